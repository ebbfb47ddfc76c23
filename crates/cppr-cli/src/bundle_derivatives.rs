//! `cppr derivatives` for bundles: how tip and efforts answer to motors, to a wrench on the tip, and to any number of the robot file.

use crate::Failure;
use crate::bundle::{Ready, no_equilibrium};
use crate::derivatives::{Args, ByKey, LOADS, STEP_OF_PARTS, as_written, moved_keys, spin_from};
use crate::free::name;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::table::plain;
use cppr::analysis::{BundleAnalysis, MovedBundle, Sensitivity, Settled};
use cppr::bundle::BundleDesign;
use cppr::bundle::solve::BundleEquilibrium;
use cppr::solve::{Freedom, Input};
use serde_json::json;
use std::fmt::Write;

/// Differences that change by more than this part of the greatest when their step is halved have not settled.
const SETTLED: f64 = 1e-2;

/// Differentiates, prints, writes.
pub fn run(args: &Args, outputs: &Outputs, design: &BundleDesign) -> Result<(), Failure> {
    let ready = Ready::new(&args.command, &args.robot, design)?;
    let mut analysis = ready.analysis(design);
    let found = analysis.solver.solve(&ready.command);
    if !found.converged {
        return Err(no_equilibrium(&design.name, &found));
    }
    crate::bundle::check_loads(&ready.command, &found)?;
    let exact = analysis.solver.sensitivity(&found).ok_or_else(|| {
        Failure::NoEquilibrium("the tangent is singular here, at a fold: nothing has a derivative".into())
    })?;
    let mut keys = Vec::new();
    if !args.by.is_empty() {
        let text = as_written(&args.robot)?;
        for key in &args.by {
            keys.push(by_key(&text, key.trim(), &analysis, &found, &exact.inputs)?);
        }
    }
    if let Some(path) = outputs.json {
        write_or_print(path, &as_json(design, &exact, &keys))?;
    }
    outputs.report(&table(design, &found, &exact, &keys))
}

/// Derivatives by one number of the robot file, and by which part of the greatest they change when the step is halved.
fn by_key(
    text: &str,
    key: &str,
    analysis: &BundleAnalysis,
    found: &BundleEquilibrium,
    inputs: &[Input],
) -> Result<(ByKey, f64), Failure> {
    let (mut keys, value) = moved_keys(text, key)?;
    let fail = |why: String| Failure::Input(format!("--by {key}: {why}"));
    let at = |by: f64| keys.bundle(&[value + by]).ok().map(|own| own.0);
    let moved = MovedBundle::new(STEP_OF_PARTS * value, at)
        .ok_or_else(|| fail(format!("no robot can be built with a value {} % off", 100.0 * STEP_OF_PARTS)))?;
    let read = |own: &BundleEquilibrium| -> Vec<f64> {
        let spin = spin_from(&own.frame, &found.frame);
        let mut values: Vec<f64> = own.tip.iter().chain(spin.iter()).copied().collect();
        values.extend(inputs.iter().map(|input| answer(own, input.conjugate())));
        values
    };
    let Settled { slopes, changes } = analysis
        .parameter_sensitivity(found, &moved, |_, own| read(own))
        .map_err(|problem| Failure::NoEquilibrium(format!("--by {key}: {problem}")))?;
    let change = part_of_greatest(found, inputs, value, &slopes, &changes);
    if change > SETTLED {
        return Err(Failure::NoEquilibrium(format!(
            "--by {key}: the differences do not settle: with steps half as long they change by {} %. The robot is next to a fold, or to a place where its \
             fields jump",
            plain(100.0 * change, 1)
        )));
    }
    let mut twist = [0.0; 6];
    twist.copy_from_slice(&slopes[..6]);
    Ok((ByKey { key: key.into(), twist, response: slopes[6..].to_vec() }, change))
}

/// Where a motor stands, or what it exerts.
fn answer(found: &BundleEquilibrium, input: Input) -> f64 {
    let own = input.tube.checked_sub(1).and_then(|tube| found.efforts.get(tube));
    own.map_or(f64::NAN, |own| match (input.freedom, input.is_motion) {
        (Freedom::PushPull, true) => own.label,
        (Freedom::PushPull, false) => own.force,
        (Freedom::Rotation, true) => own.rotation,
        (Freedom::Rotation, false) => own.torque,
    })
}

/// The greatest change as a part of the greatest slope: of what moves per part of the parameter's value, lengths as parts of the robot's, forces and torques as
/// parts of the greatest.
fn part_of_greatest(
    found: &BundleEquilibrium,
    inputs: &[Input],
    value: f64,
    slopes: &[f64],
    changes: &[f64],
) -> f64 {
    let length = found.length;
    let force = found.efforts.iter().fold(f64::MIN_POSITIVE, |most, own| most.max(own.force.abs()));
    let torque = found.efforts.iter().fold(length * force, |most, own| most.max(own.torque.abs()));
    let of_answer = |input: &Input| match (input.freedom, input.conjugate().is_motion) {
        (Freedom::PushPull, true) => length,
        (Freedom::PushPull, false) => force,
        (Freedom::Rotation, true) => 1.0,
        (Freedom::Rotation, false) => torque,
    };
    let units = [length, length, length, 1.0, 1.0, 1.0].into_iter().chain(inputs.iter().map(of_answer));
    let greatest = |list: &[f64]| {
        let own = list.iter().zip(units.clone()).map(|(own, unit)| (own * value / unit).abs());
        own.fold(0.0, f64::max)
    };
    // Slopes below this part are nothing.
    greatest(changes) / greatest(slopes).max(1e-6)
}

/// One row of the table.
struct Row {
    head: String,
    /// Of the unit that the head names (SI).
    size: f64,
    /// The tip's twist, and what the motors answer (SI).
    parts: [Vec<f64>; 2],
}

/// Two blocks, whose columns are components of the tip's twist and answers of the motors.
fn table(
    design: &BundleDesign,
    found: &BundleEquilibrium,
    exact: &Sensitivity,
    keys: &[(ByKey, f64)],
) -> String {
    let degree = 1.0_f64.to_radians();
    let inputs = &exact.inputs;
    let mut rows: Vec<Row> = Vec::new();
    let m = inputs.len();
    let column = |count: usize, at: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..count).map(at).collect() };
    for (c, input) in inputs.iter().enumerate() {
        let quantity = input.quantity();
        let head = format!("{} ({})", name(*input), quantity.shown_unit);
        let twist = column(6, &|r| exact.tip_jacobian[(r, c)]);
        let answers = column(m, &|r| exact.response[(r, c)]);
        rows.push(Row { head, size: quantity.shown_size, parts: [twist, answers] });
    }
    for (c, (head, size)) in LOADS.into_iter().enumerate() {
        let twist = column(6, &|r| exact.compliance[(r, c)]);
        let answers = column(m, &|r| exact.response_by_wrench[(r, c)]);
        rows.push(Row { head: head.into(), size, parts: [twist, answers] });
    }
    for (by, _) in keys {
        let parts = [by.twist.to_vec(), by.response.clone()];
        rows.push(Row { head: by.key.clone(), size: 1.0, parts });
    }
    let tip: Vec<(String, f64)> = ["x mm", "y mm", "z mm", "rot x deg", "rot y deg", "rot z deg"]
        .into_iter()
        .zip([1e-3, 1e-3, 1e-3, degree, degree, degree])
        .map(|(head, size)| (head.into(), size))
        .collect();
    let motors: Vec<(String, f64)> = inputs
        .iter()
        .map(|input| {
            let answer = input.conjugate();
            let quantity = answer.quantity();
            let head = format!("{} {}", name(answer).replace("tube ", "t"), quantity.shown_unit);
            (head, quantity.shown_size)
        })
        .collect();
    let mut text = format!("{}: {}\n", design.name, found.verdict());
    for (part, columns) in [tip, motors].iter().enumerate() {
        let _ = write!(text, "  {:<30}", "by");
        for (head, _) in columns {
            let _ = write!(text, "{head:>16}");
        }
        text.push('\n');
        for Row { head, size, parts } in &rows {
            let _ = write!(text, "  {head:<30}");
            for (value, (_, unit)) in parts[part].iter().zip(columns) {
                let _ = write!(text, "{:>16}", plain(value * size / unit, 4));
            }
            text.push('\n');
        }
    }
    let change = keys.iter().map(|(_, change)| *change).fold(0.0, f64::max);
    if !keys.is_empty() {
        let _ = writeln!(
            text,
            "  by numbers of the file: differences; with steps half as long they change by at most {change:.0e} of the greatest"
        );
    }
    text
}

fn as_json(design: &BundleDesign, exact: &Sensitivity, keys: &[(ByKey, f64)]) -> String {
    let m = exact.inputs.len();
    let rows = |rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..rows).map(|r| (0..columns).map(|c| at(r, c)).collect()).collect()
    };
    let inputs = exact.inputs.iter().map(|i| json!({ "tube": i.tube, "actuator": i.quantity().keyword }));
    let by = keys.iter().map(|(by, change)| {
        json!({
            "key": by.key, "tip_twist_per_unit": by.twist, "response_per_unit": by.response, "change_on_halving": change,
        })
    });
    let whole = json!({
        "schema": "cppr/bundle-derivatives", "schema_version": 1, "robot": design.name,
        "inputs": inputs.collect::<Vec<_>>(), "tip_jacobian": rows(6, m, &|r, c| exact.tip_jacobian[(r, c)]),
        "tip_jacobian_body": rows(6, m, &|r, c| exact.tip_jacobian_body[(r, c)]),
        "response": rows(m, m, &|r, c| exact.response[(r, c)]),
        "tip_compliance": rows(6, 6, &|r, c| exact.compliance[(r, c)]),
        "response_by_wrench": rows(m, 6, &|r, c| exact.response_by_wrench[(r, c)]),
        "by": by.collect::<Vec<_>>(),
    });
    format!("{whole:#}\n")
}
