//! What is asked of a robot: inputs, loads and options as a command and settings of the mechanics.

use crate::model::Model;
use crate::names::{cppr_input, cppr_option};
use cppr::Vector3;
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Formulation, Settings};
use cppr::statics::{Loads, RotationMeans, Wrench};
use std::fmt;

/// Why an input does not belong where it is given. Said without allocating.
#[derive(Debug)]
pub(crate) enum Misplaced {
    NoTube { tube: u32, tubes: usize },
    Leader,
    OnTip { tube: u32 },
}

impl fmt::Display for Misplaced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoTube { tube, tubes } => {
                write!(f, "there is no tube {tube}; this robot has tubes 1 to {tubes}")
            }
            Self::Leader => write!(f, "tube 1 is the leader, clamped in the baseplate: it has no actuator"),
            Self::OnTip { tube } => write!(f, "an input on the tip belongs to no tube: give 0, not {tube}"),
        }
    }
}

/// What is asked of a robot.
#[derive(Clone)]
pub(crate) struct Asked {
    pub command: Command,
    /// The first wrench is that of the tip inputs.
    has_tip: bool,
    pub settings: Settings,
    planar: bool,
    stretch: bool,
    refine: f64,
    /// Error of the tip that is accepted, as a part of the length; 0 takes any.
    pub accuracy: f64,
    /// Error that a step of the integration may make in a loop.
    pub loop_tolerance: f64,
}

/// Default of [`Asked::loop_tolerance`], and the greatest.
pub(crate) const LOOP_TOLERANCE: f64 = 1e-8;
const LOOSEST: f64 = 1e-4;

impl Asked {
    /// Of a robot with so many actuators.
    pub fn new(actuators: usize) -> Self {
        let actuators = vec![Actuator::HELD; actuators];
        Self {
            command: Command { actuators, loads: Loads::none(), rotation_means: RotationMeans::Base },
            has_tip: false,
            settings: Settings::default(),
            planar: false,
            stretch: false,
            refine: 1.0,
            accuracy: 0.0,
            loop_tolerance: LOOP_TOLERANCE,
        }
    }

    /// All loads; add to them at their ends.
    pub fn loads(&mut self) -> &mut Loads {
        &mut self.command.loads
    }

    fn resolution(&self) -> Resolution {
        let base = if self.planar { Resolution::PLANAR } else { Resolution::SPATIAL };
        // Only factors that there are were taken.
        let base = base.multiplied(self.refine).unwrap_or(base);
        if self.stretch { base.with_stretch() } else { base }
    }

    /// Takes all loads away, those of the tip inputs too.
    pub fn unload(&mut self) {
        let Loads { wrenches, distributed, gravity, threads } = &mut self.command.loads;
        wrenches.clear();
        distributed.clear();
        *gravity = None;
        threads.clear();
        self.has_tip = false;
    }

    pub fn hold(&mut self) {
        self.command.actuators.fill(Actuator::HELD);
        self.unload();
    }

    /// Makes room for an input on the tip.
    pub fn provide(&mut self, input: cppr_input) {
        if !is_of_tube(input) && !self.has_tip {
            self.command.loads.wrenches.insert(0, Wrench::tip_force(Vector3::zeros()));
            self.has_tip = true;
        }
    }

    /// The same with the usual number of modes.
    pub fn usual(&self) -> Self {
        let mut own = Self { refine: 1.0, ..self.clone() };
        own.settings.resolution = own.resolution();
        own
    }

    /// Sets an option; false where its number cannot be. Whether the settings make sense for a robot is left to its solver.
    pub fn choose(&mut self, option: cppr_option, value: f64) -> bool {
        let count = |most: f64| {
            let fits = value.fract().abs() <= 0.0 && (1.0..=most).contains(&value);
            // Whole and small.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            fits.then_some(value as usize)
        };
        let flag = || count(1.0).map(|_| true).or((value.abs() <= 0.0).then_some(false));
        let own = &mut self.settings;
        let done = match option {
            cppr_option::Planar => into(&mut self.planar, flag()),
            cppr_option::Stretch => into(&mut self.stretch, flag()),
            cppr_option::Refine => {
                into(&mut self.refine, Resolution::SPATIAL.multiplied(value).map(|_| value))
            }
            cppr_option::Tolerance => into(&mut own.tolerance, Some(value)),
            cppr_option::Iterations => into(&mut own.iterations, count(1e5)),
            cppr_option::SmallestStep => into(&mut own.smallest_step, Some(value)),
            cppr_option::Accuracy => {
                into(&mut self.accuracy, Some(value).filter(|part| (0.0..=1.0).contains(part)))
            }
            cppr_option::LoopTolerance => {
                into(&mut self.loop_tolerance, Some(value).filter(|own| *own > 0.0 && *own <= LOOSEST))
            }
            cppr_option::Printed => {
                let kinds = [Formulation::Consistent, Formulation::Printed];
                into(&mut own.formulation, flag().map(|on| kinds[usize::from(on)]))
            }
            cppr_option::RelativeAngle => {
                let kinds = [RotationMeans::Base, RotationMeans::RelativeAngle];
                into(&mut self.command.rotation_means, flag().map(|on| kinds[usize::from(on)]))
            }
        };
        self.settings.resolution = self.resolution();
        done
    }
}

fn into<T>(place: &mut T, value: Option<T>) -> bool {
    value.map(|value| *place = value).is_some()
}

fn is_of_tube(input: cppr_input) -> bool {
    matches!(input, cppr_input::Pull | cppr_input::Rotate | cppr_input::Tension | cppr_input::Torque)
}

/// Place of an input's actuator in a command; 0 for an input on the tip.
pub(crate) fn place(model: &Model, input: cppr_input, tube: u32) -> Result<usize, Misplaced> {
    match (is_of_tube(input), tube) {
        (true, _) => model.actuator(tube),
        (false, 0) => Ok(0),
        (false, _) => Err(Misplaced::OnTip { tube }),
    }
}

/// Prescribes a number at a [`place()`]; a command with inputs on the tip begins its wrenches with them.
pub(crate) fn put(command: &mut Command, input: cppr_input, place: usize, value: f64) {
    let tip = command.loads.wrenches.first_mut();
    match (input, command.actuators.get_mut(place), tip) {
        (cppr_input::Pull, Some(own), _) => own.push_pull = Drive::Motion(value),
        (cppr_input::Tension, Some(own), _) => own.push_pull = Drive::Effort(value),
        (cppr_input::Rotate, Some(own), _) => own.rotation = Drive::Motion(value),
        (cppr_input::Torque, Some(own), _) => own.rotation = Drive::Effort(value),
        (cppr_input::TipForceX, _, Some(tip)) => tip.force.x = value,
        (cppr_input::TipForceY, _, Some(tip)) => tip.force.y = value,
        (cppr_input::TipForceZ, _, Some(tip)) => tip.force.z = value,
        (cppr_input::TipMomentX, _, Some(tip)) => tip.moment.x = value,
        (cppr_input::TipMomentY, _, Some(tip)) => tip.moment.y = value,
        (cppr_input::TipMomentZ, _, Some(tip)) => tip.moment.z = value,
        // Neither `place` nor `Asked::provide` leaves it to this.
        (_, _, _) => {}
    }
}
