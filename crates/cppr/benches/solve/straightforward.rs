//! How one solves for an equilibrium with nothing but the generalised forces: finite differences and a controller loop.

use crate::cases::Case;
use cppr::solve::{Command, Drive, GeneralisedForces, Solver};

/// Relative step of the differences.
const STEP: f64 = 1e-6;

/// Newton's method by differences on the coordinates of a follower pulled by force, and integral control of that force.
pub struct Straightforward<'a> {
    case: &'a Case,
    solver: Solver,
    command: Command,
    pub motion: f64,
}

impl<'a> Straightforward<'a> {
    pub fn new(case: &'a Case) -> Self {
        let mut command = case.commands[0].clone();
        command.actuators[0].rotation = Drive::Effort(0.0);
        Self {
            case,
            solver: Solver::with_settings(&case.robot, case.settings).unwrap(),
            command,
            motion: 0.0,
        }
    }

    fn forces(&mut self, tension: f64, coordinates: &[f64]) -> GeneralisedForces {
        self.command.actuators[0].push_pull = Drive::Effort(tension);
        self.solver.generalised_forces(&self.command, coordinates).unwrap()
    }

    /// Coordinates in equilibrium with a tension; curvatures are brought to the size of angles by the length.
    fn relax(&mut self, tension: f64, coordinates: &mut [f64]) {
        let (n, unit) = (coordinates.len(), 1.0 / self.case.robot.length());
        for _ in 0..50 {
            let here = self.forces(tension, coordinates);
            let size = here.forces.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            self.motion = here.motions[0][0];
            if size < 1e-13 {
                return;
            }
            let mut jacobian = nalgebra::DMatrix::zeros(n, n);
            for j in 0..n {
                let kept = coordinates[j];
                coordinates[j] += STEP * unit;
                let ahead = self.forces(tension, coordinates);
                coordinates[j] = kept;
                for i in 0..n {
                    jacobian[(i, j)] = (ahead.forces[i] - here.forces[i]) / (STEP * unit);
                }
            }
            let step = jacobian.lu().solve(&nalgebra::DVector::from_vec(here.forces)).unwrap();
            for (c, s) in coordinates.iter_mut().zip(&step) {
                *c -= s;
            }
        }
    }

    /// Finds the tension of a prescribed motion (m), from rest.
    pub fn solve(&mut self, wanted: f64) -> f64 {
        let n = self.forces(0.0, &[]).forces.len();
        let (mut tension, mut coordinates) = (0.0, vec![0.0; n]);
        // The gain is the stiffness at rest, measured once.
        self.relax(1e-2, &mut coordinates);
        let at_rest = self.motion;
        coordinates.fill(0.0);
        self.relax(0.0, &mut coordinates);
        let gain = 1e-2 / (at_rest - self.motion);
        for _ in 0..200 {
            let error = wanted - self.motion;
            if error.abs() < 1e-10 {
                break;
            }
            tension += gain * error;
            self.relax(tension, &mut coordinates);
        }
        tension
    }
}
