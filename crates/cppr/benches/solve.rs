//! Times of one solve on one core: `cargo bench -p cppr --bench solve`.
//!
//! Warm starts at a neighbour 0.02 mm away, as a controller would; cold starts at rest. Robots are uniform (R1) or
//! tapered (R3); "jacobian" adds tip Jacobian and compliance.
#![allow(clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{prototype, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::sensitivity;
use cppr::design::{BelowPlate, Robot};
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Equilibrium, Settings, Workspace, solve, solve_from};
use cppr::statics::Loads;
use divan::{Bencher, black_box};
use std::f64::consts::TAU;

/// Modes of the paper in space: 3 + 3 + 3 + 2.
const PAPER: Resolution = Resolution { twist: 3, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 6 };

fn main() {
    divan::main();
}

fn two_tubes() -> Robot {
    prototype("R1", 1.27, BelowPlate::Continued)
}

fn three_tubes() -> Robot {
    let tubes = [(1.12e-3, 1.96e-4, 1.78e-4), (0.983e-3, 1.81e-4, 1.78e-4), (0.764e-3, 1.83e-4, 1.89e-4)];
    let tubes = tubes
        .iter()
        .enumerate()
        .map(|(k, &(offset, y, z))| stiff_tube(offset, [y, z], 2.8e-4, TAU / 3.0 * k as f64, 0.0))
        .collect();
    robot(0.03, tubes)
}

fn loaded(motions: &[f64]) -> Command {
    Command::pull(motions).with_loads(Loads::tip_force(Vector3::new(0.0, 0.05, 0.05)))
}

fn cold(bencher: Bencher, robot: &Robot, command: &Command, settings: &Settings) {
    let mut workspace = Workspace::new();
    bencher.bench_local(|| {
        solve(robot, &mut workspace, black_box(command), settings).unwrap().actuators[0].tension
    });
}

fn warm(bencher: Bencher, robot: &Robot, commands: [&Command; 2], settings: &Settings, jacobian: bool) {
    let mut workspace = Workspace::new();
    let start: Equilibrium = solve(robot, &mut workspace, commands[0], settings).unwrap();
    bencher.bench_local(|| {
        let found = solve_from(robot, &mut workspace, black_box(commands[1]), settings, &start).unwrap();
        if jacobian {
            black_box(sensitivity(robot, &mut workspace, &found));
        }
        found.actuators[0].tension
    });
}

#[divan::bench]
fn planar_two_tubes_cold(bencher: Bencher) {
    cold(bencher, &two_tubes(), &Command::pull(&[5e-3]), &Settings::planar());
}

#[divan::bench]
fn planar_two_tubes_warm(bencher: Bencher) {
    warm(
        bencher,
        &two_tubes(),
        [&Command::pull(&[5e-3]), &Command::pull(&[5.02e-3])],
        &Settings::planar(),
        false,
    );
}

#[divan::bench]
fn planar_tapered_pushed_warm(bencher: Bencher) {
    let robot = prototype("R3", 1.26, BelowPlate::Plain);
    warm(
        bencher,
        &robot,
        [&Command::pull(&[-5e-3]), &Command::pull(&[-5.02e-3])],
        &Settings::planar(),
        false,
    );
}

#[divan::bench]
fn space_two_tubes_cold(bencher: Bencher) {
    cold(bencher, &two_tubes(), &loaded(&[5e-3]), &Settings::default().with_resolution(PAPER));
}

#[divan::bench]
fn space_two_tubes_warm_with_jacobian(bencher: Bencher) {
    let settings = Settings::default().with_resolution(PAPER);
    warm(bencher, &two_tubes(), [&loaded(&[5e-3]), &loaded(&[5.02e-3])], &settings, true);
}

#[divan::bench]
fn space_two_tubes_default_resolution_cold(bencher: Bencher) {
    cold(bencher, &two_tubes(), &loaded(&[5e-3]), &Settings::default());
}

#[divan::bench]
fn three_tubes_warm(bencher: Bencher) {
    let settings = Settings::default().with_resolution(PAPER);
    let commands = [&Command::pull(&[5e-4, -3e-4]), &Command::pull(&[5.02e-4, -3e-4])];
    warm(bencher, &three_tubes(), commands, &settings, false);
}

#[divan::bench]
fn three_tubes_cold(bencher: Bencher) {
    cold(
        bencher,
        &three_tubes(),
        &Command::pull(&[5e-4, -3e-4]),
        &Settings::default().with_resolution(PAPER),
    );
}
