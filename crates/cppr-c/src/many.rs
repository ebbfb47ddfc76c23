//! Many poses in one call, on several threads.

use crate::model::Model;
use crate::names::{Numbered, cppr_input, cppr_option, cppr_start, cppr_value};
use crate::pointer;
use crate::poses::{Varied, solve_many};
use crate::session::Work;
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
        // SAFETY: the caller's promises.
        let (varied, wanted) = unsafe {
            let wanted = pointer::array(wanted_values, wanted, "wanted_values")?;
            (varied(&model, poses, columns, [inputs, tubes], values)?, wanted)
        };
        let wanted: Vec<cppr_value> =
            wanted.iter().map(|own| cppr_value::of(*own)).collect::<Result<_, _>>()?;
        let width: usize = wanted.iter().map(|own| size(&model, *own)).sum();
        if width == 0 || width.checked_mul(poses) != Some(count) {
            return Err(refuse(format!(
                "the wanted values are {width} numbers for each of {poses} poses; there is room for {count}"
            )));
        }
        let start = match cppr_start::of(start)? {
            cppr_start::Rest => Start::Rest,
            cppr_start::Neighbour => Start::Neighbour,
        };
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

/// What varies between poses.
///
/// # Safety
/// `inputs` and `tubes` point to `columns` numbers, `values` to poses × columns, for as long as the answer lives.
unsafe fn varied<'a>(
    model: &Model,
    poses: usize,
    columns: usize,
    [inputs, tubes]: [*const u32; 2],
    values: *const f64,
) -> Result<Varied<'a>, cppr_code> {
    let refuse = || say(cppr_code::BadArgument, format_args!("so many poses cannot be"));
    let cells = poses.checked_mul(columns).ok_or_else(refuse)?;
    // SAFETY: the caller's promises.
    let (inputs, tubes, values) = unsafe {
        (
            pointer::array(inputs, columns, "inputs")?,
            pointer::array(tubes, columns, "tubes")?,
            pointer::array(values, cells, "values")?,
        )
    };
    let inputs = inputs.iter().map(|own| cppr_input::of(*own)).zip(tubes);
    let inputs = inputs.map(|(input, tube)| Ok((input?, *tube))).collect::<Result<Vec<_>, _>>()?;
    let varied = Varied::new(model, &inputs, values);
    varied.map_err(|problem| say(cppr_code::BadCommand, format_args!("{problem}")))
}

/// Finds how few modes some poses bear with, for a loop that moves between them: those at the ends of what it moves through, for example. Every one, solved from rest, has its tip
/// within `accuracy` times the length with so many, and is as stable as with the usual ones; where none fewer suffice, it is 1 or, where more are needed, 2 or 4. CPPR_OPTION_REFINE
/// is set to it, and `refine` is the number. Forces and derivatives become coarser with the tip.
///
/// Poses are given as to cppr_solve_many(). CPPR_CODE_NO_EQUILIBRIUM where no error is known, as in the formulation printed in the paper; CPPR_CODE_BAD_ARGUMENT for a robot of parts and
/// joints, which has no modes. Takes some tens of milliseconds per pose, and allocates.
///
/// # Safety
/// `solver` is null or a living solver; `inputs` and `tubes` point to `columns` numbers, `values` to poses × columns, `refine` to room for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_fewest_modes(
    solver: *mut cppr_solver,
    accuracy: f64,
    poses: usize,
    columns: usize,
    inputs: *const u32,
    tubes: *const u32,
    values: *const f64,
    refine: *mut f64,
) -> i32 {
    guard(|| {
        let refuse = |text: &str| say(cppr_code::BadArgument, format_args!("{text}"));
        // SAFETY: the caller's promises.
        let (mut session, out) = unsafe { (session(solver)?, pointer::output(refine, 1, "refine")?) };
        if !(accuracy > 0.0 && accuracy <= 1.0) {
            return Err(refuse("accuracy is a part of the length above 0 and up to 1"));
        }
        let model = Arc::clone(&session.model);
        // SAFETY: the caller's promises.
        let varied = unsafe { varied(&model, poses, columns, [inputs, tubes], values) }?;
        let usual = session.asked.usual();
        let Work::Modal(own) = &session.work else {
            return Err(refuse("a robot of parts and joints has no modes"));
        };
        let commands = varied.commands(own, &varied.common(&usual), poses);
        let commands = commands
            .map_err(|(pose, problem)| say(cppr_code::BadCommand, format_args!("pose {pose}: {problem}")))?;
        let Some(found) = own.fewest_modes(&usual, &commands, accuracy) else {
            let text = "no pose has an equilibrium whose error is known";
            return Err(say(cppr_code::NoEquilibrium, format_args!("{text}")));
        };
        session.choose(cppr_option::Refine, found).map_err(|why| refuse(&why))?;
        out[0] = found;
        Ok(cppr_code::Ok)
    })
}
