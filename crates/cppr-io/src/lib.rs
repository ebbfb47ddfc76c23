//! Files that go into and come out of `cppr`.
//!
//! A robot file is TOML with the unit in every key; [`robot_file::parse`] turns it into a
//! [`cppr::design::RobotDesign`] or into [`Problems`]: everything that is wrong with it at once, each
//! with its line and with what to write instead. Robots of parts, joints and curved tubes are read by [`bundle_file`]. A result is written as JSON ([`result`], everything) or CSV
//! ([`result_csv`], the fields along the robot).
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir("../..")?;
//! use cppr::solve::{Command, Solver};
//!
//! let robot = cppr_io::read_robot("robots/r3.toml")?;
//! let mut solver = Solver::new(&robot);
//! let eq = solver.solve(&Command::pull(&[5e-3]))?;
//! println!("{}: tip {} mm", eq.status(), eq.tip().centre * 1e3);
//! let tip_jacobian = solver.sensitivity(&eq)?.tip_jacobian;
//! # assert!((eq.tip().centre.x - 134.383e-3).abs() < 1e-6 && tip_jacobian.ncols() == 2);
//! # Ok(())
//! # }
//! ```

pub mod bundle_file;
pub mod clearance_record;
pub mod contact_record;
pub mod continuation;
pub mod csv_table;
mod cursor;
mod keys;
mod material;
mod notches;
pub mod points;
pub mod problems;
pub mod processor;
mod profile_value;
mod quantity;
pub mod result;
pub mod result_csv;
mod result_format;
pub mod robot_file;
pub mod robot_text;
pub mod scenario;
mod scenario_bundle;
mod stiffness;
mod sudden;
mod syntax;
mod teeth;
mod tube_file;

pub use bundle_file::read_bundle;
pub use problems::{Excerpt, Problem, Problems};
pub use robot_file::{NotchPattern, RobotFile, TubeFile, read_robot};
pub use scenario::Scenario;
pub use sudden::sudden_changes;
