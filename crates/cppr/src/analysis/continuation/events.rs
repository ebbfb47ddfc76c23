//! Folds and branch points between two points of a path, and where exactly they are.

use super::bordered::{Node, length, weigh};
use super::track::Tracer;
use crate::dense::dot;
use crate::solve::stability::NEUTRAL;

/// A function that vanishes at an event and changes its sign there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Test {
    /// dλ/ds.
    Fold,
    /// An eigenvalue of the constrained tangent, by its rank; how many vanish.
    Eigenvalue(usize, usize),
    /// The determinant of the bordered system.
    Determinant,
}

/// What lies between two neighbours.
pub(super) enum Between {
    Nothing,
    One(Test),
    /// More than a single event: take a shorter step.
    Several,
}

/// Two events closer than this along the path count as one.
pub(super) const SEPARATE: f64 = 1e-4;

/// The least singular value of the bordered system is zero where it is this part of those half a step away.
const SINGULAR: f64 = 1e-3;

/// A function that is not this part of its values at the ends, where its zero is enclosed, jumps there.
const JUMP: f64 = 1e-3;

/// Regula falsi in the Illinois form on [0, `distance`], where a function has the values `ends` of different sign, until
/// its zero is enclosed to the tolerance: what belongs to the smallest value met. `None` where the function cannot be
/// evaluated, or jumps: the curve has been left for another one.
pub(super) fn enclose<T>(
    distance: f64,
    ends: [f64; 2],
    tolerance: f64,
    mut at: impl FnMut(f64) -> Option<(f64, T)>,
) -> Option<T> {
    let (mut low, mut high) = ((0.0, ends[0]), (distance, ends[1]));
    let mut found: Option<(f64, T)> = None;
    let mut side = 0.0;
    while high.0 - low.0 > tolerance {
        let inside = (0.5 * tolerance).min(0.25 * (high.0 - low.0));
        let secant = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let place = if secant.is_finite() { secant } else { 0.5 * (low.0 + high.0) };
        let place = place.clamp(low.0 + inside, high.0 - inside);
        let (value, what) = at(place)?;
        if value * low.1 > 0.0 {
            high.1 *= if side > 0.0 { 0.5 } else { 1.0 };
            (low, side) = ((place, value), 1.0);
        } else {
            low.1 *= if side < 0.0 { 0.5 } else { 1.0 };
            (high, side) = ((place, value), -1.0);
        }
        if found.as_ref().is_none_or(|(least, _)| value.abs() < *least) {
            found = Some((value.abs(), what));
        }
    }
    let small = JUMP * ends[0].abs().max(ends[1].abs());
    found.filter(|(least, _)| *least <= small).map(|(_, what)| what)
}

impl Tracer<'_> {
    pub(super) fn between(&self, here: &Node, next: &Node, distance: f64) -> Between {
        let fold = here.slope() * next.slope() < 0.0;
        let crossed = here.inertia().abs_diff(next.inertia());
        let rank = here.inertia().min(next.inertia());
        let flipped = here.determinant.sign * next.determinant.sign < 0.0;
        // At a fold one eigenvalue changes its sign, unless it is one that the symmetric part does not show.
        let crossing = crossed.saturating_sub(usize::from(fold));
        let branch = if crossing > 0 {
            Some(Test::Eigenvalue(rank, crossing))
        } else if flipped && !(self.conservative && here.spectrum.is_some()) {
            Some(Test::Determinant)
        } else {
            None
        };
        match (fold, branch) {
            (false, None) => Between::Nothing,
            (true, None) => Between::One(Test::Fold),
            (false, Some(test @ (Test::Determinant | Test::Eigenvalue(_, 1)))) => Between::One(test),
            (false, Some(test)) if distance <= SEPARATE => Between::One(test),
            (true, Some(_)) if distance <= SEPARATE => Between::One(Test::Fold),
            _ => Between::Several,
        }
    }

    fn value(test: Test, node: &Node, first: &Node) -> f64 {
        match test {
            Test::Fold => node.slope(),
            Test::Eigenvalue(rank, _) => {
                node.spectrum.as_ref().and_then(|s| s.get(rank)).map_or(0.0, |value| value + NEUTRAL)
            }
            Test::Determinant => {
                let [own, reference] = [node, first].map(|n| n.determinant);
                own.sign * (own.ln - reference.ln).exp()
            }
        }
    }

    /// The node on the path from `here` at which a test vanishes; `next` lies `distance` along.
    pub(super) fn locate(&mut self, here: &Node, next: &Node, distance: f64, test: Test) -> Option<Node> {
        let ends = [here, next].map(|node| Self::value(test, node, here));
        enclose(distance, ends, self.tracing.tolerance, |at| {
            let node = self.at(here, at)?;
            Some((Self::value(test, &node, here), node))
        })
    }

    /// The node near `distance` from `here` where the bordered system itself is singular; `None` where only the symmetric
    /// part of the tangent is. The least singular value falls towards such a place and rises behind it: golden section.
    pub(super) fn singular(&mut self, here: &Node, distance: f64) -> Option<Node> {
        let least = |tracer: &mut Self, at: f64| {
            let node = tracer.at(here, at)?;
            let value = tracer.solver.critical(&node, 1)?.1;
            Some((value, node))
        };
        let half = 0.5 * self.tracing.step;
        let (mut low, mut high) = (distance - half, distance + half);
        let around = least(self, low)?.0.min(least(self, high)?.0);
        let share = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut a, mut b) = (high - share * (high - low), low + share * (high - low));
        let (mut at_a, mut at_b) = (least(self, a)?, least(self, b)?);
        while high - low > self.tracing.tolerance {
            if at_a.0 < at_b.0 {
                (high, b, at_b) = (b, a, at_a);
                a = high - share * (high - low);
                at_a = least(self, a)?;
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + share * (high - low);
                at_b = least(self, b)?;
            }
        }
        let (value, node) = if at_a.0 < at_b.0 { at_a } else { at_b };
        (value <= SINGULAR * around).then_some(node)
    }

    /// A branch point with the tangent of its own branch, and the directions that leave it.
    pub(super) fn crossing(
        &mut self,
        mut node: Node,
        here: &Node,
        next: &Node,
        multiplicity: usize,
    ) -> Option<(Node, Vec<Vec<f64>>)> {
        // At the point itself the bordered system has no unique tangent: take the one between the neighbours'.
        let mut tangent: Vec<f64> = here.tangent.iter().zip(&next.tangent).map(|(a, b)| a + b).collect();
        let size = length(&node.stage, &tangent);
        for t in &mut tangent {
            *t /= size;
        }
        node.tangent = tangent;
        let (directions, _) = self.solver.critical(&node, multiplicity)?;
        Some((node, directions))
    }

    /// The first node of the branch that leaves a branch point along (or against) a critical direction φ: φ·W (z − z*) is
    /// prescribed, the rest is free.
    pub(super) fn switch(&mut self, node: &Node, direction: &[f64], along: bool) -> Option<Node> {
        let sign = if along { 1.0 } else { -1.0 };
        let direction: Vec<f64> = direction.iter().map(|d| sign * d).collect();
        let row = weigh(&node.stage, &direction);
        let mut distance = 0.5 * self.tracing.step;
        while distance > 1e-2 * self.tracing.step {
            let mut place = self.solver.predicted(&node.stage, &node.place, &direction, distance);
            let corrected =
                self.solver.correct(&node.stage, &mut place, &row, self.solver.settings.tolerance);
            let strayed = self.solver.offset(&node.place, &place, &weigh(&node.stage, &node.tangent));
            if corrected.is_some() && strayed.abs() <= 3.0 * distance {
                let next = self.solver.node(&node.stage, &place, &row)?;
                if dot(&row, &next.tangent) > 0.1 {
                    return Some(next);
                }
            }
            distance *= 0.5;
        }
        None
    }
}
