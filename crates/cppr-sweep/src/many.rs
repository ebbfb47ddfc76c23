//! Many poses into memory, side by side and on all threads.

use cppr::solve::{Command, CommandProblem, March, Poses, Solved, march};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Poses of a block: many enough to fill lanes and to be worth a cold start, few enough to go round.
const BLOCK: Range<usize> = 16..256;
/// Blocks that there are at least, where these are not too small.
const LEAST_BLOCKS: usize = 64;

/// Solves one pose for every entry of `results`, on the threads of the current pool of rayon.
///
/// `put` puts what varies in a pose into a command that is a copy of `poses.base`, or of an earlier pose. `read` takes every pose
/// once, with its number and its entry, or why it cannot be asked; when it breaks, no
/// further block of poses is begun.
/// Poses next to each other should be neighbours: blocks of them are a [`march()`] each. The numbers do not depend on the threads.
///
/// ```
/// use cppr::design::Robot;
/// use cppr::solve::{Actuator, Command, Poses, Settings, Start};
/// use cppr_sweep::solve_many;
/// use std::ops::ControlFlow;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let text = std::fs::read_to_string("../../robots/r1.toml")?;
/// let robot = Robot::new(cppr_io::robot_file::parse(&text)?.design).map_err(|p| format!("{p:?}"))?;
/// let pulls: Vec<f64> = (0..1000).map(|i| 5e-6 * f64::from(i)).collect();
/// let (base, settings) = (Command::held(&robot), Settings::default());
/// let poses = Poses { robot: &robot, settings: &settings, base: &base, start: Start::Neighbour };
/// let mut tips = vec![None; pulls.len()];
/// let _ = solve_many(
///     &poses,
///     &mut tips,
///     |pose, command| command.actuators[0] = Actuator::pulled(pulls[pose]),
///     |_, tip, solved| {
///         *tip = solved.ok().filter(|s| s.equilibrium.status.is_equilibrium()).map(|s| s.centre);
///         ControlFlow::<()>::Continue(())
///     },
/// );
/// assert!(tips[999].is_some_and(|tip| tip.y < -0.07));
/// # Ok(())
/// # }
/// ```
pub fn solve_many<T: Send, B: Send>(
    poses: &Poses,
    results: &mut [T],
    put: impl Fn(usize, &mut Command) + Sync,
    read: impl Fn(usize, &mut T, Result<Solved<'_>, CommandProblem>) -> ControlFlow<B> + Sync,
) -> ControlFlow<B> {
    let block = (results.len() / LEAST_BLOCKS).clamp(BLOCK.start, BLOCK.end);
    results.par_chunks_mut(block).enumerate().try_for_each_init(March::new, |memory, (number, own)| {
        let (first, count) = (number * block, own.len());
        march(
            poses,
            memory,
            count,
            |pose, command| put(first + pose, command),
            |pose, solved| read(first + pose, &mut own[pose], solved),
        )
    })
}
