//! Bodies of tubes in a solved bundle: the sections of a tube, by the labels on its own axis, go where the equilibrium has them.
//!
//! Between the sections of the shape the centre is a cubic with the right tangents, dc/dx = t / x', and the frame
//! turns about one axis. Before the plate and beyond its last section a tube goes straight on.

use crate::bend::{BentSection, FEWEST, TURN, abscissae, place};
use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::options::{Detail, TubeOptions};
use crate::tube::tube_mesh;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver, TubeEffort};
use cppr::bundle::{BundleDesign, BundleSection};
use cppr::design::TubeDesign;
use cppr::{Matrix3, Vector3};
use nalgebra::{Rotation3, UnitQuaternion};

/// Sections of the shape along the bundle, about.
const SAMPLES: f64 = 800.0;

/// Sections nearer to each other (m) are the two sides of one place.
const ONE_PLACE: f64 = 1e-9;

/// Every tube of a solved bundle in the base frame (m), the outermost first. Facets lie within `tolerance` (m) of the
/// surface; `below` (m) is how much of every tube but the outermost is below the plate at rest, more of any tube that is pushed farther.
///
/// # Errors
/// [`MeshError`]: a tube has no geometry, or tolerance or length make no sense.
pub fn bent_bundle(
    design: &BundleDesign,
    solver: &BundleSolver,
    found: &BundleEquilibrium,
    tolerance: f64,
    below: f64,
) -> Result<Vec<Mesh>, MeshError> {
    if !(0.0..=MeshError::LARGEST).contains(&below) {
        return Err(MeshError::Length { quantity: "the length below the plate", value: below });
    }
    let shape = solver.shape(found, found.length / SAMPLES);
    let tubes = found.efforts.iter().enumerate();
    tubes
        .map(|(tube, at)| {
            let course = Course::new(&shape, tube, at);
            let reach = design.tubes[tube].parts.first().map_or(0.0, |part| match &part.body {
                TubeDesign::Notched(own) => own.outline.outer_reach(),
                TubeDesign::Stiffness(_) => 0.0,
            });
            let step = (8.0 * tolerance / course.sharpest(reach)).sqrt().min(found.length / FEWEST);
            let options = TubeOptions {
                // The outermost tube ends at the plate, unless it is pushed.
                below: if tube == 0 { 0.0 } else { below }.max(-at.label),
                ..TubeOptions::plain(Detail { chord: tolerance, turn: TURN, step })
            };
            let mut mesh = tube_mesh(design, tube, &options)?;
            let abscissae = abscissae(&mesh);
            let places: Vec<BentSection> = abscissae.iter().map(|&x| course.at(x)).collect();
            place(&mut mesh, &abscissae, &places);
            Ok(mesh)
        })
        .collect()
}

/// A section of one tube.
struct Place {
    /// Its label (m).
    x: f64,
    centre: Vector3<f64>,
    /// dc/dx.
    slope: Vector3<f64>,
    /// Frame of the tube's material.
    frame: UnitQuaternion<f64>,
}

/// Sections of one tube from the plate on.
struct Course(Vec<Place>);

impl Course {
    fn new(shape: &[BundleSection], tube: usize, at: &TubeEffort) -> Self {
        let about = |angle| Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
        let places = shape.iter().filter_map(|section| {
            let own = section.tubes.iter().find(|own| own.tube == tube)?;
            let material = section.frame * about(own.rotation).matrix();
            Some(Place {
                x: own.label,
                centre: section.centre,
                slope: section.frame.column(0) / own.advance,
                frame: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(material)),
            })
        });
        let mut places: Vec<Place> = places.collect();
        if places.is_empty() {
            // Drawn in behind the plate.
            places.push(Place {
                x: at.label,
                centre: Vector3::zeros(),
                slope: Vector3::x(),
                frame: UnitQuaternion::from_rotation_matrix(&about(at.rotation)),
            });
        }
        Self(places)
    }

    /// Largest curvature of a line along the tube (1/m): that of the axis, and that of the helix at `reach` (m) from it.
    fn sharpest(&self, reach: f64) -> f64 {
        let curvature = |pair: &[Place]| {
            let step = pair[1].x - pair[0].x;
            let turn = pair[0].frame.rotation_to(&pair[1].frame).scaled_axis();
            let along = pair[0].frame.inverse() * turn;
            if step > ONE_PLACE {
                along.y.hypot(along.z) / step + reach * (along.x / step).powi(2)
            } else {
                0.0
            }
        };
        self.0.windows(2).map(curvature).fold(f64::MIN_POSITIVE, f64::max)
    }

    fn at(&self, x: f64) -> BentSection {
        let places = &self.0;
        let next = places.partition_point(|place| place.x <= x);
        let (Some(a), Some(b)) = (next.checked_sub(1).and_then(|i| places.get(i)), places.get(next)) else {
            let end = if next == 0 { &places[0] } else { &places[places.len() - 1] };
            let frame: Matrix3<f64> = end.frame.to_rotation_matrix().into_inner();
            return BentSection { centre: end.centre + frame.column(0) * (x - end.x), frame };
        };
        let step = b.x - a.x;
        let t = (x - a.x) / step;
        let centre = a.centre * ((1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t))
            + b.centre * (t * t * (3.0 - 2.0 * t))
            + (a.slope * (1.0 - t) - b.slope * t) * (step * t * (1.0 - t));
        let frame = a.frame.try_slerp(&b.frame, t, 0.0).unwrap_or(a.frame);
        BentSection { centre, frame: frame.to_rotation_matrix().into_inner() }
    }
}
