//! What the page must know of a robot: its tubes as they are cut, and how far its controls reach.

use crate::touch::Written;
use cppr::analysis::Shape;
use cppr::design::{Outline, Profile, Robot, TubeDesign};
use cppr_io::RobotFile;
use cppr_mesh::{Detail, TubeOptions, Tubes, tube_mesh};
use serde::Serialize;
use std::f64::consts::PI;

/// Places along a tube at which its cut is given.
const SAMPLES: u16 = 64;

/// A robot for the page.
#[derive(Clone, Debug, Serialize)]
pub struct Description {
    kind: &'static str,
    /// The same robot with other notches?
    changed: bool,
    name: String,
    length_mm: f64,
    tubes: Vec<Tube>,
    controls: Vec<Control>,
    /// Forces on the tip that bend the robot visibly.
    #[serde(rename = "force_N")]
    force: f64,
    has_mass: bool,
    can_stretch: bool,
    columns: &'static [&'static str],
    /// As the file says it.
    friction: Option<Written>,
}

/// One tube.
#[derive(Clone, Debug, Serialize)]
struct Tube {
    outer_mm: Option<f64>,
    inner_mm: Option<f64>,
    /// Sides of a polygon, 0 for a round tube.
    sides: u32,
    notch_mm: f64,
    tooth_mm: f64,
    count: u32,
    /// Does the pattern go on below the plate?
    continued: bool,
    /// Factor on the centroid offset in the kinematics, which the section itself has not.
    offset_factor: f64,
    /// At [`SAMPLES`] + 1 places from base to tip.
    depth_mm: Vec<f64>,
    /// Where the centroid is, about the axis from +Y towards +Z.
    direction_rad: Vec<f64>,
    /// The thickest that can be cut away.
    depth_limit_mm: f64,
}

/// Reach of the controls of one follower: about half a turn of the tip.
#[derive(Clone, Debug, Serialize)]
pub struct Control {
    /// Number of the tube.
    pub tube: usize,
    /// Translation.
    pub pull_mm: f64,
    /// Force (N).
    #[serde(rename = "tension_N")]
    pub tension: f64,
    /// Rotation.
    pub rotate_deg: f64,
    /// Torque (N mm).
    #[serde(rename = "torque_Nmm")]
    pub torque: f64,
}

impl Description {
    /// Describes a robot, its notches as they are now; `changed` where the page knows it with others.
    pub fn new(file: &RobotFile, robot: &Robot, changed: bool) -> Self {
        let length = robot.length();
        let middle = |tube| robot.fields_at(tube, 0.5 * length);
        let tubes = 0..robot.tube_count();
        let bending: f64 = tubes.clone().map(|t| middle(t).bending_z).sum();
        Self {
            kind: "robot",
            changed,
            name: robot.design().name.clone(),
            length_mm: length * 1e3,
            controls: controls(robot),
            force: nice(3.0 * bending / (length * length)),
            has_mass: robot.has_mass(),
            can_stretch: robot.has_axial_stiffness(),
            tubes: tubes.map(|t| Tube::new(file, robot, t)).collect(),
            columns: &crate::message::COLUMNS,
            friction: file.friction.map(Written::from),
        }
    }
}

/// The controls of all followers.
pub fn controls(robot: &Robot) -> Vec<Control> {
    let length = robot.length();
    let middle = (0..robot.tube_count()).map(|tube| robot.fields_at(tube, 0.5 * length));
    let (bending, torsion) = middle.fold((0.0, 0.0), |(b, t), f| (b + f.bending_z, t + f.torsion));
    let control = |t| Control {
        tube: t + 1,
        pull_mm: longest_pull(robot, t) * 1e3,
        tension: nice(bending * PI / (length * lever(robot, t))),
        rotate_deg: 180.0,
        torque: nice(torsion * PI / length * 1e3),
    };
    (1..robot.tube_count()).map(control).collect()
}

/// Distance of the centroid lines of a follower and the leader halfway (m).
fn lever(robot: &Robot, tube: usize) -> f64 {
    let offset = |t| robot.fields_at(t, 0.5 * robot.length()).centroid_offset;
    (offset(0) + offset(tube)).max(1e-5)
}

/// The motion that turns the tip by about half a turn (m).
fn longest_pull(robot: &Robot, tube: usize) -> f64 {
    nice((PI * lever(robot, tube)).min(0.25 * robot.length()) * 1e3) * 1e-3
}

/// Sections of a body along the robot.
const STEPS: f64 = 50.0;
/// What of a follower is drawn below the plate: its longest push and some more.
const BELOW: f64 = 1.2;
/// Sharpest bend that is shaded smoothly (rad): more than a chord of a coarse circle turns.
const CREASE: f64 = 0.6;

/// The bodies of all tubes whose geometry is known, as messages: the fine ones, and coarse ones for a renderer that is
/// too slow for them while the robot moves.
pub fn bodies(file: &RobotFile, robot: &Robot) -> Vec<Vec<u8>> {
    let below = |tube: usize| if tube == 0 { 0.0 } else { BELOW * longest_pull(robot, tube) };
    // A tube that is given by its stiffness is drawn as its centroid line.
    let body = |tube: usize, coarse: bool| body(file, tube, coarse, robot.length(), below(tube));
    let both = [false, true].into_iter();
    both.flat_map(|coarse| (0..robot.tube_count()).filter_map(move |tube| body(tube, coarse))).collect()
}

/// The body of a tube of a robot of some length (m), with so much below the plate (m); `None` where there is none.
pub(crate) fn body(robot: &dyn Tubes, tube: usize, coarse: bool, length: f64, below: f64) -> Option<Vec<u8>> {
    let fine = Detail::drawing(length / STEPS);
    let outer = robot.parts(tube).into_iter().find_map(|(_, body)| match body {
        TubeDesign::Notched(own) => Some(radii(&own.outline)[0]),
        TubeDesign::Stiffness(_) => None,
    })?;
    // Circles of at least 12 chords, which leave them by a tenth of the radius at most.
    let detail = if coarse { Detail { chord: 0.09 * outer, turn: 0.53, ..fine } } else { fine };
    let mesh = tube_mesh(robot, tube, &TubeOptions { below, ..TubeOptions::plain(detail) }).ok()?;
    Some(crate::message::mesh(tube, coarse, &mesh.shaded(CREASE)))
}

/// Outer and inner radius, or half the widths across flats (m).
pub(crate) fn radii(outline: &Outline) -> [f64; 2] {
    match *outline {
        Outline::Round { outer_radius, inner_radius } => [outer_radius, inner_radius],
        Outline::Polygon { outer_apothem, inner_apothem, .. } => [outer_apothem, inner_apothem],
    }
}

/// Centroid offset (m) and bending stiffness about the soft axis (N m²) half-way along a part of some length (m).
pub(crate) fn offset_and_bending(body: &TubeDesign, length: f64) -> [f64; 2] {
    let middle = |profile: &Profile| profile.eval(0.5 * length, length)[0];
    match body {
        TubeDesign::Notched(own) => {
            own.outline.inertia(middle(&own.depth)).map_or([0.0, f64::INFINITY], |i| {
                [own.centroid_offset_factor * i.centroid_offset, own.material.youngs_modulus * i.inertia_z]
            })
        }
        TubeDesign::Stiffness(own) => {
            [own.centroid_offset_factor * middle(&own.centroid_offset), middle(&own.bending_z)]
        }
    }
}

impl Tube {
    fn new(file: &RobotFile, robot: &Robot, index: usize) -> Self {
        let (length, own) = (robot.length(), file.tubes.get(index));
        let along = |value: &dyn Fn(f64) -> f64| {
            (0..=SAMPLES).map(|i| value(length * f64::from(i) / f64::from(SAMPLES))).collect()
        };
        let notched = match &robot.design().tubes[index] {
            TubeDesign::Notched(tube) => Some(tube),
            TubeDesign::Stiffness(_) => None,
        };
        let pattern = own.and_then(|t| t.notches);
        Self {
            outer_mm: own.and_then(|t| t.outer_radius).map(|r| r * 1e3),
            inner_mm: own.and_then(|t| t.inner_radius).map(|r| r * 1e3),
            sides: match notched.map(|t| &t.outline) {
                Some(Outline::Polygon { sides, .. }) => u32::try_from(*sides).unwrap_or(0),
                _ => 0,
            },
            notch_mm: pattern.map_or(0.0, |p| p.length * 1e3),
            tooth_mm: pattern.map_or(0.0, |p| p.tooth * 1e3),
            count: pattern.map_or(0, |p| p.count),
            continued: notched.is_some_and(|t| t.below == cppr::design::BelowPlate::Continued),
            offset_factor: own.map_or(1.0, |t| t.centroid_offset_factor),
            depth_mm: notched.map_or_else(Vec::new, |t| along(&|x| t.depth.eval(x, length)[0] * 1e3)),
            direction_rad: along(&|x| robot.fields_at(index, x).direction),
            depth_limit_mm: notched.map_or(0.0, |t| t.outline.depth_limit() * 1e3),
        }
    }
}

/// Number of tubes of a shape.
pub fn tubes(shape: &Shape) -> usize {
    shape.sections.first().map_or(0, |s| s.tubes.len())
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 … times a power of ten.
pub(crate) fn nice(value: f64) -> f64 {
    let unit = 10_f64.powf(value.max(1e-9).log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    steps.iter().map(|step| step * unit).find(|&step| step >= value * (1.0 - 1e-9)).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::{bodies, nice};
    use cppr::design::Robot;

    #[test]
    fn nice_numbers_are_nice() {
        for (value, want) in [(13.2, 15.0), (0.42, 0.5), (9.1, 10.0), (1.0, 1.0), (0.0011, 0.0015)] {
            assert!((nice(value) - want).abs() < 1e-12 * want, "{value}");
        }
    }

    /// Every tube twice; the coarse body has about half the triangles, on the same stretch of the axis.
    #[test]
    fn bodies_come_fine_and_coarse() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/r1.toml");
        let file = cppr_io::robot_file::read(path).unwrap();
        let robot = Robot::from_design(file.design.clone()).unwrap();
        let read = |message: Vec<u8>| {
            let length = 4 + u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
            let head: serde_json::Value = serde_json::from_slice(&message[4..length]).unwrap();
            let vertices = usize::try_from(head["vertices"].as_u64().unwrap()).unwrap();
            let x = message[length..].chunks(12).take(vertices);
            let x: Vec<f32> = x.map(|p| f32::from_le_bytes(p[..4].try_into().unwrap())).collect();
            let ends = (x.iter().copied().fold(0.0, f32::min), x.iter().copied().fold(0.0, f32::max));
            (head["tube"].as_u64(), head["coarse"].as_bool(), head["triangles"].as_u64().unwrap(), ends)
        };
        let all: Vec<_> = bodies(&file, &robot).into_iter().map(read).collect();
        let (fine, coarse) = all.split_at(2);
        for (fine, coarse) in fine.iter().zip(coarse) {
            assert_eq!((fine.0, fine.1, coarse.1), (coarse.0, Some(false), Some(true)));
            assert!(2 * coarse.2 <= fine.2 + fine.2 / 8, "{} and {} triangles", fine.2, coarse.2);
            assert_eq!(fine.3, coarse.3);
        }
    }
}
