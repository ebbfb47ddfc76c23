//! A parameter from measured tips, by Gauss and Newton's method on exact derivatives: `cargo run -p cppr --example calibrate`.
//! Tables, outliers and intervals come with the crate `cppr-calibrate`.

use cppr::analysis::Perturbed;
use cppr::design::{Robot, RobotDesign, StiffnessTube};
use cppr::solve::{Command, Equilibrium, Solver};
use std::error::Error;
use std::f64::consts::PI;

/// The robot with a factor on all centroid offsets.
fn robot(factor: f64) -> Result<Robot, Box<dyn Error>> {
    let leader = StiffnessTube::uniform(3e-3, 0.0, [12e-3, 1e-3], 4e-3);
    let follower = StiffnessTube::uniform(1.1e-3, PI, [5e-3, 0.7e-3], 2e-3);
    let tubes =
        [leader, follower].map(|tube| StiffnessTube { centroid_offset_factor: factor, ..tube }.into());
    Ok(Robot::from_design(RobotDesign { name: "pair".into(), length: 0.15, tubes: tubes.into() })?)
}

fn main() -> Result<(), Box<dyn Error>> {
    // Pull (m) and measured deflection of the tip (m); made with the factor 1.26, rounded to micrometres.
    let measured = [(2e-3, -28.395e-3), (4e-3, -54.150e-3), (6e-3, -75.470e-3)];
    let mut factor = 1.0;
    for _ in 0..6 {
        let robot = robot(factor)?;
        let mut solver = Solver::new(&robot);
        let moved =
            Perturbed::new(1e-3, |by| self::robot(factor + by).ok()).ok_or("no robot beside this one")?;
        let deflection = |_: &mut Solver, eq: &Equilibrium| vec![eq.tip().centre.y];
        let (mut normal, mut right) = (0.0, 0.0);
        for (pull, seen) in measured {
            let eq = solver.solve(&Command::pull(&[pull]))?;
            let slope = solver.parameter_sensitivity(&eq, &moved, deflection)?[0];
            normal += slope * slope;
            right += slope * (seen - eq.tip().centre.y);
        }
        factor += right / normal;
    }
    println!("the factor on the centroid offsets is {factor:.3}");
    Ok(())
}
