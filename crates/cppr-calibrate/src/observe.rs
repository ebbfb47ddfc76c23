//! What the model of tubes of one length says to measurements, and how that changes with the parameters.

use crate::bundle::{BundleModel, State};
use crate::clearance::{ClearanceModel, Loose};
use crate::data::{Line, Measurement, Observed};
use crate::design::Design;
use crate::fit::FitProblem;
use crate::parameter::{Parameter, Values};
use cppr::Vector3;
use cppr::analysis::{ACCURACY, Perturbed, absurd_demand};
use cppr::bundle::Bundle;
use cppr::bundle::solve::BundleEquilibrium;
use cppr::design::{DesignProblems, Robot};
use cppr::solve::{
    Actuator, ActuatorState, Command, Equilibrium, Freedom, Quantity, Settings, Solver, Status,
};
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

/// A robot at some values of the parameters, ready to be asked. Measurements of one pose are asked of together.
pub(crate) trait Observer {
    /// The equilibrium that a measurement was made in; from an earlier one of the same measurement, if there is one.
    fn solve(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Found, FitProblem>;

    /// All numbers that were measured in it, measurement by measurement.
    fn read(&mut self, pose: &[Measurement], found: &Found) -> Result<Vec<f64>, FitProblem>;

    /// Their slopes by what the search moves, for every parameter; `outputs` are the numbers themselves.
    fn slopes(
        &mut self,
        pose: &[Measurement],
        found: &Found,
        outputs: &[f64],
    ) -> Result<Vec<Vec<f64>>, FitProblem>;

    /// Greatest strain of a bundle's tube (number from 1), or of all, with teeth that bend as the notches do and with rigid ones.
    fn strains(&self, _found: &Found, _tube: Option<usize>) -> [f64; 2] {
        [0.0; 2]
    }
}

/// A robot at some values of the parameters and, for derivatives, near them.
pub(crate) enum Model {
    Robot(Robot, Vec<Perturbed>),
    Clearance(ClearanceModel),
    Bundle(BundleModel),
}

impl Model {
    pub(crate) fn new(design: &Design, at: &Values<'_>, derivatives: bool) -> Result<Self, FitProblem> {
        let unsound = |problems: DesignProblems| FitProblem::Search(problems.to_string());
        let moved = if derivatives { at.list.len() } else { 0 };
        let why =
            |p: usize| FitProblem::Search(format!("{} cannot be changed at {}", design.name(), at.list[p]));
        let rubs = at.friction().is_some();
        match at.design(design) {
            Design::Robot(_) if at.has_gaps() => {
                let loose = |at: &Values<'_>| {
                    let Design::Robot(own) = at.design(design) else { return None };
                    let gaps = at.gaps(&own)?;
                    Some(Loose { robot: Robot::from_design(own).ok()?, gaps })
                };
                // Whatever is at the bound of its values moves to the other side.
                let one = |p: usize| {
                    let near = |by: f64| Some((loose(&at.moved(p, by))?, by));
                    near(STEP).or_else(|| near(-STEP)).ok_or_else(|| why(p))
                };
                let moved = (0..moved).map(one).collect::<Result<Vec<_>, _>>()?;
                let own = loose(at).ok_or_else(|| {
                    let name = design.name();
                    FitProblem::Search(format!(
                        "the gaps of {name} are not known, or its values are not sound"
                    ))
                })?;
                Ok(Self::Clearance(ClearanceModel { own, moved }))
            }
            Design::Robot(own) if !rubs => {
                let near = |p: usize, by: f64| match at.moved(p, by).design(design) {
                    Design::Robot(own) => Robot::from_design(own).ok(),
                    Design::Bundle(_) => None,
                };
                let one = |p: usize| Perturbed::new(STEP, |by| near(p, by)).ok_or_else(|| why(p));
                let perturbed = (0..moved).map(one).collect::<Result<Vec<_>, _>>()?;
                Ok(Self::Robot(Robot::from_design(own).map_err(unsound)?, perturbed))
            }
            own => {
                let near = |p: usize, by: f64| {
                    let there = at.moved(p, by);
                    let own = there.design(design).integrated();
                    Some((State { bundle: Bundle::new(&own).ok()?, friction: there.friction() }, by))
                };
                // At a bound of its values a parameter moves to one side only. Friction is found in turns, which cost far more than what the other side gains.
                let sides = if rubs { 1 } else { 2 };
                let one = |p: usize| {
                    let built = [STEP, -STEP].into_iter().filter_map(|by| near(p, by));
                    let states: Vec<_> = built.take(sides).collect();
                    if states.is_empty() { Err(why(p)) } else { Ok(states) }
                };
                let moved = (0..moved).map(one).collect::<Result<Vec<_>, _>>()?;
                let by_leader = matches!(own, Design::Robot(_));
                let own = own.integrated();
                let bundle = Bundle::new(&own).map_err(unsound)?;
                let state = State { bundle, friction: at.friction() };
                Ok(Self::Bundle(BundleModel { design: own, by_leader, own: state, moved }))
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
                Box::new(RobotObserver::new(robot, list, perturbed, settings, stop))
            }
            Self::Clearance(model) => Box::new(model.observer(list, settings, stop)),
            Self::Bundle(model) => Box::new(model.observer(list, stop)),
        }
    }
}

/// With settings that were found for another robot of the same design.
pub(crate) fn solver(robot: &Robot, settings: Settings) -> Solver {
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

pub(crate) struct RobotObserver<'a> {
    pub solver: Solver,
    list: &'a [Parameter],
    perturbed: &'a [Perturbed],
}

impl<'a> RobotObserver<'a> {
    pub(crate) fn new(
        robot: &Robot,
        list: &'a [Parameter],
        perturbed: &'a [Perturbed],
        settings: Settings,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Self {
        let mut solver = solver(robot, settings);
        solver.stop_by(stop.cloned());
        Self { solver, list, perturbed }
    }
}

impl Measurement {
    /// The force on the tip that it was made under.
    pub(crate) fn loads(&self) -> Loads {
        let mut loads = Loads::none();
        if self.tip_force.norm() > 0.0 {
            loads.wrenches.push(Wrench { point: self.tip_point, ..Wrench::tip_force(self.tip_force) });
        }
        loads
    }
}

fn command(m: &Measurement, followers: usize) -> Command {
    let own = m.drives[1..=followers].iter();
    let actuators = own.map(|d| Actuator { push_pull: d.translation, rotation: d.rotation }).collect();
    Command { actuators, loads: m.loads(), rotation_means: RotationMeans::Base }
}

/// The model's numbers for the measurements of a pose.
fn observe(pose: &[Measurement], solver: &mut Solver, found: &Equilibrium) -> Vec<f64> {
    let mut one = |m: &Measurement| {
        let shape = solver.shape_at(found, &[m.at.unwrap_or(found.robot().length())]);
        let section = &shape.sections[0];
        let point = match m.line {
            Line::Centre => section.centre,
            Line::Tube(tube) => section.tubes[tube].centroid,
        };
        numbers(m, point, section.rotation.column(0).into(), |tube, freedom| {
            let own = found.actuator(tube + 1).copied().unwrap_or_default();
            ActuatorState::get(&own, Quantity::of(freedom, false))
        })
    };
    pose.iter().flat_map(&mut one).collect()
}

/// The numbers that a measurement asks for, of the point (m) and direction there and of the motors.
pub(crate) fn numbers(
    m: &Measurement,
    point: Vector3<f64>,
    direction: Vector3<f64>,
    effort: impl Fn(usize, Freedom) -> f64,
) -> Vec<f64> {
    let value = |observed| match observed {
        Observed::Coordinate(axis) => point[axis],
        Observed::Direction(axis) => direction[axis],
        Observed::Bend => direction.y.hypot(direction.z).atan2(direction.x),
        Observed::Effort(tube, freedom) => effort(tube, freedom),
    };
    m.numbers().into_iter().map(|(observed, ..)| value(observed)).collect()
}

/// That a parameter has no derivative at a measurement.
pub(crate) fn no_derivative(m: &Measurement, parameter: Parameter) -> FitProblem {
    FitProblem::NoEquilibrium(m.row, format!("{parameter} has no derivative here"))
}

impl Observer for RobotObserver<'_> {
    fn solve(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Found, FitProblem> {
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
        Ok(Found::Robot(Box::new(found)))
    }

    fn read(&mut self, pose: &[Measurement], found: &Found) -> Result<Vec<f64>, FitProblem> {
        let Found::Robot(found) = found else { return Ok(Vec::new()) };
        Ok(observe(pose, &mut self.solver, found))
    }

    fn slopes(
        &mut self,
        pose: &[Measurement],
        found: &Found,
        _outputs: &[f64],
    ) -> Result<Vec<Vec<f64>>, FitProblem> {
        let Found::Robot(found) = found else { return Ok(Vec::new()) };
        let read = |solver: &mut Solver, eq: &Equilibrium| observe(pose, solver, eq);
        let one = |(moved, parameter): (&Perturbed, &Parameter)| {
            let slope = self.solver.parameter_sensitivity(found, moved, read);
            slope.map_err(|_| no_derivative(&pose[0], *parameter))
        };
        self.perturbed.iter().zip(self.list).map(one).collect()
    }
}
