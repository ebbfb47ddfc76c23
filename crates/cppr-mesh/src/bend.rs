//! Bodies of tubes in a solved robot: every section of the tube at rest goes, unchanged, to where the equilibrium has it.
//!
//! The face-to-face map X → x_k(X) of a follower is inverted, so that its notches and teeth stand at their own rest
//! abscissae x: p = c(X) + F (0, y, z)ᵀ with x = x_k(X), F the frame of the tube's material (see the crate's page).
//! Below the plate and beyond the tip a tube goes straight on.

use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::options::{Detail, TubeOptions};
use crate::tube::tube_mesh;
use cppr::analysis::{Section, Shape};
use cppr::solve::{Equilibrium, Solver};
use cppr::{Matrix3, Vector3};
use cppr_io::RobotFile;

/// Labels at which the map is sampled; between them it is a cubic with the right slopes.
const SAMPLES: usize = 801;
/// Largest angle of a chord about the axis (rad).
pub(crate) const TURN: f64 = 0.2;
/// Fewest sections between plate and tip.
pub(crate) const FEWEST: f64 = 60.0;

/// Every tube of a solved robot in the base frame (m), the leader first. Facets lie within `tolerance` (m) of the
/// surface; `below` (m) is how much of each follower is below the plate at rest, more if it is pushed farther.
///
/// # Errors
/// [`MeshError`]: a tube has no geometry, or tolerance or length make no sense.
pub fn bent_tubes(
    file: &RobotFile,
    solver: &mut Solver,
    found: &Equilibrium,
    tolerance: f64,
    below: f64,
) -> Result<Vec<Mesh>, MeshError> {
    if !(0.0..=MeshError::LARGEST).contains(&below) {
        return Err(MeshError::Length { quantity: "the length below the plate", value: below });
    }
    let (robot, shape) = (found.robot(), solver.shape(found, SAMPLES));
    (0..robot.tube_count())
        .map(|tube| {
            let reach = file.tubes.get(tube).and_then(|t| t.outer_radius).unwrap_or_default();
            let step = (8.0 * tolerance / sharpest(&shape, tube, reach)).sqrt().min(robot.length() / FEWEST);
            let pushed = shape.sections.first().map_or(0.0, |s| -s.tubes[tube].abscissa);
            let options = TubeOptions {
                // The leader ends at the plate, in which it is clamped.
                below: if tube == 0 { 0.0 } else { below.max(pushed) },
                ..TubeOptions::plain(Detail { chord: tolerance, turn: TURN, step })
            };
            let mut mesh = tube_mesh(file, tube, &options)?;
            bend_along(&mut mesh, solver, found, &shape, tube);
            Ok(mesh)
        })
        .collect()
}

/// Largest curvature of a line along a tube (1/m): that of the axis, and that of the helix at `reach` (m) from it.
fn sharpest(shape: &Shape, tube: usize, reach: f64) -> f64 {
    let curvature = |s: &Section| {
        let strain = s.tubes[tube].strain;
        strain.y.hypot(strain.z) + reach * strain.x * strain.x
    };
    shape.sections.iter().map(curvature).fold(0.0, f64::max)
}

/// Where a section of a tube is.
pub(crate) struct BentSection {
    pub centre: Vector3<f64>,
    pub frame: Matrix3<f64>,
}

/// Moves the vertices of tube `tube` (from 0) from their places at rest, as [`tube_mesh`] gives them, to those in a
/// solved robot. Facets are as straight as the mesh is fine along the axis ([`Detail::step`]).
pub fn bend(mesh: &mut Mesh, solver: &mut Solver, found: &Equilibrium, tube: usize) {
    let shape = solver.shape(found, SAMPLES);
    bend_along(mesh, solver, found, &shape, tube);
}

fn bend_along(mesh: &mut Mesh, solver: &mut Solver, found: &Equilibrium, shape: &Shape, tube: usize) {
    let robot = found.robot();
    let abscissae = abscissae(mesh);
    let labels: Vec<f64> = abscissae.iter().map(|&x| label(shape, tube, x)).collect();
    let sections = solver.shape_at(found, &labels).sections;
    let places: Vec<BentSection> = sections
        .iter()
        .zip(&abscissae)
        .map(|(section, &x)| {
            let at = &section.tubes[tube];
            let (sin, cos) = robot.fields_at(tube, at.abscissa).direction.sin_cos();
            let back = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, sin, 0.0, -sin, cos);
            let frame = at.rotation * back;
            // Below the plate and beyond the tip. In between, what is left is the error of the inverted map.
            let at_end = section.label <= 0.0 || section.label >= robot.length();
            let straight = if at_end { x - at.abscissa } else { 0.0 };
            BentSection { centre: section.centre + frame.column(0) * straight, frame }
        })
        .collect();
    place(mesh, &abscissae, &places);
}

/// Abscissae of the sections of a mesh at rest, in order (m).
pub(crate) fn abscissae(mesh: &Mesh) -> Vec<f64> {
    let mut abscissae: Vec<f64> = mesh.positions.iter().map(|p| p[0]).collect();
    abscissae.sort_by(f64::total_cmp);
    abscissae.dedup_by(|a, b| a.total_cmp(b).is_eq());
    abscissae
}

/// Moves the sections of a mesh at rest, one at each of its abscissae, to their places.
pub(crate) fn place(mesh: &mut Mesh, abscissae: &[f64], places: &[BentSection]) {
    for position in &mut mesh.positions {
        let found = abscissae.binary_search_by(|x| x.total_cmp(&position[0]));
        let place = &places[found.unwrap_or_else(|next| next.min(places.len() - 1))];
        let [_, y, z] = *position;
        *position = (place.centre + place.frame * Vector3::new(0.0, y, z)).into();
    }
}

/// The leader's label X that faces abscissa x of a tube, that of an end where none does.
fn label(shape: &Shape, tube: usize, x: f64) -> f64 {
    let sections = &shape.sections;
    let next = sections.partition_point(|s| s.tubes[tube].abscissa <= x);
    let (Some(a), Some(b)) = (next.checked_sub(1).and_then(|i| sections.get(i)), sections.get(next)) else {
        return if next == 0 { sections[0].label } else { sections[sections.len() - 1].label };
    };
    // Hermite's cubic for X(x), with slopes 1/|h|.
    let [(xa, ha), (xb, hb)] = [a, b].map(|s| (s.tubes[tube].abscissa, s.tubes[tube].rate));
    let (step, t) = (xb - xa, (x - xa) / (xb - xa));
    let value = a.label * (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t) + b.label * t * t * (3.0 - 2.0 * t);
    let slope = step * t * (1.0 - t) * ((1.0 - t) / ha - t / hb);
    (value + slope).clamp(a.label, b.label)
}
