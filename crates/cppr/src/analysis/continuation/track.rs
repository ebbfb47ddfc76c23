//! Predictor and corrector with step control.

use super::bordered::{Bordered, Node, PathState, Stage, size_of, weigh};
use super::events::{Between, SEPARATE, Test};
use super::plate::Room;
use super::{End, PathPoint, PointKind, Tracing};
use crate::dense::dot;
use crate::solve::Equilibrium;
use crate::solve::edges::stands;
use crate::solve::input::tube_of;
use std::sync::Arc;

/// What has been traced of one branch.
pub(super) struct Trail {
    pub points: Vec<PathPoint>,
    /// Branch points: index among the points, node, directions that leave.
    pub crossings: Vec<(usize, Node, Vec<Vec<f64>>)>,
}

impl From<Vec<PathPoint>> for Trail {
    fn from(points: Vec<PathPoint>) -> Self {
        Self { points, crossings: Vec::new() }
    }
}

pub(super) struct Tracer<'a> {
    pub solver: Bordered<'a>,
    pub tracing: &'a Tracing,
    /// Do all loads have a potential, so that inertia and determinant tell the same?
    pub conservative: bool,
    /// Steps that may still be taken.
    left: usize,
}

/// Least cosine of the angle between the tangents of neighbours: 20°.
const STRAIGHT: f64 = 0.94;

impl<'a> Tracer<'a> {
    pub fn new(solver: Bordered<'a>, tracing: &'a Tracing) -> Self {
        let conservative = solver.family.is_conservative();
        Self { solver, tracing, conservative, left: tracing.steps }
    }

    /// The node of an equilibrium of the first command, its tangent towards growing λ.
    pub fn begin(&mut self, start: &Equilibrium) -> Option<Node> {
        if !start.status.is_equilibrium() {
            return None;
        }
        let (stage, place) = Self::standing_of(start, 0.0);
        let mut row = vec![0.0; size_of(start)];
        let last = row.len() - 1;
        row[last] = 1.0;
        self.settled(&stage, place, &row)
    }

    /// Stage and place of an equilibrium that the solver found.
    pub fn standing_of(found: &Equilibrium, fraction: f64) -> (Stage, PathState) {
        let standing = (0..found.drives.len()).fold(0, |bits, f| bits | u64::from(stands(found, f)) << f);
        let stage = Stage { layout: Arc::clone(&found.layout), standing };
        (stage, PathState { point: found.point.clone(), fraction })
    }

    /// Corrects a place across `row` and makes a node of it.
    pub fn settled(&mut self, stage: &Stage, mut place: PathState, row: &[f64]) -> Option<Node> {
        self.solver.correct(stage, &mut place, row, self.solver.settings.tolerance)?;
        self.solver.node(stage, &place, row)
    }

    /// The node at a distance from another one, solved as exactly as rounding allows.
    pub fn at(&mut self, here: &Node, distance: f64) -> Option<Node> {
        let row = weigh(&here.stage, &here.tangent);
        let mut place = self.solver.predicted(&here.stage, &here.place, &here.tangent, distance);
        self.solver.correct(&here.stage, &mut place, &row, 1e-2 * self.solver.settings.tolerance)?;
        self.solver.node(&here.stage, &place, &row)
    }

    /// One step of the given length, or up to the end of the path if that is nearer. The number of corrections with it.
    fn step(&mut self, here: &Node, distance: f64) -> Option<(Node, usize)> {
        let (stage, tolerance) = (&here.stage, self.solver.settings.tolerance);
        let row = weigh(stage, &here.tangent);
        let mut place = self.solver.predicted(stage, &here.place, &here.tangent, distance);
        let mut turns = None;
        if beyond(place.fraction).is_none() {
            turns = Some(self.solver.correct(stage, &mut place, &row, tolerance)?);
        }
        if let Some(bound) = beyond(place.fraction) {
            let share = (bound - here.place.fraction) / (place.fraction - here.place.fraction);
            place = self.solver.predicted(stage, &here.place, &here.tangent, share * distance);
            place.fraction = bound;
            let mut across = vec![0.0; row.len()];
            across[row.len() - 1] = 1.0;
            turns = Some(self.solver.correct(stage, &mut place, &across, tolerance)?);
        }
        let next = self.solver.node(stage, &place, &row)?;
        let straight = dot(&row, &next.tangent) >= STRAIGHT && self.in_place(&next);
        straight.then_some((next, turns.unwrap_or(0)))
    }

    /// Follows a branch from its last node to its end.
    pub fn follow(&mut self, first: &Node, trail: &mut Trail) -> End {
        let (longest, shortest) = (self.tracing.step, self.tracing.shortest);
        let mut step = 0.25 * longest;
        let mut here = first.clone();
        loop {
            if let Some(end) = ended(&here) {
                return end;
            }
            if self.solver.buffers.is_stopped() {
                return End::Stopped;
            }
            if trail.points.len() >= self.tracing.points || self.left == 0 {
                return End::Points;
            }
            self.left -= 1;
            let limit = match self.room(&here) {
                Room::Free => longest,
                Room::Within(limit) => limit.min(longest),
                Room::Edge(approach) => match self.pass(&here, &approach) {
                    Ok(next) => {
                        trail.points.push(next.point.clone());
                        here = next;
                        continue;
                    }
                    Err(end) => return end,
                },
            };
            step = step.min(limit);
            let tried = self.step(&here, step);
            let Some((next, turns)) = tried else {
                step *= 0.5;
                if step < shortest {
                    return End::Step;
                }
                continue;
            };
            let row = weigh(&here.stage, &here.tangent);
            let distance = self.solver.offset(&here.place, &next.place, &row);
            match self.between(&here, &next, distance) {
                Between::Nothing => {}
                Between::One(test) if self.mark(&here, &next, distance, test, trail) => {}
                // Too close together to go on, and too close to matter.
                _ if distance <= SEPARATE => {}
                _ => {
                    step = 0.5 * distance;
                    continue;
                }
            }
            if let Some(left) = left(self.solver.robot.length(), &next) {
                return left;
            }
            let closed = trail.points.len() > 10 && self.closes(first, &here, &next, distance);
            here = match self.agreed(&here, next, distance) {
                Ok(next) => next,
                Err(end) => return end,
            };
            trail.points.push(here.point.clone());
            if closed {
                return End::Closed;
            }
            step *= match turns {
                0..=3 => 1.5,
                4..=5 => 1.0,
                _ => 0.6,
            };
        }
    }

    /// Adds the event between two nodes to the trail; false where it cannot be located.
    fn mark(&mut self, here: &Node, next: &Node, distance: f64, test: Test, trail: &mut Trail) -> bool {
        let Some(mut node) = self.locate(here, next, distance, test) else { return false };
        let multiplicity = match test {
            Test::Fold => {
                node.mark(PointKind::Fold, here, next);
                trail.points.push(node.point);
                return true;
            }
            Test::Eigenvalue(_, count) => count,
            Test::Determinant => 1,
        };
        if matches!(test, Test::Eigenvalue(..)) && !self.conservative {
            let row = weigh(&here.stage, &here.tangent);
            let near = self.solver.offset(&here.place, &node.place, &row);
            // Where only the symmetric part is singular, nothing branches off.
            let Some(exact) = self.singular(here, near) else { return true };
            node = exact;
        }
        let Some((mut node, directions)) = self.crossing(node, here, next, multiplicity) else {
            return false;
        };
        node.mark(PointKind::BranchPoint { multiplicity }, here, next);
        trail.points.push(node.point.clone());
        trail.crossings.push((trail.points.len() - 1, node, directions));
        true
    }

    /// Does the first node lie between two later ones?
    fn closes(&self, first: &Node, here: &Node, next: &Node, distance: f64) -> bool {
        if !(first.stage.is(&here.stage) && first.stage.is(&next.stage)) {
            return false;
        }
        let row = weigh(&here.stage, &here.tangent);
        let along = self.solver.offset(&here.place, &first.place, &row);
        let across = self.solver.distance(&here.place, &first.place);
        (0.0..=distance).contains(&along) && across <= distance && dot(&row, &first.tangent) > STRAIGHT
    }
}

/// The end of the path that a fraction lies beyond.
pub(super) fn beyond(fraction: f64) -> Option<f64> {
    if fraction > 1.0 {
        Some(1.0)
    } else if fraction < 0.0 {
        Some(0.0)
    } else {
        None
    }
}

fn ended(node: &Node) -> Option<End> {
    let (fraction, slope) = (node.place.fraction, node.slope());
    if fraction >= 1.0 && slope > 0.0 {
        Some(End::Last)
    } else if fraction <= 0.0 && slope < 0.0 {
        Some(End::First)
    } else {
        None
    }
}

fn left(length: f64, node: &Node) -> Option<End> {
    let follower = node.point.equilibrium.actuators.iter().position(|a| a.motion.abs() >= length)?;
    Some(End::Left { tube: tube_of(follower) })
}
