//! Derivatives of an equilibrium of a bundle by parameters of its design.
//!
//! A parameter moves what the integration is made of: fields, lengths, joints. Equilibria under the same command are found with the parameter moved
//! by h and by h/2 to both sides, each from the one that is known, and D(h) = (f(h) − f(−h))/2h is extrapolated: (4 D(h/2) − D(h))/3, whose
//! error is of fourth order. How far D(h/2) and D(h) are apart tells whether the differences have settled.

use super::bundle::BundleAnalysis;
use super::sensitivity::NoDerivatives;
use crate::bundle::Bundle;
use crate::bundle::solve::{BundleEquilibrium, BundleSolver};

/// Derivatives by differences, one for each output.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// The extrapolated derivatives, in units of the outputs per unit of the parameter.
    pub slopes: Vec<f64>,
    /// How far the derivatives with half the step are from these: far more than the error, where that is of fourth order.
    pub changes: Vec<f64>,
}

/// Places of the bundles in steps.
const PLACES: [f64; 4] = [1.0, -1.0, 0.5, -0.5];

/// A bundle with one parameter of its design moved to both sides.
#[derive(Clone, Debug)]
pub struct MovedBundle {
    step: f64,
    bundles: [Bundle; 4],
}

impl MovedBundle {
    /// `bundle_at(p)` is the bundle at the parameter's distance p from its present value, `step` a distance over which its fields change
    /// smoothly: 4e-3 of the parameter is a good choice. `None` where a bundle cannot be built.
    pub fn new(step: f64, mut bundle_at: impl FnMut(f64) -> Option<Bundle>) -> Option<Self> {
        let [a, b, c, d] = PLACES.map(|at| bundle_at(at * step));
        Some(Self { step, bundles: [a?, b?, c?, d?] })
    }
}

impl BundleAnalysis<'_> {
    /// Derivatives of any outputs of an equilibrium by a parameter of the design. `outputs` reads as many of every equilibrium.
    ///
    /// # Errors
    /// Where there is no equilibrium, or none beside it for a moved bundle, or one of another stability.
    pub fn parameter_sensitivity(
        &self,
        equilibrium: &BundleEquilibrium,
        moved: &MovedBundle,
        outputs: impl Fn(&BundleSolver, &BundleEquilibrium) -> Vec<f64>,
    ) -> Result<Settled, NoDerivatives> {
        if !equilibrium.converged {
            return Err(NoDerivatives::NoEquilibrium(equilibrium.status()));
        }
        let read = |bundle: &Bundle| -> Option<Vec<f64>> {
            let mut solver = self.solver.of_another(bundle);
            let found = solver.continued(equilibrium.command(), equilibrium)?;
            (found.status() == equilibrium.status()).then(|| outputs(&solver, &found))
        };
        let mut values = Vec::with_capacity(PLACES.len());
        for bundle in &moved.bundles {
            values.push(read(bundle).ok_or(NoDerivatives::Perturbed)?);
        }
        let [more, less, half_more, half_less] = [0, 1, 2, 3].map(|i| &values[i]);
        let (mut slopes, mut changes) = (Vec::new(), Vec::new());
        for (((a, b), c), d) in more.iter().zip(less).zip(half_more).zip(half_less) {
            let (whole, half) = ((a - b) / (2.0 * moved.step), (c - d) / moved.step);
            slopes.push(half + (half - whole) / 3.0);
            changes.push((half - whole).abs() / 3.0);
        }
        Ok(Settled { slopes, changes })
    }
}
