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
use crate::dense::{Lu, axpy};
use crate::design::Robot;
use crate::design::fields::{FieldJets, Part};
use crate::kinematics::follower::{Block, local};
use crate::kinematics::layout::{Joint, Layout};
use crate::kinematics::pose::{Poses, point};
use crate::kinematics::state::State;
use nalgebra::Vector3;

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
pub(crate) struct Efforts {
    /// T_k of every follower (N).
    pub tension: Vec<f64>,
    /// Υ_k of every follower (N m).
    pub torque: Vec<f64>,
    /// λ of every edge, in the order of the layout's edges (N).
    pub edge: Vec<f64>,
}

/// Gradient, Hessian and conditions at one configuration. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assembly {
    /// Elastic energy U (J).
    pub elastic: f64,
    /// 𝓛_u.
    pub gradient: Vec<f64>,
    /// 𝓛_uu, row-major.
    pub hessian: Vec<f64>,
    /// Per follower: Δa_k and Ω_k (or −Δθ_k(0)).
    pub knobs: Vec<[f64; 2]>,
    /// Their rows by u.
    pub knob_rows: Vec<[Vec<f64>; 2]>,
    /// Per edge: x_b and its row.
    pub edges: Vec<f64>,
    pub edge_rows: Vec<Vec<f64>>,
    /// Per node and follower: adjoint of |h| over the node's weight, the configurational force (N).
    pub adjoint: Vec<f64>,
    angle_adjoint: Vec<f64>,
    pub(crate) jets: Vec<FieldJets>,
    pub(super) values: Vec<f64>,
    pub(super) slopes: Vec<f64>,
    pub(crate) point_force: Vec<Vector3<f64>>,
    pub(super) point_moment: Vec<Vector3<f64>>,
    lu: Lu,
    matrix: Vec<f64>,
    work: Vec<f64>,
    pub(super) stretch_row: Vec<f64>,
    pub(super) turn_row: Vec<f64>,
    pub(super) right: Vec<f64>,
    full: Vec<f64>,
    concentrated: Vec<(usize, Applied)>,
}

/// What `assemble` reads.
pub(crate) struct Setting<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    pub loads: &'a Loads,
    pub knob: RotationKnob,
}

/// Concentrated loads with the point they act at.
pub(crate) fn applied(
    setting: &Setting,
    poses: &Poses,
    coordinates: &[f64],
    all: &mut Vec<(usize, Applied)>,
) {
    let Setting { layout, loads, .. } = setting;
    let tip = layout.nodes + layout.elements.len() - 1;
    all.clear();
    for wrench in &loads.wrenches {
        let at = match wrench.station {
            Station::Tip => Some(tip),
            Station::Label(label) => end_point(layout, coordinates, label),
        };
        // A load on the clamped first section does no work.
        if let Some(at) = at {
            all.push((at, wrench.at(&poses.rotation[at])));
        }
    }
    for thread in &loads.threads {
        all.push((tip, thread.at(&poses.rotation[tip], &poses.centre[tip])));
    }
}

/// The element end that lies at `label`; the layout has been cut there.
fn end_point(layout: &Layout, coordinates: &[f64], label: f64) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (e, element) in layout.elements.iter().enumerate() {
        let distance = (Layout::label(element.end, coordinates).0 - label).abs();
        if label > 0.0 && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, point(layout, e, layout.rules[element.rule].n)));
        }
    }
    best.map(|(_, at)| at)
}

impl Assembly {
    /// Evaluates everything at an evaluated state with rows (and poses with rows where there are loads).
    pub fn assemble(
        &mut self,
        setting: &Setting,
        coordinates: &[f64],
        state: &State,
        poses: &Poses,
        efforts: &Efforts,
        second: bool,
    ) {
        let n_u = state.unknowns;
        self.gradient.clear();
        self.gradient.resize(n_u, 0.0);
        self.hessian.clear();
        self.hessian.resize(if second { n_u * n_u } else { 0 }, 0.0);
        self.conditions(setting, state);
        self.nodes(setting, state, poses);
        self.first_derivatives(setting, state, efforts);
        let mut concentrated = std::mem::take(&mut self.concentrated);
        concentrated.clear();
        if !setting.loads.is_empty() {
            applied(setting, poses, coordinates, &mut concentrated);
            self.collect_forces(setting, state, poses, &concentrated);
            self.load_gradient(state, poses);
        }
        self.adjoints(setting, state, efforts);
        if second {
            self.second_derivatives(setting, state, poses, efforts);
            if !setting.loads.is_empty() {
                self.load_hessian(setting, state, poses, &concentrated);
            }
        }
        self.concentrated = concentrated;
    }

    /// Actuator positions and edges with their rows.
    fn conditions(&mut self, setting: &Setting, state: &State) {
        let Setting { robot, layout, knob, .. } = setting;
        let followers = layout.tubes - 1;
        self.knobs.resize(followers, [0.0; 2]);
        self.knob_rows.resize(followers, [Vec::new(), Vec::new()]);
        for f in 0..followers {
            let [face, angle] = state.joints[f];
            let (position, slope) = match knob {
                RotationKnob::Base => {
                    let own = robot.fields[f + 1].direction(face, part_at_base(layout, f));
                    let rest = robot.rest_angle(f + 1, 0.0)[0];
                    let leader = robot.fields[0].direction(0.0, Part::Pattern)[0];
                    (leader + std::f64::consts::PI - rest - angle - own[0], own[1])
                }
                RotationKnob::RelativeAngle => (-angle, 0.0),
            };
            self.knobs[f] = [face, position];
            let [face_row, angle_row] = &mut self.knob_rows[f];
            face_row.clear();
            face_row.extend_from_slice(state.joint_row(0, f, 0));
            angle_row.clear();
            angle_row.extend(
                state.joint_row(0, f, 1).iter().zip(state.joint_row(0, f, 0)).map(|(t, x)| -t - slope * x),
            );
        }
        self.edges.resize(layout.edges.len(), 0.0);
        self.edge_rows.resize(layout.edges.len(), Vec::new());
        for (e, element) in layout.elements.iter().enumerate() {
            if let Joint::Edge { follower, unknown } = element.start {
                let place = unknown - layout.modes;
                self.edges[place] = state.joints[e * followers + follower - 1][0];
                self.edge_rows[place].clear();
                self.edge_rows[place].extend_from_slice(state.joint_row(e, follower - 1, 0));
            }
        }
    }

    /// F and F_v at every node: elastic energy and gravity, each with the node's weight.
    fn nodes(&mut self, setting: &Setting, state: &State, poses: &Poses) {
        let Setting { robot, layout, loads, .. } = setting;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.values.clear();
        self.values.resize(layout.nodes, 0.0);
        self.slopes.clear();
        self.slopes.resize(layout.nodes * rows, 0.0);
        self.jets.resize(layout.nodes * layout.tubes, FieldJets::default());
        self.elastic = 0.0;
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let node = element.first_node + i;
                let weight = rule.weights[i];
                let label = state.local[node * rows + local::X];
                let leader = robot.fields[0].jets(label, Part::Pattern);
                self.jets[node * layout.tubes] = leader;
                let (energy, gradient) = energy::leader(&leader, &state.local[node * rows..node * rows + 5]);
                let mut value = energy;
                let slopes = &mut self.slopes[node * rows..(node + 1) * rows];
                axpy(&mut slopes[..5], weight, &gradient);
                for f in 0..followers {
                    let v = state.variables(node, f);
                    let part = if element.below[f + 1] { Part::Below } else { Part::Pattern };
                    let jets = robot.fields[f + 1].jets(v[local::FACE], part);
                    self.jets[node * layout.tubes + f + 1] = jets;
                    let facing = &state.facing[node * followers + f];
                    let (energy, gradient) = energy::gradient(facing, v[local::EK], &jets);
                    value += energy;
                    for (variable, slope) in gradient.into_iter().enumerate() {
                        slopes[State::row(f, variable)] += weight * slope;
                    }
                }
                self.elastic += state.lengths[e] * weight * value;
                self.values[node] = weight * value;
                if let Some(gravity) = loads.gravity {
                    let at = point(layout, e, i);
                    self.weigh(
                        setting,
                        state,
                        node,
                        weight,
                        &gravity,
                        &poses.rotation[at],
                        &poses.centre[at],
                    );
                }
            }
        }
    }

    fn first_derivatives(&mut self, setting: &Setting, state: &State, efforts: &Efforts) {
        let layout = setting.layout;
        let (rows, n_u) = (layout.rows(), state.unknowns);
        for (e, element) in layout.elements.iter().enumerate() {
            let length = state.lengths[e];
            for node in element.first_node..element.first_node + layout.rules[element.rule].n {
                for &row in &element.active {
                    let slope = self.slopes[node * rows + row];
                    if slope != 0.0 {
                        axpy(&mut self.gradient, length * slope, state.z_row(node, row));
                    }
                }
                axpy(&mut self.gradient, self.values[node], &state.length_rows[e * n_u..(e + 1) * n_u]);
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
    fn adjoints(&mut self, setting: &Setting, state: &State, efforts: &Efforts) {
        let Setting { robot, layout, knob, .. } = setting;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        self.adjoint.resize(layout.nodes * followers, 0.0);
        self.angle_adjoint.resize(layout.nodes * followers, 0.0);
        for f in 0..followers {
            let slope = match knob {
                RotationKnob::Base => {
                    robot.fields[f + 1].direction(state.joints[f][0], part_at_base(layout, f))[1]
                }
                RotationKnob::RelativeAngle => 0.0,
            };
            let mut force = efforts.tension[f] - efforts.torque[f] * slope;
            let mut torque = -efforts.torque[f];
            for (e, element) in layout.elements.iter().enumerate() {
                if let Joint::Edge { follower, unknown } = element.start
                    && follower == f + 1
                {
                    force -= efforts.edge[unknown - layout.modes];
                }
                let rule = &layout.rules[element.rule];
                let (n, length) = (rule.n, state.lengths[e]);
                let node = |i: usize| element.first_node + i;
                let h_face = |i: usize| state.facing[node(i) * followers + f].dh[local::FACE];
                let slope_of =
                    |s: &Self, i: usize, variable: usize| s.slopes[node(i) * rows + State::row(f, variable)];
                // r_i, the force that node i feels along x_k: (1 + ℓ D Bᵀ) r = ℓ (F_x + D w force).
                self.work.clear();
                for i in 0..n {
                    self.work.push(
                        length * (slope_of(self, i, local::FACE) + h_face(i) * rule.weights[i] * force),
                    );
                }
                if (0..n).any(|i| h_face(i) != 0.0) {
                    self.matrix.clear();
                    for i in 0..n {
                        for j in 0..n {
                            let unit = if i == j { 1.0 } else { 0.0 };
                            self.matrix.push(unit + length * h_face(i) * rule.to_end[j * n + i]);
                        }
                    }
                    if self.lu.factor(&self.matrix, n).is_ok() {
                        self.lu.solve(&mut self.work, 1);
                    }
                }
                let mut spread = 0.0;
                for j in 0..n {
                    let back: f64 = (0..n).map(|i| rule.to_end[i * n + j] * self.work[i]).sum();
                    self.adjoint[node(j) * followers + f] = rule.weights[j] * force - back;
                    spread += self.work[j];
                }
                force -= spread;
                for i in 0..n {
                    let adjoint = self.adjoint[node(i) * followers + f];
                    let h_angle = state.facing[node(i) * followers + f].dh[local::TH];
                    self.work[i] = length * (slope_of(self, i, local::TH) + adjoint * h_angle);
                }
                let mut spread = 0.0;
                for j in 0..n {
                    let back: f64 = (0..n).map(|i| rule.to_end[i * n + j] * self.work[i]).sum();
                    self.angle_adjoint[node(j) * followers + f] = rule.weights[j] * torque - back;
                    spread += self.work[j];
                }
                torque -= spread;
            }
        }
    }

    fn second_derivatives(&mut self, setting: &Setting, state: &State, poses: &Poses, efforts: &Efforts) {
        let Setting { robot, layout, knob, .. } = setting;
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let mut full = std::mem::take(&mut self.full);
        full.resize(rows * rows, 0.0);
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            let length = state.lengths[e];
            let moving = state.length_rows[e * n_u..(e + 1) * n_u].iter().any(|&d| d != 0.0);
            for i in 0..rule.n {
                let node = element.first_node + i;
                full.fill(0.0);
                // F_v + a |h|_v, for the terms of moving elements.
                self.work.clear();
                self.work.extend_from_slice(&self.slopes[node * rows..(node + 1) * rows]);
                let leader = self.jets[node * layout.tubes];
                energy::add_leader_hessian(
                    &leader,
                    &state.local[node * rows..node * rows + 5],
                    rule.weights[i],
                    &mut full,
                    rows,
                );
                for f in 0..followers {
                    let v = state.variables(node, f);
                    let facing = &state.facing[node * followers + f];
                    let jets = &self.jets[node * layout.tubes + f + 1];
                    let adjoint = self.adjoint[node * followers + f];
                    let mut block: Block = [[0.0; local::COUNT]; local::COUNT];
                    let by_h = energy::add_hessian(facing, v[local::EK], jets, rule.weights[i], &mut block);
                    let mut along_h = rule.weights[i] * by_h + adjoint;
                    if let Some(gravity) = setting.loads.gravity {
                        let at = point(layout, e, i);
                        along_h += weight::add_hessian(
                            facing,
                            jets,
                            rule.weights[i],
                            &gravity,
                            &poses.rotation[at],
                            &poses.centre[at],
                            &mut block,
                        );
                    }
                    facing.add_second(&v, &state.leader_offset[node], &jets.offset, along_h, &mut block);
                    for (a, line) in block.iter().enumerate() {
                        self.work[State::row(f, a)] += adjoint * facing.dh[a];
                        for (b, value) in line.iter().enumerate() {
                            full[State::row(f, a) * rows + State::row(f, b)] += value;
                        }
                    }
                }
                if let Some(gravity) = setting.loads.gravity {
                    let at = point(layout, e, i);
                    let body = poses.rotation[at].transpose() * gravity;
                    let arm = gravity.dot(&poses.centre[at]) + leader.offset[0] * body.y;
                    full[local::X * rows + local::X] -= rule.weights[i]
                        * (leader.mass[2] * arm
                            + 2.0 * leader.mass[1] * leader.offset[1] * body.y
                            + leader.mass[0] * leader.offset[2] * body.y);
                }
                congruence(
                    &mut self.hessian,
                    &full,
                    rows,
                    &element.active,
                    length,
                    node,
                    state,
                    &mut self.matrix,
                );
                if moving {
                    self.moving_terms(layout, state, e, i);
                }
            }
        }
        self.full = full;
        for f in 0..followers {
            if *knob == RotationKnob::Base {
                let bend = robot.fields[f + 1].direction(state.joints[f][0], part_at_base(layout, f))[2];
                add_outer(
                    &mut self.hessian,
                    efforts.torque[f] * bend,
                    state.joint_row(0, f, 0),
                    state.joint_row(0, f, 0),
                );
            }
        }
    }

    /// Second derivatives that come from the element's length and from rest fields under a moving label.
    /// `self.work` holds F_v + a |h|_v of the node.
    fn moving_terms(&mut self, layout: &Layout, state: &State, e: usize, i: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (rows, followers, n_u) = (layout.rows(), layout.tubes - 1, state.unknowns);
        let (node, length) = (element.first_node + i, state.lengths[e]);
        let length_row = &state.length_rows[e * n_u..(e + 1) * n_u];
        let mut along = std::mem::take(&mut self.turn_row);
        along.clear();
        along.resize(n_u, 0.0);
        for row in 0..rows {
            axpy(&mut along, self.work[row], state.z_row(node, row));
        }
        for f in 0..followers {
            let (first, count) = element.modes[3 + f];
            let adjoint = self.angle_adjoint[node * followers + f];
            axpy(&mut along[first..first + count], adjoint, &rule.legendre[i * rule.n..i * rule.n + count]);
        }
        add_outer(&mut self.hessian, 1.0, length_row, &along);
        add_outer(&mut self.hessian, 1.0, &along, length_row);
        self.turn_row = along;
        let mut bend = self.work[local::KX] * state.leader_twist[node][1];
        for f in 0..followers {
            let rest = state.rest[node * followers + f];
            bend += self.work[State::row(f, local::TH)] * rest[2]
                + self.work[State::row(f, local::DTH)] * rest[3];
        }
        let label = state.z_row(node, local::X);
        add_outer(&mut self.hessian, length * bend, label, label);
    }
}

/// The part of follower `f` (0-based) that faces the plate.
fn part_at_base(layout: &Layout, f: usize) -> Part {
    if layout.elements[0].below[f + 1] { Part::Below } else { Part::Pattern }
}

/// hessian += length Zᵀ full Z at one node, over the rows of Z that are not zero.
#[allow(clippy::too_many_arguments)]
fn congruence(
    hessian: &mut [f64],
    full: &[f64],
    rows: usize,
    active: &[usize],
    length: f64,
    node: usize,
    state: &State,
    work: &mut Vec<f64>,
) {
    let n_u = state.unknowns;
    work.resize(n_u, 0.0);
    for &a in active {
        work.fill(0.0);
        for &b in active {
            let factor = length * full[a * rows + b];
            if factor != 0.0 {
                axpy(work, factor, state.z_row(node, b));
            }
        }
        for (i, &left) in state.z_row(node, a).iter().enumerate() {
            if left != 0.0 {
                axpy(&mut hessian[i * n_u..(i + 1) * n_u], left, work);
            }
        }
    }
}

/// hessian += factor · left ⊗ right.
pub(super) fn add_outer(hessian: &mut [f64], factor: f64, left: &[f64], right: &[f64]) {
    let n = right.len();
    for (i, &l) in left.iter().enumerate() {
        if l != 0.0 {
            axpy(&mut hessian[i * n..(i + 1) * n], factor * l, right);
        }
    }
}
