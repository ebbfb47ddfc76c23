//! Many poses of a robot of parts and joints, in blocks of neighbours, so that the numbers do not depend on the threads.

use crate::bundle::{Integrated, command_of};
use crate::model::Model;
use crate::names::cppr_value;
use crate::poses::Varied;
use crate::session::Refused;
use crate::values::size;
use cppr::many::Start;
use cppr::solve::Command;
use cppr_sweep::ONE_BLOCK;
use rayon::prelude::*;

/// Solves many poses on the threads of the current pool of rayon and writes `wanted` of each into its row, NaN before.
pub(crate) fn solve_many(
    model: &Model,
    work: &Integrated,
    base: &Command,
    start: Start,
    varied: &Varied,
    wanted: &[cppr_value],
    rows: &mut [&mut [f64]],
) -> Result<(), (usize, Refused)> {
    let mut each = base.clone();
    for pose in 0..rows.len() {
        varied.put(pose, &mut each);
        work.check(&command_of(&each)).map_err(|problem| (pose, problem))?;
    }
    let mut work = work.clone();
    work.prepare();
    let begin = || (work.clone(), base.clone());
    rows.par_chunks_mut(ONE_BLOCK).enumerate().for_each_init(begin, |(work, command), (block, rows)| {
        for (place, row) in rows.iter_mut().enumerate() {
            varied.put(block * ONE_BLOCK + place, command);
            work.go_to(&command_of(command), place > 0 && start == Start::Neighbour);
            let mut rest = &mut **row;
            for &value in wanted {
                let (own, after) = rest.split_at_mut(size(model, value));
                // What there is not stays NaN.
                let _ = work.read(value, own);
                rest = after;
            }
        }
    });
    Ok(())
}
