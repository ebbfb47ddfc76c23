//! Sweeps of bundles: robots with parts, joints, free tips or curved tubes.
//!
//! A grid is solved run by run of its last axis, every pose from its neighbour, where that gives no stable equilibrium from rest;
//! samples are solved from rest, one by one. Rows do not depend on threads: each run begins anew.

use crate::axis::{Axis, Variable};
use crate::chunking::Chunking;
use crate::format::csv;
use crate::halton::Halton;
use crate::solver::quaternion;
use crate::table::{Chunk, Column, ColumnKind, Verdict};
use crate::task::{Plan, STATE};
use cppr::bundle::Bundle;
pub use cppr::bundle::solve::load_behind_plate;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::solve::Quantity;
use rayon::ThreadPoolBuildError;
use rayon::prelude::*;
use std::io::Write;

/// Most poses of one sweep, which is held in memory.
pub const MOST_BUNDLE_POSES: u64 = 1_000_000;

/// A sweep of a bundle.
#[derive(Clone, Debug)]
pub struct BundleTask {
    /// The robot.
    pub bundle: Bundle,
    /// Its name.
    pub name: String,
    /// What all poses have in common.
    pub base: BundleCommand,
    /// Are the tubes' centroid lines extensible?
    pub stretch: bool,
    /// Actuators and loads that vary, slowest first; no design keys.
    pub axes: Vec<Axis>,
    /// Which poses; no list.
    pub plan: Plan,
}

impl BundleTask {
    /// Rows in all; saturates where they are beyond counting.
    #[must_use]
    pub fn rows(&self) -> u64 {
        match self.plan {
            Plan::Samples { count, .. } => count,
            _ => self.axes.iter().fold(1, |n: u64, axis| n.saturating_mul(axis.values.count())),
        }
    }

    /// The columns: inputs, status, tip, bend, length of the centreline, actuators of every tube, estimated error, Newton steps.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let number = |name: String| Column { name, kind: ColumnKind::Number };
        let mut columns: Vec<Column> =
            self.axes.iter().map(|axis| number(axis.variable.column(&self.base.loads))).collect();
        columns.push(Column { name: "status".into(), kind: ColumnKind::Status });
        let tip = ["tip_x_m", "tip_y_m", "tip_z_m", "tip_qw", "tip_qx", "tip_qy", "tip_qz"];
        columns.extend(tip.map(|name| number(name.into())));
        columns.extend(["bend_angle_rad", "length_m"].map(|name| number(name.into())));
        for tube in 1..=self.base.drives.len() {
            columns.extend(STATE.map(|quantity| number(format!("tube{tube}_{}", quantity.column()))));
        }
        columns.push(number("tip_error_m".into()));
        columns.push(Column { name: "newton_steps".into(), kind: ColumnKind::Count });
        columns
    }

    /// Solves all poses on `threads` threads (0: as many as the machine has); `done` is told how many more are solved.
    ///
    /// # Errors
    /// Where threads cannot be started.
    pub fn solve(&self, threads: usize, done: impl Fn(u64) + Sync) -> Result<Chunk, ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let rows = self.rows();
        let run = match self.plan {
            Plan::Samples { .. } => 1,
            _ => self.axes.last().map_or(1, |axis| axis.values.count()).max(1),
        };
        let width = self.columns().len();
        let solved: Vec<Vec<f64>> = pool.install(|| {
            let starts: Vec<u64> = (0..rows / run).map(|number| number * run).collect();
            let solve = |start: u64| {
                let values = self.run(start..start + run);
                done(run);
                values
            };
            starts.into_par_iter().map(solve).collect()
        });
        // At most a million.
        #[allow(clippy::cast_possible_truncation)]
        let rows = rows as usize;
        let mut chunk = Chunk { number: 0, first_row: 0, rows, values: vec![f64::NAN; rows * width] };
        for (index, value) in solved.into_iter().flatten().enumerate() {
            chunk.set(index % width, index / width, value);
        }
        Ok(chunk)
    }

    /// The rows of successive poses, one behind the other.
    fn run(&self, rows: std::ops::Range<u64>) -> Vec<f64> {
        let mut solver = BundleSolver::new(&self.bundle).with_stretch(self.stretch);
        let mut before: Option<BundleEquilibrium> = None;
        let mut table = Vec::new();
        for row in rows {
            let inputs = self.inputs(row);
            let command = self.command(&inputs);
            if self.bundle.joint_behind_plate(&command.drives).is_some() {
                table.extend(inputs);
                self.refuse(Verdict::InvalidCommand, &mut table);
                continue;
            }
            let near = before.take().map(|start| solver.solve_from(&command, &start));
            let found = match near.filter(|found| found.converged && found.stable) {
                Some(found) => found,
                None => solver.solve(&command),
            };
            table.extend(inputs);
            self.write(&command, &found, &mut table);
            before = found.converged.then_some(found);
        }
        table
    }

    /// Values of all axes in a row.
    fn inputs(&self, row: u64) -> Vec<f64> {
        if let Plan::Samples { seed, .. } = self.plan {
            let halton = Halton::new(self.axes.len(), seed);
            let axes = self.axes.iter().enumerate();
            return axes.map(|(j, axis)| axis.values.quantile(halton.at(row, j))).collect();
        }
        let counts: Vec<u64> = self.axes.iter().map(|axis| axis.values.count()).collect();
        let mut digits = vec![0; counts.len()];
        Chunking::new(&counts).digits(row, &mut digits);
        self.axes.iter().zip(digits).map(|(axis, digit)| axis.values.at(digit)).collect()
    }

    fn command(&self, inputs: &[f64]) -> BundleCommand {
        let mut command = self.base.clone();
        for (axis, &value) in self.axes.iter().zip(inputs) {
            match axis.variable {
                Variable::Actuator(input) => command = command.with_input(input, value),
                Variable::Force { wrench, component } => {
                    if let Some(wrench) = command.loads.wrenches.get_mut(wrench) {
                        wrench.force[component] = value;
                    }
                }
                Variable::Moment { wrench, component } => {
                    if let Some(wrench) = command.loads.wrenches.get_mut(wrench) {
                        wrench.moment[component] = value;
                    }
                }
                Variable::Design(_) => {}
            }
        }
        command
    }

    /// Verdict of a row and, where there is an equilibrium, its numbers.
    fn write(&self, command: &BundleCommand, found: &BundleEquilibrium, table: &mut Vec<f64>) {
        let verdict = match (found.converged, found.stable) {
            (false, _) => Verdict::PathEnds,
            _ if load_behind_plate(command, found).is_some() => Verdict::InvalidCommand,
            (true, true) => Verdict::Converged,
            (true, false) => Verdict::Unstable,
        };
        if !verdict.is_equilibrium() {
            self.refuse(verdict, table);
            return;
        }
        table.push(f64::from(verdict.code()));
        table.extend(found.tip.iter());
        table.extend(quaternion(&found.frame));
        let tangent = found.frame.column(0);
        table.push(tangent.y.hypot(tangent.z).atan2(tangent.x));
        table.push(found.length);
        for own in &found.efforts {
            table.extend(STATE.map(|quantity| match quantity {
                Quantity::PULL => own.label,
                Quantity::ROTATION => own.rotation,
                Quantity::TENSION => own.force,
                _ => own.torque,
            }));
        }
        table.push(found.error[0]);
        table.push(found.iterations as f64);
    }

    /// A row without numbers.
    fn refuse(&self, verdict: Verdict, table: &mut Vec<f64>) {
        table.push(f64::from(verdict.code()));
        table.extend(std::iter::repeat_n(f64::NAN, self.columns().len() - self.axes.len() - 1));
    }

    /// The table as CSV, a description of the sweep in its first line behind `#`.
    ///
    /// # Errors
    /// None that memory does not have.
    pub fn csv(&self, chunk: &Chunk) -> std::io::Result<Vec<u8>> {
        let about = serde_json::json!({
            "format": "cppr sweep of a bundle", "cppr_version": env!("CARGO_PKG_VERSION"), "robot": self.name, "rows": chunk.rows,
        });
        let columns = self.columns();
        let mut text = Vec::new();
        writeln!(text, "# {about}")?;
        csv::head(&mut text, &columns)?;
        let reason = "a joint or a load would lie behind the plate";
        let status = self.axes.len();
        let of = |row: usize| {
            let refused = Verdict::from_code(chunk.column(status)[row]) == Some(Verdict::InvalidCommand);
            refused.then(|| reason.to_owned())
        };
        text.extend(csv::lines(chunk, &columns, of));
        Ok(text)
    }
}
