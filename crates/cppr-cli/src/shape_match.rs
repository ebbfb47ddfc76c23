//! `cppr match`: actuator values for a measured or wanted shape.

use crate::Failure;
use crate::bundle;
use crate::command::CommandArgs;
use crate::figure;
use crate::free::{self, FreeArgs, State, line};
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::{Kind, scalar};
use crate::resolved::AccuracyArgs;
use crate::table::plain;
use cppr::analysis::inverse::{FreeInput, ShapeMatch};
use cppr::solve::Solver;
use cppr_io::points::read_points;
use serde_json::json;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr match robots/r3.toml --points examples/shapes/r3.csv
  cppr match robots/r3.toml --points examples/shapes/r3.csv --rotate 0deg --plot match.svg --json -

The table has columns x_mm, y_mm, z_mm, and may have at_mm (distance from the baseplate along the robot at rest; of one with
parts or joints, along its centreline; without it the nearest place counts) and sigma_mm. Actuators that are given a value keep it, all others are free.";

/// Arguments of `cppr match`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Points on the centreline (CSV)
    #[arg(long, value_name = "FILE")]
    points: PathBuf,
    /// Standard deviation of each coordinate, for points without sigma_mm
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", value_parser = |t: &str| scalar(t, Kind::Length))]
    point_deviation: f64,
    #[command(flatten)]
    command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    free: FreeArgs,
    /// Write the answer, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the answer and the points, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Reads, searches, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [args.json.as_deref(), None, args.plot.as_deref()])?;
    outputs.spare(&args.points)?;
    if args.point_deviation <= 0.0 {
        return Err(Failure::Input("--point-deviation is a deviation: write it above 0".into()));
    }
    let shown = args.points.display();
    let text = std::fs::read_to_string(&args.points)
        .map_err(|e| Failure::Input(format!("{shown}: cannot be read: {e}")))?;
    let points = read_points(&text, args.point_deviation).map_err(|problems| {
        let lines: Vec<String> = problems.iter().map(|p| format!("{shown}: {p}")).collect();
        Failure::Input(lines.join("\n"))
    })?;
    let marks = Some(("points", points.iter().map(|p| p.position.into()).collect()));
    args.free.search(
        &args.robot,
        &args.command,
        (&args.accuracy, None),
        |solver, command, free| {
            let find = |solver: &mut Solver| {
                solver.shape_match(command, free, &points).map_err(|p| free::failure(&p))
            };
            let (answer, resolved) = args.accuracy.search(solver, find, |answer| &answer.equilibrium)?;
            let state = State::of(solver, &resolved);
            outputs.draw(|| figure::marked_shape(solver, &answer.equilibrium, marks.clone()))?;
            finish(&outputs, &solver.robot().design().name, free, &state, &answer)
        },
        |analysis, command, free, _| {
            let answer = analysis.shape_match(command, free, &points).map_err(|p| free::failure(&p))?;
            let state = State::of_bundle(analysis, &answer.equilibrium);
            outputs.draw(|| bundle::marked(analysis, &answer.equilibrium, marks.clone()))?;
            finish(&outputs, &analysis.design().name, free, &state, &answer)
        },
    )
}

/// Writes and prints.
fn finish<E>(
    outputs: &Outputs,
    name: &str,
    free: &[FreeInput],
    state: &State,
    answer: &ShapeMatch<E>,
) -> Result<(), Failure> {
    if let Some(path) = outputs.json {
        let whole = json!({
            "schema": "cppr/match", "schema_version": 1, "robot": name,
            "inputs": free::inputs_json(free, &answer.values, &answer.at_bound, Some(&answer.uncertainty.deviations)),
            "rms_distance_m": answer.rms, "distances_m": answer.distances,
            "noise_against_stated": answer.uncertainty.misfit,
            "actuators": state.actuators, "accuracy": state.accuracy,
        });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    outputs.report(&table(name, free, state, answer))
}

fn table<E>(name: &str, free: &[FreeInput], state: &State, answer: &ShapeMatch<E>) -> String {
    let count = answer.distances.len();
    let mut text = format!("{name}: {count} point{}\n", if count == 1 { "" } else { "s" });
    free::inputs_table(&mut text, free, &answer.values, &answer.at_bound, Some(&answer.uncertainty));
    let largest = answer.distances.iter().copied().fold(0.0, f64::max);
    let distances = format!(
        "{:>9} mm root mean square, {} mm at most",
        plain(answer.rms * 1e3, 3),
        plain(largest * 1e3, 3)
    );
    line(&mut text, "distances", &distances);
    let misfit = answer.uncertainty.misfit;
    if misfit.is_finite() {
        let rest =
            format!("{:>9} (1 where the stated deviations are right and the model is)", plain(misfit, 2));
        line(&mut text, "noise / stated", &rest);
    }
    for blind in answer.uncertainty.principal.iter().filter(|p| p.blind) {
        let parts: Vec<String> = free
            .iter()
            .zip(&blind.direction)
            .map(|(f, share)| format!("{share:+.2} {}", free::name(f.input)))
            .collect();
        line(&mut text, "not seen", &format!("{} (shares of the bounds)", parts.join(", ")));
    }
    text.push_str(&state.text);
    text
}
