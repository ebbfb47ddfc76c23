//! Gaps between the tubes: what they change, solved for or estimated.

use crate::Failure;
use crate::quantity::{Kind, scalar};
use crate::table::plain;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::clearance::{
    Clearance, ClearanceEquilibrium, ClearanceProblem, Estimate, Guide, PairClearance, Zone, estimate,
};
use cppr::solve::{Equilibrium, Solver};
use cppr::{Matrix3, Vector3};
use cppr_io::clearance_record;
use cppr_plot::{Axis, Panel, Series, tube_stroke};
use serde_json::{Value, json};
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

/// Reads a gap in the guide.
pub fn guide_gap(text: &str) -> Result<f64, String> {
    match gap(text)? {
        Gap::All(gap) => Ok(gap),
        Gap::Radii => Err("the radii leave no gap in the guide; give one, for instance 0.1mm".into()),
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
        let _ = writeln!(text, "  with gaps between the tubes (estimate)");
        for (head, rest) in self.lines() {
            let _ = writeln!(text, "    {head:<16}{rest}");
        }
    }

    /// Names and values of the table's lines.
    fn lines(&self) -> Vec<(String, String)> {
        let Estimate { pairs, efforts, tip, frame, backlash } = &self.estimate;
        let mut lines = Vec::new();
        for own in pairs {
            let lies = if own.touches {
                format!(", against the wall from {} mm behind the plate on", plain(own.layer * 1e3, 1))
            } else {
                ", without reaching the wall".into()
            };
            let aside = format!("tube {} lies {} mm aside on average{lies}", own.inner + 1, mm(own.offset));
            lines.push((format!("gap {} mm", mm(own.gap)), aside));
        }
        let bent = bend(frame).to_degrees();
        let was = self.bend.to_degrees();
        lines.push((
            "bend angle".into(),
            format!("{:>9} deg instead of {} deg", plain(bent, 3), plain(was, 3)),
        ));
        lines.push(("tip".into(), format!("moves by {} mm", mm((tip - self.tip).norm()))));
        for (tube, ((own, was), play)) in (1..).zip(efforts.iter().zip(&self.forces).zip(backlash)).skip(1) {
            let back = play.filter(|play| *play > NOTHING).map_or(String::new(), |play| {
                format!("; passes no force over {} mm of its pull (backlash)", mm(play))
            });
            let force = format!("{:>9} N   instead of {} N{back}", plain(own.force, 4), plain(*was, 4));
            lines.push((format!("tube {tube} tension"), force));
        }
        lines
    }

    pub fn json(&self) -> Value {
        clearance_record::estimate(&self.estimate)
    }
}

/// A length in millimetres.
fn mm(length: f64) -> String {
    plain(length * 1e3, 3)
}

/// What gaps make of a pose: the equilibrium with contact, or the estimate and why it is one.
pub enum Gapped {
    Solved(Box<ClearanceEquilibrium>),
    Estimated(Box<Play>, String),
}

/// Gaps and play that are asked for.
fn clearance(gap: Gap, known: Vec<Option<f64>>, guide: Option<Guide>) -> Result<Clearance, Failure> {
    let own = Clearance::known(&gap.between(known)).map_err(|problem| wrong(&problem))?;
    Ok(Clearance { guide, ..own })
}

fn wrong(problem: &ClearanceProblem) -> Failure {
    Failure::Input(format!("--clearance: {problem}"))
}

impl Gapped {
    /// Of an equilibrium without gaps.
    pub fn of(
        solver: &mut Solver,
        found: &Equilibrium,
        gap: Gap,
        guide: Option<Guide>,
    ) -> Result<Self, Failure> {
        let asked = clearance(gap, found.robot().gaps(), guide)?;
        Self::solved(solver.with_clearance(found, &asked).map_err(|problem| wrong(&problem))?)
    }

    /// Of a robot with parts or joints, where the radii leave `known` gaps.
    pub fn of_bundle(
        solver: &mut BundleSolver,
        found: &BundleEquilibrium,
        known: Vec<Option<f64>>,
        gap: Gap,
        guide: Option<Guide>,
    ) -> Result<Self, Failure> {
        match solver.with_clearance(found, &clearance(gap, known.clone(), guide)?) {
            Err(problem @ ClearanceProblem::Nonlinear { .. }) if guide.is_none() => {
                Self::estimated(Play::of(solver, found, &gap.between(known)), problem.to_string())
            }
            Err(problem) => Err(wrong(&problem)),
            Ok(found) => Self::solved(found),
        }
    }

    fn solved(found: Option<ClearanceEquilibrium>) -> Result<Self, Failure> {
        let found = found.ok_or_else(|| {
            Failure::NoEquilibrium(
                "--clearance: no equilibrium with contact was found next to that without; command less, or let cppr limits estimate what gaps change".into(),
            )
        })?;
        Ok(Self::Solved(Box::new(found)))
    }

    fn estimated(play: Option<Play>, because: String) -> Result<Self, Failure> {
        let play = play.ok_or_else(|| {
            Failure::Input(format!(
                "--clearance: {because}, and there is no estimate: no tubes have a gap, or there is no equilibrium at the pulls that gaps leave"
            ))
        })?;
        Ok(Self::Estimated(Box::new(play), because))
    }

    /// Names and values of the table's lines.
    pub fn lines(&self) -> Vec<(String, String)> {
        let found = match self {
            Self::Solved(found) => found,
            Self::Estimated(play, because) => {
                let mut lines = vec![("with gaps".into(), format!("estimated, since {because}"))];
                lines.extend(play.lines().into_iter().map(|(head, rest)| (format!("  {head}"), rest)));
                return lines;
            }
        };
        let tip = <[f64; 3]>::from(found.tip() * 1e3).map(|c| format!("{:>10}", plain(c, 3))).join(" ");
        let mut lines = vec![
            ("with gaps".into(), format!("{tip} mm, the tip")),
            (String::new(), format!("{:>10} deg, the bend", plain(found.bend().to_degrees(), 3))),
        ];
        for (tube, own) in (2..).zip(&found.followers) {
            let (pull, force) = (plain(own.pull * 1e3, 3), plain(own.tension, 4));
            lines.push((String::new(), format!("tube {tube} pulled {pull:>9} mm with {force:>9} N")));
        }
        for pair in &found.pairs {
            let zone = |zone: &Zone| {
                let [from, to] = [zone.from, zone.to].map(|x| plain(x * 1e3, 1));
                let [first, last] = zone.angles.map(|angle| plain(angle.to_degrees(), 0));
                let turns = if first == last { first } else { format!("{first} to {last}") };
                format!("on the wall at {turns} deg from {from} to {to} mm with {} N", plain(zone.force, 3))
            };
            let zones: Vec<String> = pair.zones.iter().map(zone).collect();
            let zones = if zones.is_empty() { "nowhere on the wall".into() } else { zones.join(", ") };
            // Where the tube between two has ended.
            let around = if pair.inner > pair.outer + 1 {
                format!(" in tube {}", pair.outer + 1)
            } else {
                String::new()
            };
            let text = format!(
                "tube {}{around} lies {} mm aside on average in a gap of {} mm, {zones}",
                pair.inner + 1,
                mm(pair.mean(found)[0]),
                mm(pair.gap)
            );
            lines.push((String::new(), text));
        }
        let [tip, force] = found.error;
        lines
            .push((String::new(), format!("estimated error {:.1e} mm of the tip, {force:.1e} N", tip * 1e3)));
        lines
    }

    pub fn json(&self) -> Value {
        let (mut whole, method) = match self {
            Self::Solved(found) => (clearance_record::equilibrium(found), json!({ "method": "solved" })),
            Self::Estimated(play, because) => {
                (play.json(), json!({ "method": "estimated", "because": because }))
            }
        };
        if let (Value::Object(whole), Value::Object(method)) = (&mut whole, method) {
            whole.extend(method);
        }
        whole
    }

    /// The axis of the outermost tube, for a picture of the shape over two axes of the base.
    pub fn line(&self, [across, up]: [usize; 2]) -> Option<Series> {
        let Self::Solved(found) = self else { return None };
        Some(Series {
            name: "centreline with gaps".into(),
            points: found.centres[found.guided..]
                .iter()
                .map(|own| [own[across] * 1e3, own[up] * 1e3])
                .collect(),
            line: Some(tube_stroke(3)),
            ..Series::default()
        })
    }

    /// Where the inner tubes lie, and how hard they press on the walls.
    pub fn panels(&self) -> Vec<Panel> {
        let Self::Solved(found) = self else { return Vec::new() };
        let widest = found.pairs.iter().map(|pair| pair.gap).fold(0.0, f64::max) * 1e3;
        if widest <= 0.0 {
            return Vec::new();
        }
        let series = |of: &dyn Fn(&PairClearance) -> Vec<[f64; 2]>| -> Vec<Series> {
            let one = |pair: &PairClearance| Series {
                name: format!("tube {} in tube {}", pair.inner + 1, pair.outer + 1),
                points: of(pair),
                line: Some(tube_stroke(pair.inner + 1)),
                ..Series::default()
            };
            found.pairs.iter().map(one).collect()
        };
        let along = |values: &[[f64; 2]], of: &dyn Fn(&[f64; 2]) -> f64| -> Vec<[f64; 2]> {
            let there = found.labels.iter().zip(values).filter(|(_, own)| own[0].is_finite());
            there.map(|(x, own)| [x * 1e3, of(own)]).collect()
        };
        let size = |own: &[f64; 2]| own[0].hypot(own[1]);
        let mut offsets = Axis::new("offset in the gap", "mm");
        let mut forces = Axis::new("force of the wall", "N/mm");
        let planar = found
            .pairs
            .iter()
            .flat_map(|pair| &pair.offset)
            .all(|own| own[1].is_nan() || own[1].abs() < FLAT * widest);
        let panels = if planar {
            offsets.range = Some([-1.05 * widest, 1.05 * widest]);
            forces.zero_line = true;
            vec![
                (offsets, series(&|pair| along(&pair.offset, &|own| own[0] * 1e3))),
                (forces, series(&|pair| along(&pair.force, &|own| own[0] * 1e-3))),
            ]
        } else {
            offsets.range = Some([0.0, 1.05 * widest]);
            forces.include_zero = true;
            vec![
                (offsets, series(&|pair| along(&pair.offset, &|own| size(own) * 1e3))),
                (
                    Axis::new("direction of the offset", "deg"),
                    series(&|pair| directions(&found.labels, pair)),
                ),
                (forces, series(&|pair| along(&pair.force, &|own| size(own) * 1e-3))),
            ]
        };
        let panel =
            |(y, series)| Panel { height: TALL, series, ..Panel::new(Axis::new("label of tube 1", "mm"), y) };
        panels.into_iter().map(panel).collect()
    }
}

/// Labels (mm) and directions of a pair's offset (deg), without jumps of a full turn, where the inner tube lies far enough from the axis to have one.
fn directions(labels: &[f64], pair: &PairClearance) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (label, [y, z]) in labels.iter().zip(&pair.offset) {
        if y.hypot(*z) > ASIDE * pair.gap {
            let angle = z.atan2(*y).to_degrees();
            let turns = points.last().map_or(0.0, |before| ((angle - before[1]) / 360.0).round());
            points.push([label * 1e3, angle - 360.0 * turns]);
        }
    }
    points
}

const TALL: f64 = 180.0;
/// Offsets out of the plane (m) that are rounding, per gap (mm); part of the gap from which on an offset has a direction.
const FLAT: f64 = 1e-9;
const ASIDE: f64 = 0.1;

/// Backlash below this (m) is none.
const NOTHING: f64 = 1e-6;
