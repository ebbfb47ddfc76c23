//! The rotation vector of one step of R' = R K^, to sixth order in the step's length (Blanes, Casas & Ros),
//! with exact derivatives.
//!
//! ```text
//! C = α_1 × α_2     W = 2 α_3 − C     P = 20 α_1 + α_3 + C     Q = α_2 + α_1 × W / 60
//! Ω = α_1 + α_3 / 12 + P × Q / 240
//! ```
//!
//! with the generators α of `rule`, which hold the curvature K and its first two derivatives by arc length at the step's middle.

use crate::dense::{Block, cross, hat, hat_hat, hat_times};
use crate::real::Real;
use nalgebra::Vector3;

// The solution of R' = R K^ over a step is R exp(Ω^) with Magnus' series Ω = ∫ K + ½ ∫∫_{s<t} K(s) × K(t) + … (signs opposite to
// those of Y' = A Y, since K^ multiplies from the right). With K expanded about the step's middle, α_i = h^i/(i−1)! K^(i−1), as
// a quadrature of sixth order finds them, all terms up to h⁶ collapse to three products (Blanes, Casas & Ros, BIT 40, 2000): C,
// and the two in Q and in Ω. P and Q are kept because derivatives need them: 240 δΩ = 240 δα_1 + 20 δα_3 + δP × Q + P × δQ.

/// Ω of one step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Magnus<S: Real> {
    pub alpha: [Vector3<S>; 3],
    pub omega: Vector3<S>,
    w: Vector3<S>,
    p: Vector3<S>,
    q: Vector3<S>,
}

/// Three rows by the nine components of the generators (α_1, α_2, α_3).
pub(crate) type Slope<S> = [[S; 9]; 3];
/// Nine rows.
pub(crate) type SecondDerivative<S> = [[S; 9]; 9];

impl<S: Real> Magnus<S> {
    #[inline]
    pub fn new(alpha: [Vector3<S>; 3]) -> Self {
        let mut result = Self { alpha, ..Self::default() };
        result.evaluate();
        result
    }

    /// Ω of the generators that `alpha` holds.
    #[inline]
    pub fn evaluate(&mut self) {
        let [a1, a2, a3] = &self.alpha;
        let c = cross(a1, a2);
        self.w = sum(&scaled(a3, 2.0), -1.0, &c);
        self.p = sum(&sum(&c, 1.0, a3), 20.0, a1);
        self.q = sum(a2, 1.0 / 60.0, &cross(a1, &self.w));
        self.omega = sum(&sum(a1, 1.0 / 12.0, a3), 1.0 / 240.0, &cross(&self.p, &self.q));
    }

    /// dΩ by the generators.
    #[inline]
    pub fn slope(&self) -> Slope<S> {
        let Self { alpha: [a1, a2, _], p, q, .. } = self;
        // Ω_i = δ_i + (P^ Q_i − Q^ P_i)/240 with P = 20 α_1 + α_3 + α_1 × α_2.
        let [q1, q2, q3] = self.slope_of_q();
        let (t1, t2, t3) = (hat_times(p, &q1), hat_times(p, &q2), hat_times(p, &q3));
        let (own, across1, across2) = (hat(q), hat_hat(q, a2), hat_hat(q, a1));
        let mut slope = [[S::zero(); 9]; 3];
        for i in 0..3 {
            for j in 0..3 {
                slope[i][j] = (t1[i][j] + across1[i][j]).plus(S::splat(-20.0), own[i][j]) * (1.0 / 240.0);
                slope[i][3 + j] = (t2[i][j] - across2[i][j]) * (1.0 / 240.0);
                slope[i][6 + j] = (t3[i][j] - own[i][j]) * (1.0 / 240.0);
            }
            slope[i][i] += S::one();
            slope[i][6 + i] += S::splat(1.0 / 12.0);
        }
        slope
    }

    /// dQ by α_1, α_2, α_3.
    #[inline]
    fn slope_of_q(&self) -> [Block<S>; 3] {
        let Self { alpha: [a1, a2, _], w, .. } = self;
        let (mut first, mut second) = (hat_hat(a1, a2), hat_hat(a1, a1));
        let (of_w, mut third) = (hat(w), hat(a1));
        for i in 0..3 {
            for j in 0..3 {
                first[i][j] = (first[i][j] - of_w[i][j]) * (1.0 / 60.0);
                second[i][j] = second[i][j] * (-1.0 / 60.0);
                third[i][j] = third[i][j] * (1.0 / 30.0);
            }
            second[i][i] += S::one();
        }
        [first, second, third]
    }

    /// y·d²Ω by the generators: X + Xᵀ with X_ij = P_iᵀ (y^)ᵀ Q_j / 240, and the second derivatives of Q and P themselves.
    #[inline]
    pub fn second(&self, y: &Vector3<S>, form: &mut SecondDerivative<S>) {
        let Self { alpha: [a1, a2, _], p, q, .. } = self;
        let across_q = scaled(&cross(y, p), 1.0 / 240.0);
        let by_w = scaled(&across_q, 1.0 / 60.0);
        let lever = scaled(&cross(q, y), 1.0 / 240.0);
        let by_c = sum(&lever, -1.0 / 60.0, &cross(&across_q, a1));
        let minus_y = scaled(y, -1.0 / 240.0);
        let [q1, q2, q3] = self.slope_of_q();
        let (n1, n2, n3) = (hat_times(&minus_y, &q1), hat_times(&minus_y, &q2), hat_times(&minus_y, &q3));
        let (f1, f2, f3) = (hat_times(a2, &n1), hat_times(a2, &n2), hat_times(a2, &n3));
        let (s1, s2, s3) = (hat_times(a1, &n1), hat_times(a1, &n2), hat_times(a1, &n3));
        let (w1, w2, w3, c) = (hat_hat(&by_w, a2), hat_hat(&by_w, a1), hat(&by_w), hat(&by_c));
        let twenty = S::splat(20.0);
        for i in 0..3 {
            for j in 0..3 {
                let x12 = f2[i][j].plus(twenty, n2[i][j]) + w2[i][j] - c[i][j] - s1[j][i];
                let x13 = f3[i][j].plus(twenty, n3[i][j]).plus(S::splat(-2.0), w3[i][j]) + n1[j][i];
                let x23 = n2[j][i] - s3[i][j];
                let x11 = |i: usize, j: usize| f1[i][j].plus(twenty, n1[i][j]) - w1[i][j];
                form[i][j] = x11(i, j) + x11(j, i);
                form[3 + i][3 + j] = -(s2[i][j] + s2[j][i]);
                form[6 + i][6 + j] = n3[i][j] + n3[j][i];
                form[i][3 + j] = x12;
                form[3 + j][i] = x12;
                form[i][6 + j] = x13;
                form[6 + j][i] = x13;
                form[3 + i][6 + j] = x23;
                form[6 + j][3 + i] = x23;
            }
        }
    }

    /// The pull-back of a covector y from Ω to the generators: y·dΩ = Σ pull_m·dα_m.
    #[inline]
    pub fn pull(&self, y: &Vector3<S>) -> [Vector3<S>; 3] {
        let Self { alpha: [a1, a2, _], w, p, q, .. } = self;
        let (by_p, by_q) = (scaled(&cross(q, y), 1.0 / 240.0), scaled(&cross(y, p), 1.0 / 240.0));
        let sixtieth = scaled(&by_q, 1.0 / 60.0);
        let by_w = cross(&sixtieth, a1);
        let by_c = sum(&by_p, -1.0, &by_w);
        let first = sum(&sum(y, 1.0, &cross(w, &sixtieth)), 1.0, &cross(a2, &by_c));
        [
            sum(&first, 20.0, &by_p),
            sum(&by_q, 1.0, &cross(&by_c, a1)),
            sum(&sum(&by_p, 1.0 / 12.0, y), 2.0, &by_w),
        ]
    }
}

#[inline]
fn scaled<S: Real>(v: &Vector3<S>, factor: f64) -> Vector3<S> {
    Vector3::new(v.x * factor, v.y * factor, v.z * factor)
}

/// u + factor v.
#[inline]
fn sum<S: Real>(u: &Vector3<S>, factor: f64, v: &Vector3<S>) -> Vector3<S> {
    let factor = S::splat(factor);
    Vector3::new(u.x.plus(factor, v.x), u.y.plus(factor, v.y), u.z.plus(factor, v.z))
}

#[cfg(test)]
mod tests {
    use super::Magnus;
    use crate::kinematics::so3::{coefficients, exponential};
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
        let (slope, pull) = (magnus.slope(), magnus.pull(&y));
        let mut second = [[0.0; 9]; 9];
        magnus.second(&y, &mut second);
        for i in 0..9 {
            let moved = |sign: f64| {
                let mut v = at;
                v[i] += sign * h;
                Magnus::new(generators(&v))
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            let difference = (plus.omega - minus.omega) / (2.0 * h);
            assert!((0..3).all(|d| (difference[d] - slope[d][i]).abs() < 1e-9));
            assert!((y.dot(&difference) - pull[i / 3][i % 3]).abs() < 1e-9);
            for k in 0..9 {
                let along = |m: &Magnus<f64>| m.pull(&y)[k / 3][k % 3];
                let difference = (along(&plus) - along(&minus)) / (2.0 * h);
                assert!((difference - second[i][k]).abs() < 1e-9);
            }
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
            let omega = Magnus::new(alpha).omega;
            exponential(&omega, &coefficients(&omega))
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
