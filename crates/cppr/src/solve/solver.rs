//! The solver of one robot: what is asked goes in, equilibria and what they tell come out.

use super::system::Buffers;
use super::{Command, CommandProblem, Equilibrium, Settings, SettingsProblem};
use crate::design::Robot;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A robot, how it is solved, and every buffer that this takes.
///
/// Making one costs little; after its first solve later ones find their memory here. A solver derives what is asked of any
/// [`Equilibrium`], which knows its own robot; it finds that of the equilibrium solved last already evaluated.
///
/// Methods stand beside what they compute: solving in [`crate::solve`], everything that is derived of an equilibrium, paths
/// and inverse problems in [`crate::analysis`].
#[derive(Clone, Debug)]
pub struct Solver {
    pub(crate) robot: Robot,
    pub(crate) settings: Settings,
    pub(crate) buffers: Buffers,
    /// What an analysis has made of a robot (by serial number) and keeps for the next time.
    pub(crate) kept: Option<(u64, Arc<dyn Any + Send + Sync>)>,
}

impl Solver {
    /// Solves with default settings.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        Self { robot: robot.clone(), settings: Settings::default(), buffers: Buffers::default(), kept: None }
    }

    /// Solves with the given settings.
    ///
    /// # Errors
    /// Where the settings make no sense for this robot.
    pub fn with_settings(robot: &Robot, settings: Settings) -> Result<Self, SettingsProblem> {
        settings.check(robot)?;
        Ok(Self { settings, ..Self::new(robot) })
    }

    /// Whose equilibria are found.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// How.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Solves with other settings from now on.
    ///
    /// # Errors
    /// Where they make no sense for this robot; the old ones stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), SettingsProblem> {
        settings.check(&self.robot)?;
        self.settings = settings;
        Ok(())
    }

    /// Solves another robot from now on and keeps settings and buffers.
    ///
    /// # Errors
    /// Where the settings make no sense for that robot; the old one stays.
    pub fn set_robot(&mut self, robot: &Robot) -> Result<(), SettingsProblem> {
        self.settings.check(robot)?;
        self.robot = robot.clone();
        Ok(())
    }

    /// Takes over robot and settings of another solver, but not its buffers.
    pub fn copy_task(&mut self, other: &Self) {
        (self.robot, self.settings) = (other.robot.clone(), other.settings);
    }

    /// Can this be asked of the robot?
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self, command: &Command) -> Result<(), CommandProblem> {
        command.check(&self.robot, &self.settings)
    }

    /// The robot at rest, as a start for [`Solver::solve_into`].
    #[must_use]
    pub fn rest(&mut self) -> Equilibrium {
        Equilibrium::at_rest(&self.robot, &mut self.buffers, &self.settings)
    }

    /// Lets another thread end what takes many solves: safe ranges, searches for actuator values, paths, calibrations. Soon
    /// after the flag is set they return, and say that they were stopped. `None` takes the flag away.
    pub fn stop_by(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.buffers.stop = flag;
    }

    /// Has the flag been set? For loops of one's own over solves.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.buffers.is_stopped()
    }
}
