//! Long work detached from the interpreter, which Ctrl-C and other signals end.

use crate::errors;
use cppr::solve::{Equilibrium, Solver};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

/// How often signals are looked at and progress is told.
const PULSE: Duration = Duration::from_millis(50);

/// Runs work in a thread of its own, telling progress and looking at signals meanwhile. The work counts what is done, and ends
/// soon after the flag is set.
pub fn watched(
    py: Python<'_>,
    total: usize,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&AtomicUsize, &Arc<AtomicBool>) + Send,
) -> PyResult<()> {
    let (done, cancelled) = (AtomicUsize::new(0), Arc::new(AtomicBool::new(false)));
    let pulse = |py: Python<'_>| -> PyResult<()> {
        py.check_signals()?;
        if let Some(progress) = progress {
            progress.call1(py, (done.load(Ordering::Relaxed), total))?;
        }
        Ok(())
    };
    py.detach(|| {
        std::thread::scope(|scope| {
            let (finished, wait) = mpsc::channel::<()>();
            scope.spawn(|| {
                work(&done, &cancelled);
                drop(finished);
            });
            let mut failure = None;
            while let Err(mpsc::RecvTimeoutError::Timeout) = wait.recv_timeout(PULSE) {
                if failure.is_none()
                    && let Err(error) = Python::attach(pulse)
                {
                    cancelled.store(true, Ordering::Relaxed);
                    failure = Some(error);
                }
            }
            failure.map_or_else(|| Python::attach(pulse), Err)
        })
    })
}

/// Runs one long analysis from an equilibrium on, with a solver of its robot that ends where it is told to stop.
pub fn analysed<R: Send>(
    py: Python<'_>,
    found: &Equilibrium,
    work: impl FnOnce(&mut Solver) -> R + Send,
) -> PyResult<R> {
    let solver = Solver::with_settings(found.robot(), *found.settings());
    let mut solver = solver.map_err(|problem| errors::command(py, problem))?;
    stoppable(py, |stop| {
        solver.stop_by(Some(Arc::clone(stop)));
        work(&mut solver)
    })
}

/// Runs what returns soon after the flag is set.
pub fn stoppable<R: Send>(py: Python<'_>, work: impl FnOnce(&Arc<AtomicBool>) -> R + Send) -> PyResult<R> {
    let mut result = None;
    watched(py, 0, None, |_, stop| result = Some(work(stop)))?;
    result.ok_or_else(|| PyRuntimeError::new_err("the computation broke off: please report this"))
}
