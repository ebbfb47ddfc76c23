//! A solver and equilibria of other robots, settings that make no sense, designs with several problems.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{prototype, stiff_tube};
use cppr::analysis::continuation::{Family, FamilyProblem, Tracing};
use cppr::analysis::{NoDerivatives, Perturbed};
use cppr::design::{BelowPlate, DesignProblem, Robot, RobotDesign};
use cppr::kinematics::Resolution;
use cppr::many::Batch;
use cppr::solve::{Command, CommandProblem, Freedom, Settings, SettingsProblem, Solver};
use std::error::Error;
use std::f64::consts::PI;

fn one() -> Robot {
    prototype("R1", 1.27, BelowPlate::Plain)
}

fn three() -> Robot {
    let tubes = (0..3).map(|k| stiff_tube(1e-3, [2e-3, 1e-3], 1e-3, 2.0 * PI / 3.0 * f64::from(k), 0.0));
    common::robot(0.1, tubes.collect())
}

/// Whichever solver is asked, an equilibrium answers for its own robot.
#[test]
fn an_equilibrium_answers_for_its_own_robot() {
    let (first, second) = (one(), three());
    let mut own = Solver::new(&first);
    let eq = own.solve(&Command::pull(&[5e-3])).unwrap();
    let mut other = Solver::with_settings(&second, Settings::default()).unwrap();
    let busy = other.solve(&Command::pull(&[1e-3, -5e-4])).unwrap();
    let tip = own.tip(&eq).centre;
    assert!((other.tip(&eq).centre - tip).norm() < 1e-12 && (eq.tip().centre - tip).norm() < 1e-12);
    assert!((tip - busy.tip().centre).norm() > 0.01);
    let [a, b] = [&mut own, &mut other].map(|solver| solver.stability(&eq).unwrap().margin);
    assert!((a - b).abs() < 1e-12 && a < 0.999);
    let [a, b] = [&mut own, &mut other].map(|solver| solver.sensitivity(&eq).unwrap().tip_jacobian);
    assert!((&a - &b).norm() < 1e-9 * a.norm());
    assert_eq!(other.shape(&eq, 5).sections.len(), 5);
    assert!((other.shape(&eq, 5).sections[4].centre - tip).norm() < 1e-12);
    // What was solved last is still what it was.
    assert!((other.tip(&busy).centre - busy.tip().centre).norm() < 1e-12);
}

/// Coordinates count strain from rest: with held motors and without load they vanish, which is an equilibrium of every robot as it
/// stands, and where solves begin.
#[test]
fn rest_is_an_equilibrium() {
    for seed in 0..30 {
        let robot = Robot::from_design(common::cases::random_case(seed).0).unwrap();
        let (held, mut solver) = (Command::held(&robot), Solver::new(&robot));
        let rest = solver.rest();
        let forces = solver.generalised_forces(&held, rest.coordinates()).unwrap().forces;
        let stiffness = robot.fields_at(0, 0.5 * robot.length()).bending_z;
        assert!(forces.iter().all(|force| force.abs() < 1e-12 * stiffness), "{seed}: {forces:?}");
        let solved = solver.solve(&held).unwrap();
        assert!(solved.status().is_equilibrium() && solved.statistics().iterations == 0, "{seed}");
        assert_eq!(solved.coordinates(), rest.coordinates());
        assert!((solved.tip().centre - rest.tip().centre).norm() < 1e-15);
    }
}

#[test]
fn a_start_of_another_kind_is_refused_and_one_of_a_similar_robot_helps() {
    let (first, second) = (one(), three());
    let eq = Solver::new(&first).solve(&Command::pull(&[5e-3])).unwrap();
    let mut solver = Solver::new(&second);
    let command = Command::pull(&[1e-3, -5e-4]);
    let problem = CommandProblem::OtherStart { given: 2, tubes: 3 };
    assert_eq!(solver.solve_from(&command, &eq).unwrap_err(), problem);
    let mut start = eq.clone();
    assert_eq!(solver.solve_into(&command, &mut start).unwrap_err(), problem);
    assert_eq!(start.coordinates(), eq.coordinates());
    let (mut tips, mut starts) = (Vec::new(), vec![eq.clone(); 4]);
    Batch::new(solver.clone()).solve(&vec![command; 4], &mut starts, &mut tips);
    assert!(tips.into_iter().all(|tip| tip.unwrap_err() == problem));
    // A path begins at an equilibrium of the solver's own.
    let family = Family::actuator(Command::held(&second), 2, Freedom::PushPull, 1e-3).unwrap();
    let problem = solver.trace_from(&family, &Tracing::default(), &eq).unwrap_err();
    assert_eq!(problem, FamilyProblem::OtherStart);

    let stiffer = prototype("R1", 1.25, BelowPlate::Plain);
    let mut solver = Solver::new(&stiffer);
    let near = solver.solve_from(&Command::pull(&[5e-3]), &eq).unwrap();
    assert_eq!(near.robot().design(), stiffer.design());
    let cold = solver.solve(&Command::pull(&[5e-3])).unwrap();
    assert!((near.tip().centre - cold.tip().centre).norm() < 1e-10);
    assert!((near.tip().centre - eq.tip().centre).norm() > 1e-4);
}

#[test]
fn parameters_of_another_robot_are_refused() {
    let mut solver = Solver::new(&one());
    let eq = solver.solve(&Command::pull(&[5e-3])).unwrap();
    let foreign = Perturbed::new(1e-3, |_| Some(three())).unwrap();
    let read = |_: &mut Solver, eq: &cppr::solve::Equilibrium| vec![eq.elastic_energy()];
    assert_eq!(solver.parameter_sensitivity(&eq, &foreign, read), Err(NoDerivatives::Perturbed));
}

#[test]
fn settings_are_checked_when_they_are_taken() {
    let robot = three();
    let normal = Settings::default();
    let fine = Resolution { nodes: 100_000, ..Resolution::SPATIAL };
    let none = Resolution { bending_z: 0, ..Resolution::SPATIAL };
    let mut solver = Solver::new(&robot);
    for (settings, words) in [
        (Settings { smallest_step: 0.0, ..normal }, "the smallest load step is 0"),
        (Settings { smallest_step: -1.0, ..normal }, "the smallest load step is -1"),
        (Settings { smallest_step: f64::NAN, ..normal }, "the smallest load step is NaN"),
        (Settings { smallest_step: 2.0, ..normal }, "the smallest load step is 2"),
        (Settings { tolerance: f64::NAN, ..normal }, "the tolerance is NaN"),
        (Settings { tolerance: 0.0, ..normal }, "the tolerance is 0"),
        (Settings { tolerance: f64::INFINITY, ..normal }, "the tolerance is inf"),
        (Settings { tolerance: 0.5, ..normal }, "the tolerance is 0.5"),
        (Settings { iterations: 0, ..normal }, "allow at least one"),
        (normal.with_resolution(fine), "100000"),
        (normal.with_resolution(none), "at least one mode"),
        (normal.with_stretch(), "axial stiffness"),
    ] {
        let built = Solver::with_settings(&robot, settings).unwrap_err().to_string();
        assert!(built.contains(words), "{built}");
        assert_eq!(solver.set_settings(settings).unwrap_err().to_string(), built);
        assert_eq!(*solver.settings(), normal, "a refused change leaves the old settings");
    }
    let mut solver = Solver::with_settings(&one(), normal.with_stretch()).unwrap();
    assert_eq!(solver.set_robot(&robot).unwrap_err(), SettingsProblem::NoAxialStiffness);
    assert_eq!(solver.robot().design(), one().design());
    solver.set_settings(normal).unwrap();
    solver.set_robot(&robot).unwrap();
    assert!(solver.solve(&Command::pull(&[1e-3, 0.0])).unwrap().status().is_equilibrium());
}

/// `?` takes the problems of a design, and all of them are inside.
#[test]
fn the_problems_of_a_design_are_one_error() {
    fn build(design: RobotDesign) -> Result<Robot, Box<dyn Error>> {
        Ok(Robot::from_design(design)?)
    }
    let tubes = vec![
        stiff_tube(-1e-3, [2e-3, 1e-3], 1e-3, 0.0, 0.0),
        stiff_tube(1e-3, [2e-3, 1e-3], 1e-3, PI, 0.0),
        stiff_tube(1e-3, [2e-3, f64::NAN], 1e-3, 1.0, 0.0),
    ];
    let design = RobotDesign { name: "wrong".into(), length: 0.1, tubes };
    let problems = Robot::from_design(design.clone()).unwrap_err();
    let tube = |problem: &DesignProblem| match problem {
        DesignProblem::Field { tube, .. } => *tube,
        other => panic!("{other}"),
    };
    assert_eq!(problems.0.iter().map(tube).collect::<Vec<_>>(), [1, 3]);
    let text = build(design).unwrap_err().to_string();
    assert!(text.contains("tube 1") && text.contains("tube 3") && text.contains("; "), "{text}");
}
