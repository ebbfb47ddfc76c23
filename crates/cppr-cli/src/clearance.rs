//! Gaps between the tubes: what they change, estimated.

use crate::quantity::{Kind, scalar};
use crate::table::plain;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::clearance::{Estimate, estimate};
use cppr::{Matrix3, Vector3};
use cppr_io::clearance_record;
use serde_json::Value;
use std::fmt::Write;

/// Which gaps the tubes have.
#[derive(Clone, Copy, Debug)]
pub enum Gap {
    /// Those that the radii leave.
    Radii,
    /// One between all tubes (m).
    All(f64),
}

impl Gap {
    /// Of every pair, where the radii leave `known`.
    pub fn between(self, known: Vec<Option<f64>>) -> Vec<Option<f64>> {
        match self {
            Self::Radii => known,
            Self::All(gap) => vec![Some(gap); known.len()],
        }
    }
}

/// Reads a gap.
pub fn gap(text: &str) -> Result<Gap, String> {
    if text == RADII {
        return Ok(Gap::Radii);
    }
    match scalar(text, Kind::Length)? {
        length if length >= 0.0 => Ok(Gap::All(length)),
        _ => Err(format!("the gap is {text}; it cannot be negative")),
    }
}

/// What a gap without a value means.
pub const RADII: &str = "radii";

/// An estimate, and the equilibrium without clearance that it is of.
pub struct Play {
    estimate: Estimate,
    tip: Vector3<f64>,
    bend: f64,
    forces: Vec<f64>,
}

/// Angle between a tip and +X (rad).
fn bend(frame: &Matrix3<f64>) -> f64 {
    let direction = frame.column(0);
    direction.y.hypot(direction.z).atan2(direction.x)
}

impl Play {
    /// Of an equilibrium, where tubes have gaps (m) and the estimate can be made.
    pub fn of(solver: &mut BundleSolver, found: &BundleEquilibrium, gaps: &[Option<f64>]) -> Option<Self> {
        let estimate = estimate(solver, found, gaps).filter(|own| !own.pairs.is_empty())?;
        let forces = found.efforts.iter().map(|own| own.force).collect();
        Some(Self { estimate, tip: found.tip, bend: bend(&found.frame), forces })
    }

    pub fn write(&self, text: &mut String) {
        let Estimate { pairs, efforts, tip, frame, backlash } = &self.estimate;
        let _ = writeln!(text, "  with gaps between the tubes (estimate)");
        let mut line = |head: &str, rest: String| {
            let _ = writeln!(text, "    {head:<16}{rest}");
        };
        let mm = |length: f64| plain(length * 1e3, 3);
        for own in pairs {
            let lies = if own.touches {
                format!(", against the wall from {} mm behind the plate on", plain(own.layer * 1e3, 1))
            } else {
                ", without reaching the wall".into()
            };
            let aside = format!("tube {} lies {} mm aside on average{lies}", own.inner + 1, mm(own.offset));
            line(&format!("gap {} mm", mm(own.gap)), aside);
        }
        let bent = bend(frame).to_degrees();
        let was = self.bend.to_degrees();
        line("bend angle", format!("{:>9} deg instead of {} deg", plain(bent, 3), plain(was, 3)));
        line("tip", format!("moves by {} mm", mm((tip - self.tip).norm())));
        for (tube, ((own, was), play)) in (1..).zip(efforts.iter().zip(&self.forces).zip(backlash)).skip(1) {
            let back = play.filter(|play| *play > NOTHING).map_or(String::new(), |play| {
                format!("; passes no force over {} mm of its pull (backlash)", mm(play))
            });
            let force = format!("{:>9} N   instead of {} N{back}", plain(own.force, 4), plain(*was, 4));
            line(&format!("tube {tube} tension"), force);
        }
    }

    pub fn json(&self) -> Value {
        clearance_record::estimate(&self.estimate)
    }
}

/// Backlash below this (m) is none.
const NOTHING: f64 = 1e-6;
