//! Rotations and positions along the leader, and their derivatives.
//!
//! R' = R K^ is stepped from point to point (nodes and ends of elements) by R ← R exp(Ω^) with the
//! sixth-order Magnus vector of `magnus`; the centreline is c' = g t, g = 1 + e_1 + D_1 K_Z, t = R E_X.
//! Spatial rotations are written φ: δR = φ^ R.

use super::follower::local;
use super::layout::Layout;
use super::magnus::{Magnus, PARTS};
use super::so3;
use super::state::State;
use crate::dense::{add_rows, axpy, column, product, set_column, times};
use crate::design::Robot;
use crate::design::fields::Part;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// One rotation step and what its derivatives need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step<S: Real = f64> {
    /// R before the step.
    pub before: Matrix3<S>,
    /// Ω and what it is made of.
    pub magnus: Magnus<S>,
    /// Left Jacobian of exp at Ω.
    pub jacobian: Matrix3<S>,
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
    /// Per step nine rows: α_1, α_2, α_3 by the unknowns that turn it (edges, then the element's ΔK).
    generators: Vec<S>,
    /// Per step the rows of [`Magnus::changes`] by the same unknowns.
    parts: Vec<S>,
    rates: Vec<S>,
    row: Vec<S>,
    /// Serial number of the layout whose generators are known.
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
        self.steps.clear();
        let mut rotation = splat(&base_rotation(robot));
        let mut start = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            for s in 0..=n {
                let mut alpha = [Vector3::zeros(); 3];
                for j in 0..n {
                    let k = curvature(state, layout, element.first_node + j);
                    for (m, alpha) in alpha.iter_mut().enumerate() {
                        *alpha += k * S::splat(rule.magnus[m][s * n + j]);
                    }
                }
                let magnus = Magnus::new(alpha.map(|a| a * length));
                let (exp, jacobian) = so3::exp_and_jacobian(&magnus.omega);
                self.steps.push(Step { before: rotation, magnus, jacobian });
                rotation = product(&rotation, &exp);
                self.rotation[point(layout, e, s)] = rotation;
            }
            for j in 0..n {
                self.stretch[element.first_node + j] = centre_rate(state, layout, element.first_node + j);
            }
            for i in 0..=n {
                let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
                let mut sum = Vector3::zeros();
                for (j, weight) in weights.iter().enumerate() {
                    let g = self.stretch[element.first_node + j];
                    sum += self.rotation[point(layout, e, j)].column(0) * (g * *weight);
                }
                self.centre[point(layout, e, i)] = start + sum * length;
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
            self.generators.clear();
            self.generators.resize(steps_before(layout, layout.elements.len(), 0) * 9, S::zero());
            self.parts.resize(steps_before(layout, layout.elements.len(), 0) * 3 * PARTS, S::zero());
        }
        for (e, element) in layout.elements.iter().enumerate() {
            for s in 0..=layout.rules[element.rule].n {
                if self.known != layout.serial || !layout.edges.is_empty() {
                    self.generate(layout, state, e, s);
                }
                self.turn(layout, e, s);
            }
            self.move_centres(layout, state, e, everywhere);
        }
        self.known = layout.serial;
    }

    /// α_1, α_2 and α_3 of one step by the unknowns that turn it: nine rows, each as long as `turning`.
    pub fn generators(&self, layout: &Layout, e: usize, s: usize) -> &[S] {
        let start = steps_before(layout, e, s) * 9;
        &self.generators[start..start + turning(layout, e) * 9]
    }

    /// The rows of [`Magnus::changes`] of one step, each as long as `turning`.
    pub fn parts(&self, layout: &Layout, e: usize, s: usize) -> &[S] {
        let start = steps_before(layout, e, s) * 3 * PARTS;
        &self.parts[start..start + turning(layout, e) * 3 * PARTS]
    }

    /// α of one step by the unknowns: by the element's own modes, and by edges that move it.
    fn generate(&mut self, layout: &Layout, state: &State<S>, e: usize, s: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length, count, edges) = (rule.n, state.lengths[e], turning(layout, e), layout.edges.len());
        let start = steps_before(layout, e, s) * 9;
        for m in 0..3 {
            for axis in 0..3 {
                let row = &mut self.generators[start + (m * 3 + axis) * count..][..count];
                let (first, modes) = element.modes[axis];
                let own = edges + first - element.turning.start;
                for (entry, share) in row[own..own + modes].iter_mut().zip(&rule.magnus_modes[m][s * n..]) {
                    *entry = length * *share;
                }
                for (edge, entry) in row[..edges].iter_mut().enumerate() {
                    let mut bent = S::zero();
                    for j in 0..n {
                        bent += state.z_row(element.first_node + j, axis)[edge] * rule.magnus[m][s * n + j];
                    }
                    let alpha = self.steps[point(layout, e, s)].magnus.alpha[m][axis];
                    *entry = length * bent + alpha / length * state.length_row(e)[edge];
                }
            }
        }
    }

    /// Spin of one point: that of the point before plus the step's.
    fn turn(&mut self, layout: &Layout, e: usize, s: usize) {
        let (posed, at, count) = (self.posed, point(layout, e, s), turning(layout, e));
        let place = steps_before(layout, e, s);
        let step = &self.steps[at];
        let parts = &mut self.parts[place * 3 * PARTS..(place + count) * 3 * PARTS];
        step.magnus.changes(&self.generators[place * 9..(place + count) * 9], parts, count);
        let omega = &parts[3 * (PARTS - 1) * count..];
        let turn = product(&step.before, &step.jacobian);
        if at == 0 {
            self.spin[..3 * posed].fill(S::zero());
        } else {
            self.spin.copy_within((at - 1) * 3 * posed..at * 3 * posed, at * 3 * posed);
        }
        let spin = &mut self.spin[at * 3 * posed..(at + 1) * 3 * posed];
        for i in 0..count {
            let own = times(&turn, &column(omega, count, i));
            let unknown = turning_unknown(layout, e, i);
            let sum = column(spin, posed, unknown) + own;
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
            let t: Vector3<S> = self.rotation[at].column(0).into_owned();
            let g = self.stretch[node];
            stretch_row(layout, state, e, node, &mut self.row);
            if !layout.edges.is_empty() {
                axpy(&mut self.row, g / length, &state.length_row(e)[..posed]);
            }
            let spin = &self.spin[at * 3 * posed..(at + 1) * 3 * posed];
            // g φ × t + (dg/du) t, one row for each direction.
            let across = so3::hat(&t) * -g;
            for d in 0..3 {
                let target = &mut self.rates[(j * 3 + d) * posed..(j * 3 + d + 1) * posed];
                axpy(target, t[d], &self.row);
                add_rows(target, &across.row(d).transpose(), spin);
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
    for active in &layout.elements[e].active {
        let factor = match active.row {
            local::E1 => S::one(),
            local::KZ => offset,
            local::X => slope * state.local[node * layout.rows() + local::KZ],
            _ => continue,
        };
        let range = active.unknowns.clone();
        axpy(&mut row[range.clone()], factor, &state.z_row(node, active.row)[range]);
    }
}
