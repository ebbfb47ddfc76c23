//! Extreme fibres and walls of a notched section.
//!
//! A plane strain field Y ↦ e + a Y + b Z is greatest at the edge of what it acts on: on the outer contour or at the
//! corners where the cut Y = α meets it. The kept part Y ≥ α carries the strain; the part Y ≤ α, whose
//! contour the teeth keep, bounds the gap. Frame and units as in `section`.
//!
//! Twist at the rate τ shears a section by r τ at most. With the wall t = ρ̄ − ρ, A its area, of the greatest circle inside it the
//! diameter d, and concentration at inner corners and at the roots of the notches left out:
//!
//! | section | r |
//! |---|---|
//! | whole tube | ρ̄ |
//! | skin of least thickness s left under the notch | 2 A_m / (s ∮ du/t), thin-walled (Bredt), A_m within the middle line of length u |
//! | open round ring | (ρ̄² − ρ²)/(2 ρ ln(ρ̄/ρ)) − ρ, at the bore: exact for a slit tube |
//! | open polygonal ring | t |
//! | no bore left | d (1 + 0.15 k)/(1 + k), k = π² d⁴/(16 A²) (Roark's formula for solid sections, at a flat) |

use super::section::above;
use super::{NotchedTube, Outline, PeakStrain};
use crate::real::Real;
use std::f64::consts::PI;

/// Arcs of a quarter ring on which the thickness of a skin counts as constant.
const ARCS: u32 = 256;

/// A section as it is cut: its centroid, and where plane strain fields are extreme.
#[derive(Clone, Debug)]
pub(crate) struct Fibres {
    /// Depth of the notch (m).
    pub depth: f64,
    /// Distance D of the centroid from the centre (m).
    pub offset: f64,
    /// Greatest shear strain by torsion per rate of twist (m).
    pub shear_arm: f64,
    /// Where the corners of the notch have a radius: the strain there.
    pub peak: Option<PeakStrain>,
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
        let at = |x: f64| {
            let depth = tube.depth.eval(x, length)[0];
            let peak = tube.cell_factors(depth).ok().flatten().and_then(|factors| factors.peak);
            tube.outline.fibres(depth).map(|fibres| Fibres { peak, ..fibres })
        };
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
        let inertia = self.inertia(depth).ok()?;
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
        let shear_arm = self.shear_arm(depth, inertia.area);
        Some(Fibres { depth, offset: inertia.centroid_offset, shear_arm, peak: None, extremes })
    }

    fn shear_arm(&self, depth: f64, area: f64) -> f64 {
        let (outer, inner) = self.contours();
        let (far, near) = (outer.inradius, inner.inradius);
        let wall = far - near;
        let solid = |diameter: f64, area: f64| {
            let k = (PI * diameter * diameter / (4.0 * area)).powi(2);
            diameter * (1.0 + 0.15 * k) / (1.0 + k)
        };
        if near <= 0.0 || depth >= self.passing_depth() {
            if outer.sides.is_none() && depth <= 0.0 { far } else { solid(self.kept_height(depth), area) }
        } else if depth <= 0.0 {
            far
        } else if depth < self.opening_depth() {
            let middle = far - 0.5 * wall;
            // Thickness across from the middle of the notch by an angle.
            let thickness = |angle: f64| wall.min((far - depth) / angle.cos() - near);
            let flow: f64 = (0..ARCS)
                .map(|i| 0.5 * PI * (f64::from(i) + 0.5) / f64::from(ARCS))
                .map(|angle| 1.0 / thickness(angle))
                .sum::<f64>()
                * (PI * middle / f64::from(ARCS))
                + PI * middle / wall;
            2.0 * PI * middle * middle / (self.thinnest_wall(depth) * flow)
        } else if outer.sides.is_none() {
            wall * (far + near) / (2.0 * near * (far / near).ln()) - near
        } else {
            wall
        }
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

    /// A rod, a half rod (0.849 ρ, Timoshenko and Goodier art. 109), a slit and a whole thin tube, and a skin almost as thick as the wall.
    #[test]
    fn shear_by_torsion() {
        let arm = |outer_radius, inner_radius, depth: f64| {
            Outline::Round { outer_radius, inner_radius }.fibres(depth).unwrap().shear_arm
        };
        let near = |got: f64, want: f64, by: f64| assert!((got - want).abs() < by * want, "{got} {want}");
        near(arm(2.0, 0.0, 0.0), 2.0, 1e-12);
        near(arm(2.0, 0.0, 2.0), 2.0 * 0.849, 0.03);
        near(arm(1.0, 0.9, 0.0), 1.0, 1e-12);
        // ϕ = −r²/2 + A ln r + B vanishes at both radii.
        let a = (1.0 - 0.81) / (2.0 * (1.0 / 0.9_f64).ln());
        near(arm(1.0, 0.9, 0.5), a / 0.9 - 0.9, 1e-12);
        near(arm(1.0, 0.9, 0.5), 0.1, 0.03);
        near(arm(1.0, 0.9, 1e-9), 0.95, 1e-6);
        // A skin of half the wall carries the shear flow of the whole: more than the wall had, at most twice as much.
        let skin = arm(1.0, 0.9, 0.05);
        assert!(skin > 1.5 && skin < 1.9, "{skin}");
        // A square rod: 0.675 of its side.
        let square = Outline::Polygon { sides: 4, outer_apothem: 1.0, inner_apothem: 0.0 };
        near(square.fibres(0.0).unwrap().shear_arm, 2.0 * 0.675, 0.01);
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
