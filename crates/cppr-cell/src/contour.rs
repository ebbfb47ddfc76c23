//! One contour of a tube, a circle or a regular polygon, by polar angle θ from +Y towards +Z.
//!
//! Frame as in `cppr::design::section`: origin at the tube's centre, Y away from the notch. A polygon has one flat normal to Y
//! on the side of the notch (−Y). Only the half Z ≥ 0, 0 ≤ θ ≤ π, is spoken of; there Y never grows with θ.

use std::f64::consts::PI;

/// A circle of this radius, or a polygon of this apothem.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contour {
    pub sides: Option<u32>,
    pub inradius: f64,
}

impl Contour {
    /// Distance from the centre at an angle.
    fn radius(&self, angle: f64) -> f64 {
        self.sides.map_or(self.inradius, |n| {
            let half = PI / f64::from(n);
            let off = (PI - angle + half).rem_euclid(2.0 * half) - half;
            self.inradius / off.cos()
        })
    }

    /// The point (Y, Z) at an angle.
    pub fn point(&self, angle: f64) -> [f64; 2] {
        let radius = self.radius(angle);
        [radius * angle.cos(), radius * angle.sin()]
    }

    /// Angles of the corners with 0 < θ < π, rising.
    pub fn corners(&self) -> Vec<f64> {
        let n = self.sides.unwrap_or(0);
        (0..n / 2).rev().map(|k| PI - PI * f64::from(2 * k + 1) / f64::from(n)).collect()
    }

    /// Greatest Y.
    pub fn top(&self) -> f64 {
        self.radius(0.0)
    }

    /// The angle at which the contour passes the level Y; 0 above it and π below it. A flat at that level counts as passed at
    /// the corner where the contour leaves it towards the side.
    pub fn angle_at(&self, level: f64) -> f64 {
        if level >= self.top() && self.sides.is_none_or(|n| n % 2 == 1) {
            return 0.0;
        }
        if level > self.top() * (1.0 + 1e-12) {
            return 0.0;
        }
        if self.sides.is_none() {
            return (level / self.inradius).max(-1.0).acos();
        }
        let mut from = [self.top(), 0.0];
        for angle in self.corners() {
            let to = self.point(angle);
            let drop = from[0] - to[0];
            if drop > 1e-12 * self.inradius && to[0] <= level + 1e-12 * self.inradius {
                let share = ((from[0] - level) / drop).clamp(0.0, 1.0);
                return (from[1] + share * (to[1] - from[1])).atan2(level);
            }
            from = to;
        }
        PI
    }
}

#[cfg(test)]
mod tests {
    use super::Contour;
    use std::f64::consts::PI;

    #[test]
    fn levels_and_angles_belong_together() {
        for sides in [None, Some(3), Some(4), Some(6), Some(9)] {
            let contour = Contour { sides, inradius: 1.3 };
            for i in 1..40 {
                let level = -1.3 + (contour.top() + 1.3) * f64::from(i) / 40.0;
                assert!(
                    (contour.point(contour.angle_at(level))[0] - level).abs() < 1e-12,
                    "{sides:?} {level}"
                );
            }
            assert!(contour.angle_at(contour.top() + 0.1).abs() < 1e-15);
            assert!((contour.angle_at(-2.0) - PI).abs() < 1e-15);
        }
        let square = Contour { sides: Some(4), inradius: 2.0 };
        assert!((square.angle_at(2.0) - PI / 4.0).abs() < 1e-15);
        assert!((square.angle_at(-2.0) - 3.0 * PI / 4.0).abs() < 1e-15);
    }
}
