//! `cppr derivatives` for bundles: how the tip answers to every motor.

use crate::Failure;
use crate::bundle::{Ready, no_equilibrium};
use crate::derivatives::Args;
use crate::free::name;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::table::plain;
use cppr::bundle::BundleDesign;
use cppr::bundle::solve::BundleSolver;
use serde_json::json;
use std::fmt::Write;

/// Differentiates, prints, writes.
pub fn run(args: &Args, outputs: &Outputs, design: &BundleDesign) -> Result<(), Failure> {
    if !args.by.is_empty() {
        return Err(Failure::Input(
            "--by is not yet for a robot with parts or joints; leave it away, or solve at two values".into(),
        ));
    }
    let Ready { bundle, command, stretch } = Ready::new(&args.command, &args.robot, design)?;
    let mut solver = BundleSolver::new(&bundle).with_stretch(stretch);
    let found = solver.solve(&command);
    if !found.converged {
        return Err(no_equilibrium(&design.name, &found));
    }
    let exact = solver.sensitivity(&found).ok_or_else(|| {
        Failure::NoEquilibrium("the tangent is singular here, at a fold: nothing has a derivative".into())
    })?;
    let (inputs, jacobian) = (&exact.inputs, &exact.tip_jacobian);
    if let Some(path) = outputs.json {
        let m = inputs.len();
        let rows = |rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            (0..rows).map(|r| (0..columns).map(|c| at(r, c)).collect()).collect()
        };
        let inputs = inputs.iter().map(|i| json!({ "tube": i.tube, "actuator": i.quantity().keyword }));
        let whole = json!({
            "schema": "cppr/bundle-derivatives", "schema_version": 1, "robot": design.name,
            "inputs": inputs.collect::<Vec<_>>(), "tip_jacobian": rows(6, m, &|r, c| jacobian[(r, c)]),
            "tip_jacobian_body": rows(6, m, &|r, c| exact.tip_jacobian_body[(r, c)]),
            "response": rows(m, m, &|r, c| exact.response[(r, c)]),
            "tip_compliance": rows(6, 6, &|r, c| exact.compliance[(r, c)]),
            "response_by_wrench": rows(m, 6, &|r, c| exact.response_by_wrench[(r, c)]),
        });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let degree = 1.0_f64.to_radians();
    let status = found.verdict();
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
