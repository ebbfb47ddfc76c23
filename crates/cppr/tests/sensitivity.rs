//! Derivatives of equilibria against re-solved neighbours and reciprocity.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{prototype, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::Perturbed;
use cppr::design::{BelowPlate, Robot, TubeDesign};
use cppr::kinematics::TipPose;
use cppr::solve::{Actuator, Command, Drive, Equilibrium, Settings, Solver};
use cppr::statics::{Loads, RotationMeans, Wrench};

fn helix() -> Robot {
    robot(
        0.15,
        vec![
            stiff_tube(3e-3, [0.012, 1e-3], 4e-3, 0.2, 1.5),
            stiff_tube(1.5e-3, [0.006, 0.8e-3], 2e-3, 2.4, 1.2),
            stiff_tube(1.0e-3, [0.004, 0.6e-3], 1.5e-3, -2.0, -0.8),
        ],
    )
}

/// Twist (translation, rotation) from one pose to another over a distance.
fn twist(a: &TipPose, b: &TipPose, distance: f64) -> [f64; 6] {
    let turn = (b.rotation * a.rotation.transpose() - a.rotation * b.rotation.transpose()) * (0.5 / distance);
    let shift = (b.centre - a.centre) / distance;
    [shift.x, shift.y, shift.z, turn[(2, 1)], turn[(0, 2)], turn[(1, 0)]]
}

struct Case {
    robot: Robot,
    command: Command,
}

fn cases() -> Vec<Case> {
    let force = Loads::tip_force(Vector3::new(0.1, -0.1, 0.2));
    let mixed = vec![
        Actuator { push_pull: Drive::Motion(2e-3), rotation: Drive::Effort(3e-3) },
        Actuator { push_pull: Drive::Effort(-1.0), rotation: Drive::Motion(0.4) },
    ];
    let held = vec![Actuator { push_pull: Drive::Motion(-4e-3), rotation: Drive::Motion(0.5) }];
    vec![
        Case {
            robot: helix(),
            command: Command { actuators: mixed, loads: force.clone(), rotation_means: RotationMeans::Base },
        },
        // Pushed, with the uncut part inside.
        Case {
            robot: prototype("R3", 1.26, BelowPlate::Plain),
            command: Command { actuators: held, loads: force, rotation_means: RotationMeans::Base },
        },
    ]
}

fn nudged(command: &Command, input: usize, by: f64) -> Command {
    let mut command = command.clone();
    let actuator = &mut command.actuators[input / 2];
    let drive = if input % 2 == 0 { &mut actuator.push_pull } else { &mut actuator.rotation };
    *drive = match *drive {
        Drive::Motion(v) => Drive::Motion(v + by),
        Drive::Effort(v) => Drive::Effort(v + by),
    };
    command
}

fn conjugate(found: &Equilibrium, input: usize) -> f64 {
    let (state, drives) = (found.actuators()[input / 2], found.command().actuators[input / 2]);
    match (input % 2, drives.push_pull, drives.rotation) {
        (0, Drive::Motion(_), _) => state.tension,
        (0, Drive::Effort(_), _) => state.motion,
        (_, _, Drive::Motion(_)) => state.torque,
        _ => state.rotation,
    }
}

#[test]
fn jacobians_agree_with_re_solved_neighbours_and_are_reciprocal() {
    let settings = Settings { tolerance: 1e-13, ..Settings::default() };
    for Case { robot, command } in cases() {
        let mut solver = Solver::with_settings(&robot, settings).unwrap();
        let rest = solver.rest();
        let found = solver.solve_from(&command, &rest).unwrap();
        let exact = solver.sensitivity(&found).unwrap();
        let m = exact.inputs.len();
        let at = |solver: &mut Solver, command: &Command| {
            let near = solver.solve_from(command, &found).unwrap();
            assert!(near.status().is_equilibrium());
            let pose = solver.tip(&near);
            (near, pose)
        };
        for input in 0..m {
            let step = if exact.inputs[input].is_motion { 3e-6 } else { 3e-5 };
            let (ahead, behind) = (
                at(&mut solver, &nudged(&command, input, step)),
                at(&mut solver, &nudged(&command, input, -step)),
            );
            let size = exact.tip_jacobian.column(input).norm();
            assert!(size > 1e-6, "input {input} moves nothing");
            for (axis, value) in twist(&behind.1, &ahead.1, 2.0 * step).into_iter().enumerate() {
                let got = exact.tip_jacobian[(axis, input)];
                assert!((got - value).abs() < 2e-6 * size, "twist {axis} by {input}: {got} {value}");
            }
            for other in 0..m {
                let value = (conjugate(&ahead.0, other) - conjugate(&behind.0, other)) / (2.0 * step);
                let got = exact.response[(other, input)];
                let size = exact.response.column(input).amax();
                assert!((got - value).abs() < 1e-5 * size, "response {other} by {input}: {got} {value}");
            }
        }
        for axis in 0..3 {
            let step = 1e-4;
            let pushed = |sign: f64| {
                let mut loads = command.loads.clone();
                let mut force = Vector3::zeros();
                force[axis] = sign * step;
                loads.wrenches.push(Wrench::tip_force(force));
                command.clone().with_loads(loads)
            };
            let (ahead, behind) = (at(&mut solver, &pushed(1.0)), at(&mut solver, &pushed(-1.0)));
            for (row, value) in twist(&behind.1, &ahead.1, 2.0 * step).into_iter().enumerate() {
                let got = exact.compliance[(row, axis)];
                assert!(
                    (got - value).abs() < 1e-5 * exact.compliance.column(axis).norm(),
                    "{row} {axis}: {got} {value}"
                );
            }
            for input in 0..m {
                // Betti: with the motion held, a force answers as the motion moves the tip, with opposite sign.
                let sign = if exact.inputs[input].is_motion { -1.0 } else { 1.0 };
                let (a, b) =
                    (exact.response_by_wrench[(input, axis)], sign * exact.tip_jacobian[(axis, input)]);
                assert!(
                    (a - b).abs() < 1e-8 * exact.tip_jacobian.column(input).norm(),
                    "{input} {axis}: {a} {b}"
                );
            }
        }
        let (block, other) = (exact.compliance, exact.compliance.transpose());
        let forces = block.fixed_view::<3, 3>(0, 0) - other.fixed_view::<3, 3>(0, 0);
        assert!(forces.norm() < 1e-8 * block.fixed_view::<3, 3>(0, 0).norm(), "compliance is not symmetric");
        // Outputs that are read along the inputs' directions agree with those that are differentiated exactly.
        let read = |solver: &mut Solver, eq: &Equilibrium| {
            let tip = solver.tip(eq).centre;
            let tensions = eq.actuators().iter().map(|a| a.tension);
            tip.iter().copied().chain(tensions).collect()
        };
        let along = solver.outputs_by_inputs(&found, read).unwrap();
        assert_eq!(along.shape(), (3 + m / 2, m));
        let near = |got: f64, want: f64, size: f64| assert!((got - want).abs() < 1e-9 * size, "{got} {want}");
        for input in 0..m {
            let column = exact.tip_jacobian.column(input);
            for axis in 0..3 {
                near(along[(axis, input)], column[axis], column.norm());
            }
            for (row, other) in
                (0..m).step_by(2).enumerate().filter(|(_, other)| exact.inputs[*other].is_motion)
            {
                near(
                    along[(3 + row, input)],
                    exact.response[(other, input)],
                    exact.response.column(input).amax(),
                );
            }
        }
    }
}

#[test]
fn design_parameters_agree_with_re_solved_robots() {
    let settings = Settings { tolerance: 1e-13, ..Settings::default() };
    let base = prototype("R3", 1.26, BelowPlate::Plain);
    let design = base.design().clone();
    // The factor on D of all tubes; Young's modulus of the leader; a depth shift of the follower.
    let change = |which: usize, p: f64| {
        let mut design = design.clone();
        for (k, tube) in design.tubes.iter_mut().enumerate() {
            let TubeDesign::Notched(tube) = tube else { unreachable!() };
            match (which, k) {
                (0, _) => tube.centroid_offset_factor += p,
                (1, 0) => tube.material.youngs_modulus *= 1.0 + p,
                (2, 1) => tube.depth = tube.depth.shifted(p * 1e-3),
                _ => {}
            }
        }
        Robot::from_design(design).ok()
    };
    for motion in [5e-3, -5e-3] {
        let command = Command::pull(&[motion]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.1, 0.1)));
        let mut solver = Solver::with_settings(&base, settings).unwrap();
        let rest = solver.rest();
        let found = solver.solve_from(&command, &rest).unwrap();
        let read = |solver: &mut Solver, eq: &Equilibrium| {
            let shape = solver.shape(eq, 3);
            let (middle, tip) = (shape.sections[1].tubes[1].centroid, shape.sections[2].centre);
            vec![
                middle.x,
                middle.y,
                middle.z,
                tip.x,
                tip.y,
                tip.z,
                eq.actuators()[0].tension * 1e-2,
                eq.actuators()[0].torque,
            ]
        };
        for which in 0..3 {
            let moved = Perturbed::new(1e-3, |p| change(which, p)).unwrap();
            let exact = solver.parameter_sensitivity(&found, &moved, read).unwrap();
            // Only the fields are differenced: sixteen times the error, at twice the step, is still rounding. (The
            // depth of R3's follower stands at the kink of its inertia at the base.)
            let wider = Perturbed::new(2e-3, |p| change(which, p)).unwrap();
            let again = solver.parameter_sensitivity(&found, &wider, read).unwrap();
            let largest = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            if which < 2 {
                assert!(exact.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-10 * largest));
            }
            let solved = |p: f64| {
                let robot = change(which, p).unwrap();
                let mut solver = Solver::with_settings(&robot, settings).unwrap();
                let eq = solver.solve_from(&command, &found).unwrap();
                read(&mut solver, &eq)
            };
            let step = 1e-3;
            let (a, b, c, d) = (solved(step), solved(-step), solved(2.0 * step), solved(-2.0 * step));
            let size = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(size > 1e-6, "parameter {which} changes nothing");
            for i in 0..exact.len() {
                let value = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * step);
                assert!((exact[i] - value).abs() < 1e-6 * size, "{motion} {which} {i}: {} {value}", exact[i]);
            }
        }
    }
}
