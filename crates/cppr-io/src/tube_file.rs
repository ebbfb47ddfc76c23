//! One `[[tube]]` of a robot file.

use crate::cursor::Cursor;
use crate::material::{Common, Written};
use crate::notches::{Notches, read_notches};
use crate::problems::Collector;
use crate::quantity::{BORE, FACTOR, LEAST_WALL, RADIUS, print, print_mm};
use crate::robot_file::TubeFile;
use crate::stiffness::read_stiffness;
use cppr::design::{BelowPlate, NotchedTube, Outline, Profile, Torsion, TubeDesign};
use std::ops::Range;

pub(crate) const KEYS: [&str; 7] = [
    "outer_radius_mm",
    "inner_radius_mm",
    "shape",
    "centroid_offset_factor",
    "material",
    "notches",
    "stiffness",
];
/// Keys that describe a geometry.
const GEOMETRY: [&str; 5] = ["outer_radius_mm", "inner_radius_mm", "shape", "notches", "material"];
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
    /// For the comparison with its neighbours: outline, and place of the outer radius.
    pub outline: Option<(Outline, Range<usize>)>,
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
            let help =
                "Write outer_radius_mm, inner_radius_mm and [tube.notches], or a [tube.stiffness] table.";
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
    let design = design.map(|(((notches, (outline, _)), material), centroid_offset_factor)| {
        TubeDesign::Notched(NotchedTube {
            outline,
            depth: notches.depth,
            direction: notches.direction,
            pattern: notches.pattern,
            material,
            torsion: notches.torsion,
            below: notches.below,
            centroid_offset_factor,
        })
    });
    Tube { design, file, outline }
}

/// A tube without notches. Its centroid lies on the axis; a follower's axes are turned as if it were
/// opposed to the leader, so that nothing is twisted at rest.
fn uncut(number: usize) -> Notches {
    let direction = if number == 1 { 0.0 } else { std::f64::consts::PI };
    Notches {
        depth: Profile::constant(0.0),
        direction: Profile::constant(direction),
        torsion: Torsion::SaintVenant,
        below: BelowPlate::Plain,
        pattern: None,
    }
}

fn radii(outline: &Outline) -> (f64, f64) {
    match *outline {
        Outline::Round { outer_radius, inner_radius } => (outer_radius, inner_radius),
        Outline::Polygon { outer_apothem, inner_apothem, .. } => (outer_apothem, inner_apothem),
    }
}

fn read_outline(
    cursor: &Cursor<'_, '_>,
    length: Option<f64>,
    out: &mut Collector,
) -> Option<(Outline, Range<usize>)> {
    let outer_radius = cursor.number("outer_radius_mm", &RADIUS, out);
    let inner_radius = cursor.number("inner_radius_mm", &BORE, out);
    let sides = match cursor.get("shape") {
        None => Some(None),
        Some(entry) => entry.word(&["round", "square", "hexagon"], out).map(|word| match word {
            "square" => Some(4),
            "hexagon" => Some(6),
            _ => None,
        }),
    };
    let (outer, inner) = (outer_radius?, inner_radius?);
    let outer_entry = cursor.get("outer_radius_mm")?;
    let span = outer_entry.span.clone();
    if inner >= outer {
        let entry = cursor.get("inner_radius_mm")?;
        let message =
            format!("{} leaves no wall in a tube of outer radius {}", print_mm(inner), print_mm(outer));
        entry.wrong(message, format!("Write a radius below {}.", print(outer * 1e3)), out);
        return None;
    }
    if outer - inner < LEAST_WALL {
        let entry = cursor.get("inner_radius_mm")?;
        let message = format!(
            "{} in a tube of outer radius {} leaves a thinner wall than any robot has ({})",
            print_mm(inner),
            print_mm(outer),
            print_mm(LEAST_WALL)
        );
        entry.wrong(message, format!("Write a radius below {}.", print((outer - LEAST_WALL) * 1e3)), out);
        return None;
    }
    if let Some(length) = length {
        let size = format!("length_mm = {}", print(length * 1e3));
        if outer > length {
            let message = format!(
                "a radius of {} is larger than the tube is long ({})",
                print_mm(outer),
                print_mm(length)
            );
            outer_entry.wrong(message, format!("Write both in millimetres; the file has {size}."), out);
            return None;
        }
        if outer * SLENDER < length {
            let message = format!(
                "a radius of {} is less than a ten-thousandth of the length ({})",
                print_mm(outer),
                print_mm(length)
            );
            outer_entry.wrong(message, format!("Write both in millimetres; the file has {size}."), out);
            return None;
        }
    }
    let outline = match sides? {
        None => Outline::Round { outer_radius: outer, inner_radius: inner },
        Some(sides) => Outline::Polygon { sides, outer_apothem: outer, inner_apothem: inner },
    };
    Some((outline, span))
}

/// Reports every follower that is wider than the bore it slides in.
pub(crate) fn check_nesting(tubes: &[Tube], out: &mut Collector) {
    // A tube of given stiffness has no known bore: the next tube is held against the bore outside it.
    let mut around: Option<(usize, &Outline)> = None;
    for (index, tube) in tubes.iter().enumerate() {
        let Some((outline, span)) = &tube.outline else {
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
                let most = print(radii(outline).0 * bore / reach * 1e3);
                let help = if bore > 0.0 {
                    format!("Write an outer radius of at most {most}, or widen the bore.")
                } else {
                    format!("Give tube {outer} a bore to slide in.")
                };
                out.wrong(span.clone(), format!("tube {}, outer_radius_mm", index + 1), message, help);
            }
        }
        around = Some((index + 1, outline));
    }
}
