//! Sweeps: one robot, many poses.
//!
//! A [`Task`] says which inputs vary ([`Axis`]: actuators, loads, keys of the robot file) and how ([`Plan`]: a grid,
//! quasi-random samples, a list). [`run`] solves it chunk by chunk on several threads and hands the chunks over in
//! order; [`write_file`] journals them, so that nothing that was solved is lost, and assembles CSV, NPZ or Parquet.
//!
//! Every pose is a row, solved or not: columns of numbers in SI units (see [`Task::columns`]), NaN where there is no
//! equilibrium, and a [`Verdict`]. Rows depend on the task alone, not on threads, interruptions or earlier chunks: every
//! chunk is solved by a fresh solver, along a path through its grid on which neighbours follow each other.

mod axis;
mod check;
mod chunking;
mod design;
mod file;
mod format;
mod halton;
mod journal;
mod manifest;
mod run;
mod solver;
mod table;
mod task;

pub use axis::{Axis, Values, Variable};
pub use check::TaskProblem;
pub use design::{DesignKeys, KeyProblem};
pub use file::{FileOptions, FileProblem, Finished, write_file};
pub use format::Format;
pub use journal::parts_of;
pub use run::run;
pub use table::{Chunk, Column, Verdict};
pub use task::{MOST_POSES, Plan, Task};
