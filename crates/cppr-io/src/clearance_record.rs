//! Clearance as JSON: SI units, the unit in every key.

use cppr::clearance::{ClearanceEquilibrium, Estimate, PairClearance};
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

/// An equilibrium with clearance.
#[must_use]
pub fn equilibrium(own: &ClearanceEquilibrium) -> Value {
    let actuators = own.followers.iter().enumerate().map(|(k, follower)| {
        json!({
            "tube": k + 2, "pull_m": follower.pull, "tension_N": follower.tension, "torque_N_m": follower.torque,
            "abscissa_m": follower.abscissa, "tilt_rad": follower.tilt,
        })
    });
    // Where both are no neighbours stands null.
    let there = |values: &[[f64; 2]]| -> Vec<Option<[f64; 2]>> {
        values.iter().map(|own| own.iter().all(|value| value.is_finite()).then_some(*own)).collect()
    };
    let pair = |pair: &PairClearance| {
        let zones = pair.zones.iter().map(|zone| {
            json!({
                "from_m": zone.from, "to_m": zone.to, "angle_rad": zone.angles, "force_N": zone.force,
            })
        });
        json!({
            "outer": pair.outer + 1, "inner": pair.inner + 1, "gap_m": pair.gap,
            "mean_offset_m": pair.mean(own)[0], "zones": zones.collect::<Vec<_>>(),
            "offset_m": there(&pair.offset), "force_N_m": there(&pair.force),
        })
    };
    let centres = own.centres.iter().map(|centre| <[f64; 3]>::from(*centre));
    let axes = own.frames.iter().map(|frame| <[[f64; 3]; 3]>::from(*frame));
    json!({
        "tip_position_m": <[f64; 3]>::from(own.tip()), "bend_angle_rad": own.bend(),
        "error": { "tip_m": own.error[0], "force_N": own.error[1] },
        "leader": {
            "pull_m": own.leader.label, "rotation_rad": own.leader.rotation,
            "tension_N": own.leader.force, "torque_N_m": own.leader.torque,
        },
        "actuators": actuators.collect::<Vec<_>>(), "pairs": own.pairs.iter().map(pair).collect::<Vec<_>>(),
        "x_m": own.labels, "centre_m": centres.collect::<Vec<_>>(), "axes": axes.collect::<Vec<_>>(),
    })
}
