//! The tip follows the pointer: the actuators change so that the tip comes nearer to a place, from where the robot is.
//!
//! Damped least squares on the exact Jacobian J, inputs in units u of their controls' reach: Δq = Jᵀ (J Jᵀ + λ² 1)⁻¹ e with the
//! way e that is left, cut to a part of the length so that the robot stays on its branch. A step is kept where the tip comes nearer.

use crate::describe::Control;
use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::solve::{Command, Equilibrium, Freedom, Input, Solver, Status};
use nalgebra::{DMatrix, DVector};

/// Steps for one place of the pointer.
const STEPS: usize = 6;
/// Longest step, λ, and what is near enough, as parts of the length.
const LONGEST: f64 = 0.05;
const DAMPING: f64 = 0.03;
const NEAR: f64 = 1e-5;

/// The stable equilibrium nearest to `target` (m) that was met.
pub(crate) fn towards(
    solver: &mut Solver,
    start: Equilibrium,
    controls: &[Control],
    target: Vector3<f64>,
) -> Equilibrium {
    let length = solver.robot().length();
    let mut here = start;
    for _ in 0..STEPS {
        let way = target - solver.tip(&here).centre;
        if way.norm() <= NEAR * length {
            break;
        }
        let Ok(exact) = solver.sensitivity(&here) else { break };
        let reach: Vec<f64> = exact.inputs.iter().map(|input| reach(controls, *input)).collect();
        let Some(change) = step(exact.tip_jacobian.rows(0, 3).into_owned(), &reach, way, length) else {
            break;
        };
        let mut command = here.command().clone();
        for ((input, reach), part) in exact.inputs.iter().zip(&reach).zip(change.iter()) {
            advance(&mut command, *input, *reach, *part);
        }
        let Ok(next) = solver.solve_from(&command, &here) else { break };
        if next.status() != Status::Converged || next.statistics().load_steps > 0 {
            break;
        }
        if (target - solver.tip(&next).centre).norm() >= way.norm() {
            break;
        }
        here = next;
    }
    here
}

/// The step Δq towards what is `way` (m) from the tip, by the slopes J of its position.
fn step(mut jacobian: DMatrix<f64>, reach: &[f64], way: Vector3<f64>, length: f64) -> Option<DVector<f64>> {
    for (mut column, unit) in jacobian.column_iter_mut().zip(reach) {
        column *= *unit;
    }
    let square = &jacobian * jacobian.transpose() + DMatrix::identity(3, 3) * (DAMPING * length).powi(2);
    let cut = way * (LONGEST * length / way.norm()).min(1.0);
    Some(jacobian.transpose() * (square.try_inverse()? * DVector::from_column_slice(cut.as_slice())))
}

/// The same for a bundle, with the command under which it then is.
pub(crate) fn bundle_towards(
    solver: &mut BundleSolver,
    start: BundleEquilibrium,
    command: BundleCommand,
    controls: &[Control],
    target: Vector3<f64>,
) -> (BundleEquilibrium, BundleCommand) {
    let length = start.length;
    let (mut here, mut command) = (start, command);
    for _ in 0..STEPS {
        let way = target - here.tip;
        if way.norm() <= NEAR * length {
            break;
        }
        let Some(exact) = solver.tip_jacobian(&here) else { break };
        let inputs: Vec<Input> = command
            .drives
            .iter()
            .enumerate()
            .flat_map(|(i, drive)| {
                [(Freedom::PushPull, drive.translation), (Freedom::Rotation, drive.rotation)]
                    .map(|(freedom, own)| Input { tube: i + 1, freedom, is_motion: own.is_motion() })
            })
            .collect();
        let reach: Vec<f64> = inputs.iter().map(|input| reach(controls, *input)).collect();
        let Some(change) = step(exact.rows(0, 3).into_owned(), &reach, way, length) else { break };
        let mut next = command.clone();
        for ((input, reach), part) in inputs.iter().zip(&reach).zip(change.iter()) {
            let own = &mut next.drives[input.tube - 1];
            let drive =
                if input.freedom == Freedom::PushPull { &mut own.translation } else { &mut own.rotation };
            *drive = drive.with_value(drive.value() + part * reach);
        }
        let found = solver.solve_from(&next, &here);
        if !(found.converged && found.stable) || (target - found.tip).norm() >= way.norm() {
            break;
        }
        (here, command) = (found, next);
    }
    (here, command)
}

/// How far the control of an input reaches (m, rad, N or N m).
fn reach(controls: &[Control], input: Input) -> f64 {
    let control = controls.iter().find(|control| control.tube == input.tube);
    let shown = control.map_or(0.0, |c| match (input.freedom, input.is_motion) {
        (Freedom::PushPull, true) => c.pull_mm,
        (Freedom::PushPull, false) => c.tension,
        (Freedom::Rotation, true) => c.rotate_deg,
        (Freedom::Rotation, false) => c.torque,
    });
    shown * input.quantity().shown_size
}

/// Changes one input by a part of its reach, within which it stays.
fn advance(command: &mut Command, input: Input, reach: f64, part: f64) {
    let Some(actuator) = command.actuator_mut(input.tube) else { return };
    let drive = actuator.drive_mut(input.freedom);
    *drive = drive.with_value((drive.value() + part * reach).clamp(-reach, reach));
}
