//! Is an evaluated equilibrium a minimum of the energy on the motions that the conditions leave free?

use super::Formulation;
use super::reduced::{Reduced, cholesky};
use super::system::{Buffers, System};
use nalgebra::DMatrix;

/// The tangent on the free motions.
pub(crate) fn matrix(reduced: &Reduced<f64>) -> DMatrix<f64> {
    DMatrix::from_row_slice(reduced.free, reduced.free, &reduced.tangent)
}

/// How many eigenvalues of a spectrum count as negative.
pub(crate) fn negative(spectrum: &[f64]) -> usize {
    spectrum.iter().filter(|&&value| value < -NEUTRAL).count()
}

/// Below this an eigenvalue is rounding error: a neutral motion, as a round rod under an axial load has beyond buckling.
pub(crate) const NEUTRAL: f64 = 1e-9;

/// All eigenvalues, ascending, of the tangent at the evaluated point against the elastic stiffness; `None` for
/// the printed formulation.
pub(crate) fn spectrum(buffers: &mut Buffers, system: &System) -> Option<Vec<f64>> {
    if system.formulation == Formulation::Printed {
        return None;
    }
    let reduced = Some(Reduced::new(buffers, system)).filter(|reduced| reduced.fit == 1)?;
    let mut values = matrix(&reduced).symmetric_eigenvalues().as_slice().to_vec();
    values.sort_unstable_by(f64::total_cmp);
    Some(values)
}

/// Is the evaluated equilibrium a minimum on the free motions?
pub(crate) fn is_stable(buffers: &mut Buffers, system: &System) -> bool {
    if system.formulation == Formulation::Printed {
        return true;
    }
    // The penalties of the tangent vanish on motions that keep the conditions: positive pivots suffice.
    let symmetric = system.loads.first().is_conservative();
    if symmetric && buffers.factor(system).is_ok() && buffers.is_in_order() {
        return true;
    }
    let mut reduced = Reduced::new(buffers, system);
    reduced.fit == 1 && cholesky(&mut reduced.tangent, reduced.free) == 1
}
