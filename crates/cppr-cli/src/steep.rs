//! Steps in what a robot file says along a tube, which the modes of the usual solver do not follow.

use crate::table::millimetres;
use cppr::design::{Profile, Robot, TubeDesign};

/// Samples along the robot, and over how many of them a change counts as sudden: a fiftieth of the length.
const SAMPLES: u32 = 500;
const WINDOW: usize = 10;
/// A change is sudden where it is so many times steeper than the mean.
const STEEPER: f64 = 5.0;
/// Turns of the opening (rad) and parts of the greatest depth or stiffness that matter.
const TURN: f64 = 0.35;
const PART: f64 = 0.25;

/// A sentence on sudden changes, where there are any.
pub fn steep(robot: &Robot) -> Option<String> {
    let length = robot.length();
    let tubes = robot.design().tubes.iter().enumerate();
    let places: Vec<String> = tubes
        .filter_map(|(index, tube)| {
            let (name, field, direction) = match tube {
                TubeDesign::Notched(t) => ("notch depth", &t.depth, &t.direction),
                TubeDesign::Stiffness(t) => ("bending stiffness", &t.bending_z, &t.direction),
            };
            let turn = sudden(direction, length, Some(TURN)).map(|x| ("opening", x));
            let (name, x) = turn.or_else(|| Some((name, sudden(field, length, None)?)))?;
            let mm = millimetres((x * 1e4).round() * 1e-4);
            Some(format!("{name} of tube {} at {mm} mm", index + 1))
        })
        .collect();
    (!places.is_empty()).then(|| {
        format!(
            "sudden changes are not followed by these equations ({}): write a [[tube.part]] on either side, or add to the file a \
             [[joint]] of all tubes, and the robot is integrated along its length",
            places.join(", ")
        )
    })
}

/// Where a profile changes by more than `least` (or that part of its greatest value) within a window, and far more steeply than along the whole.
fn sudden(profile: &Profile, length: f64, least: Option<f64>) -> Option<f64> {
    let x = |i: usize| length * i as f64 / f64::from(SAMPLES);
    let values: Vec<f64> = (0..=SAMPLES as usize).map(|i| profile.eval(x(i), length)[0]).collect();
    let least = least.unwrap_or_else(|| PART * values.iter().fold(0.0, |m: f64, v| m.max(v.abs())));
    let whole: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
    // A turn that is even all along is no step; of a step the window holds all there is.
    let mean = whole * WINDOW as f64 / f64::from(SAMPLES);
    let steps = values.windows(WINDOW + 1).map(|w| (w[WINDOW] - w[0]).abs());
    let sudden = steps.enumerate().find(|(_, change)| *change > least && *change > STEEPER * mean)?;
    // The first window that holds one; within it the steepest cell.
    let cell = |i: usize| (values[i + 1] - values[i]).abs();
    let steepest = (sudden.0..sudden.0 + WINDOW).max_by(|a, b| cell(*a).total_cmp(&cell(*b)))?;
    Some(0.5 * (x(steepest) + x(steepest + 1)))
}
