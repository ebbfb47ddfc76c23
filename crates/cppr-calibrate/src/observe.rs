//! What the model of tubes of one length says to a measurement, and how that changes with the parameters.

use crate::bundle::BundleModel;
use crate::data::{Line, Measurement};
use crate::design::Design;
use crate::fit::FitProblem;
use crate::parameter::{Parameter, apply};
use cppr::Vector3;
use cppr::analysis::{ACCURACY, Perturbed, absurd_demand};
use cppr::bundle::Bundle;
use cppr::bundle::solve::BundleEquilibrium;
use cppr::design::{DesignProblems, Robot};
use cppr::solve::{Actuator, Command, Drive, Equilibrium, Settings, Solver, Status};
use cppr::statics::{Loads, RotationMeans, Wrench};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A step of relative changes of the parameters, over which everything changes smoothly.
pub(crate) const STEP: f64 = 1e-3;

/// An equilibrium, to start the next solve from.
#[derive(Clone)]
pub(crate) enum Found {
    Robot(Box<Equilibrium>),
    Bundle(Box<BundleEquilibrium>),
}

/// What a model says to a measurement.
pub(crate) struct Seen {
    /// Point (m) and direction of the axis.
    pub outputs: [f64; 6],
    /// Their slopes by relative changes of every parameter.
    pub slopes: Vec<[f64; 6]>,
    pub found: Found,
}

/// A robot at some values of the parameters, ready to be asked.
pub(crate) trait Observer {
    /// What it says to a measurement; from an earlier equilibrium of the same measurement, if there is one.
    fn see(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Seen, FitProblem>;
}

/// A robot at some values of the parameters and, for derivatives, near them.
pub(crate) enum Model {
    Robot(Robot, Vec<Perturbed>),
    Bundle(BundleModel),
}

impl Model {
    pub(crate) fn new(
        design: &Design,
        list: &[Parameter],
        values: &[f64],
        derivatives: bool,
    ) -> Result<Self, FitProblem> {
        let unsound = |problems: DesignProblems| FitProblem::Search(problems.to_string());
        let moved = if derivatives { list.len() } else { 0 };
        let changed = |p: usize, by: f64| {
            let mut moved = values.to_vec();
            moved[p] *= 1.0 + by;
            apply(design, list, &moved)
        };
        let why =
            |p: usize| FitProblem::Search(format!("{} cannot be changed at {}", design.name(), list[p]));
        match apply(design, list, values) {
            Design::Robot(own) => {
                let near = |p: usize, by: f64| match changed(p, by) {
                    Design::Robot(own) => Robot::from_design(own).ok(),
                    Design::Bundle(_) => None,
                };
                let one = |p: usize| Perturbed::new(STEP, |by| near(p, by)).ok_or_else(|| why(p));
                let perturbed = (0..moved).map(one).collect::<Result<Vec<_>, _>>()?;
                Ok(Self::Robot(Robot::from_design(own).map_err(unsound)?, perturbed))
            }
            Design::Bundle(own) => {
                let near = |p: usize, by: f64| match changed(p, by) {
                    Design::Bundle(own) => Bundle::new(&own).ok(),
                    Design::Robot(_) => None,
                };
                let one = |p: usize| Some([near(p, STEP)?, near(p, -STEP)?]);
                let moved =
                    (0..moved).map(|p| one(p).ok_or_else(|| why(p))).collect::<Result<Vec<_>, _>>()?;
                let bundle = Bundle::new(&own).map_err(unsound)?;
                Ok(Self::Bundle(BundleModel { bundle, moved }))
            }
        }
    }

    pub(crate) fn observer<'a>(
        &'a self,
        list: &'a [Parameter],
        settings: Settings,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Box<dyn Observer + 'a> {
        match self {
            Self::Robot(robot, perturbed) => {
                let mut solver = solver(robot, settings);
                solver.stop_by(stop.cloned());
                Box::new(RobotObserver { solver, list, perturbed })
            }
            Self::Bundle(model) => Box::new(model.observer(list, stop)),
        }
    }
}

/// With settings that were found for another robot of the same design.
fn solver(robot: &Robot, settings: Settings) -> Solver {
    Solver::with_settings(robot, settings).unwrap_or_else(|_| Solver::new(robot))
}

/// Settings with as many modes as the most demanding of some measurements needs, of those that are looked at before the flag is set.
pub(crate) fn settings_for(
    robot: &Robot,
    measurements: &[&Measurement],
    stop: Option<&Arc<AtomicBool>>,
) -> Settings {
    let mut solver = Solver::new(robot);
    solver.stop_by(stop.cloned());
    let mut settings = *solver.settings();
    for m in measurements {
        if solver.is_stopped() {
            break;
        }
        let needed = solver.settings_for(&[command(m, robot.follower_count())], ACCURACY).settings;
        if needed.resolution.nodes > settings.resolution.nodes {
            settings = needed;
        }
    }
    settings
}

impl Found {
    /// Error of the tip as a part of the length; `None` where it is not known.
    pub(crate) fn error(&self) -> Option<f64> {
        match self {
            Self::Robot(found) => {
                let robot = found.robot();
                let error = solver(robot, *found.settings()).accuracy(found)?;
                Some(error.tip / robot.length())
            }
            Self::Bundle(found) => Some(found.error[0] / found.length),
        }
    }
}

struct RobotObserver<'a> {
    solver: Solver,
    list: &'a [Parameter],
    perturbed: &'a [Perturbed],
}

/// The force on the tip that a measurement was made under.
pub(crate) fn loads(m: &Measurement) -> Loads {
    let mut loads = Loads::none();
    if m.tip_force.norm() > 0.0 {
        loads.wrenches.push(Wrench { point: m.tip_point, ..Wrench::tip_force(m.tip_force) });
    }
    loads
}

fn command(m: &Measurement, followers: usize) -> Command {
    let actuators = (1..=followers)
        .map(|k| Actuator { push_pull: Drive::Motion(m.pulls[k]), rotation: Drive::Motion(m.rotations[k]) })
        .collect();
    Command { actuators, loads: loads(m), rotation_means: RotationMeans::Base }
}

/// The model's point and direction for a measurement.
fn observe(m: &Measurement, solver: &mut Solver, found: &Equilibrium) -> Vec<f64> {
    let shape = solver.shape_at(found, &[m.at.unwrap_or(found.robot().length())]);
    let section = &shape.sections[0];
    let point = match m.line {
        Line::Centre => section.centre,
        Line::Tube(tube) => section.tubes[tube].centroid,
    };
    outputs(point, section.rotation.column(0).into()).to_vec()
}

pub(crate) fn outputs(point: Vector3<f64>, direction: Vector3<f64>) -> [f64; 6] {
    [point.x, point.y, point.z, direction.x, direction.y, direction.z]
}

/// That a parameter has no derivative at a measurement.
pub(crate) fn no_derivative(m: &Measurement, parameter: Parameter) -> FitProblem {
    FitProblem::NoEquilibrium(m.row, format!("{parameter} has no derivative here"))
}

impl Observer for RobotObserver<'_> {
    fn see(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Seen, FitProblem> {
        let solver = &mut self.solver;
        if solver.is_stopped() {
            return Err(FitProblem::Stopped);
        }
        let command = command(m, solver.robot().follower_count());
        if let Some(demand) = absurd_demand(solver.robot(), &command) {
            return Err(FitProblem::Measurement(m.row, demand.to_string()));
        }
        let found = match start {
            Some(Found::Robot(start)) => solver.solve_from(&command, start),
            _ => solver.solve(&command),
        };
        let found = found.map_err(|e| FitProblem::Measurement(m.row, e.to_string()))?;
        if let Status::NotConverged(_) = found.status() {
            return Err(FitProblem::NoEquilibrium(m.row, found.status().to_string()));
        }
        let fixed = |values: Vec<f64>| std::array::from_fn(|i| values[i]);
        let outputs = fixed(observe(m, solver, &found));
        let mut slopes = Vec::new();
        for (moved, parameter) in self.perturbed.iter().zip(self.list) {
            let read = |solver: &mut Solver, eq: &Equilibrium| observe(m, solver, eq);
            let slope = solver.parameter_sensitivity(&found, moved, read);
            slopes.push(fixed(slope.map_err(|_| no_derivative(m, *parameter))?));
        }
        Ok(Seen { outputs, slopes, found: Found::Robot(Box::new(found)) })
    }
}
