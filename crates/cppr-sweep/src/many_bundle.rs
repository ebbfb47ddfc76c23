//! Many poses of a robot of parts and joints into memory, on all threads.

use crate::many::block;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use cppr::solve::Drive;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// A pose is near another one where no motor moves by more than this part of the length, or turns by more than these radians: on random robots the loops of
/// `crates/cppr/tests/random_bundles.rs` keep to their path in such steps.
const NEAR: [f64; 2] = [3e-3, 0.1];

/// Solves one pose for every entry of `results`, on the threads of the current pool of rayon.
///
/// `command` says what is asked in a pose: motors and loads that the bundle can be asked. `read` takes every pose once, with its number, its entry, the solver and what was
/// found; when it breaks, no further block of poses is begun. With `warm` a pose begins at the one before it where that is stable, motors move by no more than 0.3 % of the length and
/// 0.1 rad between both, and nothing else changes; all others begin at rest, and their error is known. The numbers do not depend on the threads.
pub fn solve_many_of_bundle<T: Send, B: Send>(
    solver: &BundleSolver,
    warm: bool,
    results: &mut [T],
    command: impl Fn(usize) -> BundleCommand + Sync,
    read: impl Fn(usize, &mut T, &BundleSolver, &BundleEquilibrium) -> ControlFlow<B> + Sync,
) -> ControlFlow<B> {
    let block = block(results.len());
    let length = solver.bundle().length();
    let blocks = results.par_chunks_mut(block).enumerate();
    blocks.try_for_each_init(
        || solver.clone(),
        |solver, (number, own)| {
            let mut before: Option<BundleEquilibrium> = None;
            for (index, result) in own.iter_mut().enumerate() {
                let pose = number * block + index;
                let asked = command(pose);
                let near =
                    before.take().filter(|own| warm && own.stable && is_near(&asked, own.command(), length));
                let near = near.map(|mut own| {
                    solver.solve_into(&asked, &mut own);
                    own
                });
                let found = near.filter(|own| own.converged && own.stable);
                let found = found.unwrap_or_else(|| solver.solve(&asked));
                read(pose, result, solver, &found)?;
                before = Some(found);
            }
            ControlFlow::Continue(())
        },
    )
}

fn is_near(asked: &BundleCommand, other: &BundleCommand, length: f64) -> bool {
    let [shift, turn] = NEAR;
    let close = |own: Drive, other: Drive, most: f64| match (own, other) {
        (Drive::Motion(own), Drive::Motion(other)) => (own - other).abs() <= most,
        (own, other) => own == other,
    };
    let both = |(own, other): (&TubeDrive, &TubeDrive)| {
        close(own.translation, other.translation, shift * length) && close(own.rotation, other.rotation, turn)
    };
    asked.loads == other.loads && asked.drives.iter().zip(&other.drives).all(both)
}
