//! The figure of a bundle: the centroid line of every tube as far as it reaches, joints, tip and forces.

use crate::Failure;
use crate::figure::{number, plot_failure, thread_arrow, wrench_arrow};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium};
use cppr::bundle::{BundleDesign, BundleSection};
use cppr::statics::Station;
use cppr::{Matrix3, Vector3};
use cppr_plot::{Figure, Force, Line, Marks, Part, Pose, ShapeInput, shape_figure};

/// Part of the extent below which a coordinate is rounding of the integration.
const FLAT: f64 = 1e-8;

/// Some of what is drawn, and what it is called.
pub type Named<'a, T> = Option<(&'a str, Vec<T>)>;

/// A pose with its forces and joints, over the robot at rest; where they are, with marks and the shape of another pose.
pub fn draw(
    design: &BundleDesign,
    found: &BundleEquilibrium,
    command: &BundleCommand,
    pose: &[BundleSection],
    rest: &[BundleSection],
    (marks, beside): (Named<[f64; 3]>, Named<BundleSection>),
) -> Result<Figure, Failure> {
    let joints = Marks { name: "joint".into(), points: joints(design, pose) };
    let others = marks.map(|(name, points)| Marks { name: name.into(), points });
    let own = Pose {
        label: if beside.is_some() { "loading".into() } else { String::new() },
        lines: lines(design, pose),
        forces: forces(found, command, pose),
    };
    let beside = beside.map(|(label, shape)| Pose {
        label: label.into(),
        lines: lines(design, &shape),
        forces: Vec::new(),
    });
    let input = ShapeInput {
        title: title(design, command),
        poses: std::iter::once(own).chain(beside).collect(),
        rest: lines(design, rest),
        marks: std::iter::once(joints).chain(others).filter(|marks| !marks.points.is_empty()).collect(),
        ..ShapeInput::default()
    };
    shape_figure(&input).map_err(|e| plot_failure(&e))
}

/// Name and actuation.
pub fn title(design: &BundleDesign, command: &BundleCommand) -> String {
    let mut parts = vec![design.name.clone()];
    for (i, drive) in command.drives.iter().enumerate() {
        let tube = i + 1;
        for (told, motion, effort) in [
            (drive.translation, ("Δa", 1e3, " mm"), ("T", 1.0, " N")),
            (drive.rotation, ("Ω", 180.0 / std::f64::consts::PI, "°"), ("Υ", 1e3, " N mm")),
        ] {
            let (sign, unit, printed) = if told.is_motion() { motion } else { effort };
            if !told.is_motion() || told.value().abs() > 0.0 {
                parts.push(format!("{sign}_{{{tube}}} = {}{printed}", number(told.value() * unit)));
            }
        }
    }
    parts.join(", ")
}

/// Centroid lines, the inner tubes first, so that the outer ones are drawn over them and show where they end; then the centreline.
fn lines(design: &BundleDesign, sections: &[BundleSection]) -> Vec<Line> {
    let size = sections.iter().fold(0.0, |m: f64, s| m.max(s.centre.amax()));
    let flat =
        |p: Vector3<f64>| -> [f64; 3] { p.map(|c| if c.abs() < FLAT * size { 0.0 } else { c }).into() };
    let tubes = (0..design.tubes.len()).rev().map(|tube| Line {
        part: Part::Tube(tube + 1),
        points: sections.iter().filter_map(|s| centroid(s, tube)).map(flat).collect(),
    });
    let centre = Line { part: Part::Centreline, points: sections.iter().map(|s| flat(s.centre)).collect() };
    // A tube that was drawn in behind the plate has no line.
    tubes.chain([centre]).filter(|line| line.points.len() > 1).collect()
}

/// Centroid of a tube at a section that it reaches.
fn centroid(section: &BundleSection, tube: usize) -> Option<Vector3<f64>> {
    let own = section.tubes.iter().find(|t| t.tube == tube)?;
    let (sin, cos) = own.angle.sin_cos();
    let towards = section.frame.column(1) * cos + section.frame.column(2) * sin;
    Some(section.centre + towards * own.centroid_offset)
}

/// The section that holds a label of a tube, where it stands before the plate.
fn section_at(pose: &[BundleSection], tube: usize, label: f64) -> Option<&BundleSection> {
    let off = |s: &BundleSection| s.tubes.iter().find(|t| t.tube == tube).map(|t| (t.label - label).abs());
    let near = pose.iter().filter_map(|s| Some((off(s)?, s))).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (near.0 < 1e-6 * label.abs()).then_some(near.1)
}

/// On the centroid line of every tube of every joint.
fn joints(design: &BundleDesign, pose: &[BundleSection]) -> Vec<[f64; 3]> {
    let places = design.joints.iter().flatten();
    places.filter_map(|&(tube, label)| Some(centroid(section_at(pose, tube, label)?, tube)?.into())).collect()
}

/// Concentrated forces where they act.
fn forces(found: &BundleEquilibrium, command: &BundleCommand, pose: &[BundleSection]) -> Vec<Force> {
    let wrenches = command.loads.wrenches.iter().filter_map(|wrench| match wrench.station {
        Station::Tip => Some(wrench_arrow(wrench, &found.tip, &found.frame)),
        Station::Label(label) => {
            Some(wrench_arrow(wrench, &section_at(pose, 0, label)?.centre, &Matrix3::identity()))
        }
    });
    let threads = command.loads.threads.iter().map(|thread| thread_arrow(thread, &found.tip, &found.frame));
    wrenches.chain(threads).flatten().collect()
}
