//! Material fields of one tube along its axis label x (m): pieces on which they are smooth.
//!
//! On a piece every field is a constant or a Chebyshev series, fitted to the design until its last coefficients vanish beside
//! the largest; where they do not, the piece is halved. So a series never leaves the range of what it interpolates by more than
//! the tolerance of the fit, and a step of the design stays a step: it lies between two pieces.

use crate::design::metal::Metal;
use std::array::from_fn;
use std::f64::consts::PI;
use std::sync::Arc;

/// How many fields a tube has besides its direction.
pub(crate) const FIELDS: usize = 8;

/// The fields of a tube at one label.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// Centroid offset D (m).
    pub centroid_offset: f64,
    /// Bending stiffness EI_Y about the section axis towards the centroid (N m²).
    pub bending_y: f64,
    /// Bending stiffness EI_Z about the section axis across it (N m²).
    pub bending_z: f64,
    /// Torsional stiffness GJ about the tube's centre (N m²).
    pub torsion: f64,
    /// Axial stiffness EA (N); NaN where it is not known.
    pub axial: f64,
    /// Mass per axis length (kg/m).
    pub mass_per_length: f64,
    /// Curvature of the free tube's axis about its section axes Y and Z (1/m).
    pub rest_curvature: [f64; 2],
    /// Direction φ of the centroid (rad).
    pub direction: f64,
}

impl Values {
    pub(crate) fn table(&self) -> [f64; FIELDS] {
        let [y, z] = self.rest_curvature;
        [
            self.centroid_offset,
            self.bending_y,
            self.bending_z,
            self.torsion,
            self.axial,
            self.mass_per_length,
            y,
            z,
        ]
    }
}

/// One smooth stretch of a tube: labels from the end of the piece before to `to`.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Label where it ends (m).
    pub to: f64,
    /// Do the fields jump at its end?
    pub jumps: bool,
    /// Values where all fields but the direction are constant.
    pub uniform: Option<[f64; FIELDS]>,
    /// φ and its rate at label `from` where φ is linear.
    linear: Option<[f64; 2]>,
    from: f64,
    series: Vec<Series>,
    /// Where the section is not linear; such a piece is uniform.
    pub metal: Option<Arc<Metal>>,
}

/// Chebyshev series of one field over [from, to] of its piece.
type Series = Vec<f64>;

/// Degree of the longest series.
const MOST_TERMS: usize = 13;
/// Size of the last coefficients beside the largest at which a series is accepted.
const FIT: f64 = 1e-10;
/// Relative difference up to which fields of neighbouring pieces are the same.
const CONTINUOUS: f64 = 1e-7;
/// Part of a piece's length up to which its series holds beyond its ends.
const MARGIN: f64 = 0.05;
/// Shortest piece as a part of the whole range; halving ends there.
const SHORTEST: f64 = 1e-4;

impl Piece {
    /// Pieces over [from, to] (m) of fields that are smooth there, of a tube of the given length (m).
    pub fn fit(from: f64, to: f64, length: f64, field: &dyn Fn(f64) -> Values) -> Vec<Self> {
        let mut pieces = Vec::new();
        fit_into(&mut pieces, from, to, SHORTEST * length, field);
        if let Some(last) = pieces.last_mut() {
            last.jumps = true;
        }
        pieces
    }

    /// The piece that goes on below label `to` as this one begins: constant fields, φ with the slope that it has there.
    pub fn before(&self, to: f64) -> Self {
        let [direction, twist, _] = self.direction(to);
        Self {
            to,
            jumps: true,
            uniform: Some(self.table_at(to)),
            linear: Some([direction, twist]),
            from: to,
            series: Vec::new(),
            metal: self.metal.clone(),
        }
    }

    /// Takes a part of its rest curvature.
    pub fn curve_less(&mut self, part: f64) {
        for which in [FIELDS - 2, FIELDS - 1] {
            if let Some(values) = &mut self.uniform {
                values[which] *= part;
            }
            for coefficient in self.series.get_mut(which).into_iter().flatten() {
                *coefficient *= part;
            }
        }
    }

    /// All fields but the direction at x.
    pub fn table_at(&self, x: f64) -> [f64; FIELDS] {
        from_fn(|f| self.field(f, x)[0])
    }

    /// Places all over the piece (m).
    pub fn samples(&self) -> impl Iterator<Item = f64> + use<> {
        let (from, to) = (self.from, self.to);
        (0..=8).map(move |i| from + (to - from) * f64::from(i) / 8.0)
    }

    /// Do all fields run on into those of the next piece without a jump?
    pub fn meets(&self, next: &Self) -> bool {
        let x = self.to;
        let same = |a: f64, b: f64, size: f64| (a - b).abs() <= CONTINUOUS * size || a.is_nan() && b.is_nan();
        let fields = (0..FIELDS).all(|f| {
            let (a, b) = (self.field(f, x)[0], next.field(f, x)[0]);
            same(a, b, a.abs().max(b.abs()))
        });
        fields && same(self.direction(x)[0], next.direction(x)[0], 1.0)
    }

    /// Are both pieces one uniform stretch?
    pub fn continues(&self, next: &Self) -> bool {
        self.uniform.is_some()
            && next.uniform.is_some()
            && self
                .linear
                .zip(next.linear)
                .is_some_and(|(a, b)| (a[1] - b[1]).abs() <= CONTINUOUS * a[1].abs())
            && self.meets(next)
    }

    /// φ with its first and second slope at x.
    #[inline]
    pub fn direction(&self, x: f64) -> [f64; 3] {
        match self.linear {
            Some([at, rate]) => [at + rate * (x - self.from), rate, 0.0],
            None => self.series_at(FIELDS, x),
        }
    }

    /// True where φ is constant.
    pub fn is_straight(&self) -> bool {
        self.linear.is_some_and(|[_, rate]| rate.abs() <= 0.0)
    }

    /// Field number `which` with its first and second slope at x.
    #[inline]
    pub fn field(&self, which: usize, x: f64) -> [f64; 3] {
        match &self.uniform {
            Some(values) => [values[which], 0.0, 0.0],
            None => self.series_at(which, x),
        }
    }

    /// All fields but the direction with their slopes at x; `None` where they are uniform.
    pub fn jets(&self, x: f64) -> Option<[[f64; 3]; FIELDS]> {
        self.uniform.is_none().then(|| from_fn(|which| self.series_at(which, x)))
    }

    /// Clenshaw's recurrence, differentiated twice. Well beyond the piece a field keeps its value: a polynomial would leave its
    /// range there.
    fn series_at(&self, which: usize, x: f64) -> [f64; 3] {
        if let [constant] = self.series[which][..] {
            return [constant, 0.0, 0.0];
        }
        let margin = MARGIN * (self.to - self.from);
        let inside = x.clamp(self.from - margin, self.to + margin);
        if (inside - x).abs() > 0.0 {
            let [value, ..] = self.series_at(which, inside);
            return [value, 0.0, 0.0];
        }
        let scale = 2.0 / (self.to - self.from);
        let t = scale * (x - self.from) - 1.0;
        let coefficients = &self.series[which];
        let (mut b1, mut b2) = ([0.0; 3], [0.0; 3]);
        for &c in coefficients[1..].iter().rev() {
            let b = [
                2.0 * t * b1[0] - b2[0] + c,
                2.0 * (t * b1[1] + b1[0]) - b2[1],
                2.0 * (t * b1[2] + 2.0 * b1[1]) - b2[2],
            ];
            (b2, b1) = (b1, b);
        }
        [
            t * b1[0] - b2[0] + coefficients[0],
            (t * b1[1] + b1[0] - b2[1]) * scale,
            (t * b1[2] + 2.0 * b1[1] - b2[2]) * scale * scale,
        ]
    }
}

fn fit_into(pieces: &mut Vec<Piece>, from: f64, to: f64, shortest: f64, field: &dyn Fn(f64) -> Values) {
    let n = MOST_TERMS;
    let samples: Vec<[f64; FIELDS + 1]> = (0..n)
        .map(|i| {
            let t = (PI * (i as f64 + 0.5) / n as f64).cos();
            let values = field(from + 0.5 * (to - from) * (1.0 + t));
            let table = values.table();
            from_fn(|f| if f < FIELDS { table[f] } else { values.direction })
        })
        .collect();
    let mut fine = true;
    let series: Vec<Series> = (0..=FIELDS)
        .map(|f| {
            let mut coefficients: Vec<f64> = (0..n)
                .map(|k| {
                    let sum: f64 = samples
                        .iter()
                        .enumerate()
                        .map(|(i, s)| s[f] * (PI * k as f64 * (i as f64 + 0.5) / n as f64).cos())
                        .sum();
                    sum * if k == 0 { 1.0 } else { 2.0 } / n as f64
                })
                .collect();
            // Directions are of the order of one, whatever their series says.
            let size =
                coefficients.iter().fold(if f == FIELDS { 1.0 } else { 0.0 }, |m: f64, c| m.max(c.abs()));
            fine &= coefficients[n - 2..].iter().all(|c| c.is_nan() || c.abs() <= FIT * size);
            // A field that is not known is so everywhere.
            let used = coefficients.iter().rposition(|c| c.abs() > 1e-14 * size).map_or(1, |i| i + 1);
            coefficients.truncate(used);
            coefficients
        })
        .collect();
    if !fine && to - from > shortest {
        let middle = 0.5 * (from + to);
        fit_into(pieces, from, middle, shortest, field);
        fit_into(pieces, middle, to, shortest, field);
        return;
    }
    let constant = series[..FIELDS].iter().all(|s| s.len() == 1);
    let uniform = constant.then(|| from_fn(|f| series[f][0]));
    let linear = match &series[FIELDS][..] {
        [value] => Some([*value, 0.0]),
        [value, slope] => Some([value - slope, 2.0 * slope / (to - from)]),
        _ => None,
    };
    pieces.push(Piece { to, jumps: false, uniform, linear, from, series, metal: None });
}
