//! The moving edges: where the pattern of a follower begins, and a stiffer part comes in from below the plate.
//!
//! At Δa = 0 the unknowns change: an edge enters or leaves the robot, or a follower driven by force comes to stand at
//! the plate. Towards such a place steps shrink geometrically; the last one is taken by the solver at a command just
//! beyond, which also decides which of the cases holds there.

use super::bordered::Node;
use super::track::{Tracer, beyond};
use super::{End, PointKind};
use crate::kinematics::layout::{Joint, Layout};
use crate::solve::Equilibrium;
use crate::solve::newton::Scale;
use crate::solve::path::{LEAST_EDGE, settle};
use std::sync::Arc;

/// How far a step may go.
pub(super) enum Room {
    Free,
    /// Not farther than this, so as not to run into an edge.
    Within(f64),
    /// An edge is this near.
    Edge {
        follower: usize,
        distance: f64,
    },
}

/// Nearer than this part of L an edge is passed in one go.
const NEAR: f64 = 1e-5;
/// How far behind an edge (parts of L) the path goes on: the first where there is an equilibrium.
const BEHIND: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
/// Farther than this part of L the tip has jumped to another equilibrium.
const JUMP: f64 = 1e-2;

impl Tracer<'_> {
    fn stiffens(&self, follower: usize) -> bool {
        !self.solver.robot.fields[follower + 1].smooth_at_plate()
    }

    /// Followers that can reach the plate, with the length that is left to it and its rate along the path.
    fn approaches(&self, node: &Node) -> Vec<(usize, f64, f64)> {
        let layout = &node.stage.layout;
        let length = self.solver.robot.length();
        (0..node.sliding.len())
            .filter(|&f| self.stiffens(f) && node.stage.standing >> f & 1 == 0)
            .map(|f| match layout.edges.iter().position(|&e| e == f + 1) {
                Some(i) => {
                    let unknown = i;
                    (f, node.place.point.coordinates[unknown], node.tangent[unknown] * length)
                }
                None => (f, node.point.equilibrium.actuators[f].motion, node.sliding[f]),
            })
            .collect()
    }

    pub(super) fn room(&self, node: &Node) -> Room {
        let length = self.solver.robot.length();
        let mut room = Room::Free;
        for (follower, left, rate) in self.approaches(node) {
            if rate > -LEAST_EDGE * length {
                continue;
            }
            let distance = left.max(0.0) / -rate;
            if left <= NEAR * length {
                return Room::Edge { follower, distance };
            }
            let limit = 0.9 * distance;
            room = match room {
                Room::Within(other) if other < limit => room,
                _ => Room::Within(limit),
            };
        }
        room
    }

    /// Have the followers outside stayed outside?
    pub(super) fn in_place(&self, node: &Node) -> bool {
        self.approaches(node).iter().all(|&(_, left, _)| left >= -LEAST_EDGE * self.solver.robot.length())
    }

    /// Passes the plate: the first node behind it.
    pub(super) fn hop(&mut self, here: &Node, follower: usize, distance: f64) -> Option<Node> {
        let rate = self.approaches(here).into_iter().find(|a| a.0 == follower)?.2;
        let length = self.solver.robot.length();
        BEHIND.iter().find_map(|part| {
            let target = here.place.fraction + (distance + part * length / -rate) * here.slope();
            let target = beyond(target).unwrap_or(target);
            self.arrive(here, target, follower)
        })
    }

    /// The solver's equilibrium at another fraction, if its unknowns are others; its tangent continues that of `here`.
    fn arrive(&mut self, here: &Node, fraction: f64, follower: usize) -> Option<Node> {
        let found = self.solve(&here.point.equilibrium, fraction);
        let (stage, place) = Self::standing_of(&found, fraction);
        if !found.status.is_equilibrium() || (stage.is(&here.stage) && beyond(fraction).is_none()) {
            return None;
        }
        let row = self.transferred(here, &stage.layout, self.solver.size_of(&found));
        let mut node = self.settled(&stage, place, &row)?;
        node.point.kind = PointKind::Plate { tube: follower + 2 };
        let jump = (node.point.tip - here.point.tip).norm();
        (jump <= JUMP * self.solver.robot.length()).then_some(node)
    }

    fn solve(&mut self, start: &Equilibrium, fraction: f64) -> Equilibrium {
        let mut found = start.clone();
        let command = self.solver.family.at(fraction);
        settle(self.solver.robot, self.solver.workspace, &command, &self.tracing.settings, &mut found);
        found
    }

    /// The tangent of a node as a row over the unknowns of another layout.
    fn transferred(&self, here: &Node, target: &Layout, size: usize) -> Vec<f64> {
        let scale = Scale::of(self.solver.robot);
        let old = &here.stage.layout;
        let (mut before, mut after) = (Vec::new(), Vec::new());
        scale.units(old, &mut before);
        scale.units(target, &mut after);
        // Fields are linear in their modes: their rates are transferred like their values, edges where they are.
        let mut rates = here.place.point.coordinates.clone();
        for ((rate, unit), t) in rates.iter_mut().zip(&before).zip(&here.tangent).skip(old.edges.len()) {
            *rate = unit * t;
        }
        let mut row = vec![0.0; target.unknowns()];
        for (i, follower) in target.edges.iter().enumerate() {
            let motion = here.point.equilibrium.actuators[follower - 1].motion;
            row[i] = (-motion).max(NEAR * scale.length);
        }
        old.transfer(&rates, target, &mut row);
        row.iter_mut().zip(&after).for_each(|(r, unit)| *r /= unit);
        row[..target.edges.len()].fill(0.0);
        row.resize(size, 0.0);
        row[size - 1] = here.slope();
        row
    }

    /// The node itself, on the unknowns that the solver would choose there; or the first node of another stage, where
    /// a follower leaves the plate at which it stood.
    pub(super) fn agreed(&mut self, here: &Node, next: Node, distance: f64) -> Result<Node, End> {
        let stage = &next.stage;
        if stage.layout.edges.is_empty() && stage.standing == 0 {
            return Ok(next);
        }
        let differs = |tracer: &mut Self, node: &Node| {
            let found = tracer.solve(&node.point.equilibrium, node.place.fraction);
            found.status.is_equilibrium().then(|| Self::standing_of(&found, node.place.fraction)).filter(
                |(other, _)| {
                    other.standing != node.stage.standing || other.layout.edges != node.stage.layout.edges
                },
            )
        };
        let Some((other, _)) = differs(self, &next) else {
            return Ok(self.remeshed(next));
        };
        let changed = other.standing ^ stage.standing;
        let follower = (changed.trailing_zeros() as usize).min(next.sliding.len().saturating_sub(1));
        // Enclose where the follower leaves the plate.
        let (mut low, mut high, mut last) = (0.0, distance, here.clone());
        while high - low > NEAR {
            let middle = 0.5 * (low + high);
            let Some(node) = self.at(here, middle) else { break };
            if differs(self, &node).is_some() {
                high = middle;
            } else {
                (low, last) = (middle, node);
            }
        }
        let hopped = BEHIND.iter().find_map(|part| {
            let target = last.place.fraction + (high - low + part) * last.slope();
            let target = beyond(target).unwrap_or(target);
            self.arrive(&last, target, follower)
        });
        hopped.ok_or(End::Plate { tube: follower + 2 })
    }

    /// On finer or coarser elements, where an edge has moved so far that the solver would choose others.
    fn remeshed(&mut self, node: Node) -> Node {
        let found = self.solve(&node.point.equilibrium, node.place.fraction);
        let (stage, place) = Self::standing_of(&found, node.place.fraction);
        if !found.status.is_equilibrium() || stage.is(&node.stage) {
            return node;
        }
        let row = self.transferred(&node, &stage.layout, self.solver.size_of(&found));
        match self.settled(&stage, place, &row) {
            Some(other) if (other.point.tip - node.point.tip).norm() <= JUMP * self.solver.robot.length() => {
                other
            }
            _ => node,
        }
    }

    /// Where no step leads on: an edge may have met a fixed joint (a load) or another edge. Tries behind it.
    pub(super) fn leap(&mut self, here: &Node) -> Result<Node, End> {
        let layout = Arc::clone(&here.stage.layout);
        let u = &here.place.point.coordinates;
        let length = self.solver.robot.length();
        let squeezed = layout.elements.iter().find(|e| {
            let [a, b] = [e.start, e.end].map(|joint| Layout::label(joint, u).0);
            b - a <= 10.0 * NEAR * length
        });
        let edge = squeezed.and_then(|e| {
            [e.start, e.end].into_iter().find_map(|joint| match joint {
                Joint::Edge { follower, .. } => Some(follower - 1),
                Joint::Fixed(_) => None,
            })
        });
        let Some(follower) = edge else { return Err(End::Step) };
        BEHIND
            .iter()
            .find_map(|part| {
                let target = here.place.fraction + part * here.slope().signum();
                self.arrive(here, beyond(target).unwrap_or(target), follower)
            })
            .ok_or(End::Plate { tube: follower + 2 })
    }
}
