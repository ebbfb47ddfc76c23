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

use super::energy::{self, Inner};
use super::load::{Applied, Loads, Station, Wrench};
use crate::dense::{Lu, axpy};
use crate::design::Robot;
use crate::design::fields::{FieldJets, Part};
use crate::kinematics::follower::local;
use crate::kinematics::layout::{Joint, Layout};
use crate::kinematics::magnus::SecondDerivative;
use crate::kinematics::pose::{Poses, point};
use crate::kinematics::state::{Origin, State, part, row, split};
use crate::real::{Each, Real};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// What the conjugate of the actuation torque is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RotationMeans {
    /// The rotation Ω_k of the follower's base, as a motor turns it.
    #[default]
    Base,
    /// −Δθ_k(0): what the paper prescribes.
    RelativeAngle,
}

/// Actuation efforts and multipliers.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// 𝓛_uu, row-major; where it is `symmetric` nothing below the diagonal means anything.
    pub hessian: Vec<S>,
    pub symmetric: bool,
    /// Per follower: Δa_k and Ω_k (or −Δθ_k(0)).
    pub motions: Vec<[S; 2]>,
    /// Per follower: ∂Δa_k/∂u and ∂Ω_k/∂u.
    pub motion_rows: Vec<[Vec<S>; 2]>,
    /// Per edge: x_b and its row.
    pub edges: Vec<S>,
    pub edge_rows: Vec<Vec<S>>,
    /// Per node and follower: adjoint of |h| over the node's weight, the configurational force (N).
    pub adjoint: Vec<S>,
    pub(super) angle_adjoint: Vec<S>,
    /// Per node and row: generalised force of the local variable, the slope of 𝓛 by it, over ℓ.
    pub(super) local_forces: Vec<S>,
    /// Per element: slope of 𝓛 by ℓ.
    pub(super) by_length: Vec<S>,
    pub(crate) jets: Vec<FieldJets<S>>,
    /// Per node and follower.
    pub(super) energies: Vec<Inner<S>>,
    pub(super) values: Vec<S>,
    pub(super) slopes: Vec<S>,
    pub(crate) point_force: Vec<Vector3<S>>,
    pub(super) point_moment: Vec<Vector3<S>>,
    /// Per point: at nodes the internal force n (N) of all loads beyond, with the node's weight: what δc' is multiplied by.
    pub(super) internal: Vec<Vector3<S>>,
    /// Per point: moment of everything from there on.
    pub(super) moment: Vec<Vector3<S>>,
    pub(super) lu: Lu<S>,
    pub(super) matrix: Vec<S>,
    pub(super) work: Vec<S>,
    pub(super) spread: Vec<S>,
    pub(super) stretch_row: Vec<S>,
    pub(super) turn_row: Vec<S>,
    pub(super) block: Vec<S>,
    pub(super) form: SecondDerivative<S>,
    /// Per follower its base's direction at rest, and so where Ω is counted from.
    turn_at_rest: Vec<f64>,
    /// Of what `jets` and `turn_at_rest` are, as far as they depend on robot and layout alone.
    constants_of: Origin,
    pub(super) concentrated: Vec<(usize, Applied<S>)>,
}

/// What `assemble` reads.
pub(crate) struct Setting<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    /// The loads of every lane: of the same kinds at the same labels.
    pub loads: Each<'a, Loads>,
    pub rotation_means: RotationMeans,
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
        // The only load whose potential is assembled with the energies at the nodes; the others are forces and moments at points.
        let Loads { gravity, wrenches: _, distributed: _, threads: _ } = self.kinds();
        gravity.map(|_| self.vector(|loads| loads.gravity.unwrap_or_default()))
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
    // Gravity acts at the nodes, distributed forces at those that they reach.
    let Loads { wrenches, distributed: _, gravity: _, threads } = setting.kinds();
    all.clear();
    for (i, wrench) in wrenches.iter().enumerate() {
        let at = match wrench.station {
            Station::Tip => Some(tip),
            Station::Label(label) => end_point(layout, coordinates, label),
        };
        // A load on the clamped first section does no work.
        if let Some(at) = at {
            let rotation = &poses.rotation[at];
            let of = |component: fn(&Wrench) -> Vector3<f64>| setting.vector(|l| component(&l.wrenches[i]));
            let [force, moment, point] = [of(|w| w.force), of(|w| w.moment), of(|w| w.point)];
            all.push((at, Applied::wrench(wrench.frame, rotation, &force, &moment, &point)));
        }
    }
    for i in 0..threads.len() {
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
    /// Energy, conditions and gradient at an evaluated state (and evaluated poses where there are loads).
    pub fn residual(
        &mut self,
        setting: &Setting,
        coordinates: &[S],
        state: &State<S>,
        poses: &Poses<S>,
        efforts: &Efforts<S>,
    ) {
        self.conditions(setting, state);
        self.nodes(setting, state, poses);
        self.adjoints(setting, state, efforts);
        self.collect(setting, state);
        if !setting.kinds().is_empty() {
            let mut concentrated = std::mem::take(&mut self.concentrated);
            applied(setting, poses, coordinates, &mut concentrated);
            self.collect_forces(setting, state, poses, &concentrated);
            self.concentrated = concentrated;
            self.collect_loads(setting, state, poses);
        }
        self.project(setting, state);
    }

    /// The Hessian and the rows of the conditions where `residual` has been, with the rows of state (and poses).
    pub fn tangent(&mut self, setting: &Setting, state: &State<S>, poses: &Poses<S>, efforts: &Efforts<S>) {
        self.hessian.clear();
        self.hessian.resize(state.unknowns * state.unknowns, S::zero());
        self.symmetric = setting.kinds().is_conservative();
        self.condition_rows(setting, state);
        self.second_derivatives(setting, state, poses, efforts);
        if !setting.kinds().is_empty() {
            self.load_hessian(setting, state, poses);
        }
    }

    /// The second derivative of 𝓛 by unknowns i and j.
    pub fn second(&self, i: usize, j: usize) -> S {
        let (i, j) = if self.symmetric { (i.min(j), i.max(j)) } else { (i, j) };
        self.hessian[i * self.gradient.len() + j]
    }

    /// Actuator positions and edges.
    fn conditions(&mut self, setting: &Setting, state: &State<S>) {
        let Setting { robot, layout, rotation_means, .. } = setting;
        let followers = layout.tubes - 1;
        self.motions.resize(followers, [S::zero(); 2]);
        if self.constants_of != Origin::of(robot, layout) {
            let leader = robot.fields()[0].direction(0.0, Part::Pattern)[0];
            let at_rest = |f: usize| leader + PI - robot.rest_angle(f + 1, 0.0)[0];
            self.turn_at_rest.clear();
            self.turn_at_rest.extend((0..followers).map(at_rest));
        }
        for f in 0..followers {
            let [face, angle] = state.joints[f];
            let position = match rotation_means {
                RotationMeans::Base => {
                    let own = robot.fields()[f + 1].direction(face, part_at_base(layout, f));
                    -angle - own[0] + self.turn_at_rest[f]
                }
                RotationMeans::RelativeAngle => -angle,
            };
            self.motions[f] = [face, position];
        }
        self.edges.resize(layout.edges.len(), S::zero());
        for (e, element) in layout.elements.iter().enumerate() {
            if let Joint::Edge { follower, unknown } = element.start {
                self.edges[unknown] = state.joints[e * followers + follower - 1][0];
            }
        }
    }

    /// Rows by u of the actuator positions and edges.
    pub fn condition_rows(&mut self, setting: &Setting, state: &State<S>) {
        let layout = setting.layout;
        self.motion_rows.resize(layout.tubes - 1, [Vec::new(), Vec::new()]);
        for (f, [face_row, angle_row]) in self.motion_rows.iter_mut().enumerate() {
            let slope = turn_at_base(setting, state, f, 1);
            face_row.clear();
            face_row.extend_from_slice(state.joint_row(0, f, 0));
            angle_row.clear();
            let rows = state.joint_row(0, f, 1).iter().zip(state.joint_row(0, f, 0));
            angle_row.extend(rows.map(|(t, x)| -*t - slope * *x));
        }
        self.edge_rows.resize(layout.edges.len(), Vec::new());
        for (e, element) in layout.elements.iter().enumerate() {
            if let Joint::Edge { follower, unknown } = element.start {
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
        // Fields at labels that do not move, and fields that are constant, are still there from the last time.
        let origin = Origin::of(robot, layout);
        let (fresh, moving) = (self.constants_of != origin, !layout.edges.is_empty());
        self.constants_of = origin;
        self.values.clear();
        self.values.resize(layout.nodes, S::zero());
        self.slopes.clear();
        self.slopes.resize(layout.nodes * rows, S::zero());
        self.jets.resize(layout.nodes * layout.tubes, FieldJets::default());
        self.energies.resize(layout.nodes * followers, Inner::default());
        self.elastic = S::zero();
        for (e, element) in layout.elements.iter().enumerate() {
            let rule = &layout.rules[element.rule];
            for i in 0..rule.n {
                let node = element.first_node + i;
                let weight = rule.weights[i];
                let jets = &mut self.jets[node * layout.tubes..(node + 1) * layout.tubes];
                let own = &state.local[node * rows..(node + 1) * rows];
                if fresh || moving {
                    jets[0] = robot.fields()[0].jets(own[local::X], Part::Pattern);
                }
                let (energy, gradient) = energy::leader(&jets[0], own);
                let mut value = energy;
                let slopes = &mut self.slopes[node * rows..(node + 1) * rows];
                for (slope, g) in slopes.iter_mut().zip(gradient) {
                    *slope += g * weight;
                }
                for f in 0..followers {
                    let fields = &robot.fields()[f + 1];
                    let part = part(element, f + 1);
                    if fresh || !fields.is_constant(part) {
                        jets[f + 1] = fields.jets(own[row(f, local::FACE)], part);
                    }
                    let facing = &state.facing[node * followers + f];
                    let inner = energy::inner(facing, own[row(f, local::EK)], &jets[f + 1]);
                    value += inner.value();
                    if let Some((leader, own)) = split(slopes, f) {
                        let gradient = inner.gradient(facing);
                        let (before, after) = gradient.split_at(local::TH);
                        axpy(leader, S::splat(weight), before);
                        axpy(own, S::splat(weight), after);
                    }
                    self.energies[node * followers + f] = inner;
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
}

/// The part of follower `f` (0-based) that faces the plate.
fn part_at_base(layout: &Layout, f: usize) -> Part {
    part(&layout.elements[0], f + 1)
}

/// Derivative of order 1 or 2 of a follower's direction φ_k at the plate, as far as its rotation feels it.
pub(super) fn turn_at_base<S: Real>(setting: &Setting, state: &State<S>, f: usize, order: usize) -> S {
    match setting.rotation_means {
        RotationMeans::Base => {
            let fields = &setting.robot.fields()[f + 1];
            fields.direction(state.joints[f][0], part_at_base(setting.layout, f))[order]
        }
        RotationMeans::RelativeAngle => S::zero(),
    }
}

/// hessian += factor · left ⊗ right, over the first unknowns where the rows are shorter.
pub(super) fn add_outer<S: Real>(hessian: &mut [S], n_u: usize, factor: S, left: &[S], right: &[S]) {
    for (i, &l) in left.iter().enumerate() {
        if !l.vanishes() {
            axpy(&mut hessian[i * n_u..i * n_u + right.len()], factor * l, right);
        }
    }
}
