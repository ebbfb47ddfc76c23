//! Discretisation error of a sweep, from rows that are spread over it.

use cppr::analysis::ACCURACY;
use cppr_sweep::{Chunk, Task};
use serde_json::{Value, json};

/// Rows whose error is computed.
const ROWS: u64 = 8;

/// The rows that were looked at.
pub struct Errors<'a> {
    task: &'a Task,
    rows: usize,
    /// Greatest error of the tip among them, as a part of the length.
    greatest: f64,
}

impl<'a> Errors<'a> {
    /// None yet.
    pub fn new(task: &'a Task) -> Self {
        Self { task, rows: 0, greatest: 0.0 }
    }

    /// Looks at the rows of a chunk whose turn it is.
    pub fn visit(&mut self, chunk: &Chunk) {
        let apart = self.task.rows().div_ceil(ROWS);
        for row in 0..chunk.rows {
            if (chunk.first_row + row as u64) % apart == 0
                && let Some(own) = self.task.error(chunk, row)
            {
                self.rows += 1;
                self.greatest = self.greatest.max(own);
            }
        }
    }

    /// For the summary; empty where no row told.
    pub fn text(&self) -> String {
        if self.rows == 0 {
            return String::new();
        }
        let more =
            if self.greatest > ACCURACY { "; more than 1e-4: --refine 2 to 8 takes more modes" } else { "" };
        format!("  tip within {:.0e} of the length in {} rows looked at{more}\n", self.greatest, self.rows)
    }

    /// For the JSON.
    pub fn json(&self) -> Value {
        json!({ "rows": self.rows, "tip_of_length": (self.rows > 0).then_some(self.greatest) })
    }
}
