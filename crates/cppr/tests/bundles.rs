//! Equilibria of two and three tubes in space against an independent energy-minimising program.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{HELIX, bundle, reference, vector};
use cppr::Vector3;
use cppr::analysis::shape::tip_pose;
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Settings, Status, Workspace, solve};
use cppr::statics::Loads;
use std::f64::consts::{FRAC_PI_2, PI};

/// What each case of the file is asked, in words there.
fn command(name: &str) -> Command {
    let held = |motions: &[f64]| Command::pull(motions);
    let turned = |motion: f64, rotation: f64| Command {
        actuators: vec![Actuator { push_pull: Drive::Motion(motion), rotation: Drive::Motion(rotation) }],
        ..Command::pull(&[])
    };
    let tip = |x: f64, y: f64, z: f64| Loads::tip_force(Vector3::new(x, y, z));
    match name {
        "straight_+3_rot_1.571" => turned(3e-3, FRAC_PI_2),
        "straight_+3_rot_3.142" => turned(3e-3, PI),
        "straight_-3_rot_1.571" => turned(-3e-3, FRAC_PI_2),
        "straight_-3_rot_3.142" => turned(-3e-3, PI),
        "straight_rot_pi2" => turned(0.0, FRAC_PI_2),
        "straight_T_free" => Command {
            actuators: vec![Actuator { push_pull: Drive::Effort(0.0), rotation: Drive::Motion(FRAC_PI_2) }],
            ..Command::pull(&[])
        },
        "straight_load_inplane" => held(&[5e-3]).with_loads(tip(0.0, 0.2, 0.0)),
        "straight_load_out" => held(&[-4e-3]).with_loads(tip(0.0, 0.0, 0.5)),
        _ => {
            let (kind, rest) = name.split_once('_').unwrap();
            let motions: Vec<f64> = rest.split('_').map(|v| v.parse::<f64>().unwrap() * 1e-3).collect();
            let loads = if kind == "sec48" { tip(0.0, 0.0, -0.4905) } else { Loads::none() };
            held(&motions).with_loads(loads)
        }
    }
}

#[test]
fn agree_with_the_independent_program_at_its_own_modes() {
    let data = reference("bundles");
    let mut workspace = Workspace::new();
    let mut worst = 0.0_f64;
    let cases = data["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 25);
    for case in cases {
        let name = case["name"].as_str().unwrap();
        let turn = if name.starts_with("helix") { HELIX } else { 0.0 };
        let robot = bundle(&case["parameters"], turn);
        // The modes of the reference: with a follower turned by π its own truncation error is 5e-6.
        let modes = if turn == 0.0 { 6 } else { 7 };
        let resolution =
            Resolution { twist: modes, bending_y: 9, bending_z: 9, angle: modes, stretch: 0, nodes: 20 };
        let settings = Settings::default().with_resolution(resolution);
        let found = solve(&robot, &mut workspace, &command(name), &settings).unwrap();
        assert_eq!(found.status, Status::Converged, "{name}");
        let (rotation, tip) = tip_pose(&robot, &mut workspace, &found);
        let expected = &case["expected"];
        let mut check = |what: &str, got: f64, want: f64, unit: f64| {
            let error = (got - want).abs() / unit;
            worst = worst.max(error);
            assert!(error < 1e-7, "{name}: {what} is {got}, the reference {want}");
        };
        check("tip", (tip - vector(&expected["tip_centreline_m"])).norm(), 0.0, robot.length());
        for (axis, row) in expected["tip_rotation_rows"].as_array().unwrap().iter().enumerate() {
            check("rotation", (rotation.row(axis).transpose() - vector(row)).norm(), 0.0, 1.0);
        }
        // Efforts against the largest of their kind: a torque that vanishes by symmetry has no relative error.
        let list = |key: &str| -> Vec<f64> {
            expected[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let (forces, torques) = (list("actuation_force_N"), list("actuation_torque_Nm"));
        let largest = |list: &[f64]| list.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let offset = case["parameters"]["tubes"][0]["D_m"].as_f64().unwrap();
        let force_unit = largest(&forces).max(largest(&torques) / offset);
        for (f, actuator) in found.actuators.iter().enumerate() {
            check("force", actuator.tension, forces[f], force_unit);
            check("torque", actuator.torque, torques[f], force_unit * robot.length() / 10.0);
        }
        let energy = expected["elastic_energy_J"].as_f64().unwrap();
        check("energy", found.elastic_energy, energy, energy);
    }
    println!("largest relative deviation {worst:.2e}");
}
