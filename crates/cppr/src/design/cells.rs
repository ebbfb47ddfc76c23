//! Stiffness of a tube with its teeth: the mean over a cell of one notch and one tooth.
//!
//! The section at the notch, spread over the whole tube, is too soft: teeth bend less than notches. What a cell does
//! relative to that section is either taken from a [`CellTable`] that was computed elsewhere (the crate `cppr-cell` solves the cell by finite
//! elements), or bounded by teeth that do not deform at all: then EI, GJ and EA are those of the notch times (ℓ + t)/ℓ.

use super::robot::barycentric;
use super::{NotchPattern, NotchedTube, Outline};
use std::fmt;

/// What the teeth between the notches do to the stiffness of a tube.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TeethStiffness {
    /// Teeth as soft as notches: the section at the notch all along. What the paper computes.
    #[default]
    Flexible,
    /// Teeth that do not deform.
    Rigid,
    /// Computed for the cell as it is.
    Cells(CellTable),
}

/// How a notch is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cut {
    /// Along a plane normal to Y: saws, printers, wires.
    #[default]
    Plane,
    /// Towards the axis: a laser above a turning tube. Depth is measured where the cut meets the outer surface.
    Radial,
}

/// Stiffness of a cell, relative to the section at the notch cut by a plane, and the strain at its fillets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellFactors {
    /// Centroid offset of the cell over that of the section (-).
    pub centroid_offset: f64,
    /// EI_Y over that of the section (-).
    pub bending_y: f64,
    /// EI_Z over that of the section (-).
    pub bending_z: f64,
    /// GJ over G J_t of the section (-).
    pub torsion: f64,
    /// EA over that of the section (-).
    pub axial: f64,
    /// Mean mass per length over that of the section (-).
    pub mass: f64,
    /// Where the corners of the notch have a radius.
    pub peak: Option<PeakStrain>,
}

/// Principal strains of largest magnitude in a cell per unit of mean strain of the beam, about the effective centroid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PeakStrain {
    /// Greatest and least under κ_Z = 1 (m).
    pub bending_z: [f64; 2],
    /// Greatest and least under e = 1 (-).
    pub stretch: [f64; 2],
    /// Largest magnitude under κ_Y = 1 (m); both signs occur on either side of the plane Z = 0.
    pub bending_y: f64,
    /// Largest magnitude under a twist of 1 (m).
    pub twist: f64,
}

impl PeakStrain {
    /// Bounds on the greatest and the least strain under κ_Y, κ_Z (1/m) and e: the sums of what each makes, wherever that is.
    pub(crate) fn bounds(&self, [bend_y, bend_z, stretch]: [f64; 3]) -> [f64; 2] {
        let signed = |value: f64, [most, least]: [f64; 2]| {
            if value >= 0.0 { [value * most, value * least] } else { [value * least, value * most] }
        };
        let (z, e, y) =
            (signed(bend_z, self.bending_z), signed(stretch, self.stretch), bend_y.abs() * self.bending_y);
        [z[0] + e[0] + y, z[1] + e[1] - y]
    }
}

/// Factors at Chebyshev points of the second kind of the depth, between which they are interpolated.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellRange {
    /// Depth (m), falling, and factors; a single one holds for its depth alone.
    pub nodes: Vec<(f64, CellFactors)>,
}

/// Factors over depth for one tube: all else that they depend on is fixed here, and compared with the tube that uses them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellTable {
    /// The uncut section.
    pub outline: Outline,
    /// Length of a notch along the tube (m).
    pub notch: f64,
    /// Length of a tooth (m).
    pub tooth: f64,
    /// How notches are cut.
    pub cut: Cut,
    /// Radius of the corners of a notch, as its side view shows them (m); none where they are sharp.
    pub corner_radius: Option<f64>,
    /// Poisson's ratio (-).
    pub poissons_ratio: f64,
    /// By how much more than computed the teeth bend (-), at least 0: every stiffness is that of the section at the notch times (ℓ + t)/(ℓ + δ), and its δ is taken
    /// this many times; 1 is as computed, 0 are teeth that do not deform.
    pub tooth_factor: f64,
    /// By rising depth, as computed.
    pub ranges: Vec<CellRange>,
}

/// Why the stiffness of a tube with its teeth is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellProblem {
    /// The pattern has no lengths of notch and tooth.
    NoPattern,
    /// The table was computed for another tube: the quantity that differs.
    OtherTube(&'static str),
    /// The table does not cover this depth (m).
    Depth(f64),
    /// The factor on what the teeth bend is no number of at least 0.
    ToothFactor(f64),
}

impl fmt::Display for CellProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPattern => write!(f, "the stiffness of teeth needs the lengths of notch and tooth"),
            Self::OtherTube(what) => write!(
                f,
                "the table of cells was computed for another {what}; compute it again after a change of the tube"
            ),
            Self::Depth(depth) => write!(
                f,
                "the table of cells does not cover a depth of {:.6} mm; compute it for all depths of the pattern",
                depth * 1e3
            ),
            Self::ToothFactor(factor) => {
                write!(f, "the factor on what teeth bend is {factor}; it is at least 0")
            }
        }
    }
}

impl std::error::Error for CellProblem {}

/// Depths that differ by less are the same (relative to the outer radius): rounding of profiles.
const SAME_DEPTH: f64 = 1e-9;

impl CellFactors {
    /// The same where the lengths δ of the teeth that bend are `factor` times as long, in a cell of a notch and a tooth (m).
    fn with_teeth(self, factor: f64, [notch, tooth]: [f64; 2]) -> Self {
        let pitch = notch + tooth;
        let scaled = |own: f64| pitch / (notch + factor * (pitch / own - notch));
        // What the mean does less, the notch does more.
        let notches = |own: f64| scaled(own) / own;
        Self {
            bending_y: scaled(self.bending_y),
            bending_z: scaled(self.bending_z),
            torsion: scaled(self.torsion),
            axial: scaled(self.axial),
            peak: self.peak.map(|peak| PeakStrain {
                bending_z: peak.bending_z.map(|own| own * notches(self.bending_z)),
                stretch: peak.stretch.map(|own| own * notches(self.axial)),
                bending_y: peak.bending_y * notches(self.bending_y),
                twist: peak.twist * notches(self.torsion),
            }),
            ..self
        }
    }
}

impl CellTable {
    /// Factors at a depth (m), where the table covers it, with teeth that bend by the [`Self::tooth_factor`].
    #[must_use]
    pub fn at(&self, depth: f64) -> Option<CellFactors> {
        let slack = SAME_DEPTH * self.outline.outer_reach();
        let range = self.ranges.iter().find(|range| {
            let bounds = |f: fn(f64, f64) -> f64, start| range.nodes.iter().map(|n| n.0).fold(start, f);
            depth >= bounds(f64::min, f64::INFINITY) - slack
                && depth <= bounds(f64::max, f64::NEG_INFINITY) + slack
        })?;
        let value = |read: &dyn Fn(&CellFactors) -> f64| {
            let nodes: Vec<(f64, f64)> =
                range.nodes.iter().map(|(at, factors)| (*at, read(factors))).collect();
            barycentric(&nodes, depth)
        };
        let peaks = range.nodes.iter().all(|(_, factors)| factors.peak.is_some());
        let peak = |read: &dyn Fn(&PeakStrain) -> f64| value(&|f| f.peak.as_ref().map_or(f64::NAN, read));
        let computed = CellFactors {
            centroid_offset: value(&|f| f.centroid_offset),
            bending_y: value(&|f| f.bending_y),
            bending_z: value(&|f| f.bending_z),
            torsion: value(&|f| f.torsion),
            axial: value(&|f| f.axial),
            mass: value(&|f| f.mass),
            peak: peaks.then(|| PeakStrain {
                bending_z: [0, 1].map(|i| peak(&|p| p.bending_z[i])),
                stretch: [0, 1].map(|i| peak(&|p| p.stretch[i])),
                bending_y: peak(&|p| p.bending_y),
                twist: peak(&|p| p.twist),
            }),
        };
        let scales = (self.tooth_factor - 1.0).abs() > 0.0;
        Some(if scales { computed.with_teeth(self.tooth_factor, [self.notch, self.tooth]) } else { computed })
    }

    /// Is this the table of that tube?
    fn check(&self, tube: &NotchedTube, pattern: &NotchPattern) -> Result<(), CellProblem> {
        if !(self.tooth_factor >= 0.0 && self.tooth_factor.is_finite()) {
            return Err(CellProblem::ToothFactor(self.tooth_factor));
        }
        let differs = |a: f64, b: f64| (a - b).abs() > 1e-9 * a.abs().max(b.abs());
        let other = [
            ("outline", self.outline != tube.outline),
            ("length of the notch", differs(self.notch, pattern.length)),
            ("length of the tooth", differs(self.tooth, pattern.tooth)),
            ("Poisson's ratio", differs(self.poissons_ratio, tube.material.poissons_ratio)),
        ];
        other
            .into_iter()
            .find(|(_, differs)| *differs)
            .map_or(Ok(()), |(what, _)| Err(CellProblem::OtherTube(what)))
    }
}

impl NotchedTube {
    /// Factors on the stiffness of the section at the notch where its depth is `depth` (m); none where teeth count as flexible or there is no notch.
    pub(crate) fn cell_factors(&self, depth: f64) -> Result<Option<CellFactors>, CellProblem> {
        if self.teeth == TeethStiffness::Flexible || depth <= 0.0 {
            return Ok(None);
        }
        let pattern = self.pattern.ok_or(CellProblem::NoPattern)?;
        match &self.teeth {
            TeethStiffness::Flexible => Ok(None),
            TeethStiffness::Rigid => {
                let share = pattern.pitch() / pattern.length;
                let areas = [depth, 0.0].map(|depth| self.outline.inertia(depth).map(|i| i.area));
                let [Ok(notch), Ok(tooth)] = areas else { return Ok(None) };
                Ok(Some(CellFactors {
                    centroid_offset: 1.0,
                    bending_y: share,
                    bending_z: share,
                    torsion: share,
                    axial: share,
                    mass: (pattern.length + pattern.tooth * tooth / notch) / pattern.pitch(),
                    peak: None,
                }))
            }
            TeethStiffness::Cells(table) => {
                table.check(self, &pattern)?;
                table.at(depth).map(Some).ok_or(CellProblem::Depth(depth))
            }
        }
    }
}
