//! Which elements to solve on, and load stepping where Newton's method alone does not arrive.
//!
//! A follower that is pushed brings its part from below the plate into the robot. Where that part is another
//! tube (uncut, tenfold stiffer) the edge between both is a joint of the layout. For a prescribed push it is
//! known beforehand that there is one; for a prescribed force it turns out in the solve.

use super::command::{Command, CommandProblem, Drive, Settings};
use super::newton::{Failure, Point, System, Workspace};
use super::{ActuatorState, Equilibrium, Reason, Statistics, Status};
use crate::analysis::stability;
use crate::design::Robot;
use crate::kinematics::layout::Layout;
use crate::statics::assembly::Efforts;

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
    solve_from(robot, workspace, command, settings, &Equilibrium::rest(robot, settings))
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
    command.check(robot, settings)?;
    let before = (workspace.iterations, workspace.evaluations);
    let mut finder = Finder { robot, workspace, settings, load_steps: 0 };
    let mut result = finder.attempt(command, start);
    if !result.status.is_equilibrium() {
        result = finder.step_from_rest(command);
    }
    let load_steps = finder.load_steps;
    result.statistics = Statistics {
        iterations: workspace.iterations - before.0,
        evaluations: workspace.evaluations - before.1,
        load_steps,
    };
    Ok(result)
}

struct Finder<'a> {
    robot: &'a Robot,
    workspace: &'a mut Workspace,
    settings: &'a Settings,
    load_steps: usize,
}

/// Edges shorter than this part of L are not resolved: the follower stands at the plate.
const LEAST_EDGE: f64 = 1e-9;

impl Finder<'_> {
    /// One attempt at the whole command.
    fn attempt(&mut self, command: &Command, start: &Equilibrium) -> Equilibrium {
        let mut edges: Vec<bool> = (0..command.actuators.len())
            .map(|f| match command.actuators[f].push_pull {
                Drive::Motion(motion) => self.edge_at(f, motion),
                Drive::Effort(_) => self.edge_at(f, start.actuators[f].motion),
            })
            .collect();
        let asked = command.clone();
        let mut command = command.clone();
        if self.settings.resolution.angle == 0 {
            // Locked angles need no holding; a condition on them would be empty.
            command.actuators.iter_mut().for_each(|a| a.rotation = Drive::Effort(0.0));
        }
        // Each prescribed force settles its edge in at most two turns; a third finds it between both.
        for _ in 0..3 * command.actuators.len().max(1) {
            let mut result = self.on_edges(&command, start, &edges);
            let Some(f) = self.wrong_edge(&command, &edges, &result) else {
                // A follower that stands at the plate leaves the rest of its force to the jump there.
                for (state, actuator) in result.actuators.iter_mut().zip(&asked.actuators) {
                    if let Drive::Effort(force) = actuator.push_pull {
                        state.tension = force;
                    }
                }
                result.command = asked;
                return result;
            };
            if edges[f] {
                // Neither inside nor outside: the force lies in the jump, and the edge stays at the plate.
                edges[f] = false;
                command.actuators[f].push_pull = Drive::Motion(0.0);
            } else {
                edges[f] = true;
            }
        }
        let mut result = self.on_edges(&command, start, &edges);
        result.status = Status::NotConverged(Reason::Edges);
        result.command = asked;
        result
    }

    /// Does a follower that stands at Δa bring another part into the robot?
    fn edge_at(&self, follower: usize, motion: f64) -> bool {
        motion < -LEAST_EDGE * self.robot.length() && !self.robot.fields[follower + 1].smooth_at_plate()
    }

    /// The first follower driven by force whose edge is not where the layout says.
    fn wrong_edge(&self, command: &Command, edges: &[bool], result: &Equilibrium) -> Option<usize> {
        (0..edges.len()).find(|&f| {
            matches!(command.actuators[f].push_pull, Drive::Effort(_))
                && if result.status.is_equilibrium() {
                    edges[f] != self.edge_at(f, result.actuators[f].motion)
                } else {
                    edges[f]
                }
        })
    }

    fn on_edges(&mut self, command: &Command, start: &Equilibrium, edges: &[bool]) -> Equilibrium {
        let (robot, settings) = (self.robot, self.settings);
        let length = robot.length();
        let guesses: Vec<(usize, f64)> = (0..edges.len())
            .filter(|&f| edges[f])
            .map(|f| {
                let motion = match command.actuators[f].push_pull {
                    Drive::Motion(motion) => motion,
                    Drive::Effort(_) => start.actuators[f].motion,
                };
                (f + 1, (-motion).clamp(1e-3 * length, 0.9 * length))
            })
            .collect();
        let layout =
            Layout::new(robot.tube_count(), length, settings.resolution, &command.loads.cuts(), &guesses);
        let mut point = Point {
            coordinates: start.layout.transfer(&start.coordinates, &layout, &guesses),
            efforts: Efforts {
                tension: start.efforts.tension.clone(),
                torque: start.efforts.torque.clone(),
                edge: vec![0.0; layout.edges.len()],
            },
        };
        for (i, follower) in layout.edges.iter().enumerate() {
            if let Some(old) = start.layout.edges.iter().position(|f| f == follower) {
                point.efforts.edge[i] = start.efforts.edge[old];
            }
        }
        for (f, actuator) in command.actuators.iter().enumerate() {
            if let Drive::Effort(force) = actuator.push_pull {
                point.efforts.tension[f] = force;
            }
            if let Drive::Effort(torque) = actuator.rotation {
                point.efforts.torque[f] = torque;
            }
        }
        let system = System {
            robot,
            layout: &layout,
            loads: &command.loads,
            knob: command.knob,
            actuators: &command.actuators,
            formulation: settings.formulation,
        };
        let outcome = self.workspace.newton(&system, settings, &mut point);
        let stable = outcome.is_ok() && stability::is_stable(self.workspace, &system);
        self.conclude(command, layout, point, outcome, stable)
    }

    fn conclude(
        &mut self,
        command: &Command,
        layout: Layout,
        point: Point,
        outcome: Result<(), Failure>,
        stable: bool,
    ) -> Equilibrium {
        let assembly = &self.workspace.assembly;
        let status = match (outcome, stable) {
            (Ok(()), true) => Status::Converged,
            (Ok(()), false) => Status::Unstable,
            (Err(_), _) => Status::NotConverged(Reason::PathEnds { fraction: 0.0 }),
        };
        let actuators = (0..command.actuators.len())
            .map(|f| ActuatorState {
                motion: assembly.knobs[f][0],
                rotation: assembly.knobs[f][1],
                tension: point.efforts.tension[f],
                torque: point.efforts.torque[f],
            })
            .collect();
        Equilibrium {
            status,
            statistics: Statistics::default(),
            elastic_energy: assembly.elastic,
            actuators,
            command: command.clone(),
            settings: *self.settings,
            residual: self.workspace.residual.iter().fold(0.0, |m, r| r.abs().max(m)),
            layout,
            coordinates: point.coordinates,
            efforts: point.efforts,
            drives: command.actuators.clone(),
        }
    }

    /// Applies the command in steps from rest, with steps that halve where Newton's method fails.
    fn step_from_rest(&mut self, command: &Command) -> Equilibrium {
        let mut current = Equilibrium::rest(self.robot, self.settings);
        let (mut reached, mut step) = (0.0, 0.25);
        loop {
            let next: f64 = f64::min(1.0, reached + step);
            let target = if next < 1.0 { command.scaled(next) } else { command.clone() };
            self.load_steps += 1;
            let result = self.attempt(&target, &current);
            if result.status.is_equilibrium() {
                if next >= 1.0 {
                    return result;
                }
                (current, reached) = (result, next);
                step *= 1.5;
            } else {
                step *= 0.5;
                if step < self.settings.smallest_step {
                    let status = Status::NotConverged(Reason::PathEnds { fraction: reached });
                    return Equilibrium { status, command: command.clone(), ..current };
                }
            }
        }
    }
}
