//! Rotations: exponential, its left Jacobian and the derivative of that Jacobian.
//!
//! With ϑ = |Ω|: exp(Ω^) = 1 + a Ω^ + b Ω^², J(Ω) = 1 + b Ω^ + c Ω^², where a = sin ϑ/ϑ,
//! b = (1 − cos ϑ)/ϑ², c = (ϑ − sin ϑ)/ϑ³, and exp((Ω + δΩ)^) = exp((J δΩ)^) exp(Ω^) to first order.

use crate::dense::product;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

/// v^ with v^ w = v × w.
#[inline]
pub(crate) fn hat<S: Real>(v: &Vector3<S>) -> Matrix3<S> {
    let zero = S::zero();
    Matrix3::new(zero, -v.z, v.y, v.z, zero, -v.x, -v.y, v.x, zero)
}

/// Rotation about the X axis.
#[inline]
pub(crate) fn about_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// (a, b, c) of the module's head and (db/dϑ)/ϑ, (dc/dϑ)/ϑ.
type Coefficients<S> = [S; 5];

/// Series up to this angle (rad); most steps are shorter.
const SERIES_BELOW: f64 = 1.0;
/// Terms of the series: the first one dropped is below 2⁻⁵³ of the first at that angle.
const TERMS: usize = 9;

/// Coefficients of the series in ϑ²: (−1)^k/(2k + m)! for a, b, c (m = 1, 2, 3), and
/// 2 (k + 1) times the next one for the derivatives of b and c.
const SERIES: [[f64; TERMS]; 5] = series();

const fn series() -> [[f64; TERMS]; 5] {
    let mut all = [[0.0; TERMS]; 5];
    let mut m = 1;
    while m <= 3 {
        // (−1)^k/(2k + m)!, one term more than is kept.
        let mut value = if m == 3 { 1.0 / 6.0 } else { 1.0 / m as f64 };
        let mut k = 0;
        while k <= TERMS {
            if k < TERMS {
                all[m - 1][k] = value;
            }
            if m >= 2 && k > 0 {
                all[m + 1][k - 1] = 2.0 * k as f64 * value;
            }
            value /= -((2 * k + m + 1) as f64) * (2 * k + m + 2) as f64;
            k += 1;
        }
        m += 1;
    }
    all
}

fn coefficients<S: Real>(angle_squared: S) -> Coefficients<S> {
    let t = angle_squared;
    if t.mask(|t| t > SERIES_BELOW * SERIES_BELOW) == 0 {
        return SERIES.map(|c| c.iter().rev().fold(S::zero(), |sum, &c| sum * t + c));
    }
    let one = |t: f64| -> Coefficients<f64> {
        if t <= SERIES_BELOW * SERIES_BELOW {
            return coefficients(t);
        }
        let angle = t.sqrt();
        let (sin, cos) = angle.sin_cos();
        let (a, b) = (sin / angle, (1.0 - cos) / t);
        let c = (1.0 - a) / t;
        [a, b, c, (a - 2.0 * b) / t, (b - 3.0 * c) / t]
    };
    from_fn(|k| S::from_lanes(|l| one(t.lane(l))[k]))
}

/// exp(Ω^) and the left Jacobian J(Ω).
pub(crate) fn exp_and_jacobian<S: Real>(w: &Vector3<S>) -> (Matrix3<S>, Matrix3<S>) {
    let [a, b, c, ..] = coefficients(w.dot(w));
    let h = hat(w);
    let h2 = product(&h, &h);
    (Matrix3::identity() + h * a + h2 * b, Matrix3::identity() + h * b + h2 * c)
}

/// The matrix B with uᵀ B v = y · (dJ(Ω)\[u\] v): how the Jacobian turns with Ω, seen by the covector y.
pub(crate) fn jacobian_derivative<S: Real>(w: &Vector3<S>, y: &Vector3<S>) -> Matrix3<S> {
    let [_, b, c, db, dc] = coefficients(w.dot(w));
    // d(Ω^)[u] v = u × v, and y·(u × v) = u·(v × y) = −uᵀ y^ v.
    let linear = hat(y) * -b;
    // y·(u × (Ω × v) + Ω × (u × v)) with a × (b × c) = b (a·c) − c (a·b).
    let two = S::splat(2.0);
    let quadratic = (y * w.transpose() + Matrix3::identity() * y.dot(w) - w * y.transpose() * two) * c;
    let hy = y.cross(w);
    // Rows: u·Ω times the covectors y·(Ω × v) and y·(Ω × (Ω × v)).
    let change = w * (hy * db + (w * w.dot(y) - y * w.dot(w)) * dc).transpose();
    linear + quadratic + change
}

#[cfg(test)]
mod tests {
    use super::{exp_and_jacobian, hat, jacobian_derivative};
    use nalgebra::Vector3;

    #[test]
    fn exponential_jacobian_and_its_derivative_agree_with_differences() {
        let (u, v) = (Vector3::new(0.3, -0.7, 0.2), Vector3::new(-0.1, 0.4, 0.9));
        let y = Vector3::new(0.5, 0.25, -0.8);
        for scale in [1e-3, 0.1, 0.999, 1.001, 3.0] {
            let w = Vector3::new(0.36, 0.48, -0.8) * scale;
            let h = 1e-5;
            let plus = exp_and_jacobian(&(w + u * h));
            let minus = exp_and_jacobian(&(w - u * h));
            let (r, j) = exp_and_jacobian(&w);
            let spin = (plus.0 - minus.0) / (2.0 * h) * r.transpose();
            assert!((spin - hat(&(j * u))).norm() < 1e-9, "{scale}");
            let difference = y.dot(&((plus.1 - minus.1) / (2.0 * h) * v));
            let exact = (u.transpose() * jacobian_derivative(&w, &y) * v)[0];
            assert!((difference - exact).abs() < 1e-9, "{scale}: {difference} {exact}");
        }
    }
}
