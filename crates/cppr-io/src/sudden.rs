//! Steps in what a robot file says along a tube, which the modes of the usual solver do not follow.

use cppr::design::{Profile, RobotDesign, TubeDesign};

/// Cells along the robot, and over how many of them a change counts as sudden: a fiftieth of the length.
const CELLS: usize = 500;
const WINDOW: usize = 10;
/// A change is sudden where it is so many times steeper than the mean, and this part of the greatest value.
const STEEPER: f64 = 5.0;
const PART: f64 = 0.25;
/// By how much (rad) the opening may turn on a twenty-fifth of the length more or less than it would evenly. Ramps beyond that put the tip off by more
/// than some 2e-4 of the length, whether they are short or long; 4° at once make 4e-3, 10° 1e-2, half a turn 0.1.
const UNEVEN: f64 = 0.006;

/// Where a robot of tubes of one length has sudden changes that modes do not follow, in words such as "notch depth of tube 1 at 30 mm"; `None` where it
/// has none.
#[must_use]
pub fn sudden_changes(design: &RobotDesign) -> Option<String> {
    let length = design.length;
    let tubes = design.tubes.iter().enumerate();
    let places: Vec<String> = tubes
        .filter_map(|(index, tube)| {
            let (name, field, direction) = match tube {
                TubeDesign::Notched(t) => ("notch depth", &t.depth, &t.direction),
                TubeDesign::Stiffness(t) => ("bending stiffness", &t.bending_z, &t.direction),
            };
            let turn = uneven(direction, length).map(|x| ("opening", x));
            let (name, x) = turn.or_else(|| Some((name, sudden(field, length)?)))?;
            Some(format!("{name} of tube {} at {} mm", index + 1, (x * 1e4).round() / 10.0))
        })
        .collect();
    (!places.is_empty()).then(|| places.join(", "))
}

/// A profile at the ends of all cells.
fn sampled(profile: &Profile, length: f64) -> Vec<f64> {
    (0..=CELLS).map(|i| profile.eval(length * i as f64 / CELLS as f64, length)[0]).collect()
}

/// Middle (m) of the steepest of some cells.
fn steepest(values: &[f64], cells: std::ops::Range<usize>, length: f64) -> Option<f64> {
    let change = |i: usize| (values[i + 1] - values[i]).abs();
    let cell = cells.max_by(|a, b| change(*a).total_cmp(&change(*b)))?;
    Some(length * (cell as f64 + 0.5) / CELLS as f64)
}

/// Where a direction turns other than evenly.
fn uneven(direction: &Profile, length: f64) -> Option<f64> {
    let values = sampled(direction, length);
    let window = CELLS / 25;
    let even = (values[CELLS] - values[0]) * window as f64 / CELLS as f64;
    let excess = values.windows(window + 1).map(|w| (w[window] - w[0] - even).abs()).fold(0.0, f64::max);
    (excess > UNEVEN).then(|| steepest(&values, 0..CELLS, length)).flatten()
}

/// Where a profile changes by a part of its greatest value within a window, far more steeply than along the whole.
fn sudden(profile: &Profile, length: f64) -> Option<f64> {
    let values = sampled(profile, length);
    let least = PART * values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let whole: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
    let mean = whole * WINDOW as f64 / CELLS as f64;
    let changes = values.windows(WINDOW + 1).map(|w| (w[WINDOW] - w[0]).abs());
    let (place, _) = changes.enumerate().find(|(_, change)| *change > least && *change > STEEPER * mean)?;
    steepest(&values, place..place + WINDOW, length)
}
