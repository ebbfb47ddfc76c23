//! Rotations: exponential, its left Jacobian and the derivative of that Jacobian.
//!
//! With ϑ = |Ω|: exp(Ω^) = 1 + a Ω^ + b Ω^², J(Ω) = 1 + b Ω^ + c Ω^², where a = sin ϑ/ϑ,
//! b = (1 − cos ϑ)/ϑ², c = (ϑ − sin ϑ)/ϑ³, and exp((Ω + δΩ)^) = exp((J δΩ)^) exp(Ω^) to first order.

use crate::dense::{Block, cross};
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

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
pub(crate) type Coefficients<S> = [S; 5];

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
        let sum = |c: &[f64; TERMS]| c.iter().rev().fold(S::zero(), |sum, &c| S::splat(c).plus(sum, t));
        return [sum(&SERIES[0]), sum(&SERIES[1]), sum(&SERIES[2]), sum(&SERIES[3]), sum(&SERIES[4])];
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
    let each = |k: usize| S::from_lanes(|l| one(t.lane(l))[k]);
    [each(0), each(1), each(2), each(3), each(4)]
}

/// exp(Ω^), the left Jacobian J(Ω), and the coefficients that [`jacobian_derivative`] asks for.
#[inline]
pub(crate) fn exp_and_jacobian<S: Real>(w: &Vector3<S>) -> (Matrix3<S>, Matrix3<S>, Coefficients<S>) {
    let squared = (w.x * w.x).plus(w.y, w.y).plus(w.z, w.z);
    let known = coefficients(squared);
    let [a, b, c, ..] = known;
    // 1 + f Ω^ + g Ω^² with Ω^² = Ω Ωᵀ − ϑ² 1.
    let matrix = |f: S, g: S| {
        let diagonal = |x: S| S::one().plus(g, x * x - squared);
        let (x, y, z) = (f * w.x, f * w.y, f * w.z);
        let (xy, xz, yz) = (g * w.x * w.y, g * w.x * w.z, g * w.y * w.z);
        Matrix3::new(
            diagonal(w.x),
            xy - z,
            xz + y,
            xy + z,
            diagonal(w.y),
            yz - x,
            xz - y,
            yz + x,
            diagonal(w.z),
        )
    };
    (matrix(a, b), matrix(b, c), known)
}

/// The matrix B with uᵀ B v = y · (dJ(Ω)\[u\] v): how the Jacobian turns with Ω, seen by the covector y.
#[inline]
pub(crate) fn jacobian_derivative<S: Real>(
    w: &Vector3<S>,
    y: &Vector3<S>,
    [_, b, c, db, dc]: Coefficients<S>,
) -> Block<S> {
    let along = (w.x * y.x).plus(w.y, y.y).plus(w.z, y.z);
    let squared = (w.x * w.x).plus(w.y, w.y).plus(w.z, w.z);
    let hy = cross(y, w);
    // d(Ω^)\[u\] v = u × v, and y·(u × v) = u·(v × y) = −uᵀ y^ v; then y·(u × (Ω × v) + Ω × (u × v)) with
    // a × (b × c) = b (a·c) − c (a·b); last u·Ω times the covectors y·(Ω × v) and y·(Ω × (Ω × v)).
    let mut form =
        [[S::zero(), b * y.z, -b * y.y], [-b * y.z, S::zero(), b * y.x], [b * y.y, -b * y.x, S::zero()]];
    for j in 0..3 {
        let change = (hy[j] * db).plus(dc, w[j] * along - y[j] * squared).plus(S::splat(-2.0), c * y[j]);
        let own = c * w[j];
        for i in 0..3 {
            form[i][j] = form[i][j].plus(w[i], change).plus(y[i], own);
        }
        form[j][j] = form[j][j].plus(c, along);
    }
    form
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
            let (r, j, coefficients) = exp_and_jacobian(&w);
            let spin = (plus.0 - minus.0) / (2.0 * h) * r.transpose();
            assert!((spin - hat(&(j * u))).norm() < 1e-9, "{scale}");
            let difference = y.dot(&((plus.1 - minus.1) / (2.0 * h) * v));
            let b = jacobian_derivative(&w, &y, coefficients);
            let exact: f64 = (0..9).map(|k| u[k / 3] * b[k / 3][k % 3] * v[k % 3]).sum();
            assert!((difference - exact).abs() < 1e-9, "{scale}: {difference} {exact}");
        }
    }
}
