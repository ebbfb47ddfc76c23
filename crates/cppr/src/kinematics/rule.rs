//! Gauss–Legendre collocation on one element, with the integration matrices of its interpolant.
//!
//! ξ ∈ [0, 1] is the element's own coordinate, n the number of nodes ξ_i, L_j the Lagrange polynomials
//! through them. All integrals along the robot, those of the energy, of the face-to-face functions and of the
//! rotations, are taken of the same interpolants, so that derivatives of sums are sums of derivatives.

use crate::real::Real;
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// Nodes, weights and integration matrices of one element.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    /// Number of nodes n.
    pub n: usize,
    /// Nodes, increasing.
    pub nodes: Vec<f64>,
    /// Weights on [0, 1].
    pub weights: Vec<f64>,
    /// from_start[i n + j] = ∫_0^{ξ_i} L_j dξ.
    pub from_start: Vec<f64>,
    /// to_end[i n + j] = ∫_{ξ_i}^1 L_j dξ.
    pub to_end: Vec<f64>,
    /// magnus[m][s n + j]: share of node j in α_m / ℓ of step s, see [`Rule::magnus_weights`].
    pub magnus: [Vec<f64>; 3],
    /// magnus_modes[m][s n + i]: the same for Legendre mode i.
    pub magnus_modes: [Vec<f64>; 3],
    /// legendre[i n + j] = P_j(2 ξ_i − 1), j < n.
    pub legendre: Vec<f64>,
    /// legendre_to_end[i n + m] = ∫_{ξ_i}^1 P_m dξ; row n is the integral over the whole element.
    pub legendre_to_end: Vec<f64>,
}

impl Rule {
    /// The rule with n ≥ 1 nodes.
    pub fn new(n: usize) -> Self {
        let degree = NonZeroUsize::new(n).unwrap_or(NonZeroUsize::MIN);
        let n = degree.get();
        let mut pairs: Vec<(f64, f64)> =
            GaussLegendre::new(degree).iter().map(|&(x, w)| (0.5 * (x + 1.0), 0.5 * w)).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nodes, weights): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();

        let mut legendre = vec![0.0; n * n];
        for (row, &x) in legendre.chunks_mut(n).zip(&nodes) {
            legendre_values(x, row);
        }
        let mut rule = Self {
            n,
            nodes,
            weights,
            from_start: vec![0.0; n * n],
            to_end: vec![0.0; n * n],
            magnus: std::array::from_fn(|_| Vec::with_capacity((n + 1) * n)),
            magnus_modes: std::array::from_fn(|_| Vec::with_capacity((n + 1) * n)),
            legendre,
            legendre_to_end: vec![0.0; (n + 1) * n],
        };
        for i in 0..n {
            let x = rule.nodes[i];
            for (j, value) in rule.integral(0.0, x).into_iter().enumerate() {
                rule.from_start[i * n + j] = value;
                rule.to_end[i * n + j] = rule.weights[j] - value;
            }
        }
        for i in 0..=n {
            for m in 0..n {
                let weights = if i < n { &rule.to_end[i * n..(i + 1) * n] } else { &rule.weights[..] };
                rule.legendre_to_end[i * n + m] = (0..n).map(|j| weights[j] * rule.legendre[j * n + m]).sum();
            }
        }
        let mut stops = vec![0.0];
        stops.extend(&rule.nodes);
        stops.push(1.0);
        for pair in stops.windows(2) {
            for (all, own) in rule.magnus_weights(pair[0], pair[1]).into_iter().enumerate() {
                for i in 0..n {
                    let sum = own.iter().enumerate().map(|(j, share)| share * rule.legendre[j * n + i]).sum();
                    rule.magnus_modes[all].push(sum);
                }
                rule.magnus[all].extend(own);
            }
        }
        rule
    }

    /// Shares of the first `count` Legendre modes in α_1, α_2, α_3 of step `s`, over ℓ.
    #[inline]
    pub fn shares_of_modes(&self, s: usize, count: usize) -> [&[f64]; 3] {
        let of = |m: usize| &self.magnus_modes[m][s * self.n..s * self.n + count];
        [of(0), of(1), of(2)]
    }

    /// The Lagrange polynomials at ξ.
    pub fn lagrange(&self, x: f64) -> Vec<f64> {
        let mut p = vec![0.0; self.n];
        legendre_values(x, &mut p);
        (0..self.n)
            .map(|j| {
                let own = &self.legendre[j * self.n..(j + 1) * self.n];
                let sum: f64 =
                    p.iter().zip(own).enumerate().map(|(m, (a, b))| (2 * m + 1) as f64 * a * b).sum();
                sum * self.weights[j]
            })
            .collect()
    }

    /// ∫_a^b L_j dξ.
    pub fn integral(&self, a: f64, b: f64) -> Vec<f64> {
        self.moments(a, b).map(|m| m[0]).collect()
    }

    /// Moments ∫_a^b ((ξ − mid)/(b − a))^m L_j dξ for m = 0, 1, 2 of every L_j, by way of those of the Legendre
    /// modes. The rule has to be exact to degree n + 1, which it is.
    fn moments(&self, a: f64, b: f64) -> impl Iterator<Item = [f64; 3]> {
        let mut modes = vec![[0.0; 3]; self.n];
        let mut values = vec![0.0; self.n];
        for (&x, &w) in self.nodes.iter().zip(&self.weights) {
            let (weight, t) = (w * (b - a), x - 0.5);
            legendre_values(a + (b - a) * x, &mut values);
            for ((i, mode), value) in modes.iter_mut().enumerate().zip(&values) {
                let share = weight * value * (2 * i + 1) as f64;
                mode[0] += share;
                mode[1] += share * t;
                mode[2] += share * t * t;
            }
        }
        self.legendre.chunks(self.n).zip(&self.weights).map(move |(own, weight)| {
            let moment = |m: usize| weight * own.iter().zip(&modes).map(|(p, mode)| p * mode[m]).sum::<f64>();
            [moment(0), moment(1), moment(2)]
        })
    }

    /// Shares of the nodal values in the three generators α_m / ℓ of a sixth-order Magnus step from a to b:
    /// α_1 = 9/4 A_0 − 15 A_2, α_2 = 12 A_1, α_3 = −15 A_0 + 180 A_2 with the moments A_m.
    pub fn magnus_weights(&self, a: f64, b: f64) -> [Vec<f64>; 3] {
        let moments: Vec<[f64; 3]> = self.moments(a, b).collect();
        let combine = |c: [f64; 3]| moments.iter().map(|m| c[0] * m[0] + c[1] * m[1] + c[2] * m[2]).collect();
        [combine([2.25, 0.0, -15.0]), combine([0.0, 12.0, 0.0]), combine([-15.0, 0.0, 180.0])]
    }

    /// differentiate[i n + j] = dL_j/dξ at ξ_i.
    pub fn differentiation(&self) -> Vec<f64> {
        let n = self.n;
        let mut slopes = vec![0.0; n * n];
        for i in 0..n {
            let p = &self.legendre[i * n..(i + 1) * n];
            let mut dp = vec![0.0; n];
            for m in 1..n {
                // P_m' = P_{m−2}' + (2m − 1) P_{m−1}, times 2 for ξ.
                dp[m] = if m >= 2 { dp[m - 2] } else { 0.0 } + 2.0 * (2 * m - 1) as f64 * p[m - 1];
            }
            for j in 0..n {
                let own = &self.legendre[j * n..(j + 1) * n];
                let sum: f64 =
                    dp.iter().zip(own).enumerate().map(|(m, (a, b))| (2 * m + 1) as f64 * a * b).sum();
                slopes[i * n + j] = sum * self.weights[j];
            }
        }
        slopes
    }
}

/// Shifted Legendre polynomials P_0 … at ξ ∈ [0, 1].
pub(crate) fn legendre_values<S: Real>(x: S, values: &mut [S]) {
    let t = x * 2.0 - 1.0;
    let (mut before, mut current) = (S::zero(), S::one());
    for (m, value) in values.iter_mut().enumerate() {
        *value = current;
        let m = m as f64;
        let next = (t * (2.0 * m + 1.0) * current - before * m) / S::splat(m + 1.0);
        before = current;
        current = next;
    }
}

#[cfg(test)]
mod tests {
    use super::Rule;

    #[test]
    fn integrates_polynomials_to_and_from_every_node() {
        let rule = Rule::new(7);
        let f = |x: f64| 1.0 - 2.0 * x + 5.0 * x.powi(6);
        let integral = |x: f64| x - x * x + 5.0 / 7.0 * x.powi(7);
        for (i, &x) in rule.nodes.iter().enumerate() {
            let sum = |m: &[f64]| -> f64 { (0..7).map(|j| m[i * 7 + j] * f(rule.nodes[j])).sum() };
            assert!((sum(&rule.from_start) - integral(x)).abs() < 1e-14);
            assert!((sum(&rule.to_end) - (integral(1.0) - integral(x))).abs() < 1e-14);
        }
    }

    #[test]
    fn differentiates_its_interpolant() {
        let rule = Rule::new(6);
        let slopes = rule.differentiation();
        for (i, &x) in rule.nodes.iter().enumerate() {
            let got: f64 = (0..6).map(|j| slopes[i * 6 + j] * rule.nodes[j].powi(5)).sum();
            assert!((got - 5.0 * x.powi(4)).abs() < 1e-12);
        }
    }

    #[test]
    fn generators_of_a_step_are_the_local_taylor_coefficients() {
        // For K = k_0 + k_1 (ξ − mid) + k_2 (ξ − mid)² they are h k_0, h² k_1 and h³ k_2.
        let rule = Rule::new(5);
        let (a, b) = (rule.nodes[1], rule.nodes[2]);
        let (h, mid) = (b - a, 0.5 * (a + b));
        let k = |x: f64| 2.0 - 3.0 * (x - mid) + 7.0 * (x - mid) * (x - mid);
        let expected = [2.0 * h, -3.0 * h * h, 7.0 * h * h * h];
        for (weights, expected) in rule.magnus.iter().zip(expected) {
            let got: f64 = (0..5).map(|j| weights[2 * 5 + j] * k(rule.nodes[j])).sum();
            assert!((got - expected).abs() < 1e-14, "{got} {expected}");
        }
    }
}
