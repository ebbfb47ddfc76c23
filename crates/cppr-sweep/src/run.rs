//! Solving a task on several threads, chunks handed over in order.

use crate::solver::solve_chunk;
use crate::table::Chunk;
use crate::task::Task;
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

/// Chunks per thread that may be solved or wait at a time: bounds the memory.
const AHEAD: u64 = 3;

/// Solves chunks `chunks` of a checked task on `threads` threads (0: as many as the machine has) and hands them over
/// in order, on the calling thread. `on_chunk` stops the run by breaking; `stop` does so from outside, within a pose.
///
/// Memory does not grow with the task. The numbers do not depend on the threads.
///
/// # Errors
/// Where threads cannot be started.
pub fn run<B>(
    task: &Task,
    threads: usize,
    chunks: Range<u64>,
    stop: &AtomicBool,
    mut on_chunk: impl FnMut(Chunk) -> ControlFlow<B>,
) -> Result<ControlFlow<B>, ThreadPoolBuildError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let chunking = task.chunking();
    let ahead = AHEAD * pool.current_num_threads() as u64;
    let halt = AtomicBool::new(false);
    let halted = |flow| {
        halt.store(true, Ordering::Relaxed);
        flow
    };
    let result = pool.in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        let (mut started, mut wanted) = (chunks.start, chunks.start);
        let mut early = BTreeMap::new();
        while wanted < chunks.end {
            while started < chunks.end.min(wanted + ahead) {
                let (sender, number, chunking, halt) = (sender.clone(), started, &chunking, &halt);
                scope.spawn(move |_| {
                    let solved = catch_unwind(AssertUnwindSafe(|| {
                        let halts = [stop, halt].iter().any(|flag| flag.load(Ordering::Relaxed));
                        if halts { None } else { solve_chunk(task, chunking, number, stop) }
                    }));
                    // The receiver is gone where the run was stopped.
                    let _ = sender.send((number, solved));
                });
                started += 1;
            }
            let Ok((number, solved)) = receiver.recv() else { break };
            match solved {
                Ok(Some(chunk)) => early.insert(number, chunk),
                Ok(None) => return halted(ControlFlow::Continue(())),
                Err(panic) => {
                    halt.store(true, Ordering::Relaxed);
                    resume_unwind(panic)
                }
            };
            while let Some(chunk) = early.remove(&wanted) {
                wanted += 1;
                if let ControlFlow::Break(why) = on_chunk(chunk) {
                    return halted(ControlFlow::Break(why));
                }
            }
        }
        ControlFlow::Continue(())
    });
    Ok(result)
}
