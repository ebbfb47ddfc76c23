//! Robot files: TOML that describes a robot, read and checked as a whole.
//!
//! Lengths are in mm, moduli in GPa, angles in degrees, each said by the key; the [`RobotFile`] is in SI.
//!
//! | table | keys |
//! |---|---|
//! | the file | `name`, `length_mm` |
//! | `[material]`, `[tube.material]` | `youngs_modulus_GPa`, `poissons_ratio` or `shear_modulus_GPa`, `density_kg_m3`, `allowable_strain_percent` (none); a tube's keys take the place of the robot's |
//! | `[calibration]` | `centroid_offset_factor` (1) |
//! | `[friction]`, between all tubes (none) | `coefficient`, `guide_mm`: the length of the guide below the plate in which tubes rub too (none) |
//! | `[[tube]]`, the leader first | `outer_radius_mm`, `inner_radius_mm`, `shape` ("round"; "square" and "hexagon" take half the width across flats as radii), `centroid_offset_factor` (that of the robot) |
//! | `[tube.notches]` | `depth_mm`, `length_mm`, `tooth_mm`, `count` (as many as fit), `opening_deg`, `twist_deg` (0), `torsion` ("saint-venant", "polar" or `{ stiffness_Nmm2 = ... }`), `below_plate` ("plain" or "continued"), `teeth` ("flexible", "rigid" or "cell"), and with cells `cut` ("plane" or "radial"), `corner_radius_mm` (sharp), `tooth_factor` (1) |
//! | `[tube.stiffness]`, instead of radii and notches | `centroid_offset_mm`, `bending_y_Nmm2`, `bending_z_Nmm2`, `torsion_Nmm2`, `axial_N` (unknown), `mass_per_length_g_m` (0), `opening_deg`, `twist_deg` (0) |
//!
//! A direction is that to which the notches open, from +Y towards +Z; the centroid lies on the other side,
//! φ = opening + 180°. The leader opens to 180° unless told otherwise, followers must say where they open to.
//!
//! A value along a tube is a number, `[base, tip]`, or a table `{ x_mm = [0, 150], depth_mm = [8.2, 7.2] }`;
//! under `notches`, depth and opening may also be a list with one value per notch, from the base on. A list
//! of two numbers is always base and tip: a pattern of just two notches is written as a table. The notches
//! stand in cells of `length_mm` + `tooth_mm` from the baseplate on, each in the middle of its cell.
//!
//! Where a shear modulus is given, [`cppr::design::Material::poissons_ratio`] is the number that yields it,
//! E / (2 G) − 1, which may lie outside what an isotropic material can have.

use crate::bundle_file::is_bundle;
use crate::cursor::{Cursor, kind};
use crate::material::Common;
use crate::problems::{Collector, Problem, Problems};
use crate::quantity::{FACTOR, FRICTION, LENGTH};
use crate::syntax::report_syntax;
use crate::tube_file::{KEYS as TUBE_KEYS, Robot, check_nesting, read_tube};
use cppr::bundle::Friction;
pub use cppr::design::NotchPattern;
use cppr::design::RobotDesign;
use std::io::Read;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Largest robot file (bytes).
pub const LARGEST: usize = 1 << 20;

const KEYS: [&str; 6] = ["name", "length_mm", "material", "calibration", "friction", "tube"];
const EXAMPLE: &str =
    "Write at least name, length_mm, a [material] and one [[tube]]; the folder robots holds examples.";
/// Most tubes of a robot.
const MOST_TUBES: usize = 16;
/// Longest name (characters).
const LONGEST_NAME: usize = 200;

/// A robot file that was found sound.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFile {
    /// The robot.
    pub design: RobotDesign,
    /// What the file says of each tube beyond its design, in the same order.
    pub tubes: Vec<TubeFile>,
    /// Factor on the centroid offsets under `[calibration]`; a tube may have its own.
    pub centroid_offset_factor: f64,
    /// How the tubes rub on each other, where the file says it.
    pub friction: Option<Friction>,
}

/// What a robot file says of a tube that its design does not carry: for drawings and limits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TubeFile {
    /// Outer radius, or half the width across flats (m); none where the stiffness is given.
    pub outer_radius: Option<f64>,
    /// Inner radius, or half the width across flats (m); none where the stiffness is given.
    pub inner_radius: Option<f64>,
    /// The notches, where the file gives their length.
    pub notches: Option<NotchPattern>,
    /// Factor on the centroid offset of this tube.
    pub centroid_offset_factor: f64,
}

/// Reads a robot file.
///
/// # Errors
/// All problems of the file, under its path: that it cannot be read, is too large, is not UTF-8, is not
/// TOML, or does not describe a robot.
pub fn read(path: impl AsRef<Path>) -> Result<RobotFile, Problems> {
    read_as(path.as_ref(), parse_bytes)
}

/// Reads a file and parses it; problems come under its path.
pub(crate) fn read_as<T>(
    path: &Path,
    parse: impl FnOnce(&[u8]) -> Result<T, Problems>,
) -> Result<T, Problems> {
    let open = || -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        // One byte more than allowed is enough to know that there are too many.
        std::fs::File::open(path)?.take(LARGEST as u64 + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let parsed = match open() {
        Ok(bytes) => parse(&bytes),
        Err(error) => {
            Err(Problems::of_file(format!("the file cannot be read ({error})"), "Check its name and folder."))
        }
    };
    parsed.map_err(|problems| problems.in_file(path.display().to_string()))
}

/// Reads a robot file and builds its robot.
///
/// # Errors
/// All problems of the file, or of the design that it describes.
pub fn read_robot(path: impl AsRef<Path>) -> Result<cppr::design::Robot, Problems> {
    let path = path.as_ref();
    let file = read(path)?;
    cppr::design::Robot::from_design(file.design).map_err(|problems| {
        let list = problems.0.iter().map(|problem| Problem::of_file(problem.to_string(), "")).collect();
        Problems { list, ..Problems::default() }.in_file(path.display().to_string())
    })
}

/// Reads a robot from the bytes of a file.
///
/// # Errors
/// All problems of the file.
pub fn parse_bytes(bytes: &[u8]) -> Result<RobotFile, Problems> {
    parse(text_of(bytes)?)
}

/// The text of a file's bytes.
pub(crate) fn text_of(bytes: &[u8]) -> Result<&str, Problems> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(_) if bytes.len() > LARGEST => Err(too_large()),
        Err(error) => {
            let sound = bytes.get(..error.valid_up_to()).unwrap_or_default();
            let line = sound.split(|byte| *byte == b'\n').count();
            let message = format!("the file is not UTF-8 text: line {line} has a byte that cannot be");
            Err(Problems::of_file(message, "Save it as UTF-8."))
        }
    }
}

fn too_large() -> Problems {
    Problems::of_file("the file is larger than 1 MiB", "A robot file has a few lines. Is it another file?")
}

/// Reads a robot from the text of a file.
///
/// # Errors
/// All problems of the text.
pub fn parse(text: &str) -> Result<RobotFile, Problems> {
    parse_as(text, |table, out| {
        if is_bundle(table) {
            Err(Problems::of_file(
                "the file has joints, parts, shafts, metal that softens, teeth in contact, or tubes with a length or a rest \
                 curvature of their own, which this command does not take yet",
                "`cppr solve`, `check`, `sweep`, `derivatives`, `limits`, `reach`, `match`, `sense`, `calibrate`, `continue`, `export` and `view` take it; in Python \
                 cppr.Bundle does.",
            ))
        } else {
            Ok(robot_of(table, out))
        }
    })
}

/// Parses TOML and reads it with `of`, whose problems go into the collector; `None` only after a problem. A file that is of another
/// kind altogether has that as its only problem.
pub(crate) fn parse_as<T>(
    text: &str,
    of: impl FnOnce(&DeTable<'_>, &mut Collector) -> Result<Option<T>, Problems>,
) -> Result<T, Problems> {
    if text.len() > LARGEST {
        return Err(too_large());
    }
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(Problems::of_file("the file is empty", EXAMPLE));
    }
    let mut out = Collector::new(text);
    let (document, errors) = DeTable::parse_recoverable(text);
    report_syntax(text, &errors, &mut out);
    match of(document.get_ref(), &mut out)? {
        Some(file) if out.is_empty() => Ok(file),
        _ if out.is_empty() => Err(Problems::of_file("the file does not describe a robot", EXAMPLE)),
        _ => Err(out.finish()),
    }
}

fn robot_of(table: &DeTable<'_>, out: &mut Collector) -> Option<RobotFile> {
    let root = Cursor::new(table, 0..0, String::new(), &KEYS, out);
    let name = read_name(&root, out);
    let length = root.number("length_mm", &LENGTH, out);
    let material = Common::read(&root, out);
    let factor = read_factor(&root, out);
    let friction = read_friction(&root, out);
    let mut robot = Robot { length, material, factor };
    let tubes =
        read_tubes(&root, &TUBE_KEYS, out, |cursor, number, out| read_tube(cursor, number, &mut robot, out));
    check_nesting(&tubes, out);
    let files = tubes.iter().map(|tube| tube.file.clone()).collect();
    let designs = tubes.into_iter().map(|tube| tube.design).collect::<Option<Vec<_>>>()?;
    (!designs.is_empty()).then_some(())?;
    Some(RobotFile {
        design: RobotDesign { name: name?, length: length?, tubes: designs },
        tubes: files,
        centroid_offset_factor: factor?,
        friction,
    })
}

/// The factor under `[calibration]`.
pub(crate) fn read_factor(root: &Cursor<'_, '_>, out: &mut Collector) -> Option<f64> {
    let calibration = root.child("calibration", &["centroid_offset_factor"], out);
    match calibration.map(|c| c.field("centroid_offset_factor", &FACTOR, out)) {
        Some(field) if field.present => field.value,
        _ => Some(1.0),
    }
}

/// How tubes rub, under `[friction]`.
pub(crate) fn read_friction(root: &Cursor<'_, '_>, out: &mut Collector) -> Option<Friction> {
    let own = root.child("friction", &["coefficient", "guide_mm"], out)?;
    let coefficient = own.number("coefficient", &FRICTION, out);
    let guide = own.field("guide_mm", &LENGTH, out).value;
    Some(Friction { coefficient: coefficient?, guide })
}

pub(crate) fn read_name(root: &Cursor<'_, '_>, out: &mut Collector) -> Option<String> {
    let help = "Write name = \"R1\".";
    let entry = root.require("name", help, out)?;
    let name = entry.text(help, out)?;
    let fault = if name.trim().is_empty() {
        "the name is empty"
    } else if name.chars().count() > LONGEST_NAME {
        "the name is longer than 200 characters"
    } else if name.chars().any(char::is_control) {
        "the name has a control character"
    } else {
        return Some(name.to_owned());
    };
    entry.wrong(fault, help, out);
    None
}

/// Reads every `[[tube]]` with `read`, which gets its number (from 1); `keys` are those of a tube.
pub(crate) fn read_tubes<T: Default>(
    root: &Cursor<'_, '_>,
    keys: &[&'static str],
    out: &mut Collector,
    mut read: impl FnMut(&Cursor<'_, '_>, usize, &mut Collector) -> T,
) -> Vec<T> {
    let help = "Write a [[tube]] for the leader and one for each follower.";
    let Some(entry) = root.require("tube", help, out) else {
        return Vec::new();
    };
    let items = match entry.value {
        DeValue::Array(items) => items,
        DeValue::Table(table) => {
            out.wrong(
                entry.key_span.clone(),
                "tube",
                "the header stands in single brackets",
                "Write [[tube]].",
            );
            let cursor = Cursor::new(table, entry.key_span, "tube 1, ".to_owned(), keys, out);
            return vec![read(&cursor, 1, out)];
        }
        _ => {
            entry.wrong(format!("this must be [[tube]] tables, and it is {}", kind(entry.value)), help, out);
            return Vec::new();
        }
    };
    if items.is_empty() || items.len() > MOST_TUBES {
        let message = format!("the robot has {} tubes", items.len());
        entry.wrong(message, format!("Write from 1 to {MOST_TUBES}."), out);
        return Vec::new();
    }
    let mut tubes = Vec::new();
    for (index, item) in items.iter().enumerate() {
        let number = index + 1;
        let tube = if let DeValue::Table(table) = item.get_ref() {
            let cursor = Cursor::new(table, item.span(), format!("tube {number}, "), keys, out);
            read(&cursor, number, out)
        } else {
            let message = format!("this must be a [[tube]] table, and it is {}", kind(item.get_ref()));
            out.wrong(item.span(), format!("tube {number}"), message, help);
            T::default()
        };
        tubes.push(tube);
    }
    tubes
}
