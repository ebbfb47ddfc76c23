//! `cppr continue` for a robot with parts or joints.

use crate::Failure;
use crate::bundle::{Ready, actuators};
use crate::continuation::{Along, Args, table};
use crate::continuation_figure::draw;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::Kind;
use crate::table::{counted, millimetres};
use cppr::analysis::continuation::{Branch, End, FamilyProblem, Parameter, PathPoint};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::bundle::{BundleDesign, BundleFamily};
use cppr::solve::{Drive, Freedom};
use cppr_io::continuation::{end_word, kind_word, parameter_name};
use serde_json::{Value, json};
use std::fmt::Write;

/// Traces, prints, writes.
pub fn run(args: &Args, outputs: &Outputs, design: &BundleDesign) -> Result<(), Failure> {
    let Ready { bundle, command, stretch } = Ready::new(&args.command, &args.robot, design)?;
    let family = family(args, command).map_err(Failure::Input)?;
    let mut solver = BundleSolver::new(&bundle).with_stretch(stretch);
    let branches = solver.trace(&family, &args.tracing());
    if let [Branch { end: end @ End::NoStart(_), .. }] = &branches[..] {
        let at = solver.solve(&family.at(0.0)).verdict();
        return Err(Failure::NoEquilibrium(format!(
            "{}: the path {end}. At its beginning: {at}",
            design.name
        )));
    }
    if let Some(path) = outputs.json {
        write_or_print(path, &format!("{:#}\n", record(design, &family, &branches)))?;
    }
    if let Some(path) = outputs.csv {
        write_or_print(path, &csv(design, &family, &branches))?;
    }
    let varies = family.parameter();
    let conjugate = |point: &PathPoint<BundleEquilibrium>| answer(varies, &point.equilibrium);
    outputs.draw(|| Ok(draw(design.name.clone(), varies, &branches, conjugate)))?;
    let (tubes, joints) = (counted(design.tubes.len(), "tube"), counted(design.joints.len(), "joint"));
    let head = format!("{}: {tubes}, {joints}, {} mm", design.name, millimetres(bundle.length()));
    outputs.report(&table(&head, varies, &branches, conjugate))
}

/// What a motor answers at the plate.
fn answer(varies: Parameter, found: &BundleEquilibrium) -> Option<f64> {
    let Parameter::Actuator(input) = varies else { return None };
    let own = found.efforts.get(input.tube.checked_sub(1)?)?;
    Some(match (input.freedom, input.is_motion) {
        (Freedom::PushPull, true) => own.force,
        (Freedom::PushPull, false) => own.label,
        (Freedom::Rotation, true) => own.torque,
        (Freedom::Rotation, false) => own.rotation,
    })
}

fn family(args: &Args, command: BundleCommand) -> Result<BundleFamily, String> {
    let said = |problem: FamilyProblem| problem.to_string();
    match args.along {
        Along::Actuator(input) => {
            let (from, to) = args.ends(Some(Kind::of(input.quantity())))?;
            let tube = input.tube;
            let drives = tube.checked_sub(1).and_then(|index| command.drives.get(index));
            let Some(own) = drives else { return Err(format!("--along: there is no tube {tube}")) };
            let given = match if input.freedom == Freedom::PushPull { own.translation } else { own.rotation }
            {
                drive if drive.is_motion() == input.is_motion => drive.value(),
                // What is not said is held where it is at rest.
                Drive::Motion(value) if value.abs() <= 0.0 => 0.0,
                _ => {
                    return Err(format!(
                        "--along: tube {tube} is driven by motion and by effort; choose one"
                    ));
                }
            };
            BundleFamily::motor(command.with_input(input, from.unwrap_or(given)), input, to).map_err(said)
        }
        Along::Load => {
            let (from, to) = args.ends(None)?;
            if command.loads.is_empty() {
                return Err("--along load: there is no load; add for instance --tip-force".into());
            }
            BundleFamily::load(command, from.unwrap_or(0.0), to).map_err(said)
        }
        Along::Command => {
            let (from, to) = args.ends(None)?;
            BundleFamily::scaled(&command, from.unwrap_or(0.0), to).map_err(said)
        }
    }
}

fn record(design: &BundleDesign, family: &BundleFamily, branches: &[Branch<BundleEquilibrium>]) -> Value {
    let (parameter, tube) = parameter_name(family.parameter());
    let point = |p: &PathPoint<BundleEquilibrium>| {
        json!({
            "kind": kind_word(p.kind), "parameter": p.parameter, "stable": p.is_stable(), "inertia": p.inertia,
            "tip_position_m": <[f64; 3]>::from(p.tip), "actuators": actuators(design, &p.equilibrium),
        })
    };
    let branch = |b: &Branch<BundleEquilibrium>| {
        let origin = b
            .origin
            .map(|o| json!({ "branch": o.branch, "point": o.point, "mode": o.mode, "along": o.along }));
        json!({
            "end": end_word(b.end), "end_text": b.end.to_string(), "origin": origin,
            "points": b.points.iter().map(point).collect::<Vec<_>>(),
        })
    };
    json!({
        "schema": "cppr/bundle-continuation", "schema_version": 1, "cppr_version": env!("CARGO_PKG_VERSION"),
        "robot": { "name": design.name, "tubes": design.tubes.len() },
        "parameter": parameter, "parameter_tube": tube,
        "branches": branches.iter().map(branch).collect::<Vec<_>>(),
    })
}

/// One row per point, its branch counted from 1.
fn csv(design: &BundleDesign, family: &BundleFamily, branches: &[Branch<BundleEquilibrium>]) -> String {
    let mut text = format!(
        "branch,kind,parameter_{},stable,inertia,tip_x_m,tip_y_m,tip_z_m",
        parameter_name(family.parameter()).0
    );
    for tube in 1..=design.tubes.len() {
        for column in ["pull_m", "rotation_rad", "tension_N", "torque_Nm"] {
            let _ = write!(text, ",tube{tube}_{column}");
        }
    }
    text.push('\n');
    for (number, branch) in (1..).zip(branches) {
        for p in &branch.points {
            let inertia = p.inertia.map_or(String::new(), |count| count.to_string());
            let [x, y, z] = <[f64; 3]>::from(p.tip);
            let (kind, parameter, stable) = (kind_word(p.kind), p.parameter, p.is_stable());
            let _ = write!(text, "{number},{kind},{parameter},{stable},{inertia},{x},{y},{z}");
            for own in &p.equilibrium.efforts {
                let _ = write!(text, ",{},{},{},{}", own.label, own.rotation, own.force, own.torque);
            }
            text.push('\n');
        }
    }
    text
}
