//! `cppr derivatives`: how tip and efforts answer to actuators, loads and any number of the robot file.

use crate::Failure;
use crate::bundle_derivatives;
use crate::command::{CommandArgs, build};
use crate::free::{efforts_json, name};
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::resolved::AccuracyArgs;
use crate::table::plain;
use cppr::analysis::{Perturbed, Sensitivity};
use cppr::design::Robot;
use cppr::solve::{Equilibrium, Freedom, Input, Solver};
use cppr::statics::RotationMeans;
use cppr::{Matrix3, Vector3};
use cppr_io::bundle_file::Described;
use cppr_sweep::DesignKeys;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr derivatives robots/r3.toml --pull 5mm
  cppr derivatives robots/r3.toml --pull 5mm --rotate 20deg --by material.youngs_modulus_GPa,tube2.notches.depth_mm.0
  cppr derivatives robots/childs3.toml --pull 2=1mm --tension 3=-2N --by tube3.stiffness.centroid_offset_mm --json -
  cppr derivatives robots/bundles/two_sections.toml --pull 2=3mm --pull 4=2mm --by tube2.stiffness.centroid_offset_mm,tube3.part2.length_mm

Keys are those of the robot file, as for cppr sweep --vary. Columns: tip position (mm), tip rotation about the base frame's axes (deg),
and what each actuator exerts (N, N mm) or, where its effort is given, where it stands (mm, deg).";

/// Step of a parameter against its value.
const STEP: f64 = 1e-3;
/// The same of a robot with parts or joints, whose equilibria are found anew with another error of their integration.
pub const STEP_OF_PARTS: f64 = 4e-3;

/// Components of a wrench on the tip, and the sizes of their units (SI).
pub const LOADS: [(&str, f64); 6] = [
    ("tip force x (N)", 1.0),
    ("tip force y (N)", 1.0),
    ("tip force z (N)", 1.0),
    ("tip moment x (N mm)", 1e-3),
    ("tip moment y (N mm)", 1e-3),
    ("tip moment z (N mm)", 1e-3),
];

/// Arguments of `cppr derivatives`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    pub robot: PathBuf,
    #[command(flatten)]
    pub command: CommandArgs,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Numbers of the robot file to differentiate by
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    pub by: Vec<String>,
    /// Write everything in SI units, - for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Derivatives by one number of the robot file, in the unit of its key.
pub struct ByKey {
    pub key: String,
    /// Tip twist per unit: m and rad.
    pub twist: [f64; 6],
    /// Conjugate of every input per unit (SI).
    pub response: Vec<f64>,
}

/// The text of a robot file.
pub fn as_written(robot: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(robot)
        .map_err(|e| Failure::Input(format!("{}: cannot be read: {e}", robot.display())))
}

/// A number of a robot file, ready to be moved, and its value.
pub fn moved_keys(text: &str, key: &str) -> Result<(DesignKeys, f64), Failure> {
    let fail = |why: String| Failure::Input(format!("--by {key}: {why}"));
    let keys = DesignKeys::new(text, &[key]).map_err(|p| fail(p.to_string()))?;
    let value = keys.values()[0];
    if value.abs() <= 0.0 {
        return Err(fail("the value is 0, from which no step follows; write it away from 0".into()));
    }
    Ok((keys, value))
}

/// A rotation from one that is near, first order in their distance (rad): its antisymmetric part.
pub fn spin_from(rotation: &Matrix3<f64>, before: &Matrix3<f64>) -> Vector3<f64> {
    let turn = rotation * before.transpose();
    Vector3::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]) * 0.5
}

/// Differentiates, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [args.json.as_deref(), None, None])?;
    let robot = match args.accuracy.described(&args.robot, args.command.rest.needs_modes())? {
        Described::Robot(file) => build(&file, &args.robot)?,
        Described::Bundle { design, .. } => return bundle_derivatives::run(args, &outputs, &design),
    };
    let command = args.command.command(&robot)?;
    let mut solver = args.command.solver(&robot)?;
    let resolved = args.accuracy.solve_resolved(&mut solver, &command)?;
    let found = &resolved.found;
    let exact = solver.sensitivity(found).map_err(|_| {
        Failure::NoEquilibrium("the tangent is singular here, at a fold: nothing has a derivative".into())
    })?;
    let text = as_written(&args.robot)?;
    let mut keys = Vec::new();
    for key in &args.by {
        keys.push(by_key(&text, key.trim(), &mut solver, found, &exact)?);
    }
    if let Some(path) = outputs.json {
        let mut whole = as_json(&robot, found, &exact, &keys);
        whole["accuracy"] = resolved.json();
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let mut text = table(&robot, found, &exact, &keys);
    for (head, value) in resolved.lines() {
        let _ = writeln!(text, "  {head:<12}{value}");
    }
    outputs.report(&text)
}

fn by_key(
    text: &str,
    key: &str,
    solver: &mut Solver,
    found: &Equilibrium,
    exact: &Sensitivity,
) -> Result<ByKey, Failure> {
    let fail = |why: String| Failure::Input(format!("--by {key}: {why}"));
    let (keys, value) = moved_keys(text, key)?;
    let at = |by: f64| keys.clone().robot(&[value + by]).ok();
    let moved = Perturbed::new(STEP * value, at)
        .ok_or_else(|| fail(format!("no robot can be built with a value {} % off", 200.0 * STEP)))?;
    let cppr::kinematics::TipPose { rotation: before, .. } = solver.tip(found);
    let read = |solver: &mut Solver, found: &Equilibrium| -> Vec<f64> {
        let cppr::kinematics::TipPose { rotation, centre: tip } = solver.tip(found);
        let spin = spin_from(&rotation, &before);
        let mut values: Vec<f64> = tip.iter().chain(spin.iter()).copied().collect();
        values.extend(conjugates(solver, found, &exact.inputs));
        values
    };
    let slopes = solver
        .parameter_sensitivity(found, &moved, read)
        .map_err(|_| Failure::NoEquilibrium(format!("--by {key}: nothing has a derivative here")))?;
    let mut twist = [0.0; 6];
    twist.copy_from_slice(&slopes[..6]);
    Ok(ByKey { key: key.into(), twist, response: slopes[6..].to_vec() })
}

/// What answers to every input: its effort where its motion is given, its motion where its effort is.
fn conjugates(solver: &mut Solver, found: &Equilibrium, inputs: &[Input]) -> Vec<f64> {
    let base = solver.shape_at(found, &[0.0]).sections.remove(0);
    let conjugate = |input: &Input| {
        let tube = input.tube - 1;
        let motion = base.tubes[tube].abscissa;
        match (input.freedom, input.is_motion) {
            // Efforts move with the unknowns.
            (_, true) => {
                found.actuator(input.tube).map_or(f64::NAN, |state| state.get(input.conjugate().quantity()))
            }
            (Freedom::PushPull, false) => motion,
            (Freedom::Rotation, false) => {
                let direction = |x: f64| found.robot().fields_at(tube, x).direction;
                let slid = match found.command().rotation_means {
                    RotationMeans::Base => direction(0.0) - direction(motion),
                    RotationMeans::RelativeAngle => 0.0,
                };
                slid - base.angles[tube - 1]
            }
        }
    };
    inputs.iter().map(conjugate).collect()
}

fn table(robot: &Robot, found: &Equilibrium, exact: &Sensitivity, keys: &[ByKey]) -> String {
    let degree = 1.0_f64.to_radians();
    let sizes: Vec<f64> = [1e-3, 1e-3, 1e-3, degree, degree, degree]
        .into_iter()
        .chain(exact.inputs.iter().map(|i| i.conjugate().quantity().shown_size))
        .collect();
    let mut heads: Vec<String> =
        ["x mm", "y mm", "z mm", "rot x deg", "rot y deg", "rot z deg"].map(String::from).into();
    heads.extend(exact.inputs.iter().map(|i| {
        let answer = i.conjugate();
        format!("{} {}", name(answer).replace("tube ", "t"), answer.quantity().shown_unit)
    }));
    let mut text = format!("{}: {}\n", robot.design().name, crate::table::status(found));
    let mut line = |head: &str, cells: Vec<String>| {
        let _ = write!(text, "  {head:<30}");
        for cell in cells {
            let _ = write!(text, "{cell:>16}");
        }
        text.push('\n');
    };
    line("by", heads);
    let mut row = |head: String, values: Vec<f64>, per: f64| {
        let cells = values.iter().zip(&sizes).map(|(v, size)| plain(v * per / size, 4)).collect();
        line(&head, cells);
    };
    for (c, input) in exact.inputs.iter().enumerate() {
        let values =
            exact.tip_jacobian.column(c).iter().chain(exact.response.column(c).iter()).copied().collect();
        let quantity = input.quantity();
        row(format!("{} ({})", name(*input), quantity.shown_unit), values, quantity.shown_size);
    }
    for (c, (head, size)) in LOADS.into_iter().enumerate() {
        let answers = exact.response_by_wrench.column(c);
        let values = exact.compliance.column(c).iter().chain(answers.iter()).copied().collect();
        row(head.into(), values, size);
    }
    for by in keys {
        row(by.key.clone(), by.twist.iter().chain(&by.response).copied().collect(), 1.0);
    }
    text
}

fn as_json(robot: &Robot, found: &Equilibrium, exact: &Sensitivity, keys: &[ByKey]) -> Value {
    let inputs: Vec<Value> = exact
        .inputs
        .iter()
        .map(|i| {
            let full = name(*i);
            json!({ "tube": i.tube, "actuator": full.rsplit(' ').next().unwrap_or_default() })
        })
        .collect();
    let rows = |rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..rows).map(|r| (0..columns).map(|c| at(r, c)).collect()).collect()
    };
    let m = exact.inputs.len();
    let keys: Vec<Value> = keys
        .iter()
        .map(|by| json!({ "key": by.key, "tip_twist_per_unit": by.twist, "response_per_unit": by.response }))
        .collect();
    json!({
        "schema": "cppr/derivatives", "schema_version": 1, "robot": robot.design().name, "inputs": inputs,
        "actuators": efforts_json(found),
        "tip_jacobian": rows(6, m, &|r, c| exact.tip_jacobian[(r, c)]),
        "tip_jacobian_body": rows(6, m, &|r, c| exact.tip_jacobian_body[(r, c)]),
        "response": rows(m, m, &|r, c| exact.response[(r, c)]),
        "tip_compliance": rows(6, 6, &|r, c| exact.compliance[(r, c)]),
        "response_by_wrench": rows(m, 6, &|r, c| exact.response_by_wrench[(r, c)]),
        "by": keys,
    })
}
