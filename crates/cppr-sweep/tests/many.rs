//! Many poses into memory: on other threads, with wrong commands among them, broken off.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::many::Start;
use cppr::solve::{Actuator, Command, Drive, Settings, Solver, Status};
use cppr_sweep::{Memory, Poses, solve_many};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

const COUNT: usize = 1500;

fn robot() -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/r1.toml");
    let text = std::fs::read_to_string(path).unwrap();
    Robot::from_design(cppr_io::robot_file::parse(&text).unwrap().design).unwrap()
}

/// Pulled and pushed, by force where a pose is a multiple of 5; impossible where one of 97.
fn put(pose: usize, command: &mut Command) {
    let t = pose as f64 / COUNT as f64;
    let pull = if pose % 97 == 0 { f64::INFINITY } else { 8e-3 * t - 4e-3 };
    let push_pull = if pose % 5 == 0 { Drive::Effort(1e3 * pull) } else { Drive::Motion(pull) };
    command.actuators[0] = Actuator { push_pull, rotation: Drive::Motion(t) };
}

#[test]
fn poses_are_what_they_are_alone_on_any_number_of_threads() {
    let robot = robot();
    let base = Command::held(&robot);
    let settings = Settings::default().with_resolution(Resolution::PAPER);
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    let memory = Memory::new();
    for start in [Start::Rest, Start::Neighbour] {
        let own = solver.clone();
        let poses = Poses { solver: &own, base: &base, start };
        let on = |threads| {
            let mut tips = vec![None; COUNT];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let flow = pool.install(|| {
                solve_many(&poses, &memory, &mut tips, put, |_, tip, solved| {
                    *tip = Some(solved.map(|s| (s.equilibrium.status(), s.tip.centre)));
                    ControlFlow::<()>::Continue(())
                })
            });
            assert!(flow.is_continue());
            tips
        };
        let one = on(1);
        assert!(one == on(2) && one == on(3), "{start:?}");
        // So few that they stay on this thread, with buffers that know other poses.
        let mut few = vec![Vector3::zeros(); 16];
        let flow = solve_many(
            &poses,
            &memory,
            &mut few,
            |pose, command| put(pose + 1, command),
            |_, tip, s| {
                *tip = s.unwrap().tip.centre;
                ControlFlow::<()>::Continue(())
            },
        );
        assert!(flow.is_continue());
        for (pose, tip) in few.into_iter().enumerate() {
            let (_, wanted) = one[pose + 1].clone().unwrap().unwrap();
            assert!((tip - wanted).norm() < 1e-11, "pose {pose}: {}", tip - wanted);
        }
        for (pose, tip) in one.into_iter().enumerate().filter(|(pose, _)| pose % 3 == 0 || pose % 97 == 0) {
            let mut command = base.clone();
            put(pose, &mut command);
            match (tip.expect("every pose is read"), solver.solve(&command)) {
                (Ok((status, tip)), Ok(alone)) => {
                    assert_eq!(
                        (status, alone.status()),
                        (Status::Converged, Status::Converged),
                        "pose {pose}"
                    );
                    let centre = solver.tip(&alone).centre;
                    assert!((tip - centre).norm() < 1e-11, "pose {pose}: {}", tip - centre);
                }
                (tip, alone) => assert_eq!(tip.unwrap_err(), alone.unwrap_err(), "pose {pose}"),
            }
        }
    }
}

#[test]
fn breaking_stops_all_threads() {
    let robot = robot();
    let (base, solver) = (Command::held(&robot), Solver::new(&robot));
    let poses = Poses { solver: &solver, base: &base, start: Start::Rest };
    let (read, memory) = (AtomicUsize::new(0), Memory::new());
    let mut tips = vec![Vector3::<f64>::zeros(); 1_000_000];
    let flow = solve_many(&poses, &memory, &mut tips, put, |pose, _, _| {
        if read.fetch_add(1, Ordering::Relaxed) < 10 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(pose)
        }
    });
    assert!(flow.is_break() && read.into_inner() < 10_000);
    let none: &mut [Vector3<f64>] = &mut [];
    assert!(solve_many(&poses, &memory, none, put, |_, _, _| ControlFlow::Break(())).is_continue());
}
