//! Stability: the tangent on the motions that the actuators leave free.
//!
//! An equilibrium is stable where δuᵀ 𝓛_uu δu > 0 for every δu that keeps the prescribed motions and the
//! edges. Loads that have no potential (follower loads, dead moments) enter with the symmetric part.

use crate::dense::column;
use crate::solve::reduced::Reduced;
use crate::solve::stability::{matrix, negative};
use crate::solve::{Equilibrium, Formulation, Solver};
use nalgebra::{SymmetricEigen, Vector3};

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
    /// Where the tip's centre goes under the mode: a unit vector of the base frame whose largest component is positive (the
    /// mode goes either way), or zero where the mode leaves the tip in its place.
    pub tip_direction: Vector3<f64>,
}

/// The tip stays where it moves by less than this part of what the largest share of the mode alone would move it.
const STILL: f64 = 1e-9;

impl Solver {
    /// Margin to instability, how many eigenvalues are negative and the motion of the lowest; `None` for the printed formulation, which
    /// is not the derivative of an energy, and where there is no equilibrium.
    #[must_use]
    pub fn stability(&mut self, equilibrium: &Equilibrium) -> Option<Stability> {
        let reduced = self.reduced(equilibrium)?;
        let eigen = SymmetricEigen::new(matrix(&reduced));
        let lowest = eigen.eigenvalues.imin();
        let mode = reduced.motion(eigen.eigenvectors.column(lowest).as_slice());
        let largest = mode.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        let mode: Vec<f64> = mode.iter().map(|entry| entry / largest).collect();
        Some(Stability {
            margin: eigen.eigenvalues[lowest],
            inertia: negative(eigen.eigenvalues.as_slice()),
            tip_direction: self.tip_direction(equilibrium, &mode),
            mode,
        })
    }

    /// [`Stability::margin`] alone, several times as fast.
    #[must_use]
    pub fn margin(&mut self, equilibrium: &Equilibrium) -> Option<f64> {
        self.reduced(equilibrium).map(Reduced::lowest)
    }

    fn reduced(&mut self, equilibrium: &Equilibrium) -> Option<Reduced<f64>> {
        if equilibrium.settings.formulation == Formulation::Printed || !equilibrium.status.is_equilibrium() {
            return None;
        }
        equilibrium.refresh(&mut self.buffers);
        let reduced = Reduced::new(&mut self.buffers, &equilibrium.system());
        (reduced.fit == 1 && reduced.free > 0).then_some(reduced)
    }

    fn tip_direction(&mut self, equilibrium: &Equilibrium, mode: &[f64]) -> Vector3<f64> {
        self.buffers.pose_rows(&equilibrium.robot, &equilibrium.layout);
        let poses = &self.buffers.poses;
        let last = &poses.shift[(poses.rotation.len() - 1) * 3 * poses.leader_unknowns..];
        let (mut shift, mut most) = (Vector3::zeros(), 0.0_f64);
        for (i, share) in mode.iter().take(poses.leader_unknowns).enumerate() {
            let own = column(last, poses.leader_unknowns, i) * *share;
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
