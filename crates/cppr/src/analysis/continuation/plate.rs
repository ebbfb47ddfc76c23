//! The moving edges: where the pattern of a follower begins, and a stiffer part comes in from below the plate.
//!
//! At Δa = 0 the unknowns change: an edge enters or leaves the robot, or a follower driven by force comes to stand at
//! the plate, between the tensions of both sides. Where an edge meets a load or another edge, their order changes. Towards
//! such a place steps shrink geometrically, and the last one leads past it.

use super::bordered::{Node, PathState, Stage, size_of};
use super::events::enclose;
use super::track::{Tracer, beyond};
use super::{End, PointKind};
use crate::kinematics::layout::{Cut, Joint, Layout};
use crate::solve::Equilibrium;
use crate::solve::edges::{LEAST_EDGE, Side, carried, excess_at_plate};
use crate::solve::input::tube_of;
use crate::solve::path::settle;
use crate::solve::system::Scale;
use std::sync::Arc;

/// What an edge meets.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meeting {
    Plate,
    Load,
    /// The edge of another follower.
    Edge(usize),
    Tip,
}

/// Two places that may come together.
pub(super) struct Approach {
    follower: usize,
    /// Length between them (m), and its rate along the path.
    left: f64,
    rate: f64,
    meeting: Meeting,
}

impl Approach {
    /// Along the path.
    fn distance(&self) -> f64 {
        self.left.max(0.0) / self.rate.abs()
    }
}

/// How far a step may go.
pub(super) enum Room {
    Free,
    /// Not farther than this, so as not to run into an edge.
    Within(f64),
    /// A meeting is near: to be passed in one go.
    Edge(Approach),
}

/// Nearer than this part of L an edge is passed in one go.
const NEAR: f64 = 1e-5;
/// How far behind an edge (parts of L) the path goes on: the first where there is an equilibrium.
const BEHIND: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
/// Farther than this part of L the tip has jumped to another equilibrium.
const JUMP: f64 = 1e-2;

impl Tracer<'_> {
    fn stiffens(&self, follower: usize) -> bool {
        !self.solver.robot.fields()[follower + 1].smooth_at_plate()
    }

    /// Everything that may meet, with the length that is left between and its rate along the path.
    fn approaches(&self, node: &Node) -> Vec<Approach> {
        let layout = &node.stage.layout;
        let length = self.solver.robot.length();
        let outside = (0..node.sliding.len())
            .filter(|&f| self.stiffens(f) && node.stage.standing >> f & 1 == 0)
            .filter(|f| !layout.edges.contains(&(f + 1)))
            .map(|follower| Approach {
                follower,
                left: node.point.equilibrium.actuators[follower].motion,
                rate: node.sliding[follower],
                meeting: Meeting::Plate,
            });
        let at = |joint: Joint| {
            let (label, unknown) = Layout::label(joint, &node.place.point.coordinates);
            (label, unknown.map_or(0.0, |u| node.tangent[u] * length))
        };
        let between = layout.elements.iter().filter_map(|element| {
            let ((a, a_rate), (b, b_rate)) = (at(element.start), at(element.end));
            let edge = |joint: Joint| match joint {
                Joint::Edge { follower, .. } => Some(follower - 1),
                Joint::Fixed(_) => None,
            };
            let beyond = |label: f64| {
                if label <= 0.0 {
                    Meeting::Plate
                } else if label >= length {
                    Meeting::Tip
                } else {
                    Meeting::Load
                }
            };
            let (follower, meeting) = match (edge(element.start), edge(element.end)) {
                (None, None) => return None,
                (None, Some(end)) => (end, beyond(a)),
                (Some(start), None) => (start, beyond(b)),
                (Some(start), Some(end)) => (end, Meeting::Edge(start)),
            };
            Some(Approach { follower, left: b - a, rate: b_rate - a_rate, meeting })
        });
        outside.chain(between).collect()
    }

    pub(super) fn room(&self, node: &Node) -> Room {
        let length = self.solver.robot.length();
        let mut room = Room::Free;
        for approach in self.approaches(node) {
            if approach.rate > -LEAST_EDGE * length {
                continue;
            }
            if approach.left <= NEAR * length {
                return Room::Edge(approach);
            }
            let limit = 0.9 * approach.distance();
            room = match room {
                Room::Within(other) if other < limit => room,
                _ => Room::Within(limit),
            };
        }
        room
    }

    /// Have the followers outside stayed outside?
    pub(super) fn in_place(&self, node: &Node) -> bool {
        self.approaches(node).iter().all(|a| a.left >= -LEAST_EDGE * self.solver.robot.length())
    }

    /// The first node behind a meeting.
    pub(super) fn pass(&mut self, here: &Node, approach: &Approach) -> Result<Node, End> {
        let tube = tube_of(approach.follower);
        match approach.meeting {
            Meeting::Tip => Err(End::Left { tube }),
            Meeting::Plate => self.hop(here, approach).ok_or(End::Edge { tube }),
            Meeting::Load | Meeting::Edge(_) => self.exchange(here, approach).ok_or(End::Edge { tube }),
        }
    }

    /// Past the plate.
    fn hop(&mut self, here: &Node, approach: &Approach) -> Option<Node> {
        let length = self.solver.robot.length();
        BEHIND.iter().find_map(|part| {
            let distance = approach.distance() + part * length / -approach.rate;
            let target = here.place.fraction + distance * here.slope();
            self.arrive(here, beyond(target).unwrap_or(target), approach.follower)
        })
    }

    /// Past a load or another edge: both joints change their order. How far the edge is behind is prescribed, the
    /// fraction follows.
    fn exchange(&mut self, here: &Node, approach: &Approach) -> Option<Node> {
        let old = Arc::clone(&here.stage.layout);
        let (robot, length) = (self.solver.robot, self.solver.robot.length());
        let number = |layout: &Layout, f: usize| layout.edges.iter().position(|&e| e == f + 1);
        let rate = |f: usize| number(&old, f).map(|i| here.tangent[i]);
        let relative = match approach.meeting {
            Meeting::Edge(other) => rate(approach.follower)? - rate(other)?,
            _ => rate(approach.follower)?,
        };
        let towards = relative.signum();
        let label = |f: usize| {
            let i = number(&old, f).unwrap_or(0);
            let gap = if f == approach.follower { approach.left + NEAR * length } else { 0.0 };
            here.place.point.coordinates[i] + towards * gap
        };
        let loads = here.point.equilibrium.command.loads.clone();
        let edges = old.edges.iter().map(|&e| Cut::edge(e, label(e - 1)));
        let cuts = loads.cuts().map(Cut::fixed).chain(edges);
        let resolution = self.solver.settings.resolution;
        let layout = self.solver.buffers.layouts.get(robot.tube_count(), length, resolution, cuts);
        let place = PathState {
            point: carried(&here.place.point, &old, &layout, label),
            fraction: here.place.fraction + approach.distance() * here.slope(),
        };
        let conditions = here.tangent.len() - old.unknowns();
        let mut row = vec![0.0; layout.unknowns() + conditions];
        row[number(&layout, approach.follower)?] = towards;
        if let Meeting::Edge(other) = approach.meeting {
            row[number(&layout, other)?] = -towards;
        }
        let stage = Stage { layout, standing: here.stage.standing };
        let mut node = self.settled(&stage, place, &row)?;
        node.point.kind = PointKind::Edge { tube: tube_of(approach.follower) };
        let jump = (node.point.tip - here.point.tip).norm();
        (jump <= JUMP * length).then_some(node)
    }

    /// The solver's equilibrium at another fraction, if its unknowns are others; its tangent continues that of `here`.
    fn arrive(&mut self, here: &Node, fraction: f64, follower: usize) -> Option<Node> {
        let found = self.solve(&here.point.equilibrium, fraction);
        let (stage, place) = Self::standing_of(&found, fraction);
        if !found.status.is_equilibrium() || (stage.is(&here.stage) && beyond(fraction).is_none()) {
            return None;
        }
        let row = self.transferred(here, &stage.layout, size_of(&found));
        let mut node = self.settled(&stage, place, &row)?;
        node.point.kind = PointKind::Edge { tube: tube_of(follower) };
        let jump = (node.point.tip - here.point.tip).norm();
        (jump <= JUMP * self.solver.robot.length()).then_some(node)
    }

    fn solve(&mut self, start: &Equilibrium, fraction: f64) -> Equilibrium {
        let mut found = start.clone();
        let command = self.solver.family.at(fraction);
        settle(self.solver.robot, self.solver.buffers, &command, self.solver.settings, &mut found);
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

    /// The node itself, on the elements that the solver would choose there; or the first node of another stage, where
    /// a follower leaves the plate at which it stood.
    pub(super) fn agreed(&mut self, here: &Node, next: Node, distance: f64) -> Result<Node, End> {
        for follower in (0..next.sliding.len()).filter(|f| next.stage.standing >> f & 1 == 1) {
            for side in [Side::Outside, Side::Inside] {
                let lost = End::Edge { tube: tube_of(follower) };
                let ends = [here, &next].map(|node| self.rest_of_force(node, follower, side).map(|r| r.0));
                let (Some(before), Some(after)) = (ends[0], ends[1]) else { return Err(lost) };
                if after > 0.0 {
                    let left = if before > 0.0 {
                        // It came to stand just here.
                        Some(here.clone())
                    } else {
                        enclose(distance, [before, after], self.tracing.tolerance, |at| {
                            let node = self.at(here, at)?;
                            Some((self.rest_of_force(&node, follower, side)?.0, node))
                        })
                    };
                    return left.and_then(|node| self.leave(&node, follower, side)).ok_or(lost);
                }
            }
        }
        Ok(if next.stage.layout.edges.is_empty() { next } else { self.remeshed(next) })
    }

    /// [`excess_at_plate`] at a node.
    fn rest_of_force(&mut self, node: &Node, follower: usize, side: Side) -> Option<(f64, Equilibrium)> {
        let (robot, standing) = (self.solver.robot, &node.point.equilibrium);
        let depth = BEHIND[0] * robot.length();
        excess_at_plate(robot, self.solver.buffers, standing, follower, side, depth)
    }

    /// The first node of a follower that leaves the plate to a side.
    fn leave(&mut self, node: &Node, follower: usize, side: Side) -> Option<Node> {
        let (_, mut found) = self.rest_of_force(node, follower, side)?;
        found.drives[follower].push_pull = node.point.equilibrium.command.actuators[follower].push_pull;
        let standing = node.stage.standing & !(1 << follower);
        let mut row = vec![0.0; size_of(&found)];
        let last = row.len() - 1;
        row[last] = 1.0;
        let stage = Stage { layout: found.layout, standing };
        let place = PathState { point: found.point, fraction: node.place.fraction };
        let mut first = self.settled(&stage, place, &row)?;
        let mut approaches = self.approaches(&first).into_iter();
        if approaches.any(|a| a.follower == follower && a.meeting == Meeting::Plate && a.rate < 0.0) {
            first.turn();
        }
        first.point.kind = PointKind::Edge { tube: tube_of(follower) };
        Some(first)
    }

    /// On finer or coarser elements, where an edge has moved so far that the solver would choose others.
    fn remeshed(&mut self, node: Node) -> Node {
        let found = self.solve(&node.point.equilibrium, node.place.fraction);
        let (stage, place) = Self::standing_of(&found, node.place.fraction);
        if !found.status.is_equilibrium() || stage.is(&node.stage) {
            return node;
        }
        let row = self.transferred(&node, &stage.layout, size_of(&found));
        match self.settled(&stage, place, &row) {
            Some(other) if (other.point.tip - node.point.tip).norm() <= JUMP * self.solver.robot.length() => {
                other
            }
            _ => node,
        }
    }
}
