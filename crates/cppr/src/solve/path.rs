//! Which elements to solve on, and load stepping where Newton's method alone does not arrive.
//!
//! A follower that is pushed brings its part from below the plate into the robot. Where that part is another
//! tube (uncut, up to some hundred times stiffer) the edge between both is a joint of the layout. For a prescribed push it is
//! known beforehand that there is one; for a prescribed force it turns out in the solve.

use super::command::{Actuator, Command, CommandProblem, Drive, Settings};
use super::newton::{Failure, Point, System, Workspace};
use super::{Equilibrium, Reason, Statistics, Status};
use crate::analysis::stability;
use crate::design::Robot;
use crate::kinematics::layout::{Cut, Layout};
use crate::real::Each;
use std::sync::Arc;

/// Solves for the equilibrium under a command, from rest.
///
/// # Errors
/// Where the command cannot be asked of this robot. That no equilibrium was found is not an error but a
/// [`Status`].
pub fn solve(
    robot: &Robot,
    workspace: &mut Workspace,
    command: &Command,
    settings: &Settings,
) -> Result<Equilibrium, CommandProblem> {
    let mut result = Equilibrium::at_rest(robot, workspace, settings);
    solve_into(robot, workspace, command, settings, &mut result)?;
    Ok(result)
}

/// Solves for the equilibrium under a command, starting at another one: a neighbour in a sweep.
///
/// # Errors
/// As [`solve`].
pub fn solve_from(
    robot: &Robot,
    workspace: &mut Workspace,
    command: &Command,
    settings: &Settings,
    start: &Equilibrium,
) -> Result<Equilibrium, CommandProblem> {
    let mut result = start.clone();
    solve_into(robot, workspace, command, settings, &mut result)?;
    Ok(result)
}

/// Moves an equilibrium to a new command, starting at itself: for control loops. Allocates nothing where robot,
/// settings and the kinds of loads are those of earlier calls.
///
/// # Errors
/// As [`solve`]; `equilibrium` is then left as it was.
pub fn solve_into(
    robot: &Robot,
    workspace: &mut Workspace,
    command: &Command,
    settings: &Settings,
    equilibrium: &mut Equilibrium,
) -> Result<(), CommandProblem> {
    command.check(robot, settings)?;
    let before = (workspace.iterations, workspace.evaluations);
    let known = workspace.holds(robot, equilibrium.mark)
        && equilibrium.status.is_equilibrium()
        && equilibrium.settings == *settings
        && equilibrium.command.knob == command.knob
        && equilibrium.command.loads == command.loads;
    equilibrium.settings = *settings;
    let mut finder = Finder { robot, workspace, settings, load_steps: 0, known };
    finder.attempt(command, equilibrium);
    if !equilibrium.status.is_equilibrium() {
        finder.step_from_rest(command, equilibrium);
    }
    let load_steps = finder.load_steps;
    equilibrium.command.copy(command);
    equilibrium.statistics = Statistics {
        iterations: workspace.iterations - before.0,
        evaluations: workspace.evaluations - before.1,
        load_steps,
    };
    Ok(())
}

/// One attempt at a command from a neighbouring equilibrium, which it moves: no way around over rest, so that the
/// result lies on the same branch or is none.
pub(crate) fn settle(
    robot: &Robot,
    workspace: &mut Workspace,
    command: &Command,
    settings: &Settings,
    equilibrium: &mut Equilibrium,
) {
    Finder { robot, workspace, settings, load_steps: 0, known: false }.attempt(command, equilibrium);
    equilibrium.command.copy(command);
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

/// Does a follower (0 is the first) that stands at Δa (m) bring another part into the robot?
pub(super) fn has_edge(robot: &Robot, follower: usize, motion: f64) -> bool {
    motion < -LEAST_EDGE * robot.length() && !robot.fields[follower + 1].smooth_at_plate()
}

/// Where the edge of a follower at Δa is expected: it has moved by its label, nearly.
pub(super) fn edge_estimate(motion: f64, length: f64) -> f64 {
    (-motion).clamp(1e-3 * length, 0.9 * length)
}

/// Locked angles need no holding; a condition on them would be empty.
pub(super) fn hold_locked(drives: &mut [Actuator], settings: &Settings) {
    if settings.resolution.angle == 0 {
        for actuator in drives {
            actuator.rotation = Drive::Effort(0.0);
        }
    }
}

struct Finder<'a> {
    robot: &'a Robot,
    workspace: &'a mut Workspace,
    settings: &'a Settings,
    load_steps: usize,
    /// The workspace has just evaluated the start under the same loads.
    known: bool,
}

/// Edges shorter than this part of L are not resolved: the follower stands at the plate.
pub(crate) const LEAST_EDGE: f64 = 1e-9;

/// What an attempt starts at; its point is `workspace.start`.
struct Start {
    layout: Arc<Layout>,
}

impl Finder<'_> {
    /// One attempt at the whole command, starting at `equilibrium` and ending in it.
    fn attempt(&mut self, command: &Command, equilibrium: &mut Equilibrium) {
        self.workspace.start.copy(&equilibrium.point);
        let start = Start { layout: Arc::clone(&equilibrium.layout) };
        // One bit per follower: has it an edge inside?
        let mut edges = 0_u64;
        for (f, actuator) in command.actuators.iter().enumerate() {
            let motion = match actuator.push_pull {
                Drive::Motion(motion) => motion,
                Drive::Effort(_) => equilibrium.actuators[f].motion,
            };
            edges |= u64::from(has_edge(self.robot, f, motion)) << f;
        }
        let drives = &mut self.workspace.drives;
        drives.clone_from(&command.actuators);
        hold_locked(drives, self.settings);
        self.known &= equilibrium.drives.iter().zip(&*drives).all(|(old, new)| old.is_held_like(new));
        std::mem::swap(drives, &mut equilibrium.drives);
        // Each prescribed force settles its edge in at most two turns; a third finds it between both.
        for _ in 0..3 * command.actuators.len().max(1) {
            self.on_edges(command, &start, edges, equilibrium);
            let Some(f) = self.wrong_edge(edges, equilibrium) else {
                // A follower that stands at the plate leaves the rest of its force to the jump there.
                for (state, actuator) in equilibrium.actuators.iter_mut().zip(&command.actuators) {
                    if let Drive::Effort(force) = actuator.push_pull {
                        state.tension = force;
                    }
                }
                return;
            };
            if edges >> f & 1 == 1 {
                // Neither inside nor outside: the force lies in the jump, and the edge stays at the plate.
                equilibrium.drives[f].push_pull = Drive::Motion(0.0);
            }
            edges ^= 1 << f;
        }
        equilibrium.status = Status::NotConverged(Reason::Edges);
    }

    /// The first follower driven by force whose edge is not where the layout says.
    fn wrong_edge(&self, edges: u64, result: &Equilibrium) -> Option<usize> {
        (0..result.drives.len()).find(|&f| {
            let inside = edges >> f & 1 == 1;
            matches!(result.drives[f].push_pull, Drive::Effort(_))
                && if result.status.is_equilibrium() {
                    inside != has_edge(self.robot, f, result.actuators[f].motion)
                } else {
                    inside
                }
        })
    }

    fn on_edges(&mut self, command: &Command, start: &Start, edges: u64, result: &mut Equilibrium) {
        let (robot, settings) = (self.robot, self.settings);
        let length = robot.length();
        // Where an edge is expected: the follower has moved by its label, nearly.
        let estimate = |f: usize| {
            let motion = match result.drives[f].push_pull {
                Drive::Motion(motion) => motion,
                Drive::Effort(_) => result.actuators[f].motion,
            };
            edge_estimate(motion, length)
        };
        let inside = (0..command.actuators.len()).filter(|&f| edges >> f & 1 == 1);
        let cuts = command.loads.cuts().map(Cut::fixed).chain(inside.map(|f| Cut::edge(f + 1, estimate(f))));
        let layout = self.workspace.layouts.get(robot.tube_count(), length, settings.resolution, cuts);
        let from = &self.workspace.start;
        let same = Arc::ptr_eq(&layout, &start.layout);
        // What the workspace has seen is a good start as it is; elsewhere edges jump to where they will be.
        let known = std::mem::take(&mut self.known) && same;
        if same {
            result.point.copy(from);
        } else {
            result.point = carried(from, &start.layout, &layout, estimate);
        }
        for (i, follower) in layout.edges.iter().enumerate() {
            if let (Drive::Motion(_), false) = (result.drives[follower - 1].push_pull, known) {
                result.point.coordinates[i] = estimate(follower - 1);
            }
        }
        for (f, actuator) in result.drives.iter().enumerate() {
            if let Drive::Effort(force) = actuator.push_pull {
                result.point.efforts.tension[f] = force;
            }
            if let Drive::Effort(torque) = actuator.rotation {
                result.point.efforts.torque[f] = torque;
            }
        }
        let system = System {
            robot,
            layout: &layout,
            loads: Each::same(&command.loads),
            knob: command.knob,
            actuators: Each::same(&result.drives),
            formulation: settings.formulation,
        };
        let outcome = self.workspace.newton(&system, settings, &mut result.point, known);
        let stable = outcome.is_ok() && stability::is_stable(self.workspace, &system);
        result.layout = layout;
        self.conclude(result, outcome, stable);
    }

    fn conclude(&mut self, result: &mut Equilibrium, outcome: Result<(), Failure>, stable: bool) {
        // A follower that has slid by the robot's length has left it.
        let knobs = &self.workspace.assembly.knobs;
        let inside = knobs.iter().all(|knob| knob[0].abs() < self.robot.length());
        result.status = match (outcome, stable) {
            (Ok(()), _) if !inside => Status::NotConverged(Reason::PathEnds { fraction: 0.0 }),
            (Ok(()), true) => Status::Converged,
            (Ok(()), false) => Status::Unstable,
            (Err(_), _) => Status::NotConverged(Reason::PathEnds { fraction: 0.0 }),
        };
        result.read(self.workspace);
        if !result.status.is_equilibrium() {
            // The last evaluation need not be that of the point.
            (result.mark, self.workspace.mark) = (0, 0);
        }
    }

    /// Applies the command in steps from rest, with steps that halve where Newton's method fails.
    fn step_from_rest(&mut self, command: &Command, result: &mut Equilibrium) {
        let mut current = Equilibrium::at_rest(self.robot, self.workspace, self.settings);
        let (mut reached, mut step) = (0.0, 0.25);
        loop {
            let next: f64 = f64::min(1.0, reached + step);
            let target = if next < 1.0 { command.scaled(next) } else { command.clone() };
            self.load_steps += 1;
            let mut trial = current.clone();
            self.attempt(&target, &mut trial);
            if trial.status.is_equilibrium() {
                if next >= 1.0 {
                    *result = trial;
                    return;
                }
                (current, reached) = (trial, next);
                step *= 1.5;
            } else {
                step *= 0.5;
                if step < self.settings.smallest_step {
                    *result = current;
                    result.status = Status::NotConverged(Reason::PathEnds { fraction: reached });
                    return;
                }
            }
        }
    }
}
