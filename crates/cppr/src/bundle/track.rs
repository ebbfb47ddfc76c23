//! From one equilibrium to the next: Newton's method that begins where the tangent at the first leads, every integration with slopes by unknowns and motors.
//!
//! The slopes r_u of the conditions by the unknowns, at the equilibrium before and at this one, also tell whether an eigenvalue of the second variation has changed its
//! sign between the two. One vanishes where r_u is singular; and where ‖r_u⁻¹ r_u' − 1‖ < 1 no matrix on the line between both is. Where [coordinates](super::coordinates) are
//! exchanged on the way, orthonormal ones that vary with the equilibrium, the slopes are those by the last of them.

use super::frame::Frame;
use super::newton::{BETWEEN, SETTLED_NEAR};
use super::sensitivity::Slopes;
use super::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use nalgebra::{DMatrix, DVector};

/// Integrations.
const MOST: usize = 8;
/// Longest first step, in scaled unknowns.
const LONGEST: f64 = 2.0;
/// By this factor at least a step is shorter than the one before.
const SHRINKS: f64 = 0.5;
/// Greatest ‖r_u⁻¹ r_u' − 1‖ (Frobenius) between equilibria that have as many negative eigenvalues.
const ALIKE: f64 = 0.5;
/// How many times as far as before a path may go on and be taken to bend as it did.
const FARTHER: f64 = 2.0;

impl Slopes {
    /// Has no eigenvalue changed its sign between both, if one lies near the other?
    fn alike(&self, other: &Self) -> bool {
        let n = self.conditions.nrows();
        let same = other.conditions.nrows() == n && self.gone == other.gone;
        let turned = same.then(|| self.conditions.clone().lu().solve(&other.conditions)).flatten();
        turned.is_some_and(|turned| (turned - DMatrix::identity(n, n)).norm() < ALIKE)
    }

    /// By what multiple of what they left the tangent by before the unknowns will leave it where motors move by `moved`: it grows with the square of the way.
    fn again(&self, moved: &DVector<f64>) -> f64 {
        if self.came.is_empty() {
            return 0.0;
        }
        let along = moved.dot(&self.came) / self.came.norm_squared();
        if along.abs() <= FARTHER { along * along } else { 0.0 }
    }
}

impl BundleSolver<'_> {
    /// The equilibrium to which Newton's method leads from a neighbour; `None` where whole steps lead nowhere.
    pub(super) fn tracked(
        &mut self,
        frame: &Frame,
        command: &BundleCommand,
        start: &BundleEquilibrium,
        tolerance: f64,
    ) -> Option<BundleEquilibrium> {
        let walk = frame.walk(tolerance);
        let mut unknowns = frame.scaled(&start.unknowns);
        let mut steps = start.between.coarsened(tolerance);
        let fits = |own: &&Slopes| own.last.nrows() == unknowns.len() && command.driven_as(&start.command);
        let known = start.slopes.as_deref().filter(fits);
        let old = start.command.drives.iter().flat_map(|d| [d.translation.value(), d.rotation.value()]);
        let moved = frame.drives().into_iter().flatten().zip(old).map(|(new, old)| new - old);
        let moved = DVector::from_iterator(2 * command.drives.len(), moved);
        let mut straight = None;
        if let Some(known) = known {
            add(&mut unknowns, (&known.unknowns * &moved).as_slice());
            straight = Some(unknowns.clone());
            let again = known.again(&moved);
            add(&mut unknowns, &known.bend.iter().map(|bend| again * bend).collect::<Vec<_>>());
            let change = &known.last * &moved;
            steps.predict(&change.iter().chain(&moved).copied().collect::<Vec<_>>(), again);
        }
        let mut longest = LONGEST;
        for iterations in 1..=MOST {
            steps.adapt = true;
            let (mut slopes, arrived) = self.slopes(frame, &walk, &unknowns, &mut steps, 0)?;
            let (change, between) = steps.at_plate(slopes.step.as_slice(), &walk);
            let size = change.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
            if !(size <= longest && between.is_finite()) {
                return None;
            }
            add(&mut unknowns, &change);
            steps.advance(slopes.step.as_slice(), 1.0, 1.0);
            longest = SHRINKS * size;
            if size > SETTLED_NEAR || between > BETWEEN * SETTLED_NEAR {
                continue;
            }
            let same = known.is_some_and(|own| steps.keys() == start.between.keys() && own.alike(&slopes));
            let determinant = slopes.determinant;
            if let Some(straight) = straight {
                slopes.came = moved;
                slopes.bend = unknowns.iter().zip(&straight).map(|(own, straight)| own - straight).collect();
                steps.note_bend();
            }
            let mut found = self.report(frame, command, &unknowns, steps, iterations, &arrived);
            found.slopes = Some(slopes.into());
            if same && start.inertia.is_some() {
                (found.inertia, found.stable) = (start.inertia, start.stable);
            } else {
                let reference = self.rest_determinant(command);
                self.judge(&mut found, determinant, reference);
            }
            return Some(found);
        }
        None
    }
}

fn add(values: &mut [f64], change: &[f64]) {
    for (value, change) in values.iter_mut().zip(change) {
        *value += change;
    }
}
