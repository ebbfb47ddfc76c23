//! A control loop that leads the tip along a line with the tip Jacobian; after its first turn it allocates nothing:
//! `cargo run -p cppr --example jacobian_loop`.

use cppr::Vector3;
use cppr::analysis::Sensitivity;
use cppr::design::{Robot, RobotDesign, StiffnessTube};
use cppr::solve::{Command, Drive, Solver};
use std::error::Error;
use std::f64::consts::PI;

fn main() -> Result<(), Box<dyn Error>> {
    let leader = StiffnessTube::uniform(3e-3, 0.0, [12e-3, 1e-3], 4e-3);
    let follower = StiffnessTube::uniform(1.1e-3, PI, [5e-3, 0.7e-3], 2e-3);
    let tubes = vec![leader.into(), follower.into()];
    let robot = Robot::from_design(RobotDesign { name: "pair".into(), length: 0.15, tubes })?;

    let mut solver = Solver::new(&robot);
    let mut command = Command::pull(&[3e-3]);
    let mut eq = solver.rest();
    solver.solve_into(&command, &mut eq)?;
    let mut derivatives = Sensitivity::default();
    // 10 mm sideways in steps of 0.2 mm, by pull and rotation of tube 2.
    let start = solver.tip(&eq).centre;
    for step in 1..=50 {
        let wanted = start + Vector3::new(0.0, 0.0, 2e-4 * f64::from(step));
        for _ in 0..4 {
            solver.sensitivity_into(&eq, &mut derivatives)?;
            // Least squares over the two coordinates across the robot: dp = J dq.
            let j = &derivatives.tip_jacobian;
            let gap = wanted - solver.tip(&eq).centre;
            let determinant = j[(1, 0)] * j[(2, 1)] - j[(1, 1)] * j[(2, 0)];
            let actuator = &mut command.actuators[0];
            let pull = (gap.y * j[(2, 1)] - gap.z * j[(1, 1)]) / determinant;
            let turn = (gap.z * j[(1, 0)] - gap.y * j[(2, 0)]) / determinant;
            actuator.push_pull = Drive::Motion(actuator.push_pull.value() + pull);
            actuator.rotation = Drive::Motion(actuator.rotation.value() + turn);
            solver.solve_into(&command, &mut eq)?;
        }
    }
    let moved = (solver.tip(&eq).centre - start) * 1e3;
    println!("{}", eq.status());
    println!("the tip moved by {:.3} mm across and {:.3} mm sideways", moved.y, moved.z);
    Ok(())
}
