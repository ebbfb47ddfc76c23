//! Paths of bundles against closed forms and the modal solver: folds, branch points, other branches.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::prototype;
use cppr::Vector3;
use cppr::analysis::continuation::{End, Family, FamilyProblem, PointKind, Tracing};
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign, BundleFamily, Part, TubeParts};
use cppr::design::{BelowPlate, StiffnessTube};
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Drive, Freedom, Input, Settings, Solver};
use cppr::statics::Loads;
use std::f64::consts::PI;

/// The two curved tubes that are shipped.
fn curved() -> Bundle {
    let tube = |bending: f64, torsion: f64, curvature: f64| TubeParts {
        parts: vec![Part {
            length: 0.15,
            body: StiffnessTube::uniform(0.0, 0.0, [bending; 2], torsion).into(),
            rest_curvature: curvature,
            rest_direction: 0.0,
        }],
        shaft: None,
    };
    let tubes = vec![tube(0.02, 0.016, 12.0), tube(0.006, 0.0045, 20.0)];
    Bundle::new(&BundleDesign { name: "two".into(), tubes, joints: Vec::new() }).unwrap()
}

/// A clamped column leaves its axis at Euler's load, to both sides, and where it is round in any direction.
#[test]
fn a_column_leaves_its_axis_at_eulers_load() {
    for (bending, multiplicity) in [([2e-3, 9e-3], 1), ([2e-3, 2e-3], 2)] {
        let part = Part {
            length: 0.1,
            body: StiffnessTube::uniform(0.0, 0.0, bending, 1.5e-3).into(),
            rest_curvature: 0.0,
            rest_direction: 0.0,
        };
        let tubes = vec![TubeParts { parts: vec![part], shaft: None }];
        let bundle = Bundle::new(&BundleDesign { name: "rod".into(), tubes, joints: Vec::new() }).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let euler = PI * PI * 2e-3 / 0.04;
        let mut command = solver.held();
        command.loads = Loads::tip_force(Vector3::new(-euler, 0.0, 0.0));
        let family = BundleFamily::load(command, 0.0, 1.5).unwrap();
        let branches = solver.trace(&family, &Tracing { depth: 1, ..Tracing::default() });
        let point =
            branches[0].points.iter().find(|p| matches!(p.kind, PointKind::BranchPoint { .. })).unwrap();
        assert_eq!(point.kind, PointKind::BranchPoint { multiplicity });
        // One step of the integration goes along the straight column, whose error is seen in slopes alone. Two eigenvalues that change together are counted, within
        // the count's own error.
        let within = if multiplicity == 1 { 1e-5 } else { 3e-4 };
        assert!((point.parameter - 1.0).abs() < within, "{}", point.parameter);
        assert!(branches.len() >= 3, "{}", branches.len());
        for branch in &branches[1..] {
            let last = branch.points.last().unwrap();
            // A round column may turn about its axis: one eigenvalue stays zero.
            assert!(
                branch.end == End::Last && last.inertia.is_none_or(|count| count == 0),
                "{bending:?}: {:?} {:?}",
                branch.end,
                last.inertia
            );
            assert!(last.tip.y.hypot(last.tip.z) > 0.05, "{}", last.tip);
        }
    }
}

/// A pushed robot under a load on its tip snaps sideways where the modal solver says, and comes back where it says.
#[test]
fn a_pushed_robot_snaps_where_the_modal_solver_says() {
    let robot = prototype("R3", 1.27, BelowPlate::Plain);
    let loads = Loads::tip_force(Vector3::new(-1.0, 0.0, 0.0));
    let settings = Settings { resolution: Resolution::SPATIAL.refined(2), ..Settings::default() };
    let mut modal = Solver::with_settings(&robot, settings).unwrap();
    let family = Family::load(Command::pull(&[-5e-3]).with_loads(loads.clone()), 1.0, 1.6).unwrap();
    let tracing = Tracing { depth: 1, ..Tracing::default() };
    let expected = modal.trace(&family, &tracing).unwrap();
    let bundle = Bundle::from_robot(&robot).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let mut command = solver.held();
    command.drives[1].translation = Drive::Motion(-5e-3);
    command.loads = loads;
    let family = BundleFamily::load(command, 1.0, 1.6).unwrap();
    let found = solver.trace(&family, &tracing);
    let special = |kinds: Vec<(PointKind, f64)>| {
        kinds
            .into_iter()
            .filter(|(kind, _)| matches!(kind, PointKind::Fold | PointKind::BranchPoint { .. }))
            .collect()
    };
    let of_modal = |i: usize| -> Vec<(PointKind, f64)> {
        special(expected[i].points.iter().map(|p| (p.kind, p.parameter)).collect())
    };
    let of_bundle = |i: usize| -> Vec<(PointKind, f64)> {
        special(found[i].points.iter().map(|p| (p.kind, p.parameter)).collect())
    };
    for branch in 0..3 {
        let (own, other) = (of_bundle(branch), of_modal(branch));
        assert_eq!(own.len(), other.len(), "{branch}: {own:?}, {other:?}");
        assert!(!own.is_empty());
        for (a, b) in own.iter().zip(&other) {
            assert_eq!(a.0, b.0);
            assert!((a.1 - b.1).abs() < 1e-3, "{branch}: {a:?}, {b:?}");
        }
    }
}

#[test]
fn families_without_variation_are_refused() {
    let bundle = curved();
    let solver = BundleSolver::new(&bundle);
    let input = Input { tube: 2, freedom: Freedom::Rotation, is_motion: true };
    assert_eq!(BundleFamily::motor(solver.held(), input, 0.0), Err(FamilyProblem::Nothing));
    assert_eq!(BundleFamily::motor(solver.held(), input, f64::NAN), Err(FamilyProblem::NotFinite));
    assert_eq!(BundleFamily::load(solver.held(), 0.0, 1.0), Err(FamilyProblem::NoLoad));
    let other = Input { tube: 3, ..input };
    assert_eq!(BundleFamily::motor(solver.held(), other, 1.0), Err(FamilyProblem::Drives { tube: 3 }));
}
