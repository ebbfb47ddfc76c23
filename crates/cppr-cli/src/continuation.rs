//! `cppr continue`: a path of equilibria along one actuator, the loads or a whole command.

use crate::Failure;
use crate::bundle_continuation;
use crate::command::{CommandArgs, build};
use crate::continuation_figure::draw;
use crate::figure;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::{Kind, scalar};
use crate::resolved::{AccuracyArgs, told};
use crate::table::{counted, millimetres, plain};
use cppr::analysis::continuation::{
    Branch, End, Family, FamilyProblem, Parameter, PathPoint, PointKind, Tracing,
};
use cppr::analysis::explained;
use cppr::design::Robot;
use cppr::solve::{Command, Drive, Input, Quantity};
use cppr_io::bundle_file::Described;
use cppr_io::continuation::{ContinuationRecord, PathAccuracyRecord};
use std::fmt::Write;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr continue robots/r3.toml --along pull --to 20mm --plot r3-path.svg
  cppr continue robots/r1.toml --along pull --from -7mm --to 7mm
  cppr continue robots/childs3.toml --along rotate=3 --to 180deg --pull 2=1mm
  cppr continue robots/r1.toml --along tension --to -3N --csv path.csv
  cppr continue robots/r1.toml --along load --to 1.5 --tip-force -1,0,0N --branches --plot buckling.svg
  cppr continue robots/r4.toml --along command --to 1 --pull -4mm --tip-force 0,0.1,0.1N --json -

The path begins at the equilibrium of the other options, with the varied one at --from. Without --from it begins
at the value that the same option gives (--pull 2mm --along pull), or at 0. Steps are measured along the path, not along the
parameter, which may turn back: a fold, where the robot snaps. At a branch point it may leave into another shape.
Exit codes: 0 traced (the table says how far), 2 wrong input, 3 no equilibrium to begin with.";

/// What varies along the path.
#[derive(Clone, Copy)]
pub enum Along {
    Actuator(Input),
    Load,
    Command,
}

fn along(text: &str) -> Result<Along, String> {
    let (name, tube) = match text.split_once('=') {
        None => (text, None),
        Some((name, number)) => match number.trim().parse::<usize>() {
            Ok(tube) if tube >= 1 => (name, Some(tube)),
            _ => return Err(format!("{number} is no tube: write for instance {name}=2")),
        },
    };
    if let Some(quantity) = Quantity::named(name) {
        return Ok(Along::Actuator(quantity.of_tube(tube.unwrap_or(2))));
    }
    match name {
        "load" | "command" if tube.is_some() => {
            Err(format!("{name} takes everything at once: write it without a number"))
        }
        "load" => Ok(Along::Load),
        "command" => Ok(Along::Command),
        _ => Err("write pull, rotate, tension, torque (with =K for tube K), load or command".into()),
    }
}

/// Arguments of `cppr continue`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    pub robot: PathBuf,
    /// What varies: pull, rotate, tension or torque of tube 2 or K (of any tube where there are parts or joints), the factor of all loads, or of the whole command
    #[arg(long, value_name = "WHAT[=K]", value_parser = along)]
    pub along: Along,
    /// Where the path ends: a length, an angle, a force, a moment or, for load and command, a factor
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    to: String,
    /// Where it begins
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    from: Option<String>,
    /// Follow the branches that leave at branch points too, and those that leave them, DEPTH times
    #[arg(long, value_name = "DEPTH", num_args = 0..=1, require_equals = true, default_value_t = 0, default_missing_value = "1", value_parser = clap::value_parser!(u8).range(0..=8))]
    branches: u8,
    /// Longest step, as a part of the path
    #[arg(long, value_name = "PART", default_value_t = 0.05, value_parser = part)]
    step: f64,
    /// Most points of one branch
    #[arg(long, value_name = "COUNT", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    points: u32,
    #[command(flatten)]
    pub command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    /// Write all points, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write all points as a table, - for standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw effort against motion, or the factor against the tip's deflection, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Stable points of a path whose errors are computed.
const ERRORS: usize = 8;

fn part(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(part) if (1e-5..=0.5).contains(&part) => Ok(part),
        _ => Err("write a part of the path between 0.00001 and 0.5, for instance 0.02".into()),
    }
}

impl Args {
    /// How the path is traced.
    pub fn tracing(&self) -> Tracing {
        Tracing {
            step: self.step,
            points: self.points as usize,
            depth: usize::from(self.branches),
            ..Tracing::default()
        }
    }

    /// Beginning, if it is given, and end of the path.
    pub fn ends(&self, kind: Option<Kind>) -> Result<(Option<f64>, f64), String> {
        let value = |option: &str, text: &str| match kind {
            Some(kind) => scalar(text, kind).map_err(|e| format!("{option}: {e}")),
            None => match text.parse::<f64>() {
                Ok(factor) if factor.abs() <= 1e9 => Ok(factor),
                _ => Err(format!("{option}: {text} is no factor: write a plain number, for instance 2.5")),
            },
        };
        let from = self.from.as_deref().map(|text| value("--from", text)).transpose()?;
        Ok((from, value("--to", &self.to)?))
    }
}

/// Traces, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [&args.json, &args.csv, &args.plot].map(Option::as_deref))?;
    match args.accuracy.described(&args.robot, args.command.rest.needs_modes())? {
        Described::Robot(file) => of_robot(args, &outputs, &build(&file, &args.robot)?),
        Described::Bundle { design, .. } => bundle_continuation::run(args, &outputs, &design),
    }
}

fn of_robot(args: &Args, outputs: &Outputs, robot: &Robot) -> Result<(), Failure> {
    let Outputs { json, csv, .. } = *outputs;
    let command = args.command.command(robot)?;
    let family = family(args, command.clone()).map_err(Failure::Input)?;
    let tracing = args.tracing();
    let mut solver = args.command.solver(robot)?;
    let branches = solver.trace(&family, &tracing).map_err(|problem| Failure::Input(problem.to_string()))?;
    if let [Branch { end: end @ End::NoStart(status), .. }] = &branches[..] {
        return Err(Failure::NoEquilibrium(format!(
            "{}: the path {end}. At its beginning: {}",
            robot.design().name,
            explained(robot, &command, *status)
        )));
    }
    let points: Vec<_> =
        branches.iter().flat_map(|branch| &branch.points).filter(|point| point.is_stable()).collect();
    let apart = points.len().div_ceil(ERRORS).max(1);
    let errors = points.iter().rev().step_by(apart).filter_map(|point| solver.accuracy(&point.equilibrium));
    let errors: Vec<f64> = errors.map(|own| own.tip / robot.length()).collect();
    let (known, error) = (errors.len(), errors.into_iter().reduce(f64::max));
    let record = ContinuationRecord {
        accuracy: PathAccuracyRecord { points: known, tip_of_length: error },
        ..ContinuationRecord::new(&solver, &family, &branches)
    };
    if let Some(path) = json {
        write_or_print(
            path,
            &record.to_json().map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?,
        )?;
    }
    if let Some(path) = csv {
        write_or_print(path, &record.to_csv())?;
    }
    let conjugate = |point: &PathPoint| family.parameter().conjugate(&point.equilibrium);
    // What is held is the same all along, save for the actuator that varies, which is on its axis.
    let title = match branches.first().and_then(|b| b.points.first()) {
        Some(first) if family.parameter() == Parameter::LoadFactor => figure::title(&first.equilibrium),
        _ => robot.design().name.clone(),
    };
    outputs.draw(|| Ok(draw(title, family.parameter(), &branches, conjugate)))?;
    let tubes = counted(robot.tube_count(), "tube");
    let head = format!("{}: {tubes}, {} mm", robot.design().name, millimetres(robot.length()));
    let mut text = table(&head, family.parameter(), &branches, conjugate);
    if let Some(error) = error {
        text += &told(error, known, "stable points", args.accuracy.accepted(solver.settings()));
    }
    outputs.report(&text)
}

/// The commands of the path.
fn family(args: &Args, mut command: Command) -> Result<Family, String> {
    let said = |problem: FamilyProblem| problem.to_string();
    match args.along {
        Along::Actuator(input) => {
            let (from, to) = args.ends(Some(Kind::of(input.quantity())))?;
            let tube = input.tube;
            let actuator =
                command.actuator(tube).ok_or_else(|| format!("--along: {}", command.no_such_tube(tube)))?;
            let given = match actuator.drive(input.freedom) {
                drive if drive.is_motion() == input.is_motion => drive.value(),
                // What is not said is held where it is at rest.
                Drive::Motion(value) if value.abs() <= 0.0 => 0.0,
                _ => {
                    return Err(format!(
                        "--along: tube {tube} is driven by motion and by effort; choose one"
                    ));
                }
            };
            command.set(input, from.unwrap_or(given)).map_err(|problem| format!("--along: {problem}"))?;
            Family::actuator(command, tube, input.freedom, to).map_err(said)
        }
        Along::Load => {
            let (from, to) = args.ends(None)?;
            if command.loads.is_empty() {
                return Err("--along load: there is no load; add for instance --tip-force".into());
            }
            Family::load(command, from.unwrap_or(0.0), to).map_err(said)
        }
        Along::Command => {
            let (from, to) = args.ends(None)?;
            Family::between(command.scaled(from.unwrap_or(0.0)), command.scaled(to)).map_err(said)
        }
    }
}

/// How a quantity is shown.
pub struct Shown {
    /// Symbol and tube.
    pub symbol: String,
    /// In words.
    pub words: &'static str,
    /// Unit; empty for a factor.
    pub unit: &'static str,
    /// Units per SI unit.
    pub scale: f64,
}

impl Shown {
    fn actuator(input: Input) -> Self {
        let Quantity { symbol, name: words, shown_unit: unit, shown_size, .. } = input.quantity();
        Self { symbol: format!("{symbol}_{}", input.tube), words, unit, scale: 1.0 / shown_size }
    }

    /// The parameter.
    pub fn parameter(parameter: Parameter) -> Self {
        let factor = |words: &'static str| Self { symbol: words.to_string(), words, unit: "", scale: 1.0 };
        match parameter {
            Parameter::Actuator(input) => Self::actuator(input),
            Parameter::LoadFactor => factor("load factor"),
            Parameter::Fraction => factor("command"),
        }
    }

    /// What answers an actuator.
    pub fn conjugate(parameter: Parameter) -> Option<Self> {
        let Parameter::Actuator(input) = parameter else { return None };
        Some(Self::actuator(input.conjugate()))
    }

    fn heading(&self) -> String {
        if self.unit.is_empty() { self.symbol.clone() } else { format!("{} ({})", self.symbol, self.unit) }
    }
}

/// Beginning, special points and end of every branch.
pub fn table<E>(
    head: &str,
    varies: Parameter,
    branches: &[Branch<E>],
    conjugate: impl Fn(&PathPoint<E>) -> Option<f64>,
) -> String {
    let (parameter, answer) = (Shown::parameter(varies), Shown::conjugate(varies));
    let effort = answer.as_ref().map_or(String::new(), |c| format!("{:>13}", c.heading()));
    let mut text = format!("{head}\n");
    let _ = writeln!(
        text,
        "  branch  point         {:>13}{effort}   {:^32}{:>9}  stability",
        parameter.heading(),
        "tip (mm)",
        "margin"
    );
    for (number, branch) in branches.iter().enumerate() {
        let last = branch.points.len().saturating_sub(1);
        for (i, point) in branch.points.iter().enumerate() {
            let what = match point.kind {
                _ if i == 0 => "start".into(),
                PointKind::Fold => "fold".into(),
                PointKind::BranchPoint { multiplicity: 1 } => "branch point".into(),
                PointKind::BranchPoint { multiplicity } => format!("branch point×{multiplicity}"),
                PointKind::Edge { tube } => format!("edge of tube {tube}"),
                PointKind::Regular if i == last => "end".into(),
                PointKind::Regular => continue,
            };
            let value = |x: f64, digits| format!("{:>13}", plain(x, digits));
            let effort = answer
                .as_ref()
                .map_or(String::new(), |c| value(conjugate(point).unwrap_or(0.0) * c.scale, 5));
            let tip = <[f64; 3]>::from(point.tip).map(|x| format!("{:>11}", plain(x * 1e3, 3))).join("");
            let _ = writeln!(
                text,
                "  {:>6}  {what:<14}{}{effort}{tip}  {}  {}",
                number + 1,
                value(point.parameter * parameter.scale, 5),
                point.margin.map_or("        -".into(), |m| format!("{:>9}", plain(m, 5))),
                stability(&branch.points[i..]),
            );
        }
        let from = branch.origin.map_or(String::new(), |o| format!(", leaves branch {}", o.branch + 1));
        let _ = writeln!(text, "          {} points{from}, {}", branch.points.len(), branch.end);
    }
    text
}

/// Stability of the first of some points; of one that is critical, that of the path behind it.
fn stability<E>(points: &[PathPoint<E>]) -> String {
    let words = |point: &PathPoint<E>| match point.inertia {
        None => "not known".into(),
        Some(0) => "stable".into(),
        Some(n) => format!("unstable, {n}"),
    };
    match points {
        [PathPoint { kind: PointKind::Fold | PointKind::BranchPoint { .. }, .. }, rest @ ..] => {
            rest.first().map_or("critical".into(), |next| format!("critical, then {}", words(next)))
        }
        [point, ..] => words(point),
        [] => String::new(),
    }
}
