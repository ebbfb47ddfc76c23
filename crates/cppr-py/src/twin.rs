//! What a program in Rust would do, timed inside this process: the yardstick of `bench/overhead.py`.

use crate::command::settings;
use crate::robot::Robot;
use cppr::many::Start;
use cppr::solve::{Command, Drive, Solver};
use cppr_sweep::{Poses, solve_many};
use pyo3::prelude::*;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

/// Seconds that solving for each pull of tube 2 in turn and reading the tip takes.
#[pyfunction]
pub fn time_solves(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    pulls: Vec<f64>,
    options: Option<Bound<'_, PyAny>>,
) -> PyResult<f64> {
    let (settings, _) = settings(options.as_ref())?;
    let shared = &robot.shared;
    Ok(py.detach(|| {
        shared.with(|solver| {
            if solver.set_settings(settings).is_err() {
                return f64::NAN;
            }
            let start = Instant::now();
            for pull in pulls {
                let mut command = Command::held(solver.robot());
                command.actuators[0].push_pull = Drive::Motion(pull);
                if let Ok(found) = solver.solve(&command) {
                    black_box(solver.tip(&found));
                }
            }
            start.elapsed().as_secs_f64()
        })
    }))
}

/// Seconds that solving for all pulls of tube 2 on `threads` threads takes, tip poses and actuators kept.
#[pyfunction]
pub fn time_many(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    pulls: Vec<f64>,
    options: Option<Bound<'_, PyAny>>,
    threads: usize,
) -> PyResult<f64> {
    let (settings, _) = settings(options.as_ref())?;
    let shared = &robot.shared;
    let robot = &shared.robot;
    Ok(py.detach(|| {
        let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { return f64::NAN };
        let Ok(solver) = Solver::with_settings(robot, settings) else { return f64::NAN };
        let start = Instant::now();
        let mut kept = vec![None; pulls.len()];
        let flow = pool.install(|| {
            solve_many(
                &Poses { solver: &solver, base: &Command::held(robot), start: Start::Rest },
                &shared.many,
                &mut kept,
                |pose, command| command.actuators[0].push_pull = Drive::Motion(pulls[pose]),
                |_, kept, solved| {
                    *kept = solved
                        .ok()
                        .map(|s| (s.equilibrium.status(), s.tip, s.equilibrium.actuators().to_vec()));
                    ControlFlow::<()>::Continue(())
                },
            )
        });
        let _ = black_box((kept, flow));
        start.elapsed().as_secs_f64()
    }))
}
