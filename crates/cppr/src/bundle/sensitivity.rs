//! Derivatives of an equilibrium by its motors and by a wrench on its tip.

use super::frame::Frame;
use super::newton::MOST;
use super::number::{Dual, Number};
use super::solve::{BundleEquilibrium, BundleSolver};
use super::vector::columns;
use super::walk::{Outcome, Walk};
use crate::analysis::Sensitivity;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};

/// Components of a wrench.
const WRENCH: usize = 6;

/// Slopes of the tip (rows position in m, rotation about the world axes in rad) and of the unknowns, by motors and wrench.
struct Slopes {
    tip: DMatrix<f64>,
    unknowns: DMatrix<f64>,
}

impl BundleSolver<'_> {
    /// Slopes of the tip by the motors: rows position (m) and rotation about the world axes (rad), columns translation and rotation of
    /// every tube's motor, by what is prescribed there. `None` where the equilibrium is a fold.
    #[must_use]
    pub fn tip_jacobian(&self, equilibrium: &BundleEquilibrium) -> Option<DMatrix<f64>> {
        let frame = Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening);
        Some(self.slopes(&frame, equilibrium, 0)?.tip)
    }

    /// Jacobians by the motors and compliance, as those of the modal solver; inputs are those of tube 1, of tube 2, … The motion that answers a
    /// prescribed effort is that at the plate. `None` where the equilibrium is a fold.
    #[must_use]
    pub fn sensitivity(&self, equilibrium: &BundleEquilibrium) -> Option<Sensitivity> {
        let mut frame = Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening);
        frame.prepared.loaded = true;
        let Slopes { tip, unknowns } = self.slopes(&frame, equilibrium, WRENCH)?;
        let inputs = equilibrium.command.inputs();
        let motors = inputs.len();
        let conjugates = frame.conjugates();
        let conjugate = DMatrix::from_fn(motors, motors + WRENCH, |i, j| {
            conjugates[i].map_or(0.0, |(row, unit)| unit * unknowns[(row, j)])
        });
        let tip_jacobian = tip.columns(0, motors).into_owned();
        let back = equilibrium.frame.transpose();
        let mut body = tip_jacobian.clone();
        for half in [0, 3] {
            let turned = back * tip_jacobian.fixed_rows::<3>(half);
            body.fixed_rows_mut::<3>(half).copy_from(&turned);
        }
        Some(Sensitivity {
            inputs,
            tip_jacobian,
            tip_jacobian_body: body,
            response: conjugate.columns(0, motors).into_owned(),
            compliance: Matrix6::from_fn(|i, j| tip[(i, motors + j)]),
            response_by_wrench: conjugate.columns(motors, WRENCH).into_owned(),
        })
    }

    fn slopes(&self, frame: &Frame, equilibrium: &BundleEquilibrium, wrench: usize) -> Option<Slopes> {
        match frame.count() + 2 * self.bundle.tubes.len() + wrench + 1 {
            0..=8 => self.slopes_with::<8>(frame, equilibrium, wrench),
            9..=12 => self.slopes_with::<12>(frame, equilibrium, wrench),
            13..=16 => self.slopes_with::<16>(frame, equilibrium, wrench),
            17..=24 => self.slopes_with::<24>(frame, equilibrium, wrench),
            25..=MOST => self.slopes_with::<MOST>(frame, equilibrium, wrench),
            _ => None,
        }
    }

    fn slopes_with<const P: usize>(
        &self,
        frame: &Frame,
        equilibrium: &BundleEquilibrium,
        wrench: usize,
    ) -> Option<Slopes> {
        let unknowns = frame.scaled(&equilibrium.unknowns);
        let n = unknowns.len();
        let inputs: Vec<Dual<P>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let drives: Vec<[Dual<P>; 2]> = frame
            .drives()
            .iter()
            .enumerate()
            .map(|(i, pair)| [Dual::input(pair[0], n + 2 * i), Dual::input(pair[1], n + 2 * i + 1)])
            .collect();
        let motors = 2 * drives.len();
        let mut base = frame.base(&inputs, &drives);
        if wrench > 0 {
            let [force, moment] =
                [0, 3].map(|from| [0, 1, 2].map(|i| Dual::input(0.0, n + motors + from + i)));
            base.wrench = Some([force, moment]);
            if !frame.prepared.seeks_force {
                base.force = [0, 1, 2].map(|i| base.force[i] + force[i]);
            }
        }
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let mut steps = equilibrium.between.clone();
        let outcome = walk.run(&base, &mut steps, None).ok()?;
        let given = motors + wrench;
        let (system, _) = steps.coordinates.system(given)?;
        let moved = -system.columns(0, n).into_owned().lu().solve(&system.columns(n, given))?;
        // At the tip, and from there at the plate.
        let mut last = DMatrix::zeros(P, given);
        last.rows_mut(0, n).copy_from(&moved);
        last.view_mut((n, 0), (given, given)).fill_with_identity();
        let unknowns = steps.coordinates.stages(last).swap_remove(0).rows(0, n).into_owned();
        let axes = section_axes(&outcome);
        let pose = DMatrix::from_fn(6, n + given, |i, j| {
            if i < 3 {
                outcome.centre[i].slopes[j]
            } else {
                // ω = ½ Σ axis × axis'.
                let (a, b) = ((i - 2) % 3, (i - 1) % 3);
                axes.iter().map(|v| 0.5 * (v[a].value * v[b].slopes[j] - v[b].value * v[a].slopes[j])).sum()
            }
        });
        Some(Slopes { tip: pose.columns(n, given) + pose.columns(0, n) * moved, unknowns })
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
