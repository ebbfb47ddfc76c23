//! From a robot file to shape, forces and tip Jacobian.

use cppr::solve::{Command, Solver};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = cppr_io::read_robot("robots/r3.toml")?;
    let mut solver = Solver::new(&robot);
    let eq = solver.solve(&Command::pull(&[5e-3]))?;
    // Look at the status before anything else.
    println!("{}: T = {:.4} N", eq.status(), eq.actuators()[0].tension);
    println!("tip at {:.3} mm", eq.tip().centre * 1e3);
    println!("tip Jacobian {:.3}", solver.sensitivity(&eq)?.tip_jacobian);
    Ok(())
}
