//! A robot from its geometry, and a tube whose stiffness one computes oneself along its length:
//! `cargo run -p cppr --example own_section`.

use cppr::design::{
    BelowPlate, Material, NotchedTube, Outline, Profile, Robot, RobotDesign, StiffnessTube, TeethStiffness,
    Torsion,
};
use cppr::solve::{Command, Solver};
use std::error::Error;
use std::f64::consts::PI;

/// EI of a rectangular strip (N m²): modulus (Pa), width and height (m).
fn strip(modulus: f64, width: f64, height: f64) -> f64 {
    modulus * width * height.powi(3) / 12.0
}

fn main() -> Result<(), Box<dyn Error>> {
    let length = 0.1;
    let nylon = Material {
        youngs_modulus: 1.8e9,
        poissons_ratio: 0.4,
        density: 1010.0,
        allowable_strain: Some(0.02),
        softening: None,
    };
    // The leader is a round tube with notches that get shallower towards the tip.
    let leader = NotchedTube {
        outline: Outline::Round { outer_radius: 4e-3, inner_radius: 3e-3 },
        depth: Profile::linear(5.5e-3, 5e-3),
        direction: Profile::constant(0.0),
        pattern: None,
        teeth: TeethStiffness::Flexible,
        contact: false,
        material: nylon,
        torsion: Torsion::SaintVenant,
        below: BelowPlate::Plain,
        centroid_offset_factor: 1.0,
    };
    // The follower is a strip of one's own inside it, 1.5 mm off the axis, whose height tapers.
    let heights = [0.8e-3, 0.7e-3, 0.6e-3];
    let along =
        |value: &dyn Fn(f64) -> f64| Profile::table(&[0.0, 0.5 * length, length], &heights.map(value));
    let follower = StiffnessTube {
        bending_y: along(&|h| strip(2e9, h, 3e-3))?,
        bending_z: along(&|h| strip(2e9, 3e-3, h))?,
        torsion: along(&|h| 0.7e9 * 3e-3 * h.powi(3) / 3.0)?,
        ..StiffnessTube::uniform(1.5e-3, PI, [1.0, 1.0], 1.0)
    };
    let tubes = vec![leader.into(), follower.into()];
    let robot = Robot::from_design(RobotDesign { name: "strip in a tube".into(), length, tubes })?;

    let mut solver = Solver::new(&robot);
    let eq = solver.solve(&Command::pull(&[2e-3]))?;
    println!("{}", eq.status());
    println!(
        "the tip turns by {:.2} degrees under {:.3} N",
        eq.tip().tangent().x.acos().to_degrees(),
        eq.actuators()[0].tension
    );
    Ok(())
}
