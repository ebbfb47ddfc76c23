//! Solving one chunk.

use crate::axis::Variable;
use crate::chunking::Chunking;
use crate::design::DesignKeys;
use crate::table::{Chunk, Verdict};
use crate::task::{Inputs, Task};
use cppr::analysis::shape::tip_pose;
use cppr::analysis::stability::stability;
use cppr::analysis::{SectionLimit, section_limits};
use cppr::design::Robot;
use cppr::solve::{Command, CommandProblem, Equilibrium, Status, Workspace, solve, solve_into};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::sync::atomic::{AtomicBool, Ordering};

/// A solver with its memory.
struct Solver<'a> {
    task: &'a Task,
    workspace: Workspace,
    command: Command,
    /// The last stable equilibrium, where the next pose starts; none where it starts at rest.
    last: Option<Equilibrium>,
    /// The robot of the last design values, where the design varies.
    design: Option<Design>,
}

struct Design {
    keys: DesignKeys,
    values: Vec<f64>,
    robot: Option<Robot>,
}

/// Solves a chunk; `None` where `stop` was set meanwhile. What comes out depends on the task and the chunk only.
pub(crate) fn solve_chunk(task: &Task, chunking: &Chunking, number: u64, stop: &AtomicBool) -> Option<Chunk> {
    let range = chunking.rows_of(number);
    // At most a few thousand.
    #[allow(clippy::cast_possible_truncation)]
    let rows = (range.end - range.start) as usize;
    let width = task.columns().len();
    let mut chunk = Chunk { number, first_row: range.start, rows, values: vec![f64::NAN; rows * width] };
    let design = task.varies_design().then(|| DesignKeys::new(&task.robot_text, &task.design_keys()).ok());
    let mut solver = Solver {
        task,
        workspace: Workspace::new(),
        command: task.base.clone(),
        last: None,
        design: design.flatten().map(|keys| Design { keys, values: Vec::new(), robot: None }),
    };
    let mut inputs = Inputs::new(task, chunking);
    let mut values = vec![0.0; task.axes.len()];
    for row in inputs.path(number) {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        inputs.of(range.start + row, &mut values);
        #[allow(clippy::cast_possible_truncation)]
        solver.pose(&values, &mut chunk, row as usize);
    }
    Some(chunk)
}

impl Solver<'_> {
    /// Solves one pose and writes its row.
    fn pose(&mut self, values: &[f64], chunk: &mut Chunk, row: usize) {
        for (column, value) in values.iter().enumerate() {
            chunk.set(column, row, *value);
        }
        let status = values.len();
        let verdict = if self.build(values) { self.equilibrium(values) } else { Verdict::InvalidDesign };
        chunk.set(status, row, f64::from(verdict.code()));
        let task = self.task;
        let robot = match &self.design {
            None => Some(&task.robot),
            Some(design) => design.robot.as_ref(),
        };
        let (Some(found), Some(robot)) = (&self.last, robot) else { return };
        let mut column = status;
        let mut put = |value: f64| {
            column += 1;
            chunk.set(column, row, value);
        };
        if !verdict.is_equilibrium() {
            return;
        }
        let (rotation, centre) = tip_pose(robot, &mut self.workspace, found);
        centre.iter().for_each(|v| put(*v));
        quaternion(&rotation).into_iter().for_each(&mut put);
        for actuator in &found.actuators {
            put(actuator.motion);
            put(actuator.rotation);
            put(actuator.tension);
            put(actuator.torque);
        }
        put(found.elastic_energy);
        if task.margin {
            put(stability(robot, &mut self.workspace, found).map_or(f64::NAN, |s| s.margin));
        }
        if let Some(teeth) = task.limits {
            let sections = section_limits(robot, &mut self.workspace, found, teeth);
            // NaN where nothing is judged.
            let greatest = |value: fn(&SectionLimit) -> Option<f64>| {
                sections.iter().filter_map(value).fold(f64::NAN, f64::max)
            };
            put(greatest(SectionLimit::strain_utilisation));
            put(greatest(|section| section.closure));
        }
        put(found.statistics.iterations as f64);
        if verdict != Verdict::Converged {
            // Neighbours are not to follow it.
            self.last = None;
        }
    }

    /// Makes the robot of a row; false where there is none.
    fn build(&mut self, values: &[f64]) -> bool {
        let Some(design) = &mut self.design else { return true };
        let own: Vec<f64> = self
            .task
            .axes
            .iter()
            .zip(values)
            .filter(|(axis, _)| matches!(axis.variable, Variable::Design(_)))
            .map(|(_, value)| *value)
            .collect();
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if !same(&own, &design.values) {
            design.robot = design.keys.robot(&own).ok();
            design.values = own;
            self.last = None;
        }
        design.robot.is_some()
    }

    /// Finds the equilibrium of a row from its neighbour, else from rest, and leaves it in `last`.
    fn equilibrium(&mut self, values: &[f64]) -> Verdict {
        let task = self.task;
        let robot = match &self.design {
            None => &task.robot,
            Some(Design { robot: Some(robot), .. }) => robot,
            Some(_) => return Verdict::InvalidDesign,
        };
        for (axis, value) in task.axes.iter().zip(values) {
            axis.variable.put(&mut self.command, *value);
        }
        let workspace = &mut self.workspace;
        if let Some(last) = &mut self.last {
            match solve_into(robot, workspace, &self.command, &task.settings, last) {
                Ok(()) if last.status == Status::Converged => return Verdict::Converged,
                Ok(()) if last.status == Status::Unstable => {}
                // Load stepping from rest has been tried.
                Ok(()) => return self.lost(),
                Err(problem) => return invalid(&problem),
            }
        }
        // Also where the neighbour's branch has turned unstable: the robot then is on another one.
        match solve(robot, workspace, &self.command, &task.settings) {
            Ok(found) if found.status.is_equilibrium() => {
                let verdict = found.status.into();
                self.last = Some(found);
                verdict
            }
            Ok(found) => {
                let warm = self.last.as_ref().map_or(found.status, |last| last.status);
                if !warm.is_equilibrium() {
                    self.last = None;
                }
                warm.into()
            }
            Err(problem) => invalid(&problem),
        }
    }

    /// There is no equilibrium; the next pose starts at rest.
    fn lost(&mut self) -> Verdict {
        self.last.take().map_or(Verdict::PathEnds, |last| last.status.into())
    }
}

/// The neighbour stays: it has not been touched.
fn invalid(_: &CommandProblem) -> Verdict {
    Verdict::InvalidCommand
}

/// w, x, y, z of a rotation, w ≥ 0.
fn quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w, sign * q.i, sign * q.j, sign * q.k]
}
