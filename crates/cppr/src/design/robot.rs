//! The robot: coaxial tubes of common rest length, joined at the tip, tube 1 clamped in the baseplate.

use super::fibre::TubeFibres;
use super::fields::{FieldValues, Fields, Part};
use super::{
    BelowPlate, CellFactors, NotchedTube, Outline, Profile, SectionError, StiffnessTube, Torsion, TubeDesign,
};
use crate::real::Real;
use std::array::from_fn;
use std::f64::consts::PI;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Cells of the field tables along [0, L]; the spline error is far below the discretisation's.
const TABLE_CELLS: u16 = 256;
/// Parts of a cell at whose ends its fields are looked at where a spline may leave their range.
const INSIDE: u16 = 8;
/// Depths at which the torsion constant is solved for, between the least and the greatest depth.
const TORSION_SAMPLES: u8 = 16;
/// Part of the wall on both sides of the depth at which the ring opens that is not interpolated.
const NEAR_OPENING: f64 = 0.1;

/// A robot as designed: plain data, unchecked. [`Robot::from_design`] checks it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RobotDesign {
    /// Name, for people.
    pub name: String,
    /// Rest length L of every tube above the baseplate (m).
    pub length: f64,
    /// The tubes; the first is the leader, the others are its followers, numbered from 2 as in the paper.
    pub tubes: Vec<TubeDesign>,
}

/// What is wrong with a design. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum DesignProblem {
    /// The length is not a positive finite number (m).
    Length(f64),
    /// There is no tube.
    NoTube,
    /// A section of a tube cannot be built.
    Section {
        /// Tube number.
        tube: usize,
        /// Rest abscissa (m).
        x: f64,
        /// What is wrong.
        error: SectionError,
    },
    /// A field of a tube is not finite or has the wrong sign.
    Field {
        /// Tube number.
        tube: usize,
        /// Name of the field.
        field: &'static str,
        /// Rest abscissa (m).
        x: f64,
        /// Its value there (SI).
        value: f64,
    },
    /// A follower does not fit into the bore of the tube around it.
    TooWide {
        /// Tube number.
        tube: usize,
        /// Greatest outer reach of the tube (m).
        reach: f64,
        /// Radius of the bore that it slides in (m).
        bore: f64,
    },
    /// A joint cannot be.
    Joint {
        /// Joint number.
        joint: usize,
        /// What is wrong.
        problem: JointProblem,
    },
}

/// What is wrong with a joint. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum JointProblem {
    /// It bonds fewer than two tubes.
    TooFew,
    /// There is no tube of this number.
    NoSuchTube(usize),
    /// A tube is named twice.
    Twice(usize),
    /// The label does not lie on the tube.
    Outside {
        /// Tube number.
        tube: usize,
        /// Label (m).
        label: f64,
        /// Length of the tube (m).
        length: f64,
    },
}

impl fmt::Display for JointProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew => write!(f, "it bonds fewer than two tubes"),
            Self::NoSuchTube(tube) => write!(f, "there is no tube {tube}"),
            Self::Twice(tube) => write!(f, "tube {tube} is named twice"),
            Self::Outside { tube, label, length } => write!(
                f,
                "it bonds tube {tube} at {:.3} mm, but the tube reaches from 0 to {:.3} mm",
                label * 1e3,
                length * 1e3
            ),
        }
    }
}

impl fmt::Display for DesignProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(value) => write!(f, "the length is {value} m; it must be a positive number"),
            Self::NoTube => write!(f, "the robot has no tube; give at least the leader"),
            Self::Section { tube, x, error } => write!(f, "tube {tube} at x = {:.3} mm: {error}", x * 1e3),
            Self::Field { tube, field, x, value } => {
                write!(f, "tube {tube} at x = {:.3} mm: {field} is {value}, which cannot be", x * 1e3)
            }
            Self::TooWide { tube, reach, bore } => write!(
                f,
                "tube {tube} reaches {:.3} mm from its axis, but the bore it slides in has a radius of {:.3} mm",
                reach * 1e3,
                bore * 1e3
            ),
            Self::Joint { joint, problem } => write!(f, "joint {joint}: {problem}"),
        }
    }
}

impl std::error::Error for DesignProblem {}

/// All that is wrong with a design, in the order of its tubes.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignProblems(pub Vec<DesignProblem>);

impl fmt::Display for DesignProblems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.0.iter().enumerate() {
            let separator = if i > 0 { "; " } else { "" };
            write!(f, "{separator}{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for DesignProblems {}

/// A checked robot with the material fields of its tubes. Immutable; a clone shares them.
#[derive(Clone, Debug)]
pub struct Robot {
    built: Arc<Built>,
}

#[derive(Debug)]
struct Built {
    design: RobotDesign,
    fields: Vec<Fields>,
    /// Per tube: its notches, where its geometry is known.
    fibres: Vec<Option<TubeFibres>>,
    serial: u64,
    is_planar: bool,
    bending: f64,
}

/// Serial number of the robot built next.
static NEXT_SERIAL: AtomicU64 = AtomicU64::new(1);

impl Robot {
    /// Checks a design and tabulates its fields.
    ///
    /// # Errors
    /// All problems of the design, not only the first.
    pub fn from_design(design: RobotDesign) -> Result<Self, DesignProblems> {
        let mut problems = Vec::new();
        if !(design.length.is_finite() && design.length > 0.0) {
            return Err(DesignProblems(vec![DesignProblem::Length(design.length)]));
        }
        if design.tubes.is_empty() {
            problems.push(DesignProblem::NoTube);
        }
        check_nesting(&design.tubes, &mut problems);
        let mut fields = Vec::new();
        for (index, tube) in design.tubes.iter().enumerate() {
            match tabulate(index + 1, tube, design.length) {
                Ok(table) => fields.push(table),
                Err(mut found) => problems.append(&mut found),
            }
        }
        if !problems.is_empty() {
            return Err(DesignProblems(problems));
        }
        let is_planar = is_planar(design.length, &fields);
        let bending = fields.iter().map(|f| f.values(0.5 * design.length).bending_z).sum();
        let fibres = design.tubes.iter().map(|tube| match tube {
            TubeDesign::Notched(tube) => Some(TubeFibres::of(tube, design.length)),
            TubeDesign::Stiffness(_) => None,
        });
        let fibres = fibres.collect();
        let serial = NEXT_SERIAL.fetch_add(1, Ordering::Relaxed);
        Ok(Self { built: Arc::new(Built { design, fields, fibres, serial, is_planar, bending }) })
    }

    /// The design it was built from.
    #[must_use]
    pub fn design(&self) -> &RobotDesign {
        &self.built.design
    }

    /// Does a pull of a follower (0 is the first) bend the robot? Not where its centroid and the leader's lie on the axis all along,
    /// as in tubes without notches: without stretch it cannot be pulled at all.
    #[must_use]
    pub fn has_lever(&self, follower: usize) -> bool {
        let off_axis = |tube: usize| self.fields().get(tube).is_some_and(Fields::is_off_axis);
        off_axis(0) || off_axis(follower + 1)
    }

    /// Tubes (from 1) whose row of notches ends more than a cell before the tip, and where (m): beyond, the mechanics takes them as
    /// notched too, since depths and directions are spread evenly.
    #[must_use]
    pub fn ends_of_patterns(&self) -> Vec<(usize, f64)> {
        let end = |(tube, number): (&TubeDesign, usize)| match tube {
            TubeDesign::Notched(NotchedTube { pattern: Some(pattern), depth, .. }) => {
                let (end, length) = (f64::from(pattern.count) * pattern.pitch(), self.length());
                let cut_beyond = depth.eval(0.5 * (end + length), length)[0] > 0.0;
                (end + pattern.pitch() < length && cut_beyond).then_some((number, end))
            }
            _ => None,
        };
        self.design().tubes.iter().zip(1..).filter_map(end).collect()
    }

    /// Radial gap (m) between every tube and the one inside it, from outside to inside; `None` where a tube is given by its stiffness.
    #[must_use]
    pub fn gaps(&self) -> Vec<Option<f64>> {
        self.design().tubes.windows(2).map(|pair| gap(&pair[0], &pair[1])).collect()
    }

    /// Rest length L (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.built.design.length
    }

    /// Number of tubes N.
    #[must_use]
    pub fn tube_count(&self) -> usize {
        self.built.fields.len()
    }

    /// Number of followers N − 1.
    #[must_use]
    pub fn follower_count(&self) -> usize {
        self.built.fields.len() - 1
    }

    /// Fields of a tube (index 0 is the leader) at rest abscissa x ≤ L (m); x < 0 is below the plate.
    #[must_use]
    pub fn fields_at(&self, tube: usize, x: f64) -> FieldValues {
        self.built.fields[tube].values(x)
    }

    /// True where every tube has an axial stiffness, so that stretch can be computed.
    #[must_use]
    pub fn has_axial_stiffness(&self) -> bool {
        self.built.fields.iter().all(Fields::has_axial)
    }

    /// True where any part of a tube has mass, so that gravity acts on the robot.
    #[must_use]
    pub fn has_mass(&self) -> bool {
        self.built.fields.iter().any(Fields::has_mass)
    }

    /// Tube numbers of the followers: 2 to N.
    #[must_use]
    pub fn followers(&self) -> std::ops::RangeInclusive<usize> {
        2..=self.tube_count()
    }

    /// True where all centroid lines at rest lie in the X–Y plane.
    #[must_use]
    pub fn is_planar(&self) -> bool {
        self.built.is_planar
    }

    /// Fields of every tube, the leader first.
    #[inline]
    pub(crate) fn fields(&self) -> &[Fields] {
        &self.built.fields
    }

    /// Notches of every tube whose geometry is known.
    pub(crate) fn fibres(&self) -> &[Option<TubeFibres>] {
        &self.built.fibres
    }

    /// Serial number, shared by the clones of one robot and by nothing else.
    #[inline]
    pub(crate) fn serial(&self) -> u64 {
        self.built.serial
    }

    /// Σ EI_Z at the middle of the robot (N m²): its scale of stiffness.
    #[inline]
    pub(crate) fn bending(&self) -> f64 {
        self.built.bending
    }

    /// θ_k at rest and its first three derivatives at label X: π − (φ_k − φ_1).
    #[inline]
    pub(crate) fn rest_angle<S: Real>(&self, follower: usize, label: S) -> [S; 4] {
        let own = self.built.fields[follower].direction(label, Part::Pattern);
        let leader = self.built.fields[0].direction(label, Part::Pattern);
        let mut angle = from_fn(|i| leader[i] - own[i]);
        angle[0] = angle[0] + PI;
        angle
    }
}

fn is_planar(length: f64, fields: &[Fields]) -> bool {
    fields.iter().all(|f| {
        (0..=16).all(|i| {
            let x = length * f64::from(i) / 16.0;
            f.direction(x, Part::Pattern)[0].sin().abs() < 1e-12 || f.offset(x, Part::Pattern)[0] < 1e-15
        })
    })
}

/// The outline a tube slides with, where its geometry is known.
fn outline(tube: &TubeDesign) -> Option<&Outline> {
    match tube {
        TubeDesign::Notched(t) => Some(&t.outline),
        TubeDesign::Stiffness(_) => None,
    }
}

fn check_nesting(tubes: &[TubeDesign], problems: &mut Vec<DesignProblem>) {
    for (index, pair) in tubes.windows(2).enumerate() {
        if let Some((reach, bore)) = misfit(&pair[0], &pair[1]) {
            problems.push(DesignProblem::TooWide { tube: index + 2, reach, bore });
        }
    }
}

/// Reach of the inner tube and bore of the outer one (m), where the one does not fit into the other.
pub(crate) fn misfit(outer: &TubeDesign, inner: &TubeDesign) -> Option<(f64, f64)> {
    fit(outer, inner).filter(|(reach, bore)| reach > bore)
}

/// Radial gap (m) that is left between two tubes, where the radii of both are known.
pub(crate) fn gap(outer: &TubeDesign, inner: &TubeDesign) -> Option<f64> {
    fit(outer, inner).map(|(reach, bore)| bore - reach)
}

/// Reach of the inner tube and bore of the outer one (m), where both are known.
fn fit(outer: &TubeDesign, inner: &TubeDesign) -> Option<(f64, f64)> {
    let (outer, inner) = (outline(outer)?, outline(inner)?);
    Some(match (inner, outer) {
        // Alike polygons slide flat on flat.
        (
            Outline::Polygon { sides, outer_apothem, .. },
            Outline::Polygon { sides: around, inner_apothem, .. },
        ) if sides == around => (*outer_apothem, *inner_apothem),
        _ => (inner.outer_reach(), outer.inner_clearance()),
    })
}

fn tabulate(number: usize, tube: &TubeDesign, length: f64) -> Result<Fields, Vec<DesignProblem>> {
    let abscissae: Vec<f64> =
        (0..=TABLE_CELLS).map(|i| length * f64::from(i) / f64::from(TABLE_CELLS)).collect();
    let (samples, below, twist) = match tube {
        TubeDesign::Notched(t) => sample_notched(number, t, length, &abscissae)?,
        TubeDesign::Stiffness(t) => sample_stiffness(t, length, &abscissae),
    };
    let mut problems = Vec::new();
    for (x, values) in abscissae.iter().zip(&samples).chain([(&-f64::EPSILON, &below)]) {
        let FieldValues { centroid_offset, bending_y, bending_z, torsion, axial, mass_per_length, direction } =
            *values;
        for (field, value, ok) in [
            ("the centroid offset", centroid_offset, centroid_offset >= 0.0),
            ("the bending stiffness EI_Y", bending_y, bending_y > 0.0),
            ("the bending stiffness EI_Z", bending_z, bending_z > 0.0),
            ("the torsional stiffness", torsion, torsion > 0.0),
            ("the axial stiffness", axial, axial.is_nan() || axial > 0.0),
            ("the mass per length", mass_per_length, mass_per_length >= 0.0),
            ("the direction", direction, direction.is_finite()),
        ] {
            if !ok || value.is_infinite() {
                problems.push(DesignProblem::Field { tube: number, field, x: *x, value });
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
    }
    let mut fields = Fields::new(length, &samples, below, twist);
    for cell in fields.overshooting() {
        let (from, to) = (abscissae[cell], abscissae[cell + 1]);
        let inside: Vec<f64> =
            (0..=INSIDE).map(|i| from + (to - from) * f64::from(i) / f64::from(INSIDE)).collect();
        let samples = match tube {
            TubeDesign::Notched(t) => sample_notched(number, t, length, &inside)?.0,
            TubeDesign::Stiffness(t) => sample_stiffness(t, length, &inside).0,
        };
        fields.keep_within(cell, &samples);
    }
    Ok(fields)
}

type Samples = (Vec<FieldValues>, FieldValues, f64);

fn sample_notched(
    number: usize,
    tube: &NotchedTube,
    length: f64,
    abscissae: &[f64],
) -> Result<Samples, Vec<DesignProblem>> {
    let depths: Vec<f64> = abscissae.iter().map(|&x| tube.depth.eval(x, length)[0]).collect();
    let directions: Vec<f64> = abscissae.iter().map(|&x| tube.direction.eval(x, length)[0]).collect();
    let at = |x: f64| move |error| vec![DesignProblem::Section { tube: number, x, error }];
    if tube.is_nonlinear() {
        return Err(at(0.0)(SectionError::NotLinear));
    }
    let Material { e, g, mu } = Material::of(tube);
    let constant = torsion_constants(tube, &depths).map_err(at(0.0))?;
    let mut samples = Vec::with_capacity(abscissae.len());
    for (i, &x) in abscissae.iter().enumerate() {
        let inertia = tube.outline.inertia(depths[i]).map_err(at(x))?;
        let cell = tube.cell_factors(depths[i]).map_err(SectionError::Cells).map_err(at(x))?;
        let by = |factor: fn(&CellFactors) -> f64| cell.as_ref().map_or(1.0, factor);
        let torsion = match &tube.torsion {
            Torsion::SaintVenant => g * constant[i] * by(|c| c.torsion),
            Torsion::Polar => g * inertia.polar_about_centre,
            Torsion::Given(profile) => profile.eval(x, length)[0],
        };
        samples.push(FieldValues {
            centroid_offset: tube.centroid_offset_factor
                * inertia.centroid_offset
                * by(|c| c.centroid_offset),
            bending_y: e * inertia.inertia_y * by(|c| c.bending_y),
            bending_z: e * inertia.inertia_z * by(|c| c.bending_z),
            torsion,
            axial: e * inertia.area * by(|c| c.axial),
            mass_per_length: mu * inertia.area * by(|c| c.mass),
            direction: directions[i],
        });
    }
    let base = samples.first().copied().unwrap_or_default();
    let [_, twist, _] = tube.direction.eval(0.0, length);
    match tube.below {
        BelowPlate::Continued => Ok((samples, base, twist)),
        BelowPlate::Plain => {
            let plain = tube.outline.plain().map_err(at(0.0))?;
            let below = FieldValues {
                centroid_offset: 0.0,
                bending_y: e * plain.inertia_y,
                bending_z: e * plain.inertia_z,
                torsion: g * plain.torsion_constant,
                axial: e * plain.area,
                mass_per_length: mu * plain.area,
                direction: base.direction,
            };
            Ok((samples, below, 0.0))
        }
    }
}

/// E, G and density of a notched tube under the letters of the paper.
struct Material {
    e: f64,
    g: f64,
    mu: f64,
}

impl Material {
    fn of(tube: &NotchedTube) -> Self {
        let m = &tube.material;
        Self { e: m.youngs_modulus, g: m.shear_modulus(), mu: m.density }
    }
}

/// Saint-Venant constants at the given depths. Each costs the solution of a boundary-value problem, so
/// they are interpolated between Chebyshev points of the depth on ranges where the constant is smooth: it has kinks where the
/// notch passes the bore, and falls like a square root just before the ring opens, where every depth is solved for.
fn torsion_constants(tube: &NotchedTube, depths: &[f64]) -> Result<Vec<f64>, SectionError> {
    if tube.torsion != Torsion::SaintVenant {
        return Ok(vec![0.0; depths.len()]);
    }
    let solve = |depth: f64| tube.outline.notched(depth).map(|s| s.torsion_constant);
    let (opening, passing) = (tube.outline.opening_depth(), tube.outline.passing_depth());
    let near = NEAR_OPENING * opening;
    let range =
        |depth: f64| [0.0, opening - near, opening + near, passing].iter().filter(|&&b| depth > b).count();
    let mut constants = vec![0.0; depths.len()];
    for part in 0..=4 {
        let own: Vec<usize> = (0..depths.len()).filter(|&i| range(depths[i]) == part).collect();
        let bounds = |f: fn(f64, f64) -> f64, start: f64| own.iter().map(|&i| depths[i]).fold(start, f);
        let (least, greatest) = (bounds(f64::min, f64::INFINITY), bounds(f64::max, f64::NEG_INFINITY));
        if part == 2 || own.len() <= usize::from(TORSION_SAMPLES) {
            let mut last = (f64::NAN, 0.0);
            for i in own {
                if (depths[i] - last.0).abs() > 0.0 || last.0.is_nan() {
                    last = (depths[i], solve(depths[i])?);
                }
                constants[i] = last.1;
            }
        } else if greatest - least <= 1e-12 * greatest.abs() {
            let value = solve(greatest)?;
            for i in own {
                constants[i] = value;
            }
        } else {
            let nodes = chebyshev(least, greatest, &solve)?;
            for i in own {
                constants[i] = barycentric(&nodes, depths[i]);
            }
        }
    }
    Ok(constants)
}

/// Samples at Chebyshev points of the second kind.
pub(crate) fn chebyshev(
    least: f64,
    greatest: f64,
    solve: &impl Fn(f64) -> Result<f64, SectionError>,
) -> Result<Vec<(f64, f64)>, SectionError> {
    let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
    (0..=TORSION_SAMPLES)
        .map(|i| {
            let angle = PI * f64::from(i) / f64::from(TORSION_SAMPLES);
            let depth = (middle + half * angle.cos()).clamp(least, greatest);
            solve(depth).map(|value| (depth, value))
        })
        .collect()
}

/// Value at `at` of the polynomial through Chebyshev points of the second kind.
pub(crate) fn barycentric(nodes: &[(f64, f64)], at: f64) -> f64 {
    let last = nodes.len() - 1;
    let (mut above, mut below) = (0.0, 0.0);
    for (i, &(node, value)) in nodes.iter().enumerate() {
        let distance = at - node;
        if distance.abs() <= f64::EPSILON * at.abs() {
            return value;
        }
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let weight = sign * if i == 0 || i == last { 0.5 } else { 1.0 } / distance;
        above += weight * value;
        below += weight;
    }
    above / below
}

fn sample_stiffness(tube: &StiffnessTube, length: f64, abscissae: &[f64]) -> Samples {
    let value = |profile: &Profile, x: f64| profile.eval(x, length)[0];
    let samples: Vec<FieldValues> = abscissae
        .iter()
        .map(|&x| FieldValues {
            centroid_offset: tube.centroid_offset_factor * value(&tube.centroid_offset, x),
            bending_y: value(&tube.bending_y, x),
            bending_z: value(&tube.bending_z, x),
            torsion: value(&tube.torsion, x),
            axial: tube.axial.as_ref().map_or(f64::NAN, |p| value(p, x)),
            mass_per_length: value(&tube.mass_per_length, x),
            direction: value(&tube.direction, x),
        })
        .collect();
    let below = samples.first().copied().unwrap_or_default();
    let [_, twist, _] = tube.direction.eval(0.0, length);
    (samples, below, twist)
}
