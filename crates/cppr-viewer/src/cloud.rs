//! Where the tip can go: poses spread evenly over ranges of the actuators (Halton's sequence), solved some at a time while the
//! page asks nothing else.

use crate::message;
use cppr::design::Robot;
use cppr::solve::{Actuator, Command, Drive, Equilibrium, Solver, Status};
use cppr_io::Scenario;
use serde::Deserialize;
use serde_json::json;

/// Tip positions over ranges of the actuators, the rest as in a scenario.
#[derive(Clone, Debug, Deserialize)]
pub struct Cloud {
    /// Loads and how to solve.
    pub scenario: Scenario,
    /// Which actuators are moved.
    pub ranges: Vec<Range>,
    /// Number of poses.
    pub count: u32,
}

/// Ranges of one follower's motions.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Range {
    /// Number of the tube.
    pub tube: usize,
    /// From and to.
    pub pull_mm: [f64; 2],
    /// From and to.
    pub rotate_deg: [f64; 2],
}

/// Poses of a cloud between two looks at what else is to be done.
const CHUNK: u32 = 24;
/// Most poses of a cloud.
const MOST_POSES: u32 = 20_000;

/// Poses that are still to be solved.
pub(crate) struct Remaining {
    command: Command,
    solver: Solver,
    ranges: Vec<Range>,
    next: u32,
    count: u32,
    last: Equilibrium,
}

impl Remaining {
    /// All poses of a cloud; a sentence where it asks what the robot has not.
    pub fn new(cloud: &Cloud, robot: &Robot) -> Result<Self, String> {
        let mut command = cloud.scenario.command(robot).map_err(|problems| problems.join("\n"))?;
        let finite = |range: &Range| range.pull_mm.iter().chain(&range.rotate_deg).all(|v| v.is_finite());
        let known = |range: &Range| command.actuator(range.tube).is_some();
        if cloud.ranges.is_empty() || !cloud.ranges.iter().all(|r| finite(r) && known(r)) {
            return Err("a workspace needs the ranges of followers of this robot".into());
        }
        for range in &cloud.ranges {
            if let Some(actuator) = command.actuator_mut(range.tube) {
                *actuator = Actuator::HELD;
            }
        }
        let mut solver =
            Solver::with_settings(robot, cloud.scenario.settings()).map_err(|problem| problem.to_string())?;
        let last = solver.rest();
        Ok(Self {
            command,
            solver,
            ranges: cloud.ranges.clone(),
            next: 0,
            count: cloud.count.min(MOST_POSES),
            last,
        })
    }

    /// Is every pose solved?
    pub fn is_empty(&self) -> bool {
        self.next >= self.count
    }

    /// Solves some poses: the message with their tips (mm).
    pub fn some(&mut self) -> Vec<u8> {
        let mut floats = Vec::new();
        let end = (self.next + CHUNK).min(self.count);
        for index in self.next..end {
            for (i, range) in self.ranges.iter().enumerate() {
                let part = |bounds: [f64; 2], base: usize| {
                    bounds[0] + (bounds[1] - bounds[0]) * halton(index + 1, PRIMES[base % PRIMES.len()])
                };
                let moved = Actuator {
                    push_pull: Drive::Motion(part(range.pull_mm, 2 * i) * 1e-3),
                    rotation: Drive::Motion(part(range.rotate_deg, 2 * i + 1).to_radians()),
                };
                if let Some(actuator) = self.command.actuator_mut(range.tube) {
                    *actuator = moved;
                }
            }
            let done = self.solver.solve_into(&self.command, &mut self.last);
            if done.is_err() || self.last.status() != Status::Converged {
                self.last = self.solver.rest();
                continue;
            }
            let tip = self.solver.tip(&self.last).centre;
            #[allow(clippy::cast_possible_truncation, reason = "for drawing")]
            floats.extend(tip.iter().map(|v| (v * 1e3) as f32));
        }
        self.next = end;
        let head = json!({"kind": "cloud", "done": self.is_empty(), "solved": end, "count": self.count});
        message::encode(&head, &floats)
    }
}

/// Bases of the Halton sequence.
const PRIMES: [u32; 10] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29];

/// The digits of `index` mirrored at the point: evenly spread over (0, 1) whatever the count.
fn halton(mut index: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value
}
