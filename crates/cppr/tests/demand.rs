//! What a command asks of a robot, against closed forms of a clamped rod.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::{Asked, explained, greatest_demand, total_bend};
use cppr::design::{Profile, Robot, TubeDesign};
use cppr::solve::{Actuator, Command, Drive, Quantity, Solver};
use cppr::statics::{DistributedForce, Loads, RotationMeans, Station, Thread, Wrench};
use std::f64::consts::PI;

const LENGTH: f64 = 0.15;

/// Two like tubes; the demand of small loads is the bend that they cause.
fn pair() -> Robot {
    let tube = |direction: f64| {
        let TubeDesign::Stiffness(tube) = stiff_tube(1e-3, [4e-3; 2], 3e-3, direction, 0.0) else {
            unreachable!()
        };
        TubeDesign::Stiffness(cppr::design::StiffnessTube {
            mass_per_length: Profile::constant(0.02),
            ..tube
        })
    };
    robot(LENGTH, vec![tube(0.0), tube(PI)])
}

fn with_loads(loads: Loads) -> Command {
    Command {
        actuators: vec![Actuator { push_pull: Drive::Effort(0.0), ..Actuator::HELD }],
        loads,
        rotation_means: RotationMeans::Base,
    }
}

/// Every load there is, so small that the robot is linear; followers free to slide.
fn small() -> Vec<(Asked, Command)> {
    let wrench = |wrench: Wrench| with_loads(Loads { wrenches: vec![wrench], ..Loads::none() });
    let at = |wrench: Wrench| Wrench { station: Station::Label(0.06), ..wrench };
    let (force, moment) = (Wrench::tip_force(Vector3::y() * 1e-6), Wrench::tip_moment(Vector3::z() * 1e-7));
    let distributed = DistributedForce { force: Vector3::y() * 1e-5, from: 0.03, to: 0.12 };
    let far = Vector3::new(LENGTH, 1e3, 0.0);
    let thread = Thread { tension: 1e-6, pulley: far, radius: 0.0, left: true, point: Vector3::zeros() };
    let driven = |push_pull: Drive, rotation: Drive| Command {
        actuators: vec![Actuator { push_pull, rotation }],
        ..with_loads(Loads::none())
    };
    vec![
        (Asked::TipForce, wrench(force)),
        (Asked::TipMoment, wrench(moment)),
        (Asked::Force(0.06), wrench(at(force))),
        (Asked::Moment(0.06), wrench(at(moment))),
        (
            Asked::Distributed(0.03, 0.12),
            with_loads(Loads { distributed: vec![distributed], ..Loads::none() }),
        ),
        (Asked::Gravity, with_loads(Loads { gravity: Some(Vector3::y() * 1e-4), ..Loads::none() })),
        (Asked::Thread, with_loads(Loads { threads: vec![thread], ..Loads::none() })),
        (Asked::Actuator(Quantity::TENSION.of_tube(2)), driven(Drive::Effort(1e-5), Drive::Motion(0.0))),
        (Asked::Actuator(Quantity::PULL.of_tube(2)), driven(Drive::Motion(1e-9), Drive::Motion(0.0))),
    ]
}

#[test]
fn where_the_robot_is_linear_the_demand_is_the_bend() {
    let robot = pair();
    let mut solver = Solver::new(&robot);
    for (asked, command) in small() {
        let demand = greatest_demand(&robot, &command).unwrap();
        assert_eq!(demand.asked, asked);
        let found = solver.solve(&command).unwrap();
        let bend = total_bend(&found);
        // The weight of the follower acts on its own centroid line: 6 (D/L)² = 2.7e-4 beside gravity's own moment.
        assert!((demand.angle - bend).abs() < 3e-4 * bend, "{asked:?}: {} {bend}", demand.angle);
        assert!(!demand.is_absurd());
    }
    let still = greatest_demand(&robot, &with_loads(Loads::none()));
    assert_eq!(still, None);
}

#[test]
fn turns_and_torques_are_angles() {
    let robot = pair();
    let turned = |rotation: Drive| Command {
        actuators: vec![Actuator { push_pull: Drive::Motion(0.0), rotation }],
        ..with_loads(Loads::none())
    };
    let turn = greatest_demand(&robot, &turned(Drive::Motion(-0.3))).unwrap();
    assert_eq!((turn.asked, turn.angle), (Asked::Actuator(Quantity::ROTATION.of_tube(2)), 0.3));
    let far = greatest_demand(&robot, &turned(Drive::Motion(200.0 * PI))).unwrap();
    assert_eq!(far.to_string(), "The rotation of tube 2 is 36000 deg, 100 turns. Check number and unit");
    let torque = greatest_demand(&robot, &turned(Drive::Effort(-2e-2))).unwrap();
    assert_eq!(torque.asked, Asked::Actuator(Quantity::TORQUE.of_tube(2)));
    assert!((torque.angle - 2e-2 * LENGTH / 6e-3).abs() < 1e-12);
}

/// Numbers near the greatest that there are: no infinity, no NaN.
#[test]
fn squares_that_overflow_do_no_harm() {
    let robot = pair();
    let huge = greatest_demand(&robot, &with_loads(Loads::tip_force(Vector3::y() * 1e300))).unwrap();
    assert!((huge.amount - 1e300).abs() < 1e286);
    assert!(
        huge.is_absurd()
            && huge.to_string().contains("is 1.0e300 N; on this robot about 1.12 N bends by 90°")
    );
}

/// Whatever a mistaken unit has made too large is named, with a number that would do.
#[test]
fn what_is_absurd_is_named() {
    let robot = pair();
    let mut solver = Solver::new(&robot);
    for (command, words) in [
        (
            with_loads(Loads::tip_force(Vector3::y() * 1e9)),
            "The tip force is 1.0e9 N; on this robot about 1.12 N bends by 90°",
        ),
        (
            Command {
                actuators: vec![Actuator { push_pull: Drive::Effort(1e7), ..Actuator::HELD }],
                ..with_loads(Loads::none())
            },
            "The tension of tube 2 is 1.0e7 N; on this robot about 42 N",
        ),
    ] {
        let found = solver.solve(&command).unwrap();
        assert!(!found.status().is_equilibrium());
        let text = explained(&robot, &command, found.status());
        assert!(text.starts_with("not converged") && text.contains(words), "{text}");
    }
}
