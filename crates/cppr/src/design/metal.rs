//! Metal with a second slope, and teeth that meet: the potential of a section by fibres.
//!
//! A fibre bears σ = E ε up to an onset strain and rises by a second modulus beyond it, in tension and in compression each by its own.
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

use super::{Cut, NotchedTube, Outline, SectionError, TeethStiffness};
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// Stress beyond the proportional range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Branch {
    /// Strain, positive, from which on it holds (-).
    pub onset: f64,
    /// Slope of the stress there (Pa), above zero and at most Young's modulus.
    pub modulus: f64,
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

/// Stretch e of the centroid line (-) and curvatures b_Y, b_Z less those at rest (1/m).
pub(crate) type Strains = [f64; 3];

/// A fibre: ε = arm · strains.
#[derive(Clone, Copy, Debug)]
struct Fibre {
    arm: [f64; 3],
    /// Its area, times the part of the cell for which it stands (m²).
    weight: f64,
}

/// Fibres whose stress leaves that of the stiffness by `slope` (Pa) per strain beyond `from`, on its side of zero.
#[derive(Clone, Debug)]
struct Layer {
    fibres: Vec<Fibre>,
    from: f64,
    slope: f64,
}

/// Potential of a section that is not linear.
#[derive(Clone, Debug)]
pub(crate) struct Metal {
    /// EA (N), EI_Y, EI_Z (N m²).
    stiffness: [f64; 3],
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

/// Rings of the rule on a quarter of the radius at most, and angles on half a section.
const RINGS: usize = 4;
const ANGLES: usize = 24;

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
        let (kept, removed) = points(&tube.outline, depth, cut).ok_or(SectionError::Fibres)?;
        let sum = |f: &dyn Fn(&[f64; 3]) -> f64| kept.iter().map(|p| p[2] * f(p)).sum::<f64>();
        let e = tube.material.youngs_modulus;
        let area = sum(&|_| 1.0);
        let offset = sum(&|p| p[0]) / area;
        let own = [area, sum(&|p| p[1] * p[1]), sum(&|p| (p[0] - offset).powi(2))].map(|v| e * v);
        let share = own[2] / stiffness[2];
        let [by_e, by_y, by_z] = std::array::from_fn(|i| (stiffness[i] / (own[i] * share)).sqrt());
        let mut layers = Vec::new();
        if let Some(Softening { tension, compression }) = tube.material.softening {
            let sound =
                |b: &Branch| b.onset > 0.0 && b.onset.is_finite() && b.modulus > 0.0 && b.modulus <= e;
            if !(sound(&tension) && sound(&compression)) {
                return Err(SectionError::Softening);
            }
            let fibre = |p: &[f64; 3]| Fibre {
                arm: [by_e, by_y * p[1], -by_z * (p[0] - offset)],
                weight: share * p[2],
            };
            let fibres: Vec<Fibre> = kept.iter().map(fibre).collect();
            layers.push(Layer { fibres: fibres.clone(), from: tension.onset, slope: tension.modulus - e });
            layers.push(Layer { fibres, from: -compression.onset, slope: compression.modulus - e });
        }
        if let Some(pattern) = tube.pattern.filter(|_| tube.contact && depth > 0.0) {
            let closing = pattern.pitch() / pattern.length;
            let fibre = |p: &[f64; 3]| Fibre {
                arm: [closing, closing * p[1], -closing * (p[0] - offset)],
                weight: p[2] / closing,
            };
            layers.push(Layer { fibres: removed.iter().map(fibre).collect(), from: -1.0, slope: e });
        }
        Ok(Self { stiffness, layers })
    }

    /// w (N) and its derivatives.
    pub fn at(&self, strains: Strains) -> Potential {
        let slopes: [f64; 3] = std::array::from_fn(|i| self.stiffness[i] * strains[i]);
        let value = 0.5 * (0..3).map(|i| slopes[i] * strains[i]).sum::<f64>();
        let second =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { self.stiffness[i] } else { 0.0 }));
        let mut all = Potential { value, slopes, second };
        for Layer { fibres, from, slope } in &self.layers {
            for Fibre { arm, weight } in fibres {
                let strain = arm[0] * strains[0] + arm[1] * strains[1] + arm[2] * strains[2];
                let beyond = strain - from;
                // On the side of zero on which the layer is.
                if beyond * from <= 0.0 {
                    continue;
                }
                let factor = weight * slope;
                all.value += 0.5 * factor * beyond * beyond;
                for i in 0..3 {
                    all.slopes[i] += factor * beyond * arm[i];
                    for j in 0..3 {
                        all.second[i][j] += factor * arm[i] * arm[j];
                    }
                }
            }
        }
        all
    }
}

/// Points (Y, Z) with their areas.
type Points = Vec<[f64; 3]>;

/// Points of the part that a notch keeps and of the part that it removes; none for polygons, which have no such rule.
fn points(outline: &Outline, depth: f64, cut: Cut) -> Option<(Points, Points)> {
    let Outline::Round { outer_radius, inner_radius } = *outline else { return None };
    let [rings, angles] = [RINGS, ANGLES].map(|n| NonZeroUsize::new(n).map(GaussLegendre::new));
    let (rings, angles) = (rings?, angles?);
    let plane = depth - outer_radius;
    // Radii at which the cut begins and ends to cross the rings are edges of the rule.
    let mut edges = vec![inner_radius, outer_radius];
    edges.extend([0.25, 0.5, 0.75].map(|part| part * outer_radius).into_iter().filter(|r| *r > inner_radius));
    edges.extend(Some(plane.abs()).filter(|r| *r > inner_radius && *r < outer_radius));
    edges.sort_by(f64::total_cmp);
    let (mut kept, mut removed) = (Points::new(), Points::new());
    for ring in edges.windows(2) {
        for (x, weight) in rings.as_node_weight_pairs() {
            let half = 0.5 * (ring[1] - ring[0]);
            let radius = ring[0] + half * (1.0 + x);
            let level = match cut {
                Cut::Plane => plane / radius,
                Cut::Radial => plane / outer_radius,
            };
            let end = level.clamp(-1.0, 1.0).acos();
            for (part, from, to) in [(&mut kept, 0.0, end), (&mut removed, end, std::f64::consts::PI)] {
                let span = 0.5 * (to - from);
                if span <= 0.0 {
                    continue;
                }
                for (y, share) in angles.as_node_weight_pairs() {
                    let (sin, cos) = (from + span * (1.0 + y)).sin_cos();
                    let area = radius * half * weight * span * share;
                    part.extend([1.0, -1.0].map(|side| [radius * cos, side * radius * sin, area]));
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
        let branch = |onset| Branch { onset, modulus: 0.08 * E };
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
    }
}
