//! Slopes of the tip by the motors.

use super::frame::Frame;
use super::newton::MOST;
use super::number::{Dual, Number};
use super::solve::{BundleEquilibrium, BundleSolver};
use super::vector::columns;
use super::walk::{Outcome, Walk};
use nalgebra::{DMatrix, Matrix3, Vector3};

impl BundleSolver<'_> {
    /// Slopes of the tip by the motors: rows position (m) and rotation about the world axes (rad), columns translation and rotation of
    /// every tube's motor, by what is prescribed there. `None` where the equilibrium is a fold.
    #[must_use]
    pub fn tip_jacobian(&self, equilibrium: &BundleEquilibrium) -> Option<DMatrix<f64>> {
        let frame = Frame::new(self.bundle, &equilibrium.command, self.stretch);
        match frame.count() + 2 * self.bundle.tubes.len() + 1 {
            0..=8 => self.jacobian_with::<8>(&frame, equilibrium),
            9..=12 => self.jacobian_with::<12>(&frame, equilibrium),
            13..=16 => self.jacobian_with::<16>(&frame, equilibrium),
            17..=24 => self.jacobian_with::<24>(&frame, equilibrium),
            25..=MOST => self.jacobian_with::<MOST>(&frame, equilibrium),
            _ => None,
        }
    }

    fn jacobian_with<const P: usize>(
        &self,
        frame: &Frame,
        equilibrium: &BundleEquilibrium,
    ) -> Option<DMatrix<f64>> {
        let unknowns = frame.scaled(&equilibrium.unknowns);
        let n = unknowns.len();
        let inputs: Vec<Dual<P>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let drives: Vec<[Dual<P>; 2]> = frame
            .drives()
            .iter()
            .enumerate()
            .map(|(i, pair)| [Dual::input(pair[0], n + 2 * i), Dual::input(pair[1], n + 2 * i + 1)])
            .collect();
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let outcome = walk.run(&frame.base(&inputs, &drives), &mut equilibrium.between.clone(), None).ok()?;
        let motors = 2 * drives.len();
        let by_unknowns = DMatrix::from_fn(n, n, |i, j| outcome.residual[i].slopes[j]);
        let by_motors = DMatrix::from_fn(n, motors, |i, j| -outcome.residual[i].slopes[n + j]);
        let moved = by_unknowns.lu().solve(&by_motors)?;
        let axes = section_axes(&outcome);
        let pose = DMatrix::from_fn(6, n + motors, |i, j| {
            if i < 3 {
                outcome.centre[i].slopes[j]
            } else {
                // ω = ½ Σ axis × axis'.
                let (a, b) = ((i - 2) % 3, (i - 1) % 3);
                axes.iter().map(|v| 0.5 * (v[a].value * v[b].slopes[j] - v[b].value * v[a].slopes[j])).sum()
            }
        });
        Some(pose.columns(n, motors) + pose.columns(0, n) * moved)
    }
}

/// Tangent, towards the centroid, and across, at the tip.
fn section_axes<S: Number>(outcome: &Outcome<S>) -> [[S; 3]; 3] {
    let [x, y, z] = columns(outcome.turn);
    let (sin, cos) = outcome.angle.sin_cos();
    let axes = [0, 1, 2].map(|i| [y[i] * cos + z[i] * sin, z[i] * cos - y[i] * sin]);
    [x, axes.map(|a| a[0]), axes.map(|a| a[1])]
}

pub(super) fn section_frame(outcome: &Outcome<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&section_axes(outcome).map(Vector3::from))
}
