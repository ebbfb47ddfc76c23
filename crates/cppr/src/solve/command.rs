//! What a solve is asked for.

use super::Settings;
use crate::design::Robot;
use crate::statics::{LoadProblem, Loads, RotationKnob};
use std::fmt;

/// One degree of freedom of an actuator: either its motion or its effort is prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Prescribed motion: Δa (m), pull positive, or Ω (rad), right-handed about +X.
    Motion(f64),
    /// Prescribed effort: T (N), pull positive, or Υ (N m) conjugate to Ω.
    Effort(f64),
}

impl Drive {
    /// The prescribed number.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::Motion(value) | Self::Effort(value) => value,
        }
    }

    /// Is the motion prescribed, not the effort?
    #[must_use]
    pub fn is_motion(self) -> bool {
        matches!(self, Self::Motion(_))
    }

    /// The same kind of drive with another number.
    #[must_use]
    pub fn with_value(self, value: f64) -> Self {
        match self {
            Self::Motion(_) => Self::Motion(value),
            Self::Effort(_) => Self::Effort(value),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        self.with_value(factor * self.value())
    }

    /// Is the same thing prescribed, and the same number too where it is an effort?
    fn is_held_like(self, other: Self) -> bool {
        matches!((self, other), (Self::Motion(_), Self::Motion(_))) || self == other
    }
}

/// The actuator of one follower, below the baseplate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Translation: Δa_k or T_k.
    pub push_pull: Drive,
    /// Rotation: Ω_k (or −Δθ_k(0), see [`RotationKnob`]) or Υ_k.
    pub rotation: Drive,
}

impl Actuator {
    /// Do both differ in prescribed motions only?
    pub(crate) fn is_held_like(&self, other: &Self) -> bool {
        self.push_pull.is_held_like(other.push_pull) && self.rotation.is_held_like(other.rotation)
    }

    /// Both motors held where they are at rest.
    pub const HELD: Self = Self { push_pull: Drive::Motion(0.0), rotation: Drive::Motion(0.0) };

    /// Pulled (m), not turned.
    #[must_use]
    pub fn pulled(motion: f64) -> Self {
        Self { push_pull: Drive::Motion(motion), ..Self::HELD }
    }
}

/// The actuators of all followers and the loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// One per follower, tube 2 first.
    pub actuators: Vec<Actuator>,
    /// External loads.
    pub loads: Loads,
    /// What "rotation" means.
    pub knob: RotationKnob,
}

impl Command {
    /// All actuators held, no load.
    #[must_use]
    pub fn held(robot: &Robot) -> Self {
        Self {
            actuators: vec![Actuator::HELD; robot.follower_count()],
            loads: Loads::none(),
            knob: RotationKnob::Base,
        }
    }

    /// Every follower pulled by its own Δa (m), not turned, no load.
    #[must_use]
    pub fn pull(motions: &[f64]) -> Self {
        Self {
            actuators: motions.iter().map(|&a| Actuator::pulled(a)).collect(),
            loads: Loads::none(),
            knob: RotationKnob::Base,
        }
    }

    /// The same command with other loads.
    #[must_use]
    pub fn with_loads(self, loads: Loads) -> Self {
        Self { loads, ..self }
    }

    /// Every motion, effort and load multiplied by a factor: 0 is rest.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            actuators: self
                .actuators
                .iter()
                .map(|a| Actuator {
                    push_pull: a.push_pull.scaled(factor),
                    rotation: a.rotation.scaled(factor),
                })
                .collect(),
            loads: self.loads.scaled(factor),
            knob: self.knob,
        }
    }

    /// Copies without giving memory back.
    pub(crate) fn copy(&mut self, other: &Self) {
        self.actuators.clone_from(&other.actuators);
        self.loads.wrenches.clone_from(&other.loads.wrenches);
        self.loads.distributed.clone_from(&other.loads.distributed);
        self.loads.threads.clone_from(&other.loads.threads);
        self.loads.gravity = other.loads.gravity;
        self.knob = other.knob;
    }

    /// Checks a command against a robot and settings.
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self, robot: &Robot, settings: &Settings) -> Result<(), CommandProblem> {
        let (given, followers) = (self.actuators.len(), robot.follower_count());
        if given != followers {
            return Err(CommandProblem::Actuators { given, followers });
        }
        for (index, actuator) in self.actuators.iter().enumerate() {
            if !(actuator.push_pull.value().is_finite() && actuator.rotation.value().is_finite()) {
                return Err(CommandProblem::NotFinite { tube: index + 2 });
            }
            if settings.resolution.angle == 0 && actuator.rotation.value() != 0.0 {
                return Err(CommandProblem::AngleLocked { tube: index + 2 });
            }
            if let Drive::Motion(motion) = actuator.push_pull
                && motion.abs() >= robot.length()
            {
                return Err(CommandProblem::TooFar { tube: index + 2, motion, length: robot.length() });
            }
        }
        let r = settings.resolution;
        let flat = r.twist == 0 && r.bending_y == 0;
        if flat && !(robot.is_planar() && self.loads.is_planar()) {
            return Err(CommandProblem::NotPlanar);
        }
        self.loads.check(robot).map_err(CommandProblem::Load)
    }
}

/// A command that cannot be asked of a robot. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum CommandProblem {
    /// The number of actuators is not the number of followers.
    Actuators {
        /// Actuators given.
        given: usize,
        /// Followers of the robot.
        followers: usize,
    },
    /// A motion or effort is NaN or infinite.
    NotFinite {
        /// Tube number.
        tube: usize,
    },
    /// A follower is asked to slide by the robot's length or more.
    TooFar {
        /// Tube number.
        tube: usize,
        /// The motion (m).
        motion: f64,
        /// The robot's length (m).
        length: f64,
    },
    /// A rotation or torque is asked for, but the resolution holds the follower angles.
    AngleLocked {
        /// Tube number.
        tube: usize,
    },
    /// The planar resolution is asked to solve for a robot or loads that leave the plane.
    NotPlanar,
    /// A load is wrong.
    Load(LoadProblem),
    /// The equilibrium to start at is that of a robot with another number of tubes.
    Start {
        /// Tubes of the start.
        given: usize,
        /// Tubes of the robot.
        tubes: usize,
    },
}

impl fmt::Display for CommandProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Actuators { given, followers } => {
                write!(f, "{given} actuators are given for a robot with {followers} followers")
            }
            Self::NotFinite { tube } => {
                write!(f, "the actuator of tube {tube} is given a value that is not finite")
            }
            Self::TooFar { tube, motion, length } => write!(
                f,
                "tube {tube} cannot slide by {:.3} mm: the robot is only {:.3} mm long. Check the unit",
                motion * 1e3,
                length * 1e3
            ),
            Self::AngleLocked { tube } => {
                write!(
                    f,
                    "tube {tube} is to be turned, but the planar resolution holds the angles between tubes"
                )
            }
            Self::NotPlanar => {
                write!(
                    f,
                    "the planar resolution sees neither loads across the X-Y plane nor robots out of it"
                )
            }
            Self::Load(problem) => problem.fmt(f),
            Self::Start { given, tubes } => {
                write!(f, "the start is an equilibrium of {given} tubes, the robot has {tubes}")
            }
        }
    }
}

impl std::error::Error for CommandProblem {}
