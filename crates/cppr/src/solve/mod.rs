//! From a command to the equilibrium, or to the reason why there is none.

pub mod batch;
pub mod command;
pub(crate) mod edges;
pub mod march;
pub(crate) mod newton;
pub(crate) mod path;
pub(crate) mod system;
#[cfg(test)]
mod work;

pub use batch::{Batch, Tip, solve_batch};
pub use command::{Actuator, Command, CommandProblem, Drive, Formulation, Settings};
pub use march::{March, Poses, Solved, Start, march};
pub use path::{solve, solve_from, solve_into};
pub use system::{GeneralisedForces, Workspace, generalised_forces};

use crate::design::Robot;
use crate::kinematics::layout::Layout;
use crate::real::{Each, Real};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use system::{Point, System};

/// What came out of a solve. Look at it before using anything else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// An equilibrium, and a minimum of the energy under the prescribed motions.
    Converged,
    /// An equilibrium that the robot leaves at the slightest disturbance. From rest, no stable one was found in steps either:
    /// the path loses its stability on the way, or the robot would leave its plane to either side.
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
            Self::NotConverged(Reason::PathEnds { fraction }) if *fraction <= 0.0 => write!(
                f,
                "not converged: applied step by step, not even the first small part of the command has an equilibrium. \
                 The robot folds, collapses or cannot go there; ask for less"
            ),
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
    /// The workspace with this mark has evaluated it last; 0 for none.
    pub(crate) mark: u64,
}

/// Mark of the equilibrium found next.
static NEXT_MARK: AtomicU64 = AtomicU64::new(1);

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
            mark: 0,
        }
    }

    pub(crate) fn system<'a>(&'a self, robot: &'a Robot) -> System<'a> {
        System {
            robot,
            layout: &self.layout,
            loads: Each::same(&self.command.loads),
            knob: self.command.knob,
            actuators: Each::same(&self.drives),
            formulation: self.settings.formulation,
        }
    }

    /// Takes efforts, energy and residual over from the workspace that evaluated its point.
    pub(crate) fn read(&mut self, workspace: &mut Workspace) {
        workspace.mark = NEXT_MARK.fetch_add(1, Ordering::Relaxed);
        self.mark = workspace.mark;
        self.read_actuators(workspace.assembly.knobs.iter().copied());
        self.elastic_energy = workspace.assembly.elastic;
        self.residual = workspace.residual.iter().fold(0.0, |m, r| r.abs().max(m));
    }

    /// Takes coordinates, efforts and energy over from one lane of a workspace and the point it evaluated.
    pub(crate) fn take_lane<S: Real>(
        &mut self,
        workspace: &Workspace<S>,
        point: &Point<S>,
        lane: usize,
        layout: &Arc<Layout>,
    ) {
        let take = |own: &mut Vec<f64>, all: &[S]| {
            own.clear();
            own.extend(all.iter().map(|v| v.lane(lane)));
        };
        take(&mut self.point.coordinates, &point.coordinates);
        take(&mut self.point.efforts.tension, &point.efforts.tension);
        take(&mut self.point.efforts.torque, &point.efforts.torque);
        take(&mut self.point.efforts.edge, &point.efforts.edge);
        self.layout = Arc::clone(layout);
        self.mark = NEXT_MARK.fetch_add(1, Ordering::Relaxed);
        let knobs = workspace.assembly.knobs.iter().map(|knob| knob.map(|k| k.lane(lane)));
        self.read_actuators(knobs);
        self.elastic_energy = workspace.assembly.elastic.lane(lane);
        self.residual = workspace.residual.iter().fold(0.0, |m, r| r.lane(lane).abs().max(m));
    }

    fn read_actuators(&mut self, knobs: impl Iterator<Item = [f64; 2]>) {
        let efforts = self.point.efforts.tension.iter().zip(&self.point.efforts.torque);
        for ((state, [motion, rotation]), (&tension, &torque)) in
            self.actuators.iter_mut().zip(knobs).zip(efforts)
        {
            *state = ActuatorState { motion, rotation, tension, torque };
        }
    }

    /// Brings the workspace to this equilibrium, poses included.
    pub(crate) fn refresh(&self, robot: &Robot, workspace: &mut Workspace) {
        if !workspace.holds(robot, self.mark) {
            // A point that was evaluated once can be evaluated again.
            let _ = workspace.evaluate(&self.system(robot), &self.point);
        }
        workspace.pose(robot, &self.layout);
    }

    /// The Ritz coordinates, as [`generalised_forces`] takes them where no tube brings an uncut part into the robot.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.point.coordinates
    }

    /// Becomes another equilibrium without giving memory back: a start for [`solve_into`].
    pub fn copy(&mut self, other: &Self) {
        self.status = other.status;
        self.statistics = other.statistics;
        self.elastic_energy = other.elastic_energy;
        self.actuators.clone_from(&other.actuators);
        self.command.copy(&other.command);
        self.settings = other.settings;
        self.residual = other.residual;
        self.layout = Arc::clone(&other.layout);
        self.point.copy(&other.point);
        self.drives.clone_from(&other.drives);
        self.mark = other.mark;
    }

    /// The equilibrium moved by `factor` times a scaled step of its unknowns: coordinates, efforts and edges.
    /// Actuator states follow; status and statistics stay.
    pub(crate) fn moved(&self, robot: &Robot, step: &[f64], factor: f64) -> Self {
        let system = self.system(robot);
        let point = system::advanced(&system, &self.point, step, factor);
        let mut moved = Self { point, mark: 0, ..self.clone() };
        for (f, actuator) in moved.actuators.iter_mut().enumerate() {
            actuator.tension = moved.point.efforts.tension[f];
            actuator.torque = moved.point.efforts.torque[f];
        }
        moved
    }
}
