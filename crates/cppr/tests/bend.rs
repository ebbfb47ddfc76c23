//! The total bend against closed forms, and against the tangents of the shape, which know nothing of curvatures.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{HELIX, converged, prototype, robot, stiff_tube, three_with_edges};
use cppr::Vector3;
use cppr::analysis::total_bend;
use cppr::design::{BelowPlate, Robot};
use cppr::solve::{Actuator, Command, Drive, Equilibrium, Settings, Solver};
use cppr::statics::{Loads, Wrench};
use std::f64::consts::PI;

const LENGTH: f64 = 0.15;
const STIFFNESS: f64 = 8e-3;

fn rod() -> Robot {
    robot(LENGTH, vec![stiff_tube(0.0, [STIFFNESS; 2], 5e-3, 0.0, 0.0)])
}

#[test]
fn a_circle_of_one_and_a_half_turns_bends_by_540_degrees() {
    // Uniform opposed tubes: K_Z = −Δa/((D_1 + D_2) L), whatever the stiffness.
    let [d1, d2] = [3e-3, 1.5e-3];
    let tube = |offset: f64, direction: f64| stiff_tube(offset, [1e-2, 5e-3], 5e-3, direction, 0.0);
    let pair = robot(LENGTH, vec![tube(d1, 0.0), tube(d2, PI)]);
    let pull = 3.0 * PI * (d1 + d2);
    for settings in [Settings::planar(), Settings::default()] {
        let found = converged(&pair, &Command::pull(&[pull]), &settings);
        assert!((total_bend(&found) - 3.0 * PI).abs() < 1e-9, "{}", total_bend(&found));
        // The tip points backwards: the angle between it and the base says half a turn.
        let tip = found.tip().tangent().x;
        assert!((tip + 1.0).abs() < 1e-9);
    }
    // A rod under a moment about any axis across it: M L/EI. A dead moment of this size is unstable.
    for moment in [Vector3::z(), -Vector3::y()] {
        let wrench = Wrench::tip_moment(moment * (3.0 * PI * STIFFNESS / LENGTH));
        let command = Command::pull(&[]).with_loads(Loads { wrenches: vec![wrench], ..Loads::none() });
        let found = Solver::new(&rod()).solve(&command).unwrap();
        assert!(found.status().is_equilibrium());
        assert!((total_bend(&found) - 3.0 * PI).abs() < 1e-9, "{}", total_bend(&found));
    }
}

/// A force at the tip and the opposite moment about its base: a cubic with an inflection. For small loads
/// κ = (F (L − x) − M)/EI, of which the total is the sum of both triangles.
#[test]
fn a_bend_and_its_opposite_add_up() {
    let (force, share) = (1e-4, 0.3);
    let moment = -share * force * LENGTH;
    let wrench = Wrench { moment: Vector3::z() * moment, ..Wrench::tip_force(Vector3::y() * force) };
    let loads = Loads { wrenches: vec![wrench], ..Loads::none() };
    let found = converged(&rod(), &Command::pull(&[]).with_loads(loads), &Settings::default());
    let want = force * LENGTH * LENGTH / (2.0 * STIFFNESS) * ((1.0 - share).powi(2) + share * share);
    assert!((total_bend(&found) - want).abs() < 1e-6 * want, "{} {want}", total_bend(&found));
    let tip = force * LENGTH * LENGTH / (2.0 * STIFFNESS) * (1.0 - 2.0 * share);
    assert!(want > 1.4 * tip, "without an inflection both would be the same");
}

/// Sum of the angles between tangents of neighbouring sections: the total bend as their number grows, from below, with an error
/// of second order that is taken away.
fn by_tangents(_robot: &Robot, solver: &mut Solver, found: &Equilibrium) -> f64 {
    let mut sum = |count: usize| -> f64 {
        let shape = solver.shape(found, count + 1);
        let tangents: Vec<_> = shape.sections.iter().map(|s| s.rotation.column(0).into_owned()).collect();
        tangents.windows(2).map(|t| 2.0 * (0.5 * (t[1] - t[0]).norm()).asin()).sum()
    };
    let (coarse, fine) = (sum(2000), sum(4000));
    fine + (fine - coarse) / 3.0
}

#[test]
fn in_space_it_is_the_length_of_the_curve_of_tangents() {
    let helix = {
        let tube = |offset: f64, direction: f64| stiff_tube(offset, [1e-2, 4e-3], 5e-3, direction, HELIX);
        robot(LENGTH, vec![tube(3e-3, 0.0), tube(2e-3, PI)])
    };
    let turned = |pulls: &[f64], turn: f64| {
        let mut command = Command::pull(pulls).with_loads(Loads::tip_force(Vector3::new(0.05, -0.1, 0.15)));
        command.actuators[0].rotation = Drive::Motion(turn);
        command
    };
    for (robot, command) in [
        (helix, turned(&[6e-3], 0.8)),
        (three_with_edges(), turned(&[1e-3, -0.8e-3], 0.5)),
        (prototype("R3", 1.25, BelowPlate::Plain), turned(&[-4e-3], 1.0)),
    ] {
        let mut solver = Solver::new(&robot);
        let found = converged(&robot, &command, &Settings::default());
        let (bend, want) = (total_bend(&found), by_tangents(&robot, &mut solver, &found));
        assert!((bend - want).abs() < 2e-6 * want, "{}: {bend} {want}", robot.design().name);
        let sections = solver.shape(&found, 2).sections;
        let tip = sections[0].rotation.column(0).angle(&sections[1].rotation.column(0));
        assert!(bend > tip + 1e-4, "in space the tangent takes a longer way: {bend} {tip}");
    }
}

/// The same robot, with everything turned about its axis.
#[test]
fn it_does_not_depend_on_the_frame() {
    let settings = Settings::default();
    let bend = |by: f64| {
        let tube =
            |offset: f64, direction: f64| stiff_tube(offset, [1e-2, 4e-3], 5e-3, direction + by, HELIX);
        let robot = robot(LENGTH, vec![tube(3e-3, 0.0), tube(2e-3, PI)]);
        let _solver = Solver::new(&robot);
        let force = Vector3::new(0.05, -0.1 * by.cos() - 0.15 * by.sin(), 0.15 * by.cos() - 0.1 * by.sin());
        let actuator = Actuator { rotation: Drive::Motion(0.8), ..Actuator::pulled(6e-3) };
        let command =
            Command { actuators: vec![actuator], ..Command::pull(&[]) }.with_loads(Loads::tip_force(force));
        total_bend(&converged(&robot, &command, &settings))
    };
    let first = bend(0.0);
    assert!(first > 0.5);
    for by in [0.7, 2.0, -1.3] {
        assert!((bend(by) - first).abs() < 1e-9, "{by}: {} {first}", bend(by));
    }
}
