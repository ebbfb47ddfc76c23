//! Least squares with bounds: the Levenberg–Marquardt method on the variables that are free to move.
//!
//! Minimises ½ |r(x)|² over low ≤ x ≤ high. A variable at a bound against which the gradient presses is held; the others take the
//! damped Gauss–Newton step (JᵀJ + μ I) δ = −Jᵀr in units that make them alike, cut off at their bounds. Damping follows
//! Nielsen (1999). A step to where r does not exist counts as one that does not gain.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Residual and Jacobian at a point, and whatever the next evaluation starts at.
#[derive(Clone, Debug)]
pub(super) struct Evaluated<S> {
    pub residual: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    pub state: S,
}

/// Where the search ended.
#[derive(Clone, Debug)]
pub(super) struct Outcome<S> {
    pub values: DVector<f64>,
    pub best: Evaluated<S>,
}

const ITERATIONS: usize = 100;
/// Damping at the start, against the largest diagonal entry of JᵀJ: little, since searches start near. It grows fast where that is wrong.
const DAMPING: f64 = 1e-6;
/// Least part of the predicted gain that a step must bring.
const GAIN: f64 = 1e-4;
/// Residuals, steps and relative gains below these are zero.
const ZERO: f64 = 1e-13;
/// A step that would gain less than this part of the cost is not tried: it would change the values by 3e-7 of what the residuals leave uncertain,
/// and rounding would soon decide whether it gains.
const WORTH: f64 = 1e-13;

/// Searches from `values`, where `first` was evaluated.
pub(super) fn minimise<S>(
    values: DVector<f64>,
    first: Evaluated<S>,
    bounds: &[[f64; 2]],
    units: &[f64],
    mut evaluate: impl FnMut(&DVector<f64>, &S) -> Option<Evaluated<S>>,
) -> Outcome<S> {
    let mut outcome = Outcome { values, best: first };
    let scaled = |jacobian: &DMatrix<f64>| {
        let mut jacobian = jacobian.clone();
        jacobian.column_iter_mut().zip(units).for_each(|(mut column, unit)| column *= *unit);
        jacobian
    };
    let mut jacobian = scaled(&outcome.best.jacobian);
    let mut damping =
        DAMPING * jacobian.column_iter().map(|c| c.norm_squared()).fold(f64::MIN_POSITIVE, f64::max);
    let mut growth = 2.0;
    for _ in 0..ITERATIONS {
        let residual = &outcome.best.residual;
        let cost = 0.5 * residual.norm_squared();
        let gradient = jacobian.tr_mul(residual);
        let free: Vec<usize> = (0..bounds.len())
            .filter(|&i| {
                let [low, high] = bounds[i];
                let at = outcome.values[i];
                !((at <= low && gradient[i] > 0.0) || (at >= high && gradient[i] < 0.0))
            })
            .collect();
        let slope = free.iter().map(|&i| gradient[i].abs()).fold(0.0, f64::max);
        if residual.norm() <= ZERO || slope <= ZERO * jacobian.norm() * residual.norm() {
            break;
        }
        let own = jacobian.select_columns(&free);
        let normal = own.tr_mul(&own) + DMatrix::identity(free.len(), free.len()) * damping;
        let right = DVector::from_iterator(free.len(), free.iter().map(|&i| -gradient[i]));
        let Some(step) = Cholesky::new(normal).map(|c| c.solve(&right)) else { break };
        let mut trial = outcome.values.clone();
        for (&i, &s) in free.iter().zip(step.iter()) {
            trial[i] = (trial[i] + s * units[i]).clamp(bounds[i][0], bounds[i][1]);
        }
        let taken = DVector::from_fn(trial.len(), |i, _| (trial[i] - outcome.values[i]) / units[i]);
        if taken.norm() <= ZERO {
            break;
        }
        let predicted = -gradient.dot(&taken) - 0.5 * (&jacobian * &taken).norm_squared();
        if predicted.abs() <= WORTH * cost {
            break;
        }
        let next = evaluate(&trial, &outcome.best.state);
        let gain = next.as_ref().map_or(f64::NEG_INFINITY, |n| cost - 0.5 * n.residual.norm_squared());
        match next {
            Some(next) if predicted > 0.0 && gain >= GAIN * predicted => {
                let ratio = gain / predicted;
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
                growth = 2.0;
                outcome = Outcome { values: trial, best: next };
                jacobian = scaled(&outcome.best.jacobian);
                if gain <= ZERO * cost {
                    break;
                }
            }
            _ => {
                damping *= growth;
                growth *= 2.0;
                if !damping.is_finite() {
                    break;
                }
            }
        }
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::{Evaluated, minimise};
    use nalgebra::{DMatrix, DVector};

    /// Rosenbrock's valley as two residuals.
    fn rosenbrock(x: &DVector<f64>) -> Evaluated<()> {
        Evaluated {
            residual: DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
            jacobian: DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]),
            state: (),
        }
    }

    #[test]
    fn the_valley_is_followed_to_its_end_or_to_a_bound() {
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        for (high, want) in [(2.0, [1.0, 1.0]), (0.5, [0.5, 0.25])] {
            let bounds = [[-2.0, high], [-2.0, 2.0]];
            let found = minimise(start.clone(), rosenbrock(&start), &bounds, &[1.0, 1.0], |x, ()| {
                assert!(x[0] <= high && x[1] <= 2.0 && x.min() >= -2.0, "{x}");
                Some(rosenbrock(x))
            });
            for (got, want) in found.values.iter().zip(want) {
                assert!((got - want).abs() < 1e-8, "{}", found.values);
            }
        }
    }

    #[test]
    fn holes_in_the_domain_are_walked_around() {
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let bounds = [[-2.0, 2.0]; 2];
        let found = minimise(start.clone(), rosenbrock(&start), &bounds, &[1.0, 1.0], |x, ()| {
            (x[1] > -0.05).then(|| rosenbrock(x))
        });
        assert!((found.values[0] - 1.0).abs() < 1e-8, "{}", found.values);
    }
}
