//! Which elements to solve on, and load stepping where Newton's method alone does not arrive.
//!
//! A follower that is pushed brings its part from below the plate into the robot. Where that part is another
//! tube (uncut, up to some hundred times stiffer) the edge between both is a joint of the layout. For a prescribed push it is
//! known beforehand that there is one; for a prescribed force it turns out in the solve.

use super::command::{Actuator, Command, CommandProblem, Drive};
use super::edges::{
    LEAST_EDGE, Side, Tight, carried, edge_estimate, edge_ratio, excess_at_plate, has_edge, pushed_to,
};
use super::newton::NewtonFailure;
use super::system::{Buffers, System};
use super::{Equilibrium, Reason, Settings, Solver, Statistics, Status, constraint, stability};
use crate::design::Robot;
use crate::kinematics::layout::{Cut, Layout};
use crate::real::Each;
use std::sync::Arc;

impl Solver {
    /// Solves for the equilibrium under a command, from rest: in one go, and where that ends nowhere, at an unstable
    /// equilibrium or far from where Newton's method began, in steps. A stable equilibrium on the way of the steps goes before an unstable one; not in a robot that
    /// leaves its plane by buckling, to either side alike.
    ///
    /// A command may have several stable equilibria; [`crate::analysis::continuation`] finds the one that the robot reaches
    /// while the command grows, and the others.
    ///
    /// # Errors
    /// Where the command cannot be asked of this robot. That no equilibrium was found is not an error but a
    /// [`Status`].
    pub fn solve(&mut self, command: &Command) -> Result<Equilibrium, CommandProblem> {
        let mut result = self.rest();
        self.solve_into(command, &mut result)?;
        Ok(result)
    }

    /// Solves for the equilibrium under a command, starting at another one: a neighbour in a sweep, or on a robot that is
    /// nearly this one. The result lies on its branch where that goes on, stable or not; steps from rest are taken where it
    /// does not.
    ///
    /// # Errors
    /// As [`Solver::solve`], and where the start has another number of tubes.
    pub fn solve_from(
        &mut self,
        command: &Command,
        start: &Equilibrium,
    ) -> Result<Equilibrium, CommandProblem> {
        let mut result = start.clone();
        self.solve_into(command, &mut result)?;
        Ok(result)
    }

    /// Moves an equilibrium to a new command, starting at itself: for control loops. Allocates nothing where robot,
    /// settings and the kinds of loads are those of earlier calls.
    ///
    /// # Errors
    /// As [`Solver::solve_from`]; `equilibrium` is then left as it was.
    pub fn solve_into(
        &mut self,
        command: &Command,
        equilibrium: &mut Equilibrium,
    ) -> Result<(), CommandProblem> {
        let Self { robot, settings, buffers, .. } = self;
        let (robot, settings) = (&*robot, &*settings);
        command.check(robot, settings)?;
        let (given, tubes) = (equilibrium.robot.tube_count(), robot.tube_count());
        if given != tubes {
            return Err(CommandProblem::OtherStart { given, tubes });
        }
        let before = (buffers.iterations, buffers.evaluations);
        let shortened = buffers.shortened;
        let evaluated = buffers.holds(equilibrium.mark)
            && equilibrium.robot.serial() == robot.serial()
            && equilibrium.status.is_equilibrium()
            && equilibrium.settings == *settings
            && equilibrium.command.rotation_means == command.rotation_means
            && equilibrium.command.loads == command.loads;
        equilibrium.settings = *settings;
        equilibrium.belong_to(robot);
        let cold = equilibrium.point.is_rest();
        let mut finder = Finder { robot, buffers, settings, load_steps: 0, evaluated };
        finder.attempt(command, equilibrium);
        if !equilibrium.status.is_equilibrium() {
            *equilibrium =
                finder.step_from_rest(command, settings.smallest_step, |_, status| status.is_equilibrium());
        }
        if cold && equilibrium.status == Status::Unstable && !is_symmetric(robot, command) {
            let other = finder
                .step_from_rest(command, settings.smallest_step, |_, status| status == Status::Converged);
            if other.status == Status::Converged {
                *equilibrium = other;
            }
        }
        if cold && equilibrium.status == Status::Converged && finder.buffers.shortened >= shortened + STRAY {
            let gentle = |steps, status| steps == 0 && status == Status::Converged;
            let other = finder.step_from_rest(command, GENTLE, gentle);
            if other.status == Status::Converged {
                *equilibrium = other;
            }
        }
        let load_steps = finder.load_steps;
        equilibrium.command.copy(command);
        equilibrium.statistics = Statistics {
            iterations: buffers.iterations - before.0,
            evaluations: buffers.evaluations - before.1,
            load_steps,
        };
        Ok(())
    }

    /// The equilibrium with this solver's settings next to one with others, by one attempt.
    pub(crate) fn beside(&mut self, equilibrium: &Equilibrium) -> Equilibrium {
        let mut found = Equilibrium { settings: self.settings, ..equilibrium.clone() };
        settle(&self.robot, &mut self.buffers, &equilibrium.command, &self.settings, &mut found);
        found
    }
}

/// One attempt at a command from a neighbouring equilibrium, which it moves: no way around over rest, so that the
/// result lies on the same branch or is none.
pub(crate) fn settle(
    robot: &Robot,
    buffers: &mut Buffers,
    command: &Command,
    settings: &Settings,
    equilibrium: &mut Equilibrium,
) {
    Finder { robot, buffers, settings, load_steps: 0, evaluated: false }.attempt(command, equilibrium);
    equilibrium.command.copy(command);
}

/// So many shortened steps of Newton's method from rest may have led onto another branch: of 896 commands of random robots each of the three that did had so many,
/// and so had 18 % of the others. With this bound none of 560 is on another one (`CPPR_CASES=300 cargo test --release -p cppr --test march`).
const STRAY: usize = 4;
/// Smallest part of the command that is then added by steps that none is shortened in.
const GENTLE: f64 = 1.0 / 64.0;

/// Is the mirror image at the plane of bending of every equilibrium another one? Which of two the steps led to would be
/// chance.
fn is_symmetric(robot: &Robot, command: &Command) -> bool {
    let turned = |actuator: &Actuator| actuator.rotation.value().abs() > 0.0;
    robot.is_planar() && command.loads.is_planar() && !command.actuators.iter().any(turned)
}

struct Finder<'a> {
    robot: &'a Robot,
    buffers: &'a mut Buffers,
    settings: &'a Settings,
    load_steps: usize,
    /// The buffers hold the evaluation of the start under the same loads.
    evaluated: bool,
}

impl Finder<'_> {
    /// One attempt at the whole command, starting at `equilibrium` and ending in it.
    fn attempt(&mut self, command: &Command, equilibrium: &mut Equilibrium) {
        let mut start = self.start_at(equilibrium);
        // One bit per follower: has it an edge inside?
        let mut edges = 0_u64;
        for (f, actuator) in command.actuators.iter().enumerate() {
            let motion = match actuator.push_pull {
                Drive::Motion(motion) => motion,
                Drive::Effort(_) => equilibrium.actuators[f].motion,
            };
            edges |= u64::from(has_edge(self.robot, f, motion)) << f;
        }
        let drives = &mut self.buffers.drives;
        constraint::drives(self.robot, command, self.settings, 0, drives);
        self.evaluated &= equilibrium.drives.iter().zip(&*drives).all(|(old, new)| old.is_held_like(new));
        std::mem::swap(drives, &mut equilibrium.drives);
        // Each prescribed force settles its edge in at most two turns; a third finds it between both, a fourth at the plate.
        for _ in 0..4 * command.actuators.len().max(1) {
            self.on_edges(command, &start, edges, equilibrium);
            if let Some(f) = self.wrong_edge(edges, equilibrium) {
                if edges >> f & 1 == 1 {
                    // Neither inside nor outside, it seems: the force lies in the jump, and the edge stays at the plate.
                    equilibrium.drives[f].push_pull = Drive::Motion(0.0);
                }
                edges ^= 1 << f;
                continue;
            }
            let Some((f, left)) = self.leaves_plate(command, equilibrium) else {
                // A follower that stands at the plate leaves the rest of its force to the jump there.
                for (state, actuator) in equilibrium.actuators.iter_mut().zip(&command.actuators) {
                    if let Some(force) = actuator.push_pull.effort() {
                        state.tension = force;
                    }
                }
                return;
            };
            // Near the plate Newton's method does not find the edge by itself: it goes on from there.
            edges ^= u64::from(left.layout.edges.contains(&(f + 1))) << f;
            start = self.start_at(&left);
            equilibrium.actuators.clone_from(&left.actuators);
            equilibrium.drives[f].push_pull = command.actuators[f].push_pull;
        }
        equilibrium.status = Status::NotConverged(Reason::Edges);
    }

    /// Puts the point at which an attempt starts into `buffers.start`, and where its edges lie into `buffers.edge_ratios`; returns its layout.
    fn start_at(&mut self, equilibrium: &Equilibrium) -> Arc<Layout> {
        self.buffers.start.copy(&equilibrium.point);
        self.buffers.edge_ratios.clear();
        self.buffers.edge_ratios.extend((0..equilibrium.actuators.len()).map(|f| edge_ratio(equilibrium, f)));
        Arc::clone(&equilibrium.layout)
    }

    /// The first follower driven by force whose edge is not where the layout says.
    fn wrong_edge(&self, edges: u64, result: &Equilibrium) -> Option<usize> {
        (0..result.drives.len()).find(|&f| {
            let inside = edges >> f & 1 == 1;
            result.drives[f].push_pull.effort().is_some()
                && if result.status.is_equilibrium() {
                    inside != has_edge(self.robot, f, result.actuators[f].motion)
                } else {
                    inside
                }
        })
    }

    /// The first follower that stands at the plate although its force would move it, and where it begins to move.
    fn leaves_plate(&mut self, command: &Command, result: &Equilibrium) -> Option<(usize, Equilibrium)> {
        if !result.status.is_equilibrium() {
            return None;
        }
        (0..result.drives.len()).find_map(|f| {
            if command.actuators[f].push_pull.is_motion() || !result.drives[f].push_pull.is_motion() {
                return None;
            }
            let mut standing = result.clone();
            standing.command.copy(command);
            let depth = 2.0 * LEAST_EDGE * self.robot.length();
            [Side::Outside, Side::Inside].into_iter().find_map(|side| {
                let (excess, left) = excess_at_plate(self.robot, self.buffers, &standing, f, side, depth)?;
                if excess <= 0.0 {
                    return None;
                }
                let prescribed = command.actuators[f].push_pull.value();
                let left = match side {
                    Side::Outside => left,
                    Side::Inside => pushed_to(self.robot, self.buffers, left, f, prescribed)?,
                };
                Some((f, left))
            })
        })
    }

    fn on_edges(&mut self, command: &Command, start: &Arc<Layout>, edges: u64, result: &mut Equilibrium) {
        let (robot, settings, length) = (self.robot, self.settings, self.robot.length());
        // Edges that were not found where they were expected, and where they are looked for instead.
        let mut moved: Vec<(usize, f64)> = Vec::new();
        let (outcome, stable) = loop {
            let evaluated = self.begin(command, start, edges, &moved, result);
            let system = System {
                robot,
                layout: &result.layout,
                loads: Each::same(&command.loads),
                rotation_means: command.rotation_means,
                actuators: Each::same(&result.drives),
                formulation: settings.formulation,
            };
            let mut outcome = self.buffers.newton(&system, settings, &mut result.point, evaluated);
            let stable = outcome.is_ok() && stability::is_stable(self.buffers, &system);
            if stable {
                break (outcome, true);
            }
            let tight = Tight::of(&result.layout, &result.point);
            if tight.as_ref().is_some_and(|t| t.is_kink(&result.drives, length)) {
                outcome = Err(NewtonFailure::Singular);
            }
            match tight.and_then(|t| t.passed(length, moved.len())) {
                Some(passed) if outcome.is_err() => moved.push(passed),
                _ => break (outcome, false),
            }
        };
        self.conclude(result, outcome, stable);
    }

    /// Lays out an attempt and puts the start there. Do the buffers hold its evaluation?
    fn begin(
        &mut self,
        command: &Command,
        start: &Arc<Layout>,
        edges: u64,
        moved: &[(usize, f64)],
        result: &mut Equilibrium,
    ) -> bool {
        let (robot, length) = (self.robot, self.robot.length());
        let ratios = &self.buffers.edge_ratios;
        let estimate = |f: usize| {
            let motion = match result.drives[f].push_pull {
                Drive::Motion(motion) => motion,
                Drive::Effort(_) => result.actuators[f].motion,
            };
            let other = moved.iter().rev().find(|(follower, _)| *follower == f);
            let ratio = ratios[f];
            other.map_or_else(|| edge_estimate(ratio * motion, length), |&(_, place)| place)
        };
        let inside = (0..command.actuators.len()).filter(|&f| edges >> f & 1 == 1);
        let cuts = command.loads.cuts().map(Cut::fixed).chain(inside.map(|f| Cut::edge(f + 1, estimate(f))));
        let resolution = self.settings.resolution;
        let layout = self.buffers.layouts.get(robot.tube_count(), length, resolution, cuts);
        let from = &self.buffers.start;
        let same = Arc::ptr_eq(&layout, start);
        // An evaluated start stays as it is; elsewhere edges jump to where they will be.
        let evaluated = std::mem::take(&mut self.evaluated) && same;
        if same {
            result.point.copy(from);
        } else {
            result.point = carried(from, start, &layout, estimate);
        }
        for (i, follower) in layout.edges.iter().enumerate() {
            if let (Drive::Motion(_), false) = (result.drives[follower - 1].push_pull, evaluated) {
                result.point.coordinates[i] = estimate(follower - 1);
            }
        }
        constraint::prescribe(&Each::same(&result.drives), &mut result.point.efforts);
        result.layout = layout;
        evaluated
    }

    fn conclude(&mut self, result: &mut Equilibrium, outcome: Result<(), NewtonFailure>, stable: bool) {
        // A follower that has slid by the robot's length has left it.
        let motions = &self.buffers.assembly.motions;
        let inside = motions.iter().all(|motion| motion[0].abs() < self.robot.length());
        result.status = match (outcome, stable) {
            (Ok(()), _) if !inside => Status::NotConverged(Reason::PathEnds { fraction: 0.0 }),
            (Ok(()), true) => Status::Converged,
            (Ok(()), false) => Status::Unstable,
            (Err(_), _) => Status::NotConverged(Reason::PathEnds { fraction: 0.0 }),
        };
        result.read(self.buffers);
        if !result.status.is_equilibrium() {
            // The last evaluation need not be that of the point.
            (result.mark, self.buffers.mark) = (0, 0);
        }
    }

    /// Applies the command in steps from rest, each to an equilibrium that is accepted, by how many steps of Newton's method were shortened and by its status; they
    /// halve where none is found.
    fn step_from_rest(
        &mut self,
        command: &Command,
        smallest: f64,
        accepts: impl Fn(usize, Status) -> bool,
    ) -> Equilibrium {
        let mut current = Equilibrium::at_rest(self.robot, self.buffers, self.settings);
        let (mut reached, mut step) = (0.0, 0.25);
        loop {
            let next: f64 = f64::min(1.0, reached + step);
            let target = if next < 1.0 { command.scaled(next) } else { command.clone() };
            self.load_steps += 1;
            let mut trial = current.clone();
            let shortened = self.buffers.shortened;
            self.attempt(&target, &mut trial);
            if accepts(self.buffers.shortened - shortened, trial.status) {
                if next >= 1.0 {
                    return trial;
                }
                (current, reached) = (trial, next);
                step *= 1.5;
            } else {
                step *= 0.5;
                if step < smallest {
                    current.status = Status::NotConverged(Reason::PathEnds { fraction: reached });
                    return current;
                }
            }
        }
    }
}
