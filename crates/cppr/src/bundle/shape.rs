//! Shape of a bundle in equilibrium: its sections from the plate to the last tip.

use super::flow::Section;
use super::solve::{BundleEquilibrium, BundleSolver};
use super::vector::columns;
use super::walk::Walk;
use nalgebra::{Matrix3, Vector3};

/// One tube at a section.
#[derive(Clone, Copy, Debug)]
pub struct TubeSection {
    /// Tube (index from 0).
    pub tube: usize,
    /// Label of its section (m).
    pub label: f64,
    /// Label per length of the centreline, x'.
    pub advance: f64,
    /// Rotation of its material against the untwisted frame, about the tangent (rad).
    pub rotation: f64,
    /// Angle of its section axes against the untwisted frame, about the tangent (rad).
    pub angle: f64,
    /// Distance of its centroid from the centre, along its section axis Y (m).
    pub centroid_offset: f64,
    /// Tension T that its motor would hold here (N), and torque carried towards the tip (N m).
    pub tension: f64,
    /// Torque carried (N m).
    pub torque: f64,
    /// Curvatures about its section axes Y and Z per length of its centroid line (1/m), and its twist (rad/m), less those at rest.
    pub strains: [f64; 3],
    /// Stretch of its centroid line (-).
    pub stretch: f64,
}

/// A section of the bundle.
#[derive(Clone, Debug)]
pub struct BundleSection {
    /// Length of the centreline from the plate (m).
    pub length: f64,
    /// Centre (m).
    pub centre: Vector3<f64>,
    /// Untwisted frame: its first column is the tangent.
    pub frame: Matrix3<f64>,
    /// Tubes that are there, from outside to inside.
    pub tubes: Vec<TubeSection>,
}

impl BundleSection {
    /// A tube (index from 0) where it is at this section.
    #[must_use]
    pub fn tube(&self, tube: usize) -> Option<&TubeSection> {
        self.tubes.iter().find(|own| own.tube == tube)
    }

    /// The centroid of a tube at this section, from the centre (m).
    #[must_use]
    pub fn offset(&self, tube: &TubeSection) -> Vector3<f64> {
        let (sin, cos) = tube.angle.sin_cos();
        (self.frame.column(1) * cos + self.frame.column(2) * sin) * tube.centroid_offset
    }

    /// Centre (m) and tangent at a part of the way to the next section, by Hermite's cubic.
    #[must_use]
    pub fn towards(&self, next: &Self, share: f64) -> [Vector3<f64>; 2] {
        let (t, way) = (share, next.length - self.length);
        let [p, q] = [self, next].map(|s| Vector3::from(s.frame.column(0)) * way);
        let centre = self.centre * ((1.0 + 2.0 * t) * (1.0 - t).powi(2))
            + next.centre * (t * t * (3.0 - 2.0 * t))
            + p * (t * (1.0 - t).powi(2))
            - q * (t * t * (1.0 - t));
        [centre, (p * (1.0 - t) + q * t).try_normalize(0.0).unwrap_or_else(|| self.frame.column(0).into())]
    }
}

/// Steps per length at least, between whose ends states are interpolated.
const INTERVALS: f64 = 64.0;

impl BundleSolver<'_> {
    /// Sections of an equilibrium at most `spacing` (m) apart: at the plate, on both sides of every place where something changes,
    /// and at the last tip.
    #[must_use]
    pub fn shape(&self, equilibrium: &BundleEquilibrium, spacing: f64) -> Vec<BundleSection> {
        let mut sections = Vec::new();
        let mut see = |section: &Section<f64>| sections.push(read(section));
        self.with_walk(equilibrium, |walk, base| {
            let coarse = self.bundle.length / INTERVALS;
            let walk = Walk { posed: true, longest: spacing.max(coarse), spacing, ..walk };
            // The conditions were met before; what is left of them does not matter here.
            walk.run(base, &mut equilibrium.between.clone(), Some(&mut see)).is_ok()
        });
        sections
    }
}

fn read(section: &Section<f64>) -> BundleSection {
    let flow = section.flow;
    let (centre, turn) = flow.pose();
    let [wy, wz] = section.omega;
    let tubes = flow.present.iter().enumerate().map(|(place, &tube)| {
        let own = &flow.values[4 * place..4 * place + 4];
        let angle = flow.angle_of_section(place);
        let (sin, cos) = angle.sin_cos();
        let [offset, .., rest_y, rest_z] = flow.pieces[place].table_at(own[0]);
        let advance = section.rates[place][0];
        // g = x' h°: length of the centroid line per centreline length.
        let rest = 1.0 - offset * rest_z;
        let line = advance * rest;
        let across = wz * cos - wy * sin;
        TubeSection {
            tube,
            label: own[0],
            advance,
            rotation: own[2],
            angle,
            centroid_offset: offset,
            tension: own[1],
            torque: own[3],
            strains: [
                (wy * cos + wz * sin) / line - rest_y / rest,
                across / line - rest_z / rest,
                section.rates[place][1] / line,
            ],
            stretch: (1.0 - offset * across) / line - 1.0,
        }
    });
    BundleSection {
        length: flow.length(),
        centre: Vector3::from(centre),
        frame: Matrix3::from_columns(&columns(turn).map(Vector3::from)),
        tubes: tubes.collect(),
    }
}
