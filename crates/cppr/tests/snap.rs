//! The snap of a classical two-tube robot against its closed form (docs/src/snap.md; Dupont, Lock, Itkowitz and Butler 2010).

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::analysis::continuation::{End, PointKind, Tracing};
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign, BundleFamily, Part, TubeParts};
use cppr::design::{Profile, StiffnessTube};
use cppr::solve::{Drive, Freedom, Input};
use std::f64::consts::{PI, TAU};

/// Two tubes of different stiffness, curved towards +Y: bending and torsional stiffness (N m²), curvature (1/m).
const TUBES: [(f64, f64, f64); 2] = [(0.02, 0.016, 12.0), (0.006, 0.0045, 20.0)];
const LENGTH: f64 = 0.15;

fn bundle(length: f64) -> Bundle {
    let tube = |(bending, torsion, curvature): (f64, f64, f64)| {
        let body = StiffnessTube {
            centroid_offset: Profile::constant(0.0),
            direction: Profile::constant(0.0),
            bending_y: Profile::constant(bending),
            bending_z: Profile::constant(bending),
            torsion: Profile::constant(torsion),
            axial: None,
            mass_per_length: Profile::constant(0.0),
            centroid_offset_factor: 1.0,
        };
        let part = Part { length, body: body.into(), rest_curvature: curvature, rest_direction: 0.0 };
        TubeParts { parts: vec![part], shaft: None }
    };
    let design = BundleDesign { name: "two".into(), tubes: TUBES.map(tube).to_vec(), joints: Vec::new() };
    Bundle::new(&design).unwrap()
}

/// Length over the length that bending and torsion make together.
fn slenderness(length: f64) -> f64 {
    let [(k, g, u), (l, h, v)] = TUBES;
    let (bending, torsion) = (k * l / (k + l), g * h / (g + h));
    length * (u * v * bending / torsion).sqrt()
}

/// Jacobi's cd(t, k), by the descending transformation (Abramowitz and Stegun 16.4).
fn cd(t: f64, k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    let mut ratios = Vec::new();
    while (a - b).abs() > 1e-15 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        ratios.push(c / a);
    }
    let mut angle = 2_f64.powi(i32::try_from(ratios.len()).unwrap()) * a * t;
    for ratio in ratios.into_iter().rev() {
        angle = 0.5 * (angle + (ratio * angle.sin()).asin());
    }
    angle.cos() / (1.0 - (k * angle.sin()).powi(2)).sqrt()
}

/// Angle between the tubes at the plate for one at the tip, 0 to π.
fn base_angle(tip: f64, slenderness: f64) -> f64 {
    let k = (0.5 * (PI - tip)).sin();
    PI - 2.0 * (k * cd(slenderness, k)).asin()
}

/// Greatest base angle of the branch from rest, where it is greater than π: there it snaps.
fn critical(slenderness: f64) -> f64 {
    let (mut low, mut high) = (0.0, PI);
    // Golden section: the angle has one maximum between the straight and the opposed tip.
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    for _ in 0..80 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if base_angle(a, slenderness) > base_angle(b, slenderness) { high = b } else { low = a }
    }
    base_angle(0.5 * (low + high), slenderness)
}

/// Angle between the tubes at the tip.
fn tip_angle(solver: &BundleSolver, found: &BundleEquilibrium) -> f64 {
    let shape = solver.shape(found, 1.0);
    let last = shape.iter().rev().find(|section| section.tubes.len() == 2).unwrap();
    last.tubes[1].angle - last.tubes[0].angle
}

fn turned(solver: &mut BundleSolver, start: &BundleEquilibrium, angle: f64) -> BundleEquilibrium {
    let mut command = solver.held();
    command.drives[1].rotation = Drive::Motion(angle);
    solver.solve_from(&command, start)
}

#[test]
fn the_angles_are_those_of_a_pendulum() {
    let bundle = bundle(LENGTH);
    let mut solver = BundleSolver::new(&bundle);
    let mut found = solver.solve(&solver.held());
    let slenderness = slenderness(LENGTH);
    for step in 1..=23 {
        let angle = f64::from(step) * 10_f64.to_radians();
        found = turned(&mut solver, &found, angle);
        assert!(found.converged && found.stable);
        let tip = tip_angle(&solver, &found);
        let off = base_angle(tip, slenderness) - angle;
        assert!(off.abs() < 1e-6, "turned by {angle}: the tip stands at {tip}, which asks for {off} more");
    }
}

#[test]
fn two_curved_tubes_snap_at_the_closed_form() {
    let bundle = bundle(LENGTH);
    let mut solver = BundleSolver::new(&bundle);
    let mut found = solver.solve(&solver.held());
    let expected = critical(slenderness(LENGTH));
    // The branch from rest ends at a fold: beyond it the tip is on the other side.
    let (mut low, mut high) = (0.0, 1.5 * PI);
    for _ in 0..4 {
        let steps = 24;
        let (from, width) = (low, (high - low) / f64::from(steps));
        for step in 1..=steps {
            let angle = from + width * f64::from(step);
            let next = turned(&mut solver, &found, angle);
            if next.converged && next.stable && tip_angle(&solver, &next) < PI {
                (found, low) = (next, angle);
            } else {
                high = angle;
                break;
            }
        }
    }
    assert!((0.5 * (low + high) - expected).abs() < 1e-4, "snaps at {low} to {high}, closed form {expected}");
    assert!(expected > PI + 0.5);
}

/// Turned by a whole turn two curved tubes pass the fold, come back, and pass another one: the path is symmetric about a half turn.
#[test]
fn a_path_passes_the_folds() {
    let bundle = bundle(LENGTH);
    let mut solver = BundleSolver::new(&bundle);
    let input = Input { tube: 2, freedom: Freedom::Rotation, is_motion: true };
    let family = BundleFamily::motor(solver.held(), input, TAU).unwrap();
    let branches = solver.trace(&family, &Tracing::default());
    let branch = &branches[0];
    assert_eq!((branches.len(), branch.end), (1, End::Last));
    let folds: Vec<f64> =
        branch.points.iter().filter(|p| p.kind == PointKind::Fold).map(|p| p.parameter).collect();
    assert_eq!(folds.len(), 2, "{folds:?}");
    let expected = critical(slenderness(LENGTH));
    assert!((folds[0] - expected).abs() < 1e-6, "folds at {}, closed form {expected}", folds[0]);
    assert!((folds[0] + folds[1] - TAU).abs() < 1e-6, "{folds:?}");
    assert!(branch.points.iter().any(|p| p.inertia == Some(1)), "unstable between the folds");
    let last = branch.points.last().unwrap();
    assert_eq!(last.inertia, Some(0));
    assert!((last.tip - branch.points[0].tip).norm() < 1e-8, "a whole turn leads back");
}

#[test]
fn short_tubes_do_not_snap() {
    // Below π/2 the base angle grows with the tip angle up to π: no fold.
    let length = LENGTH * 0.9 * 0.5 * PI / slenderness(LENGTH);
    let bundle = bundle(length);
    let mut solver = BundleSolver::new(&bundle);
    let mut found = solver.solve(&solver.held());
    let mut before = 0.0;
    for step in 1..=36 {
        found = turned(&mut solver, &found, f64::from(step) * 10_f64.to_radians());
        assert!(found.converged && found.stable, "step {step}");
        let tip = tip_angle(&solver, &found);
        assert!(tip > before && tip - before < 1.0, "step {step}: {before} to {tip}");
        before = tip;
    }
    assert!((before - 2.0 * PI).abs() < 1e-6);
}
