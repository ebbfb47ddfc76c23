//! A cell, what of it can be computed, and its stiffness on meshes that are refined until it settles.

use crate::contour::Contour;
use crate::mesh::{Fineness, Mesh, Profile};
use crate::peak::peak_strain;
use crate::section::Section;
use crate::system::{self, Solution};
use cppr::design::{Cut, Outline, PeakStrain, SectionError};
use serde::{Deserialize, Serialize};
use std::fmt;

/// One notch and one tooth of a tube. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The uncut section.
    pub outline: Outline,
    /// Depth of the notch from the outer surface (m).
    pub depth: f64,
    /// Length of the notch along the tube (m); zero is an uncut tube.
    pub notch: f64,
    /// Length of the tooth (m); zero is a tube that is notched all along.
    pub tooth: f64,
    /// How the notch is cut.
    pub cut: Cut,
    /// Radius of the corners of the notch (m); for a radial cut on the unrolled outer surface. None where they are sharp.
    pub corner_radius: Option<f64>,
    /// Poisson's ratio ν (-).
    pub poissons_ratio: f64,
}

/// Stiffness of a tube of equal cells about the tube's axis, over Young's modulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellStiffness {
    /// EA / E (m²).
    pub axial: f64,
    /// Distance of the effective centroid from the axis, the line on which a force stretches without bending (m).
    pub centroid_offset: f64,
    /// EI_Y / E about the effective centroid (m⁴).
    pub bending_y: f64,
    /// EI_Z / E about the effective centroid (m⁴).
    pub bending_z: f64,
    /// GJ / G (m⁴).
    pub torsion: f64,
    /// Volume over length (m²).
    pub mean_area: f64,
    /// Largest principal strains; none with sharp corners or a polygonal bore, where they are singular.
    pub peak: Option<PeakStrain>,
    /// Largest relative change of a stiffness from the mesh before (-).
    pub change: f64,
    /// The same of the peak strains; zero without.
    pub peak_change: f64,
    /// Unknowns of the last mesh, over its three systems.
    pub unknowns: usize,
}

/// Why a cell cannot be computed.
#[derive(Clone, Debug, PartialEq)]
pub enum CellError {
    /// The section is none.
    Section(SectionError),
    /// A length is not positive and finite: which, and its value (m).
    Length(&'static str, f64),
    /// No isotropic material has this Poisson's ratio, or it is nearly incompressible.
    Poisson(f64),
    /// The radius of the corners is larger than notch or depth allow (m).
    CornerRadius {
        /// Radius (m).
        radius: f64,
        /// Largest possible one (m).
        most: f64,
    },
    /// A radial cut of a rod without a bore.
    RadialRod,
    /// Corner radii in a radial cut of a polygon.
    RadialPolygon,
    /// The elements cannot follow the shape.
    Mesh,
    /// Over these depths the stiffness changes too fast to be tabulated (m).
    Steep {
        /// From this depth.
        from: f64,
        /// To this depth.
        to: f64,
    },
    /// Refinement did not settle: the last relative change (-).
    Unsettled(f64),
}

impl fmt::Display for CellError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Section(error) => error.fmt(f),
            Self::Length(what, value) => {
                write!(f, "the {what} is {:.6} mm; a cell needs a positive length", value * 1e3)
            }
            Self::Poisson(value) => write!(
                f,
                "Poisson's ratio is {value}; finite elements of a cell need one between {LEAST_POISSON} and {MOST_POISSON}"
            ),
            Self::CornerRadius { radius, most } => write!(
                f,
                "corners of {:.6} mm do not fit into the notch; the radius may be up to {:.6} mm",
                radius * 1e3,
                most * 1e3
            ),
            Self::RadialRod => write!(f, "a radial cut needs a tube with a bore; cut a rod along a plane"),
            Self::RadialPolygon => {
                write!(f, "corner radii of a radial cut are known for round tubes only; leave the radius out")
            }
            Self::Mesh => write!(f, "the elements cannot follow this shape; change its smallest length"),
            Self::Steep { from, to } => write!(
                f,
                "between depths of {:.3} and {:.3} mm the stiffness of cells changes too fast to be tabulated; \
                 let the depth vary less, or count teeth as flexible",
                from * 1e3,
                to * 1e3
            ),
            Self::Unsettled(change) => write!(
                f,
                "the stiffness still changes by {:.2} % on the finest mesh; the wall may be too thin for solid elements",
                change * 100.0
            ),
        }
    }
}

impl std::error::Error for CellError {}

const LEAST_POISSON: f64 = -0.9;
const MOST_POISSON: f64 = 0.49;
/// The stiffness has settled when it changes by less than this from mesh to mesh.
const SETTLED: f64 = 0.005;
/// The same for peak strains.
const PEAK_SETTLED: f64 = 0.03;

/// From coarse to fine, in outer radii.
pub(crate) const MESHES: [Fineness; 4] = [
    Fineness { smallest: 0.03, growth: 1.0, largest: 0.6, across: 0.5, layers: 1, arc: 3 },
    Fineness { smallest: 0.008, growth: 0.75, largest: 0.42, across: 0.33, layers: 2, arc: 5 },
    Fineness { smallest: 0.002, growth: 0.55, largest: 0.3, across: 0.22, layers: 3, arc: 8 },
    Fineness { smallest: 0.0005, growth: 0.4, largest: 0.21, across: 0.15, layers: 4, arc: 12 },
];

impl Cell {
    /// Stiffness on the first of a row of finer meshes from which no entry changes by more than 0.5 %, nor a peak strain by more than 3 %.
    ///
    /// # Errors
    /// What describes no cell, and a stiffness that does not settle.
    pub fn stiffness(&self) -> Result<CellStiffness, CellError> {
        self.check()?;
        let mut last: Option<CellStiffness> = None;
        for fineness in &MESHES {
            let mut next = self.on(fineness)?;
            if let Some(last) = &last {
                (next.change, next.peak_change) = changes(last, &next);
                if next.change < SETTLED && next.peak_change < PEAK_SETTLED {
                    return Ok(next);
                }
            }
            last = Some(next);
        }
        let change = last.map_or(f64::NAN, |l| l.change);
        match last {
            // Peaks are stated with their change; the stiffness must have settled.
            Some(last) if change < SETTLED => Ok(last),
            _ => Err(CellError::Unsettled(change)),
        }
    }

    /// Checks that the numbers describe a cell.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn check(&self) -> Result<(), CellError> {
        self.outline.inertia(self.depth).map_err(CellError::Section)?;
        for (what, value, least) in [
            ("length of the notch", self.notch, 0.0),
            ("length of the tooth", self.tooth, 0.0),
            ("depth of the notch", self.depth, f64::MIN_POSITIVE),
            ("length of notch and tooth", self.notch + self.tooth, f64::MIN_POSITIVE),
        ] {
            if !(value.is_finite() && value >= least) {
                return Err(CellError::Length(what, value));
            }
        }
        if !(self.poissons_ratio >= LEAST_POISSON && self.poissons_ratio <= MOST_POISSON) {
            return Err(CellError::Poisson(self.poissons_ratio));
        }
        let rod = self.bore().inradius <= 0.0;
        if self.cut == Cut::Radial && rod {
            return Err(CellError::RadialRod);
        }
        if let Some(radius) = self.corner_radius {
            if self.cut == Cut::Radial && self.bore().sides.is_some() {
                return Err(CellError::RadialPolygon);
            }
            let most = (0.5 * self.notch).min(self.depth);
            if !(radius > 0.0 && radius <= most * (1.0 + 1e-9)) {
                return Err(CellError::CornerRadius { radius, most });
            }
        }
        Ok(())
    }

    /// Solution on one mesh.
    fn on(&self, fineness: &Fineness) -> Result<CellStiffness, CellError> {
        let (mesh, solution) = self.solve(fineness)?;
        let size = self.scale();
        let [axial, coupling, bending, bending_y, twist] = solution.stiffness;
        let offset = -coupling / axial;
        let claims_peak = self.corner_radius.is_some() && self.bore().sides.is_none();
        let peak = claims_peak.then(|| {
            let peak = peak_strain(&mesh, &solution, offset);
            PeakStrain {
                bending_z: peak.bending_z.map(|p| p * size),
                stretch: peak.stretch,
                bending_y: peak.bending_y * size,
                twist: peak.twist * size,
            }
        });
        Ok(CellStiffness {
            axial: axial * size.powi(2),
            centroid_offset: offset * size,
            bending_y: bending_y * size.powi(4),
            bending_z: (bending - coupling * coupling / axial) * size.powi(4),
            torsion: twist * 2.0 * (1.0 + self.poissons_ratio) * size.powi(4),
            mean_area: mesh.mean_area() * size.powi(2),
            peak,
            change: f64::INFINITY,
            peak_change: 0.0,
            unknowns: solution.unknowns,
        })
    }

    pub(crate) fn solve(&self, fineness: &Fineness) -> Result<(Mesh, Solution), CellError> {
        let mesh = self.mesh(fineness);
        let solution = system::solve(&mesh, self.poissons_ratio).ok_or(CellError::Mesh)?;
        Ok((mesh, solution))
    }

    pub(crate) fn mesh(&self, fineness: &Fineness) -> Mesh {
        let size = self.scale();
        let scaled = |c: Contour| Contour { inradius: c.inradius / size, ..c };
        let (outer, bore) = (scaled(self.outer()), scaled(self.bore()));
        let fillet = self.corner_radius.map_or(0.0, |r| r.min(0.5 * self.notch) / size);
        let level = self.depth / size - 1.0;
        let section = match self.cut {
            Cut::Plane => Section::plane(outer, bore, level, fillet),
            Cut::Radial => Section::radial(outer, bore, level),
        };
        let profile =
            Profile { half_notch: 0.5 * self.notch / size, half_tooth: 0.5 * self.tooth / size, fillet };
        Mesh::new(&section, &profile, fineness)
    }

    /// Outer radius or apothem, the unit of length of a solution (m).
    pub(crate) fn scale(&self) -> f64 {
        self.outer().inradius
    }

    fn outer(&self) -> Contour {
        let (sides, inradius) = match self.outline {
            Outline::Round { outer_radius, .. } => (None, outer_radius),
            Outline::Polygon { sides, outer_apothem, .. } => (Some(sides), outer_apothem),
        };
        Contour { sides: sides.map(count), inradius }
    }

    fn bore(&self) -> Contour {
        let (sides, inradius) = match self.outline {
            Outline::Round { inner_radius, .. } => (None, inner_radius),
            Outline::Polygon { sides, inner_apothem, .. } => (Some(sides), inner_apothem),
        };
        Contour { sides: sides.map(count), inradius }
    }
}

fn count(sides: usize) -> u32 {
    u32::try_from(sides).unwrap_or(u32::MAX)
}

/// Largest relative changes of stiffness and of peak strains.
fn changes(a: &CellStiffness, b: &CellStiffness) -> (f64, f64) {
    let relative = |a: f64, b: f64| ((a - b) / b).abs();
    let stiffness = [
        relative(a.axial, b.axial),
        relative(a.bending_y, b.bending_y),
        relative(a.bending_z, b.bending_z),
        relative(a.torsion, b.torsion),
    ];
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let peaks = match (&a.peak, &b.peak) {
        (Some(a), Some(b)) => [
            relative(a.bending_z[0], b.bending_z[0]),
            relative(a.bending_z[1], b.bending_z[1]),
            relative(a.stretch[0], b.stretch[0]),
            relative(a.bending_y, b.bending_y),
            relative(a.twist, b.twist),
        ],
        _ => [0.0; 5],
    };
    (largest(&stiffness), largest(&peaks))
}
