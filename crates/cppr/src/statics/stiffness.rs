//! What the loads contribute to gradient and Hessian of the Lagrangian.
//!
//! Every load is a force and a moment about the centre at a point of the robot; its generalised force is
//! Q = Σ (c_u · f + φ_u · m) with the rows c_u and φ_u of the poses. The second derivatives of positions are
//! never formed: with n the force and μ the moment of everything beyond a section, they collapse to one
//! term per node (centreline) and one per rotation step, as in a backward recursion along a beam.

use super::assembly::{Assembly, Setting, add_outer};
use super::load::Applied;
use crate::dense::{add_rows, add_three, axpy, column, cross, product, times};
use crate::kinematics::follower::local;
use crate::kinematics::layout::Layout;
use crate::kinematics::magnus::PARTS;
use crate::kinematics::pose::{Poses, point, stretch_row, turning, turning_unknown};
use crate::kinematics::so3::{self, hat};
use crate::kinematics::state::{State, row};
use crate::real::Real;
use nalgebra::{Matrix3, SVector, Vector3};

impl<S: Real> Assembly<S> {
    /// World forces and moments at every point, all loads together.
    pub(super) fn collect_forces(
        &mut self,
        setting: &Setting,
        state: &State<S>,
        poses: &Poses<S>,
        concentrated: &[(usize, Applied<S>)],
    ) {
        let layout = setting.layout;
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
        let gravity = setting.gravity::<S>();
        if gravity.is_none() && setting.kinds().distributed.is_empty() {
            return;
        }
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let (node, at) = (element.first_node + i, point(layout, e, i));
                let share = state.lengths[e] * rule.weights[i];
                if let Some(gravity) = &gravity {
                    let r = &poses.rotation[at];
                    let leader = &self.jets[node * layout.tubes];
                    let mut mass = leader.mass[0];
                    let mut moment = r.column(1) * (leader.offset[0] * leader.mass[0]);
                    for f in 0..followers {
                        let jets = &self.jets[node * layout.tubes + f + 1];
                        let facing = &state.facing[node * followers + f];
                        let own = jets.mass[0] * facing.h;
                        mass += own;
                        let direction = r.column(2) * facing.sin - r.column(1) * facing.cos;
                        moment += direction * (own * jets.offset[0]);
                    }
                    self.point_force[at] += gravity * (share * mass);
                    self.point_moment[at] += moment.cross(gravity) * share;
                }
                for force in setting.distributed(state.local[node * rows + local::X]) {
                    self.point_force[at] += force * share;
                }
            }
        }
    }

    pub(super) fn load_gradient(&mut self, poses: &Poses<S>) {
        let posed = poses.posed;
        let gradient = &mut self.gradient[..posed];
        for (at, (force, moment)) in self.point_force.iter().zip(&self.point_moment).enumerate() {
            let rows = at * 3 * posed..(at + 1) * 3 * posed;
            if force.iter().any(|f| !f.vanishes()) {
                add_rows(gradient, &-force, &poses.shift[rows.clone()]);
            }
            if moment.iter().any(|m| !m.vanishes()) {
                add_rows(gradient, &-moment, &poses.spin[rows]);
            }
        }
    }

    /// Minus the derivative of the loads' generalised force.
    pub(super) fn load_hessian(
        &mut self,
        setting: &Setting,
        state: &State<S>,
        poses: &Poses<S>,
        concentrated: &[(usize, Applied<S>)],
    ) {
        let Setting { layout, .. } = setting;
        for (at, load) in concentrated {
            self.concentrated_hessian(poses, *at, load);
        }
        self.distributed_hessian(setting, state, poses);
        let mut force = Vector3::zeros();
        let mut moment = Vector3::zeros();
        for (e, element) in layout.elements.iter().enumerate().rev() {
            let rule = &layout.rules[element.rule];
            let (n, length) = (rule.n, state.lengths[e]);
            force += self.point_force[point(layout, e, n)];
            moment += self.point_moment[point(layout, e, n)];
            let count = turning(layout, e);
            for block in [&mut self.block, &mut self.half] {
                block.clear();
                block.resize(count * count, S::zero());
            }
            self.step_hessian(layout, state, poses, e, n, &moment);
            let mut spread = Vector3::zeros();
            for i in (0..n).rev() {
                let at = point(layout, e, i);
                let mut inner = force * S::splat(rule.weights[i]);
                for k in 0..n {
                    inner += self.point_force[point(layout, e, k)] * S::splat(rule.from_start[k * n + i]);
                }
                spread += self.point_force[at];
                self.centreline_hessian(layout, state, poses, e, i, &inner);
                let t: Vector3<S> = poses.rotation[at].column(0).into_owned();
                moment += t.cross(&inner) * (length * poses.stretch[element.first_node + i])
                    + self.point_moment[at];
                self.step_hessian(layout, state, poses, e, i, &moment);
            }
            force += spread;
            self.add_blocks(layout, e, state.unknowns);
        }
    }

    /// Stiffness of a concentrated load: arm and change of the load itself.
    fn concentrated_hessian(&mut self, poses: &Poses<S>, at: usize, load: &Applied<S>) {
        let (n_u, posed) = (self.gradient.len(), poses.posed);
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
        let rows = at * 3 * posed..(at + 1) * 3 * posed;
        for (left, form, right) in pairs {
            if form.iter().all(|f| f.vanishes()) {
                continue;
            }
            for i in 0..posed {
                let factor = -times(&form.transpose(), &column(&left[rows.clone()], posed, i));
                add_rows(&mut self.hessian[i * n_u..i * n_u + posed], &factor, &right[rows.clone()]);
            }
        }
    }

    /// Gravity and distributed force: their arms, and how they change with the local variables.
    fn distributed_hessian(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>) {
        let layout = setting.layout;
        let gravity = setting.gravity::<S>();
        let moving = !layout.edges.is_empty();
        if gravity.is_none() && (setting.kinds().distributed.is_empty() || !moving) {
            return;
        }
        let (rows, followers, n_u, posed) = (layout.rows(), layout.tubes - 1, state.unknowns, poses.posed);
        let mut fall = std::mem::take(&mut self.stretch_row);
        let mut swing = std::mem::take(&mut self.turn_row);
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (length, length_row) = (state.lengths[e], state.length_row(e));
            for i in 0..rule.n {
                let (node, at) = (element.first_node + i, point(layout, e, i));
                let block = at * 3 * posed..(at + 1) * 3 * posed;
                let along = |v: &Vector3<S>, rows: &[S], out: &mut Vec<S>| {
                    out.clear();
                    out.resize(posed, S::zero());
                    add_rows(out, v, &rows[block.clone()]);
                };
                let pair = |hessian: &mut Vec<S>, factor: S, row: &[S], other: &[S]| {
                    add_outer(hessian, n_u, -factor, row, other);
                    add_outer(hessian, n_u, -factor, other, row);
                };
                let weight = S::splat(rule.weights[i]);
                if moving {
                    for force in setting.distributed(state.local[node * rows + local::X]) {
                        along(&force, &poses.shift, &mut fall);
                        pair(&mut self.hessian, weight, length_row, &fall);
                    }
                }
                let Some(gravity) = &gravity else { continue };
                let r = &poses.rotation[at];
                for tube in 0..layout.tubes {
                    let jets = &self.jets[node * layout.tubes + tube];
                    let [m, m1, _] = jets.mass;
                    let (direction, turned, h) = if tube == 0 {
                        (r.column(1).into_owned(), Vector3::zeros(), S::one())
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
                    let spin = &poses.spin[block.clone()];
                    for a in 0..posed {
                        let left = -(turning.transpose() * column(spin, posed, a));
                        add_rows(&mut self.hessian[a * n_u..a * n_u + posed], &left, spin);
                    }
                    // Change of m |h| γ·(c + R o) with the pose, times its slope by each local variable.
                    along(gravity, &poses.shift, &mut fall);
                    add_rows(&mut fall, &arm.cross(gravity), spin);
                    if moving {
                        pair(&mut self.hessian, weight * m * h, length_row, &fall);
                    }
                    let facing_row = if tube == 0 { local::X } else { row(tube - 1, local::FACE) };
                    let facing_row = state.z_row(node, facing_row);
                    if !m1.vanishes() {
                        pair(&mut self.hessian, length * weight * m1 * h, facing_row, &fall);
                    }
                    if !jets.offset[1].vanishes() {
                        along(&(direction * jets.offset[1]).cross(gravity), &poses.spin, &mut swing);
                        pair(&mut self.hessian, length * weight * m * h, facing_row, &swing);
                    }
                    if tube > 0 {
                        let facing = &state.facing[node * followers + tube - 1];
                        for (variable, slope) in facing.dh.iter().enumerate() {
                            if !slope.vanishes() {
                                let own = state.z_row(node, row(tube - 1, variable));
                                pair(&mut self.hessian, length * weight * m * *slope, own, &fall);
                            }
                        }
                        along(&(turned * jets.offset[0]).cross(gravity), &poses.spin, &mut swing);
                        let own = state.z_row(node, row(tube - 1, local::TH));
                        pair(&mut self.hessian, length * weight * m * h, own, &swing);
                    }
                }
            }
        }
        (self.stretch_row, self.turn_row) = (fall, swing);
    }

    /// The centreline's part at a node: −n·∂²(g t) without the part through second rotations, `inner` the
    /// force per unit length there.
    fn centreline_hessian(
        &mut self,
        layout: &Layout,
        state: &State<S>,
        poses: &Poses<S>,
        e: usize,
        i: usize,
        inner: &Vector3<S>,
    ) {
        let (n_u, posed) = (state.unknowns, poses.posed);
        let (node, at) = (layout.elements[e].first_node + i, point(layout, e, i));
        let (length, g) = (state.lengths[e], poses.stretch[node]);
        let t: Vector3<S> = poses.rotation[at].column(0).into_owned();
        let turning = (inner * t.transpose() - Matrix3::identity() * inner.dot(&t)) * (-length * g);
        let push = inner.dot(&t);
        let spin = &poses.spin[at * 3 * posed..(at + 1) * 3 * posed];
        stretch_row(layout, state, e, node, &mut self.stretch_row);
        // Turn of t along the force by the unknowns.
        self.turn_row.clear();
        self.turn_row.resize(posed, S::zero());
        add_rows(&mut self.turn_row, &t.cross(inner), spin);
        for a in 0..posed {
            let row = &mut self.hessian[a * n_u..a * n_u + posed];
            add_rows(row, &times(&turning, &column(spin, posed, a)), spin);
            axpy(row, -length * self.turn_row[a], &self.stretch_row);
            let stretch = self.stretch_row[a];
            if !stretch.vanishes() {
                axpy(row, -length * stretch, &self.turn_row);
            }
        }
        if layout.edges.is_empty() {
            return;
        }
        let [_, slope, bend] = state.leader_offset[node];
        let kz = state.local[node * layout.rows() + local::KZ];
        let (row_kz, row_x) = (state.z_row(node, local::KZ), state.z_row(node, local::X));
        let hessian = &mut self.hessian;
        add_outer(hessian, n_u, -length * push * slope, row_kz, row_x);
        add_outer(hessian, n_u, -length * push * slope, row_x, row_kz);
        add_outer(hessian, n_u, -length * push * bend * kz, row_x, row_x);
        self.turn_row.iter_mut().for_each(|v| *v *= g);
        axpy(&mut self.turn_row, push, &self.stretch_row);
        add_outer(hessian, n_u, -S::one(), state.length_row(e), &self.turn_row);
        add_outer(hessian, n_u, -S::one(), &self.turn_row, state.length_row(e));
    }

    /// The part of one rotation step: −μ·∂_b(R J Ω_a), `moment` the moment of everything beyond it. Unknowns that
    /// turn the step are collected in `block` and `half`; the spin of all before it meets them here.
    fn step_hessian(
        &mut self,
        layout: &Layout,
        state: &State<S>,
        poses: &Poses<S>,
        e: usize,
        s: usize,
        moment: &Vector3<S>,
    ) {
        let (n_u, posed, count) = (state.unknowns, poses.posed, turning(layout, e));
        let at = point(layout, e, s);
        let step = &poses.steps[at];
        let body = times(&step.before.transpose(), moment);
        let bend = so3::jacobian_derivative(&step.magnus.omega, &body);
        let y = times(&step.jacobian.transpose(), &body);
        let second = step.magnus.second(&y);
        let lever = product(&hat(moment), &product(&step.before, &step.jacobian));
        let parts = poses.parts(layout, e, s);
        let (a1, a2) = poses.generators(layout, e, s).split_at(3 * count);
        let rows = |part: usize| &parts[3 * part * count..3 * (part + 1) * count];
        let [w, p, q, omega] = [0, 1, 2, PARTS - 1].map(rows);
        for a in 0..count {
            let turned = column(omega, count, a);
            // −Ω_b·(B Ω_a)
            add_rows(&mut self.block[a * count..(a + 1) * count], &-times(&bend, &turned), omega);
            let half = &mut self.half[a * count..(a + 1) * count];
            let first = column(a1, count, a);
            let factors =
                [cross(&second.p, &column(p, count, a)), cross(&second.a2, &first), cross(&second.w, &first)];
            add_three(half, &factors, [q, a2, w]);
            if at > 0 {
                // −μ·(φ_b × R J Ω_a) = (μ × R J Ω_a)·φ_b
                let unknown = turning_unknown(layout, e, a);
                let before = &poses.spin[(at - 1) * 3 * posed..at * 3 * posed];
                let row = &mut self.hessian[unknown * n_u..unknown * n_u + posed];
                add_rows(row, &times(&lever, &turned), before);
            }
        }
        if !layout.edges.is_empty() {
            self.moving_step(layout, state, poses, e, s, &y);
        }
    }

    /// Puts what the steps of one element have collected into the Hessian.
    fn add_blocks(&mut self, layout: &Layout, e: usize, n_u: usize) {
        let count = turning(layout, e);
        for a in 0..count {
            let row = turning_unknown(layout, e, a) * n_u;
            for b in 0..count {
                let half = self.half[a * count + b] + self.half[b * count + a];
                self.hessian[row + turning_unknown(layout, e, b)] += self.block[a * count + b] - half;
            }
        }
    }

    /// α is linear in ℓ and in K: its mixed second derivative where the element moves, and that of K_X under a
    /// moving label. `y` is what a change of Ω is multiplied by.
    fn moving_step(
        &mut self,
        layout: &Layout,
        state: &State<S>,
        poses: &Poses<S>,
        e: usize,
        s: usize,
        y: &Vector3<S>,
    ) {
        let (n_u, count) = (state.unknowns, turning(layout, e));
        let at = point(layout, e, s);
        let length = state.lengths[e];
        let length_row = state.length_row(e);
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let magnus = &poses.steps[at].magnus;
        let pull: SVector<S, 9> = magnus.slope().transpose() * y;
        let omega = &poses.parts(layout, e, s)[3 * (PARTS - 1) * count..];
        self.turn_row.clear();
        self.turn_row.resize(poses.posed, S::zero());
        for i in 0..count {
            self.turn_row[turning_unknown(layout, e, i)] = y.dot(&column(omega, count, i)) / length;
        }
        let mut along = S::zero();
        for i in 0..9 {
            along += pull[i] * magnus.alpha[i / 3][i % 3];
        }
        let hessian = &mut self.hessian;
        add_outer(hessian, n_u, -S::one(), length_row, &self.turn_row);
        add_outer(hessian, n_u, -S::one(), &self.turn_row, length_row);
        add_outer(hessian, n_u, along * 2.0 / (length * length), length_row, length_row);
        for j in 0..rule.n {
            let node = element.first_node + j;
            let mut share = S::zero();
            for m in 0..3 {
                share += pull[3 * m] * rule.magnus[m][s * rule.n + j];
            }
            let bend = -share * length * state.leader_twist(node)[1];
            if !bend.vanishes() {
                let label = state.z_row(node, local::X);
                add_outer(hessian, n_u, bend, label, label);
            }
        }
    }
}
