//! Bundle files: robot files whose tubes have parts, rest curvature, shafts or lengths of their own, and joints.
//!
//! All keys of [`crate::robot_file`] keep their meaning, and any robot file can be read as a bundle. In addition:
//!
//! | table | keys |
//! |---|---|
//! | the file | `length_mm` is that of tubes that say none |
//! | `[[tube]]` | `length_mm`, `rest_curvature_1_m` (0), `rest_direction_deg` (0), unless it has parts |
//! | `[[tube.part]]`, from base to tip | `length_mm`, `notches` or `stiffness` as a tube's (neither: uncut), `rest_curvature_1_m` (0), `rest_direction_deg` (0: towards +Y) |
//! | `[material]` | `onset_strain_percent`, `second_modulus_GPa`, `unloading_onset_strain_percent` where it unloads below, and under compression, where it differs, the same with `compression_` before them |
//! | `[tube.notches]` | `contact` (false): teeth that meet carry load |
//! | `[tube.shaft]` | `length_mm` of an uncut tube between motor and plate, or `axial_N_mm` and `torsional_Nmm_deg` |
//! | `[[joint]]` | `tubes`, numbers from 1; `at_mm`, a label on each (their tips) |
//!
//! Without any joint all tips are bonded to each other, which takes tubes of one length; `joint = []` leaves all tips free.
//! Along a part, abscissae count from the part's base. A first part of length 0 is what lies below the plate alone.

use crate::cursor::Cursor;
use crate::material::{Common, SOFTENING, Written};
use crate::notches::read_notches;
use crate::problems::{Collector, Problems};
use crate::profile_value::numbers;
use crate::quantity::{
    ANGLE, AXIAL_SPRING, CURVATURE, FACTOR, LENGTH, NUMBER, PART, TORSION_SPRING, print, print_mm,
};
use crate::robot_file::{
    self, RobotFile, parse_as, read_as, read_factor, read_friction, read_name, read_tubes, text_of,
};
use crate::stiffness::read_stiffness;
use crate::sudden::sudden_changes;
use crate::tube_file::{self, Robot, Tube, check_nesting, notched, read_outline, uncut};
use cppr::bundle::{BundleDesign, Friction, Part, Shaft, TubeParts};
use cppr::design::{Material, Outline, TubeDesign};
use std::path::Path;
use toml::de::{DeTable, DeValue};

const KEYS: [&str; 7] = ["name", "length_mm", "material", "calibration", "friction", "tube", "joint"];
const TUBE_KEYS: [&str; 14] = [
    "outer_radius_mm",
    "inner_radius_mm",
    "outer_diameter_mm",
    "inner_diameter_mm",
    "shape",
    "centroid_offset_factor",
    "material",
    "notches",
    "stiffness",
    "length_mm",
    "rest_curvature_1_m",
    "rest_direction_deg",
    "part",
    "shaft",
];
const PART_KEYS: [&str; 5] =
    ["length_mm", "notches", "stiffness", "rest_curvature_1_m", "rest_direction_deg"];
/// Keys of a tube that make its file a bundle.
const MARKS: [&str; 5] = ["part", "shaft", "length_mm", "rest_curvature_1_m", "rest_direction_deg"];
/// Lengths that differ by less than this part are the same.
const SAME: f64 = 1e-9;
/// Most parts of a tube.
const MOST_PARTS: usize = 200;

/// What a file describes.
#[derive(Clone, Debug)]
pub enum Described {
    /// Tubes of one length, joined at the tip, one pattern along each.
    Robot(RobotFile),
    /// Anything else.
    Bundle {
        /// Its parts and joints.
        design: BundleDesign,
        /// How the tubes rub on each other, where the file says it.
        friction: Option<Friction>,
    },
}

impl Described {
    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Robot(file) => &file.design.name,
            Self::Bundle { design, .. } => &design.name,
        }
    }

    /// How the tubes rub on each other, where the file says it.
    #[must_use]
    pub fn friction(&self) -> Option<Friction> {
        match self {
            Self::Robot(file) => file.friction,
            Self::Bundle { friction, .. } => *friction,
        }
    }

    /// The robot as parts and joints.
    #[must_use]
    pub fn into_bundle(self) -> BundleDesign {
        match self {
            Self::Robot(file) => BundleDesign::from(&file.design),
            Self::Bundle { design, .. } => design,
        }
    }

    /// The robot as it is to be solved: as parts and joints, which are integrated along their length, where it has sudden changes that modes do not follow.
    /// With the places of these changes ([`sudden_changes`]); `None` where it is as it was.
    #[must_use]
    pub fn integrated(self) -> (Self, Option<String>) {
        let Self::Robot(file) = &self else { return (self, None) };
        let Some(places) = sudden_changes(&file.design) else { return (self, None) };
        (Self::Bundle { friction: file.friction, design: self.into_bundle() }, Some(places))
    }
}

/// Reads a file of either kind.
///
/// # Errors
/// All problems of the file, under its path.
pub fn read(path: impl AsRef<Path>) -> Result<Described, Problems> {
    read_as(path.as_ref(), |bytes| parse_either(text_of(bytes)?))
}

/// Reads the text of a file of either kind.
///
/// # Errors
/// All problems of the text.
pub fn parse_either(text: &str) -> Result<Described, Problems> {
    if is_bundle(DeTable::parse_recoverable(text).0.get_ref()) {
        parse_as(text, |table, out| Ok(bundle_of(table, out)))
            .map(|(design, friction)| Described::Bundle { design, friction })
    } else {
        robot_file::parse(text).map(Described::Robot)
    }
}

/// Reads any robot file as a bundle.
///
/// # Errors
/// All problems of the file, under its path.
pub fn read_bundle(path: impl AsRef<Path>) -> Result<BundleDesign, Problems> {
    read_as(path.as_ref(), |bytes| parse(text_of(bytes)?))
}

/// Reads a bundle from the text of a file.
///
/// # Errors
/// All problems of the text.
pub fn parse(text: &str) -> Result<BundleDesign, Problems> {
    parse_as(text, |table, out| Ok(bundle_of(table, out).map(|own| own.0)))
}

/// Has the file a key that no robot of one length, joined at the tip, has?
pub(crate) fn is_bundle(table: &DeTable<'_>) -> bool {
    let has = |table: &DeTable<'_>, name: &str, keys: &[&str]| {
        let inner = table.get(name).and_then(|value| value.get_ref().as_table());
        inner.is_some_and(|inner| keys.iter().any(|key| inner.contains_key(*key)))
    };
    let softens = |table: &DeTable<'_>| has(table, "material", &SOFTENING);
    let marked = |tube: &DeValue<'_>| {
        tube.as_table().is_some_and(|tube| {
            MARKS.iter().any(|mark| tube.contains_key(*mark))
                || softens(tube)
                || has(tube, "notches", &["contact"])
        })
    };
    let tubes = table.get("tube").map(toml::Spanned::get_ref);
    table.contains_key("joint")
        || softens(table)
        || tubes.is_some_and(marked)
        || tubes.and_then(DeValue::as_array).is_some_and(|t| t.iter().any(|item| marked(item.get_ref())))
}

/// One tube as far as it could be read.
#[derive(Default)]
struct Read {
    parts: Option<Vec<Part>>,
    shaft: Option<Shaft>,
    length: Option<f64>,
    /// For the comparison with its neighbours.
    tube: Tube,
}

fn bundle_of(table: &DeTable<'_>, out: &mut Collector) -> Option<(BundleDesign, Option<Friction>)> {
    let root = Cursor::new(table, 0..0, String::new(), &KEYS, out);
    let name = read_name(&root, out);
    let length = root.field("length_mm", &LENGTH, out);
    let material = Common::read(&root, out);
    let factor = read_factor(&root, out);
    let friction = read_friction(&root, out);
    let mut common = Robot { length: length.value, material, factor };
    let tubes = read_tubes(&root, &TUBE_KEYS, out, |cursor, number, out| {
        read_tube(cursor, number, length.present, &mut common, out)
    });
    let joints = read_joints(&root, &tubes, out);
    let (outlines, tubes): (Vec<Tube>, Vec<_>) =
        tubes.into_iter().map(|t| (t.tube, t.parts.map(|parts| TubeParts::new(parts, t.shaft)))).unzip();
    check_nesting(&outlines, out);
    let tubes = tubes.into_iter().collect::<Option<Vec<_>>>()?;
    (!tubes.is_empty()).then_some(())?;
    Some((BundleDesign { name: name?, tubes, joints: joints? }, friction))
}

fn read_tube(
    cursor: &Cursor<'_, '_>,
    number: usize,
    common_length: bool,
    common: &mut Robot,
    out: &mut Collector,
) -> Read {
    if cursor.has("part") {
        return read_parts(cursor, number, common, out);
    }
    let own = cursor.field("length_mm", &LENGTH, out);
    if !(own.present || common_length) {
        let help = "Write length_mm = 150.0 in this tube, or once at the top for all of them.";
        out.missing(cursor.span(), cursor.path("length_mm"), "this tube has no length", help);
    }
    let length = if own.present { own.value } else { common.length };
    let mut robot = Robot { length, material: common.material.clone(), factor: common.factor };
    let tube = tube_file::read_tube(cursor, number, &mut robot, out);
    common.material = robot.material;
    let rest = read_rest(cursor, out);
    let part = length.zip(tube.design.clone()).zip(rest).map(|((length, body), [curvature, direction])| {
        Part { length, body, rest_curvature: curvature, rest_direction: direction }
    });
    let section = match &tube.design {
        Some(TubeDesign::Notched(t)) => Some((t.outline.clone(), t.material)),
        _ => None,
    };
    let shaft = read_shaft(cursor, section.as_ref(), cursor.has("stiffness"), out);
    Read { parts: part.map(|part| vec![part]), shaft, length, tube }
}

fn read_parts(cursor: &Cursor<'_, '_>, number: usize, common: &mut Robot, out: &mut Collector) -> Read {
    let own = cursor.field("centroid_offset_factor", &FACTOR, out);
    let factor = if own.present { own.value } else { common.factor };
    for key in PART_KEYS {
        if let Some(entry) = cursor.get(key) {
            let message = "this tube has parts, and this key belongs to one of them";
            let help = match key {
                "notches" | "stiffness" => format!("Write [tube.part.{key}] below its [[tube.part]]."),
                _ => format!("Write {key} below [[tube.part]]."),
            };
            out.wrong(entry.key_span, entry.key, message, help);
        }
    }
    let prefix = |n: usize| format!("tube {number}, part {n}, ");
    let entry = cursor.get("part");
    let parts =
        entry.as_ref().map(|e| e.tables("[[tube.part]]", prefix, &PART_KEYS, out)).unwrap_or_default();
    if let Some(entry) = entry.filter(|_| parts.is_empty() || parts.len() > MOST_PARTS) {
        entry.wrong(
            format!("the tube has {} parts", parts.len()),
            format!("Write from 1 to {MOST_PARTS}."),
            out,
        );
        return Read::default();
    }
    let lengths: Vec<Option<f64>> =
        parts.iter().enumerate().map(|(i, part)| read_length(part, i == 0 && parts.len() > 1, out)).collect();
    let total = lengths.iter().copied().sum::<Option<f64>>();
    let by_section = parts.iter().any(|part| !part.has("stiffness"));
    let given = ["outer_radius_mm", "inner_radius_mm", "shape"].into_iter().any(|key| cursor.has(key));
    let outline = (by_section || given).then(|| read_outline(cursor, total, out)).flatten();
    let written = Written::read(cursor, out);
    let material = if by_section { common.material.resolve(&written, out) } else { None };
    let mut built = Vec::new();
    for (index, (part, length)) in parts.iter().zip(&lengths).enumerate() {
        let section = outline.as_ref().map(|(outline, _)| outline).zip(material.as_ref());
        let body = read_body(part, number, *length, section, factor, out);
        let below = part.get("notches").and_then(|e| e.value.as_table()?.get_key_value("below_plate"));
        if let (Some((key, _)), true) = (below, index > 0) {
            let message = "only the first part of a tube goes on below the plate";
            out.wrong(key.span(), part.path("notches.below_plate"), message, "Leave it out here.");
        }
        let rest = read_rest(part, out);
        built.push(length.zip(body).zip(rest).map(|((length, body), [curvature, direction])| Part {
            length,
            body,
            rest_curvature: curvature,
            rest_direction: direction,
        }));
    }
    let section = outline.as_ref().map(|(outline, _)| outline.clone()).zip(material);
    let shaft = read_shaft(cursor, section.as_ref(), !by_section, out);
    let parts = built.into_iter().collect::<Option<Vec<_>>>();
    Read { parts, shaft, length: total, tube: Tube { outline, ..Tube::default() } }
}

/// The length of a part; zero says that it lies below the plate.
fn read_length(part: &Cursor<'_, '_>, may_be_below: bool, out: &mut Collector) -> Option<f64> {
    let length = part.number("length_mm", &PART, out)?;
    if length <= 0.0 && !may_be_below {
        let message = "this part has no length";
        let help = "Only the first of several parts may have none: it is what lies below the plate.";
        out.wrong(part.get("length_mm")?.span, part.path("length_mm"), message, help);
        return None;
    }
    Some(length)
}

fn read_body(
    part: &Cursor<'_, '_>,
    number: usize,
    length: Option<f64>,
    section: Option<(&Outline, &Material)>,
    factor: Option<f64>,
    out: &mut Collector,
) -> Option<TubeDesign> {
    if let (Some(entry), true) = (part.get("stiffness"), part.has("notches")) {
        let message = "notches are given too, and either of them fixes the stiffness";
        out.wrong(entry.key_span, entry.key, message, "Keep one of notches and stiffness.");
    }
    if part.has("stiffness") {
        return read_stiffness(part, number, length, factor, out).map(TubeDesign::Stiffness);
    }
    let notches = if part.has("notches") {
        read_notches(part, number, length, section.map(|(outline, _)| outline), out)
    } else {
        Some(uncut(number))
    };
    let (outline, material) = section?;
    notched(notches?, outline.clone(), *material, factor?, length, out)
}

/// Curvature (1/m) and direction (rad) of the free part.
fn read_rest(cursor: &Cursor<'_, '_>, out: &mut Collector) -> Option<[f64; 2]> {
    let curvature = cursor.field("rest_curvature_1_m", &CURVATURE, out);
    let direction = cursor.field("rest_direction_deg", &ANGLE, out);
    if let (Some(entry), false) = (cursor.get("rest_direction_deg"), curvature.present) {
        let help = "Write rest_curvature_1_m = 10.0 beside it.";
        entry.wrong("a direction says nothing without a curvature", help, out);
    }
    let value = |present: bool, value: Option<f64>| if present { value } else { Some(0.0) };
    Some([
        value(curvature.present, curvature.value)?,
        value(direction.present, direction.value)?.to_radians(),
    ])
}

fn read_shaft(
    parent: &Cursor<'_, '_>,
    section: Option<&(Outline, Material)>,
    no_section: bool,
    out: &mut Collector,
) -> Option<Shaft> {
    let cursor = parent.child("shaft", &["length_mm", "axial_N_mm", "torsional_Nmm_deg"], out)?;
    let springs = cursor.has("axial_N_mm") || cursor.has("torsional_Nmm_deg");
    if let Some(entry) = cursor.get("length_mm").filter(|_| springs || no_section) {
        let (message, help) = if springs {
            ("a stiffness is given too", "Keep the length, or axial_N_mm and torsional_Nmm_deg.")
        } else {
            (
                "the section of this tube is not known, so that its length says nothing",
                "Write axial_N_mm and torsional_Nmm_deg instead.",
            )
        };
        entry.wrong(message, help, out);
        return None;
    }
    if springs {
        let axial = cursor.number("axial_N_mm", &AXIAL_SPRING, out);
        let torsional = cursor.number("torsional_Nmm_deg", &TORSION_SPRING, out);
        return Some(Shaft { axial: axial?, torsional: torsional?, of_material: false });
    }
    let length = cursor.number("length_mm", &LENGTH, out)?;
    let (outline, material) = section?;
    match outline.notched(0.0) {
        Ok(uncut) => Some(Shaft {
            axial: material.youngs_modulus * uncut.area / length,
            torsional: material.shear_modulus() * uncut.torsion_constant / length,
            of_material: true,
        }),
        Err(error) => {
            out.wrong(cursor.span(), cursor.path(""), error.to_string(), "");
            None
        }
    }
}

type Joint = Vec<(usize, f64)>;

fn read_joints(root: &Cursor<'_, '_>, tubes: &[Read], out: &mut Collector) -> Option<Vec<Joint>> {
    let Some(entry) = root.get("joint") else {
        let lengths = tubes.iter().map(|tube| tube.length).collect::<Option<Vec<f64>>>()?;
        let longest = lengths.iter().fold(0.0, |m: f64, l| m.max(*l));
        if lengths.len() < 2 {
            return Some(Vec::new());
        }
        if lengths.iter().any(|l| longest - l > SAME * longest) {
            let list: Vec<String> = lengths.iter().map(|l| print(l * 1e3)).collect();
            let message = format!(
                "the tubes are {} mm long, so that their tips do not meet, and nothing says where they are bonded",
                list.join(", ")
            );
            let help = "Write a [[joint]] with tubes = [1, 2] for every joint, or joint = [] at the top if all tips are free.";
            out.missing(root.span(), "joint", message, help);
            return None;
        }
        return Some(vec![lengths.into_iter().enumerate().collect()]);
    };
    let cursors = entry.tables("[[joint]]", |n| format!("joint {n}, "), &["tubes", "at_mm"], out);
    let mut joints: Vec<Joint> = Vec::new();
    let mut sound = entry.value.as_array().is_some();
    for cursor in &cursors {
        match read_joint(cursor, tubes, &joints, out) {
            Some(joint) => joints.push(joint),
            None => sound = false,
        }
    }
    sound.then_some(joints)
}

fn read_joint(
    cursor: &Cursor<'_, '_>,
    tubes: &[Read],
    before: &[Joint],
    out: &mut Collector,
) -> Option<Joint> {
    let help = "Write tubes = [1, 2], numbers from the outermost tube on.";
    let entry = cursor.require("tubes", help, out)?;
    let DeValue::Array(items) = entry.value else {
        entry.wrong("this must be a list of tubes", help, out);
        return None;
    };
    let named = numbers(&entry, items, &NUMBER, out)?;
    if named.len() < 2 {
        entry.wrong("a joint bonds two or more tubes", help, out);
        return None;
    }
    let at = match cursor.get("at_mm") {
        None => None,
        Some(at) => {
            let DeValue::Array(items) = at.value else {
                at.wrong("this must be a list with a label on every tube", "Write at_mm = [60, 60].", out);
                return None;
            };
            let labels = numbers(&at, items, &LENGTH, out)?;
            if labels.len() != named.len() {
                let message = format!("{} labels stand for {} tubes", labels.len(), named.len());
                at.wrong(message, "Write one per tube, or leave at_mm out for their tips.", out);
                return None;
            }
            Some(labels)
        }
    };
    let mut joint = Joint::new();
    for (place, name) in named.iter().enumerate() {
        let wrong = |message: String, help: &str, out: &mut Collector| {
            out.wrong(name.span.clone(), entry.key.clone(), message, help);
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1e6 as read")]
        let number = name.value as usize;
        let Some(tube) = tubes.get(number - 1).filter(|_| name.value.fract() <= 0.0) else {
            wrong(format!("there is no tube {}", name.value), help, out);
            return None;
        };
        if joint.iter().any(|other| other.0 == number - 1) {
            wrong(format!("tube {number} is named twice"), help, out);
            return None;
        }
        let length = tube.length?;
        let label = match at.as_ref().and_then(|labels| labels.get(place)) {
            Some(label) if label.value > length * (1.0 + SAME) => {
                let message = format!(
                    "{} lies beyond the tip of tube {number} at {}",
                    print_mm(label.value),
                    print_mm(length)
                );
                let help = format!("Write a label up to {}.", print(length * 1e3));
                out.wrong(label.span.clone(), cursor.path("at_mm"), message, help);
                return None;
            }
            Some(label) => label.value,
            None => length,
        };
        let same = |other: &&(usize, f64)| other.0 == number - 1 && (other.1 - label).abs() <= SAME * length;
        if let Some(other) = before.iter().position(|joint| joint.iter().any(|place| same(&place))) {
            let message = format!("joint {} bonds tube {number} there already", other + 1);
            wrong(message, "Write one joint that names all tubes bonded at one place.", out);
            return None;
        }
        joint.push((number - 1, label));
    }
    Some(joint)
}
