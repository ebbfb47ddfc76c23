//! Clearance as JSON: SI units, the unit in every key.

use cppr::clearance::Estimate;
use serde_json::{Value, json};

/// What clearance makes of an equilibrium, estimated.
#[must_use]
pub fn estimate(own: &Estimate) -> Value {
    let pairs = own.pairs.iter().map(|pair| {
        json!({
            "outer": pair.outer + 1, "inner": pair.inner + 1, "gap_m": pair.gap, "offset_m": pair.offset,
            "layer_m": pair.layer.is_finite().then_some(pair.layer), "touches": pair.touches,
        })
    });
    let actuators = own.efforts.iter().zip(&own.backlash).enumerate().map(|(i, (effort, backlash))| {
        json!({ "tube": i + 1, "pull_m": effort.label, "tension_N": effort.force, "backlash_m": backlash })
    });
    let direction = own.frame.column(0);
    json!({
        "pairs": pairs.collect::<Vec<_>>(), "actuators": actuators.collect::<Vec<_>>(),
        "tip_position_m": <[f64; 3]>::from(own.tip), "tip_direction": [direction.x, direction.y, direction.z],
    })
}
