//! Tubes of solved robots: where they are, what they keep of their length and volume.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::shipped;
use cppr::analysis::Shape;
use cppr::design::{BelowPlate, Robot, TubeDesign};
use cppr::solve::{Command, Drive, Equilibrium, Solver};
use cppr::{Matrix3, Vector3};
use cppr_io::RobotFile;
use cppr_mesh::{Detail, Flaws, Mesh, TubeOptions, bend, bent_tubes, tube_mesh, tube_volume};

const MM: f64 = 1e-3;

fn solved(name: &str, pull: f64, turn: f64) -> (RobotFile, Robot, Solver, Equilibrium) {
    let file = shipped(name);
    let robot = Robot::from_design(file.design.clone()).unwrap();
    let mut command = Command::held(&robot);
    command.actuators[0].push_pull = Drive::Motion(pull);
    command.actuators[0].rotation = Drive::Motion(turn);
    let mut solver = Solver::new(&robot);
    let found = solver.solve(&command).unwrap();
    assert!(found.status().is_equilibrium(), "{}", found.status());
    (file, robot, solver, found)
}

/// By what a tube's volume (m³) grows when it bends: ∫A (|dc/dx| − κ_Z D − 1) dx, D being that of the section.
fn growth(file: &RobotFile, shape: &Shape, tube: usize) -> f64 {
    let TubeDesign::Notched(design) = &file.design.tubes[tube] else { panic!() };
    let pattern = file.tubes[tube].notches.unwrap();
    let mut grown = 0.0;
    for pair in shape.sections.windows(2) {
        let [a, b] = [0, 1].map(|i| &pair[i].tubes[tube]);
        let (dx, x) = (b.abscissa - a.abscissa, 0.5 * (a.abscissa + b.abscissa));
        let cell = x.rem_euclid(pattern.length + pattern.tooth) - 0.5 * pattern.tooth;
        let cut = x > 0.0 || design.below == BelowPlate::Continued;
        let depth = if cut && cell > 0.0 && cell < pattern.length {
            design.depth.eval(x.max(0.0), file.design.length)[0]
        } else {
            0.0
        };
        let section = design.outline.inertia(depth).unwrap();
        let curvature = 0.5 * (a.strain.z + b.strain.z);
        grown += section.area
            * ((pair[1].centre - pair[0].centre).norm() - curvature * section.centroid_offset * dx - dx);
    }
    grown
}

#[test]
fn bent_tubes_are_closed_and_change_their_volume_as_the_model_says() {
    for (name, pull, turn) in [("r1", 5.0, 0.0), ("r3", -8.0, 0.0), ("helicoid", 10.0, 0.0), ("r2", 2.0, 1.0)]
    {
        let (file, _robot, mut solver, found) = solved(name, pull * MM, turn);
        let below = 20.0 * MM;
        let bent = bent_tubes(&file, &mut solver, &found, 0.02 * MM, below).unwrap();
        let shape = solver.shape(&found, 6001);
        let sharp: Vec<f64> = (0..2).map(|tube| bent[tube].bounds()[0][0]).collect();
        assert!((sharp[1] + below + pull * MM).abs() < 1e-6, "the follower ends at {sharp:?}");
        for (tube, mesh) in bent.iter().enumerate() {
            assert_eq!(mesh.flaws(), Flaws::default());
            let below = if tube == 0 { 0.0 } else { below.max(-pull * MM) };
            // One mesh before and after, so that what polygons lack of a circle drops out.
            let options = TubeOptions { below, ..TubeOptions::plain(Detail::drawing(0.5 * MM)) };
            let rest = tube_mesh(&file, tube, &options).unwrap();
            let mut mesh = rest.clone();
            bend(&mut mesh, &mut solver, &found, tube);
            let total = tube_volume(&file, tube, &options).unwrap();
            let (got, want) = (mesh.volume() / rest.volume() - 1.0, growth(&file, &shape, tube) / total);
            assert!((got - want).abs() < 3e-4, "{name}, tube {}: {got} {want}", tube + 1);
            assert!(want.abs() > 2e-3, "{name}, tube {}: {want}", tube + 1);
        }
    }
}

/// On a uniformly bent tube the fibre at distance ρ̄ on the centroid's side is shorter by κ (ρ̄ − D): its length, notch by
/// notch, tells that every section went where the face-to-face map sends it.
#[test]
fn fibres_have_the_length_that_their_distance_from_the_centroid_says() {
    for pull in [5.0, -5.0] {
        let (file, robot, mut solver, found) = solved("r1", pull * MM, 0.0);
        let shape = solver.shape(&found, 3);
        for tube in 0..2 {
            let options = TubeOptions {
                below: 10.0 * MM,
                ..TubeOptions::plain(Detail { step: 0.25 * MM, ..Detail::drawing(1.0) })
            };
            let rest = tube_mesh(&file, tube, &options).unwrap();
            let mut mesh = rest.clone();
            bend(&mut mesh, &mut solver, &found, tube);
            let radius = file.tubes[tube].outer_radius.unwrap();
            let side = if tube == 0 { radius } else { -radius };
            let mut fibre: Vec<(f64, Vector3<f64>)> = rest
                .positions
                .iter()
                .zip(&mesh.positions)
                .filter(|(r, _)| (r[1] - side).abs() < 1e-12 && r[2].abs() < 1e-12)
                .map(|(r, p)| (r[0], Vector3::from(*p)))
                .collect();
            fibre.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert!(fibre.len() > 500);
            let middle = &shape.sections[1].tubes[tube];
            let offset = robot.fields_at(tube, middle.abscissa).centroid_offset;
            let want = 1.0 - middle.strain.z * (radius - offset);
            let start = shape.sections[0].tubes[tube].abscissa;
            // Where a pushed follower is still uncut, the robot bends less.
            for pair in fibre.windows(2).filter(|pair| pair[0].0 > start && pair[0].0 > 6.0 * MM) {
                let got = (pair[1].1 - pair[0].1).norm() / (pair[1].0 - pair[0].0);
                assert!(
                    (got - want).abs() < 2e-6,
                    "{pull}, tube {}: {got} {want} at {}",
                    tube + 1,
                    pair[0].0
                );
            }
            assert!((want - 1.0).abs() > 2e-4, "{want}");
        }
    }
}

/// All tubes end in the tip's plane, around its centre.
#[test]
fn tubes_meet_at_the_tip() {
    let (file, _robot, mut solver, found) = solved("helicoid", 10.0 * MM, 0.5);
    let cppr::kinematics::TipPose { rotation, centre } = solver.tip(&found);
    for (tube, mesh) in bent_tubes(&file, &mut solver, &found, 0.02 * MM, 0.0).unwrap().iter().enumerate() {
        let radius = file.tubes[tube].outer_radius.unwrap();
        let local = |p: &[f64; 3]| rotation.transpose() * (Vector3::from(*p) - centre);
        let on_rim = |mesh: &Mesh| {
            mesh.positions
                .iter()
                .map(local)
                .filter(|p| p.x.abs() < 1e-9 && (p.y.hypot(p.z) - radius).abs() < 1e-9)
                .count()
        };
        assert!(on_rim(mesh) >= 32, "tube {}", tube + 1);
        assert!(mesh.positions.iter().map(local).all(|p| p.x < 1e-9 || p.norm() > 50.0 * MM));
    }
    assert!((rotation * rotation.transpose() - Matrix3::identity()).norm() < 1e-12);
}

#[test]
fn a_robot_at_rest_is_the_tubes_at_rest() {
    let (file, _robot, mut solver, found) = solved("r3", 0.0, 0.0);
    for tube in 0..2 {
        let rest = tube_mesh(&file, tube, &TubeOptions::plain(Detail::drawing(1.0 * MM))).unwrap();
        let mut mesh = rest.clone();
        bend(&mut mesh, &mut solver, &found, tube);
        for (p, q) in rest.positions.iter().zip(&mesh.positions) {
            assert!((Vector3::from(*p) - Vector3::from(*q)).norm() < 1e-9, "{p:?} {q:?}");
        }
    }
}
