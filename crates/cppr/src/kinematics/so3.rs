//! Rotations: exponential, its left Jacobian and the derivative of that Jacobian.
//!
//! With ϑ = |Ω|: exp(Ω^) = 1 + a Ω^ + b Ω^², J(Ω) = 1 + b Ω^ + c Ω^², where a = sin ϑ/ϑ,
//! b = (1 − cos ϑ)/ϑ², c = (ϑ − sin ϑ)/ϑ³, and exp((Ω + δΩ)^) = exp((J δΩ)^) exp(Ω^) to first order.

use crate::dense::{Block, cross, inner};
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

/// The coefficients of a rotation vector.
#[inline]
pub(crate) fn coefficients<S: Real>(w: &Vector3<S>) -> Coefficients<S> {
    let squared = inner(w, w);
    if squared.mask(|t| t > SERIES_BELOW * SERIES_BELOW) == 0 {
        return by_series(squared);
    }
    let each = |t: f64| if t > SERIES_BELOW * SERIES_BELOW { in_closed_form(t) } else { by_series(t) };
    from_fn(|k| squared.map(|t| each(t)[k]))
}

#[inline]
fn by_series<S: Real>(t: S) -> Coefficients<S> {
    let sum = |k: usize| SERIES[k].iter().rev().fold(S::zero(), |sum, &c| S::splat(c).plus(sum, t));
    [sum(0), sum(1), sum(2), sum(3), sum(4)]
}

fn in_closed_form(t: f64) -> Coefficients<f64> {
    let angle = t.sqrt();
    let (sin, cos) = angle.sin_cos();
    let (a, b) = (sin / angle, (1.0 - cos) / t);
    let c = (1.0 - a) / t;
    [a, b, c, (a - 2.0 * b) / t, (b - 3.0 * c) / t]
}

/// exp(Ω^).
#[inline]
pub(crate) fn exponential<S: Real>(w: &Vector3<S>, [a, b, ..]: &Coefficients<S>) -> Matrix3<S> {
    quadratic(w, *a, *b)
}

/// The left Jacobian J(Ω).
#[inline]
pub(crate) fn left_jacobian<S: Real>(w: &Vector3<S>, [_, b, c, ..]: &Coefficients<S>) -> Matrix3<S> {
    quadratic(w, *b, *c)
}

/// 1 + f Ω^ + g Ω^².
#[inline]
fn quadratic<S: Real>(w: &Vector3<S>, f: S, g: S) -> Matrix3<S> {
    // Ω^² = Ω Ωᵀ − ϑ² 1.
    let (x, y, z) = (f * w.x, f * w.y, f * w.z);
    let (gx, gy, gz) = (g * w.x, g * w.y, g * w.z);
    let (xx, yy, zz) = (gx * w.x, gy * w.y, gz * w.z);
    let (xy, xz, yz) = (gx * w.y, gx * w.z, gy * w.z);
    let one = S::one();
    Matrix3::new(
        one - (yy + zz),
        xy - z,
        xz + y,
        xy + z,
        one - (xx + zz),
        yz - x,
        xz - y,
        yz + x,
        one - (xx + yy),
    )
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
    use super::{coefficients, exponential, hat, jacobian_derivative, left_jacobian};
    use nalgebra::Vector3;

    #[test]
    fn exponential_jacobian_and_its_derivative_agree_with_differences() {
        let (u, v) = (Vector3::new(0.3, -0.7, 0.2), Vector3::new(-0.1, 0.4, 0.9));
        let y = Vector3::new(0.5, 0.25, -0.8);
        for scale in [1e-3, 0.1, 0.999, 1.001, 3.0] {
            let w = Vector3::new(0.36, 0.48, -0.8) * scale;
            let h = 1e-5;
            let at = |w: Vector3<f64>| {
                let known = coefficients(&w);
                (exponential(&w, &known), left_jacobian(&w, &known))
            };
            let (plus, minus, (r, j)) = (at(w + u * h), at(w - u * h), at(w));
            let spin = (plus.0 - minus.0) / (2.0 * h) * r.transpose();
            assert!((spin - hat(&(j * u))).norm() < 1e-9, "{scale}");
            let difference = y.dot(&((plus.1 - minus.1) / (2.0 * h) * v));
            let b = jacobian_derivative(&w, &y, coefficients(&w));
            let exact: f64 = (0..9).map(|k| u[k / 3] * b[k / 3][k % 3] * v[k % 3]).sum();
            assert!((difference - exact).abs() < 1e-9, "{scale}: {difference} {exact}");
        }
    }
}
