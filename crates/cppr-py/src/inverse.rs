//! Inverse problems from an equilibrium on: actuators for a wanted tip or shape, the wrench behind measurements.
//!
//! Loads and drives are those of the equilibrium's command; actuators are chosen within their safe ranges about it.

use crate::analysis::{Either, input};
use crate::arrays::{dynamic, line, number, vector};
use crate::bundle::BundleEquilibrium;
use crate::command::tube_number;
use crate::equilibrium::Equilibrium;
use crate::watch::analysed;
use crate::{errors, rubbing};
use cppr::analysis::inverse::{
    Accuracy, FreeInput, InverseProblem, Measured, Reach, Sensed, ShapeMatch, ShapePoint, Target,
    Uncertainty, free_near, free_within,
};
use cppr::analysis::{Governing, RangeProblem, Teeth, governing};
use cppr::bundle::Friction;
use cppr::bundle::solve::BundleEquilibrium as BundleFound;
use cppr::solve::{Equilibrium as RobotFound, Quantity};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::Arc;

/// The inputs that may be chosen.
fn free(py: Python<'_>, equilibrium: &Equilibrium) -> PyResult<Vec<FreeInput>> {
    let (shared, found) = (&equilibrium.shared, &equilibrium.found);
    let ranges = analysed(py, found, |w| w.safe_ranges(found.command(), Teeth::Rigid))?;
    let ranges = ranges.map_err(|problem| errors::command(py, problem))?;
    Ok(free_within(&shared.robot, &ranges))
}

/// What makes a Python object of an equilibrium found.
trait Kept<E> {
    fn kept(&self, py: Python<'_>, found: E) -> PyResult<Py<PyAny>>;
}

impl Kept<RobotFound> for Equilibrium {
    fn kept(&self, py: Python<'_>, found: RobotFound) -> PyResult<Py<PyAny>> {
        Ok(Py::new(py, Equilibrium::new(Arc::clone(&self.shared), found))?.into_any())
    }
}

impl Kept<BundleFound> for BundleEquilibrium {
    fn kept(&self, py: Python<'_>, found: BundleFound) -> PyResult<Py<PyAny>> {
        Ok(Py::new(py, self.other(found))?.into_any())
    }
}

/// What all answers about actuators hold.
fn chosen<'py>(
    py: Python<'py>,
    free: &[FreeInput],
    values: &[f64],
    at_bound: &[bool],
    found: Py<PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let own = PyDict::new(py);
    own.set_item("inputs", PyTuple::new(py, free.iter().map(|f| input(&f.input)))?)?;
    own.set_item("values", line(py, values.iter().copied()))?;
    own.set_item("at_bound", at_bound.to_vec())?;
    own.set_item("equilibrium", found)?;
    Ok(own)
}

fn known(py: Python<'_>, own: &Bound<'_, PyDict>, uncertainty: &Uncertainty) -> PyResult<()> {
    own.set_item("covariance", dynamic(py, &uncertainty.covariance)?)?;
    own.set_item("deviations", line(py, uncertainty.deviations.iter().copied()))?;
    own.set_item("misfit", uncertainty.misfit)
}

/// Fields of `Reach`.
#[pyfunction]
pub fn reach<'py>(
    py: Python<'py>,
    equilibrium: Either<'py>,
    position: Option<Bound<'py, PyAny>>,
    direction: Option<Bound<'py, PyAny>>,
    near: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let read = |what: &str, value: Option<Bound<'py, PyAny>>| value.map(|v| vector(what, &v)).transpose();
    let target = Target { position: read("position", position)?, direction: read("direction", direction)? };
    let accuracy = Accuracy::default();
    let refused = |problem: InverseProblem| errors::command(py, problem);
    match &equilibrium {
        Either::Robot(own) => {
            let (shared, found) = (&own.shared, &own.found);
            let (free, answer) = if near {
                let free = free_near(found);
                // Short, and a solver that is kept: nothing to watch, nothing to build.
                let answer =
                    py.detach(|| shared.with(|solver| solver.reach_near(found, &free, &target, &accuracy)));
                (free, answer)
            } else {
                let free = free(py, own)?;
                let answer = analysed(py, found, |w| w.reach(found.command(), &free, &target, &accuracy))?;
                (free, answer)
            };
            let answer = answer.map_err(refused)?;
            let used = py.detach(|| {
                shared.with(|solver| {
                    let sections = solver.section_limits(&answer.equilibrium, Teeth::Rigid);
                    governing(&sections, solver.margin(&answer.equilibrium))
                })
            });
            reached(py, &**own, &free, answer, used)
        }
        Either::Bundle(own) => {
            let found = &own.found;
            let searched = own.analysed(py, |analysis| {
                let command = found.command();
                let free = if near { Ok(analysis.free_near(command)) } else { analysis.free(command) };
                free.map(|free| {
                    let answer = if near {
                        analysis.reach_near(found, &free, &target, &accuracy)
                    } else {
                        analysis.reach(command, &free, &target, &accuracy)
                    };
                    let used = |answer: &Reach<BundleFound>| {
                        governing(&analysis.section_limits(&answer.equilibrium, Teeth::Rigid), None)
                    };
                    (free, answer.map(|answer| (used(&answer), answer)))
                })
            })?;
            let (free, answer) = searched.map_err(|problem| errors::command(py, problem))?;
            let (used, answer) = answer.map_err(refused)?;
            reached(py, &**own, &free, answer, used)
        }
    }
}

fn reached<'py, E>(
    py: Python<'py>,
    of: &impl Kept<E>,
    free: &[FreeInput],
    answer: Reach<E>,
    used: Option<Governing>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = of.kept(py, answer.equilibrium)?;
    let own = chosen(py, free, &answer.values, &answer.at_bound, found)?;
    own.set_item("reached", answer.reached)?;
    own.set_item("distance", answer.distance)?;
    own.set_item("angle", answer.angle)?;
    own.set_item("depends_on_path", answer.depends_on_path)?;
    own.set_item("limit_used", used.map_or(f64::NAN, |g| g.utilisation))?;
    let conditioning = answer.conditioning.as_ref();
    own.set_item("condition", conditioning.map_or(f64::NAN, |c| c.condition))?;
    own.set_item("manipulability", conditioning.map_or(f64::NAN, |c| c.manipulability))?;
    Ok(own)
}

/// Fields of `ShapeMatch`; `points` holds x, y, z, label (NaN where unknown) of each.
#[pyfunction]
pub fn match_shape<'py>(
    py: Python<'py>,
    equilibrium: Either<'py>,
    points: Vec<[f64; 4]>,
    deviation: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let points: Vec<ShapePoint> = points
        .iter()
        .map(|&[x, y, z, label]| ShapePoint {
            label: (!label.is_nan()).then_some(label),
            position: [x, y, z].into(),
            deviation,
        })
        .collect();
    let refused = |problem: InverseProblem| errors::command(py, problem);
    match &equilibrium {
        Either::Robot(own) => {
            let free = free(py, own)?;
            let found = &own.found;
            let answer = analysed(py, found, |w| w.shape_match(found.command(), &free, &points))?;
            matched(py, &**own, &free, answer.map_err(refused)?)
        }
        Either::Bundle(own) => {
            let command = own.found.command();
            let searched = own.analysed(py, |analysis| {
                let free = analysis.free(command)?;
                let answer = analysis.shape_match(command, &free, &points);
                Ok::<_, RangeProblem>((free, answer))
            })?;
            let (free, answer) = searched.map_err(|problem| errors::command(py, problem))?;
            matched(py, &**own, &free, answer.map_err(refused)?)
        }
    }
}

fn matched<'py, E>(
    py: Python<'py>,
    of: &impl Kept<E>,
    free: &[FreeInput],
    answer: ShapeMatch<E>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = of.kept(py, answer.equilibrium)?;
    let own = chosen(py, free, &answer.values, &answer.at_bound, found)?;
    known(py, &own, &answer.uncertainty)?;
    own.set_item("distances", line(py, answer.distances))?;
    own.set_item("rms", answer.rms)?;
    Ok(own)
}

/// Fields of `Sensed`. `efforts` holds tension and torque by tube, `deviations` those of tension, torque, position, direction, `friction` the coefficient
/// and the length of the guide, those of the robot where they are not given.
#[pyfunction]
pub fn sense<'py>(
    py: Python<'py>,
    equilibrium: Either<'py>,
    efforts: [Option<Bound<'py, PyAny>>; 2],
    position: Option<Bound<'py, PyAny>>,
    direction: Option<Bound<'py, PyAny>>,
    deviations: [f64; 4],
    moment: bool,
    friction: [Option<f64>; 2],
) -> PyResult<Bound<'py, PyDict>> {
    let own = match &equilibrium {
        Either::Robot(own) => own.shared.friction,
        Either::Bundle(own) => own.friction,
    };
    let friction = rubbing::felt(friction[0], friction[1], own)?;
    let mut measured = Vec::new();
    // That there is no such tube, in the words of its robot.
    let lacking = |tube: usize| match &equilibrium {
        Either::Robot(own) => {
            let command = own.found.command();
            command.actuator(tube).is_none().then(|| command.no_such_tube(tube).to_string())
        }
        Either::Bundle(own) => {
            let count = own.found.efforts.len();
            let there = (1..=count).contains(&tube);
            (!there).then(|| format!("there is no such tube; this robot has tubes 1 to {count}"))
        }
    };
    for (i, (effort, quantity)) in efforts.iter().zip([Quantity::TENSION, Quantity::TORQUE]).enumerate() {
        let Some(effort) = effort else { continue };
        let mut add = |tube: usize, value: f64| -> PyResult<()> {
            if let Some(problem) = lacking(tube) {
                return Err(errors::command(py, format!("{}: {problem}", quantity.keyword)));
            }
            measured.push(Measured::Effort(tube, quantity.freedom, value, deviations[i]));
            Ok(())
        };
        match effort.cast::<PyDict>() {
            Ok(tubes) => {
                for (tube, value) in tubes {
                    add(tube_number(quantity, &tube)?, number(quantity.keyword, &value)?)?;
                }
            }
            Err(_) => add(2, number(quantity.keyword, effort)?)?,
        }
    }
    if let Some(position) = position {
        measured.push(Measured::Position(vector("position", &position)?, deviations[2]));
    }
    if let Some(direction) = direction {
        measured.push(Measured::Direction(vector("direction", &direction)?, deviations[3]));
    }
    let refused = |problem: InverseProblem| errors::command(py, problem);
    match (&equilibrium, &friction) {
        (Either::Robot(own), None) => {
            let (shared, found) = (&own.shared, &own.found);
            // A few solves: short, and with a solver that is kept.
            let answer = py.detach(|| shared.with(|solver| solver.sense_near(found, &measured, moment)));
            sensed(py, &**own, answer.map_err(refused)?)
        }
        (Either::Bundle(own), None) => {
            let found = &own.found;
            let answer = own.analysed(py, |analysis| analysis.sense_near(found, &measured, moment))?;
            sensed(py, &**own, answer.map_err(refused)?)
        }
        (Either::Robot(own), Some(friction)) => {
            sensed_rubbed(py, &own.as_bundle(py)?, &measured, moment, friction)
        }
        (Either::Bundle(own), Some(friction)) => sensed_rubbed(py, own, &measured, moment, friction),
    }
}

/// With what motors that were driven on, and motors that were driven back, make of the same measurements.
fn sensed_rubbed<'py>(
    py: Python<'py>,
    own: &BundleEquilibrium,
    measured: &[Measured],
    moment: bool,
    friction: &Friction,
) -> PyResult<Bound<'py, PyDict>> {
    let found = &own.found;
    let answers = own.analysed(py, |analysis| {
        let free = analysis.sense_near(found, measured, moment)?;
        let sides = analysis.sense_rubbed(&free, found.command(), measured, moment, friction)?;
        Ok((free, sides))
    })?;
    let (free, sides) = answers.map_err(|problem: InverseProblem| errors::command(py, problem))?;
    let dict = sensed(py, own, free)?;
    for (name, side) in ["loading", "unloading"].into_iter().zip(sides) {
        dict.set_item(name, side.map(|side| sensed(py, own, side)).transpose()?)?;
    }
    Ok(dict)
}

fn sensed<'py, E>(py: Python<'py>, of: &impl Kept<E>, answer: Sensed<E>) -> PyResult<Bound<'py, PyDict>> {
    let own = PyDict::new(py);
    own.set_item("force", line(py, answer.force.iter().copied()))?;
    own.set_item("moment", line(py, answer.moment.iter().copied()))?;
    own.set_item("misses", line(py, answer.misses.iter().copied()))?;
    known(py, &own, &answer.uncertainty)?;
    own.set_item("equilibrium", of.kept(py, answer.equilibrium)?)?;
    Ok(own)
}
