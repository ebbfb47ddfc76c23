//! How far each actuator may go, from a given state, and what ends its range first.
//!
//! One input is walked away from the given command while all others and the loads stay. Every step starts at the
//! equilibrium before it and is halved until the tip moves by little, so that the walk stays on its branch. The walk ends where
//! a limit is reached (`limits`, and the margin to instability), or where the branch does. The end is then bracketed, and
//! found by regula falsi (Illinois) on the utilisation less one, or by bisection where there is no equilibrium to take it from. A limit that
//! is exceeded for less than a step of the walk and then kept again is not seen.

use super::limits::{Governing, Teeth};
use super::model::Model;
use crate::solve::input::follower_of;
use crate::solve::{Command, CommandProblem, Freedom, Input, Solver, Status};
use nalgebra::Vector3;

/// Why an actuator goes no further.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// A limit is reached.
    Limit(Governing),
    /// No equilibrium was found beyond that continues this one: the robot folds, snaps or collapses, or the solver failed.
    BranchEnds,
    /// Nothing was met as far as the search went: to its end, or over as many equilibria as it looks for.
    Open,
}

/// One end of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeEnd {
    /// Last safe value (m, rad, N or N m).
    pub value: f64,
    /// What lies there.
    pub bound: Bound,
    /// The nearest limit there: how much of it is used where nothing was met.
    pub nearest: Option<Governing>,
}

/// Values that one input may take while everything else stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeRange {
    /// Which input.
    pub input: Input,
    /// Its value in the given command.
    pub start: f64,
    /// Towards lesser values: pushed further, turned left.
    pub low: RangeEnd,
    /// Towards greater values.
    pub high: RangeEnd,
}

/// A state that cannot be the middle of a safe range.
#[derive(Clone, Debug, PartialEq)]
pub enum RangeProblem {
    /// The command cannot be asked of the robot.
    Command(CommandProblem),
    /// There is no stable equilibrium under the command.
    NoEquilibrium(Status),
    /// A limit is exceeded there already.
    Exceeded(Box<Governing>),
    /// [`Solver::stop_by`].
    Stopped,
}

impl std::fmt::Display for RangeProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Command(problem) => problem.fmt(f),
            Self::NoEquilibrium(status) => status.fmt(f),
            Self::Exceeded(nearest) => {
                write!(f, "a limit is exceeded already: {:.1} % of it are used", 100.0 * nearest.utilisation)
            }
            Self::Stopped => write!(f, "stopped before the ranges were known"),
        }
    }
}

impl std::error::Error for RangeProblem {}

/// First and longest step of a walk along one input, parts of its extent.
const INPUT: [f64; 2] = [1.0 / 200.0, 1.0 / 40.0];
/// The same along a whole command.
const WHOLE: [f64; 2] = [1.0 / 20.0, 1.0 / 6.0];
/// Part of the extent to which an end is found.
const SHARP: f64 = 1e-9;
/// Equilibria that one walk looks for at most.
const MOST: u32 = 1000;
/// Bisection and halving of steps stop here.
const SHORTEST: f64 = 1e-6;
/// The tip moves by at most this part of the length in one step.
const NEAR: f64 = 0.05;
impl Solver {
    /// Safe ranges of all inputs about a command that can move, push-pull and rotation of tube 2, then of tube 3, …
    ///
    /// # Errors
    /// Where the command itself is not safe, and where the search was stopped.
    pub fn safe_ranges(&mut self, command: &Command, teeth: Teeth) -> Result<Vec<SafeRange>, RangeProblem> {
        let start = self.solve(command).map_err(RangeProblem::Command)?;
        if start.status != Status::Converged {
            return Err(RangeProblem::NoEquilibrium(start.status));
        }
        let moves = |input: Input| match input.freedom {
            Freedom::Rotation => self.settings.resolution.angle > 0,
            Freedom::PushPull => {
                !input.is_motion
                    || follower_of(input.tube).is_some_and(|f| self.settings.can_slide(&self.robot, f))
            }
        };
        let inputs: Vec<Input> = command.inputs().map(|(input, _)| input).filter(|i| moves(*i)).collect();
        safe_ranges(self, command, start, &inputs, teeth)
    }

    /// How much of a command a robot can follow, applied from rest in small steps, all of it in proportion: the greatest part in
    /// [0, 1] up to which every limit is kept. At 0 it is at rest, which no limit forbids.
    ///
    /// # Errors
    /// Where the command cannot be asked of the robot, and where the search was stopped.
    pub fn safe_part(&mut self, command: &Command, teeth: Teeth) -> Result<RangeEnd, RangeProblem> {
        self.check(command).map_err(RangeProblem::Command)?;
        let rest = self.solve(&command.scaled(0.0)).map_err(RangeProblem::Command)?;
        safe_part(self, rest, teeth, &|part| command.scaled(part))
    }
}

/// Safe ranges of some inputs about a stable equilibrium.
pub(super) fn safe_ranges<M: Model>(
    model: &mut M,
    command: &M::Command,
    start: M::Found,
    inputs: &[Input],
    teeth: Teeth,
) -> Result<Vec<SafeRange>, RangeProblem> {
    let mut walk = Walk { model, teeth, steps: INPUT };
    let start = walk.state(start);
    if let Some(nearest) = start.nearest
        && nearest.utilisation >= 1.0
    {
        return Err(RangeProblem::Exceeded(Box::new(nearest)));
    }
    let mut ranges = Vec::new();
    for &input in inputs {
        let [low, high] = [-1.0, 1.0].map(|side| walk.end_of_input(command, &start, input, side));
        if walk.model.is_stopped() {
            return Err(RangeProblem::Stopped);
        }
        let value = M::value(command, input).unwrap_or_default();
        ranges.push(SafeRange { input, start: value, low, high });
    }
    Ok(ranges)
}

/// The greatest part in [0, 1] of a command, from rest, up to which every limit is kept.
pub(super) fn safe_part<M: Model>(
    model: &mut M,
    rest: M::Found,
    teeth: Teeth,
    command: &dyn Fn(f64) -> M::Command,
) -> Result<RangeEnd, RangeProblem> {
    let mut walk = Walk { model, teeth, steps: WHOLE };
    let start = walk.state(rest);
    let end = walk.end(&start, command, [0.0, 1.0], 1.0);
    if walk.model.is_stopped() { Err(RangeProblem::Stopped) } else { Ok(end) }
}

/// An equilibrium with what a walk wants to know of it.
#[derive(Clone)]
struct State<F> {
    found: F,
    tip: Vector3<f64>,
    nearest: Option<Governing>,
}

impl<F> State<F> {
    /// Utilisation less one: negative where the state is safe.
    fn excess(&self) -> f64 {
        self.nearest.map_or(-1.0, |g| g.utilisation - 1.0)
    }
}

struct Walk<'a, M> {
    model: &'a mut M,
    teeth: Teeth,
    /// First and longest step, parts of the extent.
    steps: [f64; 2],
}

impl<M: Model> Walk<'_, M> {
    fn state(&mut self, found: M::Found) -> State<M::Found> {
        let nearest = self.model.nearest_limit(&found, self.teeth);
        State { nearest, tip: self.model.tip(&found).centre, found }
    }

    /// The state under a command, if it continues the one given.
    fn next(&mut self, from: &State<M::Found>, command: &M::Command) -> Option<State<M::Found>> {
        if self.model.is_stopped() {
            return None;
        }
        let found = self.model.continued(command, &from.found)?;
        let state = self.state(found);
        ((state.tip - from.tip).norm() <= NEAR * self.model.length()).then_some(state)
    }

    fn end_of_input(
        &mut self,
        command: &M::Command,
        start: &State<M::Found>,
        input: Input,
        side: f64,
    ) -> RangeEnd {
        let extent = self.model.extent(input);
        let first = M::value(command, input).unwrap_or_default();
        // A follower stays within its stroke, wherever it started.
        let last = if input.freedom == Freedom::PushPull && input.is_motion {
            side * extent
        } else {
            first + side * extent
        };
        self.end(start, &|value| M::with_input(command, input, value), [first, last], side * extent)
    }

    /// Walks from the first value, where `start` is, to the last; `reach` gives the steps their size and side.
    fn end(
        &mut self,
        start: &State<M::Found>,
        command: &dyn Fn(f64) -> M::Command,
        [first, last]: [f64; 2],
        reach: f64,
    ) -> RangeEnd {
        let (side, extent) = (reach.signum(), reach.abs());
        let mut here = start.clone();
        let [mut step, longest] = self.steps.map(|part| part * extent);
        let mut at = first;
        for _ in 0..MOST {
            if side * (last - at) <= 0.0 {
                break;
            }
            let to = at + side * step.min(side * (last - at));
            match self.next(&here, &command(to)) {
                Some(state) if state.excess() < 0.0 => {
                    // As far as the tip may move, at its present speed.
                    let speed = (state.tip - here.tip).norm() / (to - at).abs();
                    let near = 0.8 * NEAR * self.model.length() / speed;
                    step = (1.5 * step).min(longest).min(near.max(SHORTEST * extent));
                    (here, at) = (state, to);
                }
                Some(state) => return self.refine(here, (at, to), state.excess(), command, SHARP * extent),
                None if step > SHORTEST * extent => step *= 0.5,
                None => return RangeEnd { value: at, bound: Bound::BranchEnds, nearest: here.nearest },
            }
        }
        RangeEnd { value: at, bound: Bound::Open, nearest: here.nearest }
    }

    /// The crossing of a limit between a safe value and one with the given excess.
    fn refine(
        &mut self,
        safe: State<M::Found>,
        (mut low, mut high): (f64, f64),
        mut above: f64,
        command: &dyn Fn(f64) -> M::Command,
        sharp: f64,
    ) -> RangeEnd {
        let mut here = safe;
        let mut below = here.excess();
        let mut nearest = here.nearest;
        // Which end moved last.
        let mut moved = None;
        while (high - low).abs() > sharp && here.excess() < -SHARP {
            let share = (below / (below - above)).clamp(0.01, 0.99);
            let to = low + share * (high - low);
            let Some(state) = self.next(&here, &command(to)) else {
                return RangeEnd { value: low, bound: Bound::BranchEnds, nearest: here.nearest };
            };
            let excess = state.excess();
            let safe = excess < 0.0;
            // Illinois: an end that stays for the second time counts for half.
            let stays = if moved == Some(safe) { 0.5 } else { 1.0 };
            moved = Some(safe);
            nearest = state.nearest;
            if safe {
                (low, below, here) = (to, excess, state);
                above *= stays;
            } else {
                (high, above) = (to, excess);
                below *= stays;
            }
        }
        RangeEnd { value: low, bound: nearest.map_or(Bound::Open, Bound::Limit), nearest }
    }
}
