//! A command in the making: each degree of freedom is prescribed once at most, and problems are those of the core.

use super::command::{Command, CommandProblem};
use super::input::Input;
use crate::design::Robot;

/// A command of which options, keys or keywords prescribe one number after another. What is not prescribed stays as it was.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The command so far; loads are put here.
    pub command: Command,
    given: Vec<Input>,
}

impl Draft {
    /// All actuators held, no load.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        Self::of(Command::held(robot))
    }

    /// Changes of a command.
    #[must_use]
    pub fn of(command: Command) -> Self {
        Self { command, given: Vec::new() }
    }

    /// Prescribes a value (m, rad, N or N m).
    ///
    /// # Errors
    /// Where there is no such follower, or that freedom of it is prescribed already.
    pub fn set(&mut self, input: Input, value: f64) -> Result<(), CommandProblem> {
        if let Some(&earlier) = self.given.iter().find(|own| own.is_same_freedom(input)) {
            return Err(CommandProblem::Twice { earlier, later: input });
        }
        self.command.set(input, value)?;
        self.given.push(input);
        Ok(())
    }

    /// What has been prescribed.
    #[must_use]
    pub fn given(&self) -> &[Input] {
        &self.given
    }
}
