//! Sweeps: one robot, many poses.
//!
//! A [`Task`] says which inputs vary ([`Axis`]: actuators, loads, keys of the robot file) and how ([`Plan`]: a grid,
//! quasi-random samples, a list). [`run`] solves it chunk by chunk on several threads and hands the chunks over in
//! order; [`write_file`] journals them, so that nothing that was solved is lost, and assembles CSV, NPZ or Parquet.
//!
//! [`solve_many`] solves into memory, [`solve_many_of_bundle`] robots of parts and joints.
//!
//! Every pose is a row, solved or not: columns of numbers in SI units (see [`Task::columns`]), NaN where there is no
//! equilibrium, and a [`Verdict`]. Rows depend on the task alone, not on threads, interruptions or earlier chunks: every
//! chunk is solved by a fresh solver, along a path through its grid on which neighbours follow each other.
//!
//! ```
//! use cppr::{design::Robot, solve::{Command, Quantity, Settings}};
//! use cppr_sweep::{Axis, Plan, RobotSubject, Subject, Task, Values, Variable, run};
//! use std::{ops::ControlFlow, sync::atomic::AtomicBool};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let robot_text = std::fs::read_to_string("../../robots/r1.toml")?;
//! let robot = Robot::from_design(cppr_io::robot_file::parse(&robot_text)?.design)?;
//! let pull = Variable::Actuator(Quantity::PULL.of_tube(2));
//! let task = Task {
//!     subject: Subject::Robot(Box::new(RobotSubject {
//!         base: Command::held(&robot),
//!         settings: Settings::planar(),
//!         robot,
//!     })),
//!     axes: vec![Axis { variable: pull, values: Values::Range { from: -5e-3, to: 5e-3, count: 11 } }],
//!     plan: Plan::Grid,
//!     margin: false,
//!     limits: None,
//!     friction: None,
//!     robot_text,
//! };
//! task.check()?;
//! let tip_y = task.columns().iter().position(|column| column.name == "tip_y_m").ok_or("no such column")?;
//! let mut tips = Vec::new();
//! let _ = run(&task, 0, 0..task.chunks(), &AtomicBool::new(false), |chunk| {
//!     tips.extend_from_slice(chunk.column(tip_y));
//!     ControlFlow::<()>::Continue(())
//! })?;
//! assert!(tips.len() == 11 && tips[0] > 0.07 && tips[10] < -0.07);
//! # Ok(())
//! # }
//! ```

mod axis;
mod bundle;
mod check;
mod chunking;
mod design;
mod file;
mod format;
mod halton;
mod journal;
mod manifest;
mod many;
mod many_bundle;
mod run;
mod solver;
mod study;
mod table;
mod task;

pub use axis::{Axis, Values, Variable};
pub use check::TaskProblem;
pub use design::{DesignKeys, KeyProblem};
pub use file::{FileOptions, FileProblem, Finished, write_file};
pub use format::Format;
pub use journal::parts_of;
pub use many::{Memory, ONE_BLOCK, Poses, solve_many};
pub use many_bundle::solve_many_of_bundle;
pub use run::run;
pub use study::{Influence, PERCENTILES, Report, Statistics, Study};
pub use table::{Chunk, Column, Verdict};
pub use task::{BundleSubject, MOST_POSES, Plan, RobotSubject, Subject, Task};
