//! Many poses of all kinds at once against the same poses one by one, each from rest.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::cases::random_case;
use common::{prototype, seeds};
use cppr::Vector3;
use cppr::design::{BelowPlate, Robot};
use cppr::many::{March, Start};
use cppr::solve::{Actuator, Command, Drive, Solver, Status};
use cppr::statics::{Frame, Loads};
use std::ops::ControlFlow;

/// Pulled and pushed in turn, by motion and by force, with dead and turning loads; some out of reach, some that cannot be asked.
fn commands() -> Vec<Command> {
    (0..90)
        .map(|i| {
            let t = f64::from(i) / 90.0;
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let mut command = Command::pull(&[side * 5e-3 * t]).with_loads(Loads::tip_force(Vector3::new(
                0.0,
                0.05 * t,
                0.02,
            )));
            command.actuators[0].rotation = Drive::Motion(t);
            match i % 15 {
                3 => command.actuators[0].push_pull = Drive::Effort(side * t),
                6 => {
                    command.actuators[0] =
                        Actuator { push_pull: Drive::Effort(t), rotation: Drive::Effort(0.01 * t) }
                }
                9 => command.loads.wrenches[0].frame = Frame::Section,
                11 => command.actuators[0].rotation = Drive::Effort(1e3),
                12 => command.loads.gravity = Some(Vector3::new(0.0, 0.0, -9.81)),
                13 => command.actuators[0].push_pull = Drive::Motion(f64::NAN),
                14 => command.actuators.push(Actuator::HELD),
                _ => {}
            }
            command
        })
        .collect()
}

#[test]
fn every_pose_is_what_it_is_alone() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let (base, commands) = (Command::held(&robot), commands());
    let mut alone = Solver::new(&robot);
    let mut march = March::new(alone.clone());
    for start in [Start::Rest, Start::Neighbour] {
        let mut seen = vec![false; commands.len()];
        let mut counts = [0; 3];
        let flow = march.run(
            &base,
            start,
            commands.len(),
            |pose, command| command.clone_from(&commands[pose]),
            |pose, solved| {
                assert!(!std::mem::replace(&mut seen[pose], true), "pose {pose} comes twice");
                match (alone.solve(&commands[pose]), solved) {
                    (Ok(wanted), Ok(solved)) => {
                        assert_eq!(solved.equilibrium.status(), wanted.status(), "pose {pose}");
                        assert_eq!(solved.equilibrium.command(), &commands[pose]);
                        if wanted.status().is_equilibrium() {
                            counts[0] += 1;
                            let (own, tip) = (alone.tip(&wanted), solved.tip);
                            assert!((tip.centre - own.centre).norm() < 1e-12 * robot.length(), "pose {pose}");
                            assert!((tip.rotation - own.rotation).norm() < 1e-11, "pose {pose}");
                            let efforts = [&solved.equilibrium.actuators()[0], &wanted.actuators()[0]];
                            let [a, b] = efforts.map(|a| a.tension);
                            assert!(
                                (a - b).abs() < 1e-9 * (1.0 + b.abs()),
                                "pose {pose}: {a} instead of {b}"
                            );
                            // What is derived belongs to the same pose.
                            let margin = solved.solver.stability(solved.equilibrium).unwrap().margin;
                            let own = alone.stability(&wanted).unwrap().margin;
                            assert!((margin - own).abs() < 1e-8, "pose {pose}: {margin} instead of {own}");
                        } else {
                            counts[1] += 1;
                        }
                    }
                    (Err(wanted), Err(problem)) => {
                        counts[2] += 1;
                        // NaN differs from itself.
                        assert_eq!(problem.to_string(), wanted.to_string(), "pose {pose}");
                    }
                    (wanted, solved) => panic!("pose {pose}: {solved:?} instead of {wanted:?}"),
                }
                ControlFlow::<()>::Continue(())
            },
        );
        assert!(flow.is_continue() && seen.iter().all(|seen| *seen));
        assert_eq!(counts, [72, 6, 12]);
    }
}

/// Every second lane loses its equilibrium on the way; the others go on.
#[test]
fn a_lost_lane_does_not_touch_its_neighbours() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let base = Command::held(&robot);
    let mut tips = [vec![Vector3::zeros(); 80], vec![Vector3::zeros(); 80]];
    let mut lost = 0;
    for (spoiled, tips) in [false, true].into_iter().zip(&mut tips) {
        let put = |pose: usize, command: &mut Command| {
            let force = if spoiled && pose % 4 == 1 { 1e6 } else { 0.01 * pose as f64 };
            command.actuators[0] = Actuator { push_pull: Drive::Effort(force), ..Actuator::HELD };
        };
        let mut march = March::new(Solver::new(&robot));
        let flow = march.run(&base, Start::Neighbour, 80, put, |pose, solved| {
            let solved = solved.unwrap();
            lost += usize::from(!solved.equilibrium.status().is_equilibrium());
            tips[pose] = solved.tip.centre;
            ControlFlow::<()>::Continue(())
        });
        assert!(flow.is_continue());
    }
    assert_eq!(lost, 20);
    for (pose, (whole, spoiled)) in tips[0].iter().zip(&tips[1]).enumerate().filter(|(pose, _)| pose % 4 != 1)
    {
        assert!((whole - spoiled).norm() < 1e-12, "pose {pose}");
    }
}

#[test]
fn a_march_can_be_broken_off_and_memory_serves_another_robot() {
    let robots: Vec<Robot> =
        [("R1", 1.27), ("R3", 1.26)].map(|(name, factor)| prototype(name, factor, BelowPlate::Plain)).into();
    let mut march = March::new(Solver::new(&robots[1]));
    for robot in [&robots[0], &robots[1], &robots[0]] {
        let base = Command::held(robot);
        march.solver().set_robot(robot).unwrap();
        let put = |pose: usize, command: &mut Command| {
            command.actuators[0] = Actuator::pulled(1e-4 * pose as f64);
        };
        let mut count = 0;
        let flow = march.run(&base, Start::Neighbour, 50, put, |pose, solved| {
            let solved = solved.unwrap();
            let own = Solver::new(robot).solve(solved.equilibrium.command()).unwrap();
            assert_eq!(solved.equilibrium.status(), Status::Converged);
            assert!(
                (solved.equilibrium.actuators()[0].tension - own.actuators()[0].tension).abs() < 1e-9,
                "pose {pose}"
            );
            count += 1;
            if count == 21 { ControlFlow::Break(pose) } else { ControlFlow::Continue(()) }
        });
        assert!(matches!(flow, ControlFlow::Break(_)));
        assert_eq!(count, 21);
    }
}

/// Whole commands of random robots and grids over pull and rotation, whatever else these hold.
fn on_grid(whole: &Command, side: usize, pose: usize) -> Command {
    let mut command = whole.clone();
    let [pull, turn] = [pose / side, pose % side].map(|i| (i as f64 + 1.0) / side as f64);
    for own in &mut command.actuators {
        own.push_pull = own.push_pull.with_value(pull * own.push_pull.value());
        own.rotation = own.rotation.with_value(turn * own.rotation.value());
    }
    command
}

/// A pose begun at a near one is the pose from rest.
#[test]
fn near_poses_of_random_robots_are_what_they_are_from_rest() {
    const SIDE: usize = 7;
    let (mut poses, mut iterations) = (0, [0; 2]);
    for seed in [0, 1, 3, 4, 6, 7, 9, 10, 11, 12, 15, 24, 33, 34, 38] {
        let (design, whole) = random_case(seed);
        let robot = Robot::from_design(design).unwrap();
        let mut march = March::new(Solver::new(&robot));
        let [rest, near] = [Start::Rest, Start::Neighbour].map(|start| {
            let mut found = vec![None; SIDE * SIDE];
            let put = |pose: usize, command: &mut Command| command.clone_from(&on_grid(&whole, SIDE, pose));
            let flow = march.run(&whole, start, SIDE * SIDE, put, |pose, solved| {
                found[pose] = solved.ok().map(|solved| {
                    let steps = solved.equilibrium.statistics().iterations;
                    (solved.equilibrium.status(), solved.tip.centre, steps)
                });
                ControlFlow::<()>::Continue(())
            });
            assert!(flow.is_continue());
            found
        });
        for (pose, pair) in rest.into_iter().zip(near).enumerate() {
            let (Some(a), Some(b)) = pair else {
                assert!(pair.0.is_none() && pair.1.is_none());
                continue;
            };
            if a.0 != Status::Converged {
                continue;
            }
            poses += 1;
            iterations = [iterations[0] + a.2, iterations[1] + b.2];
            let apart = (a.1 - b.1).norm() / robot.length();
            assert!(b.0 == a.0 && apart < 1e-8, "seed {seed}, pose {pose}: {:?}, {apart:e}", b.0);
        }
    }
    assert!(poses > 500, "{poses}");
    assert!(2 * iterations[1] < iterations[0], "{iterations:?}");
}

/// Newton's method from rest led these onto another stable branch than the one that the path of equilibria from rest ends on.
#[test]
fn a_solve_from_rest_stays_on_the_branch_of_rest() {
    for (seed, side, pose) in [(11, 7, 21), (11, 7, 23), (106, 1, 0)] {
        let (design, whole) = random_case(seed);
        let robot = Robot::from_design(design).unwrap();
        let mut solver = Solver::new(&robot);
        let command = on_grid(&whole, side, pose);
        let (found, followed) = (solver.solve(&command).unwrap(), solver.follow(&command).unwrap());
        assert!(found.status() == Status::Converged && followed.folds.is_empty());
        let [own, path] = [&found, &followed.equilibrium].map(|e| solver.tip(e).centre);
        assert!((own - path).norm() < 1e-8 * robot.length(), "seed {seed}, pose {pose}: {own} {path}");
    }
}

/// Robots that are tried; `CPPR_CASES` sets others.
const CASES: u64 = 12;

/// A solve from rest ends on the branch on which the path of equilibria from rest ends.
#[test]
fn solves_from_rest_end_where_the_path_ends() {
    let seeds = seeds(CASES);
    let cases = seeds.end - seeds.start;
    let (mut solved, mut apart) = (0, Vec::new());
    for seed in seeds {
        let (design, whole) = random_case(seed);
        if design.tubes.len() > 3 {
            continue;
        }
        let robot = Robot::from_design(design).unwrap();
        let mut solver = Solver::new(&robot);
        for pose in [0, 3, 8] {
            let command = on_grid(&whole, 3, pose);
            let Ok(found) = solver.solve(&command) else { continue };
            let Some(followed) = solver.follow(&command).filter(|_| found.status() == Status::Converged)
            else {
                continue;
            };
            solved += 1;
            let [own, path] = [&found, &followed.equilibrium].map(|e| solver.tip(e).centre);
            if (own - path).norm() > 1e-6 * robot.length() {
                apart.push((seed, pose));
            }
        }
    }
    println!("{solved} solved, {} on another branch than their path: {apart:?}", apart.len());
    assert!(solved > cases && apart.is_empty(), "{solved}: {apart:?}");
}
