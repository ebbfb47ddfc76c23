//! Metal with a second slope, and teeth that meet: the potential of a section by fibres, along rings in closed form.
//!
//! A fibre bears σ = E ε up to an onset strain and rises by a second modulus beyond it, in tension and in compression each by its own. Superelastic metal
//! unloads along a lower curve, of the same slopes with another onset; whatever was done to it before, its stress lies between both.
//! With e the stretch of the line through the centroid (Y, Z) = (D, 0) of the section as cut, and b_Y, b_Z its curvatures less those at rest,
//! all of them means over a cell of notch and tooth, a fibre of the notch is strained by
//!
//! ```text
//! ε(Y, Z) = c_e e − c_Z b_Z (Y − D) + c_Y b_Y Z ,   w = ½ (EA e² + EI_Y b_Y² + EI_Z b_Z²) − s ∫ ½ (E − E_2) (|ε| − ε_on)₊² dA .
//! ```
//!
//! s = E I_Z/EI_Z is the part of the cell that bends like the section at the notch, c_Z = 1/s what the notch bends more than the mean, and c_e, c_Y are such
//! that the fibres alone give EA and EI_Y: without softening w is the energy of the tube's stiffness, whatever the teeth do. The neutral
//! axis goes where the tension puts it, since e is free.
//!
//! Teeth are whole rings. Where they meet, the part that was cut away bears pressure: fibres of it, whose strain −1 is the closed gap, with the
//! angle of the whole cell in the notch: ε = (ℓ + t)/ℓ (e − b_Z (Y − D) + b_Y Z), w + ℓ/(ℓ + t) ∫ ½ E (−1 − ε)₊² dA.
//!
//! On a ring ε is a + b cos (θ − θ₀), and what lies beyond a strain is an arc, or two where the cut divides it, whose integrals are elementary. Only the radius is left to a
//! rule, so that w has second slopes without jumps.

use super::{Cut, NotchedTube, Outline, SectionError, TeethStiffness};
use gauss_quad::GaussLegendre;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;

/// Stress beyond the proportional range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Branch {
    /// Strain, positive, from which on it holds (-).
    pub onset: f64,
    /// Slope of the stress there (Pa), above zero and at most Young's modulus.
    pub modulus: f64,
    /// Strain, positive, below which the metal is elastic again where it unloads (-), at most the onset: the stress at which its lower plateau ends, over
    /// Young's modulus. `None` where it unloads as it loads.
    pub unloading_onset: Option<f64>,
}

/// How a material softens.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Softening {
    /// Under tension.
    pub tension: Branch,
    /// Under compression.
    pub compression: Branch,
}

impl Softening {
    /// The curve along which all of the metal unloads; `None` where it is that of loading.
    #[must_use]
    pub fn unloading(&self) -> Option<Self> {
        let lower = |branch: Branch| Branch {
            onset: branch.unloading_onset.unwrap_or(branch.onset),
            unloading_onset: None,
            ..branch
        };
        let unloads = [self.tension, self.compression].iter().any(|branch| branch.unloading_onset.is_some());
        unloads.then(|| Self { tension: lower(self.tension), compression: lower(self.compression) })
    }
}

/// Stretch e of the centroid line (-) and curvatures b_Y, b_Z less those at rest (1/m).
pub(crate) type Strains = [f64; 3];

/// Fibres at one distance from the centre, between two angles θ from the axis Y.
#[derive(Clone, Copy, Debug)]
struct Ring {
    radius: f64,
    ends: [End; 2],
    /// Area per angle (m²).
    density: f64,
}

/// An angle (rad) with its cosine and sine.
#[derive(Clone, Copy, Debug)]
struct End {
    angle: f64,
    cos: f64,
    sin: f64,
}

impl End {
    fn at(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { angle, cos, sin }
    }
}

/// Fibres whose stress leaves that of the stiffness by `slope` (Pa) per strain beyond `from`, on its side of zero.
#[derive(Clone, Debug)]
struct Layer {
    rings: Vec<Ring>,
    /// c_e, c_Y, c_Z.
    factors: [f64; 3],
    /// Part of the cell for which they stand.
    share: f64,
    from: f64,
    slope: f64,
}

/// Potential of a section that is not linear.
#[derive(Clone, Debug)]
pub(crate) struct Metal {
    /// EA (N), EI_Y, EI_Z (N m²).
    stiffness: [f64; 3],
    /// D of the section as cut (m).
    offset: f64,
    layers: Vec<Layer>,
}

impl NotchedTube {
    /// Is its section not linear?
    pub(crate) fn is_nonlinear(&self) -> bool {
        self.material.softening.is_some() || self.contact && self.pattern.is_some()
    }
}

/// w with its slopes and second slopes by the strains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Potential {
    pub value: f64,
    pub slopes: [f64; 3],
    pub second: [[f64; 3]; 3],
}

/// Rings of the rule on a quarter of the radius at most. Each begins to soften, or to touch, at a strain of its own.
const RINGS: usize = 4;

/// Integrals over fibres of the products of 1, Y and Z.
type Moments = [[f64; 3]; 3];

impl Ring {
    /// Adds the integrals over what lies between two angles.
    fn add(&self, from: &End, to: &End, all: &mut Moments) {
        let way = to.angle - from.angle;
        let half = 0.5 * (to.sin * to.cos - from.sin * from.cos);
        let own = [
            [way, to.sin - from.sin, from.cos - to.cos],
            [0.0, 0.5 * way + half, 0.5 * (to.sin * to.sin - from.sin * from.sin)],
            [0.0, 0.0, 0.5 * way - half],
        ];
        let sizes = [1.0, self.radius, self.radius];
        for i in 0..3 {
            for j in 0..3 {
                all[i][j] += self.density * sizes[i] * sizes[j] * own[i.min(j)][i.max(j)];
            }
        }
    }

    /// Adds the integrals over the fibres at which a + g r cos(θ − θ₀) is above zero.
    fn add_beyond(&self, a: f64, steepest: &Steepest, all: &mut Moments) {
        let [first, last] = &self.ends;
        let most = self.radius * steepest.slope;
        if a <= -most {
            return;
        }
        if a >= most {
            return self.add(first, last, all);
        }
        let End { angle, cos, sin } = steepest.way;
        let cos_half = -a / most;
        let (half, sin_half) = (cos_half.acos(), (1.0 - cos_half * cos_half).sqrt());
        let end = |side: f64| End {
            angle: angle + side * half,
            cos: cos * cos_half - side * sin * sin_half,
            sin: sin * cos_half + side * cos * sin_half,
        };
        let ends = [end(-1.0), end(1.0)];
        for turn in [-TAU, 0.0, TAU] {
            let [from, to] = ends.map(|own| End { angle: own.angle + turn, ..own });
            let from = if from.angle > first.angle { &from } else { first };
            let to = if to.angle < last.angle { &to } else { last };
            if from.angle < to.angle {
                self.add(from, to, all);
            }
        }
    }
}

/// The direction θ₀ in which a plane field rises, and its slope g.
struct Steepest {
    slope: f64,
    way: End,
}

impl Steepest {
    fn of(y: f64, z: f64) -> Self {
        let slope = (y * y + z * z).sqrt();
        let [cos, sin] = if slope > 0.0 { [y / slope, z / slope] } else { [1.0, 0.0] };
        Self { slope, way: End { angle: sin.atan2(cos), cos, sin } }
    }
}

impl Metal {
    /// The potential of a tube of constant depth whose stiffness is EA (N), EI_Y and EI_Z (N m²).
    pub fn new(tube: &NotchedTube, stiffness: [f64; 3]) -> Result<Self, SectionError> {
        if !tube.depth.is_constant() {
            return Err(SectionError::Varying);
        }
        let cut = match &tube.teeth {
            TeethStiffness::Cells(table) => table.cut,
            TeethStiffness::Flexible | TeethStiffness::Rigid => Cut::Plane,
        };
        let depth = tube.depth.eval(0.0, 1.0)[0].max(0.0);
        let (kept, removed) = rings(&tube.outline, depth, cut).ok_or(SectionError::Fibres)?;
        let mut whole = Moments::default();
        for ring in &kept {
            let [from, to] = &ring.ends;
            ring.add(from, to, &mut whole);
        }
        let e = tube.material.youngs_modulus;
        let area = whole[0][0];
        let offset = whole[0][1] / area;
        let own = [area, whole[2][2], whole[1][1] - area * offset * offset].map(|v| e * v);
        let share = own[2] / stiffness[2];
        let factors = std::array::from_fn(|i| (stiffness[i] / (own[i] * share)).sqrt());
        let mut layers = Vec::new();
        if let Some(Softening { tension, compression }) = tube.material.softening {
            let sound = |b: &Branch| {
                let lower = b.unloading_onset.is_none_or(|strain| strain > 0.0 && strain <= b.onset);
                b.onset > 0.0 && b.onset.is_finite() && b.modulus > 0.0 && b.modulus <= e && lower
            };
            if !(sound(&tension) && sound(&compression)) {
                return Err(SectionError::Softening);
            }
            for (from, branch) in [(tension.onset, tension), (-compression.onset, compression)] {
                let slope = branch.modulus - e;
                layers.push(Layer { rings: kept.clone(), factors, share, from, slope });
            }
        }
        if let Some(pattern) = tube.pattern.filter(|_| tube.contact && depth > 0.0) {
            let closing = pattern.pitch() / pattern.length;
            let (factors, share) = ([closing; 3], 1.0 / closing);
            layers.push(Layer { rings: removed, factors, share, from: -1.0, slope: e });
        }
        Ok(Self { stiffness, offset, layers })
    }

    /// w (N) and its derivatives.
    pub fn at(&self, strains: Strains) -> Potential {
        let slopes: [f64; 3] = std::array::from_fn(|i| self.stiffness[i] * strains[i]);
        let value = 0.5 * (0..3).map(|i| slopes[i] * strains[i]).sum::<f64>();
        let second =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { self.stiffness[i] } else { 0.0 }));
        let mut all = Potential { value, slopes, second };
        for Layer { rings, factors: [along, y, z], share, from, slope } in &self.layers {
            let side = from.signum();
            // By the strains: what lies beyond is a + b Y + c Z, on the side of zero on which the layer is.
            let by = [[*along, 0.0, z * self.offset], [0.0, 0.0, -z], [0.0, *y, 0.0]];
            let mut beyond = by.map(|row| side * (0..3).map(|i| row[i] * strains[i]).sum::<f64>());
            beyond[0] -= side * from;
            let (steepest, mut moments) = (Steepest::of(beyond[1], beyond[2]), Moments::default());
            for ring in rings {
                ring.add_beyond(beyond[0], &steepest, &mut moments);
            }
            if moments[0][0] <= 0.0 {
                continue;
            }
            let factor = share * slope;
            let product = |row: [f64; 3], other: [f64; 3]| (0..3).map(|i| row[i] * other[i]).sum::<f64>();
            let turned = moments.map(|row| product(row, beyond));
            all.value += 0.5 * factor * product(turned, beyond);
            for i in 0..3 {
                let own = by.map(|row| row[i]);
                all.slopes[i] += factor * side * product(own, turned);
                let across = moments.map(|row| product(row, own));
                for j in 0..3 {
                    all.second[i][j] += factor * product(by.map(|row| row[j]), across);
                }
            }
        }
        all
    }
}

/// The part that a notch keeps and the part that it removes; none for polygons, which have no such rings.
fn rings(outline: &Outline, depth: f64, cut: Cut) -> Option<(Vec<Ring>, Vec<Ring>)> {
    let Outline::Round { outer_radius, inner_radius } = *outline else { return None };
    let rule = GaussLegendre::new(NonZeroUsize::new(RINGS)?);
    let plane = depth - outer_radius;
    // Radii at which the cut begins and ends to cross the rings are edges of the rule.
    let mut edges = vec![inner_radius, outer_radius];
    edges.extend([0.25, 0.5, 0.75].map(|part| part * outer_radius).into_iter().filter(|r| *r > inner_radius));
    edges.extend(Some(plane.abs()).filter(|r| *r > inner_radius && *r < outer_radius));
    edges.sort_by(f64::total_cmp);
    let (mut kept, mut removed) = (Vec::new(), Vec::new());
    for pair in edges.windows(2) {
        for (x, weight) in rule.as_node_weight_pairs() {
            let half = 0.5 * (pair[1] - pair[0]);
            let radius = pair[0] + half * (1.0 + x);
            let level = match cut {
                Cut::Plane => plane / radius,
                Cut::Radial => plane / outer_radius,
            };
            let end = level.clamp(-1.0, 1.0).acos();
            for (part, ends) in [(&mut kept, [-end, end]), (&mut removed, [end, TAU - end])] {
                if ends[1] > ends[0] {
                    part.push(Ring { radius, ends: ends.map(End::at), density: radius * half * weight });
                }
            }
        }
    }
    (!kept.is_empty()).then_some((kept, removed))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::design::{BelowPlate, Material, NotchPattern, Profile, Torsion};

    const E: f64 = 40e9;

    fn tube(depth: f64, softening: Softening, contact: bool) -> NotchedTube {
        NotchedTube {
            outline: Outline::Round { outer_radius: 0.81e-3, inner_radius: 0.7e-3 },
            depth: Profile::constant(depth),
            direction: Profile::constant(0.0),
            pattern: Some(NotchPattern { length: 0.8e-3, tooth: 1.2e-3, count: 5 }),
            teeth: TeethStiffness::Flexible,
            contact,
            material: Material {
                youngs_modulus: E,
                poissons_ratio: 0.33,
                density: 6450.0,
                allowable_strain: None,
                softening: Some(softening),
            },
            torsion: Torsion::SaintVenant,
            below: BelowPlate::Plain,
            centroid_offset_factor: 1.0,
        }
    }

    fn two_slopes() -> Softening {
        let branch = |onset| Branch { onset, modulus: 0.08 * E, unloading_onset: None };
        Softening { tension: branch(0.01), compression: branch(0.015) }
    }

    /// The stiffness of a section that fibres make by themselves.
    fn own(tube: &NotchedTube, depth: f64) -> [f64; 3] {
        let section = tube.outline.inertia(depth).unwrap();
        [section.area, section.inertia_y, section.inertia_z].map(|v| E * v)
    }

    #[test]
    fn slopes_are_those_of_the_potential() {
        let tube = tube(1.4e-3, two_slopes(), true);
        // Stiffer than the fibres, as a cell is.
        let [ea, y, z] = own(&tube, 1.4e-3);
        let metal = Metal::new(&tube, [1.1 * ea, 1.3 * y, 1.6 * z]).unwrap();
        let mut softened = 0;
        for at in [[0.002, 3.0, 20.0], [-0.004, 25.0, 90.0], [0.01, -40.0, -150.0], [0.02, 10.0, 330.0]] {
            let here = metal.at(at);
            softened += usize::from((here.second[2][2] / (1.6 * z) - 1.0).abs() > 0.05);
            for i in 0..3 {
                let step = [1e-7, 1e-4, 1e-4][i];
                let [ahead, behind] = [step, -step].map(|step| {
                    let mut moved = at;
                    moved[i] += step;
                    metal.at(moved)
                });
                let slope = (ahead.value - behind.value) / (2.0 * step);
                assert!(
                    (slope - here.slopes[i]).abs() <= 1e-6 * here.slopes[i].abs().max(1e-3),
                    "{at:?} {i}"
                );
                for j in 0..3 {
                    let second = (ahead.slopes[j] - behind.slopes[j]) / (2.0 * step);
                    let size = (here.second[i][i] * here.second[j][j]).sqrt();
                    assert!((second - here.second[i][j]).abs() <= 2e-3 * size, "{at:?} {i} {j}");
                }
            }
        }
        assert!(softened >= 3, "the strains are too small to test anything");
    }

    /// What is integrated along rings is the sum over fine fibres.
    #[test]
    fn rings_are_the_sum_of_their_fibres() {
        let tube = tube(1.4e-3, two_slopes(), true);
        let metal = Metal::new(&tube, own(&tube, 1.4e-3)).unwrap();
        let fine = 1000;
        let width = 0.11e-3 / f64::from(fine / 10);
        for [e, y, z] in [[0.008, 4.0, 90.0], [-0.01, -25.0, -120.0], [0.002, 40.0, -170.0]] {
            let (mut softer, mut closed) = (0.0, 0.0);
            for i in 0..fine / 10 {
                let radius = 0.7e-3 + (f64::from(i) + 0.5) * width;
                for j in 0..fine {
                    let turn = TAU / f64::from(fine);
                    let (sin, cos) = ((f64::from(j) + 0.5) * turn).sin_cos();
                    let strain = e - z * (radius * cos - metal.offset) + y * radius * sin;
                    let area = radius * width * turn;
                    if radius * cos > 0.59e-3 {
                        let beyond = (strain - 0.01).max(0.0) + (-0.015 - strain).max(0.0);
                        softer -= area * 0.5 * 0.92 * E * beyond * beyond;
                    } else {
                        closed += area * 0.4 * 0.5 * E * (-1.0 - 2.5 * strain).max(0.0).powi(2);
                    }
                }
            }
            let found = metal.at([e, y, z]).value;
            let linear = 0.5 * (0..3).map(|i| metal.stiffness[i] * [e, y, z][i].powi(2)).sum::<f64>();
            let wanted = softer + closed;
            assert!(wanted.abs() > 1e-3 * linear, "the strains are too small to test anything");
            assert!((found - linear - wanted).abs() < 2e-3 * wanted.abs(), "{found} for {linear} + {wanted}");
        }
    }

    /// A ring under tension: all fibres at once.
    #[test]
    fn a_stretched_tube_bears_the_stress_of_its_metal() {
        let tube = tube(0.0, two_slopes(), true);
        let [ea, ..] = own(&tube, 0.0);
        let metal = Metal::new(&tube, own(&tube, 0.0)).unwrap();
        let force = |e: f64| metal.at([e, 0.0, 0.0]).slopes[0] / ea;
        assert!((force(0.009) - 0.009).abs() < 1e-12 && (force(-0.014) + 0.014).abs() < 1e-12);
        assert!((force(0.03) - (0.01 + 0.08 * 0.02)).abs() < 1e-9);
        assert!((force(-0.03) + 0.015 + 0.08 * 0.015).abs() < 1e-9);
    }

    /// Below the onset the section is that of its stiffness, whatever that is.
    #[test]
    fn nothing_softens_below_the_onset() {
        let tube = tube(1.4e-3, two_slopes(), true);
        let stiffness = [1e3, 2e-3, 3e-5];
        let metal = Metal::new(&tube, stiffness).unwrap();
        let found = metal.at([1e-4, 0.1, 0.2]);
        assert!((found.slopes[2] - 3e-5 * 0.2).abs() <= 0.0 && (found.slopes[0] - 0.1).abs() < 1e-15);
    }

    #[test]
    fn what_fibres_cannot_be_is_said() {
        let varying =
            NotchedTube { depth: Profile::linear(1.4e-3, 1.3e-3), ..tube(1.4e-3, two_slopes(), false) };
        assert_eq!(Metal::new(&varying, [1.0; 3]).unwrap_err(), SectionError::Varying);
        let square = Outline::Polygon { sides: 4, outer_apothem: 1e-3, inner_apothem: 0.8e-3 };
        let square = NotchedTube { outline: square, ..tube(1e-3, two_slopes(), false) };
        assert_eq!(Metal::new(&square, [1.0; 3]).unwrap_err(), SectionError::Fibres);
        let mut harder = two_slopes();
        harder.tension.modulus = 2.0 * E;
        let harder = tube(1e-3, harder, false);
        assert_eq!(Metal::new(&harder, [1.0; 3]).unwrap_err(), SectionError::Softening);
        let mut higher = two_slopes();
        higher.tension.unloading_onset = Some(0.011);
        assert_eq!(Metal::new(&tube(1e-3, higher, false), [1.0; 3]).unwrap_err(), SectionError::Softening);
    }

    #[test]
    fn unloading_is_along_the_lower_curve() {
        assert_eq!(two_slopes().unloading(), None);
        let mut metal = two_slopes();
        metal.tension.unloading_onset = Some(0.004);
        let lower = metal.unloading().unwrap();
        assert_eq!(lower.tension, Branch { onset: 0.004, ..two_slopes().tension });
        assert_eq!(lower.compression, metal.compression);
    }
}
