//! Many poses of a robot of parts and joints in one call.

use crate::bundle::{Bundle, read_loads};
use crate::command::KEYWORDS;
use crate::errors;
use crate::watch::watched;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive, load_behind_plate};
use cppr::solve::Input;
use cppr_sweep::solve_many_of_bundle as solve;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

/// Error allowed in one step from a pose to the next: it leaves the tip within 1e-5 of the length.
const LOOP_TOLERANCE: f64 = 1e-6;

/// One row: status, iterations, error, tip position and rotation, then label, rotation, force and torque of every tube's motor, then the tip's Jacobian.
fn write(row: &mut [f64], solver: &BundleSolver, found: &BundleEquilibrium, jacobian: bool) {
    row.fill(f64::NAN);
    let reached = found.converged && load_behind_plate(found.command(), found).is_none();
    row[0] = if !reached {
        2.0
    } else if found.stable {
        0.0
    } else {
        1.0
    };
    row[1] = found.iterations as f64;
    if !reached {
        return;
    }
    row[2] = found.error[0];
    let efforts = &found.efforts;
    let values = found.tip.iter().copied().chain((0..9).map(|i| found.frame[(i / 3, i % 3)]));
    let values = values
        .chain(efforts.iter().map(|own| own.label))
        .chain(efforts.iter().map(|own| own.rotation))
        .chain(efforts.iter().map(|own| own.force))
        .chain(efforts.iter().map(|own| own.torque));
    let tip = if jacobian { solver.tip_jacobian(found) } else { None };
    let slopes =
        tip.iter().flat_map(|tip| tip.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()));
    for (cell, value) in row[3..].iter_mut().zip(values.chain(slopes)) {
        *cell = value;
    }
}

/// Fills `out`, one row per pose. `columns` holds (means, tube, values).
#[pyfunction]
#[pyo3(signature = (bundle, columns, tip_force, tip_moment, loads, stretch, out, jacobian, threads, progress, warm))]
pub fn solve_many_of_bundle(
    py: Python<'_>,
    bundle: PyRef<'_, Bundle>,
    columns: Vec<(usize, i64, PyReadonlyArray1<'_, f64>)>,
    tip_force: Option<PyReadonlyArray2<'_, f64>>,
    tip_moment: Option<PyReadonlyArray2<'_, f64>>,
    loads: Option<Bound<'_, PyAny>>,
    stretch: bool,
    mut out: PyReadwriteArray2<'_, f64>,
    jacobian: bool,
    threads: usize,
    progress: Option<Py<PyAny>>,
    warm: bool,
) -> PyResult<()> {
    let (design, bundle) = (&bundle.design, &bundle.bundle);
    let tubes = design.tubes.len();
    let (poses, width) = (out.as_array().nrows(), out.as_array().ncols());
    let mut given: Vec<(Input, &[f64])> = Vec::new();
    for (means, tube, values) in &columns {
        let quantity = KEYWORDS[*means % 4];
        let refused = |text: String| errors::command(py, format!("{}: {text}", quantity.keyword));
        let number = usize::try_from(*tube).unwrap_or(0);
        let input = quantity.of_tube(number);
        if number == 0 || number > tubes {
            return Err(refused(format!("there is no tube {tube}; this robot has tubes 1 to {tubes}")));
        }
        if given.iter().any(|(other, _)| other.is_same_freedom(input)) {
            return Err(refused(format!("the same motion of tube {tube} is given twice")));
        }
        given.push((input, values.as_slice()?));
    }
    let force = tip_force.as_ref().map(|own| own.as_slice()).transpose()?;
    let moment = tip_moment.as_ref().map(|own| own.as_slice()).transpose()?;
    let lengths =
        given.iter().map(|(_, own)| own.len()).chain(force.iter().chain(&moment).map(|own| own.len() / 3));
    if width != 15 + 4 * tubes + usize::from(jacobian) * 12 * tubes || lengths.into_iter().any(|n| n != poses)
    {
        return Err(PyValueError::new_err("the arrays of the poses differ in length"));
    }
    let mut base = BundleCommand {
        drives: vec![TubeDrive::HELD; tubes],
        loads: read_loads(None, None, loads.as_ref())?,
    };
    if force.is_some() || moment.is_some() {
        base.loads.wrenches.push(cppr::statics::Wrench::tip_force(cppr::Vector3::zeros()));
    }
    let command = |pose: usize| {
        let mut command =
            given.iter().fold(base.clone(), |own, (input, values)| own.with_input(*input, values[pose]));
        let three = |values: &[f64]| [values[3 * pose], values[3 * pose + 1], values[3 * pose + 2]].into();
        // The tip wrench that varies is the last one.
        if let Some(wrench) = command.loads.wrenches.last_mut() {
            if let Some(force) = force {
                wrench.force = three(force);
            }
            if let Some(moment) = moment {
                wrench.moment = three(moment);
            }
        }
        command
    };
    let problem = py.detach(|| {
        let check = |pose| command(pose).check(design, bundle, stretch).err().map(|own| (pose, own));
        (0..poses).find_map(check)
    });
    if let Some((pose, problem)) = problem {
        return Err(errors::command(py, format!("pose {pose}: {problem}")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|error| PyRuntimeError::new_err(format!("threads cannot be started: {error}")))?;
    let mut rows: Vec<&mut [f64]> = out.as_slice_mut()?.chunks_mut(width).collect();
    let solver = BundleSolver::new(bundle).with_stretch(stretch).with_loop_tolerance(LOOP_TOLERANCE);
    watched(py, poses, progress.as_ref(), |done, cancelled| {
        let _ = pool.install(|| {
            solve(&solver, warm, &mut rows, command, |_, row, solver, found| {
                write(row, solver, found, jacobian);
                done.fetch_add(1, Ordering::Relaxed);
                if cancelled.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
        });
    })
}
