//! Edges where solves are delicate: at the plate, under a force that hardly moves the follower, and beside loads.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{converged, prototype, three_with_edges};
use cppr::Vector3;
use cppr::design::{BelowPlate, Robot};
use cppr::solve::{Actuator, Command, Drive, Settings, Solver, Status};
use cppr::statics::{Loads, Station, Wrench};

const MM: f64 = 1e-3;

fn prototypes() -> impl Iterator<Item = (&'static str, Robot)> {
    [("R1", 1.27), ("R2", 1.27), ("R3", 1.32), ("R4", 1.06)]
        .into_iter()
        .map(|(name, factor)| (name, prototype(name, factor, BelowPlate::Plain)))
}

fn forces(tensions: &[f64], loads: &Loads) -> Command {
    let pushed = |&force| Actuator { push_pull: Drive::Effort(force), ..Actuator::HELD };
    Command { actuators: tensions.iter().map(pushed).collect(), ..Command::pull(&[]) }
        .with_loads(loads.clone())
}

/// Motion by force is the inverse of force by motion, however little the follower moves; between the tensions at
/// Δa = 0⁺ and 0⁻ it stands.
#[test]
fn the_least_push_beyond_what_the_plate_bears_moves_the_follower() {
    let settings = Settings::default();
    for (name, robot) in prototypes() {
        let _solver = Solver::new(&robot);
        for force in
            [Vector3::new(0.0, 0.2, 0.0), Vector3::new(0.0, -0.2, 0.05), Vector3::new(0.05, 0.0, 0.1)]
        {
            let loads = Loads::tip_force(force);
            let mut held = |motion: f64| {
                let command = Command::pull(&[motion]).with_loads(loads.clone());
                converged(&robot, &command, &settings).actuators()[0].tension
            };
            let motions = [-1e-7, -1e-6, -1e-5, -1e-4, -3e-4, 1e-7, 1e-5].map(|part| part * robot.length());
            let tensions = motions.map(&mut held);
            let [low, high] = [-2e-9, 2e-9].map(|part| held(part * robot.length()));
            assert!(high - low > 1e-4, "{name} {force:?}: the plate bears nothing, {low} {high}");
            for (motion, tension) in motions.into_iter().zip(tensions) {
                let found = converged(&robot, &forces(&[tension], &loads), &settings);
                let error = found.actuators()[0].motion - motion;
                assert!(error.abs() < 1e-9 * robot.length(), "{name} {force:?}: {motion} + {error}");
            }
            for share in [1e-3, 0.5, 0.999] {
                let tension = low + share * (high - low);
                let found = converged(&robot, &forces(&[tension], &loads), &settings);
                assert!(found.actuators()[0].motion.abs() < 1e-12, "{name} {force:?}: {share}");
                assert!((found.actuators()[0].tension - tension).abs() < 1e-12);
            }
        }
    }
}

/// The same for two followers, driven by force both.
#[test]
fn two_followers_leave_the_plate_by_force() {
    let robot = three_with_edges();
    let settings = Settings::default();
    let _solver = Solver::new(&robot);
    let loads = Loads::tip_force(Vector3::new(0.0, 0.3, -0.2));
    for motions in [[-1e-6, -1e-5], [-1e-5, 1e-4], [2e-5, -3e-6], [-2e-4, -1e-6], [-1e-4, -9e-5]] {
        let command = Command::pull(&motions).with_loads(loads.clone());
        let held = converged(&robot, &command, &settings);
        let tensions: Vec<f64> = held.actuators().iter().map(|a| a.tension).collect();
        let found = converged(&robot, &forces(&tensions, &loads), &settings);
        for (actuator, motion) in found.actuators().iter().zip(motions) {
            assert!((actuator.motion - motion).abs() < 1e-9 * robot.length(), "{motions:?}: {actuator:?}");
        }
    }
}

fn at(label: f64, force: [f64; 3]) -> Wrench {
    Wrench { station: Station::Label(label * MM), ..Wrench::tip_force(force.into()) }
}

/// Edges close to loads, on either side and on top of them: cold as warm, and the tension goes on evenly.
#[test]
fn an_edge_passes_loads() {
    let settings = Settings::default();
    for (name, robot) in prototypes() {
        for wrenches in [
            [at(10.0, [0.0, 0.1, 0.0]), at(20.0, [0.0, 0.0, 0.1])],
            [at(10.0, [0.0, -0.3, 0.0]), at(20.0, [0.0, 0.2, 0.1])],
            [at(19.95, [0.0, -0.3, 0.0]), at(20.0, [0.0, 0.2, 0.1])],
        ] {
            let loads = Loads { wrenches: wrenches.to_vec(), ..Loads::none() };
            let mut solver = Solver::new(&robot);
            let mut warm = solver.rest();
            let tensions: Vec<f64> = (0..35)
                .map(|i| {
                    let command =
                        Command::pull(&[-(19.85 + 0.02 * f64::from(i)) * MM]).with_loads(loads.clone());
                    let found = converged(&robot, &command, &settings).actuators()[0].tension;
                    solver.solve_into(&command, &mut warm).unwrap();
                    assert_eq!(warm.status(), Status::Converged);
                    assert!((found - warm.actuators()[0].tension).abs() < 1e-8, "{name} {command:?}");
                    found
                })
                .collect();
            let mean = (tensions[34] - tensions[0]) / 34.0;
            for pair in tensions.windows(2) {
                assert!(((pair[1] - pair[0]) / mean - 1.0).abs() < 0.2, "{name} {pair:?} {mean}");
            }
        }
    }
}

/// Two edges and loads in any order.
#[test]
fn edges_pass_each_other_and_loads() {
    let robot = three_with_edges();
    let _settings = Settings::default();
    let wrenches = vec![at(1.0, [0.0, -0.3, 0.0]), at(1.5, [0.0, 0.2, 0.1])];
    let loads = Loads { wrenches, ..Loads::none() };
    let mut solver = Solver::new(&robot);
    for i in 0..12 {
        for j in 0..12 {
            let motions = [i, j].map(|k| -(0.8 + 0.07 * f64::from(k)) * MM);
            let found = solver.solve(&Command::pull(&motions).with_loads(loads.clone()));
            assert_eq!(found.unwrap().status(), Status::Converged, "{motions:?}");
        }
    }
}

/// Commands whose equilibrium in one go is unstable: in steps the robot comes to a stable one, and so does a solve.
#[test]
fn a_cold_solve_prefers_the_stable_equilibrium_on_the_way_from_rest() {
    let robot = three_with_edges();
    let settings = Settings::default();
    let _solver = Solver::new(&robot);
    for (pulls, turns, force) in [
        ([0.64, -0.83], [1.56, -1.22], [-0.275, -0.404, 0.311]),
        ([0.94, -0.70], [1.06, -1.47], [0.259, -0.084, 0.452]),
        ([0.45, -0.92], [2.39, -1.37], [-0.469, -0.089, -0.450]),
        ([-0.53, 0.45], [2.27, -1.06], [0.280, 0.161, 0.099]),
        ([-0.65, 0.87], [0.98, -1.69], [-0.395, -0.124, 0.079]),
    ] {
        let mut command =
            Command::pull(&pulls.map(|pull| pull * MM)).with_loads(Loads::tip_force(force.into()));
        for (actuator, turn) in command.actuators.iter_mut().zip(turns) {
            actuator.rotation = Drive::Motion(turn);
        }
        converged(&robot, &command, &settings);
    }
}

/// U − T Δa is 0 at rest: where the robot carries nothing else, a follower that is pulled by T > 0 stands at Δa > 0 in every
/// equilibrium that goes before rest. A warm solve from a pushed pose must not take its edge, pressed against the plate, for one.
#[test]
fn no_tension_leaves_a_follower_pushed_or_at_the_plate() {
    let settings = Settings::default();
    let mut found_some = 0;
    for name in ["R1", "R2", "R3", "R4"] {
        let robot = prototype(name, 1.25, BelowPlate::Plain);
        let mut solver = Solver::new(&robot);
        for push in [-0.1, -1.0, -5.0, -20.0] {
            let pushed = converged(&robot, &Command::pull(&[push * MM]), &settings);
            let mut least = 0.0;
            for tension in [1.0, 10.0, 1e3, 1e6, 1e9] {
                let mut command = Command::held(&robot);
                command.actuators[0].push_pull = Drive::Effort(tension);
                let warm = solver.solve_from(&command, &pushed).unwrap();
                if warm.status().is_equilibrium() {
                    found_some += 1;
                    let motion = warm.actuators()[0].motion;
                    assert!(
                        motion > least && warm.elastic_energy() < tension * motion,
                        "{name} {push} {tension}: {motion}"
                    );
                    least = motion;
                } else {
                    assert!(tension > 1e3, "{name} {push} {tension}");
                }
            }
        }
    }
    assert!(found_some >= 4 * 4 * 3);
}
