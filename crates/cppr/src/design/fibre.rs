//! Extreme fibres and walls of a notched section.
//!
//! A plane strain field Y ↦ e + a Y + b Z is greatest at the edge of what it acts on: on the outer contour or at the
//! corners where the cut Y = α meets it. The kept part Y ≥ α carries the strain; the part Y ≤ α, whose
//! contour the teeth keep, bounds the gap. Frame and units as in `section`.

use super::Outline;
use super::section::above;

impl Outline {
    /// Greatest a Y + b Z over the kept part of a section notched by `depth` (m).
    pub(crate) fn greatest_kept(&self, depth: f64, [a, b]: [f64; 2]) -> f64 {
        let (outer, alpha) = (self.contours().0, self.cut(depth));
        if outer.sides.is_none() {
            return greatest_on_disk(outer.inradius, alpha, [a, b]);
        }
        greatest(&above(&outer, alpha), [a, b])
    }

    /// Greatest a Y + b Z over what the notch takes away.
    pub(crate) fn greatest_removed(&self, depth: f64, [a, b]: [f64; 2]) -> f64 {
        let (outer, alpha) = (self.contours().0, self.cut(depth));
        if outer.sides.is_none() {
            return greatest_on_disk(outer.inradius, -alpha, [-a, b]);
        }
        let mut corners = vec![[-outer.inradius, 0.0]];
        corners.extend(outer.vertices().into_iter().filter(|[y, _]| *y <= alpha));
        corners.extend(above(&outer, alpha).last());
        greatest(&corners, [a, b])
    }

    /// Thinnest wall of a section notched by `depth` (m): the skin under a notch that stops before the bore, the wall of the
    /// ring, or the height of what is left beyond the bore.
    #[must_use]
    pub fn thinnest_wall(&self, depth: f64) -> f64 {
        let (outer, inner) = self.contours();
        let wall = outer.inradius - inner.inradius;
        if depth > 0.0 && depth < self.opening_depth() {
            wall.min(self.opening_depth() - depth)
        } else {
            wall.min(self.kept_height(depth))
        }
    }

    /// Height of the kept part across the notch (m).
    #[must_use]
    pub fn kept_height(&self, depth: f64) -> f64 {
        self.contours().0.top() - self.cut(depth)
    }
}

/// Over the half Z ≥ 0 and its mirror image.
fn greatest(corners: &[[f64; 2]], [a, b]: [f64; 2]) -> f64 {
    corners.iter().map(|[y, z]| a * y + b.abs() * z).fold(f64::NEG_INFINITY, f64::max)
}

/// Over the part Y ≥ α of a disk.
fn greatest_on_disk(radius: f64, alpha: f64, [a, b]: [f64; 2]) -> f64 {
    let size = a.hypot(b);
    if radius * a >= alpha * size {
        radius * size
    } else {
        let alpha = alpha.max(-radius);
        a * alpha + b.abs() * ((radius - alpha) * (radius + alpha)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use crate::design::Outline;

    /// Against the greatest of many points of the contour.
    #[test]
    fn extremes_agree_with_points_all_around() {
        let round = Outline::Round { outer_radius: 3.0, inner_radius: 2.0 };
        let square = Outline::Polygon { sides: 4, outer_apothem: 3.0, inner_apothem: 2.0 };
        let pentagon = Outline::Polygon { sides: 5, outer_apothem: 3.0, inner_apothem: 2.0 };
        for outline in [round, square, pentagon] {
            let outer = outline.contours().0;
            for depth in [0.5, 2.0, 3.0, 5.0, 5.9] {
                let alpha = outline.cut(depth);
                for direction in 0..24 {
                    let (b, a) = (f64::from(direction) * 0.27).sin_cos();
                    let (mut kept, mut removed) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
                    for i in 0..200_000 {
                        let angle = std::f64::consts::TAU * f64::from(i) / 200_000.0;
                        // One flat is normal to Y on the side of −Y.
                        let radius = outer.sides.map_or(outer.inradius, |n| {
                            let sector = std::f64::consts::TAU / n as f64;
                            let off = (angle + std::f64::consts::PI + 0.5 * sector).rem_euclid(sector);
                            outer.inradius / (off - 0.5 * sector).cos()
                        });
                        let (y, z) = (radius * angle.cos(), radius * angle.sin());
                        let value = a * y + b * z;
                        let side = if y >= alpha { &mut kept } else { &mut removed };
                        *side = side.max(value);
                    }
                    for (got, want) in [
                        (outline.greatest_kept(depth, [a, b]), kept),
                        (outline.greatest_removed(depth, [a, b]), removed),
                    ] {
                        assert!((got - want).abs() < 3e-3, "{outline:?} {depth} {a} {b}: {got} {want}");
                    }
                }
            }
        }
    }

    #[test]
    fn walls_of_all_depths() {
        let ring = Outline::Round { outer_radius: 3.0, inner_radius: 2.0 };
        for (depth, wall, height) in
            [(0.0, 1.0, 6.0), (0.75, 0.25, 5.25), (2.0, 1.0, 4.0), (5.0, 1.0, 1.0), (5.5, 0.5, 0.5)]
        {
            assert!((ring.thinnest_wall(depth) - wall).abs() < 1e-15, "{depth}");
            assert!((ring.kept_height(depth) - height).abs() < 1e-15, "{depth}");
        }
    }
}
