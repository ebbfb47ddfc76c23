//! Contact force and friction in the results of a pose.

use crate::Failure;
use crate::clearance::Gapped;
use crate::quantity::{Kind, scalar};
use crate::table::plain;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver, TubeEffort};
use cppr::bundle::{Contact, Friction, Rubbed};
use cppr_io::contact_record;
use cppr_plot::{Axis, Figure, Panel, Series, tube_stroke};
use serde_json::Value;

/// Sections at which contact is told, per length.
const SECTIONS: f64 = 100.0;
/// Contact below this (N/m) is rounding.
const NOTHING: f64 = 1e-6;
const TALL: f64 = 180.0;

/// How tubes rub.
#[derive(Clone, Copy, clap::Args)]
pub struct FrictionArgs {
    /// Coefficient of friction between the tubes: give the two answers, of motors driven on and of motors driven back, between which friction leaves the robot;
    /// default: that of the robot file, if any; 0 leaves it out
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, value_parser = coefficient)]
    pub friction: Option<f64>,
    /// Length of the guide below the plate in which tubes are held: adds its friction; default: that of the robot file
    #[arg(long, value_name = "LENGTH", value_parser = guide)]
    pub guide: Option<f64>,
}

impl FrictionArgs {
    /// The friction of a robot file as the options leave it; none where there is none, or where they take it away.
    pub fn or(self, own: Option<Friction>) -> Option<Friction> {
        let coefficient = self.friction.or(own.map(|own| own.coefficient))?;
        let guide = self.guide.or(own.and_then(|own| own.guide));
        (coefficient > 0.0).then_some(Friction { coefficient, guide })
    }

    /// The same where the guide has no other use.
    pub fn alone(self, own: Option<Friction>) -> Result<Option<Friction>, Failure> {
        if self.guide.is_some() && self.friction.is_none() && own.is_none() {
            let text = "--guide: nothing is asked of the guide; give --friction, or write [friction] in the robot file, or give --guide-gap beside --clearance";
            return Err(Failure::Input(text.into()));
        }
        Ok(self.or(own))
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
        friction: Option<Friction>,
        wanted: bool,
    ) -> Result<Self, Failure> {
        let length = solver.bundle().length();
        let contact = if wanted {
            solver.contact(found, length / SECTIONS).unwrap_or_default()
        } else {
            Contact::default()
        };
        let slip = match friction {
            None => None,
            Some(friction) => {
                let sides = solver.full_slip(found, &friction).ok_or_else(|| {
                    Failure::NoEquilibrium(format!(
                        "friction {}: no equilibrium with full slip was found; take less friction, command less, or leave it out with --friction 0",
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

    /// Adds the shape with gaps to a figure, and below it the panels.
    pub fn draw(&self, figure: &mut Figure) {
        // In the plane there is the first of these views alone; the second of four is in perspective.
        for (view, axes) in [(0, [0, 1]), (2, [0, 2]), (3, [1, 2])] {
            if let (Some(panel), Some(gapped)) = (figure.panels.get_mut(view), &self.gapped) {
                panel.series.extend(gapped.line(axes));
            }
        }
        figure.panels.extend(self.panels());
    }

    /// Contact force along the robot, and what gaps make of it.
    fn panels(&self) -> Vec<Panel> {
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
