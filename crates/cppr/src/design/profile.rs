//! A design value along the rest abscissa x of a tube, 0 ≤ x ≤ L (m), with two derivatives.
//!
//! The unit is that of the value given: m for a notch depth, rad for a direction, N m² for a stiffness.
//! A profile is constant, linear from base to tip, a natural cubic spline through the middles of the notches
//! (Tummers et al. 2024, eq 1), or a monotone cubic through a table (Fritsch and Carlson 1980).

use std::fmt;

/// A value along the rest abscissa.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Profile {
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Shape {
    Constant(f64),
    Linear { base: f64, tip: f64 },
    Cubic(Cubic),
}

/// Cubic cells between points, straight lines beyond them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Cubic {
    points: Vec<f64>,
    /// Taylor coefficients of every cell about its left point: value, slope, half curvature, sixth of jerk.
    cells: Vec<[f64; 4]>,
    /// Values at the first and the last point.
    ends: [f64; 2],
    /// Slopes before the first and beyond the last point.
    beyond: [f64; 2],
    /// True for a spline, whose second derivative has no jump.
    smooth: bool,
}

/// What a profile was made from: the arguments of the constructor of that name.
#[derive(Clone, Debug, PartialEq)]
pub enum Made<'a> {
    /// [`Profile::constant`].
    Constant(f64),
    /// [`Profile::linear`]: base and tip.
    Linear([f64; 2]),
    /// [`Profile::per_notch`].
    PerNotch {
        /// Middles of the notches (m).
        middles: &'a [f64],
        /// Value of each.
        values: Vec<f64>,
    },
    /// [`Profile::table`].
    Table {
        /// Rest abscissae (m).
        abscissae: &'a [f64],
        /// Value at each.
        values: Vec<f64>,
    },
}

/// What is wrong with the points of a profile. Points are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum ProfileError {
    /// There is no point.
    Empty,
    /// There are not as many values as abscissae.
    Lengths {
        /// Number of values.
        values: usize,
        /// Number of abscissae.
        abscissae: usize,
    },
    /// A value is not finite.
    Value {
        /// Point number.
        point: usize,
        /// The value.
        value: f64,
    },
    /// An abscissa is not finite.
    Abscissa {
        /// Point number.
        point: usize,
        /// The abscissa (m).
        x: f64,
    },
    /// An abscissa does not exceed the one before it.
    Order {
        /// Point number.
        point: usize,
        /// The abscissa before it (m).
        before: f64,
        /// The abscissa (m).
        x: f64,
    },
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "there is no point; give at least one"),
            Self::Lengths { values, abscissae } => {
                write!(f, "there are {values} values for {abscissae} abscissae; give one value for each")
            }
            Self::Value { point, value } => write!(f, "value {point} is {value}; it must be a finite number"),
            Self::Abscissa { point, x } => write!(f, "abscissa {point} is {x}; it must be a finite number"),
            Self::Order { point, before, x } => write!(
                f,
                "abscissa {point} ({:.6} mm) does not exceed the one before it ({:.6} mm); order them from base to tip",
                x * 1e3,
                before * 1e3
            ),
        }
    }
}

impl std::error::Error for ProfileError {}

impl Profile {
    /// The same value everywhere.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self { shape: Shape::Constant(value) }
    }

    /// Linear in x with the given values at x = 0 and x = L.
    #[must_use]
    pub fn linear(base: f64, tip: f64) -> Self {
        Self { shape: Shape::Linear { base, tip } }
    }

    /// Natural cubic spline with the given values at the middles of the notches (m), C² everywhere.
    ///
    /// Beyond the outermost middles it goes on along its end tangents: the second derivative of a natural
    /// spline vanishes there, so that nothing jumps. A single notch makes a constant.
    ///
    /// # Errors
    /// The first of [`ProfileError`] that applies.
    pub fn per_notch(values: &[f64], middles: &[f64]) -> Result<Self, ProfileError> {
        Self::cubic(values, middles, |x, y| {
            let slopes = spline_slopes(x, y);
            let beyond = [slopes[0], slopes[slopes.len() - 1]];
            (slopes, beyond, true)
        })
    }

    /// Cubic through the given points (m), C¹ between them, monotone wherever the values are.
    ///
    /// Slopes are those of the parabola through three neighbours, limited to three times the lesser of the
    /// two chord slopes beside the point and zero at a local extremum (Fritsch and Carlson 1980). Beyond the
    /// first and the last point the profile is constant. It keeps its slope up to there, so that a table over
    /// [0, L] is not flattened at its ends; if the first or last point lies inside (0, L), the slope jumps
    /// there. A single point makes a constant.
    ///
    /// # Errors
    /// The first of [`ProfileError`] that applies.
    pub fn table(abscissae: &[f64], values: &[f64]) -> Result<Self, ProfileError> {
        Self::cubic(values, abscissae, |x, y| (monotone_slopes(x, y), [0.0; 2], false))
    }

    fn cubic(
        y: &[f64],
        x: &[f64],
        slopes: impl Fn(&[f64], &[f64]) -> (Vec<f64>, [f64; 2], bool),
    ) -> Result<Self, ProfileError> {
        check(y, x)?;
        let last = y.len() - 1;
        if last == 0 {
            return Ok(Self::constant(y[0]));
        }
        let (slopes, beyond, smooth) = slopes(x, y);
        let cells = (0..last)
            .map(|i| {
                let step = x[i + 1] - x[i];
                let chord = (y[i + 1] - y[i]) / step;
                let (left, right) = (slopes[i], slopes[i + 1]);
                let half_curvature = (3.0 * chord - 2.0 * left - right) / step;
                [y[i], left, half_curvature, (left + right - 2.0 * chord) / (step * step)]
            })
            .collect();
        Ok(Self {
            shape: Shape::Cubic(Cubic { points: x.to_vec(), cells, ends: [y[0], y[last]], beyond, smooth }),
        })
    }

    /// Value, first and second derivative with respect to x at x (m) on a tube of the given length L (m).
    ///
    /// Where a derivative jumps, the one towards the tip is given.
    #[must_use]
    pub fn eval(&self, x: f64, length: f64) -> [f64; 3] {
        match &self.shape {
            Shape::Constant(value) => [*value, 0.0, 0.0],
            Shape::Linear { base, tip } => {
                let slope = (tip - base) / length;
                [base + slope * x, slope, 0.0]
            }
            Shape::Cubic(cubic) => cubic.eval(x),
        }
    }

    /// What makes this profile again.
    #[must_use]
    pub fn made(&self) -> Made<'_> {
        match &self.shape {
            Shape::Constant(value) => Made::Constant(*value),
            Shape::Linear { base, tip } => Made::Linear([*base, *tip]),
            Shape::Cubic(cubic) => {
                let values = cubic.cells.iter().map(|cell| cell[0]).chain([cubic.ends[1]]).collect();
                if cubic.smooth {
                    Made::PerNotch { middles: &cubic.points, values }
                } else {
                    Made::Table { abscissae: &cubic.points, values }
                }
            }
        }
    }

    /// The profile times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.mapped(factor, 0.0)
    }

    /// The profile plus an offset.
    #[must_use]
    pub fn shifted(&self, offset: f64) -> Self {
        self.mapped(1.0, offset)
    }

    fn mapped(&self, factor: f64, offset: f64) -> Self {
        let map = |value: &f64| factor * value + offset;
        let shape = match &self.shape {
            Shape::Constant(value) => Shape::Constant(map(value)),
            Shape::Linear { base, tip } => Shape::Linear { base: map(base), tip: map(tip) },
            Shape::Cubic(cubic) => Shape::Cubic(Cubic {
                points: cubic.points.clone(),
                cells: cubic
                    .cells
                    .iter()
                    .map(|[a, b, c, d]| [map(a), factor * b, factor * c, factor * d])
                    .collect(),
                ends: cubic.ends.each_ref().map(map),
                beyond: cubic.beyond.map(|slope| factor * slope),
                smooth: cubic.smooth,
            }),
        };
        Self { shape }
    }

    /// True where the profile has the same value everywhere.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        let zero = |value: f64| value.abs() <= 0.0;
        match &self.shape {
            Shape::Constant(_) => true,
            Shape::Linear { base, tip } => zero(tip - base),
            Shape::Cubic(cubic) => {
                cubic.beyond.iter().all(|&s| zero(s))
                    && cubic.cells.iter().all(|c| c[1..].iter().all(|&v| zero(v)))
            }
        }
    }

    /// Abscissae 0 < x < L (m) at which the first or second derivative may jump, in order.
    #[must_use]
    pub fn knots(&self, length: f64) -> Vec<f64> {
        match &self.shape {
            Shape::Cubic(cubic) if !cubic.smooth && !self.is_constant() => {
                cubic.points.iter().copied().filter(|&x| 0.0 < x && x < length).collect()
            }
            _ => Vec::new(),
        }
    }
}

impl Profile {
    /// Abscissae 0 < x < L (m) at which any derivative may jump, in order: the ends of cubic cells.
    pub(crate) fn breaks(&self, length: f64) -> Vec<f64> {
        match &self.shape {
            Shape::Cubic(cubic) if !self.is_constant() => {
                cubic.points.iter().copied().filter(|&x| 0.0 < x && x < length).collect()
            }
            _ => Vec::new(),
        }
    }
}

impl Profile {
    /// Abscissae 0 < x < L (m), other than [`Self::breaks`], at which the profile passes a value, in order.
    pub(crate) fn passes(&self, value: f64, length: f64) -> Vec<f64> {
        let above = |x: f64| self.eval(x, length)[0] - value;
        // Between these the profile rises or falls.
        let mut turns = vec![0.0];
        if let Shape::Cubic(cubic) = &self.shape {
            turns.extend(cubic.turns());
        }
        turns.extend(self.breaks(length));
        turns.retain(|x| (0.0..length).contains(x));
        turns.push(length);
        turns.sort_unstable_by(f64::total_cmp);
        let passed = turns.windows(2).filter(|ends| above(ends[0]) * above(ends[1]) < 0.0);
        passed.map(|ends| between(ends[0], ends[1], above)).collect()
    }
}

/// Where a function changes its sign between two places, by bisection.
fn between(mut from: f64, mut to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let begins = of(from);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (from + to);
        if of(middle) * begins > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}

/// As many halvings as leave 1e-15 of a distance.
const BISECTIONS: usize = 50;

impl Cubic {
    /// Where its slope vanishes inside a cell.
    fn turns(&self) -> impl Iterator<Item = f64> {
        let ends = self.points.windows(2).zip(&self.cells);
        ends.flat_map(|(ends, [_, slope, half, sixth])| {
            let (from, width) = (ends[0], ends[1] - ends[0]);
            // 3 d t² + 2 c t + b = 0, from the root that no difference spoils.
            let sum = -(half + half.signum() * (half * half - 3.0 * sixth * slope).sqrt());
            let roots = [sum / (3.0 * sixth), slope / sum];
            roots.into_iter().filter(move |t| (0.0..width).contains(t)).map(move |t| from + t)
        })
    }

    fn eval(&self, x: f64) -> [f64; 3] {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        if x < first {
            return [self.ends[0] + self.beyond[0] * (x - first), self.beyond[0], 0.0];
        }
        if x >= last {
            return [self.ends[1] + self.beyond[1] * (x - last), self.beyond[1], 0.0];
        }
        let cell = self.points.partition_point(|&p| p <= x).saturating_sub(1).min(self.cells.len() - 1);
        let t = x - self.points[cell];
        let [a, b, c, d] = self.cells[cell];
        [a + t * (b + t * (c + t * d)), b + t * (2.0 * c + 3.0 * t * d), 2.0 * c + 6.0 * t * d]
    }
}

fn check(values: &[f64], abscissae: &[f64]) -> Result<(), ProfileError> {
    if values.len() != abscissae.len() {
        return Err(ProfileError::Lengths { values: values.len(), abscissae: abscissae.len() });
    }
    if values.is_empty() {
        return Err(ProfileError::Empty);
    }
    for (i, (&value, &x)) in values.iter().zip(abscissae).enumerate() {
        let point = i + 1;
        if !value.is_finite() {
            return Err(ProfileError::Value { point, value });
        }
        if !x.is_finite() {
            return Err(ProfileError::Abscissa { point, x });
        }
        if i > 0 && x <= abscissae[i - 1] {
            return Err(ProfileError::Order { point, before: abscissae[i - 1], x });
        }
    }
    Ok(())
}

/// Slopes at the points of the natural cubic spline: continuity of the second derivative at every inner
/// point, none at the ends. Diagonally dominant, so that elimination needs no pivots.
fn spline_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let step = |i: usize| x[i + 1] - x[i];
    let pull = |i: usize| 3.0 * (y[i + 1] - y[i]) / (step(i) * step(i));
    // Row i reads m[i-1]/h[i-1] + 2 (1/h[i-1] + 1/h[i]) m[i] + m[i+1]/h[i] = pull[i-1] + pull[i].
    let mut diagonal = vec![0.0; last + 1];
    let mut slopes = vec![0.0; last + 1];
    for i in 0..last {
        let stiffness = 1.0 / step(i);
        diagonal[i] += 2.0 * stiffness;
        diagonal[i + 1] += 2.0 * stiffness;
        slopes[i] += pull(i);
        slopes[i + 1] += pull(i);
    }
    for i in 0..last {
        let factor = 1.0 / (step(i) * diagonal[i]);
        diagonal[i + 1] -= factor / step(i);
        slopes[i + 1] -= factor * slopes[i];
    }
    slopes[last] /= diagonal[last];
    for i in (0..last).rev() {
        slopes[i] = (slopes[i] - slopes[i + 1] / step(i)) / diagonal[i];
    }
    slopes
}

/// Slopes of parabolas through three neighbours, limited so that every cell is monotone.
fn monotone_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let step = |i: usize| x[i + 1] - x[i];
    let chord = |i: usize| (y[i + 1] - y[i]) / step(i);
    if last == 1 {
        return vec![chord(0); 2];
    }
    // Derivative at the common point of cells i - 1 and i of the parabola through their three points, and at
    // its far end beside `near`.
    let middle = |i: usize| (step(i) * chord(i - 1) + step(i - 1) * chord(i)) / (step(i - 1) + step(i));
    let end = |near: usize, inner: usize| 2.0 * chord(near) - middle(inner);
    (0..=last)
        .map(|i| {
            if i == 0 {
                limited(end(0, 1), chord(0), chord(0))
            } else if i == last {
                limited(end(last - 1, last - 1), chord(last - 1), chord(last - 1))
            } else {
                limited(middle(i), chord(i - 1), chord(i))
            }
        })
        .collect()
}

/// The slope, brought between zero and three times the lesser of two chord slopes.
fn limited(slope: f64, before: f64, after: f64) -> f64 {
    if before * after <= 0.0 {
        return 0.0;
    }
    let bound = 3.0 * before.abs().min(after.abs());
    let sign = before.signum();
    sign * (sign * slope).clamp(0.0, bound)
}

#[cfg(test)]
mod tests {
    use super::Profile;

    #[test]
    fn passes_are_where_the_profile_has_the_value() {
        let length = 0.1;
        let middles: Vec<f64> = (0..20).map(|i| 0.005 * (f64::from(i) + 0.5)).collect();
        let depths: Vec<f64> = (0..20).map(|i| 5e-3 + 1e-4 * f64::from(i * i + 1).sin()).collect();
        let spline = Profile::per_notch(&depths, &middles).unwrap();
        // From a minimum up: no sample at the ends of the cell would tell the two passes.
        let arc = Profile::per_notch(&[5.1e-3, 5e-3, 5e-3, 5.1e-3], &[0.02, 0.04, 0.06, 0.08]).unwrap();
        for (profile, value, least) in
            [(&spline, 5e-3, 7), (&arc, 4.99e-3, 2), (&Profile::linear(4e-3, 6e-3), 5e-3, 1)]
        {
            let passes = profile.passes(value, length);
            assert!(passes.len() >= least && passes.is_sorted(), "{passes:?}");
            // Between two of them it stays on one side.
            let ends: Vec<f64> = [0.0].into_iter().chain(passes.iter().copied()).chain([length]).collect();
            for (number, pair) in ends.windows(2).enumerate() {
                let side = |x: f64| (profile.eval(x, length)[0] - value).signum();
                let begins = side(0.5 * (pair[0] + pair[1]));
                for i in 1..100 {
                    let at = pair[0] + (pair[1] - pair[0]) * f64::from(i) / 100.0;
                    assert!(side(at) * begins > 0.0, "{number}: {at}");
                }
            }
            assert!(passes.iter().all(|x| (profile.eval(*x, length)[0] - value).abs() < 1e-15));
        }
        assert!(Profile::constant(5e-3).passes(5e-3, length).is_empty());
    }
}
