//! One model of commands: quantities and their units, numbers of tubes, what is given twice, what is not there.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::stiff_tube;
use cppr::Vector3;
use cppr::design::{Profile, Robot, StiffnessTube, TubeDesign};
use cppr::solve::{
    Actuator, Command, CommandProblem, Draft, Drive, Freedom, Quantity, Settings, Solver, Status,
};
use cppr::statics::{LoadPart, LoadProblem, Loads, Station, Thread, Wrench};
use std::f64::consts::PI;

fn robot(count: u32) -> Robot {
    let tubes = (0..count).map(|k| stiff_tube(1e-3, [2e-3, 1e-3], 1e-3, 2.0 * PI / 3.0 * f64::from(k), 0.0));
    common::robot(0.1, tubes.collect())
}

#[test]
fn quantities_name_each_freedom_once() {
    for quantity in Quantity::ALL {
        assert_eq!(Quantity::of(quantity.freedom, quantity.is_motion), quantity);
        assert_eq!(Quantity::named(quantity.keyword), Some(quantity));
        let input = quantity.of_tube(3);
        assert_eq!(input.quantity(), quantity);
        assert!(input.is_same_freedom(input.conjugate()) && input != input.conjugate());
        assert_eq!(input.conjugate().conjugate(), input);
        assert_eq!(input.prescribed(2.0).is_motion(), quantity.is_motion);
    }
    assert_eq!(Quantity::ALL.map(Quantity::column), ["pull_m", "tension_N", "rotation_rad", "torque_Nm"]);
    assert!((Quantity::ROTATION.shown(PI) - 180.0).abs() < 1e-12);
    assert_eq!(Quantity::named("rotation"), None, "options and keywords are verbs");
}

#[test]
fn a_draft_takes_each_freedom_once_and_knows_the_tubes() {
    let robot = robot(3);
    let mut draft = Draft::new(&robot);
    draft.set(Quantity::PULL.of_tube(2), 1e-3).unwrap();
    draft.set(Quantity::TORQUE.of_tube(2), 2e-3).unwrap();
    draft.set(Quantity::TENSION.of_tube(3), 0.5).unwrap();
    let said = |draft: &mut Draft, quantity: Quantity, tube| {
        let before = draft.command.clone();
        let problem = draft.set(quantity.of_tube(tube), 7.0).unwrap_err();
        assert_eq!(draft.command, before, "what is refused changes nothing");
        problem.to_string()
    };
    let twice = "tube 2 has its motion or force given twice";
    assert_eq!(said(&mut draft, Quantity::PULL, 2), twice);
    assert_eq!(
        said(&mut draft, Quantity::TENSION, 2),
        format!("{twice}, by both pull and tension: give one of them")
    );
    assert!(said(&mut draft, Quantity::ROTATION, 2).contains("both torque and rotate"));
    assert!(
        said(&mut draft, Quantity::PULL, 4).contains("no tube 4; the followers of this robot are 2 to 3")
    );
    assert!(said(&mut draft, Quantity::PULL, 1).contains("tube 1 is no follower"));
    assert!(said(&mut draft, Quantity::PULL, usize::MAX).contains("there is no tube"));
    let expected = vec![
        Actuator { push_pull: Drive::Motion(1e-3), rotation: Drive::Effort(2e-3) },
        Actuator { push_pull: Drive::Effort(0.5), rotation: Drive::Motion(0.0) },
    ];
    assert_eq!(draft.command.actuators, expected);
    assert_eq!(draft.given().len(), 3);
    assert!(said(&mut Draft::new(&self::robot(2)), Quantity::PULL, 3).contains("only follower"));
    assert!(said(&mut Draft::new(&self::robot(1)), Quantity::PULL, 2).contains("only its leader"));
}

/// What the planar resolution does not see is named, by the core alone: the robot, or the part of the loads that leaves the plane.
#[test]
fn what_leaves_the_plane_is_named() {
    let (x, z) = (Vector3::x(), Vector3::z());
    let wrench = Wrench::tip_force(Vector3::y());
    let at = |label| Wrench { station: Station::Label(label), ..Wrench::tip_force(z) };
    let thread = Thread { tension: 1.0, pulley: x + z, radius: 0.0, left: true, point: Vector3::zeros() };
    let none = Loads::none;
    for (loads, part, words) in [
        (Loads::tip_force(z), LoadPart::Force(Station::Tip), "the force on the tip acts"),
        (
            Loads { wrenches: vec![wrench, at(0.03)], ..none() },
            LoadPart::Force(Station::Label(0.03)),
            "at 30.000 mm",
        ),
        (
            Loads { wrenches: vec![Wrench::tip_moment(x)], ..none() },
            LoadPart::Moment(Station::Tip),
            "the moment",
        ),
        (
            Loads { wrenches: vec![Wrench { point: z, ..wrench }], ..none() },
            LoadPart::Point(Station::Tip),
            "the point",
        ),
        (Loads { gravity: Some(z), ..none() }, LoadPart::Gravity, "gravity"),
        (Loads { threads: vec![thread], ..none() }, LoadPart::Thread, "a thread"),
    ] {
        let flat = robot(2).design().clone();
        let tubes = flat.tubes.into_iter().take(1).collect();
        let flat = common::robot(0.1, tubes);
        let command = Command::held(&flat).with_loads(loads);
        let problem = command.check(&flat, &Settings::planar()).unwrap_err();
        assert_eq!(problem, CommandProblem::NotPlanar(Some(part)));
        assert!(problem.to_string().contains(words), "{problem}");
        // In space the same loads are none of its business.
        assert_ne!(command.check(&flat, &Settings::default()).err(), Some(problem));
    }
    let problem = Command::held(&robot(3)).check(&robot(3), &Settings::planar()).unwrap_err();
    assert_eq!(problem, CommandProblem::NotPlanar(None));
}

#[test]
fn tubes_are_numbered_as_in_the_paper() {
    let robot = robot(3);
    assert_eq!(robot.followers().collect::<Vec<_>>(), [2, 3]);
    let command = Command::pull(&[1e-3, -5e-4]);
    let inputs: Vec<_> = command.inputs().collect();
    assert_eq!(inputs.len(), 4);
    assert_eq!(inputs[2], (Quantity::PULL.of_tube(3), -5e-4));
    assert_eq!(command.value(Quantity::TENSION.of_tube(3)), Some(-5e-4), "however it is driven");
    assert!(command.actuator(0).is_none() && command.actuator(1).is_none() && command.actuator(4).is_none());
    let eq = Solver::new(&robot).solve(&command).unwrap();
    assert_eq!(eq.status(), Status::Converged);
    for (tube, state) in eq.followers() {
        assert_eq!(eq.actuator(tube), Some(state));
        let wanted = command.value(Quantity::PULL.of_tube(tube)).unwrap();
        assert!((state.get(Quantity::PULL) - wanted).abs() < 1e-12);
        assert!((state.get(Quantity::TENSION) - state.tension).abs() <= 0.0 && state.tension.abs() > 0.0);
    }
    assert!(eq.actuator(1).is_none() && eq.actuator(4).is_none());
    assert_eq!(
        Command::pull(&[0.0]).clone().set(Quantity::PULL.of_tube(3), 0.0),
        Err(CommandProblem::NoSuchTube { tube: 3, tubes: 2 })
    );
    for (freedom, wanted) in Freedom::BOTH.into_iter().zip([1e-3, 0.0]) {
        assert_eq!(command.actuators[0].drive(freedom), Drive::Motion(wanted));
    }
}

/// Gravity needs mass anywhere: also where it tapers to nothing at the tip.
#[test]
fn gravity_needs_mass_and_be_it_at_the_base_alone() {
    let gravity = Loads { gravity: Some(Vector3::new(0.0, -9.81, 0.0)), ..Loads::none() };
    let weighing = |mass: Profile| {
        let tube = |direction: f64| {
            let uniform = StiffnessTube::uniform(1e-3, direction, [2e-3, 1e-3], 1e-3);
            TubeDesign::Stiffness(StiffnessTube { mass_per_length: mass.clone(), ..uniform })
        };
        let robot = common::robot(0.1, vec![tube(0.0), tube(PI)]);
        Solver::new(&robot).solve(&Command::pull(&[0.0]).with_loads(gravity.clone()))
    };
    let none = weighing(Profile::constant(0.0)).unwrap_err();
    assert_eq!(none, CommandProblem::Load(LoadProblem::NoMass));
    let tapered = weighing(Profile::linear(0.05, 0.0)).unwrap().tip().centre.y;
    let even = weighing(Profile::constant(0.05)).unwrap().tip().centre.y;
    assert!(tapered < -1e-6 && even < tapered, "{tapered} {even}");
}
