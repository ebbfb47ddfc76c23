//! Contact force and friction as JSON and as columns: SI units, the unit in every key.

use cppr::bundle::solve::{BundleEquilibrium, TubeEffort};
use cppr::bundle::{Contact, Friction, PairContact, Rubbed};
use serde_json::{Value, json};

/// How the tubes press on each other.
#[must_use]
pub fn contact(contact: &Contact) -> Value {
    let pairs = contact.pairs.iter().map(|pair| {
        let each = |of: &dyn Fn(&cppr::bundle::ContactPoint) -> Value| {
            pair.points.iter().map(of).collect::<Vec<_>>()
        };
        json!({
            "outer": pair.outer + 1, "inner": pair.inner + 1,
            "length_m": each(&|p| p.length.into()),
            "outer_abscissa_m": each(&|p| p.labels[0].into()),
            "inner_abscissa_m": each(&|p| p.labels[1].into()),
            "force_N_m": each(&|p| json!(<[f64; 3]>::from(p.force))),
        })
    });
    let points = contact.points.iter().map(|point| {
        json!({
            "length_m": point.length, "inner": point.inner + 1,
            "force_N": <[f64; 3]>::from(point.force), "couple_Nm": <[f64; 3]>::from(point.couple),
        })
    });
    json!({
        "pairs": pairs.collect::<Vec<_>>(), "points": points.collect::<Vec<_>>(), "residual_N_m": contact.residual,
    })
}

/// Motors of every tube.
#[must_use]
pub fn actuators(efforts: &[TubeEffort]) -> Value {
    let each = efforts.iter().enumerate().map(|(i, own)| {
        json!({
            "tube": i + 1, "pull_m": own.label, "rotation_rad": own.rotation,
            "tension_N": own.force, "torque_Nm": own.torque,
        })
    });
    each.collect()
}

/// Tip and motors of an equilibrium at one end of what may be.
#[must_use]
pub fn bound(found: &BundleEquilibrium, efforts: &[TubeEffort]) -> Value {
    json!({
        "tip_position_m": <[f64; 3]>::from(found.tip),
        "tip_direction": <[f64; 3]>::from(found.frame.column(0).into_owned()),
        "actuators": actuators(efforts),
    })
}

/// The equilibria between which friction leaves a pose.
#[must_use]
pub fn bounds(friction: &Friction, [loading, unloading]: &[Rubbed; 2]) -> Value {
    let side = |own: &Rubbed| bound(&own.equilibrium, &own.efforts);
    json!({
        "coefficient": friction.coefficient, "guide_m": friction.guide,
        "loading": side(loading), "unloading": side(unloading),
    })
}

/// Name of a pair's column of contact forces (N/m).
#[must_use]
pub fn column(pair: &PairContact) -> String {
    format!("contact_{}_{}_N_m", pair.outer + 1, pair.inner + 1)
}
