//! The table that a sweep makes: its columns, and chunks of its rows.

use cppr::solve::{Reason, Status};

/// What came of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// A stable equilibrium.
    Converged,
    /// An equilibrium that the robot leaves at the slightest disturbance.
    Unstable,
    /// Load stepping from rest ended before the whole command.
    PathEnds,
    /// No consistent entry of the uncut part below the plate was found.
    Edges,
    /// The design parameters of this row make no robot.
    InvalidDesign,
    /// The command cannot be asked of this robot.
    InvalidCommand,
}

impl Verdict {
    /// All, by their codes.
    pub const ALL: [Self; 6] = [
        Self::Converged,
        Self::Unstable,
        Self::PathEnds,
        Self::Edges,
        Self::InvalidDesign,
        Self::InvalidCommand,
    ];

    /// Number in the column `status`.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8
    }

    /// Word in the column `status_text`.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Unstable => "unstable",
            Self::PathEnds => "not_converged_path_ends",
            Self::Edges => "not_converged_edges",
            Self::InvalidDesign => "invalid_design",
            Self::InvalidCommand => "invalid_command",
        }
    }

    /// Is there an equilibrium, stable or not?
    #[must_use]
    pub fn is_equilibrium(self) -> bool {
        matches!(self, Self::Converged | Self::Unstable)
    }

    /// From a column of codes.
    #[must_use]
    pub fn from_code(code: f64) -> Option<Self> {
        Self::ALL.into_iter().find(|v| (f64::from(v.code()) - code).abs() < 0.5)
    }
}

impl From<Status> for Verdict {
    fn from(status: Status) -> Self {
        match status {
            Status::Converged => Self::Converged,
            Status::Unstable => Self::Unstable,
            Status::NotConverged(Reason::PathEnds { .. }) => Self::PathEnds,
            Status::NotConverged(Reason::Edges) => Self::Edges,
        }
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// A number; NaN where there is none.
    Number,
    /// A code of [`Verdict`].
    Status,
    /// A whole number; NaN where there is none.
    Count,
}

/// A column: name with unit, and kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, the unit at its end.
    pub name: String,
    /// What it holds.
    pub kind: ColumnKind,
}

/// Successive rows of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// Number of the chunk.
    pub number: u64,
    /// First row, counted from 0.
    pub first_row: u64,
    /// How many rows.
    pub rows: usize,
    /// Column after column, `rows` numbers each, in the order of [`crate::Task::columns`].
    pub values: Vec<f64>,
}

impl Chunk {
    /// One column.
    #[must_use]
    pub fn column(&self, index: usize) -> &[f64] {
        &self.values[index * self.rows..(index + 1) * self.rows]
    }

    pub(crate) fn set(&mut self, column: usize, row: usize, value: f64) {
        self.values[column * self.rows + row] = value;
    }
}
