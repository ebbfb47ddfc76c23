//! Points in another unit than the table says: farther away than the robot reaches, or all at the baseplate.

use crate::data::{Measurement, Observed};
use crate::design::Design;
use cppr::Vector3;
use cppr::analysis::inverse::farthest;

/// Farther than so many standard deviations beyond the robot's reach no point lies by chance.
const DEVIATIONS: f64 = 5.0;
/// Part of the distance at which a robot would be; points that are all nearer to the baseplate are given in another unit.
const NEAR: f64 = 0.125;

/// The coordinates that were measured, 0 for the others (m).
fn measured(m: &Measurement) -> Vector3<f64> {
    m.point.map(|c| if c.is_nan() { 0.0 } else { c })
}

/// What is wrong with a point that the robot cannot reach.
pub(crate) fn within_reach(m: &Measurement, design: &Design) -> Result<(), String> {
    let distance = measured(m).norm();
    let (length, at) = match design {
        Design::Robot(own) => (own.length, m.at.unwrap_or(own.length)),
        // Tubes are advanced, and places on them with them.
        Design::Bundle(_) => {
            let length =
                design.length() - m.drives.iter().filter_map(|d| d.translation.motion()).fold(0.0, f64::min);
            (length, length)
        }
    };
    if distance <= farthest(at, length) + DEVIATIONS * m.sigma {
        return Ok(());
    }
    let name = design.name();
    let [distance, length] = [distance, length].map(|v| v * 1e3);
    Err(format!(
        "the point lies {distance:.3} mm from the baseplate, out of reach of {name}, which is {length:.3} mm long. Check the unit \
         and the frame"
    ))
}

/// Refuses points that are all far nearer to the baseplate than the robots before the fit: line of the nearest to its robot, and why.
/// `differences` are row, axis, and model minus measurement (m).
pub(crate) fn not_all_at_the_plate(
    measurements: &[Measurement],
    differences: &[(usize, Observed, f64)],
) -> Result<(), (usize, String)> {
    let mut nearest: Option<(f64, usize, f64)> = None;
    for m in measurements {
        if m.point.x.is_nan() || (m.point.y.is_nan() && m.point.z.is_nan()) {
            // One coordinate may be small anywhere.
            return Ok(());
        }
        let mut model = Vector3::zeros();
        for (_, what, difference) in differences.iter().filter(|(row, ..)| *row == m.row) {
            if let Observed::Coordinate(axis) = *what {
                model[axis] = m.point[axis] + difference;
            }
        }
        let share = measured(m).norm() / model.norm();
        if share >= NEAR {
            return Ok(());
        }
        if share >= nearest.map_or(0.0, |n| n.0) {
            nearest = Some((share, m.row, model.norm()));
        }
    }
    let Some((share, row, model)) = nearest else { return Ok(()) };
    let [point, model] = [share * model, model].map(|v| v * 1e3);
    Err((
        row,
        format!(
            "this point lies {point:.3} mm from the baseplate, where the robot would be at {model:.3} mm, and no other is better. \
             Check the unit"
        ),
    ))
}
