//! Steps of the integration over one span: chosen by their estimated error, or taken again as they were.
//!
//! Repeated steps make the result of an integration a smooth function of its inputs, which Newton's method needs.

use super::flow::{Flow, Visitor};
use super::number::Number;
use super::section::Unbalanced;
use super::tableau::{BEFORE, FIFTH, STAGES, STEP, THIRD};
use super::walk::{Lost, Walk};

/// Steps of one span: the shares of the span at which they end.
#[derive(Clone, Debug, PartialEq)]
struct SpanSteps {
    /// Tube and number of its stop at which the span ends.
    key: (usize, usize),
    ends: Vec<f64>,
}

/// The steps of an integration.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steps {
    spans: Vec<SpanSteps>,
    /// Greatest estimated error of a step as a part of what is allowed.
    pub worst: f64,
    /// Has a span been cut anew since this was reset?
    pub changed: bool,
}

impl Steps {
    /// The same with every step halved.
    pub fn halved(&self) -> Self {
        let halve = |span: &SpanSteps| {
            let mut ends = Vec::with_capacity(2 * span.ends.len());
            let mut last = 0.0;
            for &end in &span.ends {
                ends.extend([0.5 * (last + end), end]);
                last = end;
            }
            SpanSteps { key: span.key, ends }
        };
        Self { spans: self.spans.iter().map(halve).collect(), worst: 0.0, changed: false }
    }

    /// Tube and stop at which span `number` ended last.
    pub fn key(&self, number: usize) -> Option<(usize, usize)> {
        self.spans.get(number).map(|span| span.key)
    }

    /// How many steps there are.
    pub fn count(&self) -> usize {
        self.spans.iter().map(|span| span.ends.len()).sum()
    }

    /// There are no more spans than these.
    pub fn end(&mut self, spans: usize) {
        self.spans.truncate(spans);
    }

    /// Forgets all steps.
    pub fn forget(&mut self) {
        self.spans.clear();
    }
}

/// Spans shorter than this part of the length are taken in one step of order one.
const TINY: f64 = 1e-9;
/// Shortest step, as a share of its span.
const SHORTEST: f64 = 1e-6;

/// What a span is integrated to.
pub(super) struct Span<'a> {
    /// Place of the tube whose label is the independent variable, and the label at which the span ends (m).
    pub leading: usize,
    pub to: f64,
    /// Number of the span, and the tube and stop at its end.
    pub number: usize,
    pub key: (usize, usize),
    /// Labels that the tubes may not pass.
    pub limits: &'a [f64],
}

/// Integrates until the leading tube has reached its label, or another one has passed its limit: then its place is returned.
pub(super) fn march<S: Number>(
    flow: &mut Flow<S>,
    span: &Span,
    steps: &mut Steps,
    walk: &Walk,
    visit: &mut Option<Visitor<S>>,
) -> Result<Option<usize>, Lost> {
    let result = try_march(flow, span, steps, walk, visit);
    if !matches!(result, Ok(None)) {
        steps.end(span.number);
    }
    result
}

fn passed<S: Number>(flow: &Flow<S>, limits: &[f64]) -> Option<usize> {
    limits.iter().enumerate().position(|(place, limit)| flow.values[4 * place].value() > *limit)
}

fn try_march<S: Number>(
    flow: &mut Flow<S>,
    span: &Span,
    steps: &mut Steps,
    walk: &Walk,
    visit: &mut Option<Visitor<S>>,
) -> Result<Option<usize>, Lost> {
    let Span { leading, to, number, key, limits } = *span;
    let width = flow.values.len();
    let way = -flow.values[4 * leading] + to;
    let mut slopes = vec![S::constant(0.0); width * STAGES];
    let length = walk.bundle.length;
    let known = steps.spans.get(number).is_some_and(|s| s.key == key && !s.ends.is_empty());
    if !known {
        steps.spans.truncate(number);
        steps.spans.push(SpanSteps { key, ends: Vec::new() });
        steps.changed = true;
    }
    if way.value().abs() < TINY * length {
        flow.slopes(Some(leading), &mut slopes[..width])?;
        for (value, slope) in flow.values.iter_mut().zip(&slopes) {
            *value += *slope * way;
        }
        return Ok(passed(flow, limits));
    }
    let scales = scales(flow, walk);
    let (mut done, mut index) = (0.0, 0);
    let longest = walk.longest / way.value().abs();
    let mut share = f64::min(1.0, longest);
    let mut trial = flow.values.clone();
    while done < 1.0 {
        let end = if known { steps.spans[number].ends[index] } else { f64::min(1.0, done + share) };
        let end = if end > 1.0 - SHORTEST { 1.0 } else { end };
        let step = way * (end - done);
        let taken = one_step(flow, leading, step, &mut slopes, &mut trial);
        let error = match taken {
            Ok(()) => estimate(&slopes, width, step.value(), &scales) / walk.tolerance,
            Err(Unbalanced) => f64::INFINITY,
        };
        if !known && (error > 1.0 || error.is_nan()) {
            share = (end - done) * (0.9 * error.powf(-1.0 / 8.0)).clamp(0.1, 0.7);
            if share < SHORTEST {
                return Err(Lost::Steps);
            }
            continue;
        }
        taken?;
        steps.worst = steps.worst.max(error);
        std::mem::swap(&mut flow.values, &mut trial);
        if !known {
            steps.spans[number].ends.push(end);
            share = ((end - done) * (0.9 * error.max(1e-12).powf(-1.0 / 8.0)).min(5.0)).min(longest);
        }
        (done, index) = (end, index + 1);
        if let Some(place) = passed(flow, limits) {
            return Ok(Some(place));
        }
        if let Some(visit) = visit {
            flow.visit(*visit)?;
        }
    }
    Ok(None)
}

/// One step of the pair of order 8.
fn one_step<S: Number>(
    flow: &mut Flow<S>,
    leading: usize,
    step: S,
    slopes: &mut [S],
    trial: &mut [S],
) -> Result<(), Unbalanced> {
    let width = trial.len();
    let mut guess = flow.guess();
    for stage in 0..STAGES {
        combine(flow, BEFORE[stage], step, slopes, trial);
        let own = &mut slopes[stage * width..(stage + 1) * width];
        flow.slopes_at(trial, Some(leading), &mut guess, own)?;
    }
    combine(flow, STEP, step, slopes, trial);
    Ok(())
}

/// trial = values + step Σ weight · slopes.
fn combine<S: Number>(flow: &Flow<S>, weights: &[(usize, f64)], step: S, slopes: &[S], trial: &mut [S]) {
    let width = trial.len();
    for (i, value) in trial.iter_mut().enumerate() {
        let mut sum = S::constant(0.0);
        for &(stage, weight) in weights {
            sum = sum.plus(weight, slopes[stage * width + i]);
        }
        *value = flow.values[i] + sum * step;
    }
}

/// Error of a step in scaled variables, as in Hairer, Nørsett and Wanner 1993, II.10.
fn estimate<S: Number>(slopes: &[S], width: usize, step: f64, scales: &[f64]) -> f64 {
    let square = |weights: &[(usize, f64)]| -> f64 {
        (0..width)
            .map(|i| {
                let sum: f64 = weights.iter().map(|&(stage, w)| w * slopes[stage * width + i].value()).sum();
                (sum * step / scales[i]).powi(2)
            })
            .sum::<f64>()
    };
    let (fifth, third) = (square(FIFTH), square(THIRD));
    if fifth <= 0.0 { 0.0 } else { fifth / (fifth + 0.01 * third).sqrt() }
}

/// Units of the state vector.
fn scales<S: Number>(flow: &Flow<S>, walk: &Walk) -> Vec<f64> {
    let length = walk.bundle.length;
    let force = walk.command.force_scale;
    let mut scales = Vec::with_capacity(flow.values.len());
    for _ in &flow.present {
        scales.extend([length, force, 1.0, force * length]);
    }
    scales.push(length);
    scales.extend([length, length, length, 1.0, 1.0, 1.0, 1.0]);
    scales.extend([force, force, force, force * length, force * length, force * length]);
    scales.truncate(flow.values.len());
    scales
}
