//! From a command to the equilibrium, or to the reason why there is none.

pub mod command;
pub(crate) mod newton;
pub(crate) mod path;

pub use command::{Actuator, Command, CommandProblem, Drive, Formulation, Settings};
pub use newton::Workspace;
pub use path::{solve, solve_from, solve_into};

use crate::design::Robot;
use crate::kinematics::layout::Layout;
use newton::{Point, System};
use std::fmt;
use std::sync::Arc;

/// What came out of a solve. Look at it before using anything else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// An equilibrium, and a minimum of the energy under the prescribed motions.
    Converged,
    /// An equilibrium that the robot leaves at the slightest disturbance.
    Unstable,
    /// No equilibrium was found; the state is the last iterate and means nothing.
    NotConverged(Reason),
}

/// Why no equilibrium was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// Load stepping from rest came to an end before the whole command: a fold, a collapse or a command beyond
    /// the robot's reach.
    PathEnds {
        /// Greatest fraction of the command at which an equilibrium was found.
        fraction: f64,
    },
    /// Newton's method did not settle on one set of edges between notched and plain parts.
    Edges,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged, stable"),
            Self::Unstable => write!(f, "converged, unstable: the robot would snap to another shape"),
            Self::NotConverged(Reason::PathEnds { fraction }) => write!(
                f,
                "not converged: applied step by step, equilibria end at {:.1} % of the command. The robot folds, \
                 collapses or cannot reach beyond; ask for less",
                100.0 * fraction
            ),
            Self::NotConverged(Reason::Edges) => {
                write!(f, "not converged: no consistent entry of the uncut part below the plate was found")
            }
        }
    }
}

impl Status {
    /// True where there is an equilibrium, stable or not.
    #[must_use]
    pub fn is_equilibrium(self) -> bool {
        !matches!(self, Self::NotConverged(_))
    }
}

/// What one solve cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Newton steps taken.
    pub iterations: usize,
    /// Residual and tangent evaluations.
    pub evaluations: usize,
    /// Load steps after the first attempt failed; 0 where it did not.
    pub load_steps: usize,
}

/// Where the actuator of one follower stands, and what it exerts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActuatorState {
    /// Δa_k (m), pull positive.
    pub motion: f64,
    /// Ω_k (rad) right-handed about +X, or −Δθ_k(0) where the command says so.
    pub rotation: f64,
    /// T_k (N), pull positive.
    pub tension: f64,
    /// Υ_k (N m), conjugate to the rotation.
    pub torque: f64,
}

/// The state of a robot under a command.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Look here first.
    pub status: Status,
    /// Cost of the solve.
    pub statistics: Statistics,
    /// Elastic energy U of all tubes (J).
    pub elastic_energy: f64,
    /// One per follower, tube 2 first.
    pub actuators: Vec<ActuatorState>,
    /// The command it answers.
    pub command: Command,
    /// How it was solved.
    pub settings: Settings,
    /// Largest scaled residual.
    pub residual: f64,
    pub(crate) layout: Arc<Layout>,
    pub(crate) point: Point,
    /// The drives it was solved with: those of the command, save for a follower that stands at the plate.
    pub(crate) drives: Vec<Actuator>,
}

impl Equilibrium {
    /// The robot at rest, as a start for [`solve_from`].
    #[must_use]
    pub fn rest(robot: &Robot, settings: &Settings) -> Self {
        Self::at_rest(robot, &mut Workspace::new(), settings)
    }

    /// The same, with a layout that the workspace may know already.
    pub(crate) fn at_rest(robot: &Robot, workspace: &mut Workspace, settings: &Settings) -> Self {
        let cuts = std::iter::empty();
        let layout = workspace.layouts.get(robot.tube_count(), robot.length(), settings.resolution, cuts);
        let followers = robot.follower_count();
        Self {
            status: Status::Converged,
            statistics: Statistics::default(),
            elastic_energy: 0.0,
            actuators: vec![ActuatorState::default(); followers],
            command: Command::held(robot),
            settings: *settings,
            residual: 0.0,
            point: Point::rest(&layout),
            layout,
            drives: vec![Actuator::HELD; followers],
        }
    }

    pub(crate) fn system<'a>(&'a self, robot: &'a Robot) -> System<'a> {
        System {
            robot,
            layout: &self.layout,
            loads: &self.command.loads,
            knob: self.command.knob,
            actuators: &self.drives,
            formulation: self.settings.formulation,
        }
    }

    /// Takes efforts, energy and residual over from the workspace that evaluated its point.
    pub(crate) fn read(&mut self, workspace: &Workspace) {
        let efforts = &self.point.efforts;
        for (f, state) in self.actuators.iter_mut().enumerate() {
            let [motion, rotation] = workspace.assembly.knobs[f];
            *state =
                ActuatorState { motion, rotation, tension: efforts.tension[f], torque: efforts.torque[f] };
        }
        self.elastic_energy = workspace.assembly.elastic;
        self.residual = workspace.residual.iter().fold(0.0, |m, r| r.abs().max(m));
    }

    /// Brings the workspace to this equilibrium, poses included.
    pub(crate) fn refresh(&self, robot: &Robot, workspace: &mut Workspace) {
        let system = self.system(robot);
        // A point that was evaluated once can be evaluated again.
        let _ = workspace.evaluate(&system, &self.point);
        workspace.poses.evaluate(robot, &self.layout, &workspace.state);
    }

    /// The equilibrium moved by `factor` times a scaled step of its unknowns: coordinates, efforts and edges.
    /// Actuator states follow; status and statistics stay.
    pub(crate) fn moved(&self, robot: &Robot, step: &[f64], factor: f64) -> Self {
        let system = self.system(robot);
        let point = newton::advanced(&system, &self.point, step, factor);
        let mut moved = Self { point, ..self.clone() };
        for (f, actuator) in moved.actuators.iter_mut().enumerate() {
            actuator.tension = moved.point.efforts.tension[f];
            actuator.torque = moved.point.efforts.torque[f];
        }
        moved
    }
}
