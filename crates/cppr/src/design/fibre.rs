//! Extreme fibres and walls of a notched section.
//!
//! A plane strain field Y ↦ e + a Y + b Z is greatest at the edge of what it acts on: on the outer contour or at the
//! corners where the cut Y = α meets it. The kept part Y ≥ α carries the strain; the part Y ≤ α, whose
//! contour the teeth keep, bounds the gap. Frame and units as in `section`.

use super::section::above;
use super::{NotchedTube, Outline};
use crate::real::Real;

/// A section as it is cut: its centroid, and where plane strain fields are extreme.
#[derive(Clone, Debug)]
pub(crate) struct Fibres {
    /// Depth of the notch (m).
    pub depth: f64,
    /// Distance D of the centroid from the centre (m).
    pub offset: f64,
    extremes: Extremes,
}

#[derive(Clone, Debug)]
enum Extremes {
    /// On a disk cut at Y = α.
    Disk { radius: f64, alpha: f64 },
    /// At corners (Y, Z) with Z ≥ 0 of the kept part and of what is cut away.
    Corners { kept: Vec<[f64; 2]>, removed: Vec<[f64; 2]> },
}

/// The sections of one tube at its notches.
#[derive(Clone, Debug)]
pub(crate) struct TubeFibres {
    /// Of the uncut tube.
    pub plain: Option<Fibres>,
    /// At the baseplate, and of notches below it.
    pub base: Option<Fibres>,
    /// Of the notches of a known pattern, from the baseplate on.
    pub notches: Vec<Option<Fibres>>,
}

impl TubeFibres {
    pub fn of(tube: &NotchedTube, length: f64) -> Self {
        let at = |x: f64| tube.outline.fibres(tube.depth.eval(x, length)[0]);
        let middles = tube.pattern.map(|pattern| pattern.middles()).unwrap_or_default();
        Self {
            plain: tube.outline.fibres(0.0),
            base: at(0.0),
            notches: middles.into_iter().map(at).collect(),
        }
    }
}

impl Fibres {
    /// Greatest a Y + b Z over the kept part.
    pub fn greatest_kept<S: Real>(&self, [a, b]: [S; 2]) -> S {
        match &self.extremes {
            Extremes::Disk { radius, alpha } => greatest_on_disk(*radius, *alpha, [a, b]),
            Extremes::Corners { kept, .. } => greatest(kept, [a, b]),
        }
    }

    /// Greatest a Y + b Z over what the notch takes away.
    pub fn greatest_removed<S: Real>(&self, [a, b]: [S; 2]) -> S {
        match &self.extremes {
            Extremes::Disk { radius, alpha } => greatest_on_disk(*radius, -alpha, [-a, b]),
            Extremes::Corners { removed, .. } => greatest(removed, [a, b]),
        }
    }
}

impl Outline {
    /// The section notched by `depth` (m); none where nothing would be left.
    pub(crate) fn fibres(&self, depth: f64) -> Option<Fibres> {
        let offset = self.inertia(depth).ok()?.centroid_offset;
        let (outer, alpha) = (self.contours().0, self.cut(depth));
        let extremes = if outer.sides.is_none() {
            Extremes::Disk { radius: outer.inradius, alpha }
        } else {
            let kept = above(&outer, alpha);
            let mut removed = vec![[-outer.inradius, 0.0]];
            removed.extend(outer.vertices().into_iter().filter(|[y, _]| *y <= alpha));
            removed.extend(kept.last());
            Extremes::Corners { kept, removed }
        };
        Some(Fibres { depth, offset, extremes })
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
fn greatest<S: Real>(corners: &[[f64; 2]], [a, b]: [S; 2]) -> S {
    S::from_lanes(|l| {
        let (a, b) = (a.lane(l), b.lane(l).abs());
        corners.iter().map(|[y, z]| a * y + b * z).fold(f64::NEG_INFINITY, f64::max)
    })
}

/// Over the part Y ≥ α of a disk.
fn greatest_on_disk<S: Real>(radius: f64, alpha: f64, [a, b]: [S; 2]) -> S {
    let size = (a * a + b * b).map(f64::sqrt);
    let end = alpha.max(-radius);
    let half_chord = ((radius - end) * (radius + end)).max(0.0).sqrt();
    S::from_lanes(|l| {
        let (a, b, size) = (a.lane(l), b.lane(l), size.lane(l));
        if radius * a >= alpha * size { radius * size } else { a * end + b.abs() * half_chord }
    })
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
                    let fibres = outline.fibres(depth).unwrap();
                    for (got, want) in
                        [(fibres.greatest_kept([a, b]), kept), (fibres.greatest_removed([a, b]), removed)]
                    {
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
