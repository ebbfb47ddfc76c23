//! A sweep into a file, in steps that survive an interruption.

use crate::check::TaskProblem;
use crate::format::{self, Format, Source};
use crate::journal::{Journal, parts_of};
use crate::manifest::manifest;
use crate::run::run;
use crate::table::{Chunk, ColumnKind, Verdict};
use crate::task::Task;
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// How a file is made.
#[derive(Clone, Copy, Debug)]
pub struct FileOptions<'a> {
    /// Threads; 0 for as many as the machine has.
    pub threads: usize,
    /// Go on with an interrupted sweep of the same task, where there is one.
    pub resume: bool,
    /// Format of the result.
    pub format: Format,
    /// Set it to stop: what is solved stays and can be resumed.
    pub stop: &'a AtomicBool,
}

/// What a finished sweep holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Finished {
    /// Rows of every verdict, in the order of [`Verdict::ALL`].
    pub counts: [u64; Verdict::ALL.len()],
    /// First row of every verdict.
    pub first: [Option<u64>; Verdict::ALL.len()],
}

/// Why there is no file.
#[derive(Debug)]
pub enum FileProblem {
    /// The task is wrong.
    Task(TaskProblem),
    /// An interrupted sweep is there, and was not to be resumed: its folder.
    Unfinished(PathBuf),
    /// The interrupted sweep is another: its folder, and what differs.
    OtherTask(PathBuf, Vec<String>),
    /// Another process writes there: the folder.
    InUse(PathBuf),
    /// Stopped: rows solved, rows in all, the folder that holds them.
    Stopped(u64, u64, PathBuf),
    /// A file cannot be read or written.
    Io(PathBuf, io::Error),
    /// A chunk that was written reads back otherwise: the folder.
    Damaged(PathBuf),
    /// Threads cannot be started.
    Threads(ThreadPoolBuildError),
}

impl FileProblem {
    pub(crate) fn at(path: &Path) -> impl Fn(io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::Io(path.clone(), error)
    }
}

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Task(problem) => problem.fmt(f),
            Self::Unfinished(folder) => write!(
                f,
                "{} holds an unfinished sweep: go on with it (resume), or remove that folder to begin anew",
                folder.display()
            ),
            Self::OtherTask(folder, differ) => write!(
                f,
                "{} holds an unfinished sweep of another task ({} differ): finish that one with its own options, or remove the folder",
                folder.display(),
                differ.join(", ")
            ),
            Self::InUse(folder) => write!(f, "{}: another process is writing this sweep", folder.display()),
            Self::Stopped(done, rows, folder) => {
                write!(f, "stopped after {done} of {rows} poses, which are kept in {}", folder.display())
            }
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Damaged(folder) => write!(
                f,
                "{}: what was written reads back otherwise; check the disk, then resume",
                folder.display()
            ),
            Self::Threads(error) => write!(f, "threads cannot be started: {error}"),
        }
    }
}

impl std::error::Error for FileProblem {}

/// Solves a task into a file.
///
/// Chunks go to the folder [`parts_of`] first, so that a crash or `stop` loses only those in work; the result is
/// assembled there and moved to `output` when whole, and the folder removed. The bytes of the result depend on the task and
/// the format alone. `progress` is told the rows solved so far, beginning with those found there; `visit` sees every
/// chunk of the finished table.
///
/// # Errors
/// See [`FileProblem`]. After [`FileProblem::Stopped`] and errors of the disk the same call with `resume` goes on.
pub fn write_file(
    task: &Task,
    output: &Path,
    options: &FileOptions,
    mut progress: impl FnMut(u64),
    mut visit: impl FnMut(&Chunk),
) -> Result<Finished, FileProblem> {
    task.check().map_err(FileProblem::Task)?;
    let (chunking, columns, manifest) = (task.chunking(), task.columns(), manifest(task));
    let mut journal = Journal::open(parts_of(output), &manifest, &chunking, columns.len(), options.resume)?;
    let rows_done =
        |chunks: u64| if chunks < chunking.chunks { chunking.rows_of(chunks).start } else { chunking.rows };
    progress(rows_done(journal.done));
    let flow = run(task, options.threads, journal.done..chunking.chunks, options.stop, |chunk| match journal
        .append(&chunk)
    {
        Ok(()) => {
            progress(rows_done(journal.done));
            ControlFlow::Continue(())
        }
        Err(problem) => ControlFlow::Break(problem),
    });
    if let ControlFlow::Break(problem) = flow.map_err(FileProblem::Threads)? {
        return Err(problem);
    }
    if journal.done < chunking.chunks {
        return Err(FileProblem::Stopped(rows_done(journal.done), chunking.rows, journal.folder));
    }
    let finished = survey(&mut journal, chunking.chunks, &columns, &mut visit)?;
    let draft = journal.folder.join("result");
    let pool = ThreadPoolBuilder::new().num_threads(options.threads).build().map_err(FileProblem::Threads)?;
    let mut source = Source {
        journal: &mut journal,
        columns: &columns,
        task,
        has_reasons: [Verdict::InvalidDesign, Verdict::InvalidCommand]
            .iter()
            .any(|verdict| finished.counts[usize::from(verdict.code())] > 0),
        manifest: &manifest.to_string(),
        rows: chunking.rows,
        chunks: chunking.chunks,
    };
    let write =
        || File::create(&draft).and_then(|file| format::write(options.format, &mut source, file)?.sync_all());
    pool.install(write).map_err(FileProblem::at(&draft))?;
    fs::rename(&draft, output).map_err(FileProblem::at(output))?;
    journal.remove()?;
    Ok(finished)
}

/// Reads the whole table once.
fn survey(
    journal: &mut Journal,
    chunks: u64,
    columns: &[crate::table::Column],
    visit: &mut impl FnMut(&Chunk),
) -> Result<Finished, FileProblem> {
    let status = columns.iter().position(|c| c.kind == ColumnKind::Status).unwrap_or_default();
    let mut finished = Finished::default();
    for number in 0..chunks {
        let chunk = journal.read(number).map_err(FileProblem::at(&journal.folder))?;
        let Some(chunk) = chunk else { return Err(FileProblem::Damaged(journal.folder.clone())) };
        for (row, code) in chunk.column(status).iter().enumerate() {
            let Some(verdict) = Verdict::from_code(*code) else { continue };
            let place = usize::from(verdict.code());
            finished.counts[place] += 1;
            finished.first[place].get_or_insert(chunk.first_row + row as u64);
        }
        visit(&chunk);
    }
    Ok(finished)
}
