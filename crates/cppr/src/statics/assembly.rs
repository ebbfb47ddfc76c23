//! The Lagrangian of the consistent formulation, its gradient and its Hessian over the unknowns u.
//!
//! ```text
//! 𝓛(u) = U + V − Σ_k T_k Δa_k − Σ_k Υ_k Ω_k + Σ_b λ_b x_b
//! ```
//!
//! with the elastic energy U, the potential V of the loads, actuation force T_k and torque Υ_k, and for
//! every edge b the multiplier of x_b = 0. Equilibrium is 𝓛_u = 0 together with the actuation conditions.
//!
//! U and Δa are sums over nodes of ℓ_e F_i(v_i), v_i the local variables. The face-to-face functions and
//! angles among them are integrals; their adjoints a_i, b_i turn second derivatives of the whole into second
//! derivatives at the nodes: 𝓛_uu = Σ ℓ Zᵀ (F + a·|h|)_vv Z + (terms of moving elements), Z = dv/du.

use super::load::{Applied, Loads, Station};
use super::{energy, weight};
use crate::dense::{Lu, axpy, axpy_table};
use crate::design::Robot;
use crate::design::fields::{FieldJets, Part};
use crate::kinematics::follower::local;
use crate::kinematics::layout::{Joint, Layout};
use crate::kinematics::pose::{Poses, point};
use crate::kinematics::state::{State, part, row};
use crate::real::{Each, Real};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// What the conjugate of the actuation torque is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RotationKnob {
    /// The rotation Ω_k of the follower's base, as a motor turns it.
    #[default]
    Base,
    /// −Δθ_k(0): what the paper prescribes.
    RelativeAngle,
}

/// Actuation efforts and multipliers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Efforts<S = f64> {
    /// T_k of every follower (N).
    pub tension: Vec<S>,
    /// Υ_k of every follower (N m).
    pub torque: Vec<S>,
    /// λ of every edge, in the order of the layout's edges (N).
    pub edge: Vec<S>,
}

/// Gradient, Hessian and conditions at one configuration. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assembly<S: Real = f64> {
    /// Elastic energy U (J).
    pub elastic: S,
    /// 𝓛_u.
    pub gradient: Vec<S>,
    /// 𝓛_uu, row-major.
    pub hessian: Vec<S>,
    /// Per follower: Δa_k and Ω_k (or −Δθ_k(0)).
    pub knobs: Vec<[S; 2]>,
    /// Their rows by u.
    pub knob_rows: Vec<[Vec<S>; 2]>,
    /// Per edge: x_b and its row.
    pub edges: Vec<S>,
    pub edge_rows: Vec<Vec<S>>,
    /// Per node and follower: adjoint of |h| over the node's weight, the configurational force (N).
    pub adjoint: Vec<S>,
    angle_adjoint: Vec<S>,
    pub(crate) jets: Vec<FieldJets<S>>,
    pub(super) values: Vec<S>,
    pub(super) slopes: Vec<S>,
    pub(crate) point_force: Vec<Vector3<S>>,
    pub(super) point_moment: Vec<Vector3<S>>,
    lu: Lu<S>,
    matrix: Vec<S>,
    work: Vec<S>,
    spread: Vec<S>,
    pub(super) stretch_row: Vec<S>,
    pub(super) turn_row: Vec<S>,
    pub(super) block: Vec<S>,
    pub(super) half: Vec<S>,
    full: Vec<S>,
    /// Serial numbers of robot and layout whose constant fields are known.
    known: (u64, u64),
    concentrated: Vec<(usize, Applied<S>)>,
}

/// What `assemble` reads.
pub(crate) struct Setting<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    /// The loads of every lane: of the same kinds at the same labels.
    pub loads: Each<'a, Loads>,
    pub knob: RotationKnob,
}

impl Setting<'_> {
    /// The loads of the first lane, where those of all lanes are alike.
    pub fn kinds(&self) -> &Loads {
        self.loads.first()
    }

    /// A vector of the loads of every lane.
    pub fn vector<S: Real>(&self, of: impl Fn(&Loads) -> Vector3<f64>) -> Vector3<S> {
        Vector3::from_fn(|axis, _| S::from_lanes(|l| of(self.loads.0[l])[axis]))
    }

    /// Gravity of every lane.
    pub fn gravity<S: Real>(&self) -> Option<Vector3<S>> {
        self.kinds().gravity.map(|_| self.vector(|loads| loads.gravity.unwrap_or_default()))
    }

    /// A distributed force of every lane, where it acts at a label.
    pub fn distributed<S: Real>(&self, label: S) -> impl Iterator<Item = Vector3<S>> {
        let list = self.kinds().distributed.iter().enumerate();
        // The layout is cut where it begins and ends, so that all lanes are inside or none.
        let inside = list.filter(move |(_, d)| (d.from..=d.to).contains(&label.lane(0)));
        inside.map(|(i, _)| self.vector(move |loads| loads.distributed[i].force))
    }
}

/// Concentrated loads with the point they act at.
pub(crate) fn applied<S: Real>(
    setting: &Setting,
    poses: &Poses<S>,
    coordinates: &[S],
    all: &mut Vec<(usize, Applied<S>)>,
) {
    let layout = setting.layout;
    let tip = layout.nodes + layout.elements.len() - 1;
    all.clear();
    for (i, wrench) in setting.kinds().wrenches.iter().enumerate() {
        let at = match wrench.station {
            Station::Tip => Some(tip),
            Station::Label(label) => end_point(layout, coordinates, label),
        };
        // A load on the clamped first section does no work.
        if let Some(at) = at {
            let rotation = &poses.rotation[at];
            let load = |l: usize| setting.loads.0[l].wrenches[i].at(&rotation.map(|r| r.lane(l)));
            all.push((at, Applied::from_lanes(load)));
        }
    }
    for i in 0..setting.kinds().threads.len() {
        let (rotation, centre) = (&poses.rotation[tip], &poses.centre[tip]);
        let load = |l: usize| {
            setting.loads.0[l].threads[i].at(&rotation.map(|r| r.lane(l)), &centre.map(|c| c.lane(l)))
        };
        all.push((tip, Applied::from_lanes(load)));
    }
}

/// The element end that lies at `label`; the layout has been cut there.
fn end_point<S: Real>(layout: &Layout, coordinates: &[S], label: f64) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (e, element) in layout.elements.iter().enumerate() {
        let distance = (Layout::label(element.end, coordinates).0.lane(0) - label).abs();
        if label > 0.0 && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, point(layout, e, layout.rules[element.rule].n)));
        }
    }
    best.map(|(_, at)| at)
}

impl<S: Real> Assembly<S> {
    /// Evaluates everything at an evaluated state with rows (and poses with rows where there are loads).
    pub fn assemble(
        &mut self,
        setting: &Setting,
        coordinates: &[S],
        state: &State<S>,
        poses: &Poses<S>,
        efforts: &Efforts<S>,
        second: bool,
    ) {
        let n_u = state.unknowns;
        self.gradient.clear();
        self.gradient.resize(n_u, S::zero());
        self.hessian.clear();
        self.hessian.resize(if second { n_u * n_u } else { 0 }, S::zero());
        self.conditions(setting, state);
        self.nodes(setting, state, poses);
        self.first_derivatives(setting, state, efforts);
        let mut concentrated = std::mem::take(&mut self.concentrated);
        concentrated.clear();
        let loaded = !setting.kinds().is_empty();
        if loaded {
            applied(setting, poses, coordinates, &mut concentrated);
            self.collect_forces(setting, state, poses, &concentrated);
            self.load_gradient(poses);
        }
        self.adjoints(setting, state, efforts);
        if second {
            self.second_derivatives(setting, state, poses, efforts);
            if loaded {
                self.load_hessian(setting, state, poses, &concentrated);
            }
        }
        self.concentrated = concentrated;
    }

    /// Serial number of the robot assembled last.
    pub fn robot(&self) -> u64 {
        self.known.0
    }

    /// Actuator positions and edges with their rows.
    fn conditions(&mut self, setting: &Setting, state: &State<S>) {
        let Setting { robot, layout, knob, .. } = setting;
        let followers = layout.tubes - 1;
        self.knobs.resize(followers, [S::zero(); 2]);
        self.knob_rows.resize(followers, [Vec::new(), Vec::new()]);
        for f in 0..followers {
            let [face, angle] = state.joints[f];
            let (position, slope) = match knob {
                RotationKnob::Base => {
                    let own = robot.fields[f + 1].direction(face, part_at_base(layout, f));
                    let rest = robot.rest_angle(f + 1, 0.0)[0];
                    let leader = robot.fields[0].direction(0.0, Part::Pattern)[0];
                    (-angle - own[0] + (leader + PI - rest), own[1])
                }
                RotationKnob::RelativeAngle => (-angle, S::zero()),
            };
            self.knobs[f] = [face, position];
            let [face_row, angle_row] = &mut self.knob_rows[f];
            face_row.clear();
            face_row.extend_from_slice(state.joint_row(0, f, 0));
            angle_row.clear();
            let rows = state.joint_row(0, f, 1).iter().zip(state.joint_row(0, f, 0));
            angle_row.extend(rows.map(|(t, x)| -*t - slope * *x));
        }
        self.edges.resize(layout.edges.len(), S::zero());
        self.edge_rows.resize(layout.edges.len(), Vec::new());
        for (e, element) in layout.elements.iter().enumerate() {
            if let Joint::Edge { follower, unknown } = element.start {
                self.edges[unknown] = state.joints[e * followers + follower - 1][0];
                self.edge_rows[unknown].clear();
                self.edge_rows[unknown].extend_from_slice(state.joint_row(e, follower - 1, 0));
            }
        }
    }

    /// F and F_v at every node: elastic energy and gravity, each with the node's weight.
    fn nodes(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>) {
        let Setting { robot, layout, .. } = setting;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        let gravity = setting.gravity();
        // Fields at labels that do not move, and fields that are constant, are known from the last time.
        let serials = (robot.serial, layout.serial);
        let (fresh, moving) = (self.known != serials, !layout.edges.is_empty());
        self.known = serials;
        self.values.clear();
        self.values.resize(layout.nodes, S::zero());
        self.slopes.clear();
        self.slopes.resize(layout.nodes * rows, S::zero());
        self.jets.resize(layout.nodes * layout.tubes, FieldJets::default());
        self.elastic = S::zero();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let node = element.first_node + i;
                let weight = rule.weights[i];
                let jets = &mut self.jets[node * layout.tubes..(node + 1) * layout.tubes];
                let own = &state.local[node * rows..(node + 1) * rows];
                if fresh || moving {
                    jets[0] = robot.fields[0].jets(own[local::X], Part::Pattern);
                }
                let (energy, gradient) = energy::leader(&jets[0], own);
                let mut value = energy;
                let slopes = &mut self.slopes[node * rows..(node + 1) * rows];
                for (slope, g) in slopes.iter_mut().zip(gradient) {
                    *slope += g * weight;
                }
                for f in 0..followers {
                    let fields = &robot.fields[f + 1];
                    let part = part(element, f + 1);
                    if fresh || !fields.is_constant(part) {
                        jets[f + 1] = fields.jets(own[row(f, local::FACE)], part);
                    }
                    let facing = &state.facing[node * followers + f];
                    let (energy, gradient) = energy::gradient(facing, own[row(f, local::EK)], &jets[f + 1]);
                    value += energy;
                    for (variable, slope) in gradient.into_iter().enumerate() {
                        slopes[row(f, variable)] += slope * weight;
                    }
                }
                self.elastic += state.lengths[e] * value * weight;
                self.values[node] = value * weight;
                if let Some(gravity) = &gravity {
                    let at = point(layout, e, i);
                    let (rotation, centre) = (&poses.rotation[at], &poses.centre[at]);
                    self.weigh(setting, state, node, weight, gravity, rotation, centre);
                }
            }
        }
    }

    fn first_derivatives(&mut self, setting: &Setting, state: &State<S>, efforts: &Efforts<S>) {
        let layout = setting.layout;
        let rows = layout.rows();
        for (e, element) in layout.elements.iter().enumerate() {
            let length = state.lengths[e];
            for node in element.first_node..element.first_node + layout.rules[element.rule].n {
                for active in &element.active {
                    let slope = self.slopes[node * rows + active.row];
                    if !slope.vanishes() {
                        let range = active.unknowns.clone();
                        let z = &state.z_row(node, active.row)[range.clone()];
                        axpy(&mut self.gradient[range], length * slope, z);
                    }
                }
                if !layout.edges.is_empty() {
                    axpy(&mut self.gradient, self.values[node], state.length_row(e));
                }
            }
        }
        for f in 0..layout.tubes - 1 {
            axpy(&mut self.gradient, -efforts.tension[f], &self.knob_rows[f][0]);
            axpy(&mut self.gradient, -efforts.torque[f], &self.knob_rows[f][1]);
        }
        for (row, &multiplier) in self.edge_rows.iter().zip(&efforts.edge) {
            axpy(&mut self.gradient, multiplier, row);
        }
    }

    /// The adjoints of |h_k| and Δθ_k' at the nodes, from the base to the tip.
    fn adjoints(&mut self, setting: &Setting, state: &State<S>, efforts: &Efforts<S>) {
        let Setting { robot, layout, knob, .. } = setting;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.adjoint.resize(layout.nodes * followers, S::zero());
        self.angle_adjoint.resize(layout.nodes * followers, S::zero());
        for f in 0..followers {
            let slope = match knob {
                RotationKnob::Base => {
                    robot.fields[f + 1].direction(state.joints[f][0], part_at_base(layout, f))[1]
                }
                RotationKnob::RelativeAngle => S::zero(),
            };
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
                // r_i, the force that node i feels along x_k: (1 + ℓ D Bᵀ) r = ℓ (F_x + D w force).
                self.work.clear();
                for i in 0..n {
                    let felt = slope_of(self, i, local::FACE) + h_face(i) * force * rule.weights[i];
                    self.work.push(length * felt);
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
                for (i, &felt) in self.work.iter().enumerate() {
                    axpy_table(&mut self.spread, felt, &rule.to_end[i * n..(i + 1) * n]);
                    spread += felt;
                }
                for j in 0..n {
                    self.adjoint[node(j) * followers + f] = force * rule.weights[j] - self.spread[j];
                }
                force -= spread;
                // The adjoint of Δθ_k' is asked for where elements move.
                if layout.edges.is_empty() {
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
                    for (i, felt) in self.work.iter().enumerate() {
                        back += *felt * rule.to_end[i * n + j];
                    }
                    self.angle_adjoint[node(j) * followers + f] = torque * rule.weights[j] - back;
                }
                torque -= total;
            }
        }
    }

    /// Collects half of every second derivative of the energies and conditions, then adds the other half.
    fn second_derivatives(
        &mut self,
        setting: &Setting,
        state: &State<S>,
        poses: &Poses<S>,
        efforts: &Efforts<S>,
    ) {
        let Setting { robot, layout, knob, .. } = setting;
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let gravity = setting.gravity();
        let moving = !layout.edges.is_empty();
        let mut full = std::mem::take(&mut self.full);
        full.resize(rows * rows, S::zero());
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let (node, weight) = (element.first_node + i, rule.weights[i]);
                full.fill(S::zero());
                // F_v + a |h|_v, for the terms of moving elements.
                self.work.clear();
                self.work.extend_from_slice(&self.slopes[node * rows..(node + 1) * rows]);
                let jets = &self.jets[node * layout.tubes..(node + 1) * layout.tubes];
                let own = &state.local[node * rows..(node + 1) * rows];
                let mut add = |a: usize, b: usize, value: S| {
                    full[a * rows + b] += value * weight;
                    if a != b {
                        full[b * rows + a] += value * weight;
                    }
                };
                energy::leader_second(&jets[0], own, moving, &mut add);
                for f in 0..followers {
                    let v = state.variables(node, f);
                    let facing = &state.facing[node * followers + f];
                    let adjoint = self.adjoint[node * followers + f];
                    let mut add = |a: usize, b: usize, value: S| {
                        let (a, b) = (row(f, a), row(f, b));
                        full[a * rows + b] += value;
                        if a != b {
                            full[b * rows + a] += value;
                        }
                    };
                    let share = S::splat(weight);
                    let by_h = energy::second(
                        facing,
                        v[local::EK],
                        &jets[f + 1],
                        share,
                        &element.variables,
                        &mut add,
                    );
                    let mut along_h = by_h * weight + adjoint;
                    if let Some(gravity) = &gravity {
                        let at = point(layout, e, i);
                        let (rotation, centre) = (&poses.rotation[at], &poses.centre[at]);
                        along_h +=
                            weight::second(facing, &jets[f + 1], weight, gravity, rotation, centre, &mut add);
                    }
                    facing.second(&v, &state.leader_offset[node], &jets[f + 1].offset, along_h, &mut add);
                    if moving {
                        for (a, dh) in facing.dh.iter().enumerate() {
                            self.work[row(f, a)] += adjoint * *dh;
                        }
                    }
                }
                if let Some(gravity) = &gravity {
                    let at = point(layout, e, i);
                    let body = poses.rotation[at].transpose() * gravity;
                    let [d, d1, d2] = jets[0].offset;
                    let arm = gravity.dot(&poses.centre[at]) + d * body.y;
                    let [m, m1, m2] = jets[0].mass;
                    let bend = m2 * arm + m1 * d1 * body.y * 2.0 + m * d2 * body.y;
                    full[local::X * rows + local::X] -= bend * weight;
                }
                self.congruence(&full, layout, state, e, node);
                if moving {
                    self.moving_terms(layout, state, e, i);
                }
            }
        }
        self.full = full;
        for f in 0..followers {
            if *knob == RotationKnob::Base {
                let bend = robot.fields[f + 1].direction(state.joints[f][0], part_at_base(layout, f))[2];
                let row = state.joint_row(0, f, 0);
                if !bend.vanishes() {
                    add_outer(&mut self.hessian, n_u, efforts.torque[f] * bend * 0.5, row, row);
                }
            }
        }
        for i in 0..n_u {
            for j in 0..=i {
                let sum = self.hessian[i * n_u + j] + self.hessian[j * n_u + i];
                self.hessian[i * n_u + j] = sum;
                self.hessian[j * n_u + i] = sum;
            }
        }
    }

    /// Half of ℓ Zᵀ full Z at one node: rows of Z with those after them, and half of the diagonal.
    fn congruence(&mut self, full: &[S], layout: &Layout, state: &State<S>, e: usize, node: usize) {
        let (rows, n_u) = (layout.rows(), state.unknowns);
        let (element, length) = (&layout.elements[e], state.lengths[e]);
        self.matrix.resize(n_u.max(self.matrix.len()), S::zero());
        let work = &mut self.matrix[..n_u];
        for (n, a) in element.active.iter().enumerate() {
            let (mut low, mut high) = (n_u, 0);
            for (m, b) in element.active[n..].iter().enumerate() {
                let mut factor = full[a.row * rows + b.row];
                if factor.vanishes() {
                    continue;
                }
                factor = length * if m == 0 { factor * 0.5 } else { factor };
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
    /// `self.work` holds F_v + a |h|_v of the node.
    fn moving_terms(&mut self, layout: &Layout, state: &State<S>, e: usize, i: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let (node, length) = (element.first_node + i, state.lengths[e]);
        let mut along = std::mem::take(&mut self.turn_row);
        along.clear();
        along.resize(n_u, S::zero());
        for row in 0..rows {
            axpy(&mut along, self.work[row], state.z_row(node, row));
        }
        for f in 0..followers {
            let (first, count) = element.modes[3 + f];
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

/// The part of follower `f` (0-based) that faces the plate.
fn part_at_base(layout: &Layout, f: usize) -> Part {
    part(&layout.elements[0], f + 1)
}

/// hessian += factor · left ⊗ right, over the first unknowns where the rows are shorter.
pub(super) fn add_outer<S: Real>(hessian: &mut [S], n_u: usize, factor: S, left: &[S], right: &[S]) {
    for (i, &l) in left.iter().enumerate() {
        if !l.vanishes() {
            axpy(&mut hessian[i * n_u..i * n_u + right.len()], factor * l, right);
        }
    }
}
