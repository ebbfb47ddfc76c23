//! `cppr view`: a robot in the browser, live or as a page to send.

use crate::Failure;
use crate::command::{build, described, unsound};
use crate::output::{self, print};
use crate::quantity::{Kind, Span, span_for_any_tube};
use crate::scenario;
use cppr::bundle::Bundle;
use cppr_io::Scenario;
use cppr_io::bundle_file::Described;
use cppr_viewer::save::{Axis, SaveProblem, Swept, page};
use cppr_viewer::{Options, serve};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr view robots/r1.toml --sweep pull=-7..7mm:29 --save r1.html
  cppr view robots/childs3.toml --scenario examples/scenario.toml --sweep pull=2=-1..1mm:9 --sweep rotate=3=-60..60deg:5 --save childs3.html
Live, until Ctrl-C:
  $ cppr view robots/r1.toml
  $ cppr view robots/childs3.toml --scenario examples/scenario.toml --no-open --port 8000
  $ cppr view robots/bundles/two_sections.toml

The live page is served on this computer only, under an address with a secret in it that is new every time.
A saved page needs no server and no network; each --sweep becomes a slider.
Exit codes: 0 saved, or ended by Ctrl-C; 2 wrong input, 3 no pose has an equilibrium.";

/// Arguments of `cppr view`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Start with this scenario (TOML) instead of at rest
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Port of the loopback address; 0 for one that is free
    #[arg(long, default_value_t = 0, conflicts_with = "save")]
    port: u16,
    /// Print the address of the page, open nothing
    #[arg(long, conflicts_with = "save")]
    no_open: bool,
    /// Poses of a saved page: pull, tension, rotate or torque, then a range as for cppr sweep
    #[arg(long, value_name = "WHAT=[K=]FROM..TO:COUNT", value_parser = axis, requires = "save")]
    sweep: Vec<Axis>,
    /// Write one HTML file that shows the swept poses
    #[arg(long, value_name = "FILE", requires = "sweep")]
    save: Option<PathBuf>,
}

fn axis(text: &str) -> Result<Axis, String> {
    let example = "write what is swept and its values, for instance pull=-7..7mm:29";
    let (what, values) = text.split_once('=').ok_or(example)?;
    // The page counts in these units.
    let (swept, kind, unit) = match what.trim() {
        "pull" => (Swept::Pull, Kind::Length, 1e-3),
        "tension" => (Swept::Tension, Kind::Force, 1.0),
        "rotate" => (Swept::Rotate, Kind::Angle, std::f64::consts::PI / 180.0),
        "torque" => (Swept::Torque, Kind::Moment, 1e-3),
        other => return Err(format!("{other} cannot be swept; pull, tension, rotate and torque can")),
    };
    let given = span_for_any_tube(values, kind)?;
    match given.value {
        Span::Range(from, to, Some(count)) => {
            let value = |i: u32| (from + (to - from) * f64::from(i) / f64::from(count - 1)) / unit;
            // Rounding must not leave a zero that is none.
            let clean = |v: f64| if v.abs() < 1e-9 * (to - from) / unit { 0.0 } else { v };
            Ok(Axis { swept, tube: given.tube, values: (0..count).map(|i| clean(value(i))).collect() })
        }
        Span::Range(..) => Err(format!("say how many values: {text}:11")),
        Span::Fixed(_) => Err(format!("{values} is one value; {example}")),
    }
}

/// Serves the page, or saves one.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scenario = args.scenario.as_deref().map(scenario::read).transpose()?;
    let keeps_modes = scenario.as_ref().is_some_and(Scenario::needs_modes);
    let robot = described(&args.robot)?;
    // As the page will have it.
    let solved = if keeps_modes { robot.clone() } else { robot.clone().integrated().0 };
    match &solved {
        Described::Robot(file) => drop(build(file, &args.robot)?),
        Described::Bundle { design, .. } => drop(Bundle::new(design).map_err(|p| unsound(&args.robot, &p))?),
    }
    match (&args.scenario, &solved) {
        (Some(path), Described::Robot(_)) => drop(scenario::apply(path, &args.robot)?),
        (Some(path), Described::Bundle { design, .. }) => drop(scenario::bundle_command(path, design)?),
        (None, _) => {}
    }
    if let Some(path) = &args.save {
        let driven = match &solved {
            Described::Robot(file) => 2..=file.design.tubes.len(),
            Described::Bundle { design, .. } => 1..=design.tubes.len(),
        };
        check_axes(&args.sweep, &driven)?;
        return save(args, path, robot, &scenario.unwrap_or_default());
    }
    let options = Options { robot, scenario, port: args.port, open: !args.no_open };
    let said = |address: &str| {
        // Where nobody reads it the page can still be opened.
        let _ = print(&format!("{address}\nCtrl-C ends it.\n"));
    };
    serve(options, said).map_err(|error| match error.kind() {
        std::io::ErrorKind::AddrInUse => {
            Failure::Input(format!("--port {}: another program listens there; leave --port away", args.port))
        }
        std::io::ErrorKind::PermissionDenied => {
            Failure::Input(format!("--port {}: this port is not for everybody; leave --port away", args.port))
        }
        _ => Failure::Input(format!("the page cannot be served: {error}")),
    })
}

fn save(args: &Args, path: &Path, robot: Described, base: &Scenario) -> Result<(), Failure> {
    output::check(&args.robot, &[("--save", Some(path))])?;
    let html = page(robot, base, &args.sweep).map_err(|problem| match problem {
        SaveProblem::NoEquilibrium => Failure::NoEquilibrium(problem.to_string()),
        _ => Failure::Input(problem.to_string()),
    })?;
    output::write(path, html.as_bytes())
}

/// Refuses sweeps of tubes that are not driven, and of one twice.
fn check_axes(axes: &[Axis], driven: &RangeInclusive<usize>) -> Result<(), Failure> {
    for (i, axis) in axes.iter().enumerate() {
        if axis.tube < *driven.start() {
            return Err(Failure::Input(
                "--sweep: tube 1 is the leader, which is fixed in the baseplate: followers begin at 2".into(),
            ));
        }
        if axis.tube > *driven.end() {
            return Err(Failure::Input(format!("--sweep: there is no tube {}", axis.tube)));
        }
        let turns = |s: Swept| matches!(s, Swept::Rotate | Swept::Torque);
        if axes[..i].iter().any(|b| b.tube == axis.tube && turns(b.swept) == turns(axis.swept)) {
            return Err(Failure::Input(format!("--sweep: tube {} is swept twice in one way", axis.tube)));
        }
    }
    Ok(())
}
