//! What a sampled sweep says of tolerances: mean, deviation and percentiles of every output, and which input matters.
//!
//! Over the stable poses, with covariances C over the inputs x and c between them and an output y, the linear fit has the slopes
//! b = C⁻¹ c. An input with the standard deviation σ moves the output by |b| σ and makes the share (b σ)² of its variance, where
//! the inputs are independent, as samples are; the fit as a whole explains b·c of it. What the fit leaves is curvature and products of inputs.

use crate::table::{Chunk, ColumnKind, Verdict};
use crate::task::Task;
use nalgebra::{DMatrix, DVector};

/// Percentiles that are given.
pub const PERCENTILES: [f64; 3] = [5.0, 50.0, 95.0];
/// Values that are kept for percentiles, per output; of more rows every second, fourth, … is kept.
const MOST: usize = 1 << 15;
/// Deviations below this part of the mean, or of a unit where the mean is less, are rounding.
const ROUNDING: f64 = 1e-12;

/// Statistics of one output over the stable poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Column of the table, unit at its end.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation of the sample.
    pub deviation: f64,
    /// [`PERCENTILES`], interpolated between order statistics.
    pub percentiles: [f64; 3],
    /// Least and greatest value.
    pub range: [f64; 2],
}

/// What an input does to the tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    /// Column of the table.
    pub name: String,
    /// Standard deviation of the input, in its unit.
    pub deviation: f64,
    /// How far one such deviation moves the tip (m).
    pub tip: f64,
    /// Its share of the variance of the tip's position (-).
    pub share: f64,
}

/// The whole study.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Stable poses, which all of this is about.
    pub count: u64,
    /// Outputs that vary, in the order of the table.
    pub outputs: Vec<Statistics>,
    /// Inputs, the most important first; empty where there are too few poses to tell.
    pub inputs: Vec<Influence>,
    /// Part of the tip's variance that is linear in the inputs (-); NaN without inputs.
    pub linear: f64,
}

/// Gathers a sweep chunk by chunk.
#[derive(Clone, Debug)]
pub struct Study {
    status: usize,
    inputs: usize,
    /// Columns: the inputs, then the outputs.
    columns: Vec<(usize, String)>,
    /// Values of the first stable pose: sums are taken about them, so that small deviations keep their digits.
    about: Vec<f64>,
    count: u64,
    sum: DVector<f64>,
    products: DMatrix<f64>,
    range: Vec<[f64; 2]>,
    kept: Vec<Vec<f64>>,
    stride: u64,
}

impl Study {
    /// Of a task.
    #[must_use]
    pub fn new(task: &Task) -> Self {
        let all = task.columns();
        let status = all.iter().position(|c| c.kind == ColumnKind::Status).unwrap_or_default();
        // Quaternions and places have no mean worth telling.
        let summarised =
            |name: &str| !(name.starts_with("tip_q") || name.ends_with("_x_m") && !name.starts_with("tip"));
        let columns: Vec<(usize, String)> = all
            .into_iter()
            .enumerate()
            .filter(|(_, column)| column.kind == ColumnKind::Number && summarised(&column.name))
            .map(|(index, column)| (index, column.name))
            .collect();
        let width = columns.len();
        Self {
            status,
            inputs: columns.iter().filter(|(index, _)| *index < status).count(),
            columns,
            about: Vec::new(),
            count: 0,
            sum: DVector::zeros(width),
            products: DMatrix::zeros(width, width),
            range: vec![[f64::INFINITY, f64::NEG_INFINITY]; width],
            kept: vec![Vec::new(); width],
            stride: 1,
        }
    }

    /// Takes the stable poses of a chunk.
    pub fn visit(&mut self, chunk: &Chunk) {
        for row in 0..chunk.rows {
            if Verdict::from_code(chunk.column(self.status)[row]) != Some(Verdict::Converged) {
                continue;
            }
            let values: Vec<f64> = self.columns.iter().map(|(index, _)| chunk.column(*index)[row]).collect();
            if self.about.is_empty() {
                self.about.clone_from(&values);
            }
            if self.count % self.stride == 0 {
                self.kept.iter_mut().zip(&values).for_each(|(kept, value)| kept.push(*value));
            }
            self.count += 1;
            for (range, value) in self.range.iter_mut().zip(&values) {
                *range = [range[0].min(*value), range[1].max(*value)];
            }
            let off = DVector::from_iterator(
                values.len(),
                values.iter().zip(&self.about).map(|(value, about)| value - about),
            );
            self.products.ger(1.0, &off, &off, 1.0);
            self.sum += off;
            if self.kept.first().is_some_and(|kept| kept.len() > MOST) {
                self.stride *= 2;
                for kept in &mut self.kept {
                    let mut odd = true;
                    kept.retain(|_| {
                        odd = !odd;
                        !odd
                    });
                }
            }
        }
    }

    /// What was gathered; none of fewer than two stable poses.
    #[must_use]
    pub fn report(&self) -> Option<Report> {
        if self.count < 2 {
            return None;
        }
        let n = self.count as f64;
        let mean = &self.sum / n;
        let covariance = (&self.products - &self.sum * mean.transpose()) / (n - 1.0);
        let deviation = |i: usize| covariance[(i, i)].max(0.0).sqrt();
        let outputs = (self.inputs..self.columns.len())
            .filter_map(|i| {
                let mut sorted = self.kept[i].clone();
                sorted.sort_by(f64::total_cmp);
                let statistics = Statistics {
                    name: self.columns[i].1.clone(),
                    mean: self.about[i] + mean[i],
                    deviation: deviation(i),
                    percentiles: PERCENTILES.map(|percent| quantile(&sorted, percent / 100.0)),
                    range: self.range[i],
                };
                (statistics.deviation > ROUNDING * statistics.mean.abs().max(1.0)).then_some(statistics)
            })
            .collect();
        let (inputs, linear) = self.influences(&covariance).unwrap_or((Vec::new(), f64::NAN));
        Some(Report { count: self.count, outputs, inputs, linear })
    }

    fn influences(&self, covariance: &DMatrix<f64>) -> Option<(Vec<Influence>, f64)> {
        let k = self.inputs;
        let tip: Vec<usize> = ["tip_x_m", "tip_y_m", "tip_z_m"]
            .iter()
            .filter_map(|name| self.columns.iter().position(|(_, own)| own == name))
            .collect();
        let variance: f64 = tip.iter().map(|&j| covariance[(j, j)]).sum();
        // As many poses again as the fit has numbers.
        if self.count < 2 * (k as u64 + 1) || variance.is_nan() || variance <= 0.0 {
            return None;
        }
        // Inputs in units of their deviations, whatever their own units.
        let deviations: Vec<f64> = (0..k).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
        let correlation = DMatrix::from_fn(k, k, |i, j| covariance[(i, j)] / (deviations[i] * deviations[j]));
        let responses = DMatrix::from_fn(k, tip.len(), |i, j| covariance[(i, tip[j])] / deviations[i]);
        let slopes = correlation.cholesky()?.solve(&responses);
        let mut inputs: Vec<Influence> = (0..k)
            .map(|i| Influence {
                name: self.columns[i].1.clone(),
                deviation: deviations[i],
                tip: slopes.row(i).norm(),
                share: slopes.row(i).norm_squared() / variance,
            })
            .collect();
        inputs.sort_by(|a, b| b.share.total_cmp(&a.share));
        Some((inputs, slopes.component_mul(&responses).sum() / variance))
    }
}

/// The value below which a share of a sorted sample lies, interpolated; NaN sorts last and is reached last.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len().saturating_sub(1)) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index of the sample")]
    let below = at.floor() as usize;
    match sorted.get(below..) {
        Some([low, high, ..]) => low + (at - at.floor()) * (high - low),
        Some([last]) => *last,
        _ => f64::NAN,
    }
}
