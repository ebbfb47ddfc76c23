//! Many poses in one call, on several threads.

use crate::names::{Numbered, cppr_input, cppr_start, cppr_value};
use crate::pointer;
use crate::poses::{Varied, solve_many};
use crate::solver::{cppr_solver, session};
use crate::status::{cppr_code, guard, say};
use crate::values::size;
use cppr::many::Start;
use cppr_sweep::ONE_BLOCK;
use std::sync::Arc;

/// Solves many poses of a robot and reads every one. Command and options of `solver` are common to all; its equilibrium is neither used nor
/// changed, and it may be used meanwhile.
///
/// What varies are `columns` inputs (cppr_input), each of a tube (0 on the tip); `values` has one row of `columns` numbers for each
/// of `poses` poses. What is read are `wanted` values (cppr_value); `out` has room for exactly `count` numbers: one row per pose, the values
/// one after another as long as cppr_solver_size() says. What a pose has not, because it has no equilibrium, is NaN: read CPPR_VALUE_STATUS first.
///
/// `start` is a cppr_start. `threads` is how many threads to solve on; 0 takes one per core. The numbers do not depend on it. A
/// command that cannot be asked is refused before anything is solved; the text names the pose, counted from 0.
///
/// # Safety
/// `solver` is null or a living solver; `inputs` and `tubes` point to `columns` numbers, `values` to poses × columns, `wanted_values` to
/// `wanted`, `out` to room for `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solve_many(
    solver: *const cppr_solver,
    start: u32,
    poses: usize,
    columns: usize,
    inputs: *const u32,
    tubes: *const u32,
    values: *const f64,
    wanted: usize,
    wanted_values: *const u32,
    out: *mut f64,
    count: usize,
    threads: usize,
) -> i32 {
    guard(|| {
        let refuse = |text: String| say(cppr_code::BadArgument, format_args!("{text}"));
        // SAFETY: the caller's promises.
        let (model, work, asked) =
            unsafe { session(solver) }.map(|s| (Arc::clone(&s.model), s.work.clone(), s.asked.clone()))?;
        let cells = poses.checked_mul(columns).ok_or_else(|| refuse("so many poses cannot be".into()))?;
        // SAFETY: the caller's promises.
        let (inputs, tubes, values, wanted) = unsafe {
            (
                pointer::array(inputs, columns, "inputs")?,
                pointer::array(tubes, columns, "tubes")?,
                pointer::array(values, cells, "values")?,
                pointer::array(wanted_values, wanted, "wanted_values")?,
            )
        };
        let wanted: Vec<cppr_value> =
            wanted.iter().map(|own| cppr_value::of(*own)).collect::<Result<_, _>>()?;
        let width: usize = wanted.iter().map(|own| size(&model, *own)).sum();
        if width == 0 || width.checked_mul(poses) != Some(count) {
            return Err(refuse(format!(
                "the wanted values are {width} numbers for each of {poses} poses; there is room for {count}"
            )));
        }
        let inputs = inputs.iter().map(|own| cppr_input::of(*own)).zip(tubes);
        let inputs = inputs.map(|(input, tube)| Ok((input?, *tube))).collect::<Result<Vec<_>, _>>()?;
        let start = match cppr_start::of(start)? {
            cppr_start::Rest => Start::Rest,
            cppr_start::Neighbour => Start::Neighbour,
        };
        let varied = Varied::new(&model, &inputs, values);
        let varied = varied.map_err(|problem| say(cppr_code::BadCommand, format_args!("{problem}")))?;
        // SAFETY: the caller's promise.
        let out = unsafe { pointer::output(out, count, "out") }?;
        let mut run = || solve_many(&model, &work, &asked, start, &varied, &wanted, out);
        // One block needs no threads, and no block more than one of them.
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let blocks = poses.div_ceil(ONE_BLOCK);
        let threads = if threads > 0 { threads } else { cores() }.min(blocks);
        let solved = if blocks > 1 {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let internal =
                |error| say(cppr_code::Internal, format_args!("threads cannot be started: {error}"));
            pool.map_err(internal)?.install(&mut run)
        } else {
            run()
        };
        solved
            .map_err(|(pose, problem)| say(cppr_code::BadCommand, format_args!("pose {pose}: {problem}")))?;
        Ok(cppr_code::Ok)
    })
}
