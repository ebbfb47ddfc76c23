//! In a control loop nothing is allocated.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use allocation_counter::measure;
use common::prototype;
use cppr::Vector3;
use cppr::analysis::Sensitivity;
use cppr::design::BelowPlate;
use cppr::many::Batch;
use cppr::solve::{Command, Settings, Solver, Status};
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
        let mut solver = Solver::with_settings(&robot, settings).unwrap();
        let mut equilibrium = solver.rest();
        let mut turn = || {
            for command in &commands[..2] {
                solver.solve_into(command, &mut equilibrium).unwrap();
                assert_eq!(equilibrium.status(), Status::Converged);
            }
        };
        turn();
        assert_eq!(measure(&mut turn).count_total, 0, "pulled, {settings:?}");
        let mut sensitivity = Sensitivity::default();
        solver.sensitivity_into(&equilibrium, &mut sensitivity).unwrap();
        let mut derive = || solver.sensitivity_into(&equilibrium, &mut sensitivity);
        assert_eq!(measure(|| assert!(derive().is_ok())).count_total, 0, "derivatives, {settings:?}");
        let mut turn = || {
            for command in &commands[2..] {
                solver.solve_into(command, &mut equilibrium).unwrap();
                assert_eq!(equilibrium.status(), Status::Converged);
            }
        };
        turn();
        assert_eq!(measure(&mut turn).count_total, 0, "pushed, {settings:?}");
        let (mut batch, mut tips) =
            (Batch::new(Solver::with_settings(&robot, settings).unwrap()), Vec::new());
        let mut equilibria = vec![solver.rest(); 4];
        let four = [&commands[..2], &commands[..2]].concat();
        let mut turn = |commands: &[Command]| {
            batch.solve(commands, &mut equilibria, &mut tips);
            assert!(equilibria.iter().all(|e| e.status() == Status::Converged));
        };
        turn(&four);
        assert_eq!(measure(|| turn(&four)).count_total, 0, "side by side, {settings:?}");
    }
}
