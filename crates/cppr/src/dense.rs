//! Small dense linear algebra on row-major slices, without allocation: the sizes are those of one
//! equilibrium, at most a few tens.

/// LU factors with partial pivoting. The buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu {
    n: usize,
    factors: Vec<f64>,
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

impl Lu {
    /// Factors an n × n row-major matrix.
    pub fn factor(&mut self, matrix: &[f64], n: usize) -> Result<(), Singular> {
        self.n = n;
        self.factors.clear();
        self.factors.extend_from_slice(&matrix[..n * n]);
        self.pivots.clear();
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
            for target in lower.chunks_exact_mut(n) {
                let factor = target[k] * inverse;
                target[k] = factor;
                if factor != 0.0 {
                    for (t, r) in target[k + 1..].iter_mut().zip(&row[k + 1..]) {
                        *t -= factor * r;
                    }
                }
            }
        }
        Ok(())
    }

    /// Of the factored matrix.
    pub fn determinant(&self) -> Determinant {
        let mut result = Determinant { sign: 1.0, ln: 0.0 };
        for (k, &pivot) in self.pivots.iter().enumerate() {
            let diagonal = self.factors[k * self.n + k];
            result.sign *= diagonal.signum() * if pivot == k { 1.0 } else { -1.0 };
            result.ln += diagonal.abs().ln();
        }
        result
    }

    /// Solves A X = B in place; B is n × columns, row-major.
    pub fn solve(&self, b: &mut [f64], columns: usize) {
        let n = self.n;
        for (k, &pivot) in self.pivots.iter().enumerate() {
            if pivot != k {
                let (upper, lower) = b.split_at_mut(pivot * columns);
                upper[k * columns..(k + 1) * columns].swap_with_slice(&mut lower[..columns]);
            }
        }
        for i in 1..n {
            let (done, rest) = b.split_at_mut(i * columns);
            let target = &mut rest[..columns];
            for (k, row) in done.chunks_exact(columns).enumerate() {
                axpy(target, -self.factors[i * n + k], row);
            }
        }
        for i in (0..n).rev() {
            let (head, done) = b.split_at_mut((i + 1) * columns);
            let target = &mut head[i * columns..];
            for (k, row) in done[..(n - 1 - i) * columns].chunks_exact(columns).enumerate() {
                axpy(target, -self.factors[i * n + i + 1 + k], row);
            }
            let inverse = 1.0 / self.factors[i * n + i];
            for t in target {
                *t *= inverse;
            }
        }
    }
}

/// Is a symmetric matrix positive definite? Its lower half is overwritten by the Cholesky factor.
pub(crate) fn is_positive(matrix: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let (head, own) = matrix.split_at(i * n);
            let row_j = if j == i { &own[..j] } else { &head[j * n..j * n + j] };
            let rest = own[j] - dot(&own[..j], row_j);
            if j < i {
                matrix[i * n + j] = rest / matrix[j * n + j];
            } else if rest > 0.0 {
                matrix[i * n + i] = rest.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// y += a x.
#[inline]
pub(crate) fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// x · y.
#[inline]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::{Lu, is_positive};

    #[test]
    fn solves_and_sees_singularity() {
        let n = 5;
        let a: Vec<f64> =
            (0..25).map(|i| f64::from((i * 7 + 3) % 11) - 5.0 + f64::from(u8::from(i % 6 == 2))).collect();
        let x: Vec<f64> = (0..5).map(|i| 1.0 - f64::from(i)).collect();
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum()).collect();
        let mut lu = Lu::default();
        lu.factor(&a, n).unwrap();
        lu.solve(&mut b, 1);
        for i in 0..n {
            assert!((b[i] - x[i]).abs() < 1e-12);
        }
        assert!(lu.factor(&[1.0, 2.0, 2.0, 4.0], 2).is_err());
        lu.factor(&[0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 5.0, 1.0, 4.0], 3).unwrap();
        let determinant = lu.determinant();
        assert!((determinant.sign * determinant.ln.exp() - 30.0).abs() < 1e-13);
    }

    #[test]
    fn knows_a_positive_matrix() {
        let definite = [4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 6.0];
        assert!(is_positive(&mut definite.clone(), 3));
        let mut saddle = definite;
        saddle[8] = 0.9;
        assert!(!is_positive(&mut saddle, 3));
    }
}
