//! Friction between neighbouring tubes, as the integration along the bundle meets it.
//!
//! Where tube j lies in tube i, a small motion makes them slip on each other by
//!
//! ```text
//! σ = δx_j/x_j' − δx_i/x_i'                                        along, per centreline length
//! ρ = r [(δα_j − α_j' δx_j/x_j') − (δα_i − α_i' δx_i/x_i')]        around, r the radius at which they touch
//! ```
//!
//! (δx and δα at a fixed section; the terms with α' are there since what slides through a section brings its own angle along). Friction f per length does the
//! work −∫ (f_σ σ + f_ρ ρ) ds, so that Hamilton's equations of both tubes become, with the upper sign for the inner one,
//!
//! ```text
//! T' = −∂G/∂x ∓ (f_σ − r α' f_ρ)/x' ,    π' = ∂G/∂α ± r f_ρ .
//! ```
//!
//! What the pair has in common cancels in the Hamiltonian, which stays as constant as it is without friction. The force is given beforehand (slip that is
//! prescribed), or that of a history: t = t_before + k · (slip since then) as long as |t| is below the limit μ |p|, and of this size beyond.

use super::number::Number;

/// Rows along a pair: events passed before the span, the outer tube's label (m), values.
pub(super) type Columns<const C: usize> = Vec<(usize, f64, [f64; C])>;

/// What is known along the outer tube of a pair, by its label (m): in every span cubic between nodes, constant beyond the ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table<const C: usize> {
    /// Spans by the events passed before them, and the first node of each.
    spans: Vec<(usize, usize)>,
    at: Vec<f64>,
    /// Value and slope of every column.
    rows: Vec<[[f64; 2]; C]>,
}

impl<const C: usize> Table<C> {
    /// Of rows in spans on which they are smooth.
    pub fn new(rows: &[(usize, f64, [f64; C])]) -> Self {
        let mut table =
            Self { spans: Vec::new(), at: rows.iter().map(|row| row.1).collect(), rows: Vec::new() };
        for span in rows.chunk_by(|a, b| a.0 == b.0) {
            table.spans.push((span[0].0, table.rows.len()));
            let labels: Vec<f64> = span.iter().map(|row| row.1).collect();
            let columns: [Vec<f64>; C] = std::array::from_fn(|c| {
                slopes(&labels, &span.iter().map(|row| row.2[c]).collect::<Vec<_>>())
            });
            let own = span.iter().enumerate();
            table.rows.extend(own.map(|(i, row)| std::array::from_fn(|c| [row.2[c], columns[c][i]])));
        }
        table
    }

    /// All columns at a label, where so many events are passed. A span that is not known takes what the one before it has at its end.
    pub fn at<S: Number>(&self, passed: usize, label: S) -> [S; C] {
        let x = label.value();
        let beyond = self.spans.partition_point(|span| span.0 <= passed).max(1);
        let first = self.spans.get(beyond - 1).map_or(0, |span| span.1);
        let end = self.spans.get(beyond).map_or(self.at.len(), |span| span.1);
        let (at, rows) = (&self.at[first..end], &self.rows[first..end]);
        let next = at.partition_point(|at| *at <= x);
        let (Some(before), Some(beyond)) = (next.checked_sub(1), at.get(next)) else {
            let end = if next == 0 { rows.first() } else { rows.last() };
            return std::array::from_fn(|c| S::constant(end.map_or(0.0, |row| row[c][0])));
        };
        let (a, b, way) = (&rows[before], &rows[next], beyond - at[before]);
        let t = (x - at[before]) / way;
        std::array::from_fn(|c| {
            let ([from, slope], [to, end]) = (a[c], b[c]);
            // Hermite's cubic: from + t (m + t (p + t q)).
            let (m, rise) = (slope * way, to - from);
            let (p, q) = (3.0 * rise - 2.0 * m - end * way, m + end * way - 2.0 * rise);
            let value = from + t * (m + t * (p + t * q));
            label.chain(value, (m + t * (2.0 * p + 3.0 * t * q)) / way)
        })
    }
}

/// Slopes at the nodes of the polynomials through each and its nearest neighbours, five nodes together.
pub(super) fn slopes(at: &[f64], values: &[f64]) -> Vec<f64> {
    let most = at.len().min(5);
    (0..at.len())
        .map(|own| {
            let first = own.saturating_sub(most / 2).min(at.len() - most);
            let others = (first..first + most).filter(|j| *j != own);
            others
                .map(|j| {
                    let rest = (first..first + most).filter(|l| *l != j && *l != own);
                    let weight: f64 = rest.map(|l| (at[own] - at[l]) / (at[j] - at[l])).product();
                    weight * (values[j] - values[own]) / (at[j] - at[own])
                })
                .sum()
        })
        .collect()
}

/// How the tubes of a pair rub.
#[derive(Clone, Debug)]
pub(crate) enum Law {
    /// f_σ and f_ρ (N/m).
    Given(Table<2>),
    /// By what went before.
    History {
        /// μ |p| (N/m).
        limit: Table<1>,
        /// Of the state before: x_j − x_i (m), α_j − α_i (rad), t along and around (N/m).
        before: Table<4>,
        /// k (N/m²).
        stiffness: f64,
    },
}

/// A tube and the one around it.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    pub outer: usize,
    pub inner: usize,
    /// Radius at which they touch (m).
    pub radius: f64,
    pub law: Law,
}

/// Label, rotation, and their rates by s of one tube of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<S> {
    pub label: S,
    pub angle: S,
    pub advance: S,
    pub twist: S,
}

/// Half the exponent in |f| = |t| (1 + (|t|/limit)^2n)^(−1/2n), which rounds the corner between sticking and slipping.
const SHARP: i32 = 4;
/// How far beyond the limit t is kept: there |f| is within half a percent of the limit.
pub(crate) const BEYOND: f64 = 1.5;

impl Pair {
    /// Friction along and around (N/m).
    pub fn force<S: Number>(&self, passed: usize, outer: &Side<S>, inner: &Side<S>) -> [S; 2] {
        match &self.law {
            Law::Given(table) => table.at(passed, outer.label),
            Law::History { limit, .. } => {
                let [along, around] = self.trial(passed, outer, inner);
                let [limit] = limit.at(passed, outer.label);
                if limit.value() <= f64::MIN_POSITIVE.sqrt() {
                    return [S::constant(0.0); 2];
                }
                let over = (along * along + around * around) / (limit * limit);
                let size = over.value();
                // (1 + q⁴)^(−1/8) and its slope.
                let (fourth, n) = (size.powi(SHARP), f64::from(SHARP));
                let share = if fourth.is_finite() { (1.0 + fourth).powf(-0.5 / n) } else { size.powf(-0.5) };
                let slope = if size > 0.0 { -0.5 * share / size / (1.0 + 1.0 / fourth) } else { 0.0 };
                let share = over.chain(share, slope);
                [along * share, around * share]
            }
        }
    }

    /// t along and around (N/m), before it is held to its limit.
    pub fn trial<S: Number>(&self, passed: usize, outer: &Side<S>, inner: &Side<S>) -> [S; 2] {
        let Law::History { before, stiffness, .. } = &self.law else { return [S::constant(0.0); 2] };
        let [lag, turn, along, around] = before.at(passed, outer.label);
        let slip = (inner.label - outer.label - lag) / inner.advance;
        let turned = inner.angle - outer.angle - turn - inner.twist * slip;
        [along + slip * *stiffness, around + turned * (self.radius * stiffness)]
    }

    /// Does the pair slip on in this step? What is beyond the limit from before and goes back does not.
    pub fn slips(&self, passed: usize, outer: &Side<f64>, inner: &Side<f64>) -> bool {
        let Law::History { limit, before, .. } = &self.law else { return false };
        let ([along, around], [limit]) = (self.trial(passed, outer, inner), limit.at(passed, outer.label));
        let [.., was_along, was_around] = before.at(passed, outer.label);
        let onwards = along * (along - was_along) + around * (around - was_around);
        limit > 0.0 && along.hypot(around) >= limit && onwards > 0.0
    }
}

/// Friction of all pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rubbing(pub Vec<Pair>);

impl Rubbing {
    /// The pair of two tubes that lie next to each other.
    pub fn pair(&self, outer: usize, inner: usize) -> Option<&Pair> {
        self.0.iter().find(|pair| (pair.outer, pair.inner) == (outer, inner))
    }
}

#[cfg(test)]
mod tests {
    use super::{Table, slopes};
    use crate::bundle::number::{Dual, Number};

    /// Five nodes give the slope of a quartic; the cubics between nodes pass through them with it, and a jump stays one.
    #[test]
    fn slopes_and_cubics() {
        let quartic = |x: f64| 1.0 + x * (2.0 - x * (3.0 - x * (0.5 + 0.7 * x)));
        let slope = |x: f64| 2.0 - 6.0 * x + 1.5 * x * x + 2.8 * x * x * x;
        let at = [0.0, 0.1, 0.25, 0.4, 0.5, 0.7, 0.8];
        let values = at.map(quartic);
        for (x, own) in at.iter().zip(slopes(&at, &values)) {
            assert!((own - slope(*x)).abs() < 1e-12, "{x}");
        }
        let rows: Vec<_> =
            at.iter().map(|x| (0, *x, [quartic(*x)])).chain([(1, 0.8, [9.0]), (1, 1.0, [9.0])]).collect();
        let table = Table::new(&rows);
        let [inside] = table.at(0, Dual::<2>::input(0.3, 0));
        assert!(
            (inside.value() - quartic(0.3)).abs() < 1e-4 && (inside.slopes()[0] - slope(0.3)).abs() < 1e-2
        );
        assert!(
            (table.at(1, 0.8)[0] - 9.0).abs() < 1e-12 && (table.at(0, 0.8)[0] - quartic(0.8)).abs() < 1e-12
        );
        assert!((table.at(0, -1.0)[0] - 1.0).abs() < 1e-12 && (table.at(7, 2.0)[0] - 9.0).abs() < 1e-12);
    }
}
