//! Paths of robots against solves of single commands: through the baseplate, past folds, into the third dimension.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{prototype, three_with_edges};
use cppr::Vector3;
use cppr::analysis::continuation::{Branch, End, Family, FamilyProblem, PathPoint, PointKind, Tracing};
use cppr::design::{BelowPlate, Robot};
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Formulation, Freedom, Settings, Solver, Status};
use cppr::statics::{Loads, Station, Wrench};

const MM: f64 = 1e-3;

fn r1() -> Robot {
    prototype("R1", 1.27, BelowPlate::Plain)
}

fn first(robot: &Robot, family: &Family) -> Branch {
    Solver::new(robot).trace(family, &Tracing::default()).unwrap().swap_remove(0)
}

fn kinds(branch: &Branch) -> Vec<&PathPoint> {
    branch.points.iter().filter(|p| p.kind != PointKind::Regular).collect()
}

fn tension(force: f64, loads: Loads) -> Command {
    let actuator = Actuator { push_pull: Drive::Effort(force), ..Actuator::HELD };
    Command { actuators: vec![actuator], ..Command::pull(&[0.0]).with_loads(loads) }
}

/// Each point solved again from rest, under its own command.
fn each_is_an_equilibrium(robot: &Robot, points: impl Iterator<Item = PathPoint>) {
    let mut solver = Solver::new(robot);
    for point in points {
        solver.set_settings(*point.equilibrium.settings()).unwrap();
        let again = solver.solve(point.equilibrium.command()).unwrap();
        if again.status() != point.equilibrium.status() {
            eprintln!(
                "{} {:?} {:?} {:?} {:?} {:?} {:?}",
                point.parameter,
                again.status(),
                solver.tip(&again).centre,
                point.tip,
                point.margin,
                solver.stability(&again).map(|s| (s.margin, s.inertia)),
                solver.stability(&point.equilibrium).map(|s| s.margin)
            );
        }
        assert_eq!(again.status(), point.equilibrium.status(), "{}", point.parameter);
        let tip = solver.tip(&again).centre;
        assert!((tip - point.tip).norm() < 1e-9 * robot.length(), "{}: {tip} {}", point.parameter, point.tip);
        for (a, b) in again.actuators().iter().zip(point.equilibrium.actuators()) {
            assert!((a.tension - b.tension).abs() < 1e-7 && (a.motion - b.motion).abs() < 1e-10);
        }
    }
}

#[test]
fn a_push_goes_through_the_plate_and_past_loads() {
    let robot = r1();
    let at = |label: f64, force: Vector3<f64>| Wrench {
        station: Station::Label(label),
        ..Wrench::tip_force(force)
    };
    let wrenches =
        vec![at(10.0 * MM, Vector3::new(0.0, 0.1, 0.0)), at(20.0 * MM, Vector3::new(0.0, 0.0, 0.1))];
    let command =
        |pull: f64| Command::pull(&[pull]).with_loads(Loads { wrenches: wrenches.clone(), ..Loads::none() });
    for (from, to) in [(5.0, -45.0), (-45.0, 5.0)] {
        let family = Family::actuator(command(from * MM), 2, Freedom::PushPull, to * MM).unwrap();
        let branch = first(&robot, &family);
        assert_eq!(branch.end, End::Last);
        let passed = kinds(&branch);
        assert!(passed.iter().all(|p| p.kind == PointKind::Edge { tube: 2 }), "{from}");
        // The plate and two loads; the edge lies where the follower has moved by its label, nearly.
        assert_eq!(passed.len(), 3);
        let mut places: Vec<f64> = passed.iter().map(|p| p.parameter).collect();
        places.sort_unstable_by(|a, b| b.total_cmp(a));
        for (place, label) in places.iter().zip([0.0, 10.0, 20.0]) {
            assert!((place / MM + label).abs() < 0.2, "{places:?}");
        }
        assert!(branch.points.iter().all(|p| p.inertia == Some(0)));
        each_is_an_equilibrium(&robot, branch.points.iter().step_by(3).cloned());
    }
}

#[test]
fn actuation_alone_makes_no_prototype_unstable() {
    for (name, factor) in [("R1", 1.27), ("R2", 1.27), ("R3", 1.32), ("R4", 1.06)] {
        let robot = prototype(name, factor, BelowPlate::Plain);
        for to in [-25.0, 25.0] {
            let family = Family::actuator(Command::pull(&[0.0]), 2, Freedom::PushPull, to * MM).unwrap();
            let branch = first(&robot, &family);
            assert_eq!(branch.end, End::Last);
            assert!(kinds(&branch).iter().all(|p| p.kind == PointKind::Edge { tube: 2 }), "{name} {to}");
            assert!(branch.points.iter().all(|p| p.margin > Some(0.5)), "{name} {to}");
        }
    }
}

#[test]
fn two_edges_pass_each_other() {
    let robot = three_with_edges();
    let pull = |a: f64, b: f64| Command::pull(&[a * MM, b * MM]);
    let branch = first(&robot, &Family::between(pull(-0.3, -0.9), pull(-0.9, -0.3)).unwrap());
    assert_eq!(branch.end, End::Last);
    let passed = kinds(&branch);
    assert_eq!(passed.len(), 1);
    assert!((passed[0].fraction - 0.5).abs() < 0.05, "{}", passed[0].fraction);
    each_is_an_equilibrium(&robot, branch.points.iter().step_by(3).cloned());
}

#[test]
fn a_force_lets_the_follower_stand_at_the_plate() {
    let robot = r1();
    let loads = Loads::tip_force(Vector3::new(0.0, 0.2, 0.0));
    // The tensions at Δa = 0⁺ and 0⁻, by motion.
    let mut solver = Solver::new(&robot);
    let held = [1e-6, -1e-6].map(|part| {
        let command = Command::pull(&[part * robot.length()]).with_loads(loads.clone());
        solver.solve(&command).unwrap().actuators()[0].tension
    });
    assert!(held[0] - held[1] > 0.04);
    for (from, to) in [(5.0, 2.0), (2.0, 5.0)] {
        let family = Family::actuator(tension(from, loads.clone()), 2, Freedom::PushPull, to).unwrap();
        let branch = first(&robot, &family);
        assert_eq!(branch.end, End::Last);
        let passed = kinds(&branch);
        assert_eq!(passed.len(), 2, "{from}");
        let mut found = [passed[0].parameter, passed[1].parameter];
        found.sort_unstable_by(f64::total_cmp);
        assert!((found[0] - held[1]).abs() < 3e-4 && (found[1] - held[0]).abs() < 3e-4, "{found:?} {held:?}");
        // Between both nothing moves, outside something does.
        for point in branch.points.iter().filter(|p| p.kind == PointKind::Regular) {
            let state = point.equilibrium.actuators()[0];
            if (found[0] + 1e-3..found[1] - 1e-3).contains(&point.parameter) {
                assert!(state.motion.abs() < 1e-12);
            } else if !(found[0] - 1e-3..found[1] + 1e-3).contains(&point.parameter) {
                assert!(state.motion.abs() > 1e-7);
            }
            assert!((state.tension - point.parameter).abs() < 1e-9);
        }
        // And every point beyond is the equilibrium under its own motion.
        for point in branch.points.iter().step_by(5) {
            let state = point.equilibrium.actuators()[0];
            let command = Command::pull(&[state.motion]).with_loads(loads.clone());
            let again = solver.solve(&command).unwrap();
            let tip = solver.tip(&again).centre;
            assert!((tip - point.tip).norm() < 1e-8 * robot.length());
        }
    }
}

/// A pushed robot under a side load: two folds, and between them two shapes to one load.
#[test]
fn a_side_load_snaps_a_pushed_robot() {
    let robot = prototype("R3", 1.32, BelowPlate::Plain);
    let command =
        |force: f64| Command::pull(&[-5.0 * MM]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.0, force)));
    let family = Family::load(command(1.0), 0.0, 4.0).unwrap();
    let branch = first(&robot, &family);
    let folds: Vec<_> = kinds(&branch).into_iter().filter(|p| p.kind == PointKind::Fold).collect();
    assert_eq!(folds.len(), 2);
    let [upper, lower] = [folds[0].parameter, folds[1].parameter];
    assert!(upper > lower, "{upper} {lower}");
    // The load raised, then lowered in small steps by the solver alone: it jumps, or finds nothing, at either fold.
    let mut solver = Solver::new(&robot);
    let mut leaves = |from: f64, step: f64| {
        let away = |p: &&PathPoint| (p.parameter - from).abs() < 0.05 && p.inertia == Some(0);
        let mut here = branch.points.iter().find(away).unwrap().equilibrium.clone();
        here = solver.solve_from(&command(from), &here).unwrap();
        let mut tip = solver.tip(&here).centre;
        (1..1000)
            .map(|i| from + f64::from(i) * step)
            .find(|&load| {
                here = solver.solve_from(&command(load), &here).unwrap();
                let next = solver.tip(&here).centre;
                let moved = (next - std::mem::replace(&mut tip, next)).norm();
                here.status() != Status::Converged || moved > 1.0 * MM
            })
            .unwrap()
    };
    let step = 2e-4;
    let (up, down) = (leaves(lower - 0.02, step), leaves(upper + 0.02, -step));
    assert!((upper..upper + step).contains(&up), "{up} {upper}");
    assert!((lower - step..lower).contains(&down), "{down} {lower}");
    // Finer fields move the folds by little.
    let settings = Settings::default().with_resolution(Resolution::SPATIAL.refined(2));
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    let fine = solver.trace(&family, &Tracing::default()).unwrap();
    let finer: Vec<_> = kinds(&fine[0]).into_iter().filter(|p| p.kind == PointKind::Fold).collect();
    for (fold, fine) in folds.iter().zip(&finer) {
        assert!((fold.parameter / fine.parameter - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_pushed_robot_buckles_sideways_where_its_margin_vanishes() {
    let robot = r1();
    let command = |force: f64| {
        Command::pull(&[-10.0 * MM]).with_loads(Loads::tip_force(Vector3::new(0.0, -force, 0.0)))
    };
    let family = Family::load(command(1.0), 0.0, 1.0).unwrap();
    let mut solver = Solver::new(&robot);
    let tracing = Tracing { depth: 1, ..Tracing::default() };
    let branches = solver.trace(&family, &tracing).unwrap();
    let points: Vec<_> = kinds(&branches[0]);
    assert_eq!(points.len(), 1);
    assert_eq!(points[0].kind, PointKind::BranchPoint { multiplicity: 1 });
    // The same load by bisection on the margin of independent solves.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let found = solver.solve(&command(middle)).unwrap();
        let stability = solver.stability(&found).unwrap();
        if stability.margin.abs() > 1e-8 {
            assert_eq!(stability.inertia, usize::from(stability.margin < 0.0));
        }
        if stability.margin > 0.0 { low = middle } else { high = middle }
    }
    assert!((points[0].parameter - low).abs() < 1e-8, "{} {low}", points[0].parameter);
    // Out of the plane both ways, mirror images, stable.
    assert_eq!(branches.len(), 3);
    let mirror = Vector3::new(1.0, 1.0, -1.0);
    assert_eq!(branches[1].points.len(), branches[2].points.len());
    for (a, b) in branches[1].points.iter().zip(&branches[2].points) {
        assert!((a.tip - b.tip.component_mul(&mirror)).norm() < 1e-8 * robot.length());
    }
    assert!(branches[1].points.last().unwrap().tip.z.abs() > 0.05);
    assert!(branches[1].points[1..].iter().all(|p| p.inertia == Some(0)));
}

/// The printed formulation turns back where the paper's solver does not converge any more.
#[test]
fn the_printed_formulation_folds() {
    let robot = prototype("R3", 1.32, BelowPlate::Plain);
    let settings = Settings { formulation: Formulation::Printed, ..Settings::planar() };
    let family = Family::actuator(Command::pull(&[0.0]), 2, Freedom::PushPull, 20.0 * MM).unwrap();
    let tracing = Tracing::default();
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    let branch = solver.trace(&family, &tracing).unwrap().swap_remove(0);
    let fold = branch.points.iter().find(|p| p.kind == PointKind::Fold).unwrap();
    // A solve finds an equilibrium just below it and none just above.
    for (pull, there) in [(fold.parameter - 1e-5, true), (fold.parameter + 1e-5, false)] {
        let before = branch.points.iter().take_while(|p| p.kind != PointKind::Fold).last().unwrap();
        let found = solver.solve_from(&Command::pull(&[pull]), &before.equilibrium);
        assert_eq!(found.unwrap().status().is_equilibrium(), there, "{pull}");
    }
    assert!((fold.parameter / MM - 13.885).abs() < 1e-3);
    assert!(branch.points.iter().all(|p| p.inertia.is_none()));
}

#[test]
fn what_cannot_be_followed_is_said() {
    let robot = r1();
    let held = Command::held(&robot);
    let problem = |family: Result<Family, FamilyProblem>| {
        family.and_then(|f| Solver::new(&robot).trace(&f, &Tracing::default()).map(|_| ())).unwrap_err()
    };
    let push = Freedom::PushPull;
    assert_eq!(
        problem(Family::actuator(held.clone(), 3, push, 1.0)),
        FamilyProblem::Command(held.no_such_tube(3))
    );
    assert_eq!(problem(Family::actuator(held.clone(), 2, push, 0.0)), FamilyProblem::Nothing);
    assert_eq!(problem(Family::actuator(held.clone(), 2, push, f64::NAN)), FamilyProblem::NotFinite);
    assert!(matches!(problem(Family::actuator(held.clone(), 2, push, 1.0)), FamilyProblem::Command(_)));
    assert_eq!(problem(Family::load(held.clone(), 0.0, 1.0)), FamilyProblem::NoLoad);
    let driven = tension(1.0, Loads::none());
    assert_eq!(problem(Family::between(held, driven)), FamilyProblem::Drives { tube: 2 });
    // No equilibrium to begin with.
    let far = Command::pull(&[0.149]).with_loads(Loads::tip_force(Vector3::new(1e6, 0.0, 0.0)));
    let family = Family::actuator(far, 2, push, 0.1).unwrap();
    let branch = first(&robot, &family);
    assert!(matches!(branch.end, End::NoStart(Status::NotConverged(_))) && branch.points.is_empty());
}
