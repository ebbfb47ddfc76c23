//! What the loads contribute to the Hessian of the Lagrangian, and the forces at the points.
//!
//! Every load is a force and a moment about the centre at a point of the robot; its generalised force is
//! Q = Σ (c_u · f + φ_u · m) with the rows c_u and φ_u of the poses. The second derivatives of positions are
//! never formed: with n the force and μ the moment of everything beyond a section, they collapse to one
//! term per node (centreline) and one per rotation step, as in a backward recursion along a beam.

use super::assembly::{Assembly, Setting, add_outer};
use super::load::{Applied, Loads};
use crate::dense::{add_rows, add_scaled, axpy, column, cross, dot, inner, times};
use crate::kinematics::follower::local;
use crate::kinematics::layout::Layout;
use crate::kinematics::pose::{Poses, point, stretch_row, tangent, turning, turning_unknown};
use crate::kinematics::so3::{self, hat};
use crate::kinematics::state::{State, row};
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

// How the second derivatives collapse. A load f at a point moves by c and turns by φ, functions of u by way of K and g. Its share of
// 𝓛_uu is −Σ (c_uu·f + φ_uu·m) − Σ c_uᵀ f_u − …: the second sum, how the load itself changes, is `concentrated_hessian` and
// `distributed_hessian`. In the first, c_uu of one point is itself a sum over all steps between it and the base. Summed over the
// points first instead, with n and μ of everything beyond a step, each step contributes once:
//
//   centreline  c = Σ ℓ w g t    →   −ℓ w n·(g_u ⊗ t_u + t_u ⊗ g_u + g t_uu) ,   t_u = φ_u × t             (`spin_hessian`)
//   rotation    R⁺ = R exp Ω^    →   −μ·(φ of the step)_uu: the derivative of J along δΩ and Ω_αα            (`step_hessian`)
//
// n and μ come from the gradient's pass, which is why this one needs nothing but rows of single steps.

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
        // Wrenches and threads are the concentrated ones; of the others, gravity and distributed forces act at the nodes.
        let Loads { gravity, distributed, wrenches: _, threads: _ } = setting.kinds();
        if gravity.is_none() && distributed.is_empty() {
            return;
        }
        let gravity = setting.gravity::<S>();
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

    /// Minus the derivative of the loads' generalised force.
    pub(super) fn load_hessian(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>) {
        let Setting { layout, .. } = setting;
        let concentrated = std::mem::take(&mut self.concentrated);
        for (at, load) in &concentrated {
            self.concentrated_hessian(poses, *at, load);
        }
        self.concentrated = concentrated;
        self.distributed_hessian(setting, state, poses);
        for (e, element) in layout.elements.iter().enumerate() {
            let n = layout.rules[element.rule].n;
            let count = turning(layout, e);
            self.block.clear();
            self.block.resize(count * count, S::zero());
            for i in 0..=n {
                self.step_hessian(layout, state, poses, e, i);
                self.spin_hessian(layout, state, poses, e, i);
            }
            self.add_block(layout, state, e);
        }
    }

    /// Stiffness of a concentrated load: arm and change of the load itself.
    fn concentrated_hessian(&mut self, poses: &Poses<S>, at: usize, load: &Applied<S>) {
        let (n_u, leader_unknowns) = (self.gradient.len(), poses.leader_unknowns);
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
        let rows = at * 3 * leader_unknowns..(at + 1) * 3 * leader_unknowns;
        for (left, form, right) in pairs {
            if form.iter().all(|f| f.vanishes()) {
                continue;
            }
            for i in 0..leader_unknowns {
                let factor = -times(&form.transpose(), &column(&left[rows.clone()], leader_unknowns, i));
                let row = &mut self.hessian[i * n_u..i * n_u + leader_unknowns];
                add_rows(row, &factor, &right[rows.clone()], if self.symmetric { i } else { 0 });
            }
        }
    }

    /// Gravity and distributed force: their arms, and how they change with the local variables.
    fn distributed_hessian(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>) {
        let layout = setting.layout;
        let gravity = setting.gravity::<S>();
        let moving = !layout.edges.is_empty();
        // Wrenches and threads are concentrated; a dead force per label changes with the labels alone.
        let Loads { gravity: _, distributed, wrenches: _, threads: _ } = setting.kinds();
        if gravity.is_none() && (distributed.is_empty() || !moving) {
            return;
        }
        let (rows, followers, n_u, leader_unknowns) =
            (layout.rows(), layout.tubes - 1, state.unknowns, poses.leader_unknowns);
        let mut fall = std::mem::take(&mut self.stretch_row);
        let mut swing = std::mem::take(&mut self.turn_row);
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let (length, length_row) = (state.lengths[e], state.length_row(e));
            for i in 0..rule.n {
                let (node, at) = (element.first_node + i, point(layout, e, i));
                let block = at * 3 * leader_unknowns..(at + 1) * 3 * leader_unknowns;
                let along = |v: &Vector3<S>, rows: &[S], out: &mut Vec<S>| {
                    out.clear();
                    out.resize(leader_unknowns, S::zero());
                    add_rows(out, v, &rows[block.clone()], 0);
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
                    for a in 0..leader_unknowns {
                        let left = -(turning.transpose() * column(spin, leader_unknowns, a));
                        let from = if self.symmetric { a } else { 0 };
                        add_rows(&mut self.hessian[a * n_u..a * n_u + leader_unknowns], &left, spin, from);
                    }
                    // Change of m |h| γ·(c + R o) with the pose, times its slope by each local variable.
                    along(gravity, &poses.shift, &mut fall);
                    add_rows(&mut fall, &arm.cross(gravity), spin, 0);
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

    /// What the spin φ of a point does: to the centreline's rate there, if it is a node, and to the rotation step after it.
    /// With n the internal force there, A = −ℓ g (n tᵀ − n·t 1), u = t × n and r = dg/du,
    /// −n·∂²(g t) = φ_aᵀ A φ_b − ℓ (u·φ_a r_b + r_a u·φ_b), without the part through second rotations; and with the moment μ
    /// from that step on, −μ·(φ_b × R J Ω_a) = (μ × R J Ω_a)·φ_b.
    fn spin_hessian(&mut self, layout: &Layout, state: &State<S>, poses: &Poses<S>, e: usize, i: usize) {
        let (n_u, leader_unknowns, edges) = (state.unknowns, poses.leader_unknowns, layout.edges.len());
        let (element, at) = (&layout.elements[e], point(layout, e, i));
        let (length, is_node) = (state.lengths[e], i < layout.rules[element.rule].n);
        let spin = &poses.spin[at * 3 * leader_unknowns..(at + 1) * 3 * leader_unknowns];
        let (mut form, mut across, mut stretched) = (Matrix3::zeros(), Vector3::zeros(), 0..0);
        if is_node {
            let (internal, node) = (&self.internal[at], element.first_node + i);
            let t = tangent(&poses.rotation[at]);
            let (factor, push) = (-length * poses.stretch[node], inner(internal, &t));
            for row in 0..3 {
                for column in 0..3 {
                    form[(row, column)] = internal[row] * t[column] * factor;
                }
                form[(row, row)] -= push * factor;
            }
            across = cross(&t, internal);
            stretch_row(layout, state, e, node, &mut self.stretch_row);
            stretched = if edges > 0 || layout.stretch { 0..leader_unknowns } else { element.bends_z() };
        }
        let next = self.moment.get(at + 1);
        for a in 0..leader_unknowns {
            let own = column(spin, leader_unknowns, a);
            let mut left = times(&form, &own);
            if stretched.contains(&a) {
                add_scaled(&mut left, -length * self.stretch_row[a], &across);
            }
            if let Some(moment) = next {
                add_scaled(&mut left, S::one(), &cross(moment, &poses.turned(at + 1, a)));
            }
            let row = &mut self.hessian[a * n_u..a * n_u + leader_unknowns];
            let from = if self.symmetric { a } else { 0 };
            add_rows(row, &left, spin, from);
            let rest = stretched.start.max(from)..stretched.end;
            if !rest.is_empty() {
                let factor = -length * inner(&across, &own);
                axpy(&mut row[rest.clone()], factor, &self.stretch_row[rest]);
            }
        }
        if is_node && edges > 0 {
            self.moving_centreline(layout, state, poses, e, i);
        }
    }

    /// The second derivatives of −n·(g t) at a node by what moves its element: the length, and D_1 and K_Z under a moving label.
    fn moving_centreline(&mut self, layout: &Layout, state: &State<S>, poses: &Poses<S>, e: usize, i: usize) {
        let (n_u, leader_unknowns) = (state.unknowns, poses.leader_unknowns);
        let (node, at) = (layout.elements[e].first_node + i, point(layout, e, i));
        let (internal, length, g) = (&self.internal[at], state.lengths[e], poses.stretch[node]);
        let t = tangent(&poses.rotation[at]);
        let push = inner(internal, &t);
        self.turn_row.clear();
        self.turn_row.resize(leader_unknowns, S::zero());
        add_rows(
            &mut self.turn_row,
            &(cross(&t, internal) * g),
            &poses.spin[at * 3 * leader_unknowns..(at + 1) * 3 * leader_unknowns],
            0,
        );
        axpy(&mut self.turn_row, push, &self.stretch_row);
        let [_, slope, bend] = state.leader_offset[node];
        let kz = state.local[node * layout.rows() + local::KZ];
        let (row_kz, row_x) = (state.z_row(node, local::KZ), state.z_row(node, local::X));
        let hessian = &mut self.hessian;
        add_outer(hessian, n_u, -length * push * slope, row_kz, row_x);
        add_outer(hessian, n_u, -length * push * slope, row_x, row_kz);
        add_outer(hessian, n_u, -length * push * bend * kz, row_x, row_x);
        add_outer(hessian, n_u, -S::one(), state.length_row(e), &self.turn_row);
        add_outer(hessian, n_u, -S::one(), &self.turn_row, state.length_row(e));
    }

    /// The part of one rotation step: −μ·∂_b(R J Ω_a) at fixed R, μ the moment of everything from its end on. What the
    /// unknowns that turn the step do to each other is collected in `block`, over ℓ².
    fn step_hessian(&mut self, layout: &Layout, state: &State<S>, poses: &Poses<S>, e: usize, s: usize) {
        let count = turning(layout, e);
        let (element, edges, at) = (&layout.elements[e], layout.edges.len(), point(layout, e, s));
        let rule = &layout.rules[element.rule];
        let (step, slope, moment) = (&poses.steps[at], &poses.slopes[at], &self.moment[at]);
        let body = times(&poses.before(at).transpose(), moment);
        let y = times(&step.jacobian.transpose(), &body);
        // In the generators: −Ω_b·(B Ω_a) − y·d²Ω.
        let bend = so3::jacobian_derivative(&step.magnus.omega, &body, step.coefficients);
        let form = &mut self.form;
        step.magnus.second(&y, form);
        for (a, form) in form.iter_mut().enumerate() {
            let [u, v, w] = [slope[0][a], slope[1][a], slope[2][a]];
            let x = (bend[0][0] * u).plus(bend[0][1], v).plus(bend[0][2], w);
            let y = (bend[1][0] * u).plus(bend[1][1], v).plus(bend[1][2], w);
            let z = (bend[2][0] * u).plus(bend[2][1], v).plus(bend[2][2], w);
            for b in 0..9 {
                form[b] = -form[b].plus(x, slope[0][b]).plus(y, slope[1][b]).plus(z, slope[2][b]);
            }
        }
        // From the generators to the unknowns, first on the left.
        let by_edge = poses.by_edge(layout, e, s);
        let of_axis = |axis: usize| rule.shares_of_modes(s, element.modes[axis].1);
        let shares = [of_axis(0), of_axis(1), of_axis(2)];
        let mut left = [S::zero(); 9];
        for a in 0..count {
            if a < edges {
                left.fill(S::zero());
                for (share, form) in by_edge[a].iter().zip(&*form) {
                    axpy(&mut left, *share, form);
                }
            } else {
                let (axis, mode) = element.turned(a - edges);
                let [t1, t2, t3] = shares[axis];
                let [t1, t2, t3] = [S::splat(t1[mode]), S::splat(t2[mode]), S::splat(t3[mode])];
                for (k, left) in left.iter_mut().enumerate() {
                    *left = (form[axis][k] * t1).plus(form[3 + axis][k], t2).plus(form[6 + axis][k], t3);
                }
            }
            let row = &mut self.block[a * count..(a + 1) * count];
            let from = if self.symmetric { a } else { 0 };
            for (entry, by_edge) in row.iter_mut().zip(by_edge).skip(from) {
                *entry += dot(&left, by_edge);
            }
            let mut rest = &mut row[edges..];
            let mut passed = from.saturating_sub(edges);
            for (axis, [t1, t2, t3]) in shares.iter().enumerate() {
                let (own, others) = rest.split_at_mut(t1.len());
                rest = others;
                let skip = passed.min(t1.len());
                passed -= skip;
                let shares = t1[skip..].iter().zip(&t2[skip..]).zip(&t3[skip..]);
                for (entry, ((t1, t2), t3)) in own[skip..].iter_mut().zip(shares) {
                    *entry = entry
                        .plus(left[axis], S::splat(*t1))
                        .plus(left[3 + axis], S::splat(*t2))
                        .plus(left[6 + axis], S::splat(*t3));
                }
            }
        }
        if edges > 0 {
            self.moving_step(layout, state, poses, e, s, &y);
        }
    }

    /// Puts what the steps of one element have collected into the Hessian.
    fn add_block(&mut self, layout: &Layout, state: &State<S>, e: usize) {
        let (count, n_u) = (turning(layout, e), state.unknowns);
        let squared = state.lengths[e] * state.lengths[e];
        for a in 0..count {
            let row = turning_unknown(layout, e, a) * n_u;
            for b in if self.symmetric { a } else { 0 }..count {
                self.hessian[row + turning_unknown(layout, e, b)] += self.block[a * count + b] * squared;
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
        let pull = magnus.pull(y);
        let moment = &self.moment[at];
        self.turn_row.clear();
        self.turn_row.resize(poses.leader_unknowns, S::zero());
        for i in 0..count {
            let unknown = turning_unknown(layout, e, i);
            self.turn_row[unknown] = inner(moment, &poses.turned(at, unknown)) / length;
        }
        let mut along = S::zero();
        for (pull, alpha) in pull.iter().zip(&magnus.alpha) {
            along += pull.dot(alpha);
        }
        let hessian = &mut self.hessian;
        add_outer(hessian, n_u, -S::one(), length_row, &self.turn_row);
        add_outer(hessian, n_u, -S::one(), &self.turn_row, length_row);
        add_outer(hessian, n_u, along * 2.0 / (length * length), length_row, length_row);
        for j in 0..rule.n {
            let node = element.first_node + j;
            let mut share = S::zero();
            for m in 0..3 {
                share += pull[m].x * rule.magnus[m][s * rule.n + j];
            }
            let bend = -share * length * state.leader_twist(node)[1];
            if !bend.vanishes() {
                let label = state.z_row(node, local::X);
                add_outer(hessian, n_u, bend, label, label);
            }
        }
    }
}
