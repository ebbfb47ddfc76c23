//! Commands solved side by side against the same commands one by one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::prototype;
use cppr::Vector3;
use cppr::design::{BelowPlate, Robot};
use cppr::many::Batch;
use cppr::solve::{Actuator, Command, CommandProblem, Drive, Formulation, Settings, Solver};
use cppr::statics::{Frame, Loads, Wrench};

/// The batch may have solved another robot before.
fn agrees(robot: &Robot, commands: &[Command], settings: Settings, batch: &mut Batch) {
    let mut single = Solver::with_settings(robot, settings).unwrap();
    batch.solver().copy_task(&single);
    let mut tips = Vec::new();
    let mut equilibria = vec![single.rest(); commands.len()];
    // From rest, then from where the first turn has led.
    for factor in [1.0, 1.02] {
        let moved: Vec<Command> = commands
            .iter()
            .map(|c| {
                let mut c = c.clone();
                for actuator in &mut c.actuators {
                    actuator.push_pull = actuator.push_pull.with_value(factor * actuator.push_pull.value());
                }
                c
            })
            .collect();
        let starts = equilibria.clone();
        batch.solve(&moved, &mut equilibria, &mut tips);
        assert_eq!(tips.len(), commands.len());
        for (i, (command, start)) in moved.iter().zip(&starts).enumerate() {
            let alone = single.solve_from(command, start).unwrap();
            let together = &equilibria[i];
            assert_eq!(alone.status(), together.status(), "command {i}");
            assert_eq!(together.command(), command);
            if !alone.status().is_equilibrium() {
                continue;
            }
            let (wanted, tip) = (single.tip(&alone), tips[i].as_ref().unwrap());
            let off = tip.centre - wanted.centre;
            assert!(off.norm() < 1e-12 * robot.length(), "command {i}: {off}");
            assert!((tip.rotation - wanted.rotation).norm() < 1e-11);
            for (a, b) in alone.actuators().iter().zip(together.actuators()) {
                assert!((a.tension - b.tension).abs() < 1e-9 * (1.0 + a.tension.abs()));
                assert!((a.motion - b.motion).abs() < 1e-12 && (a.rotation - b.rotation).abs() < 1e-10);
            }
        }
    }
}

fn command(pull: f64, turn: f64, force: [f64; 3]) -> Command {
    let mut command = Command::pull(&[pull]).with_loads(Loads::tip_force(force.into()));
    command.actuators[0].rotation = Drive::Motion(turn);
    command
}

#[test]
fn side_by_side_as_one_by_one() {
    let mut batch = Batch::new(Solver::new(&prototype("R2", 1.26, BelowPlate::Plain)));
    for below in [BelowPlate::Continued, BelowPlate::Plain] {
        for name in ["R1", "R3"] {
            let robot = prototype(name, 1.26, below);
            let mut commands: Vec<Command> = (0..11)
                .map(|i| {
                    let t = f64::from(i) / 11.0;
                    command(6e-3 * t - 3e-3, 1.5 * t, [0.01, 0.06 - 0.1 * t, 0.05 * t])
                })
                .collect();
            // Another kind of load, another kind of drive, a command out of reach.
            commands[5].loads.gravity = Some(Vector3::new(0.0, 0.0, -9.81));
            commands[7].actuators[0] = Actuator { push_pull: Drive::Effort(0.8), ..Actuator::HELD };
            commands.push(Command::pull(&[0.12]));
            agrees(&robot, &commands, Settings::default(), &mut batch);
        }
    }
}

#[test]
fn loads_without_potential_stretch_and_the_printed_formulation() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let mut batch = Batch::new(Solver::new(&robot));
    let commands: Vec<Command> =
        (0..5).map(|i| command(1e-3 * f64::from(i) - 2e-3, 0.2, [0.0, 0.05, 0.02])).collect();
    agrees(&robot, &commands, Settings::default().with_stretch(), &mut batch);
    let mut turning = commands.clone();
    for command in &mut turning {
        let force = command.loads.wrenches[0];
        command.loads.wrenches[0] = Wrench { frame: Frame::Section, ..force };
    }
    agrees(&robot, &turning, Settings::default(), &mut batch);
    let printed = Settings { formulation: Formulation::Printed, ..Settings::default() };
    agrees(&robot, &commands[..2], printed, &mut batch);
}

#[test]
fn an_impossible_command_is_named() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let mut batch = Batch::new(Solver::new(&robot));
    let rest = batch.solver().rest();
    let mut equilibria = vec![rest.clone(); 9];
    let mut commands: Vec<Command> = (1..10).map(|i| Command::pull(&[1e-4 * f64::from(i)])).collect();
    commands[2] = Command::pull(&[f64::NAN]);
    commands[8] = Command::pull(&[1e-3, 1e-3]);
    let mut tips = Vec::new();
    batch.solve(&commands, &mut equilibria, &mut tips);
    for (i, (tip, equilibrium)) in tips.iter().zip(&equilibria).enumerate() {
        match i {
            2 => assert_eq!(tip.as_ref().unwrap_err(), &CommandProblem::NotFinite { tube: 2 }),
            8 => assert_eq!(tip.as_ref().unwrap_err(), &CommandProblem::Actuators { given: 2, followers: 1 }),
            _ => assert!(tip.is_ok() && equilibrium.actuators()[0].motion > 0.0, "command {i}"),
        }
    }
    assert_eq!(equilibria[2].coordinates(), rest.coordinates());
}

/// Tubes driven by force come in and go out of the robot with their uncut part; lanes differ in that.
#[test]
fn edges_under_prescribed_force() {
    let robot = prototype("R3", 1.26, BelowPlate::Plain);
    let commands: Vec<Command> = (0..24)
        .map(|i| {
            let mut command = command(0.0, 0.3, [0.0, 0.02, 0.01 * f64::from(i % 5)]);
            command.actuators[0].push_pull = Drive::Effort(0.2 * f64::from(i) - 1.5);
            command
        })
        .collect();
    agrees(&robot, &commands, Settings::default(), &mut Batch::new(Solver::new(&robot)));
}
