//! Solving one chunk: runs of successive rows that share a robot go side by side.

use crate::axis::Variable;
use crate::bundle;
use crate::chunking::Chunking;
use crate::design::DesignKeys;
use crate::table::{Chunk, Verdict};
use crate::task::{Inputs, RobotSubject, STATE, Subject, Task};
use cppr::analysis::{Place, Utilisation};
use cppr::many::{March, Solved, Start};
use cppr::solve::Solver;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Solves a chunk; `None` where `stop` was set meanwhile. What comes out depends on the task and the chunk only.
pub(crate) fn solve_chunk(task: &Task, chunking: &Chunking, number: u64, stop: &AtomicBool) -> Option<Chunk> {
    match &task.subject {
        Subject::Robot(own) => solve_robot(task, own, chunking, number, stop),
        Subject::Bundle(own) => bundle::solve_chunk(task, own, chunking, number, stop),
    }
}

/// A chunk whose columns of inputs are filled in.
pub(crate) fn begun(task: &Task, chunking: &Chunking, number: u64) -> Chunk {
    let range = chunking.rows_of(number);
    // At most a few thousand.
    #[allow(clippy::cast_possible_truncation)]
    let rows = (range.end - range.start) as usize;
    let (axes, width) = (task.axes.len(), task.columns().len());
    let mut chunk = Chunk { number, first_row: range.start, rows, values: vec![f64::NAN; rows * width] };
    let mut inputs = Inputs::new(task, chunking);
    let mut own = vec![0.0; axes];
    for row in 0..rows {
        inputs.of(range.start + row as u64, &mut own);
        own.iter().enumerate().for_each(|(column, value)| chunk.set(column, row, *value));
    }
    chunk
}

fn solve_robot(
    task: &Task,
    own: &RobotSubject,
    chunking: &Chunking,
    number: u64,
    stop: &AtomicBool,
) -> Option<Chunk> {
    let mut chunk = begun(task, chunking, number);
    let (axes, inputs) = (task.axes.len(), Inputs::new(task, chunking));
    let values: Vec<f64> =
        (0..chunk.rows * axes).map(|place| chunk.column(place % axes)[place / axes]).collect();
    let of = |row: usize| &values[row * axes..(row + 1) * axes];
    let is_design = |axis: usize| matches!(task.axes[axis].variable, Variable::Design(_));
    let design = |row: usize| (0..axes).filter(|axis| is_design(*axis)).map(move |axis| of(row)[axis]);
    let same_robot = |a: usize, b: usize| design(a).map(f64::to_bits).eq(design(b).map(f64::to_bits));
    let keys = task.varies_design().then(|| DesignKeys::new(&task.robot_text, &task.design_keys()).ok());
    let mut keys = keys.flatten();
    // A task that was checked has settings that make sense.
    let mut march = March::new(Solver::with_settings(&own.robot, own.settings).ok()?);
    for run in inputs.path(number).chunk_by(|a, b| same_robot(*a, *b)) {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let built = keys.as_mut().map(|keys| keys.robot(&design(run[0]).collect::<Vec<_>>()));
        let builds = built.is_none_or(|b| b.is_ok_and(|robot| march.solver().set_robot(&robot).is_ok()));
        if !builds {
            for row in run {
                chunk.set(axes, *row, f64::from(Verdict::InvalidDesign.code()));
            }
            continue;
        }
        let flow = march.run(
            &own.base,
            Start::Neighbour,
            run.len(),
            |pose, command| {
                for (axis, value) in task.axes.iter().zip(of(run[pose])) {
                    axis.variable.put(command, *value);
                }
            },
            |pose, solved| {
                let mut column = axes;
                write(task, solved.ok(), |value| {
                    chunk.set(column, run[pose], value);
                    column += 1;
                });
                if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        if flow.is_break() {
            return None;
        }
    }
    Some(chunk)
}

/// Writes the verdict of a row and, where there is an equilibrium, its numbers. Without a solved pose the command cannot be
/// asked of the robot.
fn write(task: &Task, solved: Option<Solved>, mut put: impl FnMut(f64)) {
    let verdict = solved.as_ref().map_or(Verdict::InvalidCommand, |s| s.equilibrium.status().into());
    put(f64::from(verdict.code()));
    let Some(mut solved) = solved else { return };
    let Solved { equilibrium, tip, .. } = solved;
    if !verdict.is_equilibrium() {
        return;
    }
    tip.centre.iter().for_each(|v| put(*v));
    quaternion(&tip.rotation).into_iter().for_each(&mut put);
    // Between the tip and +X, by both its legs: exact near 0 and π alike.
    let tangent = tip.tangent();
    put(tangent.y.hypot(tangent.z).atan2(tangent.x));
    for actuator in equilibrium.actuators() {
        for quantity in STATE {
            put(actuator.get(quantity));
        }
    }
    put(equilibrium.elastic_energy());
    if task.margin {
        put(solved.margin().unwrap_or(f64::NAN));
    }
    if let Some(teeth) = task.limits {
        limits(&solved.utilisation(teeth), &mut put);
    }
    put(equilibrium.statistics().iterations as f64);
}

/// Utilisations, each with its place.
pub(crate) fn limits(used: &Utilisation, put: &mut impl FnMut(f64)) {
    for (value, spot) in [used.strain, used.closure, used.torsion].into_iter().zip(used.places) {
        let notch = match spot.map(|spot| spot.place) {
            Some(Place::Notch(number)) => f64::from(number),
            _ => f64::NAN,
        };
        put(value.unwrap_or(f64::NAN));
        put(spot.map_or(f64::NAN, |spot| spot.tube as f64));
        put(notch);
        put(spot.map_or(f64::NAN, |spot| spot.abscissa));
    }
}

/// w, x, y, z of a rotation, w ≥ 0.
pub(crate) fn quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w, sign * q.i, sign * q.j, sign * q.k]
}
