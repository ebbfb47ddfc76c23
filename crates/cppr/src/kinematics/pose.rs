//! Rotations and positions along the leader, and their derivatives.
//!
//! R' = R K^ is stepped from point to point (nodes and ends of elements) by R ← R exp(Ω^) with the
//! sixth-order Magnus vector of `magnus`; the centreline is c' = g t, g = 1 + e_1 + D_1 K_Z, t = R E_X.
//! Spatial rotations are written φ: δR = φ^ R.

use super::follower::local;
use super::layout::Layout;
use super::magnus::Magnus;
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
                self.steps.push(Step { before: rotation, magnus, jacobian });
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

    /// Derivatives of rotations and positions; needs the state's rows.
    pub fn differentiate(&mut self, layout: &Layout, state: &State) {
        let n_u = state.unknowns;
        let points = layout.nodes + layout.elements.len();
        for (buffer, rows) in [(&mut self.spin, 3), (&mut self.shift, 3), (&mut self.generator_rows, 9)] {
            buffer.resize(points * rows * n_u, 0.0);
            buffer.fill(0.0);
        }
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
            for s in 0..=n {
                let at = point(layout, e, s);
                let step = self.steps[at];
                let turn = (step.before * step.jacobian * step.magnus.slope()).transpose();
                for m in 0..3 {
                    for axis in 0..3 {
                        let slot = (at * 9 + m * 3 + axis) * n_u;
                        let row = &mut self.generator_rows[slot..slot + n_u];
                        for j in 0..n {
                            let share = length * rule.magnus[m][s * n + j];
                            axpy(row, share, state.z_row(element.first_node + j, axis));
                        }
                        axpy(row, step.magnus.alpha[m][axis] / length, length_row);
                        for (direction, factor) in turn.row(m * 3 + axis).iter().enumerate() {
                            let slot = (at * 3 + direction) * n_u;
                            axpy(&mut self.spin[slot..slot + n_u], *factor, row);
                        }
                    }
                }
                if at > 0 {
                    let (before, own) = self.spin.split_at_mut(at * 3 * n_u);
                    axpy(&mut own[..3 * n_u], 1.0, &before[(at - 1) * 3 * n_u..]);
                }
            }
            self.shift_rows(layout, state, e);
        }
    }

    fn shift_rows(&mut self, layout: &Layout, state: &State, e: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, length) = (rule.n, state.unknowns, state.lengths[e]);
        for a in 0..n_u {
            let start =
                if e == 0 { Vector3::zeros() } else { column(&self.shift, point(layout, e, 0) - 1, n_u, a) };
            let by_length = state.length_rows[e * n_u + a];
            for i in 0..=n {
                let weights = if i < n { &rule.from_start[i * n..(i + 1) * n] } else { &rule.weights[..] };
                let mut sum = Vector3::zeros();
                for j in 0..n {
                    sum += self.tangent_rate(layout, state, e, j, a, by_length / length) * weights[j];
                }
                set_column(&mut self.shift, point(layout, e, i), n_u, a, &(start + sum * length));
            }
        }
    }

    /// d(g t)/du_a at a node plus `share` times g t.
    #[inline]
    fn tangent_rate(
        &self,
        layout: &Layout,
        state: &State,
        e: usize,
        j: usize,
        a: usize,
        share: f64,
    ) -> Vector3<f64> {
        let node = layout.elements[e].first_node + j;
        let at = point(layout, e, j);
        let t: Vector3<f64> = self.rotation[at].column(0).into_owned();
        let g = self.stretch[node];
        let spin = column(&self.spin, at, state.unknowns, a);
        spin.cross(&t) * g + t * (stretch_slope(layout, state, node, a) + share * g)
    }
}

/// dg/du_a at a node.
#[inline]
pub(crate) fn stretch_slope(layout: &Layout, state: &State, node: usize, a: usize) -> f64 {
    let [offset, slope, _] = state.leader_offset[node];
    let kz = state.local[node * layout.rows() + local::KZ];
    state.z_row(node, local::E1)[a]
        + offset * state.z_row(node, local::KZ)[a]
        + slope * kz * state.z_row(node, local::X)[a]
}

/// Column `a` of a three-row block.
#[inline]
pub(crate) fn column(rows: &[f64], block: usize, n_u: usize, a: usize) -> Vector3<f64> {
    let at = block * 3 * n_u + a;
    Vector3::new(rows[at], rows[at + n_u], rows[at + 2 * n_u])
}

#[inline]
fn set_column(rows: &mut [f64], block: usize, n_u: usize, a: usize, value: &Vector3<f64>) {
    let at = block * 3 * n_u + a;
    rows[at] = value.x;
    rows[at + n_u] = value.y;
    rows[at + 2 * n_u] = value.z;
}
