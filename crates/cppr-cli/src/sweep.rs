//! `cppr sweep`: many poses of a robot into one table.

use crate::Failure;
use crate::bundle;
use crate::cloud::Workspace;
use crate::command::{CommandArgs, DriveArgs, RestArgs, build, unsound};
use crate::errors::Errors;
use crate::figure;
use crate::output::{self, note, write_or_print};
use crate::outputs::Outputs;
use crate::quantity::{ForTube, Kind, Span, bare_span, span_for_any_tube, span_vector};
use crate::resolved::AccuracyArgs;
use crate::rubbing::FrictionArgs;
use cppr::analysis::{ACCURACY, Teeth, absurd_demand};
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::design::Robot;
use cppr::solve::{CommandProblem, Quantity};
use cppr_io::bundle_file::Described;
use cppr_sweep::{
    Axis, BundleSubject, Chunk, FileOptions, FileProblem, Finished, Format, Plan, Report, RobotSubject,
    Study, Subject, Task, Values, Variable, Verdict, parts_of, write_file,
};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr sweep robots/r1.toml --pull -7..7mm:15 --rotate -180..180deg:13 --output workspace.csv
  cppr sweep robots/r1.toml --pull -7..7mm --rotate -90..90deg --tip-force 0,-0.2..0.2,0N --samples 200 --output samples.npz
  cppr sweep robots/r1.toml --pull 4mm --vary tube1.notches.depth_mm=normal(5,0.05) --samples 20 --output tolerance.csv
  cppr sweep robots/r1.toml --pull -6..6mm:25 --planar --limits --output plane.csv --plot plane.svg --colour closure
  cppr sweep robots/r1.toml --pull -5..5mm:11 --output pulls.csv --json -
  cppr sweep robots/childs3.toml --pull 2=-1..1mm:5 --pull 3=-1..1mm:5 --margin --output margin.parquet --resume
  cppr sweep robots/bundles/two_sections.toml --pull 2=0..3mm:4 --pull 4=0..2mm:5 --output sections.csv --plot sections.svg
  cppr sweep robots/r1.toml --pull 0..6mm:7 --friction 0.2 --output friction.csv
  cppr sweep robots/bundles/uncut_ends.toml --pull 1mm --vary tube1.part2.notches.depth_mm=normal(1.6,0.01) --samples 20 --output ends.parquet

A range FROM..TO:COUNT spans a grid with the others, the last of: --vary, --tip-force, --tip-moment, --pull, --tension,
--rotate, --torque varying fastest. With --samples a range is FROM..TO and is sampled evenly. --vary takes keys of the
robot file, in their own unit: a range, uniform(a,b) or normal(mean,deviation).
With --friction tip and actuators of all tubes are added as they are with motors driven on (loading_) and driven back (unloading_).
With --samples mean, deviation and percentiles of every output are printed, and which input moves the tip most.
The ending of the output says its format: .csv, .npz or .parquet. Every pose is a row, with its status.
Ctrl-C or a crash loses at most the poses in work: the same command with --resume goes on.
Exit codes: 0 done, 2 wrong input, 3 no pose has an equilibrium, 130 interrupted.";

/// Arguments of `cppr sweep`.
// Flags of a command line are booleans by nature.
#[allow(clippy::struct_excessive_bools)]
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Pull a follower by lengths. Without K= tube 2; repeat for more tubes
    #[arg(long, value_name = "[K=]LENGTHS", allow_hyphen_values = true, value_parser = |t: &str| span_for_any_tube(t, Kind::Length))]
    pull: Vec<ForTube<Span>>,
    /// Turn a follower's base
    #[arg(long, value_name = "[K=]ANGLES", allow_hyphen_values = true, value_parser = |t: &str| span_for_any_tube(t, Kind::Angle))]
    rotate: Vec<ForTube<Span>>,
    /// Pull a follower with forces instead
    #[arg(long, value_name = "[K=]FORCES", allow_hyphen_values = true, value_parser = |t: &str| span_for_any_tube(t, Kind::Force))]
    tension: Vec<ForTube<Span>>,
    /// Turn a follower with torques instead
    #[arg(long, value_name = "[K=]MOMENTS", allow_hyphen_values = true, value_parser = |t: &str| span_for_any_tube(t, Kind::Moment))]
    torque: Vec<ForTube<Span>>,
    /// Force on the tip, base frame; each component a value or a range
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| span_vector(t, Kind::Force))]
    tip_force: Option<[Span; 3]>,
    /// Moment on the tip, base frame; each component a value or a range
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| span_vector(t, Kind::Moment))]
    tip_moment: Option<[Span; 3]>,
    /// Vary a number of the robot file, for instance tube1.notches.depth_mm=normal(5,0.05)
    #[arg(long, value_name = "KEY=VALUES", value_parser = vary)]
    vary: Vec<(String, Spread)>,
    #[command(flatten)]
    rest: RestArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    /// Solve this many quasi-random samples instead of a grid
    #[arg(long, value_name = "N")]
    samples: Option<u64>,
    /// Other samples
    #[arg(long, default_value_t = 0, requires = "samples")]
    seed: u64,
    /// Add the margin to instability
    #[arg(long)]
    margin: bool,
    /// Add the greatest utilisation of strain, closing notches and torsion, and where it is, as cppr limits
    #[arg(long)]
    limits: bool,
    #[command(flatten)]
    friction: FrictionArgs,
    /// With --limits: let the teeth bend as the notches do
    #[arg(long, requires = "limits")]
    bending_teeth: bool,
    /// The table: .csv, .npz or .parquet
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Write how many poses ended how, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the stable tip positions, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// What the colour of the figure tells: tension, torque, energy, bend, margin, strain, closure, torsion or a column of the table
    #[arg(long, value_name = "COLUMN", requires = "plot")]
    colour: Option<String>,
    /// Go on where this sweep was interrupted, if it was
    #[arg(long)]
    resume: bool,
    /// Threads; 0 for all of the machine
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
}

/// Values of a key of the robot file.
#[derive(Clone, Copy)]
pub enum Spread {
    Span(Span),
    Normal(f64, f64),
}

fn vary(text: &str) -> Result<(String, Spread), String> {
    let example = "write a key and its values, for instance tube1.notches.depth_mm=normal(5,0.05)";
    let (key, values) = text.split_once('=').ok_or(example)?;
    let (key, values) = (key.trim(), values.trim());
    if key.is_empty() {
        return Err(example.into());
    }
    let pair = |name: &str| -> Option<Result<(f64, f64), String>> {
        let inside = values.strip_prefix(name)?.trim_start().strip_prefix('(')?.strip_suffix(')')?;
        let parts: Vec<_> = inside.split(',').map(|part| part.trim().parse::<f64>()).collect();
        Some(match parts[..] {
            [Ok(a), Ok(b)] if a.is_finite() && b.is_finite() => Ok((a, b)),
            _ => Err(format!("{name} takes two numbers, for instance {name}(4.9,5.1)")),
        })
    };
    let spread = if let Some(pair) = pair("normal") {
        let (mean, deviation) = pair?;
        if deviation <= 0.0 {
            return Err(format!("the standard deviation is {deviation}: it must be positive"));
        }
        Spread::Normal(mean, deviation)
    } else if let Some(pair) = pair("uniform") {
        let (from, to) = pair?;
        if from >= to {
            return Err(format!("{values}: write the smaller value first"));
        }
        Spread::Span(Span::Range(from, to, None))
    } else {
        match bare_span(values)? {
            Span::Fixed(_) => return Err(format!("{values} is one value: write it into the robot file")),
            span @ Span::Range(..) => Spread::Span(span),
        }
    };
    Ok((key.into(), spread))
}

/// Solves and writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let shown = args.output.display();
    let format = Format::of(&args.output)
        .ok_or_else(|| Failure::Input(format!("{shown}: tables are written as .csv, .npz or .parquet")))?;
    // A link stays a link.
    let target = std::fs::canonicalize(&args.output).unwrap_or_else(|_| args.output.clone());
    let plot = args.plot.as_deref().map(figure::format).transpose()?;
    let json = args.json.as_deref();
    let outputs =
        [("--output", Some(args.output.as_path())), ("--json", json), ("--plot", args.plot.as_deref())];
    output::check(&args.robot, &outputs)?;
    if args.output.exists() && !args.output.is_file() {
        return Err(Failure::Input(format!(
            "--output {shown}: this is no file; a table is put together in one"
        )));
    }
    let subject = subject(args)?;
    let mut task = task(args, subject)?;
    task.check().map_err(|problem| Failure::Input(problem.to_string()))?;
    let accepted = match &task.subject {
        Subject::Robot(own) => args.accuracy.accepted(&own.settings),
        Subject::Bundle(_) => ACCURACY,
    };
    let mut errors = Errors::of(&mut task, accepted);
    let task = task;
    let rows = task.rows();
    let colour = args.colour.as_deref();
    let mut cloud = args.plot.as_ref().map(|_| Workspace::new(&task, colour)).transpose()?;
    let start = Instant::now();
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
        .map_err(|error| Failure::Input(format!("Ctrl-C cannot be caught: {error}")))?;
    let options = FileOptions { threads: args.threads.into(), resume: args.resume, format, stop: &stop };
    let bar = ProgressBar::new(rows);
    if let Ok(style) = ProgressStyle::with_template(
        "{bar:30} {human_pos}/{human_len} poses, {rate} per second, {elapsed}, {eta} left",
    ) {
        let rate = |state: &ProgressState, out: &mut dyn Write| {
            let _ = write!(out, "{:.0}", state.per_sec());
        };
        bar.set_style(style.with_key("rate", rate));
    }
    let mut before = None;
    let progress = |done: u64| {
        if before.is_none() {
            before = Some(done);
            bar.reset_elapsed();
            bar.set_position(done);
            bar.reset_eta();
        }
        bar.set_position(done);
    };
    let mut study = matches!(task.plan, Plan::Samples { .. }).then(|| Study::new(&task));
    let mut reasons = [const { None }; Verdict::ALL.len()];
    let visit = |chunk: &Chunk| {
        if let Some(study) = &mut study {
            study.visit(chunk);
        }
        for (row, code) in chunk.column(task.axes.len()).iter().enumerate() {
            if let Some(verdict) = Verdict::from_code(*code)
                && let reason @ None = &mut reasons[usize::from(verdict.code())]
            {
                *reason = task.reason(chunk, row);
            }
        }
        if let Some(cloud) = &mut cloud {
            cloud.visit(chunk);
        }
        errors.visit(&task, chunk);
    };
    let finished = write_file(&task, &target, &options, progress, visit);
    bar.finish_and_clear();
    let finished = finished.map_err(|problem| failure(&target, &problem))?;
    let solved = rows - before.unwrap_or_default();
    let seconds = start.elapsed().as_secs_f64();
    let study = study.and_then(|study| study.report());
    if let Some(path) = json {
        let mut whole = as_json(args, &task, &finished, &reasons, study.as_ref(), solved, seconds);
        whole["accuracy"] = errors.json();
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let mut text = summary(args, &task, &finished, &reasons, solved, seconds);
    text += &errors.text();
    if let Some(report) = study {
        text += &crate::study::text(&report);
    }
    if finished.counts[usize::from(Verdict::Converged.code())] > 0
        && let (Some(cloud), Some(path), Some(format)) = (cloud, &args.plot, plot)
    {
        figure::write(path, format, &cloud.figure(&task)?)?;
    }
    if Verdict::ALL.iter().zip(finished.counts).any(|(v, n)| v.is_equilibrium() && n > 0) {
        Outputs { json, csv: None, plot: None }.report(&text)
    } else {
        note(&text);
        Err(Failure::NoEquilibrium(format!("{}: no pose has an equilibrium", task.name())))
    }
}

fn failure(target: &Path, problem: &FileProblem) -> Failure {
    let parts = parts_of(target);
    let parts = parts.display();
    match problem {
        FileProblem::Stopped(..) => {
            Failure::Interrupted(format!("{problem}; the same command with --resume goes on"))
        }
        FileProblem::Unfinished(_) => Failure::Input(format!(
            "{parts} holds an unfinished sweep: add --resume to go on with it, or remove that folder to begin anew"
        )),
        FileProblem::Io(..) => {
            Failure::Input(format!("{problem}. What is solved is kept in {parts}; --resume goes on"))
        }
        _ => Failure::Input(problem.to_string()),
    }
}

/// One pose of the sweep, to check options and loads as those of any pose; not at a zero, which would hide an input.
fn one_pose(args: &Args) -> CommandArgs {
    let seen = |span: Span| match span {
        Span::Range(from, to, _) if from.abs() <= 0.0 => to,
        Span::Fixed(value) | Span::Range(value, ..) => value,
    };
    let each = |list: &[ForTube<Span>]| -> Vec<ForTube> {
        list.iter().map(|f| ForTube { tube: f.tube, value: seen(f.value) }).collect()
    };
    CommandArgs {
        drive: DriveArgs {
            pull: each(&args.pull),
            rotate: each(&args.rotate),
            tension: each(&args.tension),
            torque: each(&args.torque),
            tip_force: args.tip_force.map(|v| v.map(seen)),
            tip_moment: args.tip_moment.map(|v| v.map(seen)),
        },
        rest: args.rest.clone(),
    }
}

/// What is swept.
fn subject(args: &Args) -> Result<(Subject, Option<Friction>), Failure> {
    let keeps_modes = args.rest.needs_modes() || args.margin;
    let (described, friction) = args.accuracy.rubbing(&args.robot, keeps_modes, args.friction)?;
    let subject = match described {
        Described::Robot(file) => Subject::Robot(Box::new(of_robot(args, build(&file, &args.robot)?)?)),
        Described::Bundle { design, .. } => Subject::Bundle(Box::new(of_bundle(args, design)?)),
    };
    Ok((subject, friction))
}

/// What a robot is asked in all poses.
fn of_robot(args: &Args, robot: Robot) -> Result<RobotSubject, Failure> {
    let command = one_pose(args);
    let (base, settings) = (command.command(&robot)?, command.settings());
    match base.check(&robot, &settings) {
        // Too far for this pose need not be so for the others.
        Ok(()) | Err(CommandProblem::TooFar { .. }) => {}
        Err(problem) => return Err(Failure::Input(problem.to_string())),
    }
    if let Some(demand) = absurd_demand(&robot, &base) {
        note(&format!("warning: {demand}\n"));
    }
    Ok(RobotSubject { robot, base, settings })
}

/// What a robot with parts or joints is asked in all poses.
fn of_bundle(args: &Args, design: BundleDesign) -> Result<BundleSubject, Failure> {
    let (base, stretch) = one_pose(args).bundle_command(&design)?;
    let bundle = Bundle::new(&design).map_err(|problems| unsound(&args.robot, &problems))?;
    // A joint that one pose would draw in behind the plate is that row's matter.
    let still =
        BundleCommand { drives: vec![TubeDrive::HELD; design.tubes.len()], loads: base.loads.clone() };
    bundle::check(&design, &bundle, &still, stretch)?;
    Ok(BundleSubject { bundle, design, base, stretch })
}

/// The task that the arguments describe.
fn task(args: &Args, (subject, friction): (Subject, Option<Friction>)) -> Result<Task, Failure> {
    let robot_text = std::fs::read_to_string(&args.robot)
        .map_err(|error| Failure::Input(format!("{}: {error}", args.robot.display())))?;
    let plan = match args.samples {
        Some(count) => Plan::Samples { count, seed: args.seed },
        None => Plan::Grid,
    };
    let axes = axes(args)?;
    let teeth = if args.bending_teeth { Teeth::Bending } else { Teeth::Rigid };
    let limits = args.limits.then_some(teeth);
    Ok(Task { subject, robot_text, axes, plan, margin: args.margin, limits, friction })
}

/// What varies.
fn axes(args: &Args) -> Result<Vec<Axis>, Failure> {
    let mut axes = Vec::new();
    let mut add = |option: &str, variable: Variable, spread: Spread| {
        let fail = |message: &str| Err(Failure::Input(format!("{option}: {message}")));
        let values = match (spread, args.samples) {
            (Spread::Span(Span::Fixed(_)), _) => return Ok(()),
            (Spread::Span(Span::Range(from, to, Some(count))), None) => Values::Range { from, to, count },
            (Spread::Span(Span::Range(from, to, None)), Some(_)) => Values::Range { from, to, count: 0 },
            (Spread::Span(Span::Range(_, _, Some(_))), Some(_)) => {
                return fail("with --samples a range has no count, write FROM..TO");
            }
            (Spread::Span(Span::Range(_, _, None)), None) => {
                return fail("say how many values, FROM..TO:COUNT, or take --samples N");
            }
            (Spread::Normal(mean, deviation), Some(_)) => Values::Normal { mean, deviation },
            (Spread::Normal(..), None) => return fail("a normal distribution is sampled, add --samples N"),
        };
        axes.push(Axis { variable, values });
        Ok(())
    };
    for (key, spread) in &args.vary {
        add(&format!("--vary {key}"), Variable::Design(key.clone()), *spread)?;
    }
    // The tip load is the first of the wrenches.
    for (component, span) in args.tip_force.into_iter().flatten().enumerate() {
        add("--tip-force", Variable::Force { wrench: 0, component }, Spread::Span(span))?;
    }
    for (component, span) in args.tip_moment.into_iter().flatten().enumerate() {
        add("--tip-moment", Variable::Moment { wrench: 0, component }, Spread::Span(span))?;
    }
    for (quantity, list) in
        Quantity::ALL.into_iter().zip([&args.pull, &args.tension, &args.rotate, &args.torque])
    {
        for &ForTube { tube, value } in list {
            let option = format!("--{}", quantity.keyword);
            add(&option, Variable::Actuator(quantity.of_tube(tube)), Spread::Span(value))?;
        }
    }
    if axes.is_empty() {
        return Err(Failure::Input(
            "nothing varies: give a range, for instance --pull -5..5mm:11, or use cppr solve".into(),
        ));
    }
    Ok(axes)
}

fn as_json(
    args: &Args,
    task: &Task,
    finished: &Finished,
    reasons: &[Option<String>],
    study: Option<&Report>,
    solved: u64,
    seconds: f64,
) -> Value {
    let ends = Verdict::ALL.iter().zip(finished.counts).zip(finished.first).zip(reasons);
    let ends: Vec<Value> = ends
        .map(|(((verdict, count), first), reason)| {
            json!({ "status": verdict.text(), "poses": count, "first_row": first, "reason": reason })
        })
        .collect();
    json!({
        "schema": "cppr/sweep", "schema_version": 1, "robot": task.name(),
        "table": args.output.display().to_string(), "poses": task.rows(), "solved_now": solved, "seconds": seconds,
        "ends": ends, "study": study.map(crate::study::json),
    })
}

fn summary(
    args: &Args,
    task: &Task,
    finished: &Finished,
    reasons: &[Option<String>],
    solved: u64,
    seconds: f64,
) -> String {
    let rate = solved as f64 / seconds;
    let mut text = format!(
        "{}: {} poses in {}; {solved} solved now in {seconds:.2} s, {rate:.0} per second\n",
        task.name(),
        task.rows(),
        args.output.display(),
    );
    let rows = Verdict::ALL.iter().zip(finished.counts).zip(finished.first).zip(reasons);
    for (((verdict, count), first), reason) in rows {
        if let Some(first) = first {
            let reason = reason.as_ref().map_or(String::new(), |reason| format!(": {reason}"));
            let _ = writeln!(text, "  {:<26}{count:>10}   first in row {first}{reason}", verdict.text());
        }
    }
    text
}
