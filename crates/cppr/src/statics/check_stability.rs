//! Margin, critical mode and inertia against the eigenvalue problem that dual numbers pose.
//!
//! With the Hessian 𝓛_uu of the loaded robot and the Hessian E of the straight, unloaded one, both from hyper-dual numbers, the
//! critical mode m and the margin μ solve vᵀ (𝓛_uu − μ E) m = 0 for all motions v that the actuators leave free, and no free
//! motion has a lower quotient. For uniform straight tubes E is what `analysis::stability` measures against.

use super::check_sensitivity::Plain;
use crate::design::{Profile, Robot, RobotDesign, StiffnessTube, TubeDesign};
use crate::kinematics::Resolution;
use crate::solve::{Actuator, Command, Drive, Settings, Solver, Status};
use crate::statics::{Loads, RotationMeans};
use nalgebra::{Cholesky, DMatrix, DVector, SVD, Vector3};
use std::f64::consts::PI;

/// A follower whose centroid stands at an angle against the one opposed to the leader's.
fn uniform(angle: f64) -> Robot {
    let tube = |offset: f64, direction: f64, scale: f64| {
        TubeDesign::Stiffness(StiffnessTube {
            centroid_offset: Profile::constant(offset),
            direction: Profile::constant(direction),
            bending_y: Profile::constant(0.012 * scale),
            bending_z: Profile::constant(0.004 * scale),
            torsion: Profile::constant(0.005 * scale),
            axial: None,
            mass_per_length: Profile::constant(0.0),
            centroid_offset_factor: 1.0,
        })
    };
    let tubes = vec![tube(2e-3, PI, 1.0), tube(1.5e-3, angle, 0.6)];
    Robot::from_design(RobotDesign { name: "uniform".into(), length: 0.15, tubes }).unwrap()
}

/// A basis of the motions that keep the conditions.
fn free_motions(plain: &Plain) -> DMatrix<f64> {
    let n = plain.u.len();
    let kept = plain.matrix.view((n, 0), (plain.matrix.nrows() - n, n)).into_owned();
    // The missing right singular vectors come with a square matrix.
    let mut square = DMatrix::zeros(n, n);
    square.rows_mut(0, kept.nrows()).copy_from(&kept);
    let svd = SVD::new(square, false, true);
    let v = svd.v_t.unwrap();
    let free: Vec<usize> = (0..n).filter(|&i| svd.singular_values[i] < 1e-12).collect();
    assert_eq!(free.len() + kept.nrows(), n);
    DMatrix::from_fn(n, free.len(), |i, j| v[(free[j], i)])
}

#[test]
fn margin_and_critical_mode_solve_the_eigenvalue_problem_of_dual_numbers() {
    let modes = Resolution { twist: 3, bending_y: 4, bending_z: 4, angle: 3, stretch: 0, nodes: 8 };
    let settings = Settings { tolerance: 1e-13, ..Settings::default() }.with_resolution(modes);
    let (motion, effort) = (Drive::Motion, Drive::Effort);
    for (angle, push_pull, rotation, force, inertia) in [
        (0.6, motion(3e-3), motion(0.4), Vector3::new(0.0, 0.2, 0.1), 0),
        (-1.1, effort(2.0), effort(3e-3), Vector3::new(-0.1, 0.1, -0.1), 0),
        // Pressed back against its bend, the robot wants to leave its plane.
        (0.0, motion(-3e-3), motion(0.0), Vector3::new(-4.0, 0.0, 0.0), 1),
    ] {
        let robot = uniform(angle);
        let mut solver = Solver::with_settings(&robot, settings).unwrap();
        let rest = solver.rest();
        let straight = Plain::new(&robot, &rest);
        let n = straight.u.len();
        let elastic = straight.matrix.view((0, 0), (n, n)).into_owned();
        let actuators = vec![Actuator { push_pull, rotation }];
        let command =
            Command { actuators, loads: Loads::tip_force(force), rotation_means: RotationMeans::Base };
        let found = solver.solve(&command).unwrap();
        assert_eq!(found.status == Status::Converged, inertia == 0, "{force}: {}", found.status);
        let own = solver.stability(&found).unwrap();
        let plain = Plain::new(&robot, &found);
        let hessian = plain.matrix.view((0, 0), (n, n)).into_owned();
        let free = free_motions(&plain);
        let on_free = |m: &DMatrix<f64>| free.transpose() * m * &free;
        let (hessian, elastic) = (on_free(&hessian), on_free(&elastic));

        // The mode keeps the conditions, and solves the problem.
        let mode = DVector::from_column_slice(&own.mode);
        let share = free.transpose() * &mode;
        assert!((&free * &share - &mode).norm() < 1e-9 * mode.norm(), "{force}: the mode moves an actuator");
        let rest = (&hessian - &elastic * own.margin) * &share;
        assert!(rest.norm() < 1e-8 * (&elastic * &share).norm(), "{force}: {}", rest.norm());
        // It is the lowest, and the number of negative ones is right.
        let definite = |shift: f64| Cholesky::new(&hessian - &elastic * shift).is_some();
        assert!(definite(own.margin - 1e-6) && !definite(own.margin + 1e-6), "{force}: {}", own.margin);
        let negative = hessian.symmetric_eigenvalues().iter().filter(|v| **v < 0.0).count();
        assert_eq!((own.inertia, negative), (inertia, inertia), "{force}");
        // The tip goes where dual numbers take it.
        let shift = (&plain.twist * &mode).fixed_rows::<3>(0).normalize();
        let direction = own.tip_direction;
        assert!(
            direction.cross(&shift).norm() < 1e-7 && direction[direction.icamax()] > 0.0,
            "{direction} {shift}"
        );
        if inertia == 1 {
            assert!(direction.z > 0.999, "sideways: {direction}");
        }
    }
}
