//! Material fields of one tube along its rest abscissa x (m), tabulated once per robot.
//!
//! Between x = 0 and x = L every field is a C² cubic spline through its sampled design values, whose slopes are limited where it would leave the
//! range of what it interpolates; a uniform tube keeps constants. Below the plate (x < 0) the fields are constants and the direction is linear.
//! The tables give value and exact derivatives of one and the same function, so that the tangent of the
//! equilibrium is the derivative of its residual to rounding.

use super::spline::CubicSpline;
use crate::real::Real;
use std::array::from_fn;
use std::collections::BTreeSet;

/// Value, first and second derivative with respect to x.
pub(crate) type Jet<S = f64> = [S; 3];

/// The fields of a tube at one abscissa, with derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FieldJets<S = f64> {
    /// D (m), scaled by the centroid offset factor.
    pub offset: Jet<S>,
    /// EI_Y (N m²).
    pub bending_y: Jet<S>,
    /// EI_Z (N m²).
    pub bending_z: Jet<S>,
    /// GJ about the tube's centre (N m²).
    pub torsion: Jet<S>,
    /// EA (N).
    pub axial: Jet<S>,
    /// Mass per length (kg/m).
    pub mass: Jet<S>,
    /// φ (rad) and its first three derivatives.
    pub direction: [S; 4],
}

/// Sampled values of the fields at one abscissa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldValues {
    /// Centroid offset D (m), scaled by the centroid offset factor.
    pub centroid_offset: f64,
    /// Bending stiffness EI_Y about the axis along the centroid direction (N m²).
    pub bending_y: f64,
    /// Bending stiffness EI_Z about the axis normal to the centroid direction (N m²).
    pub bending_z: f64,
    /// Torsional stiffness GJ about the tube's centre (N m²).
    pub torsion: f64,
    /// Axial stiffness EA (N); NaN where the design does not give it.
    pub axial: f64,
    /// Mass per length (kg/m).
    pub mass_per_length: f64,
    /// Direction φ of the centroid (rad).
    pub direction: f64,
}

impl FieldValues {
    /// The six fields that become splines, in table order; the direction is kept apart.
    fn tabulated(&self) -> [f64; 6] {
        let Self { centroid_offset, bending_y, bending_z, torsion, axial, mass_per_length, direction: _ } =
            *self;
        [centroid_offset, bending_y, bending_z, torsion, axial, mass_per_length]
    }
}

/// The part of a tube that faces a section of the leader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// 0 ≤ x ≤ L: the pattern.
    Pattern,
    /// x < 0: what comes up from below the plate.
    Below,
}

/// Tabulated fields of one tube.
#[derive(Clone, Debug)]
pub(crate) struct Fields {
    length: f64,
    /// Splines of the six fields over [0, L]; empty for a tube whose six fields are uniform.
    splines: Vec<CubicSpline>,
    direction: CubicSpline,
    /// Values at x = 0, used where the splines are absent or left of their range.
    base: FieldValues,
    below: FieldValues,
    /// Slope of φ below the plate (rad/m).
    below_twist: f64,
    has_axial: bool,
    has_mass: bool,
    off_axis: bool,
}

impl Fields {
    /// Tabulates `samples` taken at equal steps over [0, L]; `below` and `below_twist` describe x < 0.
    pub fn new(length: f64, samples: &[FieldValues], below: FieldValues, below_twist: f64) -> Self {
        let base = samples.first().copied().unwrap_or_default();
        let has_axial = samples.iter().chain([&below]).all(|s| s.axial.is_finite());
        let off_axis = samples.iter().any(|s| s.centroid_offset > 0.0);
        let tabulated: Vec<[f64; 6]> = samples.iter().map(FieldValues::tabulated).collect();
        let uniform = tabulated.iter().all(|row| {
            row.iter()
                .zip(base.tabulated())
                .all(|(a, b)| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs() || b.is_nan())
        });
        let splines = if uniform {
            Vec::new()
        } else {
            (0..6)
                .map(|f| {
                    CubicSpline::uniform(length, &tabulated.iter().map(|row| row[f]).collect::<Vec<_>>())
                })
                .collect()
        };
        let direction =
            CubicSpline::uniform(length, &samples.iter().map(|s| s.direction).collect::<Vec<_>>());
        let has_mass = samples.iter().chain([&below]).any(|s| s.mass_per_length > 0.0);
        Self { length, splines, direction, base, below, below_twist, has_axial, has_mass, off_axis }
    }

    /// Cells of the tables in which a field goes beyond its samples at both ends; none where the fields are uniform.
    pub fn overshooting(&self) -> Vec<usize> {
        let all = self.splines.iter().chain([&self.direction]);
        let cells: BTreeSet<usize> = all.flat_map(CubicSpline::overshooting).collect();
        cells.into_iter().collect()
    }

    /// Keeps all fields of a cell within those of some samples from it, its ends among them.
    pub fn keep_within(&mut self, cell: usize, samples: &[FieldValues]) {
        let range = |value: &dyn Fn(&FieldValues) -> f64| {
            samples
                .iter()
                .map(value)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        for (which, spline) in self.splines.iter_mut().enumerate() {
            spline.keep_within(cell, range(&|sample| sample.tabulated()[which]));
        }
        self.direction.keep_within(cell, range(&|sample| sample.direction));
    }

    /// True where any part of the tube weighs something.
    pub fn has_mass(&self) -> bool {
        self.has_mass
    }

    /// True where the centroid leaves the axis somewhere between the plate and the tip.
    pub fn is_off_axis(&self) -> bool {
        self.off_axis
    }

    /// True where every section of the tube knows its axial stiffness.
    pub fn has_axial(&self) -> bool {
        self.has_axial
    }

    /// True where the fields run smoothly through x = 0, so that no edge moves with the robot.
    pub fn smooth_at_plate(&self) -> bool {
        let same = self
            .base
            .tabulated()
            .iter()
            .zip(self.below.tabulated())
            .all(|(a, b)| (a - b).abs() <= 1e-12 * a.abs() || (a.is_nan() && b.is_nan()));
        let [_, slope, curvature, _] = self.direction.eval(0.0);
        let straight = (slope - self.below_twist).abs() * self.length <= 1e-9
            && curvature.abs() * self.length * self.length <= 1e-9;
        same && straight && self.splines.is_empty()
    }

    /// True where the fields of a part are the same everywhere, the direction apart, which does not turn.
    pub fn is_constant(&self, part: Part) -> bool {
        match part {
            Part::Below => self.below_twist == 0.0,
            Part::Pattern => {
                self.splines.is_empty()
                    && self.direction.is_linear()
                    && self.direction.eval(0.0)[1].abs() * self.length <= f64::EPSILON
            }
        }
    }

    /// φ (rad) and its derivatives on the given part.
    #[inline]
    pub fn direction<S: Real>(&self, x: S, part: Part) -> [S; 4] {
        match part {
            Part::Below => {
                let twist = self.below_twist;
                [x * twist + self.below.direction, S::splat(twist), S::zero(), S::zero()]
            }
            Part::Pattern if x.mask(|x| x < 0.0) != 0 => {
                let [value, slope, ..] = self.direction.eval(0.0);
                let inside = self.direction.eval(x);
                let line = [x * slope + value, S::splat(slope), S::zero(), S::zero()];
                from_fn(|k| {
                    S::from_lanes(|l| if x.lane(l) < 0.0 { line[k].lane(l) } else { inside[k].lane(l) })
                })
            }
            Part::Pattern => self.direction.eval(x),
        }
    }

    /// One of the splines at x. Left of its range the pattern is held at its value at x = 0.
    #[inline]
    fn tabulated<S: Real>(&self, which: usize, x: S) -> Jet<S> {
        let [v, d, dd, _] = self.splines[which].eval(x);
        if x.mask(|x| x < 0.0) == 0 {
            return [v, d, dd];
        }
        let base = self.base.tabulated()[which];
        let inside = |l: usize| x.lane(l) >= 0.0;
        let zero_below = |value: S| S::from_lanes(|l| if inside(l) { value.lane(l) } else { 0.0 });
        [S::from_lanes(|l| if inside(l) { v.lane(l) } else { base }), zero_below(d), zero_below(dd)]
    }

    /// D and its derivatives on the given part.
    #[inline]
    pub fn offset<S: Real>(&self, x: S, part: Part) -> Jet<S> {
        let constant = |value: f64| [S::splat(value), S::zero(), S::zero()];
        match part {
            Part::Below => constant(self.below.centroid_offset),
            Part::Pattern if self.splines.is_empty() => constant(self.base.centroid_offset),
            Part::Pattern => self.tabulated(0, x),
        }
    }

    /// All fields at x on the given part.
    #[inline]
    pub fn jets<S: Real>(&self, x: S, part: Part) -> FieldJets<S> {
        let direction = self.direction(x, part);
        let constant =
            |values: &FieldValues| values.tabulated().map(|value| [S::splat(value), S::zero(), S::zero()]);
        let [offset, bending_y, bending_z, torsion, axial, mass] = match part {
            Part::Below => constant(&self.below),
            Part::Pattern if self.splines.is_empty() => constant(&self.base),
            Part::Pattern => from_fn(|which| self.tabulated(which, x)),
        };
        FieldJets { offset, bending_y, bending_z, torsion, axial, mass, direction }
    }

    /// Field values at x ≤ L; the part follows from the sign of x.
    pub fn values(&self, x: f64) -> FieldValues {
        let part = if x < 0.0 { Part::Below } else { Part::Pattern };
        let jets = self.jets(x, part);
        FieldValues {
            centroid_offset: jets.offset[0],
            bending_y: jets.bending_y[0],
            bending_z: jets.bending_z[0],
            torsion: jets.torsion[0],
            axial: jets.axial[0],
            mass_per_length: jets.mass[0],
            direction: jets.direction[0],
        }
    }
}
