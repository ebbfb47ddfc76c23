//! What a sweep is, as JSON: written into every result, and compared before an interrupted sweep goes on.

use crate::axis::Values;
use crate::table::{ColumnKind, Verdict};
use crate::task::{Plan, Subject, Task};
use cppr::analysis::Teeth;
use cppr::bundle::{Friction, TubeParts};
use cppr_io::result::{CommandRecord, ResolutionRecord, formulation_name};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Version of the columns and of this description.
pub(crate) const SCHEMA_VERSION: u32 = 2;

pub(crate) fn manifest(task: &Task) -> Value {
    let axes: Vec<Value> = task
        .axes
        .iter()
        .map(|axis| {
            let column = axis.variable.column(task.loads());
            match axis.values {
                Values::Range { from, to, count: 0 } => json!({ "column": column, "from": from, "to": to }),
                Values::Range { from, to, count } => {
                    json!({ "column": column, "from": from, "to": to, "count": count })
                }
                Values::Normal { mean, deviation } => {
                    json!({ "column": column, "mean": mean, "standard_deviation": deviation })
                }
            }
        })
        .collect();
    let plan = match &task.plan {
        Plan::Grid => json!({ "kind": "grid" }),
        Plan::Samples { count, seed } => {
            json!({ "kind": "samples", "count": count, "seed": seed, "sequence": "scrambled Halton" })
        }
        Plan::List(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            json!({ "kind": "list", "sha256": hex(&bytes) })
        }
    };
    let codes: Map<String, Value> =
        Verdict::ALL.iter().map(|v| (v.code().to_string(), v.text().into())).collect();
    let columns: Vec<Value> = task
        .columns()
        .into_iter()
        .map(|column| {
            let kind = match column.kind {
                ColumnKind::Number => "number",
                ColumnKind::Status => "status",
                ColumnKind::Count => "count",
            };
            json!({ "name": column.name, "kind": kind })
        })
        .collect();
    let (command, formulation, resolution, tolerance, stretch) = match &task.subject {
        Subject::Robot(own) => (
            CommandRecord::new(&own.base, &own.robot),
            formulation_name(own.settings.formulation),
            Some(ResolutionRecord::from(own.settings.resolution)),
            Some(own.settings.tolerance),
            None,
        ),
        Subject::Bundle(own) => {
            let length = own.design.tubes.first().map_or(0.0, TubeParts::length);
            (CommandRecord::of_bundle(&own.base, length), "bundle", None, None, Some(own.stretch))
        }
    };
    let mut whole = json!({
        "schema": "cppr/sweep",
        "schema_version": SCHEMA_VERSION,
        "cppr_version": env!("CARGO_PKG_VERSION"),
        "robot": task.name(),
        "robot_length_m": task.length(),
        "robot_file": task.robot_text,
        "robot_file_sha256": hex(task.robot_text.as_bytes()),
        "command": command,
        "formulation": formulation,
        "resolution": resolution,
        "tolerance": tolerance,
        "teeth": task.limits.map(|teeth| if teeth == Teeth::Rigid { "rigid" } else { "bending" }),
        "plan": plan,
        "axes": axes,
        "rows": task.rows(),
        "columns": columns,
        "status_codes": codes,
    });
    if let Some(stretch) = stretch {
        whole["stretch"] = stretch.into();
    }
    if let Some(Friction { coefficient, guide }) = task.friction {
        whole["friction"] = json!({ "coefficient": coefficient, "guide_m": guide });
    }
    whole
}

/// Names of the entries in which two descriptions differ.
pub(crate) fn differences(one: &Value, other: &Value) -> Vec<String> {
    let (Some(one), Some(other)) = (one.as_object(), other.as_object()) else {
        return vec!["everything".into()];
    };
    one.iter().filter(|(key, value)| other.get(*key) != Some(value)).map(|(key, _)| key.clone()).collect()
}

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
