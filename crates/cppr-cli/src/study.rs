//! What a sampled sweep says of tolerances, as text and for JSON.

use crate::cloud::in_shown_unit;
use crate::table::plain;
use cppr_sweep::{PERCENTILES, Report};
use serde_json::{Value, json};
use std::fmt::Write;

/// Mean, deviation, percentiles and range of every output; then the inputs by what they do to the tip.
pub fn text(report: &Report) -> String {
    let mut text = format!("  over {} stable poses\n", report.count);
    let heads = PERCENTILES.map(|p| format!("{p} %"));
    let [low, middle, high] = heads.each_ref().map(String::as_str);
    let heads = ["mean", "deviation", low, middle, high, "least", "greatest"];
    let _ = write!(text, "    {:<32}", "");
    for head in heads {
        let _ = write!(text, "{head:>11}");
    }
    text.push('\n');
    for output in &report.outputs {
        let (name, unit, factor) = in_shown_unit(&output.name);
        let _ =
            write!(text, "    {:<32}", format!("{name}{}{unit}", if unit.is_empty() { "" } else { ", " }));
        let [low, middle, high] = output.percentiles;
        let digits = decimals(factor * output.deviation);
        for value in [output.mean, output.deviation, low, middle, high, output.range[0], output.range[1]] {
            let _ = write!(text, "{:>11}", plain(factor * value, digits));
        }
        text.push('\n');
    }
    if report.inputs.is_empty() {
        text +=
            "  too few poses to tell which input matters: take more samples than twice the inputs and two\n";
        return text;
    }
    text +=
        "  what one standard deviation of an input does to the tip, and its share of the tip's variance\n";
    for input in &report.inputs {
        let name = input.name.strip_prefix("input_").unwrap_or(&input.name);
        let (tip, share) = (plain(1e3 * input.tip, decimals(1e3 * input.tip)), plain(100.0 * input.share, 1));
        let _ = writeln!(text, "    {name:<43}{tip:>11} mm {share:>8} %");
    }
    let _ = writeln!(text, "    {:<43}{:>23} %", "linear in the inputs", plain(100.0 * report.linear, 1));
    text
}

/// The same numbers in the units of the table's columns.
pub fn json(report: &Report) -> Value {
    let outputs: Vec<Value> = report
        .outputs
        .iter()
        .map(|o| {
            json!({ "column": o.name, "mean": o.mean, "deviation": o.deviation, "percentiles": o.percentiles,
                "range": o.range })
        })
        .collect();
    let inputs: Vec<Value> = report
        .inputs
        .iter()
        .map(|i| json!({ "column": i.name, "deviation": i.deviation, "tip_m": i.tip, "share": i.share }))
        .collect();
    json!({
        "stable_poses": report.count, "percentiles_at": PERCENTILES, "outputs": outputs, "inputs": inputs,
        "linear_share": report.linear,
    })
}

/// Decimals that show three digits of a size.
fn decimals(size: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 9")]
    let digits = (3.0 - size.log10().ceil()).clamp(0.0, 9.0) as usize;
    digits
}
