//! Many poses of one robot, whatever is asked: sorted into lanes, each from its neighbour or from rest.
//!
//! Poses of one kind (the same drives and loads, the same tubes pushed) are cut into as many strands as there are lanes. The
//! strands go on side by side, each from its own last pose, so that every lane moves to a neighbour. What comes out of a
//! pose depends on the list of poses alone.

use super::batch::{Batch, LEAST, WIDTH, goes_side_by_side, same_kind};
use super::lane::Lane;
use crate::analysis::demand::Scale;
use crate::analysis::{Teeth, Utilisation};
use crate::design::Robot;
use crate::kinematics::TipPose;
use crate::solve::edges::has_edge;
use crate::solve::{Command, CommandProblem, Equilibrium, Solver, Status};
use nalgebra::Vector3;
use std::ops::ControlFlow;

/// Where every pose of many starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At rest: no pose depends on another.
    Rest,
    /// At the pose before it where that is near: where what changes would bend or turn the robot by less than 0.35 rad, were it to answer as at rest. At rest where it
    /// is not, where that finds no stable equilibrium, and where the tip has moved farther than a bend by so much moves it. Several times as fast.
    Neighbour,
}

/// How far poses are apart at most that are near (rad).
const NEAR: f64 = 0.35;

/// A pose that was solved. Look at the status of the equilibrium first.
#[derive(Debug)]
pub struct Solved<'a> {
    /// The equilibrium, or the last iterate.
    pub equilibrium: &'a Equilibrium,
    /// Pose of the tip.
    pub tip: TipPose,
    /// Derives more from the equilibrium.
    pub solver: &'a mut Solver,
    lane: Option<Lane<'a>>,
}

impl Solved<'_> {
    /// What [`Solver::margin`] gives, computed in all lanes at once.
    pub fn margin(&mut self) -> Option<f64> {
        let in_lane = self.lane.as_mut().and_then(|lane| lane.margin(self.equilibrium));
        in_lane.or_else(|| self.solver.margin(self.equilibrium))
    }

    /// What [`Solver::utilisation`] gives, computed in all lanes at once.
    pub fn utilisation(&mut self, teeth: Teeth) -> Utilisation {
        match &mut self.lane {
            Some(lane) => lane.utilisation(self.equilibrium, teeth),
            None => self.solver.utilisation(self.equilibrium, teeth),
        }
    }
}

/// A solver of many poses, with every buffer that this takes.
#[derive(Clone, Debug)]
pub struct March {
    batch: Batch,
    commands: Vec<Command>,
    lanes: Vec<Equilibrium>,
    tips: Vec<Result<TipPose, CommandProblem>>,
    kinds: Vec<Alike>,
}

/// Poses that can be solved in lanes together.
#[derive(Clone, Debug)]
struct Alike {
    command: Command,
    edges: u64,
    poses: Vec<usize>,
}

impl March {
    /// Solves what a solver solves.
    #[must_use]
    pub fn new(solver: Solver) -> Self {
        let batch = Batch::new(solver);
        Self { batch, commands: Vec::new(), lanes: Vec::new(), tips: Vec::new(), kinds: Vec::new() }
    }

    /// The solver of single commands, to change what is solved.
    pub fn solver(&mut self) -> &mut Solver {
        self.batch.solver()
    }

    /// Solves `count` poses one after another on the calling thread, side by side where they are of one kind. `put` puts what
    /// varies into a command that is a copy of the common one, or of an earlier pose; `read` takes every pose once, in an order
    /// of the solver's own, and ends the march by breaking.
    pub fn run<B>(
        &mut self,
        base: &Command,
        start: Start,
        count: usize,
        mut put: impl FnMut(usize, &mut Command),
        mut read: impl FnMut(usize, Result<Solved<'_>, CommandProblem>) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        self.sort(base, count, &mut put);
        let rest = self.batch.solver.rest();
        self.commands.resize_with(WIDTH, || base.clone());
        self.commands.iter_mut().for_each(|command| command.copy(base));
        self.lanes.resize_with(WIDTH, || rest.clone());
        let kinds = std::mem::take(&mut self.kinds);
        let scale = Scale::of(&self.batch.solver.robot);
        let mut before = base.clone();
        for Alike { command, poses, .. } in &kinds {
            let few = poses.len() < LEAST || !goes_side_by_side(command, &self.batch.solver.settings);
            // One by one, neighbours in time are neighbours in place: the buffers still knows the last.
            let strands = if few { 1 } else { poses.len().min(WIDTH) };
            let (length, longer) = (poses.len() / strands, poses.len() % strands);
            // Tips of the poses before, and how far they are from those that are solved.
            let (mut warm, mut near) = ([None; WIDTH], [None; WIDTH]);
            for turn in 0..poses.len().div_ceil(strands) {
                // The longer strands come first.
                let active = if turn < length { strands } else { longer };
                let pose = |lane: usize| match start {
                    Start::Neighbour => poses[lane * length + lane.min(longer) + turn],
                    // Alike in size, and so in steps.
                    Start::Rest => poses[turn * strands + lane],
                };
                for lane in 0..active {
                    let own = &mut self.commands[lane];
                    before.copy(own);
                    put(pose(lane), own);
                    near[lane] = warm[lane].map(|tip| (tip, scale.change(&before, own)));
                    near[lane] = near[lane].filter(|(_, change)| *change < NEAR);
                    if near[lane].is_none() {
                        self.lanes[lane].copy(&rest);
                    }
                }
                self.turn(active, &near);
                for lane in 0..active {
                    let equilibrium = &self.lanes[lane];
                    let solved = match &self.tips[lane] {
                        Ok(tip) => {
                            let goes_on =
                                start == Start::Neighbour && equilibrium.status == Status::Converged;
                            warm[lane] = goes_on.then_some(tip.centre);
                            let (solver, lane) = self.batch.lane_of(equilibrium.mark);
                            Ok(Solved { equilibrium, tip: *tip, solver, lane })
                        }
                        // The neighbour stays: it has not been touched.
                        Err(problem) => Err(problem.clone()),
                    };
                    read(pose(lane), solved)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Sorts poses by kind, each kind in the order of the poses.
    fn sort(&mut self, base: &Command, count: usize, put: &mut impl FnMut(usize, &mut Command)) {
        self.kinds.clear();
        let robot = self.batch.solver.robot.clone();
        let mut command = base.clone();
        for pose in 0..count {
            put(pose, &mut command);
            let edges = edges(&robot, &command);
            match self.kinds.iter_mut().find(|k| k.edges == edges && same_kind(&k.command, &command)) {
                Some(kind) => kind.poses.push(pose),
                None => self.kinds.push(Alike { command: command.clone(), edges, poses: vec![pose] }),
            }
        }
    }

    /// One turn: the first commands from the equilibria that stand in their lanes: `near` has the tips of those that are neighbours, and how far these are (rad).
    fn turn(&mut self, count: usize, near: &[Option<(Vector3<f64>, f64)>; WIDTH]) {
        let lanes = &mut self.lanes[..count];
        self.batch.solve(&self.commands[..count], lanes, &mut self.tips);
        for (lane, (equilibrium, tip)) in lanes.iter_mut().zip(&mut self.tips).enumerate() {
            let (Ok(own), Some((before, change))) = (&tip, near[lane]) else { continue };
            // Where the neighbour's branch has turned unstable, ends, or was left with a jump, the robot is on another one.
            let jumps = (own.centre - before).norm() > change * self.batch.solver.robot.length();
            if jumps || equilibrium.status != Status::Converged {
                let solver = &mut self.batch.solver;
                if let Ok(found) = solver.solve(&self.commands[lane])
                    && (jumps || found.status.is_equilibrium())
                {
                    *equilibrium = found;
                    *tip = Ok(solver.tip(equilibrium));
                }
            }
        }
    }
}

/// One bit for each follower whose uncut part is pushed into the robot.
fn edges(robot: &Robot, command: &Command) -> u64 {
    let actuators = command.actuators.iter().take(robot.follower_count()).enumerate();
    actuators.fold(0, |edges, (f, actuator)| {
        let drive = actuator.push_pull;
        edges | u64::from(drive.is_motion() && has_edge(robot, f, drive.value())) << f
    })
}
