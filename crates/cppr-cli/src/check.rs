//! `cppr check`: is a robot file right?

use crate::Failure;
use crate::command::read_robot;
use crate::output::print;
use crate::table::{beyond_patterns, millimetres};
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr check robots/r3.toml
  cppr check robots/r1.toml robots/childs3.toml";

/// Arguments of `cppr check`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot files (TOML)
    #[arg(required = true, value_name = "ROBOT")]
    robots: Vec<PathBuf>,
}

/// Reports every file; fails where one is wrong.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut problems = Vec::new();
    for path in &args.robots {
        match read_robot(path) {
            Ok((_, robot)) => {
                let (count, mm) = (robot.tube_count(), millimetres(robot.length()));
                let tubes = if count == 1 { "1 tube".into() } else { format!("{count} tubes") };
                let plane = if robot.is_planar() { "planar" } else { "in space" };
                print(&format!("{}: {tubes}, {mm} mm long, {plane}: fine\n", path.display()))?;
                for text in beyond_patterns(&robot) {
                    print(&format!("  but {text}\n"))?;
                }
            }
            Err(
                Failure::Input(message) | Failure::NoEquilibrium(message) | Failure::Interrupted(message),
            ) => problems.push(message),
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(Failure::Input(problems.join("\n"))) }
}
