//! Contact force and friction in the results of a pose.

use crate::Failure;
use crate::clearance::Gapped;
use crate::quantity::{Kind, scalar};
use crate::table::plain;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver, TubeEffort};
use cppr::bundle::{Contact, Friction, Rubbed};
use cppr_io::contact_record;
use cppr_plot::{Axis, Panel, Series, tube_stroke};
use serde_json::Value;

/// Sections at which contact is told, per length.
const SECTIONS: f64 = 100.0;
/// Contact below this (N/m) is rounding.
const NOTHING: f64 = 1e-6;
const TALL: f64 = 180.0;

/// How tubes rub.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("guided").multiple(true))]
pub struct FrictionArgs {
    /// Coefficient of friction between the tubes: give the two answers, of motors driven on and of motors driven back, between which friction leaves the robot
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, group = "guided", value_parser = coefficient)]
    friction: Option<f64>,
    /// Length of the guide below the plate in which tubes are held: adds its friction
    #[arg(long, value_name = "LENGTH", requires = "guided", value_parser = guide)]
    pub guide: Option<f64>,
}

impl FrictionArgs {
    /// What is asked for.
    pub fn friction(&self) -> Option<Friction> {
        self.friction.map(|coefficient| Friction { coefficient, guide: self.guide })
    }
}

/// Reads a coefficient of friction.
pub fn coefficient(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.0..=MOST).contains(&value) => Ok(value),
        _ => Err(format!("write a coefficient of friction from 0 to {MOST}, for instance 0.2")),
    }
}

/// Greatest coefficient of friction: beyond it tubes jam.
const MOST: f64 = 2.0;

/// Reads the length of a guide.
pub fn guide(text: &str) -> Result<f64, String> {
    match scalar(text, Kind::Length)? {
        length if length > 0.0 => Ok(length),
        _ => Err(format!("the guide is {text} long; it needs a length above 0")),
    }
}

/// Lines of a table for the motors of all tubes but the first.
pub fn motors(efforts: &[TubeEffort]) -> impl Iterator<Item = (String, String)> {
    efforts.iter().enumerate().skip(1).map(|(i, own)| {
        let (pull, force) = (plain(own.label * 1e3, 3), plain(own.force, 4));
        let torque = plain(own.torque * 1e3, 4);
        (String::new(), format!("tube {} pulled {pull:>9} mm with {force:>9} N, {torque:>9} N mm", i + 1))
    })
}

/// What tubes do to each other in a pose.
#[derive(Default)]
pub struct Touch {
    pub contact: Contact,
    pub slip: Option<(Friction, [Rubbed; 2])>,
    /// With gaps between them.
    pub gapped: Option<Gapped>,
}

impl Touch {
    /// Of an equilibrium; `wanted` tells whether contact is.
    pub fn of(
        solver: &BundleSolver,
        found: &BundleEquilibrium,
        args: &FrictionArgs,
        wanted: bool,
    ) -> Result<Self, Failure> {
        let length = solver.bundle().length();
        let contact = if wanted {
            solver.contact(found, length / SECTIONS).unwrap_or_default()
        } else {
            Contact::default()
        };
        let slip = match args.friction() {
            None => None,
            Some(friction) => {
                let sides = solver.full_slip(found, &friction).ok_or_else(|| {
                    Failure::NoEquilibrium(format!(
                        "--friction {}: no equilibrium with full slip was found; take less friction, or command less",
                        friction.coefficient
                    ))
                })?;
                Some((friction, sides))
            }
        };
        Ok(Self { contact, slip, gapped: None })
    }

    pub fn contact_json(&self) -> Option<Value> {
        (!self.contact.pairs.is_empty()).then(|| contact_record::contact(&self.contact))
    }

    pub fn friction_json(&self) -> Option<Value> {
        self.slip.as_ref().map(|(friction, sides)| contact_record::bounds(friction, sides))
    }

    pub fn clearance_json(&self) -> Option<Value> {
        self.gapped.as_ref().map(Gapped::json)
    }

    /// Names and values of the table's lines.
    pub fn lines(&self) -> Vec<(String, String)> {
        let pressed = self.contact.pairs.iter().map(|pair| {
            let most = plain(pair.greatest() * 1e-3, 4);
            (
                "contact".into(),
                format!("tube {} on tube {} with up to {most} N/mm", pair.outer + 1, pair.inner + 1),
            )
        });
        let mut lines: Vec<(String, String)> = pressed.collect();
        lines.extend(self.gapped.iter().flat_map(Gapped::lines));
        let Some((friction, sides)) = &self.slip else { return lines };
        for (way, side) in ["driven on", "driven back"].into_iter().zip(sides) {
            let tip = <[f64; 3]>::from(side.equilibrium.tip * 1e3)
                .map(|c| format!("{:>10}", plain(c, 3)))
                .join(" ");
            lines.push((format!("friction {}", friction.coefficient), format!("{tip} mm, {way}")));
            lines.extend(motors(&side.efforts));
        }
        lines
    }

    /// Contact force along the robot, and what gaps make of it.
    pub fn panels(&self) -> Vec<Panel> {
        let pairs = self.contact.pairs.iter().filter(|pair| pair.greatest() > NOTHING);
        let series: Vec<Series> = pairs
            .map(|pair| Series {
                name: format!("tube {} on tube {}", pair.outer + 1, pair.inner + 1),
                points: pair.points.iter().map(|p| [p.length * 1e3, p.force.norm() * 1e-3]).collect(),
                line: Some(tube_stroke(pair.inner + 1)),
                ..Series::default()
            })
            .collect();
        let mut y = Axis::new("contact force", "N/mm");
        y.include_zero = true;
        let panel =
            Panel { height: TALL, series, ..Panel::new(Axis::new("length of the centreline", "mm"), y) };
        let pressed = (!panel.series.is_empty()).then_some(panel);
        pressed.into_iter().chain(self.gapped.iter().flat_map(Gapped::panels)).collect()
    }
}
