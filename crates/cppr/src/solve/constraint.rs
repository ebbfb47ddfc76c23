//! The conditions that join the gradient in the equations of equilibrium, as rows of one list.
//!
//! A condition c says value_c(u) = target_c. It has a row ∂value_c/∂u, a scale σ_c that makes it dimensionless, and an effort e_c
//! (the multiplier: what holds it, in N or N m), in units of ε_c. The equations of equilibrium are
//!
//! ```text
//! 𝓛_u / E_0 = 0 ,      σ_c (value_c − target_c) = 0   for every c
//! ```
//!
//! and e_c enters 𝓛 with −e_c value_c for an actuator (eq 4 of the theory: its work) and with +λ_b x_b for an edge; signs of σ
//! are such that the tangent of both blocks together is symmetric. Newton's method, lanes, continuation, derivatives and
//! stability all walk [`System::constraints`]; a new kind of condition is a new variant here, with what each function says of it.

use super::command::{Actuator, Command, Drive};
use super::input::Freedom;
use super::settings::Settings;
use super::system::{Scale, System};
use crate::design::Robot;
use crate::real::{Each, Real};
use crate::statics::assembly::{Assembly, Efforts};

/// One condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Constraint {
    /// The motion of an actuator is prescribed: Δa_k (m) or Ω_k (rad); its effort is T_k or Υ_k. Also a follower driven by
    /// force that stands at the plate, where its stiffness jumps: Δa_k = 0.
    Motion {
        /// 0 is the first.
        follower: usize,
        freedom: Freedom,
    },
    /// The part of a follower from below the plate begins at a joint of the layout: x_k(X_b) = 0; λ_b holds it there.
    Edge {
        /// Number among the layout's edges, and of its unknown X_b.
        edge: usize,
    },
}

impl Constraint {
    /// value_c at the configuration assembled last.
    pub fn value<S: Real>(self, assembly: &Assembly<S>) -> S {
        match self {
            Self::Motion { follower, freedom } => assembly.motions[follower][freedom as usize],
            Self::Edge { edge } => assembly.edges[edge],
        }
    }

    /// ∂value_c/∂u there.
    pub fn row<S: Real>(self, assembly: &Assembly<S>) -> &[S] {
        match self {
            Self::Motion { follower, freedom } => &assembly.motion_rows[follower][freedom as usize],
            Self::Edge { edge } => &assembly.edge_rows[edge],
        }
    }

    /// target_c of every lane.
    pub fn target<S: Real>(self, system: &System) -> S {
        match self {
            Self::Motion { follower, freedom } => {
                S::from_lanes(|l| system.actuators.0[l][follower].drive(freedom).value())
            }
            Self::Edge { .. } => S::zero(),
        }
    }

    /// σ_c.
    pub fn scale(self, scale: Scale) -> f64 {
        match self {
            Self::Motion { freedom: Freedom::PushPull, .. } => -1.0 / scale.length,
            Self::Motion { freedom: Freedom::Rotation, .. } => -1.0,
            Self::Edge { .. } => 1.0 / scale.length,
        }
    }

    /// Where e_c is kept.
    pub fn effort<S>(self, efforts: &mut Efforts<S>) -> &mut S {
        match self {
            Self::Motion { follower, freedom: Freedom::PushPull } => &mut efforts.tension[follower],
            Self::Motion { follower, freedom: Freedom::Rotation } => &mut efforts.torque[follower],
            Self::Edge { edge } => &mut efforts.edge[edge],
        }
    }

    /// ε_c.
    pub fn effort_unit(self, scale: Scale) -> f64 {
        match self {
            Self::Motion { freedom: Freedom::Rotation, .. } => scale.energy,
            Self::Motion { freedom: Freedom::PushPull, .. } | Self::Edge { .. } => {
                scale.energy / scale.length
            }
        }
    }
}

impl<'a> System<'a> {
    /// All conditions, in the order of their equations and efforts: prescribed motions, then edges.
    pub fn constraints(&self) -> impl Iterator<Item = Constraint> + Clone + use<'a> {
        let actuators = self.actuators.first();
        let motions = actuators.iter().enumerate().flat_map(|(follower, actuator)| {
            let held = move |freedom: &Freedom| actuator.drive(*freedom).is_motion();
            let motion = move |freedom| Constraint::Motion { follower, freedom };
            Freedom::BOTH.into_iter().filter(held).map(motion)
        });
        motions.chain((0..self.layout.edges.len()).map(|edge| Constraint::Edge { edge }))
    }
}

/// What actuators are solved with: those of a command, save that what cannot move needs no holding (a condition on it would be
/// empty): locked angles, and translations that bend nothing where nothing stretches; and that followers which stand at the plate
/// are held there. `standing` has a bit for each of these.
pub(crate) fn drives(
    robot: &Robot,
    command: &Command,
    settings: &Settings,
    standing: u64,
    drives: &mut Vec<Actuator>,
) {
    drives.clone_from(&command.actuators);
    for (f, actuator) in drives.iter_mut().enumerate() {
        if settings.resolution.angle == 0 {
            actuator.rotation = Drive::Effort(0.0);
        }
        if actuator.push_pull.is_motion() && !settings.can_slide(robot, f) {
            actuator.push_pull = Drive::Effort(0.0);
        }
        if standing >> f & 1 == 1 {
            actuator.push_pull = Drive::Motion(0.0);
        }
    }
}

/// Brings the efforts that are prescribed to their values.
pub(crate) fn prescribe<S: Real>(actuators: &Each<[Actuator]>, efforts: &mut Efforts<S>) {
    for (f, actuator) in actuators.first().iter().enumerate() {
        let value = |freedom| S::from_lanes(|l| actuators.0[l][f].drive(freedom).value());
        if !actuator.push_pull.is_motion() {
            efforts.tension[f] = value(Freedom::PushPull);
        }
        if !actuator.rotation.is_motion() {
            efforts.torque[f] = value(Freedom::Rotation);
        }
    }
}
