//! Paths of equilibria of a single rod against closed forms: buckling loads, branches, a fold.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{reference, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::continuation::{Branch, End, Family, PathPoint, PointKind, Tracing};
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Settings, Solver};
use cppr::statics::{Frame, Loads, Thread, Wrench};
use serde_json::Value;
use std::f64::consts::PI;

/// Length 1, bending stiffness along both axes, GJ.
fn rod(bending: [f64; 2], torsion: f64) -> Robot {
    robot(1.0, vec![stiff_tube(0.0, bending, torsion, 0.0, 0.0)])
}

fn case(name: &str) -> Value {
    let data = reference("rods");
    data["cases"].as_array().unwrap().iter().find(|c| c["name"] == name).unwrap()["outputs"].clone()
}

fn critical_load(name: &str) -> f64 {
    case("critical_loads")[name].as_f64().unwrap()
}

fn planar(modes: usize) -> Settings {
    let resolution = Resolution { bending_z: modes, nodes: 2 * modes, ..Resolution::PLANAR };
    Settings::default().with_resolution(resolution)
}

fn tip_force(x: f64, y: f64, z: f64) -> Command {
    Command::pull(&[]).with_loads(Loads::tip_force(Vector3::new(x, y, z)))
}

fn branches(robot: &Robot, settings: Settings, family: &Family, tracing: &Tracing) -> Vec<Branch> {
    Solver::with_settings(robot, settings).unwrap().trace(family, tracing).unwrap()
}

fn special(branch: &Branch) -> Vec<&PathPoint> {
    branch.points.iter().filter(|p| p.kind != PointKind::Regular).collect()
}

#[test]
fn a_column_buckles_into_the_elastica() {
    let (robot, settings) = (rod([1.0, 1.0], 1.0), planar(24));
    let family = Family::load(tip_force(-1.0, 0.0, 0.0), 0.0, 30.0).unwrap();
    let tracing = Tracing { depth: 1, ..Tracing::default() };
    let branches = branches(&robot, settings, &family, &tracing);
    let euler = critical_load("euler_clamped_free");
    // The straight column: Euler's load and nine times it.
    let straight = special(&branches[0]);
    assert_eq!(branches[0].end, End::Last);
    assert_eq!(straight.len(), 2);
    for (point, factor) in straight.iter().zip([1.0, 9.0]) {
        assert_eq!(point.kind, PointKind::BranchPoint { multiplicity: 1 });
        assert!((point.parameter / (factor * euler) - 1.0).abs() < 1e-8, "{}", point.parameter);
    }
    for point in &branches[0].points {
        let below = [euler, 9.0 * euler].iter().filter(|&&load| load < point.parameter - 1e-5).count();
        if point.kind == PointKind::Regular {
            assert_eq!(point.inertia, Some(below), "{}", point.parameter);
        }
    }
    // Two branches at each, mirror images of each other.
    assert_eq!(branches.len(), 5);
    let elastica = case("elastica_clamped_free_axial_postbuckling");
    for pair in [[1, 2], [3, 4]] {
        let [one, other] = pair.map(|b| &branches[b]);
        assert_eq!(one.origin.unwrap().point, other.origin.unwrap().point);
        assert_ne!(one.origin.unwrap().along, other.origin.unwrap().along);
        assert_eq!(one.points.len(), other.points.len());
        for (a, b) in one.points.iter().zip(&other.points) {
            assert!((a.tip.y + b.tip.y).abs() < 1e-9 && (a.tip.x - b.tip.x).abs() < 1e-9);
        }
    }
    // The first mode is stable all along, the second never.
    assert!(branches[1].points[1..].iter().all(|p| p.inertia == Some(0)));
    assert!(branches[3].points[1..].iter().all(|p| p.inertia == Some(1)));
    // Every point of the first lies on the elastica of the tables.
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    for (degrees, expected) in elastica.as_object().unwrap() {
        let load = expected["PL2_over_EI"].as_f64().unwrap();
        let near = branches[1].points.windows(2).find(|p| p[1].parameter >= load).unwrap();
        let command = tip_force(-load, 0.0, 0.0);
        let found = solver.solve_from(&command, &near[1].equilibrium).unwrap();
        let tip = solver.tip(&found).centre;
        let tolerance = if degrees == "1" { 1e-6 } else { 1e-8 };
        assert!((tip.x - expected["x_over_L"].as_f64().unwrap()).abs() < tolerance, "{degrees}");
        assert!((tip.y.abs() - expected["y_over_L"].as_f64().unwrap()).abs() < tolerance, "{degrees}");
    }
}

#[test]
fn a_round_column_has_a_double_branch_point() {
    let robot = rod([1.0, 1.0], 1.0);
    let family = Family::load(tip_force(-1.0, 0.0, 0.0), 0.0, 4.0).unwrap();
    let branches =
        branches(&robot, Settings::default(), &family, &Tracing { depth: 1, ..Tracing::default() });
    let straight = special(&branches[0]);
    assert_eq!(straight.len(), 1);
    assert_eq!(straight[0].kind, PointKind::BranchPoint { multiplicity: 2 });
    assert!((straight[0].parameter - critical_load("euler_clamped_free")).abs() < 1e-7);
    // Both critical eigenvectors, both ways: the same elastica in different planes.
    assert_eq!(branches.len(), 5);
    let deflection = |b: &Branch| {
        let tip = b.points.last().unwrap().tip;
        tip.y.hypot(tip.z)
    };
    for branch in &branches[1..] {
        assert_eq!(branch.end, End::Last);
        assert!((deflection(branch) - deflection(&branches[1])).abs() < 1e-7);
        assert!(branch.points[1..].iter().all(|p| p.inertia == Some(0)), "neutral, but not unstable");
    }
    assert!(deflection(&branches[1]) > 0.7);
}

#[test]
fn a_load_that_follows_the_tip_branches_nowhere() {
    // Beck's column: under a force along the tip's tangent no equilibrium but the straight one is near, whatever the force. The
    // symmetric part of its tangent turns indefinite all the same, which is no branch point.
    let wrench = Wrench { frame: Frame::Section, ..Wrench::tip_force(Vector3::new(-1.0, 0.0, 0.0)) };
    let command = Command::pull(&[]).with_loads(Loads { wrenches: vec![wrench], ..Loads::none() });
    let family = Family::load(command, 0.0, 40.0).unwrap();
    let tracing = Tracing { depth: 1, ..Tracing::default() };
    let branches = branches(&rod([1.0, 1.0], 1.0), planar(16), &family, &tracing);
    assert_eq!(branches.len(), 1);
    assert_eq!(branches[0].end, End::Last);
    assert!(special(&branches[0]).is_empty(), "{:?}", special(&branches[0]));
    assert!(branches[0].points.last().unwrap().inertia > Some(0), "the safe side");
}

#[test]
fn steps_are_bounded_over_all_branches() {
    let strip = rod([1.0, 1e6], 1.0);
    let family = Family::load(tip_force(0.0, 1.0, 0.0), 0.0, 6.0).unwrap();
    let trace = |steps| {
        let tracing = Tracing { depth: 1, steps, ..Tracing::default() };
        branches(&strip, Settings::default(), &family, &tracing)
    };
    let all = trace(usize::MAX);
    assert_eq!((all.len(), all[0].end, all[1].end), (3, End::Last, End::Last));
    // Enough for the first branch and a little of the next.
    let steps = all[0].points.len() + 10;
    let some = trace(steps);
    assert_eq!([some[0].end, some[1].end, some[2].end], [End::Last, End::Points, End::Points]);
    // No steps: the start, the branch point, and with what each of the others begins.
    let taken = some.iter().map(|b| b.points.len()).sum::<usize>() - 6;
    assert!(
        taken <= steps && some[1].points.len() > 2 && some[1].points.len() < all[1].points.len(),
        "{taken}"
    );
    assert!(trace(3).iter().all(|b| b.end == End::Points));
}

#[test]
fn a_strip_buckles_sideways() {
    // The classical value neglects the deflection before buckling, which goes to zero with EI_Y/EI_Z.
    let strip = rod([1.0, 1e6], 1.0);
    let family = Family::load(tip_force(0.0, 1.0, 0.0), 0.0, 6.0).unwrap();
    let branches =
        branches(&strip, Settings::default(), &family, &Tracing { depth: 1, ..Tracing::default() });
    let flat = special(&branches[0]);
    assert_eq!(flat.len(), 1);
    let prandtl = critical_load("prandtl_lateral_cantilever_PL2_over_sqrt_EI_GJ");
    assert!((flat[0].parameter - prandtl).abs() < 1e-5, "{}", flat[0].parameter);
    assert_eq!(branches.len(), 3);
    let ends = [1, 2].map(|b| branches[b].points.last().unwrap());
    assert!(ends[0].tip.z.abs() > 0.3, "{}", ends[0].tip);
    assert!((ends[0].tip.z + ends[1].tip.z).abs() < 1e-8);
    assert!(ends.iter().all(|p| p.inertia == Some(0)));
}

/// Eight threads over eyelets at a distance hold two points of the tip body on the axis: with their tension the hold
/// becomes a clamp that slides and turns.
fn clamped(hold: f64) -> Loads {
    let (arm, distance) = (0.5, 10.0);
    let mut threads = Vec::new();
    for along in [0.0, arm] {
        for (y, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            threads.push(Thread {
                tension: hold * distance,
                pulley: Vector3::new(1.0 + along, y * distance, z * distance),
                radius: 0.0,
                left: true,
                point: Vector3::new(along, 0.0, 0.0),
            });
        }
    }
    Loads { threads, ..Loads::none() }
}

#[test]
fn a_clamped_rod_buckles_under_twist() {
    let robot = rod([1.0, 1.0], 1.0);
    let resolution = Resolution { bending_y: 14, bending_z: 14, nodes: 36, ..Resolution::SPATIAL };
    let settings = Settings::default().with_resolution(resolution);
    let buckling = |hold: f64| {
        let torque = |m: f64| {
            let wrench = Wrench::tip_moment(Vector3::new(m, 0.0, 0.0));
            Command::pull(&[]).with_loads(Loads { wrenches: vec![wrench], ..clamped(hold) })
        };
        let family = Family::between(torque(0.0), torque(12.0)).unwrap();
        let branches = branches(&robot, settings, &family, &Tracing::default());
        let found = special(&branches[0]);
        assert_eq!(found.len(), 1, "{:?}", found.iter().map(|p| (p.fraction, p.kind)).collect::<Vec<_>>());
        assert_eq!(found[0].kind, PointKind::BranchPoint { multiplicity: 2 });
        12.0 * found[0].fraction
    };
    // The rest of give goes with one over the hold.
    let [soft, stiff] = [1e5, 2e5].map(buckling);
    let limit = 2.0 * stiff - soft;
    let expected = critical_load("twist_clamped_clamped_ML_over_EI");
    assert!((limit - expected).abs() < 1e-6, "{soft} {stiff} {limit} {expected}");
}

/// ∫ dφ/√(1 − k² sin² φ) from 0 to `angle`, by the trapezoidal rule on a periodic integrand or Simpson's.
fn elliptic(angle: f64, k: f64) -> f64 {
    let n = 4000;
    let f = |phi: f64| 1.0 / (1.0 - (k * phi.sin()).powi(2)).sqrt();
    let h = angle / f64::from(n);
    (0..n).map(|i| f64::from(i) * h).map(|a| h / 6.0 * (f(a) + 4.0 * f(a + 0.5 * h) + f(a + h))).sum()
}

#[test]
fn an_inclined_load_has_a_fold() {
    // A force P at the angle β from −X. With ψ the angle of the tangent to the line of force the rod is a pendulum; bent
    // against the load, √(P/EI) L = K(k) + F(φ₀, k) with sin φ₀ = sin(β/2)/k, which has a least value: the fold.
    let beta = 0.2_f64;
    let load = |k: f64| {
        let phi = ((0.5 * beta).sin() / k).asin();
        (elliptic(0.5 * PI, k) + elliptic(phi, k)).powi(2)
    };
    let (mut low, mut high) = ((0.5 * beta).sin(), 0.9);
    for _ in 0..80 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if load(a) < load(b) { high = b } else { low = a }
    }
    let fold = load(0.5 * (low + high));

    let mut solver = Solver::with_settings(&rod([1.0, 1.0], 1.0), planar(16)).unwrap();
    let command = tip_force(-beta.cos(), beta.sin(), 0.0);
    // Under six times the load, bent against it by a moment first.
    let start = command.loads.scaled(6.0);
    let mut bent = start.clone();
    bent.wrenches[0].moment.z = -4.0;
    let held = Command::pull(&[]);
    let bent = solver.solve(&held.clone().with_loads(bent)).unwrap();
    let start = solver.solve_from(&held.with_loads(start), &bent).unwrap();
    assert!(solver.tip(&start).centre.y < -0.3);
    let family = Family::load(command, 6.0, 0.5).unwrap();
    let branches = solver.trace_from(&family, &Tracing::default(), &start).unwrap();
    let found = special(&branches[0]);
    assert_eq!(branches[0].end, End::First);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].kind, PointKind::Fold);
    assert!((found[0].parameter / fold - 1.0).abs() < 1e-9, "{} {fold}", found[0].parameter);
    // Stable before the fold, one negative eigenvalue behind it.
    let at = branches[0].points.iter().position(|p| p.kind == PointKind::Fold).unwrap();
    assert!(branches[0].points[..at].iter().all(|p| p.inertia == Some(0)));
    assert!(branches[0].points[at + 1..].iter().all(|p| p.inertia == Some(1)));
    // On both sides of it the load is that of the closed form at the rod's own modulus.
    for point in &branches[0].points {
        let tip = solver.tip(&point.equilibrium).rotation;
        let psi = tip[(1, 0)].atan2(tip[(0, 0)]) + beta;
        assert!((point.parameter / load((0.5 * psi).sin().abs()) - 1.0).abs() < 1e-7, "{psi}");
    }
}
