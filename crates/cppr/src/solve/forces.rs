//! The equations themselves, for solvers of one's own.

use super::command::{Command, Drive};
use super::solver::Solver;
use super::system::{Buffers, Point};
use crate::kinematics::layout::Cut;
use crate::real::Each;
use crate::statics::assembly::Setting;

/// The conditions of equilibrium at given coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedForces {
    /// Slopes of the Lagrangian by the coordinates: elastic, load and actuation forces in balance where they vanish. J per unit
    /// of the coordinate.
    pub forces: Vec<f64>,
    /// Per follower Δa_k (m) and Ω_k (rad).
    pub motions: Vec<[f64; 2]>,
}

impl Solver {
    /// What the solver brings to zero, for solvers of one's own: generalised forces of the consistent formulation at the given
    /// coordinates (for each field its Legendre modes over the robot; 1/m for curvatures), under the efforts of a command;
    /// motions that it prescribes count as efforts of zero. No coordinates stand for the robot at rest.
    ///
    /// `None` where the coordinates are not as many as the resolution has, or describe no bundle.
    #[must_use]
    pub fn generalised_forces(
        &mut self,
        command: &Command,
        coordinates: &[f64],
    ) -> Option<GeneralisedForces> {
        self.check(command).ok()?;
        let Self { robot, settings, buffers, .. } = self;
        let cuts = command.loads.cuts().map(Cut::fixed);
        let layout = buffers.layouts.get(robot.tube_count(), robot.length(), settings.resolution, cuts);
        let mut point = Point::rest(&layout);
        if !coordinates.is_empty() {
            if coordinates.len() != layout.unknowns() {
                return None;
            }
            point.coordinates.copy_from_slice(coordinates);
        }
        for (f, actuator) in command.actuators.iter().enumerate().take(robot.follower_count()) {
            let effort = |drive: Drive| if drive.is_motion() { 0.0 } else { drive.value() };
            point.efforts.tension[f] = effort(actuator.push_pull);
            point.efforts.torque[f] = effort(actuator.rotation);
        }
        let setting = Setting {
            robot,
            layout: &layout,
            loads: Each::same(&command.loads),
            rotation_means: command.rotation_means,
        };
        buffers.begin();
        let Buffers { state, poses, assembly, .. } = buffers;
        if state.evaluate(robot, &layout, &point.coordinates) != 0 {
            return None;
        }
        if !command.loads.is_empty() {
            poses.evaluate(robot, &layout, state);
        }
        assembly.residual(&setting, &point.coordinates, state, poses, &point.efforts);
        Some(GeneralisedForces { forces: assembly.gradient.clone(), motions: assembly.motions.clone() })
    }
}
