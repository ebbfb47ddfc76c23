//! Calibration: `cppr_calibrate` on robots and a table of measurements.

use crate::bundle::Bundle;
use crate::errors;
use crate::robot::Robot;
use crate::rubbing;
use crate::watch::stoppable;
use cppr::bundle::{BundleDesign, Friction};
use cppr_calibrate::{Design, Parameter, ParameterKind, common_friction, fit, read};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// A robot of either kind.
#[derive(FromPyObject)]
pub enum Subject<'py> {
    Robot(PyRef<'py, Robot>),
    Bundle(PyRef<'py, Bundle>),
}

/// Fits parameters; the result's fields by name.
#[pyfunction]
#[pyo3(signature = (robots, table, parameters, friction, guide))]
pub fn calibrate<'py>(
    py: Python<'py>,
    robots: Vec<Subject<'py>>,
    table: &str,
    parameters: Vec<String>,
    friction: Option<f64>,
    guide: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let refuse = |text: String| errors::error(py, "CalibrationError", text);
    let list = parameters
        .iter()
        .map(|text| Parameter::parse(text))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|problem| refuse(problem.to_string()))?;
    let designs: Vec<Design> = robots
        .iter()
        .map(|robot| match robot {
            Subject::Robot(robot) => robot.shared.robot.design().clone().into(),
            Subject::Bundle(bundle) => BundleDesign::clone(&bundle.design).into(),
        })
        .collect();
    let tubes = designs.iter().map(Design::tube_count).max().unwrap_or(0);
    let measurements = read(table, tubes).map_err(|problems| {
        refuse(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    })?;
    let each = robots.iter().map(|robot| match robot {
        Subject::Robot(robot) => robot.shared.friction,
        Subject::Bundle(bundle) => bundle.friction,
    });
    let each: Vec<_> = each.collect();
    let own = match common_friction(&each) {
        Err(problem) if friction.is_none() => return Err(refuse(problem.to_string())),
        own => own.ok().flatten(),
    };
    let friction = rubbing::felt(friction, guide, own)?;
    let found = stoppable(py, |stop| fit(&designs, &measurements, &list, friction, Some(Arc::clone(stop))))?;
    let found = found.map_err(|problem| refuse(problem.to_string()))?;
    let rubs = found
        .estimates
        .iter()
        .find(|e| e.parameter.kind == ParameterKind::Friction)
        .map(|e| Friction { coefficient: e.value, guide: friction.and_then(|own| own.guide) });
    let fitted = found
        .designs
        .iter()
        .zip(each)
        .map(|(design, own)| match design.clone() {
            Design::Robot(design) => Py::new(py, Robot::build(py, design, rubs.or(own))?).map(Py::into_any),
            Design::Bundle(design) => Py::new(py, Bundle::build(py, design, rubs.or(own))?).map(Py::into_any),
        })
        .collect::<PyResult<Vec<_>>>()?;
    let result = PyDict::new(py);
    let each =
        |get: fn(&cppr_calibrate::Estimate) -> f64| found.estimates.iter().map(get).collect::<Vec<_>>();
    result.set_item("robots", fitted)?;
    result.set_item("parameters", parameters)?;
    result.set_item("values", each(|e| e.value))?;
    result.set_item("before", each(|e| e.before))?;
    result.set_item("deviations", each(|e| e.deviation))?;
    result.set_item("intervals", each(|e| e.interval))?;
    result.set_item("at_bounds", found.estimates.iter().map(|e| e.at_bound).collect::<Vec<_>>())?;
    result.set_item("correlation", found.correlation)?;
    result.set_item("scale", found.scale)?;
    result.set_item("rms", found.rms)?;
    result.set_item("rms_before", found.rms_before)?;
    let (error, known) = found.accuracy;
    result.set_item("accuracy", (known > 0).then_some(error))?;
    let misses: Vec<_> =
        found.misses.iter().map(|own| (own.what.to_string(), own.before, own.fitted, own.measured)).collect();
    result.set_item("misses", misses)?;
    let residuals: Vec<_> = found
        .residuals
        .iter()
        .map(|r| (r.row, r.what.to_string(), r.value, r.studentised, r.outlier))
        .collect();
    result.set_item("residuals", residuals)?;
    Ok(result)
}
