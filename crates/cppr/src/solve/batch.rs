//! Many commands of one robot, several side by side.
//!
//! Commands that ask for the same unknowns (the same kinds of drives and loads, the same tubes pushed) are solved in the
//! lanes of vector registers, [`WIDTH`] at a time, by the same code as a single one. A lane in which Newton's method would
//! need more than full steps, or that is not clearly stable, is solved once more alone, so that a result does not depend
//! on its neighbours.

use super::command::{Command, CommandProblem, Drive, Formulation, Settings};
use super::newton::{LONGEST, Point, System, Workspace, add_step};
use super::path::{carried, edge_estimate, has_edge, hold_locked, solve_into};
use super::{Actuator, Equilibrium, Statistics, Status};
use crate::analysis::shape::tip_pose;
use crate::design::Robot;
use crate::kinematics::layout::{Cut, Layout};
use crate::real::{Each, Pack, Real, every};
use crate::statics::Loads;
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;
use std::sync::Arc;

/// How many commands are solved side by side.
pub const WIDTH: usize = 8;

type Lanes = Pack<WIDTH>;

/// Full Newton steps of one group; a lane that needs more is solved alone.
const MOST_STEPS: usize = 12;

/// Every buffer that solving batches needs. Reuse it.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    lanes: Workspace<Lanes>,
    point: Point<Lanes>,
    trial: Point<Lanes>,
    step: Vec<Lanes>,
    correction: Vec<Lanes>,
    drives: [Vec<Actuator>; WIDTH],
    cuts: Vec<Cut>,
    /// Marks of the equilibria that `lanes` evaluated last.
    marks: [u64; WIDTH],
    single: Workspace,
}

impl Batch {
    /// Empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

/// Solves for the equilibria under many commands, each starting at the equilibrium that stands in its place: at rest, or
/// at a neighbour. Returns the poses of the tips: rotation of the leader's last section and centre (m), base frame.
///
/// Neighbours in the list are solved side by side: they should ask for the same kinds of drives and loads. Where one list is
/// longer than the other, its rest is left as it is.
///
/// # Errors
/// As [`super::solve`], for the first command that cannot be asked; the equilibria before it are solved.
pub fn solve_batch(
    robot: &Robot,
    batch: &mut Batch,
    commands: &[Command],
    settings: &Settings,
    equilibria: &mut [Equilibrium],
    tips: &mut Vec<(Matrix3<f64>, Vector3<f64>)>,
) -> Result<(), CommandProblem> {
    tips.clear();
    let count = commands.len().min(equilibria.len());
    let (commands, equilibria) = (&commands[..count], &mut equilibria[..count]);
    for (commands, equilibria) in commands.chunks(WIDTH).zip(equilibria.chunks_mut(WIDTH)) {
        for command in commands {
            command.check(robot, settings)?;
        }
        let solved = match batch.common_layout(robot, commands, settings, equilibria) {
            Some(layout) => batch.group(robot, commands, settings, equilibria, &layout, tips),
            None => 0,
        };
        let first = tips.len() - if solved == 0 { 0 } else { commands.len() };
        for (lane, (command, equilibrium)) in commands.iter().zip(equilibria).enumerate() {
            if solved >> lane & 1 == 1 {
                continue;
            }
            solve_into(robot, &mut batch.single, command, settings, equilibrium)?;
            let tip = tip_pose(robot, &mut batch.single, equilibrium);
            match tips.get_mut(first + lane) {
                Some(place) => *place = tip,
                None => tips.push(tip),
            }
        }
    }
    Ok(())
}

impl Batch {
    /// The layout that all commands of a group share; `None` where they differ in more than numbers.
    fn common_layout(
        &mut self,
        robot: &Robot,
        commands: &[Command],
        settings: &Settings,
        equilibria: &[Equilibrium],
    ) -> Option<Arc<Layout>> {
        if settings.formulation == Formulation::Printed {
            return None;
        }
        let length = robot.length();
        let mut common: Option<Arc<Layout>> = None;
        for (lane, (command, start)) in commands.iter().zip(equilibria).enumerate() {
            // The pivots of a tangent that is not symmetric prove nothing.
            if !start.status.is_equilibrium() || !command.loads.is_conservative() {
                return None;
            }
            self.drives[lane].clone_from(&command.actuators);
            hold_locked(&mut self.drives[lane], settings);
            self.cuts.clear();
            self.cuts.extend(command.loads.cuts().map(Cut::fixed));
            for (f, actuator) in command.actuators.iter().enumerate() {
                match actuator.push_pull {
                    Drive::Motion(motion) if has_edge(robot, f, motion) => {
                        self.cuts.push(Cut::edge(f + 1, edge_estimate(motion, length)));
                    }
                    // Whether there is an edge turns out in the solve.
                    Drive::Effort(_) if !robot.fields[f + 1].smooth_at_plate() => return None,
                    _ => {}
                }
            }
            let cuts = self.cuts.iter().copied();
            let layout = self.lanes.layouts.get(robot.tube_count(), length, settings.resolution, cuts);
            let alike = common.as_ref().is_none_or(|other| Arc::ptr_eq(other, &layout))
                && command.knob == commands[0].knob
                && same_kinds(&command.loads, &commands[0].loads)
                && command.actuators.iter().zip(&commands[0].actuators).all(|(a, b)| {
                    a.push_pull.is_motion() == b.push_pull.is_motion()
                        && a.rotation.is_motion() == b.rotation.is_motion()
                });
            if !alike {
                return None;
            }
            common = Some(layout);
        }
        common
    }

    /// Solves a group; returns the lanes that are done and leaves the others' equilibria as they were.
    fn group(
        &mut self,
        robot: &Robot,
        commands: &[Command],
        settings: &Settings,
        equilibria: &mut [Equilibrium],
        layout: &Arc<Layout>,
        tips: &mut Vec<(Matrix3<f64>, Vector3<f64>)>,
    ) -> u64 {
        let last = commands.len() - 1;
        let of = |lane: usize| lane.min(last);
        let held = self.lanes.assembly.robot() == robot.serial;
        let known = held
            && self.marks.iter().enumerate().all(|(lane, &mark)| {
                let start = &equilibria[of(lane)];
                let command = &commands[of(lane)];
                mark != 0
                    && mark == start.mark
                    && start.settings == *settings
                    && start.command.knob == command.knob
                    && start.command.loads == command.loads
                    && Arc::ptr_eq(&start.layout, layout)
                    && start.drives.iter().zip(&self.drives[of(lane)]).all(|(old, new)| old.is_held_like(new))
            });
        self.begin(robot, commands, equilibria, layout, known);
        let drives = std::mem::take(&mut self.drives);
        let system = System {
            robot,
            layout,
            loads: Each(from_fn(|lane| &commands[of(lane)].loads)),
            knob: commands[0].knob,
            actuators: Each(from_fn(|lane| &drives[of(lane)][..])),
            formulation: settings.formulation,
        };
        let before = self.lanes.evaluations;
        let (solved, steps) = self.newton(&system, settings, known);
        let evaluations = self.lanes.evaluations - before;
        self.marks = [0; WIDTH];
        if solved != 0 {
            self.lanes.pose(robot, layout);
        }
        let tip = self.lanes.poses.rotation.len().saturating_sub(1);
        for (lane, (command, equilibrium)) in commands.iter().zip(equilibria).enumerate() {
            if solved == 0 {
                break;
            }
            let poses = &self.lanes.poses;
            tips.push((poses.rotation[tip].map(|r| r.lane(lane)), poses.centre[tip].map(|c| c.lane(lane))));
            if solved >> lane & 1 == 0 {
                continue;
            }
            equilibrium.take_lane(&self.lanes, &self.point, lane, layout);
            self.marks[lane] = equilibrium.mark;
            equilibrium.status = Status::Converged;
            equilibrium.drives.clone_from(&drives[lane]);
            equilibrium.command.copy(command);
            equilibrium.settings = *settings;
            equilibrium.statistics = Statistics { iterations: steps[lane], evaluations, load_steps: 0 };
        }
        for lane in last + 1..WIDTH {
            self.marks[lane] = self.marks[last];
        }
        self.drives = drives;
        solved
    }

    /// Puts the starts side by side.
    fn begin(
        &mut self,
        robot: &Robot,
        commands: &[Command],
        equilibria: &[Equilibrium],
        layout: &Arc<Layout>,
        known: bool,
    ) {
        if known {
            return;
        }
        if self.point.coordinates.len() != layout.unknowns()
            || self.point.efforts.tension.len() != layout.tubes - 1
            || self.point.efforts.edge.len() != layout.edges.len()
        {
            self.point = Point::rest(layout);
        }
        for lane in 0..WIDTH {
            let index = lane.min(commands.len() - 1);
            let (start, drives) = (&equilibria[index], &self.drives[index]);
            let estimate =
                |f: usize| edge_estimate(commands[index].actuators[f].push_pull.value(), robot.length());
            let moved;
            let from = if Arc::ptr_eq(&start.layout, layout) {
                &start.point
            } else {
                moved = carried(&start.point, &start.layout, layout, estimate);
                &moved
            };
            let put = |all: &mut [Lanes], own: &[f64]| {
                for (all, own) in all.iter_mut().zip(own) {
                    *all = Lanes::from_lanes(|l| if l == lane { *own } else { all.lane(l) });
                }
            };
            put(&mut self.point.coordinates, &from.coordinates);
            put(&mut self.point.efforts.tension, &from.efforts.tension);
            put(&mut self.point.efforts.torque, &from.efforts.torque);
            put(&mut self.point.efforts.edge, &from.efforts.edge);
            for (i, follower) in layout.edges.iter().enumerate() {
                put(&mut self.point.coordinates[i..=i], &[estimate(follower - 1)]);
            }
            for (f, actuator) in drives.iter().enumerate() {
                if let Drive::Effort(force) = actuator.push_pull {
                    put(&mut self.point.efforts.tension[f..=f], &[force]);
                }
                if let Drive::Effort(torque) = actuator.rotation {
                    put(&mut self.point.efforts.torque[f..=f], &[torque]);
                }
            }
        }
    }

    /// Newton's method with full steps in all lanes. Returns the lanes that ended at a stable equilibrium, and the steps
    /// that each took. A lane that has arrived stays where it is.
    fn newton(&mut self, system: &System, settings: &Settings, known: bool) -> (u64, [usize; WIDTH]) {
        let Self { lanes, point, trial, step, correction, .. } = self;
        let mut steps = [0; WIDTH];
        let all = every::<Lanes>();
        let mut lost = 0;
        if known {
            lanes.compose(system);
        } else {
            lost |= lanes.evaluate_consistent(system, point);
        }
        let n_u = system.layout.unknowns();
        for turn in 0..=MOST_STEPS {
            let mut waiting = 0;
            for residual in &lanes.residual {
                waiting |= residual.unless(|r| r.abs() <= settings.tolerance);
            }
            waiting &= !lost;
            if waiting == 0 {
                break;
            }
            if turn == MOST_STEPS || lost == all {
                lost |= waiting;
                break;
            }
            lost |= waiting & !lanes.factor_in_order(system);
            step.clear();
            step.extend(lanes.residual.iter().map(|r| -*r));
            lanes.solve(step, 1);
            let length = norm(step);
            let largest = step[..n_u]
                .iter()
                .fold(Lanes::splat(0.0), |most, s| Lanes::from_lanes(|l| most.lane(l).max(s.lane(l).abs())));
            lost |= waiting & largest.unless(|s| s < LONGEST);
            let moves = waiting & !lost;
            let factor = Lanes::from_lanes(|l| if moves >> l & 1 == 1 { 1.0 } else { 0.0 });
            for s in step.iter_mut() {
                *s = Lanes::from_lanes(|l| if moves >> l & 1 == 1 { s.lane(l) } else { 0.0 });
            }
            trial.copy(point);
            add_step(system, trial, &lanes.units, step, factor);
            lost |= moves & lanes.evaluate_consistent(system, trial);
            correction.clear();
            correction.extend_from_slice(&lanes.residual);
            lanes.solve(correction, 1);
            let shorter = norm(correction);
            // As a single solve accepts a full step.
            let grows = Lanes::from_lanes(|l| shorter.lane(l) / length.lane(l)).unless(|r| r <= 0.75);
            lost |= moves & grows;
            for (l, steps) in steps.iter_mut().enumerate() {
                *steps += usize::from(moves >> l & 1 == 1);
            }
            std::mem::swap(point, trial);
        }
        let mut solved = all & !lost;
        if solved != 0 {
            solved &= lanes.factor_in_order(system);
        }
        let length = system.robot.length();
        for knob in &lanes.assembly.knobs {
            solved &= knob[0].mask(|motion| motion.abs() < length);
        }
        (solved, steps)
    }
}

fn norm(v: &[Lanes]) -> Lanes {
    v.iter().fold(Lanes::splat(0.0), |sum, x| sum + *x * *x).map(f64::sqrt)
}

/// Do loads differ in numbers only?
fn same_kinds(a: &Loads, b: &Loads) -> bool {
    a.wrenches.len() == b.wrenches.len()
        && a.wrenches.iter().zip(&b.wrenches).all(|(a, b)| a.station == b.station && a.frame == b.frame)
        && a.distributed.len() == b.distributed.len()
        && a.distributed
            .iter()
            .zip(&b.distributed)
            .all(|(a, b)| (a.from - b.from).abs() <= 0.0 && (a.to - b.to).abs() <= 0.0)
        && a.gravity.is_some() == b.gravity.is_some()
        && a.threads.len() == b.threads.len()
}
