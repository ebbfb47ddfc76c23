//! Sweeps into a file: `cppr_sweep` on a robot file.

use crate::arrays::vector;
use crate::bundle::{Bundle, put};
use crate::command::{Asked, Drives, add_loads, full_turns, suspicious};
use crate::design::pick;
use crate::errors;
use crate::robot::Robot;
use crate::rubbing;
use crate::watch::watched;
use cppr::analysis::Teeth;
use cppr::bundle::Friction;
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::solve::Quantity;
use cppr::statics::{Loads, Wrench};
use cppr_io::bundle_file::{self, Described};
use cppr_sweep::{
    Axis, BundleSubject, FileOptions, FileProblem, Format, Plan, RobotSubject, Subject, Task, Values,
    Variable, Verdict, write_file,
};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// What varies ("pull", ..., "tip_force", "tip_moment", "vary"), tube or component, key of the file; "range" or "normal" with
/// its two numbers and the count of a range.
type AxisArguments = (String, usize, String, String, f64, f64, u32);

fn axis(arguments: AxisArguments) -> Axis {
    let (what, index, key, distribution, a, b, count) = arguments;
    let variable = match (Quantity::named(&what), what.as_str()) {
        (Some(quantity), _) => Variable::Actuator(quantity.of_tube(index)),
        (None, "tip_force") => Variable::Force { wrench: 0, component: index },
        (None, "tip_moment") => Variable::Moment { wrench: 0, component: index },
        _ => Variable::Design(key),
    };
    let values = match distribution.as_str() {
        "normal" => Values::Normal { mean: a, deviation: b },
        _ => Values::Range { from: a, to: b, count },
    };
    Axis { variable, values }
}

fn failed(py: Python<'_>, problem: &FileProblem) -> PyErr {
    match problem {
        FileProblem::Task(_) => errors::command(py, problem),
        _ => PyOSError::new_err(problem.to_string()),
    }
}

/// A robot file, and how its tubes rub: as given, else as it says. With friction it is integrated, and where sudden changes that modes do not follow are in it, unless something is asked for that only modes have.
fn described(
    py: Python<'_>,
    path: &Path,
    [coefficient, guide]: [Option<f64>; 2],
    keeps_modes: bool,
) -> PyResult<(Described, Option<Friction>)> {
    let read = bundle_file::read(path).map_err(|problems| errors::file(py, &problems))?;
    let friction = rubbing::felt(coefficient, guide, read.friction())?;
    if friction.is_some() {
        return Ok((Described::Bundle { design: read.into_bundle(), friction }, friction));
    }
    let (robot, sudden) = if keeps_modes { (read, None) } else { read.integrated() };
    if let Some(places) = sudden {
        let text = format!(
            "modes do not follow sudden changes ({places}): the sweep integrates along the robot; settings or margin keep the modes"
        );
        errors::warn(py, "AccuracyWarning", &text)?;
    }
    Ok((robot, None))
}

/// Rows of every verdict, by its word.
#[pyfunction]
pub fn sweep<'py>(
    py: Python<'py>,
    path: PathBuf,
    output: PathBuf,
    axes: Vec<AxisArguments>,
    drives: Drives<'py>,
    tip: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    loads: Option<Bound<'py, PyAny>>,
    settings: Option<Bound<'py, PyAny>>,
    accuracy: Option<f64>,
    samples: Option<u64>,
    seed: u64,
    margin: bool,
    teeth: Option<&str>,
    friction: [Option<f64>; 2],
    resume: bool,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (described, friction) = described(py, &path, friction, settings.is_some() || margin)?;
    let robot_text = std::fs::read_to_string(&path)?;
    let mut subject = match described {
        Described::Robot(file) => {
            let robot = Robot::build(py, file.design, None)?.shared.robot.clone();
            let (base, settings) = Asked {
                drives: drives.each_ref().map(Option::as_ref),
                loads: loads.as_ref(),
                settings: settings.as_ref(),
                ..Asked::default()
            }
            .read(&robot)?;
            Subject::Robot(Box::new(RobotSubject { robot, base, settings }))
        }
        Described::Bundle { .. } if settings.is_some() => {
            return Err(errors::command(
                py,
                "settings are not for a robot with parts or joints, nor for friction: there are no modes",
            ));
        }
        Described::Bundle { design, .. } => {
            let bundle = Bundle::build(py, design, None)?;
            let mut base = BundleCommand {
                drives: vec![TubeDrive::HELD; bundle.design.tubes.len()],
                loads: Loads::none(),
            };
            put(py, &mut base.drives, &drives)?;
            if let Some(list) = &loads {
                add_loads(&mut base.loads, list)?;
            }
            let (bundle, design) = (bundle.bundle.as_ref().clone(), bundle.design.as_ref().clone());
            Subject::Bundle(Box::new(BundleSubject { bundle, design, base, stretch: false }))
        }
    };
    if let Some((force, moment)) = tip {
        let mut wrench = Wrench::tip_force(vector("tip_force", &force)?);
        wrench.moment = vector("tip_moment", &moment)?;
        let loads = match &mut subject {
            Subject::Robot(own) => &mut own.base.loads,
            Subject::Bundle(own) => &mut own.base.loads,
        };
        // Axes of the tip's wrench count on it being the first.
        loads.wrenches.insert(0, wrench);
    }
    let Some(format) = Format::of(&output) else {
        let text = format!("{}: tables are written as .csv, .npz or .parquet", output.display());
        return Err(PyValueError::new_err(text));
    };
    let limits = match teeth {
        None => None,
        Some(text) => Some(match pick("teeth", PyString::new(py, text).as_any(), &["rigid", "bending"])? {
            0 => Teeth::Rigid,
            _ => Teeth::Bending,
        }),
    };
    let plan = samples.map_or(Plan::Grid, |count| Plan::Samples { count, seed });
    for (what, _, _, distribution, a, b, _) in &axes {
        let largest = if distribution == "normal" { a.abs() } else { a.abs().max(b.abs()) };
        let text = Quantity::named(what).and_then(|quantity| match &subject {
            Subject::Robot(own) => suspicious(quantity, &own.robot, largest),
            Subject::Bundle(_) => full_turns(quantity, largest),
        });
        if let Some(text) = text {
            errors::warn(py, "UnitWarning", &text)?;
        }
    }
    let axes = axes.into_iter().map(axis).collect();
    let mut task = Task { subject, robot_text, axes, plan, margin, limits, friction };
    if let Some(part) = accuracy {
        task.check().map_err(|problem| errors::command(py, problem))?;
        let chosen = matches!(&task.subject, Subject::Robot(own) if own.settings.modes_are_chosen());
        let left = py.detach(|| task.resolve(if chosen { f64::INFINITY } else { part }));
        if let Some((error, rows)) = left.filter(|left| left.0 > part && !chosen) {
            let text = format!(
                "a tip is within {error:.1e} of the length only, not {part:.1e}, among {rows} rows looked at: the fields of this robot \
                 change faster along it than four times as many modes follow; cppr sweep --integrate solves without modes"
            );
            errors::warn(py, "AccuracyWarning", &text)?;
        }
    }
    let total = usize::try_from(task.rows()).unwrap_or(usize::MAX);
    let mut result = None;
    watched(py, total, progress.as_ref(), |done, stop| {
        let options = FileOptions { threads, resume, format, stop };
        let tell = |rows| done.store(usize::try_from(rows).unwrap_or(usize::MAX), Ordering::Relaxed);
        result = Some(write_file(&task, &output, &options, tell, |_| {}));
    })?;
    let counts = PyDict::new(py);
    if let Some(finished) = result {
        let finished = finished.map_err(|problem| failed(py, &problem))?;
        for (verdict, rows) in Verdict::ALL.iter().zip(finished.counts) {
            if rows > 0 {
                counts.set_item(verdict.text(), rows)?;
            }
        }
    }
    Ok(counts)
}
