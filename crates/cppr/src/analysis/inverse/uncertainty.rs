//! What measurements say of unknowns: covariance from a weighted Jacobian, and what they do not see.

use nalgebra::{DMatrix, DVector};

/// An independent combination of the unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Principal {
    /// Share of each unknown, a unit vector in the units of the search.
    pub direction: Vec<f64>,
    /// Standard deviation along it in those units; infinite where nothing that was measured depends on it.
    pub deviation: f64,
    /// True where the measurements leave it open: it is worth no more than a guess.
    pub blind: bool,
}

/// Uncertainty of least-squares estimates whose measurements have known standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Covariance of the unknowns (SI), over the combinations that are seen.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each unknown (SI); infinite where it takes part in a blind combination.
    pub deviations: Vec<f64>,
    /// Units of the search (SI): in these the combinations below are independent.
    pub units: Vec<f64>,
    /// Independent combinations, best known first.
    pub principal: Vec<Principal>,
    /// Root mean square of the weighted residuals per degree of freedom: about 1 where model and deviations are right; NaN
    /// without a degree of freedom.
    pub misfit: f64,
}

/// A singular value below this part of the largest is rounding.
const ROUNDING: f64 = 1e-9;
/// Deviation in units of the search above which a combination is not known.
const UNKNOWN: f64 = 1.0;
/// Share of a blind combination from which on an unknown is not known either.
const SHARE: f64 = 1e-3;

impl Uncertainty {
    /// From `numbers` independent residuals and their Jacobian, both divided by their deviations; `units` are those of the unknowns.
    pub(super) fn new(
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        numbers: usize,
        units: &[f64],
    ) -> Self {
        let n = units.len();
        let mut scaled = jacobian.clone();
        scaled.column_iter_mut().zip(units).for_each(|(mut column, unit)| column *= *unit);
        // The eigenvectors of a symmetric matrix are complete, also where there are fewer rows than columns.
        let eigen = scaled.tr_mul(&scaled).symmetric_eigen();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let largest = eigen.eigenvalues.max().max(0.0).sqrt();
        let mut covariance = DMatrix::zeros(n, n);
        let mut principal = Vec::new();
        for i in order {
            let direction = eigen.eigenvectors.column(i).into_owned();
            // Squares lose half of the digits; the product gives them back.
            let size = (&scaled * &direction).norm();
            let deviation = if size > ROUNDING * largest { 1.0 / size } else { f64::INFINITY };
            let blind = deviation > UNKNOWN;
            if !blind {
                let own = DVector::from_fn(n, |k, _| direction[k] * units[k] * deviation);
                covariance += &own * own.transpose();
            }
            principal.push(Principal { direction: direction.as_slice().to_vec(), deviation, blind });
        }
        let deviations = (0..n)
            .map(|k| {
                let lost = principal.iter().any(|p| p.blind && p.direction[k].abs() > SHARE);
                if lost { f64::INFINITY } else { covariance[(k, k)].sqrt() }
            })
            .collect();
        let freedom = numbers as f64 - principal.iter().filter(|p| !p.blind).count() as f64;
        let misfit = if freedom > 0.0 { (residual.norm_squared() / freedom).sqrt() } else { f64::NAN };
        Self { covariance, deviations, units: units.to_vec(), principal, misfit }
    }
}
