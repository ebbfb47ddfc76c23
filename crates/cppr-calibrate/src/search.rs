//! Least squares by the Levenberg–Marquardt method, between bounds.
//!
//! A step solves (JᵀJ + λ diag JᵀJ) s = −Jᵀr of the parameters that are not held at a bound, where the sum of squares falls beyond it, and ends at the bounds. Where it
//! leads to a greater sum, or to no equilibrium, λ grows, ever faster.

use crate::fit::FitProblem;
use crate::problem::{Evaluation, Problem};
use nalgebra::{DMatrix, DVector};

/// λ at first, the part of it that is left after a step, and the least.
const FIRST: f64 = 1e-3;
const LEFT: f64 = 0.1;
const LEAST: f64 = 1e-9;
/// Below this a step changes nothing (relative changes of the parameters).
const SETTLED: f64 = 1e-9;
/// The sum of squares has settled where a step that is hardly damped takes away no more than this part of it: what is left moves no parameter by
/// a hundredth of its deviation.
const GAIN: f64 = 1e-7;
const HARDLY: f64 = 0.1;
/// Steps of a search.
const STEPS: usize = 100;

/// Parameters at a bound beyond which the sum of squares would fall.
pub(crate) fn held(at: &DVector<f64>, bounds: &[[f64; 2]], gradient: &DVector<f64>) -> Vec<bool> {
    let own = at.iter().zip(bounds).zip(gradient.iter());
    own.map(|((at, [least, most]), slope)| {
        *at <= least + SETTLED && *slope > 0.0 || *at >= most - SETTLED && *slope < 0.0
    })
    .collect()
}

/// Looks for the least sum of squares from an evaluation on; gives it with its Jacobian.
pub(crate) fn search(
    problem: &Problem<'_>,
    mut at: Evaluation,
) -> Result<(Evaluation, DMatrix<f64>), FitProblem> {
    let mut damping = FIRST;
    for _ in 0..STEPS {
        let jacobian = problem.jacobian(&at)?;
        let gradient = jacobian.tr_mul(&at.weighted);
        let bounds = problem.bounds(&at.place);
        let held = held(&at.place, &bounds, &gradient);
        let normal = jacobian.tr_mul(&jacobian);
        let (mut growth, mut failure) = (2.0, None);
        let next = loop {
            let mut damped = normal.clone();
            for (i, held) in held.iter().enumerate() {
                damped[(i, i)] *= 1.0 + damping;
                if *held {
                    damped.row_mut(i).fill(0.0);
                    damped.column_mut(i).fill(0.0);
                }
                // What changes nothing stays.
                if damped[(i, i)] <= 0.0 {
                    damped[(i, i)] = 1.0;
                }
            }
            let right = DVector::from_fn(held.len(), |i, _| if held[i] { 0.0 } else { -gradient[i] });
            let step = damped.cholesky().map(|factors| factors.solve(&right));
            let trial = step.map(|step| {
                let at = &at.place + step;
                DVector::from_fn(at.len(), |i, _| at[i].clamp(bounds[i][0], bounds[i][1]))
            });
            if let Some(trial) = trial {
                if (&trial - &at.place).amax() <= SETTLED {
                    return failure.map_or(Ok((at, jacobian)), Err);
                }
                match problem.evaluate(&trial, Some(&at.found)) {
                    Ok(found) if found.squares() < at.squares() => break found,
                    Ok(_) => failure = None,
                    Err(FitProblem::Stopped) => return Err(FitProblem::Stopped),
                    Err(problem) => failure = Some(problem),
                }
            }
            if !damping.is_finite() {
                let lost = FitProblem::Search("the derivatives lead nowhere".into());
                return Err(failure.unwrap_or_else(|| problem.at(&at.place, lost)));
            }
            damping *= growth;
            growth *= 2.0;
        };
        let settled = damping <= HARDLY && next.squares() >= (1.0 - GAIN) * at.squares();
        at = next;
        if settled {
            let jacobian = problem.jacobian(&at)?;
            return Ok((at, jacobian));
        }
        damping = (damping * LEFT).max(LEAST);
    }
    Err(problem.at(&at.place, FitProblem::Search(format!("{STEPS} steps did not settle"))))
}
