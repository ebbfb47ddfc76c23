//! The Hessian 𝓛_uu of energies and conditions (J per unit of both unknowns):
//!
//! ```text
//! 𝓛_uu = Σ ℓ Zᵀ (F + a |h|)_vv Z + (terms of moving elements),   Z = dv/du
//! ```
//!
//! over the nodes, F the density of energy and gravity (N) with the node's weight, v the local variables of `kinematics::follower`
//! and a the adjoint of |h| from `gradient`. What loads add through poses stands in `stiffness`.

use super::assembly::{Assembly, Efforts, Setting, add_outer, turn_at_base};
use super::{energy, weight};
use crate::dense::{axpy, axpy_table};
use crate::kinematics::follower::local;
use crate::kinematics::layout::{Layout, field};
use crate::kinematics::pose::{Poses, point};
use crate::kinematics::state::{State, row};
use crate::real::Real;

/// Second derivatives by the local variables of one follower, each pair in one of its two places.
type Form<S> = [[S; local::COUNT]; local::COUNT];

impl<S: Real> Assembly<S> {
    /// Collects half of every second derivative of the energies and conditions, then adds the other half.
    pub(super) fn second_derivatives(
        &mut self,
        setting: &Setting,
        state: &State<S>,
        poses: &Poses<S>,
        efforts: &Efforts<S>,
    ) {
        let layout = setting.layout;
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let gravity = setting.gravity();
        let moving = !layout.edges.is_empty();
        let mut form: Form<S> = [[S::zero(); local::COUNT]; local::COUNT];
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let (node, weight, at) = (element.first_node + i, rule.weights[i], point(layout, e, i));
                let jets = &self.jets[node * layout.tubes..(node + 1) * layout.tubes];
                let own = &state.local[node * rows..(node + 1) * rows];
                energy::leader_second(&jets[0], own, moving, &mut |a, b, value| form[a][b] += value * weight);
                if let Some(gravity) = &gravity {
                    let body = poses.rotation[at].transpose() * gravity;
                    let [[m, m1, m2], [d, d1, d2]] = weight::weighing(&jets[0]);
                    let arm = gravity.dot(&poses.centre[at]) + d * body.y;
                    let bend = m2 * arm + m1 * d1 * body.y * 2.0 + m * d2 * body.y;
                    form[local::X][local::X] -= bend * weight;
                }
                for f in 0..followers {
                    let jets = &self.jets[node * layout.tubes + f + 1];
                    let v = state.variables(node, f);
                    let facing = &state.facing[node * followers + f];
                    let energy = &self.energies[node * followers + f];
                    let mut add = |a: usize, b: usize, value: S| form[a][b] += value;
                    let variables = &element.variables;
                    let by_h =
                        energy::second(facing, energy, v[local::EK], jets, weight, variables, &mut add);
                    let mut along_h = by_h * weight + self.adjoint[node * followers + f];
                    if let Some(gravity) = &gravity {
                        let (rotation, centre) = (&poses.rotation[at], &poses.centre[at]);
                        along_h += weight::second(facing, jets, weight, gravity, rotation, centre, &mut add);
                    }
                    facing.second(&v, &state.leader_offset[node], &jets.offset, along_h, &mut add);
                    self.congruence(&mut form, layout, state, e, node, f);
                }
                if followers == 0 {
                    self.congruence(&mut form, layout, state, e, node, 0);
                }
                if moving {
                    self.moving_terms(layout, state, e, i);
                }
            }
        }
        for f in 0..followers {
            let bend = turn_at_base(setting, state, f, 2);
            if !bend.vanishes() {
                let row = state.joint_row(0, f, 0);
                add_outer(&mut self.hessian, n_u, efforts.torque[f] * bend * 0.5, row, row);
            }
        }
        for i in 0..n_u {
            for j in 0..=i {
                let sum = self.hessian[i * n_u + j] + self.hessian[j * n_u + i];
                self.hessian[j * n_u + i] = sum;
                if !self.symmetric {
                    self.hessian[i * n_u + j] = sum;
                }
            }
        }
    }

    /// Half of ℓ Zᵀ (form + formᵀ) Z at one node, the diagonal of the form counted once: rows of Z with those after them,
    /// and half of the diagonal. What it reads of the form it clears.
    fn congruence(
        &mut self,
        form: &mut Form<S>,
        layout: &Layout,
        state: &State<S>,
        e: usize,
        node: usize,
        follower: usize,
    ) {
        let n_u = state.unknowns;
        let (active, length) = (&layout.elements[e].active[follower], state.lengths[e]);
        self.matrix.resize(n_u.max(self.matrix.len()), S::zero());
        let work = &mut self.matrix[..n_u];
        for (n, a) in active.iter().enumerate() {
            let (mut low, mut high) = (n_u, 0);
            for (m, b) in active[n..].iter().enumerate() {
                let first = std::mem::take(&mut form[a.variable][b.variable]);
                let second = std::mem::take(&mut form[b.variable][a.variable]);
                let factor = if m == 0 { first * 0.5 } else { first + second };
                if factor.vanishes() {
                    continue;
                }
                let factor = length * factor;
                let range = b.unknowns.clone();
                if high == 0 {
                    (low, high) = (range.start, range.end);
                    work[low..high].fill(S::zero());
                }
                // The columns so far are low..high; those between them and the new ones are still unset.
                if range.start < low {
                    work[range.start..low].fill(S::zero());
                    low = range.start;
                }
                if range.end > high {
                    work[high..range.end].fill(S::zero());
                    high = range.end;
                }
                axpy(&mut work[range.clone()], factor, &state.z_row(node, b.row)[range]);
            }
            if high == 0 {
                continue;
            }
            let z = state.z_row(node, a.row);
            for i in a.unknowns.clone() {
                axpy(&mut self.hessian[i * n_u + low..i * n_u + high], z[i], &work[low..high]);
            }
        }
    }

    /// Half of the second derivatives that come from the element's length and from rest fields under a moving label.
    fn moving_terms(&mut self, layout: &Layout, state: &State<S>, e: usize, i: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let (node, length) = (element.first_node + i, state.lengths[e]);
        // F_v + a |h|_v.
        self.work.clear();
        self.work.extend_from_slice(&self.slopes[node * rows..(node + 1) * rows]);
        for f in 0..followers {
            let adjoint = self.adjoint[node * followers + f];
            for (a, dh) in state.facing[node * followers + f].dh.iter().enumerate() {
                self.work[row(f, a)] += adjoint * *dh;
            }
        }
        let mut along = std::mem::take(&mut self.turn_row);
        along.clear();
        along.resize(n_u, S::zero());
        for row in 0..rows {
            axpy(&mut along, self.work[row], state.z_row(node, row));
        }
        for f in 0..followers {
            let (first, count) = element.modes[field::angle(f)];
            let adjoint = self.angle_adjoint[node * followers + f];
            let p = &rule.legendre[i * rule.n..i * rule.n + count];
            axpy_table(&mut along[first..first + count], adjoint, p);
        }
        add_outer(&mut self.hessian, n_u, S::one(), state.length_row(e), &along);
        self.turn_row = along;
        let mut bend = self.work[local::KX] * state.leader_twist(node)[1];
        for f in 0..followers {
            let rest = state.rest[node * followers + f];
            bend += self.work[row(f, local::TH)] * rest[2] + self.work[row(f, local::DTH)] * rest[3];
        }
        if !bend.vanishes() {
            let label = state.z_row(node, local::X);
            add_outer(&mut self.hessian, n_u, length * bend * 0.5, label, label);
        }
    }
}
