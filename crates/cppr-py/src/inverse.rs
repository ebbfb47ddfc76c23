//! Inverse problems from an equilibrium on: actuators for a wanted tip or shape, the wrench behind measurements.
//!
//! Loads and drives are those of the equilibrium's command; actuators are chosen within their safe ranges about it.

use crate::analysis::input;
use crate::arrays::{dynamic, line, number, vector};
use crate::command::tube_number;
use crate::equilibrium::Equilibrium;
use crate::errors;
use crate::watch::analysed;
use cppr::analysis::inverse::{
    Accuracy, FreeInput, Measured, ShapePoint, Target, Uncertainty, free_near, free_within,
};
use cppr::analysis::{Teeth, governing};
use cppr::solve::Quantity;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::fmt::Display;
use std::sync::Arc;

/// The inputs that may be chosen.
fn free(py: Python<'_>, equilibrium: &Equilibrium) -> PyResult<Vec<FreeInput>> {
    let (shared, found) = (&equilibrium.shared, &equilibrium.found);
    let ranges = analysed(py, found, |w| w.safe_ranges(found.command(), Teeth::Rigid))?;
    let ranges = ranges.map_err(|problem| errors::command(py, problem))?;
    Ok(free_within(&shared.robot, &ranges))
}

/// What all answers about actuators hold.
fn chosen<'py>(
    py: Python<'py>,
    of: &Equilibrium,
    free: &[FreeInput],
    values: &[f64],
    at_bound: &[bool],
    found: cppr::solve::Equilibrium,
) -> PyResult<Bound<'py, PyDict>> {
    let own = PyDict::new(py);
    own.set_item("inputs", PyTuple::new(py, free.iter().map(|f| input(&f.input)))?)?;
    own.set_item("values", line(py, values.iter().copied()))?;
    own.set_item("at_bound", at_bound.to_vec())?;
    own.set_item("equilibrium", Equilibrium::new(Arc::clone(&of.shared), found))?;
    Ok(own)
}

fn known(py: Python<'_>, own: &Bound<'_, PyDict>, uncertainty: &Uncertainty) -> PyResult<()> {
    own.set_item("covariance", dynamic(py, &uncertainty.covariance)?)?;
    own.set_item("deviations", line(py, uncertainty.deviations.iter().copied()))?;
    own.set_item("misfit", uncertainty.misfit)
}

fn refused(py: Python<'_>) -> impl Fn(&dyn Display) -> PyErr + '_ {
    move |problem| errors::command(py, problem)
}

/// Fields of `Reach`.
#[pyfunction]
pub fn reach<'py>(
    py: Python<'py>,
    equilibrium: PyRef<'py, Equilibrium>,
    position: Option<Bound<'py, PyAny>>,
    direction: Option<Bound<'py, PyAny>>,
    near: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let read = |what: &str, value: Option<Bound<'py, PyAny>>| value.map(|v| vector(what, &v)).transpose();
    let target = Target { position: read("position", position)?, direction: read("direction", direction)? };
    let (shared, found, accuracy) = (&equilibrium.shared, &equilibrium.found, Accuracy::default());
    let (free, answer) = if near {
        let free = free_near(found);
        // Short, and a solver that is kept: nothing to watch, nothing to build.
        let answer = py.detach(|| shared.with(|solver| solver.reach_near(found, &free, &target, &accuracy)));
        (free, answer)
    } else {
        let free = free(py, &equilibrium)?;
        let answer = analysed(py, found, |w| w.reach(found.command(), &free, &target, &accuracy))?;
        (free, answer)
    };
    let answer = answer.map_err(|problem| refused(py)(&problem))?;
    let used = py.detach(|| {
        shared.with(|solver| {
            let sections = solver.section_limits(&answer.equilibrium, Teeth::Rigid);
            governing(&sections, solver.margin(&answer.equilibrium))
        })
    });
    let own = chosen(py, &equilibrium, &free, &answer.values, &answer.at_bound, answer.equilibrium)?;
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
    equilibrium: PyRef<'py, Equilibrium>,
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
    let free = free(py, &equilibrium)?;
    let found = &equilibrium.found;
    let answer = analysed(py, found, |w| w.shape_match(found.command(), &free, &points))?;
    let answer = answer.map_err(|problem| refused(py)(&problem))?;
    let own = chosen(py, &equilibrium, &free, &answer.values, &answer.at_bound, answer.equilibrium)?;
    known(py, &own, &answer.uncertainty)?;
    own.set_item("distances", line(py, answer.distances))?;
    own.set_item("rms", answer.rms)?;
    Ok(own)
}

/// Fields of `Sensed`. `efforts` holds tension and torque by tube, `deviations` those of tension, torque, position, direction.
#[pyfunction]
pub fn sense<'py>(
    py: Python<'py>,
    equilibrium: PyRef<'py, Equilibrium>,
    efforts: [Option<Bound<'py, PyAny>>; 2],
    position: Option<Bound<'py, PyAny>>,
    direction: Option<Bound<'py, PyAny>>,
    deviations: [f64; 4],
    moment: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let mut measured = Vec::new();
    let command = equilibrium.found.command();
    for (i, (effort, quantity)) in efforts.iter().zip([Quantity::TENSION, Quantity::TORQUE]).enumerate() {
        let Some(effort) = effort else { continue };
        let mut add = |tube: usize, value: f64| -> PyResult<()> {
            if command.actuator(tube).is_none() {
                let problem = command.no_such_tube(tube);
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
    let (shared, found) = (&equilibrium.shared, &equilibrium.found);
    // A few solves: short, and with a solver that is kept.
    let answer = py.detach(|| shared.with(|solver| solver.sense_near(found, &measured, moment)));
    let answer = answer.map_err(|problem| refused(py)(&problem))?;
    let own = PyDict::new(py);
    own.set_item("force", line(py, answer.force.iter().copied()))?;
    own.set_item("moment", line(py, answer.moment.iter().copied()))?;
    own.set_item("misses", line(py, answer.misses.iter().copied()))?;
    known(py, &own, &answer.uncertainty)?;
    own.set_item("equilibrium", Equilibrium::new(Arc::clone(&equilibrium.shared), answer.equilibrium))?;
    Ok(own)
}
