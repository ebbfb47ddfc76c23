//! Discretisation error of a sweep.

use crate::resolved::told;
use cppr_sweep::{Chunk, Subject, Task};
use serde_json::{Value, json};

/// The greatest error among those that are known: of rows that were looked at before, or of every row of a bundle.
pub struct Errors {
    rows: usize,
    /// Error of the tip as a part of the length.
    greatest: f64,
    accepted: f64,
}

impl Errors {
    /// Takes as many modes as the rows of a robot need.
    pub fn of(task: &mut Task, accepted: f64) -> Self {
        let (greatest, rows) = task.resolve(accepted).unwrap_or_default();
        Self { rows, greatest, accepted }
    }

    /// Looks at the errors in the rows of a chunk.
    pub fn visit(&mut self, task: &Task, chunk: &Chunk) {
        let place = task.columns().iter().position(|column| column.name == "tip_error_m");
        if let (Subject::Bundle(_), Some(place)) = (&task.subject, place) {
            for error in chunk.column(place).iter().filter(|error| error.is_finite()) {
                self.rows += 1;
                self.greatest = self.greatest.max(error / task.length());
            }
        }
    }

    /// For the summary; empty where no row told.
    pub fn text(&self) -> String {
        if self.rows == 0 { String::new() } else { told(self.greatest, self.rows, "rows", self.accepted) }
    }

    /// For the JSON.
    pub fn json(&self) -> Value {
        json!({ "rows": self.rows, "tip_of_length": (self.rows > 0).then_some(self.greatest) })
    }
}
