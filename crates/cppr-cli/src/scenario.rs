//! A scenario file applied to a robot file.

use crate::Failure;
use crate::command::read_robot;
use cppr::bundle::BundleDesign;
use cppr::bundle::solve::BundleCommand;
use cppr::design::Robot;
use cppr::solve::{Command, Solver};
use cppr_io::{Scenario, scenario};
use std::io::Read;
use std::path::Path;

/// Reads a scenario file.
pub fn read(path: &Path) -> Result<Scenario, Failure> {
    let shown = path.display();
    let mut text = String::new();
    std::fs::File::open(path)
        // One byte more than allowed is enough to know that there are too many.
        .and_then(|file| file.take(scenario::LARGEST as u64 + 1).read_to_string(&mut text))
        .map_err(|error| {
            Failure::Input(format!("{shown}: the file cannot be read ({error}). Check its name and folder"))
        })?;
    Scenario::parse(&text).map_err(|problem| Failure::Input(format!("{shown}: {problem}")))
}

/// The command of a scenario for a bundle, and whether its tubes stretch.
pub fn bundle_command(path: &Path, design: &BundleDesign) -> Result<(BundleCommand, bool), Failure> {
    read(path)?.bundle_command(design).map_err(|problems| all(path, &problems))
}

/// Problems of a scenario, each under the name of its file.
fn all(path: &Path, problems: &[String]) -> Failure {
    let lines: Vec<String> = problems.iter().map(|p| format!("{}: {p}", path.display())).collect();
    Failure::Input(lines.join("\n"))
}

/// A solver of the robot with the notches of the scenario, and its command.
pub fn apply(path: &Path, robot: &Path) -> Result<(Solver, Command), Failure> {
    let all = |problems: Vec<String>| all(path, &problems);
    let scenario = read(path)?;
    let (file, _) = read_robot(robot)?;
    let design = scenario.changed(file.design).map_err(all)?;
    let robot = Robot::from_design(design).map_err(|p| all(p.0.iter().map(ToString::to_string).collect()))?;
    let command = scenario.command(&robot).map_err(all)?;
    let solver = Solver::with_settings(&robot, scenario.settings()).map_err(|p| all(vec![p.to_string()]))?;
    solver.check(&command).map_err(|p| all(vec![p.to_string()]))?;
    Ok((solver, command))
}
