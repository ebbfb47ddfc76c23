//! When an iterate is an equilibrium, and when a step of Newton's method counts: one policy for single solves, for lanes and for
//! the corrector of a path. All numbers are scaled (see [`super::system`]); masks have a bit for each lane.

use crate::real::Real;

/// Below this the scaled residual is rounding error of the assembly.
const FLOOR: f64 = 1e-8;
/// Largest distance from the equilibrium in scaled unknowns: near a bifurcation residuals vanish early.
const NEAREST: f64 = 2e-11;
/// How often a tangent serves once more at most.
pub(crate) const MOST_REUSES: i32 = 3;
/// Shortest part of a Newton step that is tried.
pub(crate) const SHORTEST: f64 = 1.0 / 4096.0;
/// Largest change of a scaled coordinate (curvature times length: an angle in rad) in one step.
const LONGEST: f64 = 20.0;

/// Is this an equilibrium? `distance` is how far the last tangent saw it from here.
pub(crate) fn arrived<S: Real>(residual: S, distance: S, tolerance: f64) -> u64 {
    residual.mask(|r| r <= tolerance) & distance.mask(|d| d <= NEAREST)
}

/// Is rounding all that is left?
pub(crate) fn is_rounding(residual: f64) -> bool {
    residual <= FLOOR
}

/// The part of a step that keeps every scaled coordinate below its bound.
pub(crate) fn longest_part<S: Real>(largest: S) -> S {
    largest.map(|s| (LONGEST / s).min(1.0))
}

/// Deuflhard's natural monotonicity test: the next correction with the same tangent has to be shorter than the part `factor` of a
/// step of this length. Unlike the residual's norm it does not depend on how equations are scaled, and so does not stop at
/// long steps along a curved valley of the energy.
pub(crate) fn shrinks<S: Real>(correction: S, length: S, factor: f64) -> u64 {
    (correction - length * (1.0 - 0.25 * factor)).mask(|excess| excess <= 0.0)
}

/// By which ratio each use of a tangent is expected to shrink the residual, after a whole step has done so.
pub(crate) fn expected_ratio<S: Real>(reached: S, before: S) -> S {
    reached * 2.0 / before
}

/// Does a tangent promise an equilibrium if it serves `left` times more? That takes fewer operations than a new one.
pub(crate) fn promises<S: Real>(reached: S, distance: S, ratio: S, left: i32, tolerance: f64) -> u64 {
    let rest = ratio.map(|r| r.powi(left));
    arrived(reached * rest, distance * rest, tolerance)
}

/// Has a tangent that served once more kept its promise, at least by half?
pub(crate) fn keeps<S: Real>(reached: S, before: S) -> u64 {
    (reached - before * 0.5).mask(|excess| excess < 0.0)
}

/// Does the corrector of a path contract? It begins near the path and may be stricter than a single solve.
pub(crate) fn contracts(size: f64, before: f64) -> bool {
    size.is_finite() && size <= 0.5 * before
}
