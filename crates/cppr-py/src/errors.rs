//! Problems as the exceptions of `cppr._errors`.

use cppr::design::DesignProblem;
use cppr::solve::{CommandProblem, Reason, Status};
use cppr_io::Problems;
use pyo3::exceptions::{PyTypeError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::ffi::CString;
use std::fmt::Display;

fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("cppr._errors")?.getattr(name)
}

/// An exception of the package whose only argument is its message.
pub fn error(py: Python<'_>, name: &str, message: impl Display) -> PyErr {
    match class(py, name).and_then(|class| class.call1((message.to_string(),))) {
        Ok(value) => PyErr::from_value(value),
        Err(error) => error,
    }
}

/// A `CommandError`.
pub fn command(py: Python<'_>, message: impl Display) -> PyErr {
    error(py, "CommandError", message)
}

/// A `CommandError` from the solver's own check.
pub fn refused(py: Python<'_>, problem: &CommandProblem) -> PyErr {
    command(py, problem)
}

/// A `TypeError`: what was to be given, and what was.
pub fn wrong_type(what: &str, wanted: &str, given: &Bound<'_, PyAny>) -> PyErr {
    let name = given.get_type().name().map_or_else(|_| "something else".into(), |name| name.to_string());
    PyTypeError::new_err(format!("{what} must be {wanted}, not {name}"))
}

/// A warning of one of the package's categories: `UnitWarning` where a number looks as if it were in another unit, `AccuracyWarning`
/// where an answer is not as accurate as was asked for.
pub fn warn(py: Python<'_>, category: &str, message: &str) -> PyResult<()> {
    let category = class(py, category).unwrap_or_else(|_| py.get_type::<PyUserWarning>().into_any());
    let message = CString::new(message).unwrap_or_default();
    PyErr::warn(py, &category, &message, 1)
}

/// One problem: line, column, key, message, help.
pub type Listed = (usize, usize, String, String, String);

/// A `RobotError` with all problems.
pub fn robot(py: Python<'_>, text: &str, problems: Vec<Listed>) -> PyErr {
    let build = || -> PyResult<PyErr> {
        let problem = class(py, "Problem")?;
        let list = problems.into_iter().map(|p| problem.call1(p)).collect::<PyResult<Vec<_>>>()?;
        let value = class(py, "RobotError")?.call1((text, PyTuple::new(py, list)?))?;
        Ok(PyErr::from_value(value))
    };
    build().unwrap_or_else(|error| error)
}

/// A `RobotError` from the problems of a file.
pub fn file(py: Python<'_>, problems: &Problems) -> PyErr {
    let list = problems
        .list
        .iter()
        .map(|p| (p.line, p.column, p.key.clone(), p.message.clone(), p.help.clone()))
        .collect();
    robot(py, &problems.to_string(), list)
}

/// A problem of a design as a row of the list.
pub fn listed(problem: &DesignProblem) -> Listed {
    let key = match problem {
        DesignProblem::Length(_) => "length".into(),
        DesignProblem::NoTube => "tubes".into(),
        DesignProblem::Section { tube, .. }
        | DesignProblem::Field { tube, .. }
        | DesignProblem::TooWide { tube, .. } => format!("tube {tube}"),
        DesignProblem::Joint { joint, .. } => format!("joint {joint}"),
    };
    (0, 0, key, problem.to_string(), String::new())
}

/// A `RobotError` from the problems of a design.
pub fn design(py: Python<'_>, problems: &[DesignProblem]) -> PyErr {
    robot_list(py, problems.iter().map(listed).collect())
}

/// A `RobotError` whose text is the list of its problems.
pub fn robot_list(py: Python<'_>, list: Vec<Listed>) -> PyErr {
    let text: Vec<&str> = list.iter().map(|p| p.3.as_str()).collect();
    robot(py, &text.join("\n"), list)
}

/// A `NoEquilibrium` with the last iterate.
pub fn no_equilibrium(py: Python<'_>, status: Status, why: &str, iterate: Bound<'_, PyAny>) -> PyErr {
    let fraction = match status {
        Status::NotConverged(Reason::PathEnds { fraction }) => fraction,
        _ => 0.0,
    };
    match class(py, "NoEquilibrium").and_then(|class| class.call1((why, fraction, iterate))) {
        Ok(value) => PyErr::from_value(value),
        Err(error) => error,
    }
}
