//! Makes the example data: `cargo run --release -p cppr-calibrate --example synthetic` writes
//! `examples/calibration/measured.csv`, `r1.csv`, `concentric3.csv` and `loop.csv`.
//!
//! Tips of R1 and R2 with a centroid factor of 1.22 and E = 4.8 GPa, unloaded and under 0.15 N, with normal noise of
//! 0.5 mm from a fixed seed; and tips of three curved tubes, 1.06 times as curved as their file says, with G = 20 GPa; and tensions of R1 with
//! E = 4.8 GPa and a coefficient of friction of 0.2: what a calibration should find again.

use cppr::Vector3;
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::design::Robot;
use cppr::solve::{Command, Drive, Solver};
use cppr::statics::Loads;
use cppr_calibrate::{Design, Parameter};
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut uniform = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut normal = move || (-2.0 * uniform().max(1e-300).ln()).sqrt() * (TAU * uniform()).cos();
    let head = "robot,pull2_mm,tip_force_y_N,x_mm,y_mm,z_mm,sigma_mm\n";
    let (mut all, mut first) = (String::from(head), String::from(head));
    for name in ["r1", "r2"] {
        let truth = [("centroid_offset_factor", 1.22), ("youngs_modulus", 4.8e9)];
        let Design::Robot(design) = changed(&format!("robots/{name}.toml"), &truth)? else {
            return Err("this robot has parts or joints".into());
        };
        let robot = Robot::from_design(design)?;
        let mut solver = Solver::new(&robot);
        for pull in [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0] {
            for force in [0.0, 0.15, -0.15] {
                let loads = Loads::tip_force(Vector3::new(0.0, force, 0.0));
                let command = Command::pull(&[pull * 1e-3]).with_loads(loads);
                let found = solver.solve(&command)?;
                let tip = solver.tip(&found).centre * 1e3;
                let seen = [tip.x, tip.y, tip.z].map(|v| v + 0.5 * normal());
                let mut row = String::new();
                let label = &robot.design().name;
                writeln!(row, "{label},{pull},{force},{:.3},{:.3},{:.3},0.5", seen[0], seen[1], seen[2])?;
                all.push_str(&row);
                if name == "r1" && force.abs() <= 0.0 {
                    first.push_str(&row);
                }
            }
        }
    }
    std::fs::write("examples/calibration/measured.csv", all)?;
    std::fs::write("examples/calibration/r1.csv", first)?;

    let truth = [("rest_curvature_factor", 1.06), ("shear_modulus", 20e9)];
    let Design::Bundle(design) = changed("robots/bundles/concentric3.toml", &truth)? else {
        return Err("this robot has neither parts nor joints".into());
    };
    let bundle = Bundle::new(&design)?;
    let mut solver = BundleSolver::new(&bundle);
    let mut table = String::from("rotate2_deg,pull3_mm,rotate3_deg,x_mm,y_mm,z_mm,sigma_mm\n");
    for turn in [-60.0, 0.0, 90.0] {
        for pull in [0.0, -20.0] {
            for inner in [-120.0, 0.0, 60.0, 150.0] {
                let mut command = solver.held();
                command.drives[1].rotation = Drive::Motion(f64::to_radians(turn));
                command.drives[2].translation = Drive::Motion(pull * 1e-3);
                command.drives[2].rotation = Drive::Motion(f64::to_radians(inner));
                let tip = solver.solve(&command).tip * 1e3;
                let [x, y, z] = [tip.x, tip.y, tip.z].map(|v| v + 0.5 * normal());
                writeln!(table, "{turn},{pull},{inner},{x:.3},{y:.3},{z:.3},0.5")?;
            }
        }
    }
    std::fs::write("examples/calibration/concentric3.csv", table)?;

    let design = changed("robots/r1.toml", &[("youngs_modulus", 4.8e9)])?;
    let Design::Robot(design) = design else { return Err("this robot has parts or joints".into()) };
    let bundle = Bundle::new(&BundleDesign::from(&design))?;
    let mut solver = BundleSolver::new(&bundle);
    let mut table = String::from("pull2_mm,driven,measured_tension2_N,sigma_N\n");
    for pull in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0] {
        let mut command = solver.held();
        command.drives[1].translation = Drive::Motion(pull * 1e-3);
        let found = solver.solve(&command);
        let sides = solver.full_slip(&found, &Friction { coefficient: 0.2, guide: None });
        for (way, side) in ["on", "back"].into_iter().zip(sides.ok_or("no full slip")?) {
            writeln!(table, "{pull},{way},{:.3},0.03", side.efforts[1].force + 0.03 * normal())?;
        }
    }
    std::fs::write("examples/calibration/loop.csv", table)?;
    Ok(())
}

fn changed(path: &str, truth: &[(&str, f64)]) -> Result<Design, Box<dyn Error>> {
    let mut design = Design::from(cppr_io::bundle_file::read(path)?);
    for (parameter, value) in truth {
        Parameter::parse(parameter)?.set(&mut design, *value);
    }
    Ok(design)
}
