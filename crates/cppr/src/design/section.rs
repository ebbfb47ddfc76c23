//! Section properties of a notched tube: a round or polygonal ring of which the part Y ≤ α is cut away.
//!
//! Frame: origin at the tube's centre, Y along the centroid direction, away from the notch, Z normal to it.
//! The notch is a straight cut of depth γ from the outer surface, so that the part Y > α = γ − ρ̄ is kept, ρ̄
//! being the outer radius or apothem (Tummers et al. 2024, appendix B). SI units: m, m², m⁴.
//!
//! Appendix B integrates about the centre, in closed form; there I_Z = J_Z − A D² loses all digits for a thin
//! remainder. Here the moments of the outer and of the inner shape are taken about the line of the cut,
//!
//!   A = ∫dA ,   S = ∫(Y − α) dA ,   J = ∫(Y − α)² dA ,   J_Y = ∫Z² dA ,
//!
//! as sums of positive terms, and D = α + S/A, I_Z = J − S²/A. One expression serves for every depth: an inner
//! shape that is whole (shallow notch), cut, or gone (deep notch) merely contributes another share.

use super::{CellProblem, torsion};
use gauss_quad::GaussLegendre;
use std::fmt;
use std::num::NonZeroUsize;
use std::sync::LazyLock;

/// Nodes for the moments of a disk. With the angle as variable the integrands are trigonometric polynomials
/// of degree 4 over at most half a turn; n nodes integrate exp(4it) over π with a relative error below
/// π^(2n+1) (n!)⁴ 4^(2n) / (2n + 1) (2n)!³, which is 5e-19 for n = 16.
const DISK_NODES: NonZeroUsize = NonZeroUsize::new(16).unwrap();

/// Gauss–Legendre nodes and weights on [0, 1].
static DISK_RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    GaussLegendre::new(DISK_NODES).iter().map(|&(x, w)| (0.5 * (x + 1.0), 0.5 * w)).collect()
});

/// Shape of the uncut section.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Outline {
    /// Round tube; an inner radius of zero is a solid rod.
    Round {
        /// Outer radius ρ̄ (m).
        outer_radius: f64,
        /// Radius ρ of the bore (m).
        inner_radius: f64,
    },
    /// Regular polygon with a parallel polygonal bore. One flat is normal to Y, on the notched side.
    Polygon {
        /// Number of sides, at least 3.
        sides: usize,
        /// Distance of the outer flats from the centre (m).
        outer_apothem: f64,
        /// Distance of the flats of the bore from the centre (m); zero is a solid rod.
        inner_apothem: f64,
    },
}

/// Properties of a section that need no more than integration. About axes through the centroid unless said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Area A (m²).
    pub area: f64,
    /// Distance D ≥ 0 of the centroid from the tube's centre (m).
    pub centroid_offset: f64,
    /// Second moment I_Y = ∫Z² dA about the axis along the centroid direction: the stiff one (m⁴).
    pub inertia_y: f64,
    /// Second moment I_Z = ∫(Y − D)² dA about the axis normal to the centroid direction: the soft one (m⁴).
    pub inertia_z: f64,
    /// Polar moment J_Y + J_Z = I_Y + I_Z + A D² about the tube's centre (m⁴).
    pub polar_about_centre: f64,
}

/// All properties of a section: [`Inertia`] and the torsion constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionProperties {
    /// Area A (m²).
    pub area: f64,
    /// Distance D ≥ 0 of the centroid from the tube's centre (m).
    pub centroid_offset: f64,
    /// Second moment I_Y = ∫Z² dA about the axis along the centroid direction: the stiff one (m⁴).
    pub inertia_y: f64,
    /// Second moment I_Z = ∫(Y − D)² dA about the axis normal to the centroid direction: the soft one (m⁴).
    pub inertia_z: f64,
    /// Polar moment J_Y + J_Z = I_Y + I_Z + A D² about the tube's centre (m⁴).
    pub polar_about_centre: f64,
    /// Saint-Venant torsion constant J_t (m⁴).
    pub torsion_constant: f64,
}

/// What is wrong with a section. Lengths in m, shown in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionError {
    /// A length is not a finite number.
    NotFinite {
        /// Which length.
        quantity: &'static str,
        /// Its value (m).
        value: f64,
    },
    /// The outer radius or apothem is not positive.
    OuterNotPositive(f64),
    /// The radius or apothem of the bore is negative.
    InnerNegative(f64),
    /// The bore is as wide as the tube, or wider.
    NoWall {
        /// Inner radius or apothem (m).
        inner: f64,
        /// Outer radius or apothem (m).
        outer: f64,
    },
    /// A polygon with fewer than three sides.
    Sides(usize),
    /// The notch cuts the tube in two.
    NothingLeft {
        /// Depth of the notch (m).
        depth: f64,
        /// Depth at which nothing is left (m).
        limit: f64,
    },
    /// The stiffness of the tube with its teeth is not known.
    Cells(CellProblem),
    /// No rule of fibres is known for the shape.
    Fibres,
    /// The depth varies where the section is not linear.
    Varying,
    /// The section is not linear, which is computed for bundles.
    NotLinear,
    /// A second modulus or onset that no metal has.
    Softening,
    /// The torsion problem is singular to working precision.
    Torsion {
        /// Depth of the notch (m).
        depth: f64,
    },
}

impl fmt::Display for SectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |length: &f64| length * 1e3;
        match self {
            Self::NotFinite { quantity, value } => {
                write!(f, "the {quantity} is {value}; give a finite length")
            }
            Self::OuterNotPositive(outer) => {
                write!(f, "the outer radius or apothem is {:.6} mm; it must be positive", mm(outer))
            }
            Self::InnerNegative(inner) => write!(
                f,
                "the inner radius or apothem is {:.6} mm; it must not be negative (zero is a solid rod)",
                mm(inner)
            ),
            Self::NoWall { inner, outer } => write!(
                f,
                "the bore ({:.6} mm) leaves no wall inside the outer surface ({:.6} mm); make it smaller",
                mm(inner),
                mm(outer)
            ),
            Self::Sides(sides) => write!(f, "a polygon cannot have {sides} sides; give at least 3"),
            Self::NothingLeft { depth, limit } => write!(
                f,
                "a notch {:.6} mm deep leaves nothing of a tube {:.6} mm thick; make it shallower",
                mm(depth),
                mm(limit)
            ),
            Self::Cells(problem) => problem.fmt(f),
            Self::Fibres => write!(
                f,
                "metal that softens and teeth that meet are computed for round tubes; leave out its second modulus and contact"
            ),
            Self::Varying => write!(
                f,
                "metal that softens and teeth that meet are computed where depth and opening are constant; cut the tube into such parts"
            ),
            Self::NotLinear => write!(
                f,
                "metal that softens and teeth that meet are computed for bundles; make it a bundle, or leave out its second modulus and contact"
            ),
            Self::Softening => write!(
                f,
                "the material softens at a strain above zero to a modulus above zero and below Young's; give such numbers"
            ),
            Self::Torsion { depth } => write!(
                f,
                "the torsion constant of the section notched {:.6} mm deep cannot be computed; \
                 give the torsional stiffness as a number",
                mm(depth)
            ),
        }
    }
}

impl std::error::Error for SectionError {}

impl Outline {
    /// All properties of the section with a notch of the given depth γ (m); γ ≤ 0 is the uncut section.
    ///
    /// # Errors
    /// Dimensions that describe no section, and a depth of [`Outline::depth_limit`] or more.
    pub fn notched(&self, depth: f64) -> Result<SectionProperties, SectionError> {
        let inertia = self.inertia(depth)?;
        let torsion_constant =
            torsion::torsion_constant(self, depth).ok_or(SectionError::Torsion { depth })?;
        Ok(SectionProperties {
            area: inertia.area,
            centroid_offset: inertia.centroid_offset,
            inertia_y: inertia.inertia_y,
            inertia_z: inertia.inertia_z,
            polar_about_centre: inertia.polar_about_centre,
            torsion_constant,
        })
    }

    /// All properties of the uncut section.
    ///
    /// # Errors
    /// Dimensions that describe no section.
    pub fn plain(&self) -> Result<SectionProperties, SectionError> {
        self.notched(0.0)
    }

    /// What [`Outline::notched`] gives, but without the torsion constant, which costs far more than the rest.
    ///
    /// # Errors
    /// As [`Outline::notched`].
    pub fn inertia(&self, depth: f64) -> Result<Inertia, SectionError> {
        self.check(depth)?;
        let alpha = self.cut(depth);
        let (outer, inner) = self.contours();
        let kept = outer.kept(alpha).without(inner.kept(alpha));
        let lever = kept.first / kept.area;
        // Without a notch the centroid is the centre by symmetry; rounding must not give it a direction.
        let offset = if depth > 0.0 { (alpha + lever).max(0.0) } else { 0.0 };
        let inertia_z = kept.second - kept.first * lever;
        Ok(Inertia {
            area: kept.area,
            centroid_offset: offset,
            inertia_y: kept.lateral,
            inertia_z,
            polar_about_centre: kept.lateral + inertia_z + kept.area * offset * offset,
        })
    }

    /// Largest distance of the outer surface from the centre (m).
    #[must_use]
    pub fn outer_reach(&self) -> f64 {
        self.contours().0.reach()
    }

    /// Radius of the largest circle inside the bore (m).
    #[must_use]
    pub fn inner_clearance(&self) -> f64 {
        self.contours().1.inradius
    }

    /// Depth at which the notch reaches the bore and the ring opens (m).
    ///
    /// There the torsion constant of a round tube falls as the square root of the wall left, to that of the
    /// open ring; that of a polygon, whose wall has a flat bottom, falls linearly.
    #[must_use]
    pub fn opening_depth(&self) -> f64 {
        let (outer, inner) = self.contours();
        outer.inradius - inner.inradius
    }

    /// Depth from which on nothing of the bore is left (m). There all properties have a continuous slope, that
    /// of a polygon with a flat on top apart, but no continuous curvature.
    #[must_use]
    pub fn passing_depth(&self) -> f64 {
        let (outer, inner) = self.contours();
        outer.inradius + inner.top()
    }

    /// Depth at which nothing is left (m).
    #[must_use]
    pub fn depth_limit(&self) -> f64 {
        let outer = self.contours().0;
        outer.inradius + outer.top()
    }

    /// Outer and inner contour.
    pub(super) fn contours(&self) -> (Contour, Contour) {
        match *self {
            Self::Round { outer_radius, inner_radius } => (
                Contour { sides: None, inradius: outer_radius },
                Contour { sides: None, inradius: inner_radius },
            ),
            Self::Polygon { sides, outer_apothem, inner_apothem } => (
                Contour { sides: Some(sides), inradius: outer_apothem },
                Contour { sides: Some(sides), inradius: inner_apothem },
            ),
        }
    }

    /// Y = α of the cut (m).
    pub(super) fn cut(&self, depth: f64) -> f64 {
        depth.max(0.0) - self.contours().0.inradius
    }

    fn check(&self, depth: f64) -> Result<(), SectionError> {
        let (outer, inner) = (self.contours().0.inradius, self.contours().1.inradius);
        let names = match self {
            Self::Round { .. } => ["outer radius", "inner radius", "notch depth"],
            Self::Polygon { .. } => ["outer apothem", "inner apothem", "notch depth"],
        };
        for (quantity, value) in names.into_iter().zip([outer, inner, depth]) {
            if !value.is_finite() {
                return Err(SectionError::NotFinite { quantity, value });
            }
        }
        if let Self::Polygon { sides, .. } = *self
            && sides < 3
        {
            return Err(SectionError::Sides(sides));
        }
        if outer <= 0.0 {
            return Err(SectionError::OuterNotPositive(outer));
        }
        if inner < 0.0 {
            return Err(SectionError::InnerNegative(inner));
        }
        if inner >= outer {
            return Err(SectionError::NoWall { inner, outer });
        }
        let limit = self.depth_limit();
        if depth >= limit {
            return Err(SectionError::NothingLeft { depth, limit });
        }
        Ok(())
    }
}

/// A circle, or a regular polygon with one flat normal to Y on the side of −Y, about the centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contour {
    /// Number of sides; none for a circle.
    pub sides: Option<usize>,
    /// Radius or apothem (m).
    pub inradius: f64,
}

impl Contour {
    /// Largest distance from the centre (m).
    pub fn reach(&self) -> f64 {
        self.sides.map_or(self.inradius, |n| self.inradius / (std::f64::consts::PI / real(n)).cos())
    }

    /// Largest Y (m): a flat for an even number of sides, a vertex for an odd one.
    pub fn top(&self) -> f64 {
        if self.sides.is_some_and(|n| n % 2 == 1) { self.reach() } else { self.inradius }
    }

    /// Vertices (Y, Z) with Z > 0 from the top to the bottom (m).
    pub fn vertices(&self) -> Vec<[f64; 2]> {
        let Some(n) = self.sides else { return Vec::new() };
        let reach = self.reach();
        (0..n / 2)
            .rev()
            .map(|k| {
                let (sin, cos) = (std::f64::consts::PI * real(2 * k + 1) / real(n)).sin_cos();
                [-reach * cos, reach * sin]
            })
            .collect()
    }

    /// Moments about the line Y = α of what lies above it.
    fn kept(&self, alpha: f64) -> Moments {
        if alpha >= self.top() {
            Moments::default()
        } else if self.sides.is_none() {
            disk_moments(self.inradius, alpha)
        } else {
            polygon_moments(self, alpha)
        }
    }
}

/// Moments about the line Y = α.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    area: f64,
    /// ∫(Y − α) dA.
    first: f64,
    /// ∫(Y − α)² dA.
    second: f64,
    /// ∫Z² dA.
    lateral: f64,
}

impl Moments {
    fn without(self, hole: Self) -> Self {
        Self {
            area: self.area - hole.area,
            first: self.first - hole.first,
            second: self.second - hole.second,
            lateral: self.lateral - hole.lateral,
        }
    }
}

/// Strips between Y and Y + dY of a disk, Y = r cos t, 0 < t < β, where r cos β is the lower end of the part.
fn disk_moments(radius: f64, alpha: f64) -> Moments {
    let end = alpha.max(-radius);
    let lift = end - alpha;
    // The half-angle form of acos(end / r), which keeps its digits at both ends.
    let beta = 2.0 * (radius - end).sqrt().atan2((radius + end).sqrt());
    let mut sum = Moments::default();
    for &(x, weight) in DISK_RULE.iter() {
        let t = beta * x;
        let half_width = radius * t.sin();
        let height = 2.0 * radius * (0.5 * (beta + t)).sin() * (0.5 * (beta - t)).sin() + lift;
        let area = 2.0 * half_width * half_width * beta * weight;
        sum.area += area;
        sum.first += area * height;
        sum.second += area * height * height;
        sum.lateral += area * half_width * half_width / 3.0;
    }
    sum
}

/// Triangles between the point (α, 0) and the sides of the half Z > 0, doubled.
fn polygon_moments(contour: &Contour, alpha: f64) -> Moments {
    let mut sum = Moments::default();
    for pair in above(contour, alpha).windows(2) {
        let ([y, z], [v, w]) = ([pair[0][0] - alpha, pair[0][1]], [pair[1][0] - alpha, pair[1][1]]);
        let twice = y * w - v * z;
        sum.area += twice;
        sum.first += twice * (y + v) / 3.0;
        sum.second += twice * (y * y + y * v + v * v) / 6.0;
        sum.lateral += twice * (z * z + z * w + w * w) / 6.0;
    }
    sum
}

/// Corners (Y, Z) of the half Z ≥ 0 of a polygon from the top to the line Y = α or, where the polygon ends
/// above it, to the bottom (m).
pub(super) fn above(contour: &Contour, alpha: f64) -> Vec<[f64; 2]> {
    let mut corners = vec![[contour.top(), 0.0]];
    let bottom = [-contour.inradius, 0.0];
    for next in contour.vertices().into_iter().chain([bottom]) {
        let [y, z] = corners[corners.len() - 1];
        // A corner on the line up to its own rounding ends the path: the flat along the line encloses nothing.
        if next[0] <= alpha + 4.0 * f64::EPSILON * contour.inradius {
            let fraction = ((y - alpha) / (y - next[0])).clamp(0.0, 1.0);
            corners.push([alpha, z + fraction * (next[1] - z)]);
            break;
        }
        corners.push(next);
    }
    corners
}

/// A count as a number; exact, since counts here are far below 2⁵³.
#[allow(clippy::cast_precision_loss)]
pub(super) fn real(count: usize) -> f64 {
    count as f64
}
