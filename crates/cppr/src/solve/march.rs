//! Many poses of one robot, whatever is asked: sorted into lanes, each from its neighbour or from rest.
//!
//! Poses of one kind (the same drives and loads, the same tubes pushed) are cut into as many strands as there are lanes. The
//! strands go on side by side, each from its own last pose, so that every lane moves to a neighbour. What comes out of a
//! pose depends on the list of poses alone.

use super::batch::{Batch, LEAST, Tip, WIDTH, goes_side_by_side, same_kind, solve_batch};
use super::edges::has_edge;
use super::path::solve;
use super::{Command, CommandProblem, Equilibrium, Settings, Status, Workspace};
use crate::analysis::beside::Beside;
use crate::analysis::shape::tip_pose;
use crate::analysis::{Teeth, Utilisation, stability, utilisation};
use crate::design::Robot;
use crate::{Matrix3, Vector3};
use std::ops::ControlFlow;

/// Where every pose of many starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At rest: no pose depends on another.
    Rest,
    /// At the pose before it, which should be near: several times as fast. Where that has no stable equilibrium, or its branch has
    /// become unstable, at rest.
    Neighbour,
}

/// What many poses have in common.
#[derive(Clone, Copy, Debug)]
pub struct Poses<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// How to solve.
    pub settings: &'a Settings,
    /// What does not vary.
    pub base: &'a Command,
    /// Where a pose starts.
    pub start: Start,
}

/// A pose that was solved. Look at the status of the equilibrium first.
#[derive(Debug)]
pub struct Solved<'a> {
    /// The equilibrium, or the last iterate.
    pub equilibrium: &'a Equilibrium,
    /// Rotation of the leader's last section, base frame.
    pub rotation: Matrix3<f64>,
    /// Centre of the leader's last section (m), base frame.
    pub centre: Vector3<f64>,
    /// Buffers for what is derived from the equilibrium.
    pub workspace: &'a mut Workspace,
    robot: &'a Robot,
    beside: Option<Beside<'a>>,
}

impl Solved<'_> {
    /// What [`stability::margin`] gives, computed in all lanes at once.
    pub fn margin(&mut self) -> Option<f64> {
        let beside = self.beside.as_mut().and_then(|b| b.margin(self.robot, self.equilibrium));
        beside.or_else(|| stability::margin(self.robot, self.workspace, self.equilibrium))
    }

    /// What [`utilisation()`] gives, computed in all lanes at once.
    pub fn utilisation(&mut self, teeth: Teeth) -> Utilisation {
        match &mut self.beside {
            Some(beside) => beside.utilisation(self.robot, self.equilibrium, teeth),
            None => utilisation(self.robot, self.workspace, self.equilibrium, teeth),
        }
    }
}

/// Every buffer that a march needs. Reuse it.
#[derive(Clone, Debug, Default)]
pub struct March {
    batch: Batch,
    commands: Vec<Command>,
    lanes: Vec<Equilibrium>,
    tips: Vec<Result<Tip, CommandProblem>>,
    kinds: Vec<Kind>,
}

/// Poses that can go side by side.
#[derive(Clone, Debug)]
struct Kind {
    command: Command,
    edges: u64,
    poses: Vec<usize>,
}

impl March {
    /// Empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sorts poses by kind, each kind in the order of the poses.
    fn sort(&mut self, common: &Poses, count: usize, put: &mut impl FnMut(usize, &mut Command)) {
        self.kinds.clear();
        let mut command = common.base.clone();
        for pose in 0..count {
            put(pose, &mut command);
            let edges = edges(common.robot, &command);
            match self.kinds.iter_mut().find(|k| k.edges == edges && same_kind(&k.command, &command)) {
                Some(kind) => kind.poses.push(pose),
                None => self.kinds.push(Kind { command: command.clone(), edges, poses: vec![pose] }),
            }
        }
    }

    /// One turn: the first commands from the equilibria that stand in their lanes.
    fn turn(&mut self, common: &Poses, count: usize, warm: [bool; WIDTH]) {
        let Poses { robot, settings, .. } = *common;
        let lanes = &mut self.lanes[..count];
        solve_batch(robot, &mut self.batch, &self.commands[..count], settings, lanes, &mut self.tips);
        for (lane, (equilibrium, tip)) in lanes.iter_mut().zip(&mut self.tips).enumerate() {
            // Where the neighbour's branch has turned unstable the robot is on another one.
            if tip.is_ok() && warm[lane] && equilibrium.status == Status::Unstable {
                let single = &mut self.batch.single;
                if let Ok(found) = solve(robot, single, &self.commands[lane], settings)
                    && found.status.is_equilibrium()
                {
                    *equilibrium = found;
                    *tip = Ok(tip_pose(robot, single, equilibrium));
                }
            }
        }
    }
}

/// Solves `count` poses one after another on the calling thread, side by side where they are of one kind. `put` puts what
/// varies into a command that is a copy of the common one, or of an earlier pose; `read` takes every pose once, in an order
/// of the solver's own, and ends the march by breaking.
pub fn march<B>(
    common: &Poses,
    march: &mut March,
    count: usize,
    mut put: impl FnMut(usize, &mut Command),
    mut read: impl FnMut(usize, Result<Solved<'_>, CommandProblem>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let Poses { robot, settings, base, start } = *common;
    march.sort(common, count, &mut put);
    let rest = Equilibrium::at_rest(robot, &mut march.batch.single, settings);
    march.commands.resize_with(WIDTH, || base.clone());
    march.commands.iter_mut().for_each(|command| command.copy(base));
    march.lanes.resize_with(WIDTH, || rest.clone());
    let kinds = std::mem::take(&mut march.kinds);
    for Kind { command, poses, .. } in &kinds {
        let few = poses.len() < LEAST || !goes_side_by_side(command, settings);
        // One by one, neighbours in time are neighbours in place: the workspace still knows the last.
        let strands = if few { 1 } else { poses.len().min(WIDTH) };
        let (length, longer) = (poses.len() / strands, poses.len() % strands);
        let mut warm = [false; WIDTH];
        for turn in 0..poses.len().div_ceil(strands) {
            // The longer strands come first.
            let active = if turn < length { strands } else { longer };
            let pose = |lane: usize| match start {
                Start::Neighbour => poses[lane * length + lane.min(longer) + turn],
                // Alike in size, and so in steps.
                Start::Rest => poses[turn * strands + lane],
            };
            for lane in 0..active {
                put(pose(lane), &mut march.commands[lane]);
                if !warm[lane] {
                    march.lanes[lane].copy(&rest);
                }
            }
            march.turn(common, active, warm);
            for lane in 0..active {
                let equilibrium = &march.lanes[lane];
                let solved = match &march.tips[lane] {
                    Ok((rotation, centre)) => {
                        warm[lane] = start == Start::Neighbour && equilibrium.status == Status::Converged;
                        let (rotation, centre) = (*rotation, *centre);
                        let (workspace, beside) = march.batch.beside(equilibrium.mark);
                        Ok(Solved { equilibrium, rotation, centre, workspace, robot, beside })
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

/// One bit for each follower whose uncut part is pushed into the robot.
fn edges(robot: &Robot, command: &Command) -> u64 {
    let actuators = command.actuators.iter().take(robot.follower_count()).enumerate();
    actuators.fold(0, |edges, (f, actuator)| {
        let drive = actuator.push_pull;
        edges | u64::from(drive.is_motion() && has_edge(robot, f, drive.value())) << f
    })
}
