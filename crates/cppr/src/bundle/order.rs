//! Which order one step of the integration takes, and the error that it has.
//!
//! A step y₈ of order 8 has two embedded ones y₅ and y₃ of lower order (Hairer, Nørsett and Wanner 1993, II.10). With e_p = |y₈ − y_p|, in scaled variables as
//! everything here, its error is e₅²/√(e₅² + 0.01 e₃²); e₅ and e₃ are about what methods of these orders would make of the same step, and e₂ is a second difference
//! of its stages. While a step is of order p, a difference d of its own few stages stands for e₃ (at order 5) or e₂ (at order 3): its error is taken to be
//!
//! ```text
//! e₅ (d/e₃)^(6/4)   and   e₃ (d/e₂)^(4/3) ,
//! ```
//!
//! with e from the last time that the step was of order 8, or where it never was and is short, from the last such step before it, and powers of the length with which the terms go. Values alone do not tell what grows along the tubes: where an
//! equilibrium holds them still, the slopes by the unknowns may grow without being seen, and too little with a low order. So these have to be followed as well.

use super::number::Number;
use super::tableau::{FIFTH, Method, SECOND, THIRD};

/// Order of the method of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Order {
    #[default]
    Eighth,
    Fifth,
    Third,
}

/// What a step of order 8 shows of methods of lower order.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Seen {
    /// e₅, e₃ and e₂ as parts of what is allowed.
    differences: [f64; 3],
    /// e₅ and e₃ of the slopes of the values, as a part of these; plain numbers say nothing of them.
    of_slopes: Option<[f64; 2]>,
    /// Length of the step (m), and how many values there were.
    length: f64,
    width: usize,
}

/// Slopes are followed where a method is off by no more than this part of them in a step.
const RESOLVED: f64 = 1e-2;
/// The same for what watches a step of lower order.
const WATCHED: f64 = 0.03;
/// A method of lower order is taken where the error that is expected of it is below this part of what is allowed.
const SAFE: f64 = 0.1;
/// By this factor a step may be longer than where that was expected.
const ALIKE: f64 = 1.1;
/// Differences below this part of what is allowed may be rounding.
const LEAST: f64 = 1e-3;

impl Seen {
    /// The lowest order that does.
    pub fn order(&self) -> Order {
        match (self.differences, self.of_slopes) {
            ([_, third, _], Some([_, slopes])) if third < SAFE && slopes < RESOLVED => Order::Third,
            ([fifth, ..], Some([slopes, _])) if fifth < SAFE && slopes < RESOLVED => Order::Fifth,
            _ => Order::Eighth,
        }
    }

    /// The same as parts of another size.
    pub fn times(self, part: f64) -> Self {
        Self { differences: self.differences.map(|own| part * own), ..self }
    }

    /// Does it hold for a step of such a length (m) with so many values?
    pub fn covers(&self, width: usize, length: f64) -> bool {
        width <= self.width && length.abs() <= ALIKE * self.length.abs()
    }

    /// The same with what was seen before of slopes, where that was in plain numbers.
    pub fn after(self, before: &Self) -> Self {
        Self { of_slopes: self.of_slopes.or(before.of_slopes), ..self }
    }
}

/// A step that was taken: its stages, where it arrived, its length (m), the units of all values, and how many of these others depend on.
pub(super) struct Taken<'a, S> {
    pub stages: &'a [S],
    pub arrived: &'a [S],
    pub step: S,
    pub scales: &'a [f64],
    pub dependent: usize,
}

impl<S: Number> Taken<'_, S> {
    /// The error of a step of order 8 as a part of what is allowed, and what it shows of methods of lower order.
    pub fn error(&self, allowed: f64) -> (f64, Option<Seen>) {
        if self.is_lost() {
            return (f64::INFINITY, None);
        }
        let differences = [FIFTH, THIRD, SECOND].map(|weights| self.size(weights) / allowed);
        let has_slopes = !self.arrived[0].slopes().is_empty();
        let of_slopes = has_slopes.then(|| [FIFTH, THIRD].map(|weights| self.of_slopes(weights)));
        let [fifth, third, _] = differences;
        let error = if fifth <= 0.0 { 0.0 } else { fifth * fifth / fifth.hypot(0.1 * third) };
        (error, Some(Seen { differences, of_slopes, length: self.step.value(), width: self.arrived.len() }))
    }

    /// The error of a step of lower order as a part of what is allowed, from what it was when it was of order 8.
    pub fn error_of_lower(&self, order: Order, seen: &Seen, allowed: f64) -> f64 {
        if self.is_lost() {
            return f64::INFINITY;
        }
        let monitor = Method::of(order).monitor;
        let [fifth, third, second] = seen.differences;
        let (expected, then, power) =
            if order == Order::Fifth { (fifth, third, 1.5) } else { (third, second, 4.0 / 3.0) };
        let grown = (self.size(monitor) / allowed / then.max(LEAST)).max(1.0);
        // Plain numbers have no slopes, and what is then no number does not count.
        (expected.max(LEAST) * grown.powf(power)).max((self.of_slopes(monitor) / WATCHED).powi(8))
    }

    fn is_lost(&self) -> bool {
        self.arrived.iter().any(|value| value.value().is_nan())
    }

    /// Size of a sum of stages in scaled variables.
    fn size(&self, weights: &[(usize, f64)]) -> f64 {
        let (width, step) = (self.arrived.len(), self.step.value());
        let squares = self.scales.iter().enumerate().map(|(i, scale)| {
            let sum: f64 = weights.iter().map(|&(stage, w)| w * self.stages[stage * width + i].value()).sum();
            (sum * step / scale).powi(2)
        });
        squares.sum::<f64>().sqrt()
    }

    /// Size of a sum of the stages' slopes as a part of the slopes that the step arrived with.
    fn of_slopes(&self, weights: &[(usize, f64)]) -> f64 {
        let square =
            |own: &S, scale: f64| own.slopes().iter().map(|slope| (slope / scale).powi(2)).sum::<f64>();
        let (mut lost, mut whole) = (0.0, 0.0);
        for (i, scale) in self.scales[..self.dependent].iter().enumerate() {
            let mut sum = S::constant(0.0);
            for &(stage, weight) in weights {
                sum.add_scaled(weight * self.step.value(), &self.stages[stage * self.arrived.len() + i]);
            }
            lost += square(&sum, *scale);
            whole += square(&self.arrived[i], *scale);
        }
        (lost / whole).sqrt()
    }
}
