//! The gradient 𝓛_u (J per unit of the unknown) by one pass backwards through the integrals that make up 𝓛. No row of
//! derivatives is needed, so that a residual costs a fraction of a tangent.
//!
//! ```text
//! x_k(X) = L − ∫_X^L |h_k|       →  a: what |h_k| at a node is multiplied by in δ𝓛 (N)
//! Δθ_k(X) = −∫_X^L Δθ_k'         →  b: the same for Δθ_k' (N m)
//! c' = g t,  R' = R K^           →  n, μ: force (N) and moment (N m) of all loads beyond, base frame, as along a beam
//! δ𝓛 = Σ ℓ (F_v + a |h|_v)·δv + b δΔθ_k' − n·t δg − μ·(R J δΩ),   δv = modes, labels and lengths
//! ```
//!
//! F is the density of energy and gravity at a node (N) with its weight, v the local variables of `kinematics::follower`.

use super::assembly::{Assembly, Efforts, Setting, turn_at_base};
use crate::dense::{add_scaled, axpy, axpy_table, cross, inner, times};
use crate::kinematics::follower::local;
use crate::kinematics::layout::{Joint, field};
use crate::kinematics::pose::{Poses, point, tangent};
use crate::kinematics::state::{State, row, split};
use crate::real::Real;
use nalgebra::Vector3;

// Why backwards. 𝓛 depends on x_k at a node, which is an integral of |h_k| from there to the tip, and |h_k| depends on x_k again. Let
// g_i = ℓ (F_x + a_i |h|_x) be what node i contributes to ∂𝓛/∂x_k(X_i), where a_i, the factor of ℓ δ|h_i| in δ𝓛, is looked for.
// x_i = x_end − ℓ Σ_j B_ij |h_j| with the integrals B from node i to the element's end, so that
//
//   a_j = w_j T − Σ_i B_ij g_i ,     T = force at the element's start, less Σ g over the elements before it.
//
// T begins at the plate with T_k (less the torque's share where the pattern turns), loses λ at an edge, and goes on towards the
// tip: each element needs only what those before it have left of T. Within an element a_i stands on both sides, through g_i:
// (1 + ℓ D Bᵀ) g = ℓ (F_x + D w T) with D = diag |h|_x, the identity where the offset is uniform. Angles are alike, with b for a
// and without a system, since Δθ_k' depends on no angle.
//
// `local_forces` holds per node and local variable v the generalised force F_v + a |h|_v (and b for Δθ_k'; loads subtracted), over ℓ.

impl<S: Real> Assembly<S> {
    /// The adjoints of |h_k| and Δθ_k' at the nodes, from the base to the tip.
    pub(super) fn adjoints(&mut self, setting: &Setting, state: &State<S>, efforts: &Efforts<S>) {
        let layout = setting.layout;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.adjoint.resize(layout.nodes * followers, S::zero());
        self.angle_adjoint.clear();
        self.angle_adjoint.resize(layout.nodes * followers, S::zero());
        for f in 0..followers {
            let slope = turn_at_base(setting, state, f, 1);
            let mut force = efforts.tension[f] - efforts.torque[f] * slope;
            let mut torque = -efforts.torque[f];
            for (e, element) in layout.elements.iter().enumerate() {
                if let Joint::Edge { follower, unknown } = element.start
                    && follower == f + 1
                {
                    force -= efforts.edge[unknown];
                }
                let rule = &layout.rules[element.rule];
                let (n, length) = (rule.n, state.lengths[e]);
                let node = |i: usize| element.first_node + i;
                let h_face = |i: usize| state.facing[node(i) * followers + f].dh[local::FACE];
                let slope_of =
                    |s: &Self, i: usize, variable: usize| s.slopes[node(i) * rows + row(f, variable)];
                // r_i, the generalised force of x_k at node i: (1 + ℓ D Bᵀ) r = ℓ (F_x + D w force).
                self.work.clear();
                for i in 0..n {
                    let right = slope_of(self, i, local::FACE) + h_face(i) * force * rule.weights[i];
                    self.work.push(length * right);
                }
                if (0..n).any(|i| !h_face(i).vanishes()) {
                    self.matrix.clear();
                    for i in 0..n {
                        for j in 0..n {
                            let unit = if i == j { 1.0 } else { 0.0 };
                            self.matrix.push(length * h_face(i) * rule.to_end[j * n + i] + unit);
                        }
                    }
                    // Near the identity, as where the rows of x_k are found.
                    self.lu.factor_in_order(&self.matrix, n, n);
                    self.lu.solve(&mut self.work, 1);
                }
                let mut spread = S::zero();
                self.spread.clear();
                self.spread.resize(n, S::zero());
                for (i, &own) in self.work.iter().enumerate() {
                    axpy_table(&mut self.spread, own, &rule.to_end[i * n..(i + 1) * n]);
                    spread += own;
                }
                for j in 0..n {
                    self.adjoint[node(j) * followers + f] = force * rule.weights[j] - self.spread[j];
                }
                force -= spread;
                if element.modes[field::angle(f)].1 == 0 && layout.edges.is_empty() {
                    continue;
                }
                for i in 0..n {
                    let adjoint = self.adjoint[node(i) * followers + f];
                    let h_angle = state.facing[node(i) * followers + f].dh[local::TH];
                    self.work[i] = length * (slope_of(self, i, local::TH) + adjoint * h_angle);
                }
                let total = self.work.iter().fold(S::zero(), |sum, w| sum + *w);
                for j in 0..n {
                    let mut back = S::zero();
                    for (i, own) in self.work.iter().enumerate() {
                        back += *own * rule.to_end[i * n + j];
                    }
                    self.angle_adjoint[node(j) * followers + f] = torque * rule.weights[j] - back;
                }
                torque -= total;
            }
        }
    }

    /// Slopes by the local variables with what they do to the face-to-face functions, and by the elements' lengths.
    pub(super) fn collect(&mut self, setting: &Setting, state: &State<S>) {
        let layout = setting.layout;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.local_forces.clone_from(&self.slopes);
        self.by_length.clear();
        self.by_length.resize(layout.elements.len(), S::zero());
        for (e, element) in layout.elements.iter().enumerate() {
            for node in element.first_node..element.first_node + layout.rules[element.rule].n {
                let forces = &mut self.local_forces[node * rows..(node + 1) * rows];
                let mut by_length = self.values[node];
                for f in 0..followers {
                    let at = node * followers + f;
                    let (facing, adjoint) = (&state.facing[at], self.adjoint[at]);
                    let Some((leader, own)) = split(forces, f) else { continue };
                    let (before, after) = facing.dh.split_at(local::TH);
                    axpy(leader, adjoint, before);
                    axpy(own, adjoint, after);
                    by_length += adjoint * facing.h;
                    let (adjoint, rate) = (self.angle_adjoint[at], row(f, local::DTH));
                    by_length += adjoint * (state.local[node * rows + rate] - state.rest[at][1]);
                    forces[rate] += adjoint;
                }
                self.by_length[e] += by_length;
            }
        }
    }

    // With n(X) the force and μ(X) the moment of all loads beyond X, virtual work on the leader (c' = g t, R' = R K^) is
    //
    //   δW = ∫ n·t δg + (Rᵀμ)·δK dX ,     μ' = −g t × n ,
    //
    // as along any beam: n changes at loads only, μ grows by g t × n towards the base. Discretely R goes on by exp of the Magnus vector
    // Ω(α), so that everything beyond a step turns by δφ = R J δΩ (J the left Jacobian of exp), and K enters through the
    // generators α: `pull` is (∂Ω/∂α)ᵀ Jᵀ Rᵀ μ. From the tip to the base every point costs a fixed number of operations; rows of
    // the poses by the unknowns are not needed.

    /// What forces and moments at the points do to curvatures and stretch of the leader: as along a beam, from the tip to the
    /// base.
    pub(super) fn collect_loads(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>) {
        let layout = setting.layout;
        let rows = layout.rows();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        // Without forces along the robot only those at the ends of elements are left.
        let spread = setting.kinds().act_along();
        self.internal.resize(self.point_force.len(), Vector3::zeros());
        self.moment.resize(self.point_force.len(), Vector3::zeros());
        for (e, element) in layout.elements.iter().enumerate().rev() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            let mut by_length = S::zero();
            for i in (0..=n).rev() {
                let at = point(layout, e, i);
                if i == n {
                    force += self.point_force[at];
                } else {
                    let mut internal = Vector3::zeros();
                    add_scaled(&mut internal, S::splat(rule.weights[i]), &force);
                    for k in 0..if spread { n } else { 0 } {
                        let share = S::splat(rule.from_start[k * n + i]);
                        add_scaled(&mut internal, share, &self.point_force[point(layout, e, k)]);
                    }
                    self.internal[at] = internal;
                    let node = element.first_node + i;
                    let t = tangent(&poses.rotation[at]);
                    let (push, stretch) = (inner(&internal, &t), poses.stretch[node]);
                    add_scaled(&mut moment, length * stretch, &cross(&t, &internal));
                    self.by_length[e] -= push * stretch;
                    let [offset, slope, _] = state.leader_offset[node];
                    let forces = &mut self.local_forces[node * rows..(node + 1) * rows];
                    forces[local::E1] -= push;
                    forces[local::KZ] -= push * offset;
                    forces[local::X] -= push * slope * state.local[node * rows + local::KZ];
                }
                add_scaled(&mut moment, S::one(), &self.point_moment[at]);
                self.moment[at] = moment;
                let step = &poses.steps[at];
                let body = times(&poses.before(at).transpose(), &moment);
                let pull = step.magnus.pull(&times(&step.jacobian.transpose(), &body));
                for (m, (pull, alpha)) in pull.iter().zip(&step.magnus.alpha).enumerate() {
                    by_length += inner(pull, alpha);
                    for (j, share) in rule.magnus[m][i * n..(i + 1) * n].iter().enumerate() {
                        let slopes =
                            &mut self.local_forces[(element.first_node + j) * rows..][..field::CURVATURES];
                        axpy(slopes, S::splat(-share), pull.as_slice());
                    }
                }
            }
            self.by_length[e] -= by_length / length;
            for k in 0..if spread { n } else { 0 } {
                force += self.point_force[point(layout, e, k)];
            }
        }
    }

    /// From the local variables to the modes and edges.
    pub(super) fn project(&mut self, setting: &Setting, state: &State<S>) {
        let layout = setting.layout;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.gradient.clear();
        self.gradient.resize(state.unknowns, S::zero());
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let length = state.lengths[e];
            let mut add = |number: usize, row: usize| {
                let (first, count) = element.modes[number];
                if count == 0 {
                    return;
                }
                let target = &mut self.gradient[first..first + count];
                for i in 0..rule.n {
                    let force = self.local_forces[(element.first_node + i) * rows + row];
                    axpy_table(target, length * force, &rule.legendre[i * rule.n..i * rule.n + count]);
                }
            };
            for axis in 0..field::CURVATURES {
                add(axis, axis);
            }
            for f in 0..followers {
                add(field::angle(f), row(f, local::DTH));
            }
            if layout.stretch {
                add(field::stretch(followers, 0), local::E1);
                for f in 0..followers {
                    add(field::stretch(followers, f + 1), row(f, local::EK));
                }
            }
            for i in 0..if layout.edges.is_empty() { 0 } else { rule.n } {
                let node = element.first_node + i;
                let forces = &self.local_forces[node * rows..(node + 1) * rows];
                // What a moving label changes by itself.
                let [twist, _] = state.leader_twist(node);
                let mut by_label = forces[local::X] + forces[local::KX] * twist;
                for f in 0..followers {
                    let rest = &state.rest[node * followers + f];
                    // Without the share of the modes: the label changes θ_k' at rest alone.
                    let rate = forces[row(f, local::DTH)] - self.angle_adjoint[node * followers + f];
                    by_label += forces[row(f, local::TH)] * rest[1] + rate * rest[2];
                }
                for (joint, share) in [(element.start, 1.0 - rule.nodes[i]), (element.end, rule.nodes[i])] {
                    if let Joint::Edge { unknown, .. } = joint {
                        self.gradient[unknown] += length * by_label * share;
                    }
                }
            }
            for (joint, sign) in [(element.start, -1.0), (element.end, 1.0)] {
                if let Joint::Edge { unknown, .. } = joint {
                    self.gradient[unknown] += self.by_length[e] * sign;
                }
            }
        }
    }
}
