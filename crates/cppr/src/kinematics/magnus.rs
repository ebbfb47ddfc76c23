//! The rotation vector of one step of R' = R K^, to sixth order in the step's length (Blanes, Casas & Ros),
//! with exact derivatives.
//!
//! ```text
//! C = α_1 × α_2     W = 2 α_3 − C     P = 20 α_1 + α_3 + C     Q = α_2 + α_1 × W / 60
//! Ω = α_1 + α_3 / 12 + P × Q / 240
//! ```
//!
//! with the generators α of `rule`, which hold the curvature's value, slope and curvature at the step's middle.

use super::so3::hat;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Three rows by the nine components of the generators.
pub(crate) type Slope = SMatrix<f64, 3, 9>;

/// Ω of one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Magnus {
    pub alpha: [Vector3<f64>; 3],
    pub omega: Vector3<f64>,
    w: Vector3<f64>,
    p: Vector3<f64>,
    q: Vector3<f64>,
}

impl Magnus {
    pub fn new(alpha: [Vector3<f64>; 3]) -> Self {
        let [a1, a2, a3] = alpha;
        let c = a1.cross(&a2);
        let w = a3 * 2.0 - c;
        let p = a1 * 20.0 + a3 + c;
        let q = a2 + a1.cross(&w) / 60.0;
        Self { alpha, omega: a1 + a3 / 12.0 + p.cross(&q) / 240.0, w, p, q }
    }

    /// dP, dQ, dW by the generators.
    fn parts(&self) -> (Slope, Slope, Slope) {
        let [a1, a2, _] = self.alpha;
        let c = columns(-hat(&a2), hat(&a1), Matrix3::zeros());
        let w = columns(Matrix3::zeros(), Matrix3::zeros(), Matrix3::identity() * 2.0) - c;
        let p = columns(Matrix3::identity() * 20.0, Matrix3::zeros(), Matrix3::identity()) + c;
        let q = columns(-hat(&self.w) / 60.0, Matrix3::identity(), Matrix3::zeros()) + hat(&a1) * w / 60.0;
        (p, q, w)
    }

    /// dΩ by the generators.
    pub fn slope(&self) -> Slope {
        let (p, q, _) = self.parts();
        let linear = columns(Matrix3::identity(), Matrix3::zeros(), Matrix3::identity() / 12.0);
        linear + (hat(&self.p) * q - hat(&self.q) * p) / 240.0
    }

    /// d²(y·Ω) by the generators.
    pub fn curvature(&self, y: &Vector3<f64>) -> SMatrix<f64, 9, 9> {
        let (p, q, w) = self.parts();
        let q_bar = y.cross(&self.p);
        let c_bar = (self.q.cross(y) - q_bar.cross(&self.alpha[0]) / 60.0) / 240.0;
        // y·(u × v) = −uᵀ y^ v.
        let mut form = -(p.transpose() * hat(y) * q) / 240.0;
        let first =
            -(hat(&q_bar) * w) / (240.0 * 60.0) + columns(Matrix3::zeros(), -hat(&c_bar), Matrix3::zeros());
        let mut top = form.fixed_rows_mut::<3>(0);
        top += first;
        form + form.transpose()
    }
}

fn columns(a: Matrix3<f64>, b: Matrix3<f64>, c: Matrix3<f64>) -> Slope {
    let mut slope = Slope::zeros();
    slope.fixed_columns_mut::<3>(0).copy_from(&a);
    slope.fixed_columns_mut::<3>(3).copy_from(&b);
    slope.fixed_columns_mut::<3>(6).copy_from(&c);
    slope
}

#[cfg(test)]
mod tests {
    use super::Magnus;
    use crate::kinematics::so3::exp_and_jacobian;
    use nalgebra::{Matrix3, Vector3};

    fn generators(v: &[f64]) -> [Vector3<f64>; 3] {
        std::array::from_fn(|m| Vector3::from_column_slice(&v[3 * m..3 * m + 3]))
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let at = [0.3, -0.5, 0.2, 0.4, 0.1, -0.6, 0.25, -0.35, 0.15];
        let magnus = Magnus::new(generators(&at));
        let y = Vector3::new(0.7, -0.2, 0.5);
        let h = 1e-5;
        let (slope, curvature) = (magnus.slope(), magnus.curvature(&y));
        for i in 0..9 {
            let moved = |sign: f64| {
                let mut v = at;
                v[i] += sign * h;
                Magnus::new(generators(&v))
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            let difference = (plus.omega - minus.omega) / (2.0 * h);
            assert!((difference - slope.column(i)).norm() < 1e-9);
            let difference = (plus.slope().transpose() * y - minus.slope().transpose() * y) / (2.0 * h);
            assert!((difference - curvature.column(i)).norm() < 1e-9);
        }
    }

    #[test]
    fn sixth_order() {
        // One step of length h against very many, curvature quadratic in the arc length.
        let k = |s: f64| Vector3::new(2.0 + s, 1.0 - 3.0 * s, 2.0 * s * s - 1.0);
        let step = |a: f64, h: f64| {
            let m = a + 0.5 * h;
            let slope = Vector3::new(1.0, -3.0, 4.0 * m);
            let alpha = [k(m) * h, slope * h * h, Vector3::new(0.0, 0.0, 2.0) * h * h * h];
            exp_and_jacobian(&Magnus::new(alpha).omega).0
        };
        let chain = |count: u32| -> Matrix3<f64> {
            let h = 1.0 / f64::from(count);
            (0..count).map(|i| step(f64::from(i) * h, h)).product()
        };
        let exact = chain(512);
        let rate = ((chain(4) - exact).norm() / (chain(8) - exact).norm()).log2();
        assert!((5.7..6.6).contains(&rate), "{rate}");
    }
}
