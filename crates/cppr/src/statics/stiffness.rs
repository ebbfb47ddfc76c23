//! What the loads contribute to gradient and Hessian of the Lagrangian.
//!
//! Every load is a force and a moment about the centre at a point of the robot; its generalised force is
//! Q = Σ (c_u · f + φ_u · m) with the rows c_u and φ_u of the poses. The second derivatives of positions are
//! never formed: with n the force and μ the moment of everything beyond a section, they collapse to one
//! term per node (centreline) and one per rotation step, as in a backward recursion along a beam.

use super::assembly::{Assembly, Setting, add_outer};
use super::load::Applied;
use crate::dense::axpy;
use crate::kinematics::follower::local;
use crate::kinematics::layout::Layout;
use crate::kinematics::pose::{Poses, column, point, stretch_row};
use crate::kinematics::so3::{self, hat};
use crate::kinematics::state::State;
use nalgebra::{Matrix3, SVector, Vector3};

impl Assembly {
    /// World forces and moments at every point, all loads together.
    pub(super) fn collect_forces(
        &mut self,
        setting: &Setting,
        state: &State,
        poses: &Poses,
        concentrated: &[(usize, Applied)],
    ) {
        let Setting { layout, loads, .. } = setting;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        let points = layout.nodes + layout.elements.len();
        self.point_force.clear();
        self.point_force.resize(points, Vector3::zeros());
        self.point_moment.clear();
        self.point_moment.resize(points, Vector3::zeros());
        for (at, load) in concentrated {
            self.point_force[*at] += load.force;
            self.point_moment[*at] += load.moment + load.arm.cross(&load.force);
        }
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let (node, at) = (element.first_node + i, point(layout, e, i));
                let share = state.lengths[e] * rule.weights[i];
                if let Some(gravity) = loads.gravity {
                    let r = &poses.rotation[at];
                    let leader = &self.jets[node * layout.tubes];
                    let mut mass = leader.mass[0];
                    let mut moment = r.column(1) * (leader.offset[0] * leader.mass[0]);
                    for f in 0..followers {
                        let jets = &self.jets[node * layout.tubes + f + 1];
                        let facing = &state.facing[node * followers + f];
                        let own = jets.mass[0] * facing.h;
                        mass += own;
                        moment +=
                            (r.column(2) * facing.sin - r.column(1) * facing.cos) * (own * jets.offset[0]);
                    }
                    self.point_force[at] += gravity * (share * mass);
                    self.point_moment[at] += moment.cross(&gravity) * share;
                }
                let label = state.local[node * rows + local::X];
                for d in &loads.distributed {
                    if (d.from..=d.to).contains(&label) {
                        self.point_force[at] += d.force * share;
                    }
                }
            }
        }
    }

    pub(super) fn load_gradient(&mut self, state: &State, poses: &Poses) {
        let n_u = state.unknowns;
        for (at, (force, moment)) in self.point_force.iter().zip(&self.point_moment).enumerate() {
            for axis in 0..3 {
                let row = (at * 3 + axis) * n_u;
                if force[axis] != 0.0 {
                    axpy(&mut self.gradient, -force[axis], &poses.shift[row..row + n_u]);
                }
                if moment[axis] != 0.0 {
                    axpy(&mut self.gradient, -moment[axis], &poses.spin[row..row + n_u]);
                }
            }
        }
    }

    /// Minus the derivative of the loads' generalised force.
    pub(super) fn load_hessian(
        &mut self,
        setting: &Setting,
        state: &State,
        poses: &Poses,
        concentrated: &[(usize, Applied)],
    ) {
        let Setting { layout, .. } = setting;
        for (at, load) in concentrated {
            self.concentrated_hessian(state, poses, *at, load);
        }
        self.distributed_hessian(setting, state, poses);
        let mut force = Vector3::zeros();
        let mut moment = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate().rev() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            force += self.point_force[point(layout, e, n)];
            moment += self.point_moment[point(layout, e, n)];
            self.step_hessian(layout, state, poses, e, n, &moment);
            let mut spread = Vector3::zeros();
            for i in (0..n).rev() {
                let at = point(layout, e, i);
                let inner: Vector3<f64> = (0..n)
                    .map(|k| self.point_force[point(layout, e, k)] * rule.from_start[k * n + i])
                    .sum::<Vector3<f64>>()
                    + force * rule.weights[i];
                spread += self.point_force[at];
                self.centreline_hessian(layout, state, poses, e, i, &inner);
                let t: Vector3<f64> = poses.rotation[at].column(0).into_owned();
                moment += t.cross(&inner) * (length * poses.stretch[element.first_node + i])
                    + self.point_moment[at];
                self.step_hessian(layout, state, poses, e, i, &moment);
            }
            force += spread;
        }
    }

    /// Stiffness of a concentrated load: arm and change of the load itself.
    fn concentrated_hessian(&mut self, state: &State, poses: &Poses, at: usize, load: &Applied) {
        let n_u = state.unknowns;
        let turning = load.arm * load.force.transpose() - Matrix3::identity() * load.force.dot(&load.arm);
        // −H = φᵀ (turning + twist) φ + (c + φ × arm)ᵀ (force by point · (c + φ × arm) + force by spin · φ)
        let arm = hat(&load.arm);
        let by_move = load.force_by_point;
        let by_spin = load.force_by_spin - load.force_by_point * arm;
        let spin_by_spin = turning + load.moment_by_spin + arm * by_spin;
        let spin_by_move = arm * by_move;
        let pairs = [
            (&poses.spin, spin_by_spin, &poses.spin),
            (&poses.spin, spin_by_move, &poses.shift),
            (&poses.shift, by_spin, &poses.spin),
            (&poses.shift, by_move, &poses.shift),
        ];
        for (left, form, right) in pairs {
            for i in 0..3 {
                for j in 0..3 {
                    if form[(i, j)] != 0.0 {
                        let row = |d: usize| (at * 3 + d) * n_u..(at * 3 + d + 1) * n_u;
                        add_outer(&mut self.hessian, -form[(i, j)], &left[row(i)], &right[row(j)]);
                    }
                }
            }
        }
    }

    /// Gravity and distributed force: their arms, and how they change with the local variables.
    fn distributed_hessian(&mut self, setting: &Setting, state: &State, poses: &Poses) {
        let Setting { layout, loads, .. } = setting;
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let mut fall = std::mem::take(&mut self.stretch_row);
        let mut swing = std::mem::take(&mut self.turn_row);
        let mut whole = std::mem::take(&mut self.right);
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (length, length_row) = (state.lengths[e], &state.length_rows[e * n_u..(e + 1) * n_u]);
            for i in 0..rule.n {
                let (node, at) = (element.first_node + i, point(layout, e, i));
                let weight = rule.weights[i];
                let along = |v: &Vector3<f64>, block: &[f64], out: &mut Vec<f64>| {
                    out.clear();
                    out.resize(n_u, 0.0);
                    for axis in 0..3 {
                        let row = (at * 3 + axis) * n_u;
                        axpy(out, v[axis], &block[row..row + n_u]);
                    }
                };
                let label = state.local[node * rows + local::X];
                for d in &loads.distributed {
                    if (d.from..=d.to).contains(&label) {
                        along(&d.force, &poses.shift, &mut fall);
                        add_outer(&mut self.hessian, -weight, length_row, &fall);
                        add_outer(&mut self.hessian, -weight, &fall, length_row);
                    }
                }
                let Some(gravity) = loads.gravity else { continue };
                let r = &poses.rotation[at];
                along(&gravity, &poses.shift, &mut fall);
                for tube in 0..layout.tubes {
                    let jets = &self.jets[node * layout.tubes + tube];
                    let [m, m1, _] = jets.mass;
                    let (direction, turned, h) = if tube == 0 {
                        (r.column(1).into_owned(), Vector3::zeros(), 1.0)
                    } else {
                        let facing = &state.facing[node * followers + tube - 1];
                        (
                            r.column(2) * facing.sin - r.column(1) * facing.cos,
                            r.column(2) * facing.cos + r.column(1) * facing.sin,
                            facing.h,
                        )
                    };
                    let arm = direction * jets.offset[0];
                    // φ_aᵀ (arm γᵀ − γ·arm) φ_b of the rotating arm.
                    let turning = (arm * gravity.transpose() - Matrix3::identity() * gravity.dot(&arm))
                        * (length * weight * m * h);
                    for a in 0..n_u {
                        let left = turning.transpose() * column(&poses.spin, at, n_u, a);
                        for b in 0..n_u {
                            self.hessian[a * n_u + b] -= left.dot(&column(&poses.spin, at, n_u, b));
                        }
                    }
                    // Change of m |h| γ·(c + R o) with the pose, times its slope by each local variable.
                    along(&arm.cross(&gravity), &poses.spin, &mut swing);
                    let pair = |hessian: &mut Vec<f64>, factor: f64, row: &[f64], other: &[f64]| {
                        add_outer(hessian, -factor, row, other);
                        add_outer(hessian, -factor, other, row);
                    };
                    whole.clone_from(&fall);
                    axpy(&mut whole, 1.0, &swing);
                    pair(&mut self.hessian, weight * m * h, length_row, &whole);
                    let facing_row = if tube == 0 {
                        state.z_row(node, local::X)
                    } else {
                        state.z_row(node, State::row(tube - 1, local::FACE))
                    };
                    pair(&mut self.hessian, length * weight * m1 * h, facing_row, &whole);
                    along(&(direction * jets.offset[1]).cross(&gravity), &poses.spin, &mut swing);
                    pair(&mut self.hessian, length * weight * m * h, facing_row, &swing);
                    if tube > 0 {
                        let facing = &state.facing[node * followers + tube - 1];
                        for (variable, slope) in facing.dh.iter().enumerate() {
                            if *slope != 0.0 {
                                let row = state.z_row(node, State::row(tube - 1, variable));
                                pair(&mut self.hessian, length * weight * m * slope, row, &whole);
                            }
                        }
                        along(&(turned * jets.offset[0]).cross(&gravity), &poses.spin, &mut swing);
                        let row = state.z_row(node, State::row(tube - 1, local::TH));
                        pair(&mut self.hessian, length * weight * m * h, row, &swing);
                    }
                }
            }
        }
        (self.stretch_row, self.turn_row, self.right) = (fall, swing, whole);
    }

    /// The centreline's part at a node: −n·∂²(g t) without the part through second rotations, `inner` the
    /// force per unit length there.
    fn centreline_hessian(
        &mut self,
        layout: &Layout,
        state: &State,
        poses: &Poses,
        e: usize,
        i: usize,
        inner: &Vector3<f64>,
    ) {
        let n_u = state.unknowns;
        let (node, at) = (layout.elements[e].first_node + i, point(layout, e, i));
        let (length, g) = (state.lengths[e], poses.stretch[node]);
        let t: Vector3<f64> = poses.rotation[at].column(0).into_owned();
        let turning = (t * inner.transpose() - Matrix3::identity() * inner.dot(&t)) * (length * g);
        let push = inner.dot(&t);
        let cross = t.cross(inner);
        let spin = &poses.spin[at * 3 * n_u..(at + 1) * 3 * n_u];
        stretch_row(layout, state, node, &mut self.stretch_row);
        // Turn of t along the force by the unknowns.
        self.turn_row.clear();
        self.turn_row.resize(n_u, 0.0);
        for d in 0..3 {
            axpy(&mut self.turn_row, cross[d], &spin[d * n_u..(d + 1) * n_u]);
        }
        for a in 0..n_u {
            let row = &mut self.hessian[a * n_u..(a + 1) * n_u];
            let own = Vector3::new(spin[a], spin[n_u + a], spin[2 * n_u + a]);
            let left = turning.transpose() * own;
            for d in 0..3 {
                axpy(row, -left[d], &spin[d * n_u..(d + 1) * n_u]);
            }
            axpy(row, -length * self.stretch_row[a], &self.turn_row);
            axpy(row, -length * self.turn_row[a], &self.stretch_row);
        }
        let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
        if length_row.iter().all(|&d| d == 0.0) {
            return;
        }
        let [_, slope, bend] = state.leader_offset[node];
        let kz = state.local[node * layout.rows() + local::KZ];
        let (row_kz, row_x) = (state.z_row(node, local::KZ), state.z_row(node, local::X));
        add_outer(&mut self.hessian, -length * push * slope, row_kz, row_x);
        add_outer(&mut self.hessian, -length * push * slope, row_x, row_kz);
        add_outer(&mut self.hessian, -length * push * bend * kz, row_x, row_x);
        self.turn_row.iter_mut().for_each(|v| *v *= g);
        axpy(&mut self.turn_row, push, &self.stretch_row);
        add_outer(&mut self.hessian, -1.0, length_row, &self.turn_row);
        add_outer(&mut self.hessian, -1.0, &self.turn_row, length_row);
    }

    /// The part of one rotation step: −μ·∂_b(R J Ω_a), `moment` the moment of everything beyond it.
    fn step_hessian(
        &mut self,
        layout: &Layout,
        state: &State,
        poses: &Poses,
        e: usize,
        s: usize,
        moment: &Vector3<f64>,
    ) {
        let n_u = state.unknowns;
        let at = point(layout, e, s);
        let step = &poses.steps[at];
        let element = &layout.elements[e];
        let body = step.before.transpose() * moment;
        let turning = so3::jacobian_derivative(&step.magnus.omega, &body);
        let y = step.jacobian.transpose() * body;
        let slope = step.slope;
        let form = slope.transpose() * turning * slope + step.magnus.curvature(&y);
        let lever = (hat(moment) * step.before * step.jacobian * slope).transpose();
        let generators = &poses.generator_rows[at * 9 * n_u..(at + 1) * 9 * n_u];
        // right_i = Σ_j form_ji α_j,b − lever_i · φ_b: what meets generator i of the other unknown. With
        // μ·(φ_b × R J Ω_a) = −φ_b·(μ × R J Ω_a).
        self.right.clear();
        self.right.resize(9 * n_u, 0.0);
        for i in 0..9 {
            let row = &mut self.right[i * n_u..(i + 1) * n_u];
            for j in 0..9 {
                let (first, count) = element.modes[j % 3];
                for range in [first..first + count, layout.modes..n_u] {
                    let own = &generators[j * n_u + range.start..j * n_u + range.end];
                    axpy(&mut row[range], form[(j, i)], own);
                }
            }
            if at > 0 {
                for d in 0..3 {
                    let from = ((at - 1) * 3 + d) * n_u;
                    axpy(row, -lever[(i, d)], &poses.spin[from..from + n_u]);
                }
            }
        }
        for i in 0..9 {
            let (first, count) = element.modes[i % 3];
            for a in (first..first + count).chain(layout.modes..n_u) {
                let factor = -generators[i * n_u + a];
                axpy(&mut self.hessian[a * n_u..(a + 1) * n_u], factor, &self.right[i * n_u..(i + 1) * n_u]);
            }
        }
        self.moving_step(layout, state, poses, e, s, &(slope.transpose() * y));
    }

    /// α is linear in ℓ and in K: its mixed second derivative where the element moves, and that of K_X under a
    /// moving label. `pull` is y·dΩ/dα.
    fn moving_step(
        &mut self,
        layout: &Layout,
        state: &State,
        poses: &Poses,
        e: usize,
        s: usize,
        pull: &SVector<f64, 9>,
    ) {
        let n_u = state.unknowns;
        let at = point(layout, e, s);
        let length = state.lengths[e];
        let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
        if length_row.iter().all(|&d| d == 0.0) {
            return;
        }
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        self.turn_row.clear();
        self.turn_row.resize(n_u, 0.0);
        let mut along = 0.0;
        for i in 0..9 {
            let from = (at * 9 + i) * n_u;
            axpy(&mut self.turn_row, pull[i] / length, &poses.generator_rows[from..from + n_u]);
            along += pull[i] * poses.steps[at].magnus.alpha[i / 3][i % 3];
        }
        add_outer(&mut self.hessian, -1.0, length_row, &self.turn_row);
        add_outer(&mut self.hessian, -1.0, &self.turn_row, length_row);
        add_outer(&mut self.hessian, 2.0 * along / (length * length), length_row, length_row);
        for j in 0..rule.n {
            let node = element.first_node + j;
            let share: f64 = (0..3).map(|m| pull[3 * m] * rule.magnus[m][s * rule.n + j]).sum();
            let bend = -share * length * state.leader_twist[node][1];
            let label = state.z_row(node, local::X);
            add_outer(&mut self.hessian, bend, label, label);
        }
    }
}
