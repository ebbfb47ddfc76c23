//! The tip follows the pointer: the actuators change so that the tip comes nearer to a place, from where the robot is.
//!
//! Damped least squares on the exact Jacobian J, inputs in units u of their controls' reach: Δq = Jᵀ (J Jᵀ + λ² 1)⁻¹ e with the
//! way e that is left, cut to a part of the length so that the robot stays on its branch. A step is kept where the tip comes nearer.

use crate::describe::Control;
use cppr::Vector3;
use cppr::solve::{Command, Equilibrium, Freedom, Input, Solver, Status};
use nalgebra::Matrix3;

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
        let mut jacobian = exact.tip_jacobian.rows(0, 3).into_owned();
        for (mut column, unit) in jacobian.column_iter_mut().zip(&reach) {
            column *= *unit;
        }
        let square = &jacobian * jacobian.transpose() + Matrix3::identity() * (DAMPING * length).powi(2);
        let Some(inverse) = square.try_inverse() else { break };
        let change = jacobian.transpose() * (inverse * way * (LONGEST * length / way.norm()).min(1.0));
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
