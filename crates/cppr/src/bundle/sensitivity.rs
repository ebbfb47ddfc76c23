//! Derivatives of an equilibrium by its motors and by a wrench on its tip.

use super::frame::Frame;
use super::newton::MOST;
use super::number::{Dual, Number};
use super::solve::{BundleEquilibrium, BundleSolver};
use super::steps::Steps;
use super::vector::columns;
use super::walk::{Outcome, Walk};
use crate::analysis::Sensitivity;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3};

/// Components of a wrench.
const WRENCH: usize = 6;

/// The conditions near given unknowns to first order.
#[derive(Clone, Debug)]
pub(crate) struct Slopes {
    /// Of the tip (rows position in m, rotation about the world axes in rad), by motors and wrench.
    pub tip: DMatrix<f64>,
    /// Of the scaled unknowns likewise.
    pub unknowns: DMatrix<f64>,
    /// Of the scaled conditions by the [coordinates](super::coordinates) at the tip, and their determinant by the scaled unknowns.
    pub conditions: DMatrix<f64>,
    pub determinant: f64,
    /// Coordinates that conditions took away on the way, and how often the others were exchanged.
    pub gone: Vec<usize>,
    /// Newton's step of the coordinates.
    pub step: DVector<f64>,
    /// Slopes of the coordinates by motors and wrench.
    pub last: DMatrix<f64>,
    /// By how much motors had moved to the equilibrium, translation and rotation of every tube, and by how much the scaled unknowns left the tangent on the way;
    /// empty where that is not known.
    pub came: DVector<f64>,
    pub bend: Vec<f64>,
}

impl BundleSolver<'_> {
    /// Slopes of the tip by the motors: rows position (m) and rotation about the world axes (rad), columns translation and rotation of
    /// every tube's motor, by what is prescribed there. `None` where the equilibrium is a fold. Of an equilibrium that was found next to another they are those
    /// where its last Newton step began, 1e-5 away at most in scaled unknowns; [`Self::sensitivity`] takes them at the equilibrium itself.
    #[must_use]
    pub fn tip_jacobian(&self, equilibrium: &BundleEquilibrium) -> Option<DMatrix<f64>> {
        if let Some(slopes) = &equilibrium.slopes {
            return Some(slopes.tip.clone());
        }
        let frame = Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening);
        Some(self.slopes_at(&frame, equilibrium, 0)?.tip)
    }

    /// Jacobians by the motors and compliance, as those of the modal solver; inputs are those of tube 1, of tube 2, … The motion that answers a
    /// prescribed effort is that at the plate. `None` where the equilibrium is a fold.
    #[must_use]
    pub fn sensitivity(&self, equilibrium: &BundleEquilibrium) -> Option<Sensitivity> {
        let mut frame = Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening);
        frame.prepared.loaded = true;
        let Slopes { tip, unknowns, .. } = self.slopes_at(&frame, equilibrium, WRENCH)?;
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

    fn slopes_at(&self, frame: &Frame, equilibrium: &BundleEquilibrium, wrench: usize) -> Option<Slopes> {
        let (walk, mut steps) = (frame.walk(self.tolerance), equilibrium.between.clone());
        Some(self.slopes(frame, &walk, &frame.scaled(&equilibrium.unknowns), &mut steps, wrench)?.0)
    }

    /// Slopes near unknowns, and what an integration leaves after Newton's step.
    pub(super) fn slopes(
        &self,
        frame: &Frame,
        walk: &Walk,
        unknowns: &[f64],
        steps: &mut Steps,
        wrench: usize,
    ) -> Option<(Slopes, Outcome<f64>)> {
        match unknowns.len() + 2 * self.bundle.tubes.len() + wrench + 1 {
            0..=7 => Self::slopes_with::<8>(frame, walk, unknowns, steps, wrench),
            8..=11 => Self::slopes_with::<12>(frame, walk, unknowns, steps, wrench),
            12..=15 => Self::slopes_with::<16>(frame, walk, unknowns, steps, wrench),
            16..=19 => Self::slopes_with::<20>(frame, walk, unknowns, steps, wrench),
            20..=23 => Self::slopes_with::<24>(frame, walk, unknowns, steps, wrench),
            24..=MOST => Self::slopes_with::<{ 1 + MOST }>(frame, walk, unknowns, steps, wrench),
            _ => None,
        }
    }

    fn slopes_with<const N: usize>(
        frame: &Frame,
        walk: &Walk,
        unknowns: &[f64],
        steps: &mut Steps,
        wrench: usize,
    ) -> Option<(Slopes, Outcome<f64>)> {
        let n = unknowns.len();
        let inputs: Vec<Dual<N>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let drives: Vec<[Dual<N>; 2]> = frame
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
        let walk = Walk { posed: true, ..*walk };
        let outcome = walk.run(&base, steps, None).ok()?;
        let given = motors + wrench;
        let (system, residual) = steps.coordinates.system(given)?;
        let conditions = system.columns(0, n).into_owned();
        let factors = conditions.clone().lu();
        let moved = -factors.solve(&system.columns(n, given))?;
        let step = -factors.solve(&DVector::from_vec(residual))?;
        let determinant = steps.coordinates.determinant * factors.determinant();
        // At the tip, and from there at the plate.
        let mut last = DMatrix::zeros(N - 1, given);
        last.rows_mut(0, n).copy_from(&moved);
        last.view_mut((n, 0), (given, given)).fill_with_identity();
        let gone = steps.coordinates.gone();
        let unknowns = steps.coordinates.stages(last).swap_remove(0).rows(0, n).into_owned();
        let axes = section_axes(&outcome);
        let pose = DMatrix::from_fn(6, n + given, |i, j| {
            if i < 3 {
                outcome.centre[i].slopes()[j]
            } else {
                // ω = ½ Σ axis × axis'.
                let (a, b) = ((i - 2) % 3, (i - 1) % 3);
                axes.iter()
                    .map(|v| 0.5 * (v[a].value() * v[b].slopes()[j] - v[b].value() * v[a].slopes()[j]))
                    .sum()
            }
        });
        let tip = pose.columns(n, given) + pose.columns(0, n) * &moved;
        let arrived = outcome.moved(step.as_slice());
        let (came, bend) = (DVector::zeros(0), Vec::new());
        let slopes = Slopes { tip, unknowns, conditions, determinant, gone, step, last: moved, came, bend };
        Some((slopes, arrived))
    }
}

impl<const N: usize> Outcome<Dual<N>> {
    /// After a change of the first inputs, once steps meet.
    fn moved(&self, change: &[f64]) -> Outcome<f64> {
        let own = |number: Dual<N>| {
            let slopes = number.slopes().iter().zip(change);
            number.value()
                + number.slopes()[N - 2]
                + slopes.map(|(slope, change)| slope * change).sum::<f64>()
        };
        Outcome {
            centre: self.centre.map(own),
            turn: self.turn.map(own),
            angle: own(self.angle),
            length: own(self.length),
        }
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
