//! C² cubic spline on a uniform grid, with not-a-knot ends: fourth-order accurate up to the ends.

use crate::real::Real;

/// Part of the range of all values by which a spline may go beyond the ends of a cell unasked.
const OVERSHOOT: f64 = 1e-3;

/// A cubic spline over [0, length].
#[derive(Clone, Debug)]
pub(crate) struct CubicSpline {
    /// Cells per unit length.
    density: f64,
    step: f64,
    /// Taylor coefficients of each cell about its left end: value, slope, half curvature, sixth of jerk.
    cells: Vec<[f64; 4]>,
}

impl CubicSpline {
    /// Interpolates values given at equal steps over [0, length]. Data on a straight line, and fewer
    /// than five points, become a single linear cell.
    pub fn uniform(length: f64, values: &[f64]) -> Self {
        let first = values.first().copied().unwrap_or_default();
        let last = values.last().copied().unwrap_or_default();
        let count = values.len();
        let slope = (last - first) / length;
        let scale = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let linear = values.iter().enumerate().all(|(i, v)| {
            let line = first + (last - first) * i as f64 / (count - 1) as f64;
            (v - line).abs() <= 8.0 * f64::EPSILON * scale
        });
        if linear || count < 5 {
            return Self { density: 1.0 / length, step: length, cells: vec![[first, slope, 0.0, 0.0]] };
        }
        let step = length / (count - 1) as f64;
        let curvatures = knot_curvatures(step, values);
        let cells = (0..count - 1)
            .map(|i| {
                let (m0, m1) = (curvatures[i], curvatures[i + 1]);
                let slope = (values[i + 1] - values[i]) / step - step * (2.0 * m0 + m1) / 6.0;
                [values[i], slope, 0.5 * m0, (m1 - m0) / (6.0 * step)]
            })
            .collect();
        Self { density: 1.0 / step, step, cells }
    }

    /// Value and first three derivatives at x; the end cells go on outside the range.
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn eval<S: Real>(&self, x: S) -> [S; 4] {
        if let [[a, b, c, d]] = self.cells[..]
            && c == 0.0
            && d == 0.0
        {
            return [x * b + a, S::splat(b), S::zero(), S::zero()];
        }
        // A negative or NaN position saturates to cell 0.
        let cell = |l: usize| ((x.lane(l) * self.density) as usize).min(self.cells.len() - 1);
        let t = x - S::from_lanes(|l| cell(l) as f64 * self.step);
        let part = |k: usize| S::from_lanes(|l| self.cells[cell(l)][k]);
        let (a, b, c, d) = (part(0), part(1), part(2), part(3));
        [a + t * (b + t * (c + t * d)), b + t * (c * 2.0 + t * d * 3.0), c * 2.0 + t * d * 6.0, d * 6.0]
    }

    /// Cells in which the spline goes beyond the values at both their ends by more than a part of all values' range.
    pub fn overshooting(&self) -> Vec<usize> {
        let allowed = self.allowed();
        let beyond = |index: &usize| {
            let [low, high] = self.extremes(*index);
            let cell = self.cells[*index];
            let ends = [cell[0], self.end(*index)];
            low < ends[0].min(ends[1]) - allowed || high > ends[0].max(ends[1]) + allowed
        };
        if self.is_linear() { Vec::new() } else { (0..self.cells.len()).filter(beyond).collect() }
    }

    /// By how much a cell may leave its range.
    fn allowed(&self) -> f64 {
        let values = self.cells.iter().map(|cell| cell[0]);
        let (least, greatest) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        OVERSHOOT * (greatest - least)
    }

    /// Value at the end of a cell.
    fn end(&self, index: usize) -> f64 {
        let ([a, b, c, d], t) = (self.cells[index], self.step);
        a + t * (b + t * (c + t * d))
    }

    /// Least and greatest value in a cell.
    fn extremes(&self, index: usize) -> [f64; 2] {
        let [a, b, c, d] = self.cells[index];
        let at = |t: f64| a + t * (b + t * (c + t * d));
        // Roots of b + 2 c t + 3 d t², in the form that does not cancel.
        let root = (c * c - 3.0 * b * d).max(0.0).sqrt();
        let sum = -(c + root.copysign(c));
        let inside = [sum / (3.0 * d), b / sum].into_iter().filter(|t| *t > 0.0 && *t < self.step);
        inside
            .map(at)
            .chain([a, self.end(index)])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    }

    /// Keeps a cell within a range, that of what is interpolated there: where it leaves it, the slopes at its ends are limited so that it is
    /// monotonic (Fritsch and Carlson 1980). Values stay, and so does the continuity of the slope.
    pub fn keep_within(&mut self, index: usize, range: [f64; 2]) {
        if self.is_linear() {
            return;
        }
        let [low, high] = self.extremes(index);
        let allowed = self.allowed();
        if low >= range[0] - allowed && high <= range[1] + allowed {
            return;
        }
        for knot in [index, index + 1] {
            let rise =
                |index: usize| self.cells.get(index).map(|cell| (self.end(index) - cell[0]) / self.step);
            let (before, after) = (knot.checked_sub(1).and_then(rise), rise(knot));
            let (Some(before), Some(after)) = (before.or(after), after.or(before)) else { continue };
            let most = if before * after > 0.0 { 3.0 * before.abs().min(after.abs()) } else { 0.0 };
            let slope = self.slopes(knot.min(self.cells.len() - 1))[usize::from(knot == self.cells.len())];
            let slope = slope.clamp(-most, most);
            if knot > 0 {
                self.set_slopes(knot - 1, [self.cells[knot - 1][1], slope]);
            }
            if knot < self.cells.len() {
                self.set_slopes(knot, [slope, self.slopes(knot)[1]]);
            }
        }
    }

    /// Slopes at both ends of a cell.
    fn slopes(&self, index: usize) -> [f64; 2] {
        let ([_, b, c, d], t) = (self.cells[index], self.step);
        [b, b + t * (2.0 * c + t * 3.0 * d)]
    }

    /// Gives a cell other slopes at its ends, and leaves its values there.
    fn set_slopes(&mut self, index: usize, [first, last]: [f64; 2]) {
        let (from, to, step) = (self.cells[index][0], self.end(index), self.step);
        let rise = (to - from) / step;
        let second = (3.0 * rise - 2.0 * first - last) / step;
        self.cells[index] = [from, first, second, (first + last - 2.0 * rise) / (step * step)];
    }

    /// True where the spline is one straight line.
    pub fn is_linear(&self) -> bool {
        self.cells.len() == 1
    }
}

/// Second derivatives at the knots: tridiagonal system of a C² spline whose third derivative is also
/// continuous across the second and the last but one knot.
fn knot_curvatures(step: f64, values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let second = |i: usize| (values[i - 1] - 2.0 * values[i] + values[i + 1]) / (step * step);
    // Not-a-knot on a uniform grid gives m_0 = 2 m_1 − m_2, so that row 1 reads 6 m_1 = 6 second(1).
    let mut m = vec![0.0; n];
    let mut diagonal = vec![4.0; n];
    let mut rhs: Vec<f64> =
        (0..n).map(|i| if i == 0 || i == n - 1 { 0.0 } else { 6.0 * second(i) }).collect();
    m[1] = second(1);
    m[n - 2] = second(n - 2);
    for i in 2..n - 2 {
        if i == 2 {
            rhs[i] -= m[1];
        } else {
            let factor = 1.0 / diagonal[i - 1];
            diagonal[i] -= factor;
            rhs[i] -= factor * rhs[i - 1];
        }
    }
    for i in (2..n - 2).rev() {
        m[i] = (rhs[i] - m[i + 1]) / diagonal[i];
    }
    m[0] = 2.0 * m[1] - m[2];
    m[n - 1] = 2.0 * m[n - 2] - m[n - 3];
    m
}

#[cfg(test)]
mod tests {
    use super::{CubicSpline, OVERSHOOT};

    #[test]
    fn reproduces_a_cubic_with_its_derivatives() {
        let f = |x: f64| 2.0 - x + 3.0 * x * x - 0.5 * x * x * x;
        let values: Vec<f64> = (0..=16).map(|i| f(2.0 * f64::from(i) / 16.0)).collect();
        let spline = CubicSpline::uniform(2.0, &values);
        for x in [0.0, 0.03, 0.77, 1.9, 2.0] {
            let exact = [f(x), -1.0 + 6.0 * x - 1.5 * x * x, 6.0 - 3.0 * x, -3.0];
            for (got, want) in spline.eval(x).iter().zip(exact) {
                assert!((got - want).abs() < 1e-10, "{x}: {got} {want}");
            }
        }
    }

    /// A step is followed without overshoot, and a smooth peak between two samples stays as it is.
    #[test]
    fn keeps_within_what_it_interpolates() {
        let step = |i: usize| if i < 10 { 2.0 } else { 0.5 };
        let values: Vec<f64> = (0..=32).map(step).collect();
        let mut spline = CubicSpline::uniform(1.0, &values);
        let least = |spline: &CubicSpline| {
            (0..=999).map(|i| spline.eval(f64::from(i) / 999.0)[0]).fold(2.0, f64::min)
        };
        assert!(least(&spline) < 0.4, "the spline overshoots");
        let cells = spline.overshooting();
        assert!(cells.contains(&10) && !cells.contains(&20), "{cells:?}");
        for cell in cells {
            let ends = [values[cell], values[cell + 1]];
            spline.keep_within(cell, [ends[0].min(ends[1]), ends[0].max(ends[1])]);
        }
        assert!(least(&spline) > 0.5 - 1.5 * OVERSHOOT);
        for i in 1..32 {
            let x = f64::from(i) / 32.0;
            let [below, at] = [x - 1e-9, x].map(|x| spline.eval(x)[1]);
            assert!((below - at).abs() < 1e-4, "the slope jumps at {x}: {below} {at}");
        }
        let peak: Vec<f64> =
            (0..=32).map(|i| (std::f64::consts::PI * (f64::from(i) + 0.5) / 33.0).sin()).collect();
        assert!(CubicSpline::uniform(1.0, &peak).overshooting().is_empty());
    }

    #[test]
    fn converges_with_the_fourth_power_of_the_step() {
        let error = |n: u32| {
            let values: Vec<f64> = (0..=n).map(|i| (3.0 * f64::from(i) / f64::from(n)).sin()).collect();
            let spline = CubicSpline::uniform(3.0, &values);
            (0..=999)
                .map(|i| f64::from(i) * 0.003)
                .map(|x| (spline.eval(x)[0] - x.sin()).abs())
                .fold(0.0, f64::max)
        };
        let rate = (error(128) / error(256)).log2();
        assert!((3.7..4.3).contains(&rate), "{rate}");
    }
}
