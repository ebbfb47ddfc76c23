//! Rotations and positions along the leader, and their derivatives.
//!
//! R' = R K^ is stepped from point to point (nodes and ends of elements) by R ← R exp(Ω^) with the
//! sixth-order Magnus vector of `magnus`; the centreline is c' = g t, g = 1 + e_1 + D_1 K_Z, t = R E_X.
//! Spatial rotations are written φ: δR = φ^ R.

use super::follower::local;
use super::layout::Layout;
use super::magnus::{Magnus, Slope};
use super::so3;
use super::state::State;
use crate::dense::axpy;
use crate::design::Robot;
use crate::design::fields::Part;
use nalgebra::{Matrix3, Vector3};

/// One rotation step and what its derivatives need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// R before the step.
    pub before: Matrix3<f64>,
    /// Ω and what it is made of.
    pub magnus: Magnus,
    /// Left Jacobian of exp at Ω.
    pub jacobian: Matrix3<f64>,
    /// dΩ by the generators.
    pub slope: Slope,
}

/// Poses at all points. A point is a node or the end of an element; `point(e, i)` numbers them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Poses {
    pub steps: Vec<Step>,
    /// Rotation at every point.
    pub rotation: Vec<Matrix3<f64>>,
    /// Centreline at every point (m).
    pub centre: Vec<Vector3<f64>>,
    /// g at every node.
    pub stretch: Vec<f64>,
    /// Per point three rows: φ by the unknowns.
    pub spin: Vec<f64>,
    /// Per point three rows: c by the unknowns.
    pub shift: Vec<f64>,
    /// Per step nine rows: α_1, α_2, α_3 by the unknowns.
    pub generator_rows: Vec<f64>,
    rates: Vec<f64>,
    row: Vec<f64>,
}

/// Number of a point: node `i` of element `e`, or its end for `i` = n.
#[inline]
pub(crate) fn point(layout: &Layout, e: usize, i: usize) -> usize {
    layout.elements[e].first_node + e + i
}

/// K at a node.
#[inline]
pub(crate) fn curvature(state: &State, layout: &Layout, node: usize) -> Vector3<f64> {
    let row = node * layout.rows();
    Vector3::new(state.local[row], state.local[row + 1], state.local[row + 2])
}

/// g at a node.
#[inline]
fn centre_rate(state: &State, layout: &Layout, node: usize) -> f64 {
    let row = node * layout.rows();
    1.0 + state.local[row + local::E1] + state.leader_offset[node][0] * state.local[row + local::KZ]
}

/// The rotation of the leader's first section.
pub(crate) fn base_rotation(robot: &Robot) -> Matrix3<f64> {
    so3::about_x(robot.fields[0].direction(0.0, Part::Pattern)[0])
}

impl Poses {
    /// Rotations and positions from an evaluated state.
    pub fn evaluate(&mut self, robot: &Robot, layout: &Layout, state: &State) {
        let points = layout.nodes + layout.elements.len();
        self.rotation.resize(points, Matrix3::identity());
        self.centre.resize(points, Vector3::zeros());
        self.stretch.resize(layout.nodes, 0.0);
        self.steps.clear();
        let mut rotation = base_rotation(robot);
        let mut start = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            for s in 0..=n {
                let mut alpha = [Vector3::zeros(); 3];
                for j in 0..n {
                    let k = curvature(state, layout, element.first_node + j) * length;
                    for (m, alpha) in alpha.iter_mut().enumerate() {
                        *alpha += k * rule.magnus[m][s * n + j];
                    }
                }
                let magnus = Magnus::new(alpha);
                let (exp, jacobian) = so3::exp_and_jacobian(&magnus.omega);
                let slope = magnus.slope();
                self.steps.push(Step { before: rotation, magnus, jacobian, slope });
                rotation *= exp;
                self.rotation[point(layout, e, s)] = rotation;
            }
            let tangent = |poses: &Self, j: usize| {
                poses.rotation[point(layout, e, j)].column(0) * poses.stretch[element.first_node + j]
            };
            for j in 0..n {
                self.stretch[element.first_node + j] = centre_rate(state, layout, element.first_node + j);
            }
            for i in 0..=n {
                let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
                let sum: Vector3<f64> = (0..n).map(|j| tangent(self, j) * weights[j]).sum();
                self.centre[point(layout, e, i)] = start + sum * length;
            }
            start = self.centre[point(layout, e, n)];
        }
    }

    /// Derivatives of rotations and positions; needs the state's rows. Those of positions are found at the ends of
    /// elements, and at the nodes too where `everywhere`.
    pub fn differentiate(&mut self, layout: &Layout, state: &State, everywhere: bool) {
        let n_u = state.unknowns;
        let points = layout.nodes + layout.elements.len();
        self.spin.resize(points * 3 * n_u, 0.0);
        self.shift.resize(points * 3 * n_u, 0.0);
        self.generator_rows.clear();
        self.generator_rows.resize(points * 9 * n_u, 0.0);
        for e in 0..layout.elements.len() {
            for s in 0..=layout.rules[layout.elements[e].rule].n {
                self.generators(layout, state, e, s);
                self.turn_rows(layout, state, e, s);
            }
            self.shift_rows(layout, state, e, everywhere);
        }
    }

    /// α of one step by the unknowns: by the element's own modes, and by edges that move it.
    fn generators(&mut self, layout: &Layout, state: &State, e: usize, s: usize) {
        let n_u = state.unknowns;
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length, at) = (rule.n, state.lengths[e], point(layout, e, s));
        let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
        for m in 0..3 {
            for axis in 0..3 {
                let slot = (at * 9 + m * 3 + axis) * n_u;
                let row = &mut self.generator_rows[slot..slot + n_u];
                let (first, count) = element.modes[axis];
                let own = &rule.magnus_modes[m][s * n..s * n + count];
                for (entry, share) in row[first..first + count].iter_mut().zip(own) {
                    *entry = length * share;
                }
                for edge in layout.modes..n_u {
                    let bent: f64 = (0..n)
                        .map(|j| rule.magnus[m][s * n + j] * state.z_row(element.first_node + j, axis)[edge])
                        .sum();
                    row[edge] =
                        length * bent + self.steps[at].magnus.alpha[m][axis] / length * length_row[edge];
                }
            }
        }
    }

    /// Spin of one point: that of the point before plus the step's.
    fn turn_rows(&mut self, layout: &Layout, state: &State, e: usize, s: usize) {
        let n_u = state.unknowns;
        let (element, at) = (&layout.elements[e], point(layout, e, s));
        let step = &self.steps[at];
        let turn = step.before * step.jacobian * step.slope;
        if at == 0 {
            self.spin[..3 * n_u].fill(0.0);
        } else {
            self.spin.copy_within((at - 1) * 3 * n_u..at * 3 * n_u, at * 3 * n_u);
        }
        for m in 0..3 {
            for axis in 0..3 {
                let source = (at * 9 + m * 3 + axis) * n_u;
                let (first, count) = element.modes[axis];
                for direction in 0..3 {
                    let factor = turn[(direction, m * 3 + axis)];
                    let target = (at * 3 + direction) * n_u;
                    for range in [first..first + count, layout.modes..n_u] {
                        let row = &self.generator_rows[source + range.start..source + range.end];
                        axpy(&mut self.spin[target + range.start..target + range.end], factor, row);
                    }
                }
            }
        }
    }

    fn shift_rows(&mut self, layout: &Layout, state: &State, e: usize, everywhere: bool) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, length) = (rule.n, state.unknowns, state.lengths[e]);
        let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
        // d(g t)/du at the nodes, with the part of the element's length.
        self.rates.clear();
        self.rates.resize(n * 3 * n_u, 0.0);
        for j in 0..n {
            let (node, at) = (element.first_node + j, point(layout, e, j));
            let t: Vector3<f64> = self.rotation[at].column(0).into_owned();
            let g = self.stretch[node];
            stretch_row(layout, state, node, &mut self.row);
            axpy(&mut self.row, g / length, length_row);
            for d in 0..3 {
                let target = &mut self.rates[(j * 3 + d) * n_u..(j * 3 + d + 1) * n_u];
                axpy(target, t[d], &self.row);
                // (φ × t)_d
                let (p, q) = ((d + 1) % 3, (d + 2) % 3);
                axpy(target, g * t[q], &self.spin[(at * 3 + p) * n_u..(at * 3 + p + 1) * n_u]);
                axpy(target, -g * t[p], &self.spin[(at * 3 + q) * n_u..(at * 3 + q + 1) * n_u]);
            }
        }
        for i in if everywhere { 0..=n } else { n..=n } {
            let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
            let at = point(layout, e, i) * 3 * n_u;
            if e == 0 {
                self.shift[at..at + 3 * n_u].fill(0.0);
            } else {
                let start = (point(layout, e, 0) - 1) * 3 * n_u;
                self.shift.copy_within(start..start + 3 * n_u, at);
            }
            for (weight, rate) in weights.iter().zip(self.rates.chunks_exact(3 * n_u)) {
                axpy(&mut self.shift[at..at + 3 * n_u], length * weight, rate);
            }
        }
    }
}

/// dg/du at a node.
pub(crate) fn stretch_row(layout: &Layout, state: &State, node: usize, row: &mut Vec<f64>) {
    let [offset, slope, _] = state.leader_offset[node];
    let kz = state.local[node * layout.rows() + local::KZ];
    row.clear();
    row.extend_from_slice(state.z_row(node, local::E1));
    axpy(row, offset, state.z_row(node, local::KZ));
    axpy(row, slope * kz, state.z_row(node, local::X));
}

/// Column `a` of a three-row block.
#[inline]
pub(crate) fn column(rows: &[f64], block: usize, n_u: usize, a: usize) -> Vector3<f64> {
    let at = block * 3 * n_u + a;
    Vector3::new(rows[at], rows[at + n_u], rows[at + 2 * n_u])
}
