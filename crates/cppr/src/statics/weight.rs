//! Gravity: the potential −m |h| γ·(c + R o) of every tube per unit of the leader's label, o the offset of its
//! centroid, and its derivatives by the local variables.

use super::assembly::{Assembly, Setting};
use crate::design::fields::FieldJets;
use crate::kinematics::follower::{Block, Facing, local};
use crate::kinematics::state::State;
use nalgebra::{Matrix3, Vector3};

impl Assembly {
    /// Adds the potential of gravity at one node: F −= w Σ m |h| γ·(c + R o).
    #[allow(clippy::too_many_arguments)]
    pub(super) fn weigh(
        &mut self,
        setting: &Setting,
        state: &State,
        node: usize,
        weight: f64,
        gravity: &Vector3<f64>,
        rotation: &Matrix3<f64>,
        centre: &Vector3<f64>,
    ) {
        let layout = setting.layout;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        let slopes = &mut self.slopes[node * rows..(node + 1) * rows];
        let body = rotation.transpose() * gravity;
        let height = gravity.dot(centre);
        let leader = &self.jets[node * layout.tubes];
        let arm = height + leader.offset[0] * body.y;
        self.values[node] -= weight * leader.mass[0] * arm;
        slopes[local::X] -= weight * (leader.mass[1] * arm + leader.mass[0] * leader.offset[1] * body.y);
        for f in 0..followers {
            let jets = &self.jets[node * layout.tubes + f + 1];
            let facing = &state.facing[node * followers + f];
            let along = -facing.cos * body.y + facing.sin * body.z;
            let across = facing.sin * body.y + facing.cos * body.z;
            let arm = height + jets.offset[0] * along;
            let [m, m1, _] = jets.mass;
            self.values[node] -= weight * m * facing.h * arm;
            for (variable, slope) in facing.dh.iter().enumerate() {
                slopes[State::row(f, variable)] -= weight * m * arm * slope;
            }
            slopes[State::row(f, local::FACE)] -= weight * facing.h * (m1 * arm + m * jets.offset[1] * along);
            slopes[State::row(f, local::TH)] -= weight * m * facing.h * jets.offset[0] * across;
        }
    }
}

/// Second derivatives of −w m |h| γ·(c + R o) by the local variables, without those of |h| itself, whose
/// factor is returned.
pub(super) fn add_hessian(
    facing: &Facing,
    jets: &FieldJets,
    weight: f64,
    gravity: &Vector3<f64>,
    rotation: &Matrix3<f64>,
    centre: &Vector3<f64>,
    block: &mut Block,
) -> f64 {
    let body = rotation.transpose() * gravity;
    let along = -facing.cos * body.y + facing.sin * body.z;
    let across = facing.sin * body.y + facing.cos * body.z;
    let [d, d1, d2] = jets.offset;
    let [m, m1, m2] = jets.mass;
    let arm = gravity.dot(centre) + d * along;
    // S(x, θ) = m · arm, so that F = −w h S.
    let (by_face, by_angle) = (m1 * arm + m * d1 * along, m * d * across);
    let mut add = |i: usize, j: usize, value: f64| {
        block[i][j] -= weight * value;
        if i != j {
            block[j][i] -= weight * value;
        }
    };
    add(local::FACE, local::FACE, facing.h * (m2 * arm + 2.0 * m1 * d1 * along + m * d2 * along));
    add(local::FACE, local::TH, facing.h * (m1 * d + m * d1) * across);
    add(local::TH, local::TH, -facing.h * m * d * along);
    for (variable, &slope) in facing.dh.iter().enumerate() {
        for (other, by) in [(local::FACE, by_face), (local::TH, by_angle)] {
            block[variable][other] -= weight * slope * by;
            block[other][variable] -= weight * slope * by;
        }
    }
    -weight * m * arm
}
