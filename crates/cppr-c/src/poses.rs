//! Many poses: what varies put into commands, what is wanted read into rows.

use crate::asked::{Asked, place, put};
use crate::bundle_poses;
use crate::modal::Modal;
use crate::model::Model;
use crate::names::{cppr_input, cppr_value};
use crate::session::{Refused, Work};
use crate::values::{Reader, size};
use cppr::analysis::Sensitivity;
use cppr::many::{Solved, Start};
use cppr::solve::{Command, CommandProblem};
use cppr_sweep::{Memory, Poses};
use std::ops::ControlFlow;

/// Poses whose error is looked at, to take as many modes as they need.
const LOOKED_AT: usize = 8;

/// What varies from pose to pose.
pub(crate) struct Varied<'a> {
    /// Input and place of each column.
    columns: Vec<(cppr_input, usize)>,
    /// One row per pose.
    values: &'a [f64],
}

impl<'a> Varied<'a> {
    /// `inputs` are the columns of `values`, each of a tube.
    pub fn new(model: &Model, inputs: &[(cppr_input, u32)], values: &'a [f64]) -> Result<Self, String> {
        let mut columns: Vec<(cppr_input, usize)> = Vec::with_capacity(inputs.len());
        for (number, &(input, tube)) in inputs.iter().enumerate() {
            let own = place(model, input, tube).map_err(|problem| format!("column {number}: {problem}"))?;
            if columns.contains(&(input, own)) {
                return Err(format!("column {number} varies the same input as one before it"));
            }
            columns.push((input, own));
        }
        Ok(Self { columns, values })
    }

    /// What all poses have in common, with room for what varies.
    pub fn common(&self, asked: &Asked) -> Command {
        let mut asked = asked.clone();
        self.columns.iter().for_each(|column| asked.provide(column.0));
        asked.command
    }

    /// Some of so many poses, spread from the first to the last.
    fn some(&self, base: &Command, poses: usize) -> Vec<Command> {
        let last = poses.saturating_sub(1);
        let mut places: Vec<usize> = (0..LOOKED_AT).map(|i| last * i / (LOOKED_AT - 1)).collect();
        places.dedup();
        places.into_iter().map(|pose| self.command(base, pose)).collect()
    }

    /// That of one pose.
    fn command(&self, base: &Command, pose: usize) -> Command {
        let mut command = base.clone();
        self.put(pose, &mut command);
        command
    }

    /// All of so many poses, checked; the pose and the problem of one that cannot be asked.
    pub fn commands(
        &self,
        own: &Modal,
        base: &Command,
        poses: usize,
    ) -> Result<Vec<Command>, (usize, CommandProblem)> {
        let each = (0..poses).map(|pose| {
            let command = self.command(base, pose);
            own.solver.check(&command).map(|()| command).map_err(|problem| (pose, problem))
        });
        each.collect()
    }

    pub fn put(&self, pose: usize, command: &mut Command) {
        let width = self.columns.len();
        let row = self.values.iter().skip(pose * width);
        for (&(input, place), value) in self.columns.iter().zip(row) {
            put(command, input, place, *value);
        }
    }
}

/// Solves many poses on the threads of the current pool of rayon and writes `wanted` of each into its row of `out`, NaN before.
pub(crate) fn solve_many(
    model: &Model,
    work: &Work,
    asked: &Asked,
    start: Start,
    varied: &Varied,
    wanted: &[cppr_value],
    out: &mut [f64],
) -> Result<(), (usize, Refused)> {
    let width: usize = wanted.iter().map(|value| size(model, *value)).sum();
    let mut rows: Vec<&mut [f64]> = out.chunks_exact_mut(width.max(1)).collect();
    let base = varied.common(asked);
    match (model, work) {
        (Model::Modal { memory, .. }, Work::Modal(own)) => {
            let solver = own.for_many(asked, &varied.some(&base, rows.len()));
            let poses = Poses { solver: &solver, base: &base, start };
            solve_modal(model, memory, &poses, varied, wanted, &mut rows)
        }
        (_, Work::Bundle(own)) => {
            bundle_poses::solve_many(model, own, &base, start, varied, wanted, &mut rows)
        }
        // A session has the work of its model.
        (Model::Bundle(_), Work::Modal(_)) => Ok(()),
    }
}

fn solve_modal(
    model: &Model,
    memory: &Memory,
    poses: &Poses,
    varied: &Varied,
    wanted: &[cppr_value],
    rows: &mut [&mut [f64]],
) -> Result<(), (usize, Refused)> {
    let mut each = poses.base.clone();
    for pose in 0..rows.len() {
        varied.put(pose, &mut each);
        poses.solver.check(&each).map_err(|problem| (pose, Refused::Modal(problem)))?;
    }
    let _ = cppr_sweep::solve_many(
        poses,
        memory,
        rows,
        |pose, command| varied.put(pose, command),
        |_, row, solved| {
            // All commands have been checked.
            if let Ok(solved) = solved {
                write_row(model, solved, wanted, row);
            }
            ControlFlow::<()>::Continue(())
        },
    );
    Ok(())
}

fn write_row(model: &Model, mut solved: Solved<'_>, wanted: &[cppr_value], row: &mut [f64]) {
    let margin = wanted.contains(&cppr_value::Margin).then(|| solved.margin()).flatten();
    let (mut sensitivity, mut derived) = (Sensitivity::default(), None);
    let mut reader = Reader {
        found: solved.equilibrium,
        pose: Some(solved.tip),
        solver: solved.solver,
        sensitivity: &mut sensitivity,
        derived: &mut derived,
    };
    let mut rest = row;
    for &value in wanted {
        let (own, after) = rest.split_at_mut(size(model, value));
        if value == cppr_value::Margin {
            own.fill(margin.unwrap_or(f64::NAN));
        } else {
            // What there is not stays NaN.
            let _ = reader.read(value, own);
        }
        rest = after;
    }
}
