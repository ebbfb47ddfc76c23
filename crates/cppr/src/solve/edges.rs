//! The moving edges: sections where the pattern of a follower begins and its part from below the plate ends.
//!
//! An edge is the label X (m) where x_k(X) = 0, a joint of the layout; layouts differ in which edges there are and in how they
//! follow upon the loads. Here is what leads from one layout to the next. Motions Δa_k are in m, pull positive; tensions in N.

use super::Equilibrium;
use super::command::{Actuator, Drive};
use super::path::settle;
use super::system::{Buffers, Point};
use crate::design::Robot;
use crate::kinematics::layout::{Joint, Layout};

/// Edges shorter than this part of L are not resolved: the follower stands at the plate.
pub(crate) const LEAST_EDGE: f64 = 1e-9;

/// Does a follower (0 is the first) that stands at Δa (m) bring another part into the robot?
pub(crate) fn has_edge(robot: &Robot, follower: usize, motion: f64) -> bool {
    motion < -LEAST_EDGE * robot.length() && !robot.fields()[follower + 1].smooth_at_plate()
}

/// Where the edge of a follower at Δa is expected: it has moved by its label, nearly.
pub(crate) fn edge_estimate(motion: f64, length: f64) -> f64 {
    (-motion).clamp(LEAST_EDGE * length, 0.9 * length)
}

/// A point carried over to another layout whose edges lie at `label(follower)` (m; 0 is the first follower).
pub(crate) fn carried(from: &Point, old: &Layout, new: &Layout, label: impl Fn(usize) -> f64) -> Point {
    let mut point = Point::rest(new);
    point.efforts.tension.copy_from_slice(&from.efforts.tension);
    point.efforts.torque.copy_from_slice(&from.efforts.torque);
    for (i, follower) in new.edges.iter().enumerate() {
        point.coordinates[i] = label(follower - 1);
        if let Some(place) = old.edges.iter().position(|f| f == follower) {
            point.efforts.edge[i] = from.efforts.edge[place];
        }
    }
    old.transfer(&from.coordinates, new, &mut point.coordinates);
    point
}

/// Where a follower goes that leaves the plate: its pattern out, or the part from below in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Outside,
    Inside,
}

/// By how much the force on a follower that stands at the plate exceeds, towards one side, what holds it there: its
/// tension at Δa = 0⁺ or, `depth` (m) behind the plate, at 0⁻. With it the equilibrium on that side at this tension.
pub(crate) fn excess_at_plate(
    robot: &Robot,
    buffers: &mut Buffers,
    standing: &Equilibrium,
    follower: usize,
    side: Side,
    depth: f64,
) -> Option<(f64, Equilibrium)> {
    let mut found = standing.clone();
    let prescribed = standing.command.actuators[follower].push_pull.value();
    if side == Side::Outside {
        return Some((prescribed - standing.point.efforts.tension[follower], found));
    }
    let mut command = standing.command.clone();
    for (f, actuator) in command.actuators.iter_mut().enumerate() {
        if stands(standing, f) {
            actuator.push_pull = Drive::Motion(if f == follower { -depth } else { 0.0 });
        }
    }
    settle(robot, buffers, &command, &standing.settings, &mut found);
    found.status.is_equilibrium().then(|| (found.actuators[follower].tension - prescribed, found))
}

/// Goes on from a follower that has just entered by a prescribed motion to where its tension is `prescribed` (N): by its motion, since
/// Newton's method on the force does not find an edge that is far from where it was. `None` where no motion holds that tension.
pub(super) fn pushed_to(
    robot: &Robot,
    buffers: &mut Buffers,
    entered: Equilibrium,
    follower: usize,
    prescribed: f64,
) -> Option<Equilibrium> {
    let length = robot.length();
    let mut command = entered.command.clone();
    let mut at = |motion: f64, near: &Equilibrium| {
        command.actuators[follower].push_pull = Drive::Motion(motion);
        let mut found = near.clone();
        settle(robot, buffers, &command, &near.settings, &mut found);
        found.status.is_equilibrium().then_some(found)
    };
    // By how much an equilibrium is short of the push; it grows from here.
    let short = |found: &Equilibrium| found.actuators[follower].tension - prescribed;
    let motion = |found: &Equilibrium| found.actuators[follower].motion;
    let (mut near, mut step) = (entered, FIRST_PUSH * length);
    let mut far = loop {
        let next = motion(&near) - step;
        if next <= -FARTHEST_PUSH * length || step < LEAST_EDGE * length {
            return None;
        }
        match at(next, &near) {
            Some(found) if short(&found) <= 0.0 => break found,
            Some(found) => (near, step) = (found, 2.0 * step),
            None => step *= 0.25,
        }
    };
    // Regula falsi (Illinois): an end that stays for the second time counts for half.
    let (mut above, mut below) = (short(&near), short(&far));
    let mut moved_near = None;
    for _ in 0..MOST_TURNS {
        if above.min(-below) <= NEAR_PUSH * prescribed.abs() {
            break;
        }
        let share = above / (above - below);
        let Some(found) = at(motion(&near) + share * (motion(&far) - motion(&near)), &near) else { break };
        let (left, nearer) = (short(&found), short(&found) > 0.0);
        let half = if moved_near == Some(nearer) { 0.5 } else { 1.0 };
        moved_near = Some(nearer);
        if nearer {
            (near, above, below) = (found, left, half * below);
        } else {
            (far, below, above) = (found, left, half * above);
        }
    }
    Some(if short(&near) < -short(&far) { near } else { far })
}

/// First step into the robot on the way to a force (part of L).
const FIRST_PUSH: f64 = 1e-4;
/// No follower is pushed farther (part of L).
const FARTHEST_PUSH: f64 = 0.9;
/// Part of the force up to which its motion is found; Newton's method does the rest.
const NEAR_PUSH: f64 = 1e-3;
/// Turns of regula falsi: a part of 1e-3 takes five or six.
const MOST_TURNS: u32 = 30;

/// Does a follower driven by force rest at the plate, where its stiffness jumps?
pub(crate) fn stands(equilibrium: &Equilibrium, follower: usize) -> bool {
    let (drive, prescribed) = (&equilibrium.drives[follower], &equilibrium.command.actuators[follower]);
    matches!((drive.push_pull, prescribed.push_pull), (Drive::Motion(_), Drive::Effort(_)))
}

/// Under a force, an element beside an edge that is shorter than this part of L is a kink, see [`Tight::is_kink`].
const LEAST_PUSHED: f64 = 1e-6;
/// Nearer than this part of L to a load or to another edge, an edge may have failed to pass it.
const CROWDED: f64 = 1e-2;
/// How far beyond (parts of L) it is looked for then: one after the other.
const BEYOND: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

/// Label of a follower's edge against −Δa, 1 where it has none: hardly changes from an equilibrium to the next.
pub(super) fn edge_ratio(equilibrium: &Equilibrium, follower: usize) -> f64 {
    let edge = equilibrium.layout.edges.iter().position(|&e| e == follower + 1);
    let motion = equilibrium.actuators[follower].motion;
    edge.filter(|_| motion < 0.0).map_or(1.0, |edge| equilibrium.point.coordinates[edge] / -motion)
}

/// The edge that has the least room to one side.
pub(super) struct Tight {
    /// 0 is the first.
    follower: usize,
    /// To the next joint (m).
    room: f64,
    /// That joint (m), and how much farther a place in the middle of the next element is; `None` at plate and tip.
    beyond: Option<(f64, f64)>,
}

impl Tight {
    pub fn of(layout: &Layout, point: &Point) -> Option<Self> {
        let at = |joint: Joint| Layout::label(joint, &point.coordinates).0;
        let ends = |e: usize| layout.elements.get(e).map(|element| [at(element.start), at(element.end)]);
        let half = |e: usize| ends(e).map(|[from, to]| 0.5 * (to - from));
        let sides = layout.elements.iter().enumerate().filter_map(|(e, element)| {
            let [from, to] = ends(e)?;
            let (follower, beyond) = match (element.start, element.end) {
                (Joint::Edge { follower, .. }, _) => (follower, half(e + 1).map(|half| (to, half))),
                (_, Joint::Edge { follower, .. }) => {
                    (follower, e.checked_sub(1).and_then(half).map(|half| (from, -half)))
                }
                _ => return None,
            };
            Some(Self { follower: follower - 1, room: to - from, beyond })
        });
        sides.min_by(|a, b| a.room.total_cmp(&b.room))
    }

    /// Follower and place where its edge may be found after Newton's method has failed `times`.
    pub fn passed(&self, length: f64, times: usize) -> Option<(usize, f64)> {
        let most = BEYOND.get(times)? * length;
        let (joint, half) = self.beyond.filter(|_| self.room < CROWDED * length)?;
        Some((self.follower, joint + half.clamp(-most, most)))
    }

    /// A finite angle in an element of no length may fulfil the conditions of equilibrium, but is no shape of a robot. Where
    /// a force drives the follower, it is found on its way to the plate.
    pub fn is_kink(&self, drives: &[Actuator], length: f64) -> bool {
        let least = match drives[self.follower].push_pull {
            Drive::Motion(_) => LEAST_EDGE,
            Drive::Effort(_) => LEAST_PUSHED,
        };
        self.room < least * length
    }
}
