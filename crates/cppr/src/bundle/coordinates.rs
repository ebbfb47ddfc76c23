//! Conditions that an integration leaves, and coordinates of its unknowns in which their effects stay apart.
//!
//! Along tubes that bend far the slopes of the states by the unknowns at the plate grow exponentially, all towards the same few directions, until rounding
//! leaves nothing of their differences. Where they have grown, the conditions met so far take as many coordinates away, and the others are
//! exchanged for new ones by which the state has orthonormal slopes (Godunov 1961; Conte 1966; the stabilised march of Ascher, Mattheij and Russell 1995).
//! With the old coordinates v, the new ones w and what is given g, v = T w + t g. From what w is found to be at the tip, v follows
//! backwards, where what has grown decays.

use super::number::Number;
use nalgebra::DMatrix;

/// Slopes in scaled variables beyond which coordinates are exchanged.
const GROWN: f64 = 1e3;
/// Factor by which slopes that are as great may grow in one step: e³, where the integration still follows what grows and what decays.
const GROWTH: f64 = 20.0;
/// Pivots below this part of the greatest are zero: then coordinates stay as they are.
const SINGULAR: f64 = 1e-12;

/// What is left of one condition, in units of its own.
#[derive(Clone, Debug)]
struct Left {
    value: f64,
    slopes: Vec<f64>,
}

/// Conditions and coordinates of one integration. Numbers have slopes by the coordinates, by what is given, and by the gap between steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Coordinates {
    /// How many unknowns there are.
    unknowns: usize,
    conditions: Vec<Left>,
    /// How many of them have taken coordinates away.
    used: usize,
    /// Which were taken away.
    gone: Vec<usize>,
    /// Slopes before every exchange by those after it.
    exchanges: Vec<DMatrix<f64>>,
    /// Product of the determinants of what was exchanged.
    pub determinant: f64,
}

/// How far an integration had come.
pub(super) struct Mark {
    used: usize,
    gone: usize,
    exchanges: usize,
    determinant: f64,
}

impl Coordinates {
    /// An integration with so many unknowns begins.
    pub fn begin(unknowns: usize) -> Self {
        Self { unknowns, determinant: 1.0, ..Self::default() }
    }

    pub fn mark(&self) -> Mark {
        let Self { used, determinant, .. } = *self;
        Mark { used, gone: self.gone.len(), exchanges: self.exchanges.len(), determinant }
    }

    /// Forgets what came after a mark; conditions did not.
    pub fn back_to(&mut self, mark: &Mark) {
        (self.used, self.determinant) = (mark.used, mark.determinant);
        self.gone.truncate(mark.gone);
        self.exchanges.truncate(mark.exchanges);
    }

    /// Coordinates that were taken away, with the number of exchanges.
    pub fn gone(&self) -> Vec<usize> {
        self.gone.iter().copied().chain([self.stage()]).collect()
    }

    /// Number of exchanges so far.
    pub fn stage(&self) -> usize {
        self.exchanges.len()
    }

    /// Leaves a condition.
    pub fn leave<S: Number>(&mut self, left: S, unit: f64) {
        let slopes = left.slopes().iter().map(|s| s / unit).collect();
        self.conditions.push(Left { value: left.value() / unit, slopes });
    }

    /// Greatest of what is left.
    pub fn greatest(&self) -> f64 {
        self.conditions.iter().fold(0.0, |most, own| f64::max(most, own.value.abs()))
    }

    /// Greatest slope by a coordinate; `scales` are the units of the values that others depend on.
    fn size<S: Number>(&self, values: &[S], scales: &[f64]) -> f64 {
        let size = |(value, scale): (&S, &f64)| {
            let own = value.slopes().iter().take(self.unknowns);
            own.fold(0.0, |most: f64, slope| most.max(slope.abs())) / scale
        };
        values.iter().zip(scales).map(size).fold(0.0, f64::max)
    }

    /// How many times longer a step is than slopes may grow in one, from values to others.
    pub fn overgrowth<S: Number>(&self, from: &[S], to: &[S], scales: &[f64]) -> f64 {
        let [before, after] = [from, to].map(|values| self.size(values, scales));
        if after > GROWN || self.stage() > 0 && before > 0.0 {
            (after / before).ln() / GROWTH.ln()
        } else {
            0.0
        }
    }

    /// Exchanges coordinates where slopes of the state have grown.
    pub fn exchange<S: Number>(&mut self, values: &mut [S], scales: &[f64]) {
        let width = values.first().map_or(0, |value| value.slopes().len());
        if width == 0 || self.size(values, scales) <= GROWN {
            return;
        }
        let dependent = &values[..scales.len()];
        if let Some((matrix, gone, determinant)) = self.exchanged(dependent, scales, width) {
            for value in values {
                let old = value.slopes().to_vec();
                for (slope, column) in value.slopes_mut().iter_mut().zip(matrix.column_iter()) {
                    *slope = old.iter().zip(column.iter()).map(|(a, b)| a * b).sum();
                }
            }
            self.used = self.conditions.len();
            self.gone.extend(gone);
            self.determinant *= determinant;
            self.exchanges.push(matrix);
        }
    }

    /// Slopes before by slopes after, coordinates that go, and determinant; `None` where effects are the same.
    fn exchanged<S: Number>(
        &self,
        values: &[S],
        scales: &[f64],
        width: usize,
    ) -> Option<(DMatrix<f64>, Vec<usize>, f64)> {
        let n = self.unknowns;
        let conditions = &self.conditions[self.used..];
        let matters = |slot: &usize| {
            values.iter().any(|value| value.slopes()[*slot].abs() > 0.0)
                || conditions.iter().any(|own| own.slopes[*slot].abs() > 0.0)
        };
        let own: Vec<usize> = (0..n).filter(|slot| !self.gone.contains(slot)).filter(matters).collect();
        let kept =
            own.len().checked_sub(conditions.len()).filter(|kept| (1..=values.len()).contains(kept))?;
        let slopes = DMatrix::from_fn(values.len(), width, |i, j| values[i].slopes()[j] / scales[i]);
        let (by_own, by_given) = (slopes.select_columns(&own), slopes.columns(n, width - n));
        // v = free · w + fixed · g meets the conditions.
        let (free, fixed, determinant) = met(conditions, &own, n, width)?;
        let qr = (&by_own * &free).qr();
        let (q, r) = (qr.q(), qr.r());
        let diagonal = r.diagonal();
        if diagonal.amin() <= SINGULAR * diagonal.amax() {
            return None;
        }
        let inverse = r.solve_upper_triangular(&DMatrix::identity(kept, kept))?;
        let by_new = free * inverse;
        let offset = q.transpose() * (by_given + by_own * &fixed);
        let by_given = fixed - &by_new * offset;
        let mut matrix = DMatrix::identity(width, width);
        for (i, &row) in own.iter().enumerate() {
            matrix[(row, row)] = 0.0;
            for (j, &column) in own.iter().take(kept).enumerate() {
                matrix[(row, column)] = by_new[(i, j)];
            }
            for k in 0..width - n {
                matrix[(row, n + k)] = by_given[(i, k)];
            }
        }
        Some((matrix, own[kept..].to_vec(), determinant * diagonal.product()))
    }

    /// What is left at the end and its slopes by the last coordinates, and by `given` more inputs. Coordinates that are gone have a row that
    /// keeps them at zero. `None` where there are not as many conditions as unknowns.
    pub fn system(&self, given: usize) -> Option<(DMatrix<f64>, Vec<f64>)> {
        let n = self.unknowns;
        let mut matrix = DMatrix::zeros(n, n + given);
        let mut residual = vec![0.0; n];
        let mut conditions = self.conditions[self.used..].iter();
        for slot in 0..n {
            if self.gone.contains(&slot) {
                matrix[(slot, slot)] = 1.0;
                continue;
            }
            let own = conditions.next()?;
            for (column, slope) in own.slopes.iter().enumerate().take(n + given) {
                matrix[(slot, column)] = *slope;
            }
            residual[slot] = own.value + own.slopes.last().copied().unwrap_or(0.0);
        }
        conditions.next().is_none().then_some((matrix, residual))
    }

    /// Coordinates at every stage, that of the plate first, from what they and the given inputs are at the last: one column for each case.
    pub fn stages(&self, last: DMatrix<f64>) -> Vec<DMatrix<f64>> {
        let mut stages = vec![last];
        for exchange in self.exchanges.iter().rev() {
            stages.extend(stages.last().map(|after| exchange * after));
        }
        stages.reverse();
        stages
    }
}

/// What conditions on `own` coordinates leave free of them, and how they depend on what is given; and the determinant of the conditions.
fn met(
    conditions: &[Left],
    own: &[usize],
    first: usize,
    width: usize,
) -> Option<(DMatrix<f64>, DMatrix<f64>, f64)> {
    let (many, given) = (conditions.len(), width - first);
    if many == 0 {
        return Some((DMatrix::identity(own.len(), own.len()), DMatrix::zeros(own.len(), given), 1.0));
    }
    let mut rows = DMatrix::from_fn(many, own.len(), |i, j| conditions[i].slopes[own[j]]);
    let mut by_given = DMatrix::from_fn(many, given, |i, j| conditions[i].slopes[first + j]);
    // The gap is what is left besides.
    for (i, own) in conditions.iter().enumerate() {
        by_given[(i, given - 1)] += own.value;
    }
    let mut determinant = 1.0;
    for (mut row, mut given) in rows.row_iter_mut().zip(by_given.row_iter_mut()) {
        let size = row.norm();
        determinant *= size;
        row /= size;
        given /= size;
    }
    let qr = rows.col_piv_qr();
    let (q, r) = (qr.q(), qr.r());
    let left = r.columns(0, many);
    let diagonal = left.diagonal();
    if !determinant.is_normal() || diagonal.amin() <= SINGULAR * diagonal.amax() {
        return None;
    }
    determinant *= diagonal.product() * q.determinant() * qr.p().determinant::<f64>();
    let rest = own.len() - many;
    let mut free = -left.solve_upper_triangular(&r.columns(many, rest))?;
    free = free.insert_rows(many, rest, 0.0);
    free.view_mut((many, 0), (rest, rest)).fill_with_identity();
    let fixed = -left.solve_upper_triangular(&(q.transpose() * by_given))?;
    let mut fixed = fixed.insert_rows(many, rest, 0.0);
    qr.p().inv_permute_rows(&mut free);
    qr.p().inv_permute_rows(&mut fixed);
    Some((free, fixed, determinant))
}
