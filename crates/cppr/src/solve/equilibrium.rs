//! The state of a robot under a command.

use super::command::{Actuator, Command};
use super::input::{Freedom, Quantity, follower_of, tube_of};
use super::settings::Settings;
use super::system::{self, Buffers, Point, System};
use super::{Statistics, Status};
use crate::design::Robot;
use crate::kinematics::TipPose;
use crate::kinematics::layout::Layout;
use crate::real::{Each, Real};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where the actuator of one follower stands, and what it exerts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

impl ActuatorState {
    /// One of the four numbers (SI).
    #[must_use]
    pub fn get(&self, quantity: Quantity) -> f64 {
        match (quantity.freedom, quantity.is_motion) {
            (Freedom::PushPull, true) => self.motion,
            (Freedom::PushPull, false) => self.tension,
            (Freedom::Rotation, true) => self.rotation,
            (Freedom::Rotation, false) => self.torque,
        }
    }
}

/// The state of a robot under a command. It knows both, so that nothing else is needed to derive more from it: see
/// [`Solver`](super::Solver).
#[derive(Clone, Debug)]
pub struct Equilibrium {
    pub(crate) robot: Robot,
    pub(crate) status: Status,
    /// Cost of the solve.
    pub(crate) statistics: Statistics,
    /// Elastic energy U of all tubes (J).
    pub(crate) elastic_energy: f64,
    /// One per follower, tube 2 first.
    pub(crate) actuators: Vec<ActuatorState>,
    /// The command it answers.
    pub(crate) command: Command,
    /// How it was solved.
    pub(crate) settings: Settings,
    /// Largest scaled residual.
    pub(crate) residual: f64,
    pub(crate) layout: Arc<Layout>,
    pub(crate) point: Point,
    /// The drives it was solved with: those of the command, save for a follower that stands at the plate.
    pub(crate) drives: Vec<Actuator>,
    /// Buffers that bear this mark have evaluated it last; 0 for none.
    pub(crate) mark: u64,
}

/// Mark of the equilibrium found next.
static NEXT_MARK: AtomicU64 = AtomicU64::new(1);

impl Equilibrium {
    /// The robot at rest, with a layout that the buffers may know already.
    pub(crate) fn at_rest(robot: &Robot, buffers: &mut Buffers, settings: &Settings) -> Self {
        let cuts = std::iter::empty();
        let layout = buffers.layouts.get(robot.tube_count(), robot.length(), settings.resolution, cuts);
        let followers = robot.follower_count();
        Self {
            robot: robot.clone(),
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

    /// The drives it was solved with.
    pub(crate) fn drives(&self) -> &[Actuator] {
        &self.drives
    }

    /// The equations that it solves.
    pub(crate) fn system(&self) -> System<'_> {
        self.system_of(&self.robot)
    }

    /// The equations that it solves, on a robot that differs from its own in numbers only.
    pub(crate) fn system_of<'a>(&'a self, robot: &'a Robot) -> System<'a> {
        System {
            robot,
            layout: &self.layout,
            loads: Each::same(&self.command.loads),
            rotation_means: self.command.rotation_means,
            actuators: Each::same(&self.drives),
            formulation: self.settings.formulation,
        }
    }

    /// Takes efforts, energy and residual over from the buffers that evaluated its point.
    pub(crate) fn read(&mut self, buffers: &mut Buffers) {
        buffers.mark = NEXT_MARK.fetch_add(1, Ordering::Relaxed);
        self.mark = buffers.mark;
        self.read_actuators(buffers.assembly.motions.iter().copied());
        self.elastic_energy = buffers.assembly.elastic;
        self.residual = buffers.residual.iter().fold(0.0, |m, r| r.abs().max(m));
    }

    /// Takes coordinates, efforts and energy over from one lane of the buffers and the point that they evaluated.
    pub(crate) fn take_lane<S: Real>(
        &mut self,
        buffers: &Buffers<S>,
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
        self.read_actuators(buffers.assembly.motions.iter().map(|own| own.map(|m| m.lane(lane))));
        self.elastic_energy = buffers.assembly.elastic.lane(lane);
        self.residual = buffers.residual.iter().fold(0.0, |m, r| r.lane(lane).abs().max(m));
    }

    fn read_actuators(&mut self, motions: impl Iterator<Item = [f64; 2]>) {
        let efforts = self.point.efforts.tension.iter().zip(&self.point.efforts.torque);
        for ((state, [motion, rotation]), (&tension, &torque)) in
            self.actuators.iter_mut().zip(motions).zip(efforts)
        {
            *state = ActuatorState { motion, rotation, tension, torque };
        }
    }

    /// Brings the buffers to this equilibrium, poses included.
    pub(crate) fn refresh(&self, buffers: &mut Buffers) {
        if !buffers.holds(self.mark) {
            // A point that was evaluated once can be evaluated again.
            let _ = buffers.evaluate(&self.system(), &self.point);
        }
        buffers.pose(&self.robot, &self.layout);
    }

    /// Becomes another equilibrium without giving memory back: a start for [`Solver::solve_into`](super::Solver::solve_into).
    pub fn copy(&mut self, other: &Self) {
        self.belong_to(&other.robot);
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

    /// Becomes one of another robot. A handle that is there already is kept: threads that count handles wait for each other.
    pub(crate) fn belong_to(&mut self, robot: &Robot) {
        if self.robot.serial() != robot.serial() {
            self.robot = robot.clone();
        }
    }

    /// The equilibrium moved by `factor` times a scaled step of its unknowns (coordinates, efforts and edges), on a robot that
    /// differs from its own in numbers only. Actuator states follow; status and statistics stay.
    pub(crate) fn moved(&self, robot: &Robot, step: &[f64], factor: f64) -> Self {
        let point = system::advanced(&self.system(), &self.point, step, factor);
        let mut moved = Self { robot: robot.clone(), point, mark: 0, ..self.clone() };
        for (f, actuator) in moved.actuators.iter_mut().enumerate() {
            actuator.tension = moved.point.efforts.tension[f];
            actuator.torque = moved.point.efforts.torque[f];
        }
        moved
    }
}

/// What it is.
impl Equilibrium {
    /// Whether this is an equilibrium at all, and a stable one. Look here first.
    #[must_use]
    pub fn status(&self) -> Status {
        self.status
    }

    /// The robot whose state it is.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The command it answers.
    #[must_use]
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// How it was solved.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Cost of the solve.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Where every actuator stands and what it exerts: one per follower, tube 2 first.
    #[must_use]
    pub fn actuators(&self) -> &[ActuatorState] {
        &self.actuators
    }

    /// Tube number and actuator state of every follower.
    pub fn followers(&self) -> impl Iterator<Item = (usize, &ActuatorState)> + '_ {
        self.actuators.iter().enumerate().map(|(follower, state)| (tube_of(follower), state))
    }

    /// The actuator of a tube, by its number; `None` for the leader and for tubes that are not there.
    #[must_use]
    pub fn actuator(&self, tube: usize) -> Option<&ActuatorState> {
        self.actuators.get(follower_of(tube)?)
    }

    /// Elastic energy U of all tubes (J).
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        self.elastic_energy
    }

    /// Largest scaled residual.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// The Ritz coordinates, as [`Solver::generalised_forces`](super::Solver::generalised_forces) takes them where no tube brings
    /// an uncut part into the robot.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.point.coordinates
    }

    /// Pose of the tip, computed anew with every call; in a loop [`Solver::tip`](super::Solver::tip) is faster.
    #[must_use]
    pub fn tip(&self) -> TipPose {
        let mut buffers = Buffers::default();
        self.refresh(&mut buffers);
        buffers.poses.tip()
    }
}
