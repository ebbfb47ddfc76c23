//! What a task cannot be.

use crate::axis::{Axis, Values, Variable};
use crate::bundle::BEHIND_THE_PLATE;
use crate::design::{DesignKeys, KeyProblem};
use crate::table::{Chunk, Verdict};
use crate::task::{Inputs, MOST_POSES, Plan, RobotSubject, Subject, Task};
use cppr::bundle::Friction;
use cppr::solve::{Command, SettingsProblem, Solver};
use std::collections::BTreeSet;
use std::fmt;

/// What is wrong with a task. `axis` is the name of its column.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskProblem {
    /// Nothing varies.
    NoAxis,
    /// There is no pose.
    NoPose,
    /// Too many poses: how many, and bytes per row.
    TooMany(u64, u64),
    /// Two axes set the same input.
    Twice(String),
    /// An axis has values that are not finite or a deviation that is not positive.
    Values(String),
    /// A distribution in a grid.
    NotSampled(String),
    /// An actuator, a load or a component that is not there.
    NoSuchInput(String),
    /// A design key.
    Key(KeyProblem),
    /// The robot cannot be solved with the settings.
    Settings(SettingsProblem),
    /// A margin of a robot with parts or joints.
    NoMargin,
    /// Friction in a robot that is solved with modes.
    NoFriction,
    /// A key of the file's friction varies where friction is left out.
    IdleFriction(String),
}

impl fmt::Display for TaskProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAxis => write!(f, "nothing varies: give a range to at least one input"),
            Self::NoPose => write!(f, "there is no pose to solve: every count must be at least 1"),
            Self::TooMany(rows, bytes) => write!(
                f,
                "these are {:.1e} poses, {:.1} GB of results; one sweep takes up to {MOST_POSES:.0e}. Lower the counts, or take --samples",
                *rows as f64,
                *rows as f64 * *bytes as f64 * 1e-9
            ),
            Self::Twice(axis) => write!(f, "{axis} varies twice"),
            Self::Values(axis) => {
                write!(f, "{axis}: ends and mean must be finite numbers and the deviation positive")
            }
            Self::NotSampled(axis) => {
                write!(f, "{axis}: a normal distribution has no grid of values; take samples")
            }
            Self::NoSuchInput(axis) => write!(f, "{axis}: the robot has no such actuator or load"),
            Self::Key(problem) => problem.fmt(f),
            Self::Settings(problem) => problem.fmt(f),
            Self::NoFriction => write!(f, "friction is that of a bundle: describe the robot as one"),
            Self::IdleFriction(key) => write!(f, "{key} varies, and this sweep leaves friction out"),
            Self::NoMargin => {
                write!(
                    f,
                    "a margin to instability is not known for robots with parts or joints, nor beside friction (0 leaves it out); the status says whether they are stable"
                )
            }
        }
    }
}

impl std::error::Error for TaskProblem {}

/// Rows whose discretisation error is computed.
const LOOKED_AT: u64 = 8;

impl Task {
    /// Checks the task as a whole; single poses that cannot be asked for are rows of the result.
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self) -> Result<(), TaskProblem> {
        match &self.subject {
            Subject::Robot(_) if self.friction.is_some() => return Err(TaskProblem::NoFriction),
            Subject::Robot(own) => own.settings.check(&own.robot).map_err(TaskProblem::Settings)?,
            Subject::Bundle(_) if self.margin => return Err(TaskProblem::NoMargin),
            Subject::Bundle(_) => {}
        }
        if let (None, Some(key)) =
            (self.friction, self.design_keys().iter().find(|key| key.starts_with("friction.")))
        {
            return Err(TaskProblem::IdleFriction((*key).to_owned()));
        }
        if self.axes.is_empty() {
            return Err(TaskProblem::NoAxis);
        }
        for (i, axis) in self.axes.iter().enumerate() {
            let name = axis.variable.column(self.loads());
            if self.axes[..i].iter().any(|other| same_input(&other.variable, &axis.variable)) {
                return Err(TaskProblem::Twice(name));
            }
            let sound = match axis.values {
                Values::Range { from, to, .. } => from.is_finite() && to.is_finite(),
                Values::Normal { mean, deviation } => {
                    mean.is_finite() && deviation.is_finite() && deviation > 0.0
                }
            };
            if !sound {
                return Err(TaskProblem::Values(name));
            }
            if self.plan == Plan::Grid && matches!(axis.values, Values::Normal { .. }) {
                return Err(TaskProblem::NotSampled(name));
            }
            let wrenches = self.loads().wrenches.len();
            let there = match axis.variable {
                Variable::Actuator(input) => match &self.subject {
                    Subject::Robot(own) => own.base.actuator(input.tube).is_some(),
                    Subject::Bundle(own) => (1..=own.design.tubes.len()).contains(&input.tube),
                },
                Variable::Force { wrench, component } | Variable::Moment { wrench, component } => {
                    wrench < wrenches && component < 3
                }
                Variable::Design(_) => true,
            };
            if !there {
                return Err(TaskProblem::NoSuchInput(name));
            }
        }
        let rows = self.rows();
        if rows == 0 {
            return Err(TaskProblem::NoPose);
        }
        if rows > MOST_POSES {
            return Err(TaskProblem::TooMany(rows, 8 * self.columns().len() as u64));
        }
        if self.varies_design() {
            DesignKeys::new(&self.robot_text, &self.design_keys()).map_err(TaskProblem::Key)?;
        }
        Ok(())
    }

    /// Why a row of a chunk could not be solved: what is wrong with its design, or what its robot cannot be asked. None where the status
    /// says all.
    #[must_use]
    pub fn reason(&self, chunk: &Chunk, row: usize) -> Option<String> {
        let verdict = Verdict::from_code(chunk.column(self.axes.len())[row])?;
        if !matches!(verdict, Verdict::InvalidDesign | Verdict::InvalidCommand) {
            return None;
        }
        let values: Vec<f64> = (0..self.axes.len()).map(|axis| chunk.column(axis)[row]).collect();
        match &self.subject {
            Subject::Robot(own) => match self.row(own, &values) {
                Ok((solver, command)) => solver.check(&command).err().map(|problem| problem.to_string()),
                Err(problem) => Some(problem),
            },
            Subject::Bundle(_) if verdict == Verdict::InvalidDesign => {
                self.keys().and_then(|mut keys| keys.bundle(&self.design_values(&values)).map(drop)).err()
            }
            Subject::Bundle(_) => Some(BEHIND_THE_PLATE.into()),
        }
    }

    /// Takes as many modes as some rows need whose tips are to be within `accuracy` times the length: rows spread from the first to the last, each solved
    /// from rest. Gives the greatest error that is left in them, as a part of the length, and how many of them have one. `None` where none is known, and of
    /// a bundle, whose table has an error in every row. Check the task first.
    pub fn resolve(&mut self, accuracy: f64) -> Option<(f64, usize)> {
        let chunking = self.chunking();
        let (mut greatest, mut known) = (0.0, 0);
        let apart = self.rows().saturating_sub(1).div_ceil(LOOKED_AT - 1).max(1);
        let last = self.rows().saturating_sub(1);
        let rows: BTreeSet<u64> = (0..LOOKED_AT).map(|i| last.min(i * apart)).collect();
        for row in rows {
            let Subject::Robot(own) = &self.subject else { return None };
            let mut values = vec![0.0; self.axes.len()];
            Inputs::new(self, &chunking).of(row, &mut values);
            let Ok((mut solver, command)) = self.row(own, &values) else { continue };
            let found = solver.settings_for(&[command], accuracy);
            if let Some(error) = found.error {
                greatest = f64::max(greatest, error / solver.robot().length());
                known += 1;
            }
            if let Subject::Robot(own) = &mut self.subject {
                own.settings = found.settings;
            }
        }
        (known > 0).then_some((greatest, known))
    }

    /// A solver of the robot of a row, and its command, from the values of all axes.
    fn row(&self, own: &RobotSubject, values: &[f64]) -> Result<(Solver, Command), String> {
        let robot = if self.varies_design() {
            self.keys()?.robot(&self.design_values(values))?
        } else {
            own.robot.clone()
        };
        let mut command = own.base.clone();
        for (axis, value) in self.axes.iter().zip(values) {
            axis.variable.put(&mut command, *value);
        }
        let solver = Solver::with_settings(&robot, own.settings).map_err(|problem| problem.to_string())?;
        Ok((solver, command))
    }

    fn keys(&self) -> Result<DesignKeys, String> {
        DesignKeys::new(&self.robot_text, &self.design_keys()).map_err(|problem| problem.to_string())
    }

    /// Those of the values of all axes that are of design keys.
    fn design_values(&self, values: &[f64]) -> Vec<f64> {
        let is_design = |axis: &Axis| matches!(axis.variable, Variable::Design(_));
        self.axes.iter().zip(values).filter(|(axis, _)| is_design(axis)).map(|(_, value)| *value).collect()
    }

    pub(crate) fn design_keys(&self) -> Vec<&str> {
        self.axes
            .iter()
            .filter_map(|axis| match &axis.variable {
                Variable::Design(key) => Some(key.as_str()),
                _ => None,
            })
            .collect()
    }

    /// The friction of rows of another design: what varies of it is as its file says, the rest as in all rows.
    pub(crate) fn varied(&self, written: Option<Friction>) -> Option<Friction> {
        let (common, written) = (self.friction?, written.or(self.friction)?);
        let from = |key: &str| if self.design_keys().contains(&key) { written } else { common };
        Some(Friction {
            coefficient: from("friction.coefficient").coefficient,
            guide: from("friction.guide_mm").guide,
        })
    }
}

/// Motion and effort of one freedom are the same input.
fn same_input(a: &Variable, b: &Variable) -> bool {
    match (a, b) {
        (Variable::Actuator(a), Variable::Actuator(b)) => a.is_same_freedom(*b),
        _ => a == b,
    }
}
