//! Rotations: exponential, its left Jacobian and the derivative of that Jacobian.
//!
//! With ϑ = |Ω|: exp(Ω^) = 1 + a Ω^ + b Ω^², J(Ω) = 1 + b Ω^ + c Ω^², where a = sin ϑ/ϑ,
//! b = (1 − cos ϑ)/ϑ², c = (ϑ − sin ϑ)/ϑ³, and exp((Ω + δΩ)^) = exp((J δΩ)^) exp(Ω^) to first order.

use nalgebra::{Matrix3, Vector3};

/// v^ with v^ w = v × w.
#[inline]
pub(crate) fn hat(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rotation about the X axis.
#[inline]
pub(crate) fn about_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// The coefficients a, b, c of the module's head, with the derivatives of b and c by ϑ²/2.
struct Coefficients {
    a: f64,
    b: f64,
    c: f64,
    /// (db/dϑ)/ϑ.
    db: f64,
    /// (dc/dϑ)/ϑ.
    dc: f64,
}

/// Series below this angle: the first dropped terms, ϑ⁸/10!·9 and smaller, are below 2⁻⁵³.
const SERIES_BELOW: f64 = 0.1;

fn coefficients(angle_squared: f64) -> Coefficients {
    let t = angle_squared;
    if t < SERIES_BELOW * SERIES_BELOW {
        Coefficients {
            a: 1.0 - t / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0))),
            b: 0.5 - t / 24.0 * (1.0 - t / 30.0 * (1.0 - t / 56.0 * (1.0 - t / 90.0))),
            c: 1.0 / 6.0 - t / 120.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0))),
            db: -1.0 / 12.0 + t / 180.0 * (1.0 - 3.0 * t / 112.0 * (1.0 - 2.0 * t / 135.0)),
            dc: -1.0 / 60.0 + t / 1260.0 * (1.0 - t / 48.0 * (1.0 - 2.0 * t / 165.0)),
        }
    } else {
        let angle = t.sqrt();
        let (sin, cos) = angle.sin_cos();
        let (a, b) = (sin / angle, (1.0 - cos) / t);
        let c = (1.0 - a) / t;
        Coefficients { a, b, c, db: (a - 2.0 * b) / t, dc: (b - 3.0 * c) / t }
    }
}

/// exp(Ω^) and the left Jacobian J(Ω).
pub(crate) fn exp_and_jacobian(w: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let k = coefficients(w.norm_squared());
    let h = hat(w);
    let h2 = h * h;
    (Matrix3::identity() + h * k.a + h2 * k.b, Matrix3::identity() + h * k.b + h2 * k.c)
}

/// The matrix B with uᵀ B v = y · (dJ(Ω)\[u\] v): how the Jacobian turns with Ω, seen by the covector y.
pub(crate) fn jacobian_derivative(w: &Vector3<f64>, y: &Vector3<f64>) -> Matrix3<f64> {
    let k = coefficients(w.norm_squared());
    // d(Ω^)[u] v = u × v, and y·(u × v) = u·(v × y) = −uᵀ y^ v.
    let linear = -hat(y) * k.b;
    // y·(u × (Ω × v) + Ω × (u × v)) with a × (b × c) = b (a·c) − c (a·b).
    let quadratic = (y * w.transpose() + Matrix3::identity() * y.dot(w) - w * y.transpose() * 2.0) * k.c;
    let hy = y.cross(w);
    // Rows: u·Ω times the covectors y·(Ω × v) and y·(Ω × (Ω × v)).
    let change = w * (hy * k.db + (w * w.dot(y) - y * w.norm_squared()) * k.dc).transpose();
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
        for scale in [1e-3, 0.0999, 0.1001, 1.0, 3.0] {
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
