//! Stability: the tangent on the motions that the actuators leave free.
//!
//! An equilibrium is stable where δuᵀ 𝓛_uu δu > 0 for every δu that keeps the prescribed motions and the
//! edges. Loads that have no potential (follower loads, dead moments) enter with the symmetric part.

use super::reduced::{Reduced, cholesky};
use crate::dense::column;
use crate::design::Robot;
use crate::solve::system::{System, Workspace};
use crate::solve::{Equilibrium, Formulation};
use nalgebra::{DMatrix, SymmetricEigen, Vector3};

/// Lowest eigenvalue of the constrained tangent, its eigenvector, and how many are negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// Lowest eigenvalue of 𝓛_uu against the elastic stiffness of the straight robot, both on the free
    /// motions: 1 for a straight, unloaded robot with straight patterns, 0 where it snaps, negative beyond.
    pub margin: f64,
    /// Number of negative eigenvalues: 0 where stable, and one more behind each fold or simple branch point.
    pub inertia: usize,
    /// The motion that belongs to it, in the solver's coordinates, of largest entry 1.
    pub mode: Vec<f64>,
}

impl Stability {
    /// Where the tip's centre goes under the mode: a unit vector of the base frame whose largest component is positive (the
    /// mode goes either way), or zero where the mode leaves the tip in its place.
    #[must_use]
    pub fn tip_direction(
        &self,
        robot: &Robot,
        workspace: &mut Workspace,
        equilibrium: &Equilibrium,
    ) -> Vector3<f64> {
        equilibrium.refresh(robot, workspace);
        workspace.pose_rows(robot, &equilibrium.layout);
        let poses = &workspace.poses;
        let last = &poses.shift[(poses.rotation.len() - 1) * 3 * poses.posed..];
        let (mut shift, mut most) = (Vector3::zeros(), 0.0_f64);
        for (i, share) in self.mode.iter().take(poses.posed).enumerate() {
            let own = column(last, poses.posed, i) * *share;
            shift += own;
            most = most.max(own.norm());
        }
        // What cancels is rounding.
        if shift.norm() <= STILL * most {
            return Vector3::zeros();
        }
        shift.normalize() * shift[shift.icamax()].signum()
    }
}

/// The tip stays where it moves by less than this part of what the largest share of the mode alone would move it.
const STILL: f64 = 1e-9;

/// Margin to instability, how many eigenvalues are negative and the motion of the lowest; `None` for the printed formulation, which
/// is not the derivative of an energy, and where there is no equilibrium.
#[must_use]
pub fn stability(robot: &Robot, workspace: &mut Workspace, equilibrium: &Equilibrium) -> Option<Stability> {
    let reduced = reduced(robot, workspace, equilibrium)?;
    let eigen = SymmetricEigen::new(matrix(&reduced));
    let lowest = eigen.eigenvalues.imin();
    let mode = reduced.motion(eigen.eigenvectors.column(lowest).as_slice());
    let largest = mode.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
    Some(Stability {
        margin: eigen.eigenvalues[lowest],
        inertia: negative(eigen.eigenvalues.as_slice()),
        mode: mode.iter().map(|entry| entry / largest).collect(),
    })
}

/// [`Stability::margin`] alone, several times as fast.
#[must_use]
pub fn margin(robot: &Robot, workspace: &mut Workspace, equilibrium: &Equilibrium) -> Option<f64> {
    reduced(robot, workspace, equilibrium).map(Reduced::lowest)
}

fn reduced(robot: &Robot, workspace: &mut Workspace, equilibrium: &Equilibrium) -> Option<Reduced<f64>> {
    if equilibrium.settings.formulation == Formulation::Printed || !equilibrium.status.is_equilibrium() {
        return None;
    }
    equilibrium.refresh(robot, workspace);
    let reduced = Reduced::new(workspace, &equilibrium.system(robot));
    (reduced.fit == 1 && reduced.free > 0).then_some(reduced)
}

fn matrix(reduced: &Reduced<f64>) -> DMatrix<f64> {
    DMatrix::from_row_slice(reduced.free, reduced.free, &reduced.tangent)
}

/// How many eigenvalues of a spectrum count as negative.
pub(crate) fn negative(spectrum: &[f64]) -> usize {
    spectrum.iter().filter(|&&value| value < -NEUTRAL).count()
}

/// Below this an eigenvalue is rounding error: a neutral motion, as a round rod under an axial load has beyond buckling.
pub(crate) const NEUTRAL: f64 = 1e-9;

/// All eigenvalues, ascending, of the tangent at the evaluated point against the elastic stiffness; `None` as for
/// [`stability`].
pub(crate) fn spectrum(workspace: &mut Workspace, system: &System) -> Option<Vec<f64>> {
    if system.formulation == Formulation::Printed {
        return None;
    }
    let reduced = Some(Reduced::new(workspace, system)).filter(|reduced| reduced.fit == 1)?;
    let mut values = matrix(&reduced).symmetric_eigenvalues().as_slice().to_vec();
    values.sort_unstable_by(f64::total_cmp);
    Some(values)
}

/// Is the evaluated equilibrium a minimum on the free motions?
pub(crate) fn is_stable(workspace: &mut Workspace, system: &System) -> bool {
    if system.formulation == Formulation::Printed {
        return true;
    }
    // The penalties of the tangent vanish on motions that keep the conditions: positive pivots suffice.
    let symmetric = system.loads.first().is_conservative();
    if symmetric && workspace.factor(system).is_ok() && workspace.is_in_order() {
        return true;
    }
    let mut reduced = Reduced::new(workspace, system);
    reduced.fit == 1 && cholesky(&mut reduced.tangent, reduced.free) == 1
}
