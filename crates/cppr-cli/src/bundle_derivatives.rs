//! `cppr derivatives` for bundles: how the tip answers to every motor.

use crate::Failure;
use crate::bundle::{check, no_equilibrium, status};
use crate::command::unsound;
use crate::derivatives::Args;
use crate::free::name;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::table::plain;
use cppr::bundle::solve::{BundleCommand, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::solve::{Freedom, Input};
use serde_json::json;
use std::fmt::Write;

/// Differentiates, prints, writes.
pub fn run(args: &Args, outputs: &Outputs, design: &BundleDesign) -> Result<(), Failure> {
    if !args.by.is_empty() {
        return Err(Failure::Input(
            "--by is not yet for a robot with parts or joints; leave it away, or solve at two values".into(),
        ));
    }
    let (command, stretch) = args.command.bundle_command(design)?;
    let bundle = Bundle::new(design).map_err(|problems| unsound(&args.robot, &problems))?;
    check(design, &bundle, &command, stretch)?;
    let mut solver = BundleSolver::new(&bundle).with_stretch(stretch);
    let found = solver.solve(&command);
    if !found.converged {
        return Err(no_equilibrium(&design.name));
    }
    let jacobian = solver.tip_jacobian(&found).ok_or_else(|| {
        Failure::NoEquilibrium("the tangent is singular here, at a fold: nothing has a derivative".into())
    })?;
    let inputs = inputs(&command);
    if let Some(path) = outputs.json {
        let rows: Vec<Vec<f64>> = jacobian.row_iter().map(|row| row.iter().copied().collect()).collect();
        let inputs = inputs.iter().map(|i| json!({ "tube": i.tube, "actuator": i.quantity().keyword }));
        let whole = json!({
            "schema": "cppr/bundle-derivatives", "schema_version": 1, "robot": design.name,
            "inputs": inputs.collect::<Vec<_>>(), "tip_jacobian": rows,
        });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let degree = 1.0_f64.to_radians();
    let status = status(&found);
    let mut text = format!("{}: {status}\n  {:<26}", design.name, "by");
    for head in ["x mm", "y mm", "z mm", "rot x deg", "rot y deg", "rot z deg"] {
        let _ = write!(text, "{head:>14}");
    }
    text.push('\n');
    for (column, input) in inputs.iter().enumerate() {
        let quantity = input.quantity();
        let _ = write!(text, "  {:<26}", format!("{} ({})", name(*input), quantity.shown_unit));
        for (row, size) in [1e-3, 1e-3, 1e-3, degree, degree, degree].into_iter().enumerate() {
            let slope = jacobian[(row, column)] * quantity.shown_size / size;
            let _ = write!(text, "{:>14}", plain(slope, 4));
        }
        text.push('\n');
    }
    outputs.report(&text)
}

/// What is prescribed of every tube, in the order of the Jacobian's columns.
fn inputs(command: &BundleCommand) -> Vec<Input> {
    let own = |(index, drive): (usize, &cppr::bundle::solve::TubeDrive)| {
        [(Freedom::PushPull, drive.translation), (Freedom::Rotation, drive.rotation)]
            .map(|(freedom, told)| Input { tube: index + 1, freedom, is_motion: told.is_motion() })
    };
    command.drives.iter().enumerate().flat_map(own).collect()
}
