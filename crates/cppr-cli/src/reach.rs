//! `cppr reach`: actuator values for a wanted tip.

use crate::Failure;
use crate::bundle;
use crate::command::CommandArgs;
use crate::figure;
use crate::free::{self, FreeArgs, State, line, three};
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::{Kind, direction, scalar, vector};
use crate::resolved::AccuracyArgs;
use crate::rubbing::{FrictionArgs, Touch};
use crate::table::plain;
use cppr::Vector3;
use cppr::analysis::inverse::{Accuracy, Conditioning, FreeInput, Reach, Target};
use cppr::solve::Solver;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr reach robots/r1.toml --position 128,-58.3,-12.8mm
  cppr reach robots/childs3.toml --position 25.152,-2.689,13.327mm --rotate 3=0deg --pull-bounds 2=-2..2mm --pull-bounds 3=-2..2mm --rotate-bounds 2=-45..45deg
  cppr reach robots/r4.toml --direction 0.7,0.7,0 --rotate 0deg --tip-force 0,-0.05,0N --json -
  cppr reach robots/r1.toml --position 100,100,100mm --plot reach.svg
  cppr reach robots/r1.toml --position 128,-58.3,0mm --rotate 0deg --pull-bounds 0..6mm --friction 0.2
  cppr reach robots/bundles/two_sections.toml --position 110,-20,0mm --pull 3=0mm --pull-bounds 2=-5..5mm --pull-bounds 4=-5..5mm --rotate 2=0deg --rotate 3=0deg --rotate 4=0deg

Actuators that are given a value keep it, all others are free. The target is in the base frame: the robot at rest
lies along +X from the baseplate. What is out of reach is answered with the nearest pose and its distance.
With --friction the answer is that without, and the two poses are told between which friction leaves the robot there.";

/// Arguments of `cppr reach`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Wanted position of the tip
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Length))]
    position: Option<[f64; 3]>,
    /// Wanted direction of the tip, of any length
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction)]
    direction: Option<[f64; 3]>,
    #[command(flatten)]
    command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    free: FreeArgs,
    #[command(flatten)]
    friction: FrictionArgs,
    /// Distance within which the position counts as reached
    #[arg(long, value_name = "LENGTH", default_value = "0.1mm", value_parser = |t: &str| scalar(t, Kind::Length))]
    tolerance: f64,
    /// Angle within which the direction counts as reached
    #[arg(long, value_name = "ANGLE", default_value = "0.5deg", value_parser = |t: &str| scalar(t, Kind::Angle))]
    angle_tolerance: f64,
    /// Standard deviation of the translations that the actuators really make
    #[arg(long, value_name = "LENGTH", default_value = "0.1mm", value_parser = |t: &str| scalar(t, Kind::Length))]
    pull_accuracy: f64,
    /// Standard deviation of the rotations that the actuators really make
    #[arg(long, value_name = "ANGLE", default_value = "1deg", value_parser = |t: &str| scalar(t, Kind::Angle))]
    rotate_accuracy: f64,
    /// Write the answer, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the answer and the target, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Searches, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [args.json.as_deref(), None, args.plot.as_deref()])?;
    if args.position.is_none() && args.direction.is_none() {
        return Err(Failure::Input("say where to: --position X,Y,Zmm, --direction X,Y,Z, or both".into()));
    }
    let accuracy =
        Accuracy { translation: args.pull_accuracy, rotation: args.rotate_accuracy, ..Accuracy::default() };
    if accuracy.translation <= 0.0 || accuracy.rotation <= 0.0 {
        return Err(Failure::Input(
            "--pull-accuracy and --rotate-accuracy are deviations: write them above 0".into(),
        ));
    }
    let target =
        Target { position: args.position.map(Vector3::from), direction: args.direction.map(Vector3::from) };
    let marks = args.position.map(|p| ("target", vec![p]));
    args.free.search(
        &args.robot,
        &args.command,
        (&args.accuracy, Some(args.friction)),
        |solver, command, free| {
            let find = |solver: &mut Solver| {
                solver.reach(command, free, &target, &accuracy).map_err(|p| free::failure(&p))
            };
            let (answer, resolved) = args.accuracy.search(solver, find, |answer| &answer.equilibrium)?;
            let state = State::of(solver, &resolved);
            outputs.draw(|| figure::marked_shape(solver, &answer.equilibrium, marks.clone()))?;
            finish(args, &outputs, &solver.robot().design().name, free, &state, &Touch::default(), answer)
        },
        |analysis, command, free, friction| {
            let answer = analysis.reach(command, free, &target, &accuracy).map_err(|p| free::failure(&p))?;
            let state = State::of_bundle(analysis, &answer.equilibrium);
            outputs.draw(|| bundle::marked(analysis, &answer.equilibrium, marks.clone()))?;
            let touch = Touch::of(&analysis.solver, &answer.equilibrium, friction, false)?;
            finish(args, &outputs, &analysis.design().name, free, &state, &touch, answer)
        },
    )
}

/// Judges, writes, prints.
fn finish<E>(
    args: &Args,
    outputs: &Outputs,
    name: &str,
    free: &[FreeInput],
    state: &State,
    touch: &Touch,
    mut answer: Reach<E>,
) -> Result<(), Failure> {
    answer.reached = answer.distance.is_none_or(|d| d <= args.tolerance)
        && answer.angle.is_none_or(|a| a <= args.angle_tolerance);
    if let Some(path) = outputs.json {
        let mut whole = as_json(name, free, state, &answer);
        whole["friction"] = json!(touch.friction_json());
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let mut text = table(name, free, state, &answer);
    for (head, value) in touch.lines() {
        line(&mut text, &head, &value);
    }
    outputs.report(&text)
}

fn table<E>(name: &str, free: &[FreeInput], state: &State, answer: &Reach<E>) -> String {
    let verdict = if answer.reached { "reached" } else { "out of reach; this is the nearest pose found" };
    let mut text = format!("{name}: {verdict}\n");
    free::inputs_table(&mut text, free, &answer.values, &answer.at_bound, None);
    line(&mut text, "tip position", &format!("{} mm", three((answer.position * 1e3).into(), 3)));
    line(&mut text, "tip direction", &three(answer.direction.into(), 4));
    if let Some(distance) = answer.distance {
        line(&mut text, "from the target", &format!("{:>9} mm", plain(distance * 1e3, 3)));
    }
    if let Some(angle) = answer.angle {
        line(&mut text, "from its direction", &format!("{:>9} deg", plain(angle.to_degrees(), 3)));
    }
    text.push_str(&state.text);
    if answer.depends_on_path {
        line(&mut text, "warning", "the same values, applied at once from rest, lead to another pose");
    }
    match &answer.conditioning {
        None => line(&mut text, "warning", "the tangent is singular here: a fold"),
        Some(conditioning) => conditioning_table(&mut text, free, conditioning),
    }
    text
}

fn conditioning_table(text: &mut String, free: &[FreeInput], conditioning: &Conditioning) {
    for axis in &conditioning.axes {
        let along = three(axis.direction.into(), 3);
        let rest = if axis.deviation > 0.0 {
            format!("± {:.3} mm", free::HALF * axis.deviation * 1e3)
        } else {
            "cannot move".into()
        };
        line(text, "tip along", &format!("{along}   {rest}"));
    }
    for idle in &conditioning.idle {
        let parts: Vec<String> =
            free.iter().zip(idle).map(|(f, share)| format!("{share:+.2} {}", free::name(f.input))).collect();
        line(text, "tip stays under", &parts.join(", "));
    }
}

fn as_json<E>(name: &str, free: &[FreeInput], state: &State, answer: &Reach<E>) -> Value {
    let conditioning = answer.conditioning.as_ref().map(|c| {
        let axes: Vec<Value> = c
            .axes
            .iter()
            .map(|a| {
                json!({ "direction": <[f64; 3]>::from(a.direction), "standard_deviation_m": a.deviation,
                    "inputs_per_m": a.inputs })
            })
            .collect();
        json!({ "axes": axes, "condition": c.condition, "manipulability_m3": c.manipulability, "idle": c.idle })
    });
    json!({
        "schema": "cppr/reach", "schema_version": 1, "robot": name, "reached": answer.reached,
        "inputs": free::inputs_json(free, &answer.values, &answer.at_bound, None),
        "tip_position_m": <[f64; 3]>::from(answer.position), "tip_direction": <[f64; 3]>::from(answer.direction),
        "distance_m": answer.distance, "angle_rad": answer.angle, "depends_on_path": answer.depends_on_path,
        "actuators": state.actuators, "accuracy": state.accuracy, "conditioning": conditioning,
    })
}
