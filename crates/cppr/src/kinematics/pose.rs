//! Rotations and positions along the leader, and their derivatives.
//!
//! R' = R K^ is stepped from point to point (nodes and ends of elements) by R ← R exp(Ω^) with the
//! sixth-order Magnus vector of `magnus`; the centreline is c' = g t, g = 1 + e_1 + D_1 K_Z, t = R E_X.
//! Spatial rotations are written φ: δR = φ^ R.

use super::follower::local;
use super::layout::Layout;
use super::magnus::{Magnus, Slope};
use super::so3::{self, Coefficients};
use super::state::State;
use crate::dense::{add_scaled, axpy, column, cross, dot, product, set_column};
use crate::design::Robot;
use crate::design::fields::Part;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

/// One rotation step and what its derivatives need.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Step<S: Real = f64> {
    /// Ω and what it is made of.
    pub magnus: Magnus<S>,
    /// Left Jacobian of exp at Ω, and the coefficients it is made of.
    pub jacobian: Matrix3<S>,
    pub coefficients: Coefficients<S>,
}

/// Poses at all points. A point is a node or the end of an element; `point(e, i)` numbers them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Poses<S: Real = f64> {
    pub steps: Vec<Step<S>>,
    /// R of the clamped section.
    base: Matrix3<S>,
    /// Rotation at every point.
    pub rotation: Vec<Matrix3<S>>,
    /// Centreline at every point (m).
    pub centre: Vec<Vector3<S>>,
    /// g at every node.
    pub stretch: Vec<S>,
    /// Number of unknowns that move poses: length of the rows that follow.
    pub leader_unknowns: usize,
    /// Per point three rows: φ by the unknowns.
    pub spin: Vec<S>,
    /// Per point three rows: c by the unknowns.
    pub shift: Vec<S>,
    /// Per step dΩ by the generators.
    pub slopes: Vec<Slope<S>>,
    /// Per step and edge that moves it: the generators by the edge, over ℓ.
    by_edge: Vec<[S; 9]>,
    rates: Vec<S>,
    row: Vec<S>,
    /// Serial number of the layout that the rows are made for.
    rows_of: u64,
}

/// Pose of the tip in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipPose {
    /// Rotation of the leader's last section; its first column is the tangent.
    pub rotation: Matrix3<f64>,
    /// Centre of that section (m).
    pub centre: Vector3<f64>,
}

impl TipPose {
    /// Direction of the tip.
    #[must_use]
    pub fn tangent(&self) -> Vector3<f64> {
        self.rotation.column(0).into_owned()
    }
}

impl Poses<f64> {
    /// Pose at the last point.
    pub fn tip(&self) -> TipPose {
        self.tip_of(0)
    }
}

/// Number of a point: node `i` of element `e`, or its end for `i` = n.
#[inline]
pub(crate) fn point(layout: &Layout, e: usize, i: usize) -> usize {
    layout.elements[e].first_node + e + i
}

/// How many unknowns turn the steps of an element.
#[inline]
pub(crate) fn turning(layout: &Layout, e: usize) -> usize {
    layout.edges.len() + layout.elements[e].turning.len()
}

/// The unknown that stands in column `i` of an element's step rows.
#[inline]
pub(crate) fn turning_unknown(layout: &Layout, e: usize, i: usize) -> usize {
    let edges = layout.edges.len();
    if i < edges { i } else { layout.elements[e].turning.start + i - edges }
}

/// K at a node.
#[inline]
pub(crate) fn curvature<S: Real>(state: &State<S>, layout: &Layout, node: usize) -> Vector3<S> {
    let row = node * layout.rows();
    Vector3::new(state.local[row], state.local[row + 1], state.local[row + 2])
}

/// g at a node.
#[inline]
fn centre_rate<S: Real>(state: &State<S>, layout: &Layout, node: usize) -> S {
    let row = node * layout.rows();
    state.local[row + local::E1] + state.leader_offset[node][0] * state.local[row + local::KZ] + 1.0
}

/// The tangent t = R E_X.
#[inline]
pub(crate) fn tangent<S: Real>(rotation: &Matrix3<S>) -> Vector3<S> {
    Vector3::new(rotation.m11, rotation.m21, rotation.m31)
}

/// The rotation of the leader's first section.
pub(crate) fn base_rotation(robot: &Robot) -> Matrix3<f64> {
    so3::about_x(robot.fields()[0].direction(0.0, Part::Pattern)[0])
}

/// The same numbers in every lane.
pub(crate) fn splat<S: Real>(matrix: &Matrix3<f64>) -> Matrix3<S> {
    matrix.map(S::splat)
}

impl<S: Real> Poses<S> {
    /// Pose at the last point, of one lane.
    pub fn tip_of(&self, lane: usize) -> TipPose {
        let last = self.rotation.len() - 1;
        TipPose {
            rotation: self.rotation[last].map(|r| r.lane(lane)),
            centre: self.centre[last].map(|c| c.lane(lane)),
        }
    }

    /// Rotations and positions from an evaluated state.
    pub fn evaluate(&mut self, robot: &Robot, layout: &Layout, state: &State<S>) {
        let points = layout.nodes + layout.elements.len();
        self.rotation.resize(points, Matrix3::identity());
        self.centre.resize(points, Vector3::zeros());
        self.stretch.resize(layout.nodes, S::zero());
        self.steps.resize(points, Step::default());
        self.base = splat(&base_rotation(robot));
        let mut rotation = self.base;
        let mut start = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            for s in 0..=n {
                let at = point(layout, e, s);
                let step = &mut self.steps[at];
                for (alpha, shares) in step.magnus.alpha.iter_mut().zip(&rule.magnus) {
                    let mut sum = Vector3::zeros();
                    for (j, share) in shares[s * n..(s + 1) * n].iter().enumerate() {
                        add_scaled(
                            &mut sum,
                            S::splat(*share),
                            &curvature(state, layout, element.first_node + j),
                        );
                    }
                    *alpha = Vector3::new(length * sum.x, length * sum.y, length * sum.z);
                }
                step.magnus.evaluate();
                let omega = &step.magnus.omega;
                step.coefficients = so3::coefficients(omega);
                step.jacobian = so3::left_jacobian(omega, &step.coefficients);
                rotation = product(&rotation, &so3::exponential(omega, &step.coefficients));
                self.rotation[at] = rotation;
            }
            for i in 0..=n {
                self.centre[point(layout, e, i)] = start;
            }
            for j in 0..n {
                let stretch = centre_rate(state, layout, element.first_node + j);
                self.stretch[element.first_node + j] = stretch;
                let t = tangent(&self.rotation[point(layout, e, j)]);
                let shares = rule.from_start.iter().skip(j).step_by(n).chain([&rule.weights[j]]);
                for (centre, share) in self.centre[point(layout, e, 0)..].iter_mut().zip(shares) {
                    add_scaled(centre, length * stretch * *share, &t);
                }
            }
            start = self.centre[point(layout, e, n)];
        }
    }

    /// Derivatives of rotations and positions; needs the state's rows. Those of positions are found at the ends of
    /// elements, and at the nodes too where `everywhere`.
    pub fn differentiate(&mut self, layout: &Layout, state: &State<S>, everywhere: bool) {
        let points = layout.nodes + layout.elements.len();
        if self.rows_of != layout.serial {
            self.leader_unknowns = layout.leader_unknowns;
            for rows in [&mut self.spin, &mut self.shift] {
                rows.clear();
                rows.resize(points * 3 * self.leader_unknowns, S::zero());
            }
            self.slopes.resize(points, [[S::zero(); 9]; 3]);
            self.by_edge.resize(points * layout.edges.len(), [S::zero(); 9]);
        }
        for (e, element) in layout.elements.iter().enumerate() {
            for s in 0..=layout.rules[element.rule].n {
                self.generate_by_edges(layout, state, e, s);
                self.turn(layout, state, e, s);
            }
            self.move_centres(layout, state, e, everywhere);
        }
        self.rows_of = layout.serial;
    }

    /// R before a step.
    #[inline]
    pub fn before(&self, at: usize) -> &Matrix3<S> {
        at.checked_sub(1).map_or(&self.base, |before| &self.rotation[before])
    }

    /// What a step adds to the spin of one unknown: R J Ω_u.
    #[inline]
    pub fn turned(&self, at: usize, unknown: usize) -> Vector3<S> {
        let rows = |at: usize| &self.spin[at * 3 * self.leader_unknowns..(at + 1) * 3 * self.leader_unknowns];
        let here = column(rows(at), self.leader_unknowns, unknown);
        if at == 0 {
            return here;
        }
        let before = column(rows(at - 1), self.leader_unknowns, unknown);
        Vector3::new(here.x - before.x, here.y - before.y, here.z - before.z)
    }

    /// α of one step by the edges, over ℓ.
    pub fn by_edge(&self, layout: &Layout, e: usize, s: usize) -> &[[S; 9]] {
        let edges = layout.edges.len();
        &self.by_edge[point(layout, e, s) * edges..][..edges]
    }

    fn generate_by_edges(&mut self, layout: &Layout, state: &State<S>, e: usize, s: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length, at) = (rule.n, state.lengths[e], point(layout, e, s));
        for edge in 0..layout.edges.len() {
            let moved = state.length_row(e)[edge] / (length * length);
            let alpha = &self.steps[at].magnus.alpha;
            for (k, entry) in self.by_edge[at * layout.edges.len() + edge].iter_mut().enumerate() {
                let (m, axis) = (k / 3, k % 3);
                *entry = alpha[m][axis] * moved;
                for j in 0..n {
                    *entry += state.z_row(element.first_node + j, axis)[edge] * rule.magnus[m][s * n + j];
                }
            }
        }
    }

    /// Spin of one point: that of the point before plus the step's, R J dΩ.
    fn turn(&mut self, layout: &Layout, state: &State<S>, e: usize, s: usize) {
        let (leader_unknowns, at, edges) = (self.leader_unknowns, point(layout, e, s), layout.edges.len());
        let (element, length) = (&layout.elements[e], state.lengths[e]);
        let rule = &layout.rules[element.rule];
        let step = &self.steps[at];
        let slope = step.magnus.slope();
        let turn = product(self.before(at), &step.jacobian);
        let (done, rest) = self.spin.split_at_mut(at * 3 * leader_unknowns);
        let before = done.rchunks_exact(3 * leader_unknowns).next();
        for (d, spin) in rest[..3 * leader_unknowns].chunks_exact_mut(leader_unknowns).enumerate() {
            let before = before.map(|rows| &rows[d * leader_unknowns..(d + 1) * leader_unknowns]);
            // Row d of ℓ R J dΩ by the generators.
            let [x, y, z] = [turn[(d, 0)], turn[(d, 1)], turn[(d, 2)]].map(|t| length * t);
            let by_alpha: [S; 9] = from_fn(|k| (x * slope[0][k]).plus(y, slope[1][k]).plus(z, slope[2][k]));
            let before = |u: usize| before.map_or(S::zero(), |row| row[u]);
            if turning(layout, e) < leader_unknowns {
                spin.iter_mut().enumerate().for_each(|(u, entry)| *entry = before(u));
            }
            let by_edges = &self.by_edge[at * edges..(at + 1) * edges];
            for (u, (entry, by_edge)) in spin.iter_mut().zip(by_edges).enumerate() {
                *entry = before(u) + dot(&by_alpha, by_edge);
            }
            for axis in 0..3 {
                let (first, modes) = element.modes[axis];
                let [t1, t2, t3] = rule.shares_of_modes(s, modes);
                let [a, b, c] = [by_alpha[axis], by_alpha[3 + axis], by_alpha[6 + axis]];
                for (i, entry) in spin[first..first + modes].iter_mut().enumerate() {
                    let [t1, t2, t3] = [t1[i], t2[i], t3[i]].map(S::splat);
                    *entry = before(first + i).plus(a, t1).plus(b, t2).plus(c, t3);
                }
            }
        }
        self.slopes[at] = slope;
    }

    fn move_centres(&mut self, layout: &Layout, state: &State<S>, e: usize, everywhere: bool) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, leader_unknowns, length) = (rule.n, self.leader_unknowns, state.lengths[e]);
        let block = 3 * leader_unknowns;
        let places = if everywhere { 0..=n } else { n..=n };
        for i in places.clone() {
            let at = point(layout, e, i) * block;
            if e == 0 {
                self.shift[at..at + block].fill(S::zero());
            } else {
                let start = (point(layout, e, 0) - 1) * block;
                self.shift.copy_within(start..start + block, at);
            }
        }
        self.rates.resize(block, S::zero());
        for j in 0..n {
            // d(g t)/du at the node, with the part of the element's length.
            let (node, at) = (element.first_node + j, point(layout, e, j));
            let (t, g) = (tangent(&self.rotation[at]), self.stretch[node]);
            stretch_row(layout, state, e, node, &mut self.row);
            if !layout.edges.is_empty() {
                axpy(&mut self.row, g / length, &state.length_row(e)[..leader_unknowns]);
            }
            let flow = Vector3::new(g * t.x, g * t.y, g * t.z);
            let spin = &self.spin[at * block..(at + 1) * block];
            for (u, stretched) in self.row.iter().enumerate() {
                let mut rate = cross(&column(spin, leader_unknowns, u), &flow);
                add_scaled(&mut rate, *stretched, &t);
                set_column(&mut self.rates, leader_unknowns, u, &rate);
            }
            for i in places.clone() {
                let share = if i < n { rule.from_start[i * n + j] } else { rule.weights[j] };
                let at = point(layout, e, i) * block;
                axpy(&mut self.shift[at..at + block], length * share, &self.rates);
            }
        }
    }
}

/// dg/du at a node of an element.
pub(crate) fn stretch_row<S: Real>(
    layout: &Layout,
    state: &State<S>,
    e: usize,
    node: usize,
    row: &mut Vec<S>,
) {
    let leader_unknowns = layout.leader_unknowns;
    let [offset, slope, _] = state.leader_offset[node];
    row.clear();
    row.resize(leader_unknowns, S::zero());
    for active in &layout.elements[e].active[0] {
        let factor = match active.variable {
            local::E1 => S::one(),
            local::KZ => offset,
            local::X => slope * state.local[node * layout.rows() + local::KZ],
            _ => continue,
        };
        let range = active.unknowns.clone();
        axpy(&mut row[range.clone()], factor, &state.z_row(node, active.row)[range]);
    }
}
