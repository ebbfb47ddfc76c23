//! Newton's method with slopes of the conditions that are taken once and learn from every step (Broyden 1965): near an equilibrium those of a neighbour lead to
//! the next one without being taken anew, and an integration without slopes costs a tenth of one with them.

use super::frame::Frame;
use super::newton::{Found, LONGEST, Tangent};
use super::steps::Steps;
use super::walk::{Outcome, Walk};
use nalgebra::{DMatrix, DVector};

/// Inverse of the slopes of the conditions by the scaled unknowns.
#[derive(Clone, Debug)]
pub(super) struct Chord {
    inverse: DMatrix<f64>,
}

/// Integrations.
const MOST: usize = 12;
/// The scaled step with which the method ends.
const SETTLED: f64 = 1e-9;
/// By this factor at least a step is shorter than the one before; else slopes are taken anew.
const SHRINKS: f64 = 0.25;
/// Part of the steps' own length by which conditions answer to a step, between which slopes learn from it.
const LEARNS: [f64; 2] = [0.5, 2.0];
/// How often slopes are taken anew.
const TAKEN: usize = 3;
/// Pivots below this part of the greatest are zero.
const SINGULAR: f64 = 1e-12;

impl Chord {
    /// At unknowns where the states that are kept meet. `None` where slopes grow so far along the bundle that it has to be shot at in parts.
    fn new(frame: &Frame, walk: &Walk, unknowns: &[f64], steps: &mut Steps) -> Option<Self> {
        let tangent = Tangent::new(frame, unknowns, walk, steps).ok()?;
        if steps.coordinates.stage() > 0 {
            return None;
        }
        let slopes = tangent.matrix.lu();
        let pivots = slopes.u().diagonal();
        if pivots.amin() <= SINGULAR * pivots.amax() {
            return None;
        }
        Some(Self { inverse: slopes.try_inverse()? })
    }

    /// Newton's step where this is left of the conditions.
    fn step(&self, left: &DVector<f64>) -> Option<DVector<f64>> {
        (self.inverse.ncols() == left.len()).then(|| -(&self.inverse * left))
    }

    /// Learns by how much a step has changed what is left.
    fn learn(&mut self, step: &DVector<f64>, change: &DVector<f64>) {
        let seen = &self.inverse * change;
        let (along, square) = (step.dot(&seen), step.norm_squared());
        let share = along / square;
        if share > LEARNS[0] && share < LEARNS[1] {
            let row = self.inverse.tr_mul(step);
            self.inverse.ger(1.0 / along, &(step - seen), &row, 1.0);
        }
    }
}

/// The equilibrium near unknowns, with the pose of its tip and without the determinant of its conditions; `None` where the slopes of a neighbour do not lead to it.
pub(super) fn near(
    frame: &Frame,
    walk: &Walk,
    mut unknowns: Vec<f64>,
    mut steps: Steps,
    chord: &mut Option<Chord>,
) -> Option<(Found, Outcome<f64>)> {
    let posed = Walk { posed: true, ..*walk };
    let mut last: Option<(DVector<f64>, DVector<f64>)> = None;
    let mut taken = 0;
    for iterations in 1..=MOST {
        steps.forget();
        steps.adapt = true;
        let outcome = posed.run(&frame.base(&unknowns, &frame.drives()), &mut steps, None).ok()?;
        let left = steps.coordinates.values();
        if left.len() != unknowns.len() {
            return None;
        }
        let longest = last.as_ref().map_or(f64::INFINITY, |(step, _)| step.amax());
        let leads =
            |step: &DVector<f64>| step.amax() <= (SHRINKS * longest).min(LONGEST) || step.amax() <= SETTLED;
        if let (Some(chord), Some((step, before))) = (chord.as_mut(), &last) {
            chord.learn(step, &(&left - before));
        }
        let mut step = chord.as_ref().and_then(|chord| chord.step(&left));
        if !step.as_ref().is_some_and(leads) {
            taken += 1;
            *chord = if taken <= TAKEN { Chord::new(frame, walk, &unknowns, &mut steps) } else { None };
            step = chord.as_ref().and_then(|chord| chord.step(&left));
        }
        let step = step?;
        let size = step.amax();
        if size <= SETTLED {
            return Some((Found { unknowns, steps, determinant: f64::NAN, iterations }, outcome));
        }
        if size > longest.min(LONGEST) || size.is_nan() {
            return None;
        }
        for (unknown, step) in unknowns.iter_mut().zip(step.iter()) {
            *unknown += step;
        }
        last = Some((step, left));
    }
    None
}
