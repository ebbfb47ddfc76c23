//! Solving one chunk of a sweep of a bundle: a robot with parts, joints, free tips or curved tubes.
//!
//! Rows are solved one after another, along the last axis each from its neighbour, and from rest where that gives no stable equilibrium; samples and
//! other designs are solved from rest.

use crate::axis::Variable;
use crate::chunking::Chunking;
use crate::design::DesignKeys;
use crate::solver::{begun, limits, quaternion};
use crate::table::{Chunk, Verdict};
use crate::task::{BundleSubject, Plan, SLIP, STATE, Task};
use cppr::analysis::{BundleAnalysis, Utilisation};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort, load_behind_plate};
use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::solve::Quantity;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a command cannot be asked of a bundle.
pub(crate) const BEHIND_THE_PLATE: &str = "a joint or a load would lie behind the plate";

/// Solves a chunk; `None` where `stop` was set meanwhile.
pub(crate) fn solve_chunk(
    task: &Task,
    own: &BundleSubject,
    chunking: &Chunking,
    number: u64,
    stop: &AtomicBool,
) -> Option<Chunk> {
    let mut chunk = begun(task, chunking, number);
    let axes = task.axes.len();
    let mut keys =
        DesignKeys::new(&task.robot_text, &task.design_keys()).ok().filter(|_| task.varies_design());
    let is_design = |axis: &usize| matches!(task.axes[*axis].variable, Variable::Design(_));
    let design = |chunk: &Chunk, row: usize| -> Vec<f64> {
        (0..axes).filter(is_design).map(|axis| chunk.column(axis)[row]).collect()
    };
    let mut row = 0;
    while row < chunk.rows {
        let values = design(&chunk, row);
        let end = (row..chunk.rows).find(|other| design(&chunk, *other) != values).unwrap_or(chunk.rows);
        match keys.as_mut().map(|keys| keys.bundle(&values)) {
            None => {
                let analysis = analysis(own, &own.bundle, &own.design);
                solve_rows(task, own, analysis, task.friction, &mut chunk, row..end, stop)?;
            }
            Some(Ok((bundle, design, friction))) => {
                let analysis = analysis(own, &bundle, &design);
                solve_rows(task, own, analysis, task.varied(friction), &mut chunk, row..end, stop)?;
            }
            Some(Err(_)) => {
                for refused in row..end {
                    chunk.set(axes, refused, f64::from(Verdict::InvalidDesign.code()));
                }
            }
        }
        row = end;
    }
    Some(chunk)
}

fn analysis<'a>(own: &BundleSubject, bundle: &'a Bundle, design: &'a BundleDesign) -> BundleAnalysis<'a> {
    BundleAnalysis::new(BundleSolver::new(bundle).with_stretch(own.stretch), design)
}

/// Solves rows of one robot; `None` where `stop` was set.
fn solve_rows(
    task: &Task,
    own: &BundleSubject,
    mut analysis: BundleAnalysis<'_>,
    friction: Option<Friction>,
    chunk: &mut Chunk,
    rows: Range<usize>,
    stop: &AtomicBool,
) -> Option<()> {
    let run = match task.plan {
        Plan::Grid => task.axes.last().map_or(1, |axis| axis.values.count()),
        _ => 1,
    };
    let mut before: Option<BundleEquilibrium> = None;
    for row in rows {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        if (chunk.first_row + row as u64) % run.max(1) == 0 {
            before = None;
        }
        let mut column = task.axes.len();
        let command = command(task, own, chunk, row);
        let mut put = |value: f64| {
            chunk.set(column, row, value);
            column += 1;
        };
        if analysis.solver.bundle().joint_behind_plate(&command.drives).is_some() {
            put(f64::from(Verdict::InvalidCommand.code()));
            continue;
        }
        let solver = &mut analysis.solver;
        let near = before.take().map(|start| solver.solve_from(&command, &start));
        let found = match near.filter(|found| found.converged && found.stable) {
            Some(found) => found,
            None => solver.solve(&command),
        };
        write(task, &analysis, friction, (&command, &found), &mut put);
        before = found.converged.then_some(found);
    }
    Some(())
}

/// What is asked in a row.
pub(crate) fn command(task: &Task, own: &BundleSubject, chunk: &Chunk, row: usize) -> BundleCommand {
    let mut command = own.base.clone();
    for (axis, varies) in task.axes.iter().enumerate() {
        varies.variable.put_in_bundle(&mut command, chunk.column(axis)[row]);
    }
    command
}

/// Motions and efforts of every tube.
fn actuators(efforts: &[TubeEffort], put: &mut impl FnMut(f64)) {
    for own in efforts {
        for quantity in STATE {
            put(match quantity {
                Quantity::PULL => own.label,
                Quantity::ROTATION => own.rotation,
                Quantity::TENSION => own.force,
                _ => own.torque,
            });
        }
    }
}

/// Writes the verdict of a row and, where there is an equilibrium, its numbers.
fn write(
    task: &Task,
    analysis: &BundleAnalysis<'_>,
    friction: Option<Friction>,
    (command, found): (&BundleCommand, &BundleEquilibrium),
    put: &mut impl FnMut(f64),
) {
    let verdict = match found.status().into() {
        Verdict::Converged | Verdict::Unstable if load_behind_plate(command, found).is_some() => {
            Verdict::InvalidCommand
        }
        other => other,
    };
    put(f64::from(verdict.code()));
    if !verdict.is_equilibrium() {
        return;
    }
    found.tip.iter().for_each(|v| put(*v));
    quaternion(&found.frame).into_iter().for_each(&mut *put);
    let tangent = found.frame.column(0);
    put(tangent.y.hypot(tangent.z).atan2(tangent.x));
    put(found.length);
    actuators(&found.efforts, put);
    if let Some(teeth) = task.limits {
        limits(&Utilisation::of(&analysis.section_limits(found, teeth)), put);
    }
    if let Some(friction) = friction {
        match analysis.solver.full_slip(found, &friction) {
            Some(sides) => {
                for side in sides {
                    side.equilibrium.tip.iter().for_each(|v| put(*v));
                    actuators(&side.efforts, put);
                }
            }
            None => (0..SLIP.len() * (3 + STATE.len() * found.efforts.len())).for_each(|_| put(f64::NAN)),
        }
    }
    put(found.error[0]);
    put(found.iterations as f64);
}
