//! Many commands of one robot, several side by side.
//!
//! Commands that ask for the same unknowns (the same kinds of drives and loads, the same tubes pushed) are solved in the
//! lanes of vector registers, [`WIDTH`] at a time, by the same code as a single one. A lane in which Newton's method would
//! need more than full steps, or that is not clearly stable, is solved once more alone, so that a result does not depend
//! on its neighbours.

use super::lane::{Derived, Lane};
use crate::design::Robot;
use crate::kinematics::TipPose;
use crate::kinematics::layout::{Cut, Layout};
use crate::real::{Each, Pack, Real, every};
use crate::solve::acceptance::{
    MOST_REUSES, arrived, expected_ratio, keeps, longest_part, promises, shrinks,
};
use crate::solve::constraint;
use crate::solve::edges::{carried, edge_estimate, has_edge};
use crate::solve::system::{Buffers, Point, System, add_step};
use crate::solve::{
    Actuator, Command, CommandProblem, Drive, Equilibrium, Formulation, Settings, Solver, Statistics, Status,
};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// How many commands are solved side by side.
pub const WIDTH: usize = Lanes::LANES;

pub(super) type Lanes = Pack;

/// Full Newton steps of one group; a lane that needs more is solved alone.
const MOST_STEPS: usize = 12;

/// Fewer commands than this are solved faster one by one.
pub(super) const LEAST: usize = 3;

/// A solver of many commands at a time, with every buffer that this takes.
#[derive(Clone, Debug)]
pub struct Batch {
    pub(super) solver: Solver,
    side: SideBySide,
}

/// What solving side by side takes.
#[derive(Clone, Debug, Default)]
struct SideBySide {
    lanes: Buffers<Lanes>,
    point: Point<Lanes>,
    trial: Point<Lanes>,
    step: Vec<Lanes>,
    correction: Vec<Lanes>,
    drives: [Vec<Actuator>; WIDTH],
    layouts: [Option<Arc<Layout>>; WIDTH],
    cuts: Vec<Cut>,
    /// Marks of the equilibria that `lanes` evaluated last.
    marks: [u64; WIDTH],
    derived: Derived,
}

impl Batch {
    /// Solves what a solver solves.
    #[must_use]
    pub fn new(solver: Solver) -> Self {
        Self { solver, side: SideBySide::default() }
    }

    /// The solver of single commands, to change what is solved or to derive more of an equilibrium.
    pub fn solver(&mut self) -> &mut Solver {
        &mut self.solver
    }

    /// Solves for the equilibria under many commands, each starting at the equilibrium that stands in its place: at rest, or
    /// at a neighbour. Gives the poses of the tips in their order, or why a command cannot be asked: its equilibrium is then left
    /// as it was. What a tip without equilibrium holds means nothing.
    ///
    /// Neighbours in the list are solved side by side, as far as they ask for the same kinds of drives and loads. Where one
    /// list is longer than the other, its rest is left as it is.
    pub fn solve(
        &mut self,
        commands: &[Command],
        equilibria: &mut [Equilibrium],
        tips: &mut Vec<Result<TipPose, CommandProblem>>,
    ) {
        let Self { solver, side } = self;
        tips.clear();
        let count = commands.len().min(equilibria.len());
        let (commands, equilibria) = (&commands[..count], &mut equilibria[..count]);
        for (commands, equilibria) in commands.chunks(WIDTH).zip(equilibria.chunks_mut(WIDTH)) {
            let first = tips.len();
            let unknown = TipPose { rotation: Matrix3::zeros(), centre: Vector3::zeros() };
            tips.extend(commands.iter().map(|command| solver.check(command).map(|()| unknown)));
            let tips = &mut tips[first..];
            let asked =
                tips.iter().enumerate().fold(0, |asked, (i, tip)| asked | u64::from(tip.is_ok()) << i);
            side.lay_out(solver, commands, equilibria, asked);
            let (mut left, mut alone) = (asked, 0);
            while left != 0 {
                let alike = side.alike(commands, left);
                left &= !alike;
                alone |= alike;
                if alike.count_ones() as usize >= LEAST {
                    alone &= !side.group(solver, commands, equilibria, alike, tips);
                }
            }
            for (i, (command, equilibrium)) in commands.iter().zip(equilibria).enumerate() {
                if alone >> i & 1 == 1 {
                    tips[i] = solver.solve_into(command, equilibrium).map(|()| solver.tip(equilibrium));
                }
            }
        }
    }

    /// What derives more of an equilibrium solved last: the solver and, where it was solved in one, its lane.
    pub(super) fn lane_of(&mut self, mark: u64) -> (&mut Solver, Option<Lane<'_>>) {
        let SideBySide { lanes, point, marks, derived, .. } = &mut self.side;
        if derived.marks != *marks {
            *derived = Derived::of(*marks);
        }
        let lane = marks.iter().position(|own| *own == mark && mark != 0);
        (&mut self.solver, lane.map(|index| Lane { index, buffers: lanes, point, derived }))
    }
}

impl SideBySide {
    /// Finds the layouts and drives of those commands that can be solved side by side with others.
    fn lay_out(&mut self, solver: &mut Solver, commands: &[Command], equilibria: &[Equilibrium], asked: u64) {
        self.layouts = Default::default();
        let Solver { robot, settings, buffers, .. } = solver;
        for (i, (command, start)) in commands.iter().zip(equilibria).enumerate() {
            let fits = start.robot.tube_count() == robot.tube_count() && start.status.is_equilibrium();
            if asked >> i & 1 == 0 || !fits || !goes_side_by_side(command, settings) {
                continue;
            }
            constraint::drives(robot, command, settings, 0, &mut self.drives[i]);
            self.cuts.clear();
            self.cuts.extend(command.loads.cuts().map(Cut::fixed));
            for f in 0..command.actuators.len() {
                let motion = expected(command, start, f);
                if has_edge(robot, f, motion) {
                    self.cuts.push(Cut::edge(f + 1, edge_estimate(motion, robot.length())));
                }
            }
            let cuts = self.cuts.iter().copied();
            self.layouts[i] =
                Some(buffers.layouts.get(robot.tube_count(), robot.length(), settings.resolution, cuts));
        }
    }

    /// The first of the commands that are left, and all that differ from it in numbers only.
    fn alike(&self, commands: &[Command], left: u64) -> u64 {
        let first = left.trailing_zeros() as usize;
        let mut alike = 1 << first;
        if let Some(layout) = &self.layouts[first] {
            for i in first + 1..commands.len() {
                let same_layout = self.layouts[i].as_ref().is_some_and(|own| Arc::ptr_eq(own, layout));
                if left >> i & 1 == 1 && same_layout && same_kind(&commands[i], &commands[first]) {
                    alike |= 1 << i;
                }
            }
        }
        alike
    }

    /// Solves the commands in `members`, which are alike; returns those that are done and leaves the others' equilibria
    /// as they were.
    fn group(
        &mut self,
        solver: &Solver,
        commands: &[Command],
        equilibria: &mut [Equilibrium],
        members: u64,
        tips: &mut [Result<TipPose, CommandProblem>],
    ) -> u64 {
        let Solver { robot, settings, .. } = solver;
        // Lanes beyond the last member repeat it.
        let mut of = [0; WIDTH];
        let mut count = 0;
        for i in (0..commands.len()).filter(|i| members >> i & 1 == 1) {
            of[count..].fill(i);
            count += 1;
        }
        let Some(layout) = self.layouts[of[0]].take() else { return 0 };
        let evaluated = self.marks.iter().zip(of).all(|(&mark, i)| {
            let (start, command) = (&equilibria[i], &commands[i]);
            mark != 0
                && mark == start.mark
                && start.robot.serial() == robot.serial()
                && start.settings == *settings
                && start.command.rotation_means == command.rotation_means
                && start.command.loads == command.loads
                && Arc::ptr_eq(&start.layout, &layout)
                && start.drives.iter().zip(&self.drives[i]).all(|(old, new)| old.is_held_like(new))
        });
        self.begin(robot, commands, equilibria, &layout, of, evaluated);
        let drives = std::mem::take(&mut self.drives);
        let system = System {
            robot,
            layout: &layout,
            loads: Each(of.map(|i| &commands[i].loads)),
            rotation_means: commands[of[0]].rotation_means,
            actuators: Each(of.map(|i| &drives[i][..])),
            formulation: settings.formulation,
        };
        let before = self.lanes.evaluations;
        let (solved, steps) = self.newton(&system, settings, evaluated);
        let evaluations = self.lanes.evaluations - before;
        self.marks = [0; WIDTH];
        if solved != 0 {
            self.lanes.pose(robot, &layout);
        }
        let mut done = 0;
        for (lane, &i) in of[..count].iter().enumerate() {
            if solved >> lane & 1 == 0 {
                continue;
            }
            let equilibrium = &mut equilibria[i];
            equilibrium.take_lane(&self.lanes, &self.point, lane, &layout);
            self.marks[lane..].fill(equilibrium.mark);
            equilibrium.status = Status::Converged;
            equilibrium.drives.clone_from(&drives[i]);
            equilibrium.command.copy(&commands[i]);
            equilibrium.settings = *settings;
            equilibrium.belong_to(robot);
            equilibrium.statistics = Statistics { iterations: steps[lane], evaluations, load_steps: 0 };
            tips[i] = Ok(self.lanes.poses.tip_of(lane));
            done |= 1 << i;
        }
        self.drives = drives;
        done
    }

    /// Puts the starts side by side.
    fn begin(
        &mut self,
        robot: &Robot,
        commands: &[Command],
        equilibria: &[Equilibrium],
        layout: &Arc<Layout>,
        of: [usize; WIDTH],
        evaluated: bool,
    ) {
        if evaluated {
            return;
        }
        if self.point.coordinates.len() != layout.unknowns()
            || self.point.efforts.tension.len() != layout.tubes - 1
            || self.point.efforts.edge.len() != layout.edges.len()
        {
            self.point = Point::rest(layout);
        }
        for (lane, i) in of.into_iter().enumerate() {
            let (start, drives) = (&equilibria[i], &self.drives[i]);
            let estimate = |f: usize| edge_estimate(expected(&commands[i], start, f), robot.length());
            let moved;
            let from = if Arc::ptr_eq(&start.layout, layout) {
                &start.point
            } else {
                moved = carried(&start.point, &start.layout, layout, estimate);
                &moved
            };
            let put = |all: &mut [Lanes], own: &[f64]| {
                for (all, own) in all.iter_mut().zip(own) {
                    *all = Lanes::splat(*own).in_lanes(1 << lane, *all);
                }
            };
            put(&mut self.point.coordinates, &from.coordinates);
            put(&mut self.point.efforts.tension, &from.efforts.tension);
            put(&mut self.point.efforts.torque, &from.efforts.torque);
            put(&mut self.point.efforts.edge, &from.efforts.edge);
            for (e, follower) in layout.edges.iter().enumerate() {
                if drives[follower - 1].push_pull.is_motion() {
                    put(&mut self.point.coordinates[e..=e], &[estimate(follower - 1)]);
                }
            }
        }
        constraint::prescribe::<Lanes>(&Each(of.map(|i| &self.drives[i][..])), &mut self.point.efforts);
    }

    /// Newton's method with full steps in all lanes. Returns the lanes that ended at a stable equilibrium, and the steps
    /// that each took. A lane that has arrived stays where it is.
    fn newton(&mut self, system: &System, settings: &Settings, evaluated: bool) -> (u64, [usize; WIDTH]) {
        let Self { lanes, point, trial, step, correction, .. } = self;
        let mut steps = [0; WIDTH];
        let all = every::<Lanes>();
        let mut lost = 0;
        if evaluated {
            lanes.compose_residual(system);
        } else {
            lost |= lanes.evaluate_consistent(system, point);
        }
        let n_u = system.layout.unknowns();
        // How far the last tangent saw the equilibrium.
        let (mut distance, mut done) = (Lanes::splat(0.0), 0);
        for turn in 0..=MOST_STEPS {
            let before = largest(&lanes.residual);
            // A lane that has arrived stays so, whatever its neighbours' tangents see of it.
            done |= arrived(before, distance, settings.tolerance);
            let waiting = all & !done & !lost;
            if waiting == 0 {
                break;
            }
            if turn == MOST_STEPS {
                lost |= waiting;
                break;
            }
            lost |= waiting & !lanes.ensure_in_order(system);
            step.clear();
            step.extend(lanes.residual.iter().map(|r| -*r));
            lanes.solve(step, 1);
            let length = norm(step);
            let whole = longest_part(largest(&step[..n_u])).mask(|part| part >= 1.0);
            lost |= waiting & !(whole & length.mask(f64::is_finite));
            let moves = waiting & !lost;
            trial.copy(point);
            advance(system, trial, &lanes.units, step, moves, 1.0);
            lost |= moves & lanes.evaluate_residual(system, trial);
            lanes.correct(correction);
            distance = norm(correction);
            // As a single solve accepts a full step.
            lost |= moves & !shrinks(distance, length, 1.0);
            count(&mut steps, moves);
            // The same tangent again, in each lane as in a single solve.
            let mut reached = largest(&lanes.residual);
            let mut ratio = expected_ratio(reached, before);
            let mut reuses = moves;
            for left in (1..=MOST_REUSES).rev() {
                reuses &= !lost & !arrived(reached, distance, settings.tolerance);
                reuses &= promises(reached, distance, ratio, left, settings.tolerance);
                if reuses == 0 {
                    break;
                }
                advance(system, trial, &lanes.units, correction, reuses, -1.0);
                lost |= reuses & lanes.evaluate_residual(system, trial);
                let after = largest(&lanes.residual);
                lost |= reuses & !keeps(after, reached);
                ratio = after / reached;
                lanes.correct(correction);
                (reached, distance) = (after, norm(correction));
                count(&mut steps, reuses);
            }
            if lost == all {
                break;
            }
            lost |= moves & lanes.complete(system, trial);
            std::mem::swap(point, trial);
        }
        let mut solved = all & !lost;
        if solved != 0 {
            solved &= lanes.ensure_in_order(system);
        }
        let length = system.robot.length();
        for (f, (motions, actuator)) in
            lanes.assembly.motions.iter().zip(system.actuators.first()).enumerate()
        {
            solved &= motions[0].mask(|motion| motion.abs() < length);
            if !actuator.push_pull.is_motion() {
                // Its edge has to be where the layout says.
                let inside = system.layout.edges.contains(&(f + 1));
                solved &= motions[0].mask(|motion| has_edge(system.robot, f, motion) == inside);
            }
        }
        (solved, steps)
    }
}

/// Adds `factor` times a step in the lanes that move; the others stay where they are.
fn advance(
    system: &System,
    point: &mut Point<Lanes>,
    units: &[f64],
    step: &mut [Lanes],
    moves: u64,
    factor: f64,
) {
    for s in step.iter_mut() {
        *s = s.in_lanes(moves, Lanes::splat(0.0));
    }
    add_step(system, point, units, step, Lanes::splat(factor));
}

fn count(steps: &mut [usize; WIDTH], moves: u64) {
    for (l, steps) in steps.iter_mut().enumerate() {
        *steps += usize::from(moves >> l & 1 == 1);
    }
}

fn largest(v: &[Lanes]) -> Lanes {
    let zero = Lanes::splat(0.0);
    v.iter().fold(zero, |most, x| Lanes::from_lanes(|l| most.lane(l).max(x.lane(l).abs())))
}

fn norm(v: &[Lanes]) -> Lanes {
    v.iter().fold(Lanes::splat(0.0), |sum, x| sum + *x * *x).map(f64::sqrt)
}

/// Where a follower (0 is the first) will stand, as far as it is evaluated before the solve (m).
fn expected(command: &Command, start: &Equilibrium, follower: usize) -> f64 {
    match command.actuators[follower].push_pull {
        Drive::Motion(motion) => motion,
        Drive::Effort(_) => start.actuators[follower].motion,
    }
}

/// Can a command be solved side by side with others at all?
pub(super) fn goes_side_by_side(command: &Command, settings: &Settings) -> bool {
    // The pivots of a tangent that is not symmetric prove nothing.
    settings.formulation == Formulation::Consistent && command.loads.is_conservative()
}

/// Do commands differ in numbers only, and in which tubes are pushed?
pub(super) fn same_kind(one: &Command, other: &Command) -> bool {
    one.rotation_means == other.rotation_means
        && one.actuators.len() == other.actuators.len()
        && one.actuators.iter().zip(&other.actuators).all(|(a, b)| {
            a.push_pull.is_motion() == b.push_pull.is_motion()
                && a.rotation.is_motion() == b.rotation.is_motion()
        })
        && one.loads.is_like(&other.loads)
}
