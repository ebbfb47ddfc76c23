//! In a control loop nothing is allocated.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use allocation_counter::measure;
use common::prototype;
use cppr::Vector3;
use cppr::analysis::{Sensitivity, sensitivity_into};
use cppr::design::BelowPlate;
use cppr::solve::{Batch, Command, Equilibrium, Settings, Status, Workspace, solve_batch, solve_into};
use cppr::statics::{DistributedForce, Loads};

/// Pulled, pushed with the uncut part inside, loaded in every way.
#[test]
fn a_loop_of_solves_allocates_nothing_after_its_first_turn() {
    let robot = prototype("R3", 1.26, BelowPlate::Plain);
    let mut loads = Loads::tip_force(Vector3::new(0.0, 0.05, 0.05));
    loads.distributed.push(DistributedForce { force: Vector3::new(0.0, 0.1, 0.0), from: 0.0, to: 0.15 });
    loads.gravity = Some(Vector3::new(0.0, 0.0, -9.81));
    for (loads, settings) in [(Loads::none(), Settings::planar()), (loads, Settings::default())] {
        let commands: Vec<Command> = [1.0, 1.5, -1.0, -1.5]
            .iter()
            .map(|pull| Command::pull(&[pull * 1e-3]).with_loads(loads.clone()))
            .collect();
        let mut workspace = Workspace::new();
        let mut equilibrium = Equilibrium::rest(&robot, &settings);
        let mut turn = || {
            for command in &commands[..2] {
                solve_into(&robot, &mut workspace, command, &settings, &mut equilibrium).unwrap();
                assert_eq!(equilibrium.status, Status::Converged);
            }
        };
        turn();
        assert_eq!(measure(&mut turn).count_total, 0, "pulled, {settings:?}");
        let mut sensitivity = Sensitivity::default();
        assert!(sensitivity_into(&robot, &mut workspace, &equilibrium, &mut sensitivity));
        let mut derive = || sensitivity_into(&robot, &mut workspace, &equilibrium, &mut sensitivity);
        assert_eq!(measure(|| assert!(derive())).count_total, 0, "derivatives, {settings:?}");
        let mut turn = || {
            for command in &commands[2..] {
                solve_into(&robot, &mut workspace, command, &settings, &mut equilibrium).unwrap();
                assert_eq!(equilibrium.status, Status::Converged);
            }
        };
        turn();
        assert_eq!(measure(&mut turn).count_total, 0, "pushed, {settings:?}");
        let (mut batch, mut tips) = (Batch::new(), Vec::new());
        let mut equilibria = vec![Equilibrium::rest(&robot, &settings); 4];
        let four = [&commands[..2], &commands[..2]].concat();
        let mut turn = |commands: &[Command]| {
            solve_batch(&robot, &mut batch, commands, &settings, &mut equilibria, &mut tips);
            assert!(equilibria.iter().all(|e| e.status == Status::Converged));
        };
        turn(&four);
        assert_eq!(measure(|| turn(&four)).count_total, 0, "side by side, {settings:?}");
    }
}
