//! Systems of equations whose matrix has entries near its diagonal alone: elimination with row exchanges, in linear time.

/// A square matrix with `reach` diagonals on either side.
pub(super) struct Banded {
    order: usize,
    reach: usize,
    /// Row by row; column j of row i stands at j − i + reach. Row exchanges fill up to 2·`reach` diagonals on the right.
    rows: Vec<f64>,
}

impl Banded {
    pub fn zeros(order: usize, reach: usize) -> Self {
        Self { order, reach, rows: vec![0.0; order * (3 * reach + 1)] }
    }

    fn at(&self, i: usize, j: usize) -> usize {
        i * (3 * self.reach + 1) + (j + self.reach - i)
    }

    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.at(i, j);
        self.rows[at] += value;
    }

    /// Solves in place. `None` where the matrix is singular.
    pub fn solve(mut self, mut right: Vec<f64>) -> Option<Vec<f64>> {
        let (n, reach) = (self.order, self.reach);
        for k in 0..n {
            let below = (k + reach + 1).min(n);
            let size = |i: usize| self.rows[self.at(i, k)].abs();
            let pivot = (k..below).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
            let across = (k + 2 * reach + 1).min(n);
            if pivot != k {
                for j in k..across {
                    let (a, b) = (self.at(k, j), self.at(pivot, j));
                    self.rows.swap(a, b);
                }
                right.swap(k, pivot);
            }
            let inverse = 1.0 / self.rows[self.at(k, k)];
            if !inverse.is_finite() {
                return None;
            }
            let (from, width) = (self.at(k, k), across - k);
            for i in k + 1..below {
                let to = self.at(i, k);
                let factor = self.rows[to] * inverse;
                if factor.abs() > 0.0 {
                    let (above, own) = self.rows.split_at_mut(to);
                    for (own, above) in own[..width].iter_mut().zip(&above[from..from + width]) {
                        *own -= factor * above;
                    }
                    right[i] -= factor * right[k];
                }
            }
        }
        for k in (0..n).rev() {
            let across = (k + 2 * reach + 1).min(n);
            let sum: f64 = (k + 1..across).map(|j| self.rows[self.at(k, j)] * right[j]).sum();
            right[k] = (right[k] - sum) / self.rows[self.at(k, k)];
        }
        right.iter().all(|own| own.is_finite()).then_some(right)
    }
}

#[cfg(test)]
mod tests {
    use super::Banded;

    /// Against the product, with a zero on the diagonal, so that rows are exchanged.
    #[test]
    fn solves_with_row_exchanges() {
        let (n, reach) = (40, 3);
        let value = |i: usize, j: usize| {
            if i == j && i % 3 == 0 {
                0.0
            } else {
                ((7 * i + 11 * j) % 13) as f64 - 6.0 + f64::from(u8::from(j == i + 1)) * 9.0
            }
        };
        let mut matrix = Banded::zeros(n, reach);
        let known: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut right = vec![0.0; n];
        for i in 0..n {
            for j in i.saturating_sub(reach)..(i + reach + 1).min(n) {
                matrix.add(i, j, value(i, j));
                right[i] += value(i, j) * known[j];
            }
        }
        let found = matrix.solve(right).unwrap();
        let off = found.iter().zip(&known).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{off}");
    }
}
