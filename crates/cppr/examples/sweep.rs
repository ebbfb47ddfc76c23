//! The workspace of a robot: many poses side by side, each from its neighbour, with their margins to instability.
//! `cargo run -p cppr --example sweep`. Files and threads come with the crate `cppr-sweep`.

use cppr::design::{Robot, RobotDesign, StiffnessTube};
use cppr::many::{March, Start};
use cppr::solve::{Command, Drive, Solver};
use std::error::Error;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn Error>> {
    let leader = StiffnessTube::uniform(3e-3, 0.0, [12e-3, 1e-3], 4e-3);
    let follower = StiffnessTube::uniform(1.1e-3, PI, [5e-3, 0.7e-3], 2e-3);
    let tubes = vec![leader.into(), follower.into()];
    let robot = Robot::from_design(RobotDesign { name: "pair".into(), length: 0.15, tubes })?;

    let (pulls, turns) = (21, 11);
    let mut march = March::new(Solver::new(&robot));
    let (mut solved, mut farthest, mut least) = (0, 0.0_f64, f64::INFINITY);
    let flow = march.run(
        &Command::held(&robot),
        Start::Neighbour,
        pulls * turns,
        |pose, command| {
            let (pull, turn) = (pose % pulls, pose / pulls);
            command.actuators[0].push_pull = Drive::Motion(5e-4 * (pull as f64 - 10.0));
            command.actuators[0].rotation = Drive::Motion(0.1 * turn as f64);
        },
        |_, pose| {
            let mut pose = match pose {
                Ok(pose) if pose.equilibrium.status().is_equilibrium() => pose,
                Ok(_) => return ControlFlow::Continue(()),
                Err(problem) => return ControlFlow::Break(problem),
            };
            solved += 1;
            farthest = farthest.max(pose.tip.centre.yz().norm());
            least = least.min(pose.margin().unwrap_or(f64::INFINITY));
            ControlFlow::Continue(())
        },
    );
    if let ControlFlow::Break(problem) = flow {
        return Err(problem.into());
    }
    println!("{solved} of {} poses have an equilibrium", pulls * turns);
    println!(
        "the tip reaches {:.1} mm to the side; the least margin to instability is {least:.3}",
        farthest * 1e3
    );
    Ok(())
}
