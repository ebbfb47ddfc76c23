//! Small dense linear algebra on row-major slices, without allocation: the sizes are those of one
//! equilibrium, at most a few tens.

use crate::real::{Real, every};
use nalgebra::{Matrix3, Vector3};

/// LU factors. The buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu<S = f64> {
    n: usize,
    factors: Vec<S>,
    inverses: Vec<S>,
    /// Rows as they were exchanged; empty where none was.
    pivots: Vec<usize>,
}

/// A determinant that may be far beyond the range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Determinant {
    /// 1 or −1.
    pub sign: f64,
    /// Logarithm of its magnitude.
    pub ln: f64,
}

/// A matrix that has no inverse to working precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Singular;

impl<S: Real> Lu<S> {
    /// Factors an n × n matrix by elimination in the order of its rows. Returns the lanes in which the first
    /// `positive` pivots are positive and the others negative: there the order was safe, and a symmetric
    /// matrix has as many positive eigenvalues.
    pub fn factor_in_order(&mut self, matrix: &[S], n: usize, positive: usize) -> u64 {
        self.begin(n).copy_from_slice(&matrix[..n * n]);
        self.eliminate_in_order(positive, false)
    }

    /// Room for an n × n matrix, whose entries all mean nothing yet.
    pub fn begin(&mut self, n: usize) -> &mut [S] {
        self.n = n;
        self.factors.resize(n * n, S::zero());
        self.pivots.clear();
        self.inverses.clear();
        &mut self.factors
    }

    /// Factors the matrix that stands in the room, as [`Lu::factor_in_order`]; of a symmetric one nothing below the diagonal
    /// is read.
    pub fn eliminate_in_order(&mut self, positive: usize, symmetric: bool) -> u64 {
        let n = self.n;
        let mut in_order = every::<S>();
        for k in 0..n {
            let (upper, lower) = self.factors.split_at_mut((k + 1) * n);
            let row = &upper[k * n..];
            let pivot = row[k];
            in_order &= pivot.mask(|p| if k < positive { p > LEAST_PIVOT } else { p < -LEAST_PIVOT });
            let inverse = S::one() / pivot;
            self.inverses.push(inverse);
            for (i, target) in (k + 1..n).zip(lower.chunks_exact_mut(n)) {
                // L = (D⁻¹ U)ᵀ
                let (factor, from) = if symmetric { (row[i], i) } else { (target[k], k + 1) };
                let factor = factor * inverse;
                target[k] = factor;
                axpy(&mut target[from..], -factor, &row[from..]);
            }
        }
        in_order
    }

    /// Solves A X = B in place; B is n × columns, row-major.
    pub fn solve(&self, b: &mut [S], columns: usize) {
        let n = self.n;
        for (k, &pivot) in self.pivots.iter().enumerate() {
            if pivot != k {
                let (upper, lower) = b.split_at_mut(pivot * columns);
                upper[k * columns..(k + 1) * columns].swap_with_slice(&mut lower[..columns]);
            }
        }
        if columns == 1 {
            for (i, row) in self.factors.chunks_exact(n).enumerate().skip(1) {
                let (done, rest) = b.split_at_mut(i);
                rest[0] -= dot(&row[..i], done);
            }
            for i in (0..n).rev() {
                let (head, done) = b.split_at_mut(i + 1);
                head[i] = (head[i] - dot(&self.factors[i * n + i + 1..(i + 1) * n], done)) * self.inverses[i];
            }
            return;
        }
        for i in 1..n {
            let (done, rest) = b.split_at_mut(i * columns);
            let target = &mut rest[..columns];
            for (k, row) in done.chunks_exact(columns).enumerate() {
                let factor = self.factors[i * n + k];
                axpy(target, -factor, row);
            }
        }
        for i in (0..n).rev() {
            let (head, done) = b.split_at_mut((i + 1) * columns);
            let target = &mut head[i * columns..];
            for (k, row) in done[..(n - 1 - i) * columns].chunks_exact(columns).enumerate() {
                axpy(target, -self.factors[i * n + i + 1 + k], row);
            }
            for t in target {
                *t *= self.inverses[i];
            }
        }
    }
}

/// Scaled pivots of an equilibrium's tangent below this may have lost their sign to rounding.
const LEAST_PIVOT: f64 = 1e-10;

impl Lu {
    /// Of the matrix factored with partial pivoting.
    pub fn determinant(&self) -> Determinant {
        let mut result = Determinant { sign: 1.0, ln: 0.0 };
        for (k, &pivot) in self.pivots.iter().enumerate() {
            let diagonal = self.factors[k * self.n + k];
            result.sign *= diagonal.signum() * if pivot == k { 1.0 } else { -1.0 };
            result.ln += diagonal.abs().ln();
        }
        result
    }

    /// Factors an n × n row-major matrix with partial pivoting.
    pub fn factor(&mut self, matrix: &[f64], n: usize) -> Result<(), Singular> {
        self.begin(n).copy_from_slice(&matrix[..n * n]);
        for k in 0..n {
            let mut pivot = k;
            let mut best = self.factors[k * n + k].abs();
            for i in k + 1..n {
                let candidate = self.factors[i * n + k].abs();
                if candidate > best {
                    (pivot, best) = (i, candidate);
                }
            }
            if !(best > 0.0 && best.is_finite()) {
                return Err(Singular);
            }
            self.pivots.push(pivot);
            let (upper, lower) = self.factors.split_at_mut((k + 1) * n);
            if pivot != k {
                upper[k * n..].swap_with_slice(&mut lower[(pivot - k - 1) * n..(pivot - k) * n]);
            }
            let row = &upper[k * n..];
            let inverse = 1.0 / row[k];
            self.inverses.push(inverse);
            for target in lower.chunks_exact_mut(n) {
                let factor = target[k] * inverse;
                target[k] = factor;
                if factor != 0.0 {
                    axpy(&mut target[k + 1..], -factor, &row[k + 1..]);
                }
            }
        }
        Ok(())
    }
}

/// y += a x.
#[inline]
pub(crate) fn axpy<S: Real>(y: &mut [S], a: S, x: &[S]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = y.plus(a, *x);
    }
}

/// y += a x with a table of numbers.
#[inline]
pub(crate) fn axpy_table<S: Real>(y: &mut [S], a: S, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = y.plus(a, S::splat(*x));
    }
}

/// x · y.
#[inline]
pub(crate) fn dot<S: Real>(x: &[S], y: &[S]) -> S {
    x.iter().zip(y).fold(S::zero(), |sum, (x, y)| sum.plus(*x, *y))
}

/// Σ w y with a table of weights.
#[inline]
pub(crate) fn dot_table<S: Real>(weights: &[f64], y: &[S]) -> S {
    weights.iter().zip(y).fold(S::zero(), |sum, (w, y)| sum.plus(*y, S::splat(*w)))
}

/// y += v₁ x₁ + v₂ x₂ + v₃ x₃ with the three rows of `x`, each as long as y, in the columns from `from` on.
#[inline]
pub(crate) fn add_rows<S: Real>(y: &mut [S], v: &Vector3<S>, x: &[S], from: usize) {
    let n = y.len();
    let (first, rest) = x.split_at(n);
    let (second, third) = rest.split_at(n);
    let (first, second, third) = (&first[from..], &second[from..], &third[from..]);
    for ((y, a), (b, c)) in y[from..].iter_mut().zip(first).zip(second.iter().zip(third)) {
        *y = y.plus(v.x, *a).plus(v.y, *b).plus(v.z, *c);
    }
}

/// u += a v.
#[inline]
pub(crate) fn add_scaled<S: Real>(u: &mut Vector3<S>, a: S, v: &Vector3<S>) {
    (u.x, u.y, u.z) = (u.x.plus(a, v.x), u.y.plus(a, v.y), u.z.plus(a, v.z));
}

/// u · v.
#[inline]
pub(crate) fn inner<S: Real>(u: &Vector3<S>, v: &Vector3<S>) -> S {
    (u.x * v.x).plus(u.y, v.y).plus(u.z, v.z)
}

/// M v, inlined: lanes stay in registers.
#[inline]
pub(crate) fn times<S: Real>(m: &Matrix3<S>, v: &Vector3<S>) -> Vector3<S> {
    Vector3::new(
        (m.m11 * v.x).plus(m.m12, v.y).plus(m.m13, v.z),
        (m.m21 * v.x).plus(m.m22, v.y).plus(m.m23, v.z),
        (m.m31 * v.x).plus(m.m32, v.y).plus(m.m33, v.z),
    )
}

/// A B, inlined.
#[inline]
pub(crate) fn product<S: Real>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let column = |x: S, y: S, z: S| times(a, &Vector3::new(x, y, z));
    let (x, y, z) = (column(b.m11, b.m21, b.m31), column(b.m12, b.m22, b.m32), column(b.m13, b.m23, b.m33));
    Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
}

/// u × v, inlined.
#[inline]
pub(crate) fn cross<S: Real>(u: &Vector3<S>, v: &Vector3<S>) -> Vector3<S> {
    Vector3::new((u.y * v.z).plus(-u.z, v.y), (u.z * v.x).plus(-u.x, v.z), (u.x * v.y).plus(-u.y, v.x))
}

/// A 3 × 3 matrix by its rows.
pub(crate) type Block<S> = [[S; 3]; 3];

/// a^.
#[inline]
pub(crate) fn hat<S: Real>(a: &Vector3<S>) -> Block<S> {
    let zero = S::zero();
    [[zero, -a.z, a.y], [a.z, zero, -a.x], [-a.y, a.x, zero]]
}

/// a^ M.
#[inline]
pub(crate) fn hat_times<S: Real>(a: &Vector3<S>, m: &Block<S>) -> Block<S> {
    let [x, y, z] = m;
    [
        [(a.y * z[0]).plus(-a.z, y[0]), (a.y * z[1]).plus(-a.z, y[1]), (a.y * z[2]).plus(-a.z, y[2])],
        [(a.z * x[0]).plus(-a.x, z[0]), (a.z * x[1]).plus(-a.x, z[1]), (a.z * x[2]).plus(-a.x, z[2])],
        [(a.x * y[0]).plus(-a.y, x[0]), (a.x * y[1]).plus(-a.y, x[1]), (a.x * y[2]).plus(-a.y, x[2])],
    ]
}

/// a^ b^ = b aᵀ − (a·b) 1.
#[inline]
pub(crate) fn hat_hat<S: Real>(a: &Vector3<S>, b: &Vector3<S>) -> Block<S> {
    let (x, y, z) = (a.x * b.x, a.y * b.y, a.z * b.z);
    [[-(y + z), b.x * a.y, b.x * a.z], [b.y * a.x, -(x + z), b.y * a.z], [b.z * a.x, b.z * a.y, -(x + y)]]
}

/// Column `i` of three rows of length n.
#[inline]
pub(crate) fn column<S: Real>(rows: &[S], n: usize, i: usize) -> Vector3<S> {
    Vector3::new(rows[i], rows[n + i], rows[2 * n + i])
}

/// Sets column `i` of three rows of length n.
#[inline]
pub(crate) fn set_column<S: Real>(rows: &mut [S], n: usize, i: usize, v: &Vector3<S>) {
    (rows[i], rows[n + i], rows[2 * n + i]) = (v.x, v.y, v.z);
}

#[cfg(test)]
mod tests {
    use super::Lu;

    #[test]
    fn solves_and_sees_singularity() {
        let n = 5;
        let a: Vec<f64> =
            (0..25).map(|i| f64::from((i * 7 + 3) % 11) - 5.0 + f64::from(u8::from(i % 6 == 2))).collect();
        let x: Vec<f64> = (0..5).map(|i| 1.0 - f64::from(i)).collect();
        let b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum()).collect();
        let mut lu = Lu::default();
        for columns in [1, 2] {
            lu.factor(&a, n).unwrap();
            let mut right: Vec<f64> = b.iter().flat_map(|v| vec![*v; columns]).collect();
            lu.solve(&mut right, columns);
            for i in 0..n {
                assert!((right[i * columns] - x[i]).abs() < 1e-12);
            }
        }
        assert!(lu.factor(&[1.0, 2.0, 2.0, 4.0], 2).is_err());
        lu.factor(&[0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 5.0, 1.0, 4.0], 3).unwrap();
        let determinant = lu.determinant();
        assert!((determinant.sign * determinant.ln.exp() - 30.0).abs() < 1e-13);
    }

    #[test]
    fn elimination_in_order_counts_signs() {
        // Positive on the first two, with one condition.
        let saddle = [4.0, 1.0, 1.0, 1.0, 3.0, -2.0, 1.0, -2.0, 0.0];
        let mut lu = Lu::default();
        assert_eq!(lu.factor_in_order(&saddle, 3, 2), 1);
        let x = [0.5, -1.5, 2.0];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| saddle[i * 3 + j] * x[j]).sum()).collect();
        lu.solve(&mut b, 1);
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14));
        let mut indefinite = saddle;
        indefinite[4] = 0.1;
        assert_eq!(lu.factor_in_order(&indefinite, 3, 2), 0);
    }
}
