//! One `[[tube]]` of a robot file.

use crate::cursor::Cursor;
use crate::material::{Common, Written};
use crate::notches::{Notches, read_notches};
use crate::problems::Collector;
use crate::quantity::{BORE, BORE_DIAMETER, DIAMETER, FACTOR, LEAST_WALL, Quantity, RADIUS, print, print_mm};
use crate::robot_file::TubeFile;
use crate::stiffness::read_stiffness;
use crate::teeth::Teeth;
use cppr::design::{
    BelowPlate, Material, NotchedTube, Outline, Profile, TeethStiffness, Torsion, TubeDesign,
};
use std::ops::Range;

pub(crate) const KEYS: [&str; 9] = [
    "outer_radius_mm",
    "inner_radius_mm",
    "outer_diameter_mm",
    "inner_diameter_mm",
    "shape",
    "centroid_offset_factor",
    "material",
    "notches",
    "stiffness",
];
/// Keys that describe a geometry.
const GEOMETRY: [&str; 7] = [
    "outer_radius_mm",
    "inner_radius_mm",
    "outer_diameter_mm",
    "inner_diameter_mm",
    "shape",
    "notches",
    "material",
];
/// The two ways to say a size, each with its quantity and the radii that 1 of it makes.
const OUTER: [(&str, &Quantity, f64); 2] =
    [("outer_radius_mm", &RADIUS, 1.0), ("outer_diameter_mm", &DIAMETER, 0.5)];
const INNER: [(&str, &Quantity, f64); 2] =
    [("inner_radius_mm", &BORE, 1.0), ("inner_diameter_mm", &BORE_DIAMETER, 0.5)];
/// Most slender robot: length over outer radius.
const SLENDER: f64 = 1e4;

/// What holds for all tubes. `None` stands for a value that has its problem already.
pub(crate) struct Robot {
    pub length: Option<f64>,
    pub material: Common,
    pub factor: Option<f64>,
}

/// One tube as far as it could be read.
#[derive(Default)]
pub(crate) struct Tube {
    pub design: Option<TubeDesign>,
    pub file: TubeFile,
    /// For the comparison with its neighbours: outline, and the outer radius as it is written.
    pub outline: Option<(Outline, Size)>,
}

/// A radius as a file writes it: itself or the diameter.
#[derive(Clone)]
pub(crate) struct Size {
    key: String,
    /// Place of the value.
    span: Range<usize>,
    /// SI (m).
    radius: f64,
    /// Radii that 1 of what is written makes.
    share: f64,
}

impl Size {
    /// Reads the one of two keys that is there.
    fn read(
        cursor: &Cursor<'_, '_>,
        ways: [(&'static str, &Quantity, f64); 2],
        out: &mut Collector,
    ) -> Option<Self> {
        let [(radius, of_radius, _), (diameter, of_diameter, _)] = ways;
        if let (true, Some(entry)) = (cursor.has(radius), cursor.get(diameter)) {
            let message = format!("{radius} is given too, and either of them fixes the other");
            out.wrong(entry.key_span, entry.key, message, format!("Keep one of {radius} and {diameter}."));
            return None;
        }
        let (name, quantity, share) = ways[usize::from(cursor.has(diameter))];
        let help =
            format!("Write {radius} = {}, or {diameter} = {}.", of_radius.example, of_diameter.example);
        let entry = cursor.require(name, &help, out)?;
        let radius = share * entry.number(quantity, out)?;
        Some(Self { key: entry.key, span: entry.span, radius, share })
    }

    fn wrong(&self, message: impl Into<String>, help: impl Into<String>, out: &mut Collector) {
        out.wrong(self.span.clone(), self.key.clone(), message, help);
    }

    /// A radius (m) in the way that this one is written: `a radius` or `a diameter`, and its number.
    fn say(&self, radius: f64) -> (&'static str, String) {
        let word = if self.share < 1.0 { "diameter" } else { "radius" };
        (word, print(radius / self.share * 1e3))
    }
}

/// Reads tube `number` (from 1).
pub(crate) fn read_tube(
    cursor: &Cursor<'_, '_>,
    number: usize,
    robot: &mut Robot,
    out: &mut Collector,
) -> Tube {
    let own = cursor.field("centroid_offset_factor", &FACTOR, out);
    let factor = if own.present { own.value } else { robot.factor };
    let geometry = GEOMETRY.into_iter().find(|key| cursor.has(key));
    match (geometry, cursor.has("stiffness")) {
        (None, false) => {
            let help = "Write outer_radius_mm, inner_radius_mm (or the diameters) and [tube.notches], or a [tube.stiffness] table.";
            out.missing(
                cursor.span(),
                cursor.path("outer_radius_mm"),
                "neither a geometry nor a stiffness is given",
                help,
            );
            Tube::default()
        }
        (None, true) => Tube {
            design: read_stiffness(cursor, number, robot.length, factor, out).map(TubeDesign::Stiffness),
            file: TubeFile { centroid_offset_factor: factor.unwrap_or(1.0), ..TubeFile::default() },
            outline: None,
        },
        (Some(_), false) => read_geometry(cursor, number, robot, factor, out),
        (Some(key), true) => {
            if let Some(entry) = cursor.get("stiffness") {
                let message =
                    format!("a geometry is given too ({key}), and either of them fixes the stiffness");
                let help = "Keep the geometry (radii, shape, material, notches) or the stiffness.";
                out.wrong(entry.key_span, entry.key, message, help);
            }
            // Both are read for the problems inside them.
            read_stiffness(cursor, number, robot.length, factor, out);
            read_geometry(cursor, number, robot, factor, out)
        }
    }
}

fn read_geometry(
    cursor: &Cursor<'_, '_>,
    number: usize,
    robot: &mut Robot,
    factor: Option<f64>,
    out: &mut Collector,
) -> Tube {
    let outline = read_outline(cursor, robot.length, out);
    let own = Written::read(cursor, out);
    let material = robot.material.resolve(&own, out);
    let notches = if cursor.has("notches") {
        let outline = outline.as_ref().map(|(outline, _)| outline);
        read_notches(cursor, number, robot.length, outline, out)
    } else {
        Some(uncut(number))
    };
    let mut file = TubeFile { centroid_offset_factor: factor.unwrap_or(1.0), ..TubeFile::default() };
    if let Some((outline, _)) = &outline {
        let (outer, inner) = radii(outline);
        (file.outer_radius, file.inner_radius) = (Some(outer), Some(inner));
    }
    file.notches = notches.as_ref().and_then(|notches| notches.pattern);
    let design = notches.zip(outline.clone()).zip(material).zip(factor);
    let design = design.and_then(|(((notches, (outline, _)), material), factor)| {
        notched(notches, outline, material, factor, robot.length, out)
    });
    Tube { design, file, outline }
}

/// The design of a tube, or of one part of it; `length` (m) is its own.
pub(crate) fn notched(
    notches: Notches,
    outline: Outline,
    material: Material,
    factor: f64,
    length: Option<f64>,
    out: &mut Collector,
) -> Option<TubeDesign> {
    let tube = NotchedTube {
        outline,
        depth: notches.depth,
        direction: notches.direction,
        pattern: notches.pattern,
        teeth: TeethStiffness::Flexible,
        contact: notches.contact,
        material,
        torsion: notches.torsion,
        below: notches.below,
        centroid_offset_factor: factor,
    };
    notches.teeth.of(tube, length, out).map(TubeDesign::Notched)
}

/// A tube without notches. Its centroid lies on the axis; a follower's axes are turned as if it were
/// opposed to the leader, so that nothing is twisted at rest.
pub(crate) fn uncut(number: usize) -> Notches {
    let direction = if number == 1 { 0.0 } else { std::f64::consts::PI };
    Notches {
        depth: Profile::constant(0.0),
        direction: Profile::constant(direction),
        torsion: Torsion::SaintVenant,
        below: BelowPlate::Plain,
        pattern: None,
        teeth: Teeth::Flexible,
        contact: false,
    }
}

fn radii(outline: &Outline) -> (f64, f64) {
    match *outline {
        Outline::Round { outer_radius, inner_radius } => (outer_radius, inner_radius),
        Outline::Polygon { outer_apothem, inner_apothem, .. } => (outer_apothem, inner_apothem),
    }
}

pub(crate) fn read_outline(
    cursor: &Cursor<'_, '_>,
    length: Option<f64>,
    out: &mut Collector,
) -> Option<(Outline, Size)> {
    let outer = Size::read(cursor, OUTER, out);
    let inner = Size::read(cursor, INNER, out);
    let sides = match cursor.get("shape") {
        None => Some(None),
        Some(entry) => entry.word(&["round", "square", "hexagon"], out).map(|word| match word {
            "square" => Some(4),
            "hexagon" => Some(6),
            _ => None,
        }),
    };
    let (outer_size, inner_size) = (outer?, inner?);
    let (outer, inner) = (outer_size.radius, inner_size.radius);
    let ((inner_word, inner_text), (outer_word, outer_text)) = (inner_size.say(inner), outer_size.say(outer));
    if inner >= outer {
        let message =
            format!("{inner_text} mm leaves no wall in a tube of outer {outer_word} {outer_text} mm");
        let help = format!("Write a {inner_word} below {}.", inner_size.say(outer).1);
        inner_size.wrong(message, help, out);
        return None;
    }
    if outer - inner < LEAST_WALL {
        let message = format!(
            "{inner_text} mm in a tube of outer {outer_word} {outer_text} mm leaves a thinner wall than any robot has ({})",
            print_mm(LEAST_WALL)
        );
        let help = format!("Write a {inner_word} below {}.", inner_size.say(outer - LEAST_WALL).1);
        inner_size.wrong(message, help, out);
        return None;
    }
    if let Some(length) = length {
        let help = format!("Write both in millimetres; the file has length_mm = {}.", print(length * 1e3));
        if outer > length {
            let message = format!(
                "a {outer_word} of {outer_text} mm is larger than the tube is long ({})",
                print_mm(length)
            );
            outer_size.wrong(message, help, out);
            return None;
        }
        if outer * SLENDER < length {
            let message = format!(
                "a {outer_word} of {outer_text} mm is less than a ten-thousandth of the length ({})",
                print_mm(length)
            );
            outer_size.wrong(message, help, out);
            return None;
        }
    }
    let outline = match sides? {
        None => Outline::Round { outer_radius: outer, inner_radius: inner },
        Some(sides) => Outline::Polygon { sides, outer_apothem: outer, inner_apothem: inner },
    };
    Some((outline, outer_size))
}

/// Reports every follower that is wider than the bore it slides in.
pub(crate) fn check_nesting(tubes: &[Tube], out: &mut Collector) {
    // A tube of given stiffness has no known bore: the next tube is held against the bore outside it.
    let mut around: Option<(usize, &Outline)> = None;
    for (index, tube) in tubes.iter().enumerate() {
        let Some((outline, size)) = &tube.outline else {
            continue;
        };
        if let Some((outer, bore)) = around.map(|(number, outer)| (number, outer.inner_clearance())) {
            let reach = outline.outer_reach();
            if reach > bore {
                let message = format!(
                    "the tube reaches {} from its axis and does not fit into the bore of tube {outer} ({})",
                    print_mm(reach),
                    print_mm(bore)
                );
                let (word, most) = size.say(radii(outline).0 * bore / reach);
                let help = if bore > 0.0 {
                    format!("Write an outer {word} of at most {most}, or widen the bore.")
                } else {
                    format!("Give tube {outer} a bore to slide in.")
                };
                size.wrong(message, help, out);
            }
        }
        around = Some((index + 1, outline));
    }
}
