//! Contour of an uncut section in polar form, in the frame of [`cppr::design::section`]: Y along the centroid
//! direction, angles from +Y towards +Z, one flat of a polygon normal to Y on the side of −Y.

use std::f64::consts::{PI, TAU};

/// A circle or a regular polygon about the tube's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contour {
    /// Number of sides; none for a circle.
    pub sides: Option<usize>,
    /// Radius or apothem (m); zero where a rod is solid.
    pub inradius: f64,
}

impl Contour {
    /// Angle between neighbouring flats.
    fn pitch(sides: usize) -> f64 {
        TAU / sides as f64
    }

    /// Point at an angle of at most π (m).
    pub fn point(&self, angle: f64) -> [f64; 2] {
        let reach = self.sides.map_or(self.inradius, |n| {
            let off = (angle - PI).rem_euclid(Self::pitch(n));
            self.inradius / off.min(Self::pitch(n) - off).cos()
        });
        if angle.abs() >= PI {
            // One point for both ends of the turn.
            return [-reach, 0.0];
        }
        [reach * angle.cos(), reach * angle.sin()]
    }

    /// Angles of the vertices in (−π, π].
    pub fn vertices(&self) -> Vec<f64> {
        let count = self.sides.unwrap_or(0);
        (0..count).map(|k| (2 * k + 1) as f64 * PI / count as f64 - PI).collect()
    }

    /// Largest Y (m): a flat for an even number of sides, a vertex for an odd one.
    pub fn top(&self) -> f64 {
        self.point(0.0)[0]
    }

    /// Largest distance from the centre (m).
    pub fn reach(&self) -> f64 {
        self.sides.map_or(self.inradius, |n| self.inradius / (0.5 * Self::pitch(n)).cos())
    }

    /// Enclosed area (m²).
    pub fn area(&self) -> f64 {
        let r2 = self.inradius * self.inradius;
        self.sides.map_or(PI * r2, |n| n as f64 * r2 * (0.5 * Self::pitch(n)).tan())
    }

    /// Angle of the point with Z ≥ 0 at which the line Y = `y` leaves the contour: π below it, 0 above it.
    pub fn angle(&self, y: f64) -> f64 {
        if y <= -self.inradius {
            return PI;
        }
        if y > self.top() {
            return 0.0;
        }
        let half_width = match self.sides {
            None => ((self.inradius - y) * (self.inradius + y)).max(0.0).sqrt(),
            Some(n) => (1..=n / 2)
                .map(|k| PI - Self::pitch(n) * k as f64)
                .filter(|normal| normal.sin() > 1e-9)
                .map(|normal| (self.inradius - y * normal.cos()) / normal.sin())
                .fold(f64::INFINITY, f64::min),
        };
        half_width.atan2(y)
    }
}
