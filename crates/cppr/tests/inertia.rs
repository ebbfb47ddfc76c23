//! Negative eigenvalues of the second variation: Euler's column, two of them at once. `accuracy` compares them with the modal solver's on
//! random robots.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign, Part, TubeParts};
use cppr::design::StiffnessTube;
use cppr::statics::Loads;
use std::f64::consts::PI;

fn rod(bending: [f64; 2]) -> Bundle {
    let part = Part {
        length: 0.1,
        body: StiffnessTube::uniform(0.0, 0.0, bending, 1.5e-3).into(),
        rest_curvature: 0.0,
        rest_direction: 0.0,
    };
    let tube = TubeParts { parts: vec![part], shaft: None };
    Bundle::new(&BundleDesign { name: "rod".into(), tubes: vec![tube], joints: Vec::new() }).unwrap()
}

/// A column that is clamped at one end buckles at (2k − 1)² π² EI/(4 L²), in both directions at once where it is round. The count is
/// within the error of its midpoint rule on 32 intervals, a twelfth of the square of the phase (2k − 1) π/64.
#[test]
fn columns_buckle_as_euler_said() {
    for bending in [[2e-3, 2e-3], [2e-3, 9e-3]] {
        let bundle = rod(bending);
        let mut solver = BundleSolver::new(&bundle);
        let mut command = solver.held();
        let critical = |k: u32, ei: f64| f64::from(2 * k - 1).powi(2) * PI * PI * ei / 0.04;
        for k in 1..4 {
            let error = (f64::from(2 * k - 1) * PI / 64.0).powi(2) / 12.0;
            for factor in [1.0 - 1.1 * error, 1.0 + 0.1 * error] {
                let force = critical(k, bending[0]) * factor;
                command.loads = Loads::tip_force(Vector3::new(-force, 0.0, 0.0));
                let found = solver.solve(&command);
                assert!(found.converged && (found.tip.x - 0.1).abs() < 1e-12);
                let expected =
                    (1..5).map(|k| bending.iter().filter(|ei| critical(k, **ei) < force).count()).sum();
                assert_eq!(solver.inertia(&found), Some(expected), "{bending:?}, {force} N");
                assert_eq!(found.stable, expected == 0, "{bending:?}, {force} N");
            }
        }
    }
}

/// A control loop that presses a straight column does not move it, so that slopes of neighbours lead on: it says nevertheless where the column buckles.
#[test]
fn a_control_loop_sees_a_column_buckle() {
    for bending in [[2e-3, 2e-3], [2e-3, 9e-3]] {
        let bundle = rod(bending);
        let mut solver = BundleSolver::new(&bundle);
        let mut command = solver.held();
        let euler = PI * PI * bending[0] / 0.04;
        let pressed = |share: f64| Loads::tip_force(Vector3::new(-share * euler, 0.0, 0.0));
        command.loads = pressed(0.5);
        let mut found = solver.solve(&command);
        for share in [0.6, 0.8, 0.99, 1.01, 1.2, 0.9] {
            command.loads = pressed(share);
            solver.solve_into(&command, &mut found);
            assert_eq!(found.stable, share < 1.0, "{bending:?}, {share} of Euler's load");
        }
    }
}
