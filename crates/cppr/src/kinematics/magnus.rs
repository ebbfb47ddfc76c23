//! The rotation vector of one step of R' = R K^, to sixth order in the step's length (Blanes, Casas & Ros),
//! with exact derivatives.
//!
//! ```text
//! C = α_1 × α_2     W = 2 α_3 − C     P = 20 α_1 + α_3 + C     Q = α_2 + α_1 × W / 60
//! Ω = α_1 + α_3 / 12 + P × Q / 240
//! ```
//!
//! with the generators α of `rule`, which hold the curvature's value, slope and curvature at the step's middle.

use crate::dense::{column, cross, set_column};
use crate::real::Real;
use nalgebra::{SMatrix, Vector3};

/// Three rows by the nine components of the generators.
pub(crate) type Slope<S> = SMatrix<S, 3, 9>;

/// Ω of one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Magnus<S: Real> {
    pub alpha: [Vector3<S>; 3],
    pub omega: Vector3<S>,
    w: Vector3<S>,
    p: Vector3<S>,
    q: Vector3<S>,
}

/// How the parts of Ω change with the unknowns that move a step, three rows each: W, P, Q and Ω in this order.
pub(crate) const PARTS: usize = 4;

impl<S: Real> Magnus<S> {
    pub fn new(alpha: [Vector3<S>; 3]) -> Self {
        let [a1, a2, a3] = alpha;
        let c = a1.cross(&a2);
        let w = a3 * S::splat(2.0) - c;
        let p = a1 * S::splat(20.0) + a3 + c;
        let q = a2 + a1.cross(&w) * S::splat(1.0 / 60.0);
        let omega = a1 + a3 * S::splat(1.0 / 12.0) + p.cross(&q) * S::splat(1.0 / 240.0);
        Self { alpha, omega, w, p, q }
    }

    /// Turns changes of α (α_1, α_2, α_3) into those of (W, P, Q, Ω).
    #[inline]
    fn change(&self, [d1, d2, d3]: [Vector3<S>; 3]) -> [Vector3<S>; 4] {
        let [a1, a2, _] = &self.alpha;
        let c = cross(&d1, a2) + cross(a1, &d2);
        let w = d3 * S::splat(2.0) - c;
        let p = d1 * S::splat(20.0) + d3 + c;
        let q = d2 + (cross(&d1, &self.w) + cross(a1, &w)) * S::splat(1.0 / 60.0);
        let omega = d1
            + d3 * S::splat(1.0 / 12.0)
            + (cross(&p, &self.q) + cross(&self.p, &q)) * S::splat(1.0 / 240.0);
        [w, p, q, omega]
    }

    /// Changes by many unknowns: `alpha` holds nine rows of length n, `parts` takes [`PARTS`] times three.
    pub fn changes(&self, alpha: &[S], parts: &mut [S], n: usize) {
        for i in 0..n {
            let own = [column(alpha, n, i), column(&alpha[3 * n..], n, i), column(&alpha[6 * n..], n, i)];
            for (k, part) in self.change(own).iter().enumerate() {
                set_column(&mut parts[3 * k * n..], n, i, part);
            }
        }
    }

    /// dΩ by the generators.
    pub fn slope(&self) -> Slope<S> {
        let mut slope = Slope::zeros();
        for i in 0..9 {
            let mut unit = [Vector3::zeros(); 3];
            unit[i / 3][i % 3] = S::one();
            slope.set_column(i, &self.change(unit)[3]);
        }
        slope
    }

    /// The vectors v_k for which y·d²Ω = Σ_k (v_k × α_1,a)·part_k,b + the same with a and b exchanged; the parts
    /// are α_2 and W, and for the third, (y × P_a)·Q_b.
    pub fn second(&self, y: &Vector3<S>) -> Second<S> {
        let scale = S::splat(1.0 / 240.0);
        let across_q = y.cross(&self.p) * scale;
        let [a1, ..] = self.alpha;
        let sixtieth = S::splat(1.0 / 60.0);
        Second {
            p: y * scale,
            w: across_q * sixtieth,
            a2: self.q.cross(y) * scale - across_q.cross(&a1) * sixtieth,
        }
    }
}

/// See [`Magnus::second`].
pub(crate) struct Second<S: Real> {
    /// y / 240: (y × P_a)·Q_b.
    pub p: Vector3<S>,
    /// (v × α_1,a)·W_b.
    pub w: Vector3<S>,
    /// (v × α_1,a)·α_2,b.
    pub a2: Vector3<S>,
}

#[cfg(test)]
mod tests {
    use super::{Magnus, PARTS};
    use crate::dense::column;
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
        let slope = magnus.slope();
        let mut identity = [0.0; 81];
        (0..9).for_each(|i| identity[10 * i] = 1.0);
        let mut parts = [0.0; 3 * PARTS * 9];
        magnus.changes(&identity, &mut parts, 9);
        let part = |k: usize, i: usize| column(&parts[27 * k..], 9, i);
        let alpha = |m: usize, i: usize| column(&identity[27 * m..], 9, i);
        let second = magnus.second(&y);
        let half = |a: usize, b: usize| {
            second.p.cross(&part(1, a)).dot(&part(2, b))
                + second.w.cross(&alpha(0, a)).dot(&part(0, b))
                + second.a2.cross(&alpha(0, a)).dot(&alpha(1, b))
        };
        for i in 0..9 {
            let moved = |sign: f64| {
                let mut v = at;
                v[i] += sign * h;
                Magnus::new(generators(&v))
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            let difference = (plus.omega - minus.omega) / (2.0 * h);
            assert!((difference - slope.column(i)).norm() < 1e-9);
            assert!((difference - part(3, i)).norm() < 1e-9);
            let difference = (plus.slope().transpose() * y - minus.slope().transpose() * y) / (2.0 * h);
            let exact: Vec<f64> = (0..9).map(|a| half(a, i) + half(i, a)).collect();
            assert!(difference.iter().zip(exact).all(|(d, e)| (d - e).abs() < 1e-9));
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
