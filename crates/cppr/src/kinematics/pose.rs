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
use crate::dense::{add_rows, add_scaled, axpy, column, dot, product, set_column, times};
use crate::design::Robot;
use crate::design::fields::Part;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// One rotation step and what its derivatives need.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Step<S: Real = f64> {
    /// R before the step.
    pub before: Matrix3<S>,
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
    /// Rotation at every point.
    pub rotation: Vec<Matrix3<S>>,
    /// Centreline at every point (m).
    pub centre: Vec<Vector3<S>>,
    /// g at every node.
    pub stretch: Vec<S>,
    /// Number of unknowns that move poses: length of the rows that follow.
    pub posed: usize,
    /// Per point three rows: φ by the unknowns.
    pub spin: Vec<S>,
    /// Per point three rows: c by the unknowns.
    pub shift: Vec<S>,
    /// Per step three rows: Ω by the unknowns that turn it (edges, then the element's ΔK).
    omega: Vec<S>,
    /// Per step dΩ by the generators.
    pub slopes: Vec<Slope<S>>,
    /// Per step and edge that moves it: the generators by the edge, over ℓ.
    by_edge: Vec<[S; 9]>,
    rates: Vec<S>,
    row: Vec<S>,
    /// Serial number of the layout that the rows are made for.
    known: u64,
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

/// Columns of all steps before step `s` of element `e`.
fn steps_before(layout: &Layout, e: usize, s: usize) -> usize {
    let all = |e: usize| (layout.rules[layout.elements[e].rule].n + 1) * turning(layout, e);
    (0..e).map(all).sum::<usize>() + if s > 0 { s * turning(layout, e) } else { 0 }
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
    so3::about_x(robot.fields[0].direction(0.0, Part::Pattern)[0])
}

/// The same numbers in every lane.
pub(crate) fn splat<S: Real>(matrix: &Matrix3<f64>) -> Matrix3<S> {
    matrix.map(S::splat)
}

impl<S: Real> Poses<S> {
    /// Rotations and positions from an evaluated state.
    pub fn evaluate(&mut self, robot: &Robot, layout: &Layout, state: &State<S>) {
        let points = layout.nodes + layout.elements.len();
        self.rotation.resize(points, Matrix3::identity());
        self.centre.resize(points, Vector3::zeros());
        self.stretch.resize(layout.nodes, S::zero());
        self.steps.resize(points, Step::default());
        let mut rotation = splat(&base_rotation(robot));
        let mut start = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            for s in 0..=n {
                let (mut a1, mut a2, mut a3) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
                for j in 0..n {
                    let k = curvature(state, layout, element.first_node + j);
                    let share = |m: usize| length * rule.magnus[m][s * n + j];
                    add_scaled(&mut a1, share(0), &k);
                    add_scaled(&mut a2, share(1), &k);
                    add_scaled(&mut a3, share(2), &k);
                }
                let at = point(layout, e, s);
                let step = &mut self.steps[at];
                step.before = rotation;
                step.magnus = Magnus::new([a1, a2, a3]);
                let exp;
                (exp, step.jacobian, step.coefficients) = so3::exp_and_jacobian(&step.magnus.omega);
                rotation = product(&rotation, &exp);
                self.rotation[at] = rotation;
            }
            for j in 0..n {
                self.stretch[element.first_node + j] = centre_rate(state, layout, element.first_node + j);
            }
            for i in 0..=n {
                let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
                let mut centre = start;
                for (j, weight) in weights.iter().enumerate() {
                    let rate = length * self.stretch[element.first_node + j] * *weight;
                    add_scaled(&mut centre, rate, &tangent(&self.rotation[point(layout, e, j)]));
                }
                self.centre[point(layout, e, i)] = centre;
            }
            start = self.centre[point(layout, e, n)];
        }
    }

    /// Derivatives of rotations and positions; needs the state's rows. Those of positions are found at the ends of
    /// elements, and at the nodes too where `everywhere`.
    pub fn differentiate(&mut self, layout: &Layout, state: &State<S>, everywhere: bool) {
        let points = layout.nodes + layout.elements.len();
        if self.known != layout.serial {
            self.posed = layout.posed;
            for rows in [&mut self.spin, &mut self.shift] {
                rows.clear();
                rows.resize(points * 3 * self.posed, S::zero());
            }
            self.omega.resize(steps_before(layout, layout.elements.len(), 0) * 3, S::zero());
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
        self.known = layout.serial;
    }

    /// Ω of one step by the unknowns that turn it: three rows, each as long as `turning`.
    pub fn omega(&self, layout: &Layout, e: usize, s: usize) -> &[S] {
        let start = steps_before(layout, e, s) * 3;
        &self.omega[start..start + turning(layout, e) * 3]
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

    /// Spin of one point: that of the point before plus the step's.
    fn turn(&mut self, layout: &Layout, state: &State<S>, e: usize, s: usize) {
        let (posed, at, count) = (self.posed, point(layout, e, s), turning(layout, e));
        let (element, length, edges) = (&layout.elements[e], state.lengths[e], layout.edges.len());
        let rule = &layout.rules[element.rule];
        let step = &self.steps[at];
        let slope = step.magnus.slope();
        let place = steps_before(layout, e, s) * 3;
        let omega = &mut self.omega[place..place + count * 3];
        for (d, slope) in slope.iter().enumerate() {
            let row = &mut omega[d * count..(d + 1) * count];
            for (entry, by_edge) in row.iter_mut().zip(&self.by_edge[at * edges..]) {
                *entry = length * dot(slope, by_edge);
            }
            for axis in 0..3 {
                let (first, modes) = element.modes[axis];
                let [t1, t2, t3] = rule.shares_of_modes(s, modes);
                let own = edges + first - element.turning.start;
                let scaled = [length * slope[axis], length * slope[3 + axis], length * slope[6 + axis]];
                for (i, entry) in row[own..own + modes].iter_mut().enumerate() {
                    *entry =
                        (scaled[0] * t1[i]).plus(scaled[1], S::splat(t2[i])).plus(scaled[2], S::splat(t3[i]));
                }
            }
        }
        self.slopes[at] = slope;
        let turn = product(&step.before, &step.jacobian);
        if at == 0 {
            self.spin[..3 * posed].fill(S::zero());
        } else {
            self.spin.copy_within((at - 1) * 3 * posed..at * 3 * posed, at * 3 * posed);
        }
        let spin = &mut self.spin[at * 3 * posed..(at + 1) * 3 * posed];
        for i in 0..count {
            let unknown = turning_unknown(layout, e, i);
            let mut sum = times(&turn, &column(omega, count, i));
            add_scaled(&mut sum, S::one(), &column(spin, posed, unknown));
            set_column(spin, posed, unknown, &sum);
        }
    }

    fn move_centres(&mut self, layout: &Layout, state: &State<S>, e: usize, everywhere: bool) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, posed, length) = (rule.n, self.posed, state.lengths[e]);
        // d(g t)/du at the nodes, with the part of the element's length.
        self.rates.clear();
        self.rates.resize(n * 3 * posed, S::zero());
        for j in 0..n {
            let (node, at) = (element.first_node + j, point(layout, e, j));
            let (t, g) = (tangent(&self.rotation[at]), self.stretch[node]);
            stretch_row(layout, state, e, node, &mut self.row);
            if !layout.edges.is_empty() {
                axpy(&mut self.row, g / length, &state.length_row(e)[..posed]);
            }
            let spin = &self.spin[at * 3 * posed..(at + 1) * 3 * posed];
            // g φ × t + (dg/du) t, one row for each direction.
            let zero = S::zero();
            let (x, y, z) = (g * t.x, g * t.y, g * t.z);
            let across = [[zero, z, -y], [-z, zero, x], [y, -x, zero]];
            for (d, [x, y, z]) in across.into_iter().enumerate() {
                let target = &mut self.rates[(j * 3 + d) * posed..(j * 3 + d + 1) * posed];
                axpy(target, t[d], &self.row);
                add_rows(target, &Vector3::new(x, y, z), spin);
            }
        }
        for i in if everywhere { 0..=n } else { n..=n } {
            let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
            let at = point(layout, e, i) * 3 * posed;
            if e == 0 {
                self.shift[at..at + 3 * posed].fill(S::zero());
            } else {
                let start = (point(layout, e, 0) - 1) * 3 * posed;
                self.shift.copy_within(start..start + 3 * posed, at);
            }
            for (weight, rate) in weights.iter().zip(self.rates.chunks_exact(3 * posed)) {
                axpy(&mut self.shift[at..at + 3 * posed], length * *weight, rate);
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
    let posed = layout.posed;
    let [offset, slope, _] = state.leader_offset[node];
    row.clear();
    row.resize(posed, S::zero());
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
