//! From a robot file to shape, forces and tip Jacobian.

use cppr::analysis::{Shape, sensitivity};
use cppr::design::Robot;
use cppr::solve::{Command, Settings, Workspace, solve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = cppr_io::robot_file::read("robots/r3.toml")?;
    let robot = Robot::new(file.design).map_err(|problems| problems[0].clone())?;
    let mut workspace = Workspace::new();
    let found = solve(&robot, &mut workspace, &Command::pull(&[5e-3]), &Settings::default())?;
    // Look at the status before anything else.
    println!("{}: T = {:.4} N", found.status, found.actuators[0].tension);
    let shape = Shape::sampled(&robot, &mut workspace, &found, 101);
    if let Some(tip) = shape.sections.last() {
        println!("tip at {:.3} mm", tip.centre * 1e3);
    }
    if let Some(derivatives) = sensitivity(&robot, &mut workspace, &found) {
        println!("tip Jacobian {:.3}", derivatives.tip_jacobian);
    }
    Ok(())
}
