//! What a solve is asked for.

use super::Settings;
use super::input::{Freedom, Input, follower_of, tube_of};
use crate::design::Robot;
use crate::statics::{LoadPart, LoadProblem, Loads, RotationMeans};
use std::fmt;

/// One degree of freedom of an actuator: either its motion or its effort is prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
        self.motion().is_some()
    }

    /// The prescribed motion, where that is what is prescribed.
    #[must_use]
    pub fn motion(self) -> Option<f64> {
        match self {
            Self::Motion(motion) => Some(motion),
            Self::Effort(_) => None,
        }
    }

    /// The prescribed effort, where that is what is prescribed.
    #[must_use]
    pub fn effort(self) -> Option<f64> {
        match self {
            Self::Motion(_) => None,
            Self::Effort(effort) => Some(effort),
        }
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Actuator {
    /// Translation: Δa_k or T_k.
    pub push_pull: Drive,
    /// Rotation: Ω_k (or −Δθ_k(0), see [`RotationMeans`]) or Υ_k.
    pub rotation: Drive,
}

impl Actuator {
    /// Do both differ in prescribed motions only?
    pub(crate) fn is_held_like(&self, other: &Self) -> bool {
        self.push_pull.is_held_like(other.push_pull) && self.rotation.is_held_like(other.rotation)
    }

    /// Both motors held where they are at rest.
    pub const HELD: Self = Self { push_pull: Drive::Motion(0.0), rotation: Drive::Motion(0.0) };

    /// The drive of a degree of freedom.
    #[must_use]
    pub fn drive(&self, freedom: Freedom) -> Drive {
        match freedom {
            Freedom::PushPull => self.push_pull,
            Freedom::Rotation => self.rotation,
        }
    }

    /// The drive of a degree of freedom, to be changed.
    pub fn drive_mut(&mut self, freedom: Freedom) -> &mut Drive {
        match freedom {
            Freedom::PushPull => &mut self.push_pull,
            Freedom::Rotation => &mut self.rotation,
        }
    }

    /// Pulled (m), not turned.
    #[must_use]
    pub fn pulled(motion: f64) -> Self {
        Self { push_pull: Drive::Motion(motion), ..Self::HELD }
    }
}

/// The actuators of all followers and the loads.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Command {
    /// One per follower, tube 2 first.
    pub actuators: Vec<Actuator>,
    /// External loads.
    pub loads: Loads,
    /// What "rotation" means.
    pub rotation_means: RotationMeans,
}

impl Command {
    /// All actuators held, no load.
    #[must_use]
    pub fn held(robot: &Robot) -> Self {
        Self {
            actuators: vec![Actuator::HELD; robot.follower_count()],
            loads: Loads::none(),
            rotation_means: RotationMeans::Base,
        }
    }

    /// Every follower pulled by its own Δa (m), not turned, no load.
    #[must_use]
    pub fn pull(motions: &[f64]) -> Self {
        Self {
            actuators: motions.iter().map(|&a| Actuator::pulled(a)).collect(),
            loads: Loads::none(),
            rotation_means: RotationMeans::Base,
        }
    }

    /// The actuator of a tube, by its number; `None` for the leader and for tubes that are not there.
    #[must_use]
    pub fn actuator(&self, tube: usize) -> Option<&Actuator> {
        self.actuators.get(follower_of(tube)?)
    }

    /// The actuator of a tube, by its number, to be changed.
    pub fn actuator_mut(&mut self, tube: usize) -> Option<&mut Actuator> {
        self.actuators.get_mut(follower_of(tube)?)
    }

    /// That a tube is no follower.
    #[must_use]
    pub fn no_such_tube(&self, tube: usize) -> CommandProblem {
        CommandProblem::NoSuchTube { tube, tubes: self.actuators.len() + 1 }
    }

    /// All inputs with what is prescribed: push-pull and rotation of tube 2, then of tube 3, …
    pub fn inputs(&self) -> impl Iterator<Item = (Input, f64)> + '_ {
        inputs(&self.actuators)
    }

    /// Prescribes a value (m, rad, N or N m).
    ///
    /// # Errors
    /// Where there is no such follower.
    pub fn set(&mut self, input: Input, value: f64) -> Result<(), CommandProblem> {
        let problem = self.no_such_tube(input.tube);
        *self.actuator_mut(input.tube).ok_or(problem)?.drive_mut(input.freedom) = input.prescribed(value);
        Ok(())
    }

    /// What is prescribed of an input, whether as motion or as effort.
    #[must_use]
    pub fn value(&self, input: Input) -> Option<f64> {
        Some(self.actuator(input.tube)?.drive(input.freedom).value())
    }

    /// The same command with one input at another value; an input that is not there changes nothing.
    pub(crate) fn with_input(&self, input: Input, value: f64) -> Self {
        let mut command = self.clone();
        if let Some(actuator) = command.actuator_mut(input.tube) {
            *actuator.drive_mut(input.freedom) = input.prescribed(value);
        }
        command
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
            rotation_means: self.rotation_means,
        }
    }

    /// Copies without giving memory back.
    pub(crate) fn copy(&mut self, other: &Self) {
        let Self { actuators, loads, rotation_means } = other;
        self.actuators.clone_from(actuators);
        self.loads.copy(loads);
        self.rotation_means = *rotation_means;
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
                return Err(CommandProblem::NotFinite { tube: tube_of(index) });
            }
            if settings.resolution.angle == 0 && actuator.rotation.value() != 0.0 {
                return Err(CommandProblem::AngleLocked { tube: tube_of(index) });
            }
            if let Some(motion) = actuator.push_pull.motion()
                && motion.abs() >= robot.length()
            {
                return Err(CommandProblem::TooFar { tube: tube_of(index), motion, length: robot.length() });
            }
            if let Some(motion) = actuator.push_pull.motion()
                && motion.abs() > 0.0
                && !settings.can_slide(robot, index)
            {
                return Err(CommandProblem::NoLever { tube: tube_of(index) });
            }
        }
        let r = settings.resolution;
        let flat = r.twist == 0 && r.bending_y == 0;
        if flat && !robot.is_planar() {
            return Err(CommandProblem::NotPlanar(None));
        }
        if let Some(part) = self.loads.out_of_plane().filter(|_| flat) {
            return Err(CommandProblem::NotPlanar(Some(part)));
        }
        self.loads.check(robot).map_err(CommandProblem::Load)
    }
}

/// The inputs of actuators, with what is prescribed.
pub(crate) fn inputs(actuators: &[Actuator]) -> impl Iterator<Item = (Input, f64)> + '_ {
    actuators.iter().enumerate().flat_map(|(follower, actuator)| {
        Freedom::BOTH.map(|freedom| {
            let drive = actuator.drive(freedom);
            let input = Input { tube: tube_of(follower), freedom, is_motion: drive.is_motion() };
            (input, drive.value())
        })
    })
}

/// A command that cannot be asked of a robot. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum CommandProblem {
    /// There is no such follower.
    NoSuchTube {
        /// Tube number asked for.
        tube: usize,
        /// Tubes of the robot.
        tubes: usize,
    },
    /// A degree of freedom is prescribed for the second time, by motion or by effort.
    Twice {
        /// What was given first.
        earlier: Input,
        /// What was to be given after it.
        later: Input,
    },
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
    /// A follower that bends nothing is asked to slide, but the tubes do not stretch.
    NoLever {
        /// Tube number.
        tube: usize,
    },
    /// A rotation or torque is asked for, but the resolution holds the follower angles.
    AngleLocked {
        /// Tube number.
        tube: usize,
    },
    /// The planar resolution is asked to solve for loads that leave the plane, or for a robot that does (`None`).
    NotPlanar(Option<LoadPart>),
    /// A load is wrong.
    Load(LoadProblem),
    /// The equilibrium to start at is that of a robot with another number of tubes.
    OtherStart {
        /// Tubes of the start.
        given: usize,
        /// Tubes of the robot.
        tubes: usize,
    },
}

impl fmt::Display for CommandProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchTube { tubes: 1, .. } => {
                write!(f, "this robot has only its leader, nothing to actuate")
            }
            Self::NoSuchTube { tube: 0, .. } => {
                write!(f, "tube 0 is no follower: tubes are numbered from 1, followers from 2")
            }
            Self::NoSuchTube { tube: 1, .. } => {
                write!(f, "tube 1 is no follower: tube 1 is the leader, which is fixed in the baseplate")
            }
            Self::NoSuchTube { tube, tubes: 2 } => {
                write!(f, "there is no tube {tube}; the only follower of this robot is tube 2")
            }
            Self::NoSuchTube { tube, tubes } => {
                write!(f, "there is no tube {tube}; the followers of this robot are 2 to {tubes}")
            }
            Self::Twice { earlier, later } => {
                let what = match later.freedom {
                    Freedom::PushPull => "motion or force",
                    Freedom::Rotation => "rotation or torque",
                };
                write!(f, "tube {} has its {what} given twice", later.tube)?;
                if earlier.is_motion == later.is_motion {
                    return Ok(());
                }
                let [first, second] = [earlier, later].map(|input| input.quantity().keyword);
                write!(f, ", by both {first} and {second}: give one of them")
            }
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
            Self::NoLever { tube } => write!(
                f,
                "tube {tube} cannot be pulled or pushed: its centroid and that of tube 1 lie on the axis all along, so that nothing \
                 bends and the tubes would have to stretch. Turn it, or let the tubes stretch (stretch, a setting)"
            ),
            Self::AngleLocked { tube } => {
                write!(
                    f,
                    "tube {tube} is to be turned, but the planar resolution holds the angles between tubes"
                )
            }
            Self::NotPlanar(None) => {
                write!(
                    f,
                    "the notches of this robot bend it in space, which the planar resolution does not see"
                )
            }
            Self::NotPlanar(Some(part)) => {
                write!(f, "{part} acts out of the plane X-Y, which the planar resolution does not see")
            }
            Self::Load(problem) => problem.fmt(f),
            Self::OtherStart { given, tubes } => {
                write!(f, "the start is an equilibrium of {given} tubes, the robot has {tubes}")
            }
        }
    }
}

impl std::error::Error for CommandProblem {}
