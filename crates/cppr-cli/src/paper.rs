//! `cppr paper`: the report on Tummers et al. 2024.

use crate::Failure;
use crate::output::print;
use cppr_paper::{Job, Page, PaperError, html, pages};
use indicatif::{ProgressBar, ProgressStyle};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr paper --output report
  cppr paper --only figure25 --only differences --output part

The folder holds report.html (one file, no network), every figure as SVG and PNG, and numbers.json.";

/// Arguments of `cppr paper`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder to write; an earlier report there is replaced
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
    /// Only this page; repeat for more
    #[arg(long, value_name = "PAGE")]
    only: Vec<String>,
}

/// Pixels of a PNG per unit of the figure.
const PIXELS: f64 = 2.0;

/// Computes on all cores, writes the folder whole.
pub fn run(args: &Args) -> Result<(), Failure> {
    let jobs = pages();
    if let Some(unknown) = args.only.iter().find(|name| jobs.iter().all(|job| job.name != name.as_str())) {
        let known: Vec<&str> = jobs.iter().map(|job| job.name).collect();
        return Err(Failure::Input(format!(
            "--only: there is no page {unknown}; there are {}",
            known.join(", ")
        )));
    }
    let jobs: Vec<Job> =
        jobs.into_iter().filter(|j| args.only.is_empty() || args.only.iter().any(|n| n == j.name)).collect();
    let target = place(&args.output)?;
    let start = Instant::now();
    let pages = compute(&jobs).map_err(|e| Failure::NoEquilibrium(e.to_string()))?;
    write(&target, &pages)?;
    print(&format!(
        "{}: {} pages, {} figures, {:.1} s\n",
        args.output.join("report.html").display(),
        pages.len(),
        pages.iter().map(|p| p.figures.len()).sum::<usize>(),
        start.elapsed().as_secs_f64()
    ))
}

/// Pages in order, computed side by side.
fn compute(jobs: &[Job]) -> Result<Vec<Page>, PaperError> {
    let bar = ProgressBar::new(jobs.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} pages, {elapsed}, {msg}") {
        bar.set_style(style);
    }
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Result<Page, PaperError>>>> = Mutex::new(jobs.iter().map(|_| None).collect());
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(i) else { break };
                    bar.set_message(job.name);
                    let page = job.run();
                    if let Ok(mut done) = done.lock() {
                        done[i] = Some(page);
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    done.into_inner().unwrap_or_default().into_iter().flatten().collect()
}

/// The folder to write, found out before anything is computed: its parent is there and can be written, and what it
/// holds, if it is there, is an earlier report and nothing else.
fn place(output: &Path) -> Result<PathBuf, Failure> {
    let refuse = |what: String| Failure::Input(format!("--output {}: {what}", output.display()));
    // An existing folder by its real name: `.` has no parent to work in.
    let target = fs::canonicalize(output).unwrap_or_else(|_| output.into());
    if target.exists() && !target.is_dir() {
        return Err(refuse("this is no folder; give another name".into()));
    }
    if let Ok(list) = fs::read_dir(&target) {
        let names: Vec<String> =
            list.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        if let Some(other) = names.iter().find(|name| !is_ours(name)) {
            let message = format!("holds {other}, which is not of an earlier report; give another folder");
            return Err(refuse(message));
        }
    }
    let folder = parent(&target);
    if !folder.is_dir() {
        return Err(refuse(format!("there is no folder {}; make it first", folder.display())));
    }
    tempfile::tempdir_in(&folder)
        .map_err(|e| refuse(format!("nothing can be written in {}: {e}", folder.display())))?;
    Ok(target)
}

fn parent(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => ".".into(),
    }
}

/// Files that a report consists of.
fn is_ours(name: &str) -> bool {
    let figure = name.strip_suffix(".svg").or(name.strip_suffix(".png"));
    matches!(name, "report.html" | "numbers.json")
        || figure.is_some_and(|figure| pages().iter().any(|job| figure.starts_with(job.name)))
}

/// Everything is made first, then written into a folder beside the target, which takes the target's place in the end.
fn write(target: &Path, pages: &[Page]) -> Result<(), Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Input(format!("{}: {error}", target.display()));
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    let mut numbers = serde_json::Map::new();
    for page in pages {
        for (name, _, figure) in &page.figures {
            files.push((format!("{name}.svg"), figure.to_svg().map_err(|e| failed(&e))?.into_bytes()));
            files.push((format!("{name}.png"), figure.to_png(PIXELS).map_err(|e| failed(&e))?));
        }
        let own: serde_json::Map<String, serde_json::Value> =
            page.numbers.iter().map(|(key, value)| (key.clone(), (*value).into())).collect();
        numbers.insert(page.name.clone(), own.into());
    }
    let numbers = format!("{:#}\n", serde_json::Value::Object(numbers));
    files.push(("numbers.json".into(), numbers.into_bytes()));
    files.push(("report.html".into(), html(pages).map_err(|e| failed(&e))?.into_bytes()));

    let beside = || tempfile::Builder::new().prefix(".cppr-").tempdir_in(parent(target));
    let folder = beside().map_err(|e| failed(&e))?;
    for (name, bytes) in &files {
        fs::write(folder.path().join(name), bytes).map_err(|e| failed(&e))?;
    }
    // The earlier report, if any, goes only when the new one is whole.
    let earlier = beside().map_err(|e| failed(&e))?;
    if target.exists() {
        fs::rename(target, earlier.path().join("earlier")).map_err(|e| failed(&e))?;
    }
    let whole = folder.keep();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&whole, fs::Permissions::from_mode(0o755)).map_err(|e| failed(&e))?;
    }
    fs::rename(&whole, target).map_err(|e| failed(&e))
}
