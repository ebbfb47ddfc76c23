//! How far a robot bends in all.
//!
//! The total bend is the total curvature of the centreline, the length of the curve that its tangent draws on the unit sphere:
//!
//!   ∫_0^L |d(R E_X)/dX| dX = ∫_0^L √(K_Y² + K_Z²) dX ,   from dR/dX = R K^ .
//!
//! It depends on no frame and on no parameter of the curve. Where curvature lies in one plane and has one sign it is the angle
//! between tip and base, and goes on counting beyond 180°; elsewhere it is larger.

use crate::kinematics::layout::Layout;
use crate::kinematics::rule::Rule;
use crate::solve::Equilibrium;

/// Error of the quadrature on an element (rad).
const TOLERANCE: f64 = 1e-11;
/// Halvings of an element: where the curvature passes through zero its magnitude has a kink, and the error of the piece that holds it
/// falls with the square of the length.
const HALVINGS: u32 = 30;

/// Total bend of the centreline (rad).
#[must_use]
pub fn total_bend(equilibrium: &Equilibrium) -> f64 {
    let (layout, coordinates) = (&equilibrium.layout, &equilibrium.point.coordinates);
    let mut buffer = Vec::new();
    let elements = layout.elements.iter().enumerate();
    elements
        .map(|(e, element)| {
            let [from, to] = [element.start, element.end].map(|joint| Layout::label(joint, coordinates).0);
            let mut bend = |x: f64| {
                let [y, z] = [1, 2].map(|field| layout.field(coordinates, e, x, field, &mut buffer));
                (to - from) * y.hypot(z)
            };
            let rule = &layout.rules[element.rule];
            let whole = piece(rule, &mut bend, [0.0, 1.0]);
            halved(rule, &mut bend, [0.0, 1.0], whole, HALVINGS)
        })
        .sum()
}

/// The rule on a piece of an element.
fn piece(rule: &Rule, value: &mut impl FnMut(f64) -> f64, [from, to]: [f64; 2]) -> f64 {
    let nodes = rule.nodes.iter().zip(&rule.weights);
    nodes.map(|(x, weight)| (to - from) * weight * value(from + (to - from) * x)).sum()
}

/// The piece in halves, and these again, until that changes nothing.
fn halved(
    rule: &Rule,
    value: &mut impl FnMut(f64) -> f64,
    [from, to]: [f64; 2],
    whole: f64,
    left: u32,
) -> f64 {
    let middle = 0.5 * (from + to);
    let halves = [[from, middle], [middle, to]];
    let [first, last] = halves.map(|half| piece(rule, value, half));
    if left == 0 || (first + last - whole).abs() <= TOLERANCE {
        return first + last;
    }
    halved(rule, value, halves[0], first, left - 1) + halved(rule, value, halves[1], last, left - 1)
}
