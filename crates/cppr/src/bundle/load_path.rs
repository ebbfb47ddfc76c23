//! Following equilibria from a known one to a command in steps.

use super::frame::{Frame, Unknowns};
use super::newton::Found;
use super::steps::Steps;

/// Shortest step, as a part of the way.
const SHORTEST_STEP: f64 = 1.0 / 4096.0;
/// Newton steps of an easy load step.
const EASY: usize = 6;
/// Load steps.
const MOST_STEPS: usize = 400;
/// By this factor at least the determinant falls from one of the shortest steps to the next where an eigenvalue vanishes.
const TURNING: f64 = 0.8;

/// Where a path from a neighbour to a command ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PathEnd {
    /// Share of the way on which equilibria as stable as the first were found.
    pub share: f64,
    /// Does an eigenvalue of theirs vanish there?
    pub turns: bool,
}

/// Where the next equilibrium of a path is sought: states at the last and the one before, each with its share of the way.
pub(super) struct Guess {
    last: (f64, Unknowns, Steps),
    before: Option<(f64, Unknowns, Steps)>,
}

impl Guess {
    pub fn new(unknowns: Unknowns, steps: Steps) -> Self {
        Self { last: (0.0, unknowns, steps), before: None }
    }

    /// How far a share of the way is from the last.
    pub fn way_to(&self, share: f64) -> f64 {
        share - self.last.0
    }

    /// On the line through both.
    pub fn at(&self, frame: &Frame, share: f64, tolerance: f64) -> (Vec<f64>, Steps) {
        let (reached, unknowns, between) = &self.last;
        let (mut start, mut steps) = (frame.scaled(unknowns), between.coarsened(tolerance));
        if let Some((from, unknowns, between)) = &self.before {
            let factor = (share - reached) / (reached - from);
            for (own, old) in start.iter_mut().zip(frame.scaled(unknowns)) {
                *own += factor * (*own - old);
            }
            steps.extrapolate(between, factor);
        }
        (start, steps)
    }
}

/// Goes along a path in steps, none longer than `longest`, to its end at 1. `attempt` finds the equilibrium at a share of the way; a step to where it finds
/// none is halved.
pub(super) fn follow(
    mut guess: Guess,
    longest: f64,
    mut attempt: impl FnMut(f64, &Guess) -> Option<(Unknowns, Found)>,
) -> Result<Found, PathEnd> {
    let mut step = longest.min(0.25);
    // Determinants at the last three places.
    let mut determinants = [f64::NAN; 3];
    for _ in 0..MOST_STEPS {
        let reached = guess.last.0;
        let next = f64::min(1.0, reached + step);
        match attempt(next, &guess) {
            Some((_, found)) if next >= 1.0 => return Ok(found),
            Some((unknowns, found)) => {
                step = longest.min(step * if found.iterations <= EASY { 2.0 } else { 1.0 });
                determinants = [determinants[1], determinants[2], found.determinant.abs()];
                guess.before = Some(std::mem::replace(&mut guess.last, (next, unknowns, found.steps)));
            }
            None => step *= 0.5,
        }
        if step < SHORTEST_STEP {
            break;
        }
    }
    // The steps shrink towards a place where an eigenvalue vanishes, and the determinant with it.
    let [first, second, third] = determinants;
    Err(PathEnd { share: guess.last.0, turns: third < TURNING * second && second < first })
}
