//! Many poses in one call: detached from the interpreter, on all cores, interruptible.
//!
//! Every pose is solved from rest, so that its answer depends neither on its neighbours, save for rounding, nor on the number
//! of threads.

use crate::command::{Asked, KEYWORDS, suspicious};
use crate::errors;
use crate::robot::{Robot, Shared};
use crate::watch::{stoppable, watched};
use cppr::many::{Solved, Start};
use cppr::solve::{Command, CommandProblem, Draft, Input, Reason, Solver, Status};
use cppr::statics::Wrench;
use cppr_sweep::{ONE_BLOCK, Poses};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What is written of every pose beyond the cheap numbers.
#[derive(Clone, Copy)]
pub struct Extras {
    jacobian: bool,
    margin: bool,
    sections: usize,
}

/// Everything that a pose needs; shared by all threads.
struct Job<'a> {
    shared: &'a Shared,
    base: &'a Command,
    solver: &'a Solver,
    columns: Vec<(Input, &'a [f64])>,
    force: Option<&'a [f64]>,
    moment: Option<&'a [f64]>,
    extras: Extras,
    start: Start,
}

impl<'a> Job<'a> {
    /// With its columns.
    fn new(
        py: Python<'_>,
        mut job: Self,
        columns: &'a [(usize, i64, PyReadonlyArray1<'_, f64>)],
        poses: usize,
    ) -> PyResult<Self> {
        let mut draft = Draft::of(job.base.clone());
        for (means, tube, values) in columns {
            let quantity = KEYWORDS[*means % 4];
            let values = values.as_slice()?;
            let input = quantity.of_tube(usize::try_from(*tube).unwrap_or(usize::MAX));
            let refused = |problem| errors::command(py, format!("{}: {problem}", quantity.keyword));
            draft.set(input, 0.0).map_err(refused)?;
            job.columns.push((input, values));
        }
        let vectors = job.force.iter().chain(&job.moment).map(|v| v.len() / 3);
        if job.columns.iter().map(|c| c.1.len()).chain(vectors).any(|n| n != poses) {
            return Err(PyValueError::new_err("the arrays of the poses differ in length"));
        }
        Ok(job)
    }

    /// Puts the numbers of a pose into a copy of the base command.
    fn set(&self, command: &mut Command, pose: usize) {
        for (input, values) in &self.columns {
            // The draft of the first pose has taken all columns.
            if let Some(actuator) = command.actuator_mut(input.tube) {
                *actuator.drive_mut(input.freedom) = input.prescribed(values[pose]);
            }
        }
        let three = |values: &[f64]| [values[3 * pose], values[3 * pose + 1], values[3 * pose + 2]].into();
        // The tip wrench that varies is the last one.
        if let Some(wrench) = command.loads.wrenches.last_mut() {
            if let Some(force) = self.force {
                wrench.force = three(force);
            }
            if let Some(moment) = self.moment {
                wrench.moment = three(moment);
            }
        }
    }

    fn check(&self, poses: usize) -> Option<(usize, CommandProblem)> {
        let mut command = self.base.clone();
        (0..poses).find_map(|pose| {
            self.set(&mut command, pose);
            self.solver.check(&command).err().map(|problem| (pose, problem))
        })
    }

    /// One row: status, iterations, energy, tip position and rotation, actuators; then the extras.
    fn write(&self, row: &mut [f64], mut solved: Solved<'_>) {
        let Solved { equilibrium: found, tip, .. } = solved;
        row[0] = match found.status() {
            Status::Converged => 0.0,
            Status::Unstable => 1.0,
            Status::NotConverged(Reason::Edges) => 3.0,
            Status::NotConverged(_) => 2.0,
        };
        row[1] = found.statistics().iterations as f64;
        if !found.status().is_equilibrium() {
            return;
        }
        let head = [found.elastic_energy()].into_iter().chain(tip.centre.iter().copied());
        let head = head.chain((0..9).map(|i| tip.rotation[(i / 3, i % 3)]));
        let states = || found.actuators().iter();
        let mut values = head
            .chain(states().map(|a| a.motion))
            .chain(states().map(|a| a.rotation))
            .chain(states().map(|a| a.tension))
            .chain(states().map(|a| a.torque));
        let mut cells = row[2..].iter_mut();
        // `zip` would lose the cell that ends it.
        for value in values.by_ref() {
            if let Some(cell) = cells.next() {
                *cell = value;
            }
        }
        if self.extras.jacobian {
            let inputs = 2 * found.actuators().len();
            let own = solved.solver.sensitivity(found).ok();
            for i in 0..6_usize * inputs + 36 {
                if let (Some(cell), Some(s)) = (cells.next(), &own) {
                    let j = i.checked_sub(6 * inputs);
                    *cell = j.map_or_else(
                        || s.tip_jacobian[(i / inputs, i % inputs)],
                        |j| s.compliance[(j / 6, j % 6)],
                    );
                }
            }
        }
        if self.extras.margin
            && let (Some(cell), Some(own)) = (cells.next(), solved.margin())
        {
            *cell = own;
        }
        if self.extras.sections > 0 {
            let shape = solved.solver.shape(found, self.extras.sections);
            for (cell, value) in cells.zip(shape.sections.iter().flat_map(|s| s.centre.iter())) {
                *cell = *value;
            }
        }
    }

    fn run(&self, out: &mut [f64], width: usize, done: &AtomicUsize, cancelled: &AtomicBool) {
        let mut rows: Vec<&mut [f64]> = out.chunks_mut(width).collect();
        let poses = Poses { solver: self.solver, base: self.base, start: self.start };
        let _ = cppr_sweep::solve_many(
            &poses,
            &self.shared.many,
            &mut rows,
            |pose, command| self.set(command, pose),
            |_, row, solved| {
                row.fill(f64::NAN);
                row[0] = 2.0;
                // All commands have been checked.
                if let Ok(solved) = solved {
                    self.write(row, solved);
                }
                done.fetch_add(1, Ordering::Relaxed);
                if cancelled.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
    }
}

/// Numbers per pose.
fn width(followers: usize, extras: Extras) -> usize {
    let jacobian = if extras.jacobian { 12 * followers + 36 } else { 0 };
    15 + 4 * followers + jacobian + usize::from(extras.margin) + 3 * extras.sections
}

/// Fills `out`, one row per pose. `columns` holds (means, tube, values).
#[pyfunction]
#[pyo3(signature = (robot, columns, tip_force, tip_moment, loads, settings, out, jacobian, stability, sections, threads, progress, first, warm))]
pub fn solve_many(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    columns: Vec<(usize, i64, PyReadonlyArray1<'_, f64>)>,
    tip_force: Option<PyReadonlyArray2<'_, f64>>,
    tip_moment: Option<PyReadonlyArray2<'_, f64>>,
    loads: Option<Bound<'_, PyAny>>,
    settings: Option<Bound<'_, PyAny>>,
    mut out: PyReadwriteArray2<'_, f64>,
    jacobian: bool,
    stability: bool,
    sections: usize,
    threads: usize,
    progress: Option<Py<PyAny>>,
    first: usize,
    warm: bool,
) -> PyResult<()> {
    let core = &robot.shared.robot;
    let asked = Asked { loads: loads.as_ref(), settings: settings.as_ref(), ..Asked::default() };
    let (mut base, settings) = asked.read(core)?;
    if tip_force.is_some() || tip_moment.is_some() {
        base.loads.wrenches.push(Wrench::tip_force(cppr::Vector3::zeros()));
    }
    let solver = Solver::with_settings(core, settings).map_err(|problem| errors::command(py, problem))?;
    let extras = Extras { jacobian, margin: stability, sections };
    let (poses, width) = (out.as_array().nrows(), width(core.follower_count(), extras));
    if out.as_array().ncols() != width {
        return Err(PyValueError::new_err("the arrays of the poses differ in length"));
    }
    let job = Job::new(
        py,
        Job {
            shared: &robot.shared,
            base: &base,
            solver: &solver,
            columns: Vec::new(),
            force: tip_force.as_ref().map(|a| a.as_slice()).transpose()?,
            moment: tip_moment.as_ref().map(|a| a.as_slice()).transpose()?,
            extras,
            start: if warm { Start::Neighbour } else { Start::Rest },
        },
        &columns,
        poses,
    )?;
    for (input, values) in &job.columns {
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if let Some(text) = suspicious(input.quantity(), core, largest) {
            errors::warn(py, "UnitWarning", &text)?;
        }
    }
    if let Some((pose, problem)) = py.detach(|| job.check(poses)) {
        return Err(errors::command(py, format!("pose {}: {problem}", first + pose)));
    }
    // One block needs no threads, and no block more than one of them.
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads > 0 { threads } else { cores() }.min(poses.div_ceil(ONE_BLOCK));
    let pool = (poses > ONE_BLOCK).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
    let pool = pool.transpose();
    let pool =
        pool.map_err(|error| PyRuntimeError::new_err(format!("threads cannot be started: {error}")))?;
    let rows = out.as_slice_mut()?;
    watched(py, poses, progress.as_ref(), |done, cancelled| match &pool {
        Some(pool) => pool.install(|| job.run(rows, width, done, cancelled)),
        None => job.run(rows, width, done, cancelled),
    })
}

/// How many times as many modes some poses need whose tips are to be within `accuracy` times the length, the greatest error of a tip (m) that is
/// left, and of how many poses it is known.
#[pyfunction]
#[pyo3(signature = (robot, columns, tip_force, tip_moment, loads, settings, poses, accuracy))]
pub fn modes_for(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    columns: Vec<(usize, i64, PyReadonlyArray1<'_, f64>)>,
    tip_force: Option<PyReadonlyArray2<'_, f64>>,
    tip_moment: Option<PyReadonlyArray2<'_, f64>>,
    loads: Option<Bound<'_, PyAny>>,
    settings: Option<Bound<'_, PyAny>>,
    poses: usize,
    accuracy: f64,
) -> PyResult<(usize, Option<f64>, usize)> {
    let core = &robot.shared.robot;
    let asked = Asked { loads: loads.as_ref(), settings: settings.as_ref(), ..Asked::default() };
    let (mut base, settings) = asked.read(core)?;
    if tip_force.is_some() || tip_moment.is_some() {
        base.loads.wrenches.push(Wrench::tip_force(cppr::Vector3::zeros()));
    }
    let mut solver = Solver::with_settings(core, settings).map_err(|problem| errors::command(py, problem))?;
    let job = Job {
        shared: &robot.shared,
        base: &base,
        solver: &solver.clone(),
        columns: Vec::new(),
        force: tip_force.as_ref().map(|a| a.as_slice()).transpose()?,
        moment: tip_moment.as_ref().map(|a| a.as_slice()).transpose()?,
        extras: Extras { jacobian: false, margin: false, sections: 0 },
        start: Start::Rest,
    };
    let job = Job::new(py, job, &columns, poses)?;
    let command = |pose: usize| {
        let mut command = base.clone();
        job.set(&mut command, pose);
        command
    };
    let commands: Vec<Command> = (0..poses).map(command).collect();
    let found = stoppable(py, |stop| {
        solver.stop_by(Some(Arc::clone(stop)));
        solver.settings_for(&commands, if settings.modes_are_chosen() { f64::INFINITY } else { accuracy })
    })?;
    let factor = found.settings.resolution.nodes / settings.resolution.nodes;
    Ok((factor, found.error, found.known))
}
