//! Discretisation error of a sweep, and rows whose friction is not known.

use crate::resolved::told;
use cppr_sweep::{Chunk, Subject, Task, Verdict};
use serde_json::{Value, json};
use std::fmt::Write;

/// The greatest error among those that are known: of rows that were looked at before, or of every row of a bundle.
pub struct Errors {
    rows: usize,
    /// Error of the tip as a part of the length.
    greatest: f64,
    accepted: f64,
    /// Equilibria at which none with full slip was found.
    no_slip: usize,
}

impl Errors {
    /// Takes as many modes as the rows of a robot need.
    pub fn of(task: &mut Task, accepted: f64) -> Self {
        let (greatest, rows) = task.resolve(accepted).unwrap_or_default();
        Self { rows, greatest, accepted, no_slip: 0 }
    }

    /// Looks at the errors in the rows of a chunk.
    pub fn visit(&mut self, task: &Task, chunk: &Chunk) {
        let columns = task.columns();
        let place = |name: &str| columns.iter().position(|column| column.name == name);
        if let Some(tip) = place("loading_tip_x_m") {
            let verdicts = chunk.column(task.axes.len()).iter().map(|code| Verdict::from_code(*code));
            let found = verdicts.map(|verdict| verdict.is_some_and(Verdict::is_equilibrium));
            self.no_slip +=
                found.zip(chunk.column(tip)).filter(|(found, tip)| *found && tip.is_nan()).count();
        }
        if let (Subject::Bundle(_), Some(place)) = (&task.subject, place("tip_error_m")) {
            for error in chunk.column(place).iter().filter(|error| error.is_finite()) {
                self.rows += 1;
                self.greatest = self.greatest.max(error / task.length());
            }
        }
    }

    /// For the summary; empty where no row told.
    pub fn text(&self) -> String {
        let mut text = match self.rows {
            0 => String::new(),
            rows => told(self.greatest, rows, "rows", self.accepted),
        };
        if self.no_slip > 0 {
            let rows = self.no_slip;
            let _ = writeln!(
                text,
                "  no equilibrium with full slip was found in {rows} rows: their columns of friction are empty"
            );
        }
        text
    }

    /// For the JSON.
    pub fn json(&self) -> Value {
        json!({ "rows": self.rows, "tip_of_length": (self.rows > 0).then_some(self.greatest) })
    }
}
