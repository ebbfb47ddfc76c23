//! A family of commands over the fraction λ: λ = 0 is its first command, λ = 1 its last.
//!
//! Motions, efforts and loads are affine in λ, and so are the conditions of equilibrium at fixed unknowns.

use crate::solve::input::tube_of;
use crate::solve::{Command, CommandProblem, Drive, Equilibrium, Freedom, Input, Solver};
use crate::statics::Loads;
use std::fmt;

/// What varies along a path, and in which unit its parameter is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// One actuator: Δa (m), Ω (rad), T (N) or Υ (N m).
    Actuator(Input),
    /// The factor of all loads.
    LoadFactor,
    /// The fraction of the way from one command to another.
    Fraction,
}

impl Parameter {
    /// What an actuator answers: the effort where its motion varies, the motion where its effort does. `None` for other
    /// parameters.
    #[must_use]
    pub fn conjugate(self, equilibrium: &Equilibrium) -> Option<f64> {
        let Self::Actuator(input) = self else { return None };
        Some(equilibrium.actuator(input.tube)?.get(input.conjugate().quantity()))
    }
}

/// Commands between a first and a last one.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    first: Command,
    last: Command,
    /// Loads that join those of `first`, multiplied by `share[0] + λ share[1]`.
    varying: Loads,
    share: [f64; 2],
    parameter: Parameter,
    /// The parameter at both ends.
    ends: [f64; 2],
}

/// A path that cannot be followed.
#[derive(Clone, Debug, PartialEq)]
pub enum FamilyProblem {
    /// First and last command prescribe the motion here and the effort there.
    Drives {
        /// Tube number.
        tube: usize,
    },
    /// First and last command mean different things by rotation.
    Rotations,
    /// There is no load to vary.
    NoLoad,
    /// An end of the path is NaN or infinite.
    NotFinite,
    /// Nothing varies: both ends are the same.
    Nothing,
    /// The command at one end cannot be asked of the robot.
    Command(CommandProblem),
    /// The equilibrium to start at is that of another robot or of other settings.
    OtherStart,
}

impl fmt::Display for FamilyProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drives { tube } => write!(
                f,
                "tube {tube} is driven by motion at one end of the path and by effort at the other; drive it one way"
            ),
            Self::Rotations => write!(f, "rotations mean different angles at the ends of the path"),
            Self::NoLoad => write!(f, "the load factor is to vary, but there is no load"),
            Self::NotFinite => write!(f, "an end of the path is not a finite number"),
            Self::Nothing => write!(f, "the path begins where it ends: nothing varies"),
            Self::Command(problem) => problem.fmt(f),
            Self::OtherStart => write!(
                f,
                "the equilibrium to start at was not found by this solver: its robot or its settings are others"
            ),
        }
    }
}

impl std::error::Error for FamilyProblem {}

impl Family {
    /// One actuator goes from its value in `command` to `to` (SI), driven as the command drives it.
    ///
    /// # Errors
    /// Where the robot has no such follower or the value is already there.
    pub fn actuator(command: Command, tube: usize, freedom: Freedom, to: f64) -> Result<Self, FamilyProblem> {
        let mut last = command.clone();
        let Some(actuator) = last.actuator_mut(tube) else {
            return Err(FamilyProblem::Command(command.no_such_tube(tube)));
        };
        let drive = actuator.drive_mut(freedom);
        let from = drive.value();
        *drive = drive.with_value(to);
        let is_motion = drive.is_motion();
        let parameter = Parameter::Actuator(Input { tube, freedom, is_motion });
        Self { first: command, last, varying: Loads::none(), share: [0.0; 2], parameter, ends: [from, to] }
            .checked()
    }

    /// All loads of a command go from `from` to `to` times their size.
    ///
    /// # Errors
    /// Where there is no load or the factor does not vary.
    pub fn load(command: Command, from: f64, to: f64) -> Result<Self, FamilyProblem> {
        if command.loads.is_empty() {
            return Err(FamilyProblem::NoLoad);
        }
        Self {
            first: Command { loads: Loads::none(), ..command.clone() },
            varying: command.loads.clone(),
            last: command,
            share: [from, to - from],
            parameter: Parameter::LoadFactor,
            ends: [from, to],
        }
        .checked()
    }

    /// Straight from one command to another: every motion, effort and load at once.
    ///
    /// # Errors
    /// Where the commands drive an actuator differently, or are the same.
    pub fn between(first: Command, last: Command) -> Result<Self, FamilyProblem> {
        let mut varying = Loads::none();
        if first.loads != last.loads {
            // Loads are linear in their size: one that goes fades out while another one comes.
            varying = first.loads.scaled(-1.0).joined(last.loads.clone());
        }
        let (parameter, ends) = (Parameter::Fraction, [0.0, 1.0]);
        Self { first, last, varying, share: [0.0, 1.0], parameter, ends }.checked()
    }

    fn checked(self) -> Result<Self, FamilyProblem> {
        if self.first.rotation_means != self.last.rotation_means {
            return Err(FamilyProblem::Rotations);
        }
        for (f, (a, b)) in self.first.actuators.iter().zip(&self.last.actuators).enumerate() {
            let same = |a: &Drive, b: &Drive| std::mem::discriminant(a) == std::mem::discriminant(b);
            if !(same(&a.push_pull, &b.push_pull) && same(&a.rotation, &b.rotation)) {
                return Err(FamilyProblem::Drives { tube: tube_of(f) });
            }
        }
        let [from, to] = self.ends;
        if !(from.is_finite() && to.is_finite()) {
            return Err(FamilyProblem::NotFinite);
        }
        let still = self.varying.is_empty() && self.first.actuators == self.last.actuators;
        if still || (to - from).abs() <= 0.0 {
            return Err(FamilyProblem::Nothing);
        }
        Ok(self)
    }

    /// Can both ends be asked of this robot?
    pub(super) fn check(&self, solver: &Solver) -> Result<(), FamilyProblem> {
        for end in [&self.first, &self.last] {
            solver.check(end).map_err(FamilyProblem::Command)?;
        }
        Ok(())
    }

    /// The command at a fraction.
    #[must_use]
    pub fn at(&self, fraction: f64) -> Command {
        let mut command = self.first.clone();
        let mix = |a: Drive, b: Drive| a.with_value(a.value() + fraction * (b.value() - a.value()));
        for (own, last) in command.actuators.iter_mut().zip(&self.last.actuators) {
            own.push_pull = mix(own.push_pull, last.push_pull);
            own.rotation = mix(own.rotation, last.rotation);
        }
        if !self.varying.is_empty() {
            let [at_first, slope] = self.share;
            command.loads = command.loads.joined(self.varying.scaled(at_first + fraction * slope));
        }
        command
    }

    /// What varies.
    #[must_use]
    pub fn parameter(&self) -> Parameter {
        self.parameter
    }

    /// The parameter at a fraction, in its own unit.
    #[must_use]
    pub fn value(&self, fraction: f64) -> f64 {
        let [from, to] = self.ends;
        from + fraction * (to - from)
    }

    /// Are all loads the gradient of a potential?
    pub(super) fn is_conservative(&self) -> bool {
        self.first.loads.is_conservative() && self.varying.is_conservative()
    }
}
