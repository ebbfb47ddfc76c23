//! Which prescribed pulls contradict one another.
//!
//! Tubes that do not stretch are as long along their centroids as the robot's bend makes them. At rest, with d_k(x) = D_k (cos φ_k, sin φ_k)
//! the centroid of tube k and κ(x) the curvature, both across the axis,
//!
//!   Δa_k = ∫ (d_1 − d_k)·(κ_Z, −κ_Y) dx ,
//!
//! so that prescribed pulls are independent only as far as the functions d_1 − d_k are: two of them where no pattern changes along
//! the tubes. Their Gram matrix, each function scaled to length 1, tells by its lowest eigenvalue.

use crate::design::Robot;
use crate::solve::{Command, Drive};
use nalgebra::{DMatrix, DVector};

/// Sections over which the functions are compared.
const SECTIONS: u32 = 64;
/// An eigenvalue below this asks for bends some thirty times as strong as the pulls by themselves would.
const DEPENDENT: f64 = 1e-3;
/// A share of a combination, or a contradiction, below this is rounding.
const NONE: f64 = 1e-6;

/// Numbers of the tubes whose prescribed pulls cannot all be had without stretch, or only by a far stronger bend.
#[must_use]
pub fn contradicting_pulls(robot: &Robot, command: &Command) -> Option<Vec<usize>> {
    let length = robot.length();
    let centroid = |tube: usize, x: f64| {
        let fields = robot.fields_at(tube, x);
        let (sin, cos) = fields.direction.sin_cos();
        [fields.centroid_offset * cos, fields.centroid_offset * sin]
    };
    // One row per tube: both components of d_1 − d_k at the middle of every section.
    let row = |tube: usize| {
        DVector::from_iterator(
            2 * SECTIONS as usize,
            (0..SECTIONS).flat_map(|i| {
                let x = length * (f64::from(i) + 0.5) / f64::from(SECTIONS);
                let (leader, own) = (centroid(0, x), centroid(tube - 1, x));
                [leader[0] - own[0], leader[1] - own[1]]
            }),
        )
    };
    let pulls: Vec<(usize, f64, DVector<f64>)> = command
        .actuators
        .iter()
        .zip(2..)
        .filter_map(|(actuator, tube)| match actuator.push_pull {
            Drive::Motion(pull) => {
                let lever = row(tube);
                let size = lever.norm();
                (size > 0.0).then(|| (tube, pull / size, lever / size))
            }
            Drive::Effort(_) => None,
        })
        .collect();
    let n = pulls.len();
    if n < 2 {
        return None;
    }
    let gram = DMatrix::from_fn(n, n, |i, j| pulls[i].2.dot(&pulls[j].2)).symmetric_eigen();
    let lowest = gram.eigenvalues.imin();
    if gram.eigenvalues[lowest] > DEPENDENT {
        return None;
    }
    let combination = gram.eigenvectors.column(lowest);
    let wanted = DVector::from_iterator(n, pulls.iter().map(|p| p.1));
    if combination.dot(&wanted).abs() <= NONE * wanted.norm() {
        return None;
    }
    Some(
        pulls
            .iter()
            .zip(combination.iter())
            .filter(|(_, share)| share.abs() > NONE)
            .map(|(p, _)| p.0)
            .collect(),
    )
}
