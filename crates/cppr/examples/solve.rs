//! From a design to shape, forces and tip Jacobian: `cargo run -p cppr --example solve`.

use cppr::design::{Robot, RobotDesign, StiffnessTube};
use cppr::solve::{Command, Solver};
use std::error::Error;
use std::f64::consts::PI;

fn main() -> Result<(), Box<dyn Error>> {
    // Two opposed tubes: centroid offset, its direction, bending and torsional stiffness.
    let leader = StiffnessTube::uniform(3e-3, 0.0, [12e-3, 1e-3], 4e-3);
    let follower = StiffnessTube::uniform(1.1e-3, PI, [5e-3, 0.7e-3], 2e-3);
    let tubes = vec![leader.into(), follower.into()];
    let robot = Robot::from_design(RobotDesign { name: "pair".into(), length: 0.15, tubes })?;

    let mut solver = Solver::new(&robot);
    let eq = solver.solve(&Command::pull(&[5e-3]))?;
    println!("{}", eq.status());
    let tip = eq.tip().centre * 1e3;
    println!("tip at {:.3}, {:.3}, {:.3} mm", tip.x, tip.y, tip.z);
    for (actuator, tube) in eq.actuators().iter().zip(2..) {
        println!("tube {tube}: pulled by {:.3} mm with {:.4} N", actuator.motion * 1e3, actuator.tension);
    }
    for section in solver.shape(&eq, 4).sections {
        println!(
            "at {:.0} mm the follower's moment is {:.3} N mm",
            section.label * 1e3,
            section.tubes[1].moment.z * 1e3
        );
    }
    let tip_jacobian = solver.sensitivity(&eq)?.tip_jacobian;
    println!("1 mm more pull moves the tip by {:.3} mm across", tip_jacobian[(1, 0)]);
    Ok(())
}
