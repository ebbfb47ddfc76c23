//! C² cubic spline on a uniform grid, with not-a-knot ends: fourth-order accurate up to the ends.

use crate::real::Real;

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
    use super::CubicSpline;

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
