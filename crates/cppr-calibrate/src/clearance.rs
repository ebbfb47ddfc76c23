//! What the model of tubes with gaps between them says to measurements, and how that changes with the parameters.

use crate::data::{Line, Measurement};
use crate::fit::FitProblem;
use crate::observe::{Found, Observer, RobotObserver, no_derivative, numbers, solver};
use crate::parameter::Parameter;
use cppr::Vector3;
use cppr::clearance::{Clearance, ClearanceEquilibrium};
use cppr::design::Robot;
use cppr::solve::{Equilibrium, Freedom, Settings, Solver};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Elements along a robot: half as many as a single equilibrium takes by default, in a third of its time.
const ELEMENTS: usize = 60;

/// A robot at some values of the parameters, and the gaps between its tubes.
pub(crate) struct Loose {
    pub robot: Robot,
    pub gaps: Vec<f64>,
}

/// A robot with gaps and, for derivatives, the same with every parameter changed.
pub(crate) struct ClearanceModel {
    pub own: Loose,
    /// For every parameter, another state and how far (in what the search moves) it lies from the robot's own.
    pub moved: Vec<(Loose, f64)>,
}

impl ClearanceModel {
    pub(crate) fn observer<'a>(
        &'a self,
        list: &'a [Parameter],
        settings: Settings,
        stop: Option<&Arc<AtomicBool>>,
    ) -> ClearanceObserver<'a> {
        let moved = self.moved.iter().map(|(own, by)| (solver(&own.robot, settings), own, *by));
        let tight = RobotObserver::new(&self.own.robot, list, &[], settings, stop);
        ClearanceObserver { tight, own: &self.own, list, moved: moved.collect() }
    }
}

pub(crate) struct ClearanceObserver<'a> {
    /// Finds the equilibria without gaps from which those with gaps begin.
    tight: RobotObserver<'a>,
    own: &'a Loose,
    list: &'a [Parameter],
    moved: Vec<(Solver, &'a Loose, f64)>,
}

impl Observer for ClearanceObserver<'_> {
    fn solve(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Found, FitProblem> {
        self.tight.solve(m, start)
    }

    fn read(&mut self, pose: &[Measurement], found: &Found) -> Result<Vec<f64>, FitProblem> {
        let Found::Robot(found) = found else { return Ok(Vec::new()) };
        read(pose, &mut self.tight.solver, found, self.own)
    }

    fn slopes(
        &mut self,
        pose: &[Measurement],
        found: &Found,
        outputs: &[f64],
    ) -> Result<Vec<Vec<f64>>, FitProblem> {
        let Found::Robot(found) = found else { return Ok(Vec::new()) };
        let one = |((solver, own, by), parameter): (&mut (Solver, &Loose, f64), &Parameter)| {
            let near =
                solver.solve(found.command()).ok().and_then(|near| read(pose, solver, &near, own).ok());
            let values = near.ok_or_else(|| no_derivative(&pose[0], *parameter))?;
            Ok(values.iter().zip(outputs).map(|(to, from)| (to - from) / *by).collect())
        };
        self.moved.iter_mut().zip(self.list).map(one).collect()
    }
}

/// All numbers of the measurements of one pose.
fn read(
    pose: &[Measurement],
    solver: &mut Solver,
    tight: &Equilibrium,
    own: &Loose,
) -> Result<Vec<f64>, FitProblem> {
    let row = pose[0].row;
    let clearance = Clearance { gaps: own.gaps.clone(), guide: None, elements: ELEMENTS };
    let found = solver
        .with_clearance(tight, &clearance)
        .map_err(|problem| FitProblem::Measurement(row, problem.to_string()))?
        .ok_or_else(|| FitProblem::NoEquilibrium(row, "no equilibrium with these gaps was found".into()))?;
    let one = |m: &Measurement| {
        if let Line::Tube(tube) = m.line {
            let why = format!(
                "points on the centroid line of tube {} cannot be compared with a robot that has gaps; leave it out",
                tube + 1
            );
            return Err(FitProblem::Measurement(m.row, why));
        }
        let [point, direction] = place(&found, m.at.unwrap_or(own.robot.length()));
        Ok(numbers(m, point, direction, |tube, freedom| {
            let own = &found.followers[tube - 1];
            if freedom == Freedom::PushPull { own.tension } else { own.torque }
        }))
    };
    Ok(pose.iter().map(one).collect::<Result<Vec<_>, _>>()?.concat())
}

/// Point (m) and direction of the leader's axis at a label (m).
fn place(found: &ClearanceEquilibrium, label: f64) -> [Vector3<f64>; 2] {
    let last = found.labels.len() - 1;
    let next = found.labels.partition_point(|own| *own < label).clamp(1, last);
    let [from, to] = [next - 1, next].map(|i| found.labels[i]);
    let share = ((label - from) / (to - from)).clamp(0.0, 1.0);
    let point = found.centres[next - 1].lerp(&found.centres[next], share);
    let [from, to] = [next - 1, next].map(|i| Vector3::from(found.frames[i].column(0)));
    [point, from.lerp(&to, share).normalize()]
}
