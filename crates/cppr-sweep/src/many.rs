//! Many poses into memory, side by side and on all threads.

use cppr::many::{March, Solved, Start};
use cppr::solve::{Command, CommandProblem, Solver};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// So many poses, or fewer, [`solve_many`] solves on the calling thread. They are the least of a block: enough to fill lanes and to be
/// worth a cold start.
pub const ONE_BLOCK: usize = 16;
/// Most poses of a block: few enough to go round.
const LARGEST_BLOCK: usize = 256;
/// Blocks that there are at least, where these are not too small.
const LEAST_BLOCKS: usize = 64;

/// How many of so many poses make a block.
pub(crate) fn block(poses: usize) -> usize {
    (poses / LEAST_BLOCKS).clamp(ONE_BLOCK, LARGEST_BLOCK)
}

/// Buffers of [`solve_many`], as many as ever worked at the same time. Making them costs as much as some dozen poses: keep them from
/// call to call.
#[derive(Debug, Default)]
pub struct Memory(Mutex<Vec<March>>);

impl Memory {
    /// No buffers yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Buffers that solve what a solver solves. The lock is held to take and to give back, never in between.
    fn lend(&self, solver: &Solver) -> Lent<'_> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let march = match kept {
            Some(mut march) => {
                march.solver().copy_task(solver);
                march
            }
            None => March::new(solver.clone()),
        };
        Lent { memory: self, march: Some(march) }
    }
}

/// Buffers that go back where they came from.
struct Lent<'a> {
    memory: &'a Memory,
    march: Option<March>,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let kept = self.march.take();
        self.memory.0.lock().unwrap_or_else(PoisonError::into_inner).extend(kept);
    }
}

/// What many poses have in common.
#[derive(Clone, Copy, Debug)]
pub struct Poses<'a> {
    /// Robot and settings.
    pub solver: &'a Solver,
    /// What does not vary.
    pub base: &'a Command,
    /// Where a pose starts.
    pub start: Start,
}

/// Solves one pose for every entry of `results`, on the threads of the current pool of rayon.
///
/// `put` puts what varies in a pose into a command that is a copy of `poses.base`, or of an earlier pose. `read` takes every pose
/// once, with its number and its entry, or why it cannot be asked; when it breaks, no
/// further block of poses is begun.
/// Poses next to each other should be neighbours: blocks of them are a [`March`] each. The numbers do not depend on the threads.
///
/// ```
/// use cppr::many::Start;
/// use cppr::solve::{Actuator, Command, Solver};
/// use cppr_sweep::{Memory, Poses, solve_many};
/// use std::ops::ControlFlow;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let robot = cppr_io::read_robot("../../robots/r1.toml")?;
/// let pulls: Vec<f64> = (0..1000).map(|i| 5e-6 * f64::from(i)).collect();
/// let (base, solver) = (Command::held(&robot), Solver::new(&robot));
/// let poses = Poses { solver: &solver, base: &base, start: Start::Neighbour };
/// let mut tips = vec![None; pulls.len()];
/// let _ = solve_many(
///     &poses,
///     &Memory::new(),
///     &mut tips,
///     |pose, command| command.actuators[0] = Actuator::pulled(pulls[pose]),
///     |_, tip, solved| {
///         *tip = solved.ok().filter(|s| s.equilibrium.status().is_equilibrium()).map(|s| s.tip.centre);
///         ControlFlow::<()>::Continue(())
///     },
/// );
/// assert!(tips[999].is_some_and(|tip| tip.y < -0.07));
/// # Ok(())
/// # }
/// ```
pub fn solve_many<T: Send, B: Send>(
    poses: &Poses,
    memory: &Memory,
    results: &mut [T],
    put: impl Fn(usize, &mut Command) + Sync,
    read: impl Fn(usize, &mut T, Result<Solved<'_>, CommandProblem>) -> ControlFlow<B> + Sync,
) -> ControlFlow<B> {
    let block = block(results.len());
    let Poses { solver, base, start } = *poses;
    let solve = |lent: &mut Lent, number: usize, own: &mut [T]| {
        let Some(march) = &mut lent.march else { return ControlFlow::Continue(()) };
        let (first, count) = (number * block, own.len());
        march.run(
            base,
            start,
            count,
            |pose, command| put(first + pose, command),
            |pose, solved| read(first + pose, &mut own[pose], solved),
        )
    };
    if results.len() <= block {
        return solve(&mut memory.lend(solver), 0, results);
    }
    let blocks = results.par_chunks_mut(block).enumerate();
    blocks.try_for_each_init(|| memory.lend(solver), |lent, (number, own)| solve(lent, number, own))
}
