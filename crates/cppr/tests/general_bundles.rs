//! Bundles with parts, joints on the way, free tips, tubes curved at rest and insertion, against an independent program that
//! treats every tube alike (untwisted frame, rotations of the material, polynomials for all fields, Newton's method by automatic differentiation),
//! and against what any bundle has to fulfil.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod common;

use common::bundle_cases::{cases, command, design, list};
use cppr::Vector3;
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign, Part, TubeParts};
use cppr::design::StiffnessTube;
use cppr::solve::Drive;

#[test]
fn an_independent_program_finds_the_same() {
    let mut met = 0;
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let found = solver.solve(&command(&case));
        assert!(found.converged && found.stable, "{name}");
        let expected = &case["expected"];
        let off = (found.tip - Vector3::from_vec(list(expected, "tip_m"))).norm();
        // Its own modes leave up to 1.3e-8 m.
        assert!(off < 2e-7 * bundle.length(), "{name}: the tip is off by {off:e} m");
        assert!(found.error[0] < 1e-7 * bundle.length(), "{name}: {:?}", found.error);
        let direction = found.frame.column(0) - Vector3::from_vec(list(expected, "tip_direction"));
        assert!(direction.norm() < 1e-6, "{name}: {direction}");
        let most = list(expected, "force_N").iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        for (tube, (force, torque)) in
            list(expected, "force_N").into_iter().zip(list(expected, "torque_Nm")).enumerate()
        {
            let own = found.efforts[tube];
            assert!(
                (own.force - force).abs() < 1e-6 * most,
                "{name}, tube {tube}: {} N for {force}",
                own.force
            );
            let scale = most * bundle.length();
            assert!((own.torque - torque).abs() < 1e-6 * scale, "{name}, tube {tube}: {} Nm", own.torque);
        }
        met += 1;
    }
    assert_eq!(met, 9);
}

/// A force is the slope of the energy by its motor's travel: what is prescribed as a motion and answered by an effort gives the same
/// motion when that effort is prescribed.
#[test]
fn motions_and_efforts_are_two_views_of_one_equilibrium() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let command = command(&case);
        let found = solver.solve(&command);
        // A free tube without centroid offset takes no force: leave tubes in no joint alone.
        let last = command.drives.len() - 1;
        if case["joints"].as_array().unwrap().is_empty() {
            continue;
        }
        let mut other = command.clone();
        other.drives[last].translation = Drive::Effort(found.efforts[last].force);
        other.drives[last].rotation = Drive::Effort(found.efforts[last].torque);
        let again = solver.solve_from(&other, &found);
        assert!(again.converged, "{name}");
        assert!((again.tip - found.tip).norm() < 1e-8, "{name}: {}", (again.tip - found.tip).norm());
        assert!((again.efforts[last].label - found.efforts[last].label).abs() < 1e-8, "{name}");
    }
}

/// Where a curved part begins at the tip of a straight tube around it, drawing it in takes the energy of bending both, pushing it out takes nothing:
/// the force jumps, and is found on both sides from the place between.
#[test]
fn a_force_jumps_where_a_curved_part_is_drawn_in() {
    let part = |length: f64, bending: f64, curvature: f64| Part {
        length,
        body: StiffnessTube::uniform(0.0, 0.0, [bending, bending], 0.8 * bending).into(),
        rest_curvature: curvature,
        rest_direction: 0.0,
    };
    let tubes = vec![
        TubeParts { parts: vec![part(0.05, 9e-3, 0.0)], shaft: None },
        TubeParts { parts: vec![part(0.05, 2e-3, 0.0), part(0.03, 2e-3, 10.0)], shaft: None },
    ];
    let bundle = Bundle::new(&BundleDesign { name: "edge".into(), tubes, joints: Vec::new() }).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let rest = solver.rest().unwrap().clone();
    let energy = 0.5 * 100.0 * 9e-3 * 2e-3 / 11e-3;
    for (motion, force) in [(1e-5, energy), (-1e-5, 0.0)] {
        let mut command = solver.held();
        command.drives[1].translation = Drive::Motion(motion);
        let found = solver.continued(&command, &rest).unwrap();
        assert!(found.stable && (found.tip - rest.tip).norm() < 1.1e-5, "{}", found.tip);
        assert!((found.efforts[1].force - force).abs() < 1e-8, "{} N for {force}", found.efforts[1].force);
    }
}

/// Turning all motors and the loads about the axis turns the robot.
#[test]
fn the_plate_may_be_turned() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let command = command(&case);
        let found = solver.solve(&command);
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
        let mut turned = command.clone();
        for drive in &mut turned.drives {
            drive.rotation = Drive::Motion(drive.rotation.value() + 0.3);
        }
        for wrench in &mut turned.loads.wrenches {
            wrench.force = turn * wrench.force;
        }
        let other = solver.solve(&turned);
        assert!(other.converged, "{name}");
        assert!((other.tip - turn * found.tip).norm() < 1e-7 * bundle.length(), "{name}");
    }
}

#[test]
fn the_tip_jacobian_is_the_slope_of_the_tip() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle).with_tolerance(1e-10);
        let command = command(&case);
        let found = solver.solve(&command);
        let jacobian = solver.tip_jacobian(&found).unwrap();
        assert!(jacobian.norm() > 0.0, "{name}");
        for (tube, _) in command.drives.iter().enumerate() {
            for which in 0..2 {
                let unit = if which == 0 { 1e-5 } else { 1e-3 };
                let mut at = |sign: f64| {
                    let mut moved = command.clone();
                    let drive = &mut moved.drives[tube];
                    let own = if which == 0 { &mut drive.translation } else { &mut drive.rotation };
                    *own = own.with_value(own.value() + sign * unit);
                    solver.solve_from(&moved, &found).tip
                };
                // One-sided: at the plate an edge may lie on one side only.
                let slope = (at(1.0) - at(-1.0)) / (2.0 * unit);
                let column = jacobian.fixed_view::<3, 1>(0, 2 * tube + which);
                let scale = if which == 0 { 10.0 } else { bundle.length() };
                let off = (slope - column).norm() / scale;
                assert!(off < 1e-3, "{name}, tube {tube}, motor {which}: {slope} for {column}");
            }
        }
    }
}

/// The section at the end of the shape is the tip, and tensions of the tubes in the plane add up along an unloaded robot.
#[test]
fn the_shape_ends_at_the_tip() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let found = solver.solve(&command(&case));
        let spacing = bundle.length() / 50.0;
        let shape = solver.shape(&found, spacing);
        let (first, last) = (&shape[0], &shape[shape.len() - 1]);
        assert!(first.centre.norm() < 1e-15, "{name}");
        assert!((last.centre - found.tip).norm() < 1e-7 * bundle.length(), "{name}");
        assert!((last.frame.column(0) - found.frame.column(0)).norm() < 1e-6, "{name}");
        for pair in shape.windows(2) {
            let step = (pair[1].centre - pair[0].centre).norm();
            let length = pair[1].length - pair[0].length;
            assert!(
                step <= length * (1.0 + 1e-9) + 1e-12 && length < spacing * 1.2,
                "{name}: {step} {length}"
            );
        }
        for tube in &first.tubes {
            assert!(
                (tube.tension - found.efforts[tube.tube].force).abs() < 1e-9 * (1.0 + tube.tension.abs()),
                "{name}"
            );
        }
    }
}

/// A control loop that goes over a loop of commands in place has at every pose the equilibrium that is solved for from rest, stable as that, whether or not
/// slopes of neighbours led there; and where a robot snaps it says so as the other.
#[test]
fn a_control_loop_finds_what_is_found_from_rest() {
    // Of the tip and the last section (parts of the length), forces and Jacobian (parts of themselves).
    compare_loops(1e-8, [1e-6, 1e-7, 1e-5, 1e-4]);
    compare_loops(1e-6, [1e-5, 1e-5, 5e-5, 1e-3]);
}

fn compare_loops(tolerance: f64, [tip, end, force, jacobian]: [f64; 4]) {
    let mut compared = 0;
    for case in &cases() {
        let design = design(case);
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle).with_loop_tolerance(tolerance);
        let first = command(case);
        let mut found = solver.solve(&first);
        let tubes = design.tubes.len();
        for step in 1..=24 {
            let phase = f64::from(step) * std::f64::consts::PI / 12.0;
            let mut moved = first.clone();
            for (tube, drive) in moved.drives.iter_mut().enumerate().skip(tubes - 1) {
                let by = [4e-4 * phase.sin(), 0.2 * (1.0 - phase.cos()) / (tube as f64 + 1.0)];
                drive.translation = Drive::Motion(drive.translation.value() + by[0]);
                drive.rotation = Drive::Motion(drive.rotation.value() + by[1]);
            }
            solver.solve_into(&moved, &mut found);
            // Steps of the loop are of lower order where that does; these are not.
            let mut fresh = BundleSolver::new(&bundle).with_tolerance(1e-11);
            let whole = fresh.solve(&moved);
            assert_eq!(
                (found.converged, found.stable),
                (whole.converged, whole.stable),
                "{} at {step}",
                design.name
            );
            if !found.stable {
                continue;
            }
            compared += 1;
            let away = (found.tip - whole.tip).norm();
            assert!(away < tip * bundle.length(), "{} at {step}: {away:e} m", design.name);
            for (own, other) in found.efforts.iter().zip(&whole.efforts) {
                let size = force * (1.0 + other.force.abs());
                assert!((own.force - other.force).abs() < size, "{} at {step}", design.name);
            }
            // The derivatives that led there, and the sections at the ends of its steps, are its own.
            if let (Some(own), Some(other)) = (solver.tip_jacobian(&found), fresh.tip_jacobian(&whole)) {
                let off = (&own - &other).norm() / other.norm();
                assert!(off < jacobian, "{} at {step}: Jacobians differ by {off:e}", design.name);
            }
            let last = solver.shape(&found, f64::INFINITY).pop().unwrap().centre;
            assert!((last - found.tip).norm() < end * bundle.length(), "{} at {step}", design.name);
        }
        // Far away, with a motor turned by more than a quarter, it goes on in steps.
        solver.solve_into(&first, &mut found);
        assert!((found.tip - solver.solve(&first).tip).norm() < 1e-6 * bundle.length(), "{}", design.name);
    }
    assert!(compared > 180, "{compared}");
}
