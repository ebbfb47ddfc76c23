//! The cut pattern of a round tube, unrolled at its outer surface.
//!
//! u is the rest abscissa x and v = −ρ̄ (θ − θ₀), ρ̄ being the outer radius, θ the angle about the axis and θ₀ the direction
//! to which the first pattern opens at its base: the pattern as seen from outside, base on the left. A notch, the part
//! Y ≤ α of the section, reaches over |θ − φ − π| ≤ acos(−α/ρ̄) on the outer surface, so that its opening is a
//! rectangle where depth and direction are constant, and has curved or slanted sides where they are not.
//!
//! The edge of the beam, not its middle, makes the edge of the notch: the path runs half a kerf inside the opening.

use crate::error::MeshError;
use crate::options::{Detail, TubeOptions};
use crate::part::FileError;
use crate::stretch::Tubes;
use crate::tube::{Notch, TubeBody};
use cavalier_contours::polyline::{PlineSource, PlineSourceMut, Polyline};
use dxf::Drawing;
use dxf::entities::{Entity, EntityType, LwPolyline};
use dxf::enums::{AcadVersion, Units};
use dxf::tables::Layer;
use std::f64::consts::{PI, TAU};

/// Layers of the drawing.
pub const CUT_LAYER: &str = "CUT";
/// Layer of the unrolled tube, which is not to be cut.
pub const OUTLINE_LAYER: &str = "OUTLINE";

/// What to unroll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnrolledOptions {
    /// Largest distance between a curve and its chords (m).
    pub tolerance: f64,
    /// Width that the tool takes away (m).
    pub kerf: f64,
    /// Length of the tube below the baseplate (m).
    pub below: f64,
}

/// Paths on the unrolled outer surface, [u, v] in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Unrolled {
    /// Lower left and upper right corner of the whole surface.
    pub outline: [[f64; 2]; 2],
    /// One closed path per notch, anticlockwise, without the first point again at the end. A notch that crosses the seam
    /// of the outline goes on beyond it.
    pub openings: Vec<Vec<[f64; 2]>>,
    /// Area (m²) of the section that the first notch leaves: that of the design, which a straight cut across makes, and
    /// that of a beam which always points at the axis.
    pub kept_area: Option<[f64; 2]>,
}

/// Unrolls tube `tube` (from 0).
///
/// # Errors
/// [`MeshError`]: as for the body of the tube; it is not round; a notch is narrower than the kerf.
pub fn unrolled(robot: &dyn Tubes, tube: usize, options: &UnrolledOptions) -> Result<Unrolled, MeshError> {
    let UnrolledOptions { tolerance, kerf, below } = *options;
    let body = TubeBody::new(
        robot,
        tube,
        &TubeOptions { below, ..TubeOptions::plain(Detail::workshop(tolerance)) },
    )?;
    if body.outer().sides.is_some() {
        return Err(MeshError::NotRound { tube: tube + 1 });
    }
    let radius = body.outer().inradius;
    if !(0.0..=MeshError::LARGEST).contains(&kerf) {
        return Err(MeshError::Length { quantity: "the kerf", value: kerf });
    }
    let mut openings = Vec::new();
    let first = body.notches.first().map(|notch| (&body.stretches[notch.stretch], notch.span[0]));
    let start = first.map_or(0.0, |(own, _)| own.direction(own.from));
    for (index, &Notch { stretch, span }) in body.notches.iter().enumerate() {
        let own = &body.stretches[stretch];
        let centre = |x: f64| -radius * (own.direction(x) - start);
        let turns = (centre(0.5 * (span[0] + span[1])) / (radius * TAU)).round() * radius * TAU;
        let abscissae: Vec<f64> =
            [span[0]].into_iter().chain(body.inside(own, span)).chain([span[1]]).collect();
        let side = |x: f64, sign: f64| [x, centre(x) - turns + sign * radius * (PI - body.cut(own, x).outer)];
        let path: Vec<[f64; 2]> = abscissae
            .iter()
            .map(|&x| side(x, -1.0))
            .chain(abscissae.iter().rev().map(|&x| side(x, 1.0)))
            .collect();
        openings.push(narrowed(path, kerf).ok_or(MeshError::Kerf { notch: index + 1, kerf })?);
    }
    let kept_area = first.map(|(own, x)| {
        let bore = body.bore().inradius;
        [own.area(x), (radius * radius - bore * bore) * body.cut(own, x).outer]
    });
    Ok(Unrolled { outline: [[0.0 - below, -PI * radius], [body.length, PI * radius]], openings, kept_area })
}

/// The path half a kerf inside; none where nothing or more than one piece is left.
fn narrowed(path: Vec<[f64; 2]>, kerf: f64) -> Option<Vec<[f64; 2]>> {
    if kerf <= 0.0 {
        return Some(path);
    }
    // In mm: the library's tolerances are absolute.
    let mut line: Polyline<f64> = Polyline::new_closed();
    for [u, v] in &path {
        line.add(u * 1e3, v * 1e3, 0.0);
    }
    match &line.parallel_offset(0.5e3 * kerf)[..] {
        // A path narrower than the kerf may come out again on its other side.
        [inside] if inside.area() > 0.0 => {
            Some(inside.iter_vertexes().map(|v| [v.x * 1e-3, v.y * 1e-3]).collect())
        }
        _ => None,
    }
}

/// DXF (release 2000) in mm, with a closed polyline per notch on [`CUT_LAYER`] and the tube on [`OUTLINE_LAYER`].
///
/// # Errors
/// [`FileError`] from the library that writes it.
pub fn dxf(pattern: &Unrolled) -> Result<Vec<u8>, FileError> {
    let mut drawing = Drawing::new();
    drawing.header.version = AcadVersion::R2000;
    drawing.header.default_drawing_units = Units::Millimeters;
    drawing.normalize();
    for (name, colour) in [(CUT_LAYER, 1), (OUTLINE_LAYER, 7)] {
        drawing.add_layer(Layer {
            name: name.into(),
            color: dxf::Color::from_index(colour),
            ..Layer::default()
        });
    }
    let [[left, bottom], [right, top]] = pattern.outline;
    let outline = [[left, bottom], [right, bottom], [right, top], [left, top]];
    for (layer, path) in [(OUTLINE_LAYER, &outline[..])]
        .into_iter()
        .chain(pattern.openings.iter().map(|path| (CUT_LAYER, &path[..])))
    {
        let mut line = LwPolyline {
            vertices: path
                .iter()
                .map(|[u, v]| dxf::LwPolylineVertex {
                    x: u * 1e3,
                    y: v * 1e3,
                    ..dxf::LwPolylineVertex::default()
                })
                .collect(),
            ..LwPolyline::default()
        };
        line.set_is_closed(true);
        let mut entity = Entity::new(EntityType::LwPolyline(line));
        entity.common.layer = layer.into();
        drawing.add_entity(entity);
    }
    let mut bytes = Vec::new();
    drawing.save(&mut bytes).map_err(|e| FileError { format: "DXF", source: e.into() })?;
    Ok(bytes)
}
