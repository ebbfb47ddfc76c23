//! Gravity: the potential −m |h| γ·(c + R o) of every tube per unit of the leader's label, o the offset of its
//! centroid, and its derivatives by the local variables.

use super::assembly::{Assembly, Setting};
use crate::design::fields::{FieldJets, Jet};
use crate::kinematics::follower::{Facing, local};
use crate::kinematics::state::{State, row};
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

impl<S: Real> Assembly<S> {
    /// Adds the potential of gravity at one node: F −= w Σ m |h| γ·(c + R o).
    #[allow(clippy::too_many_arguments)]
    pub(super) fn weigh(
        &mut self,
        setting: &Setting,
        state: &State<S>,
        node: usize,
        weight: f64,
        gravity: &Vector3<S>,
        rotation: &Matrix3<S>,
        centre: &Vector3<S>,
    ) {
        let layout = setting.layout;
        let (rows, followers) = (layout.rows(), layout.tubes - 1);
        let slopes = &mut self.slopes[node * rows..(node + 1) * rows];
        let body = rotation.transpose() * gravity;
        let height = gravity.dot(centre);
        let [mass, offset] = weighing(&self.jets[node * layout.tubes]);
        let arm = height + offset[0] * body.y;
        self.values[node] -= mass[0] * arm * weight;
        slopes[local::X] -= (mass[1] * arm + mass[0] * offset[1] * body.y) * weight;
        for f in 0..followers {
            let [mass, offset] = weighing(&self.jets[node * layout.tubes + f + 1]);
            let facing = &state.facing[node * followers + f];
            let along = facing.sin * body.z - facing.cos * body.y;
            let across = facing.sin * body.y + facing.cos * body.z;
            let arm = height + offset[0] * along;
            let [m, m1, _] = mass.map(|m| m * weight);
            self.values[node] -= m * facing.h * arm;
            for (variable, slope) in facing.dh.iter().enumerate() {
                slopes[row(f, variable)] -= m * arm * *slope;
            }
            slopes[row(f, local::FACE)] -= facing.h * (m1 * arm + m * offset[1] * along);
            slopes[row(f, local::TH)] -= m * facing.h * offset[0] * across;
        }
    }
}

/// Mass and offset: the fields on which a tube's weight depends.
pub(super) fn weighing<S: Real>(fields: &FieldJets<S>) -> [Jet<S>; 2] {
    let FieldJets { mass, offset, bending_y: _, bending_z: _, torsion: _, axial: _, direction: _ } = *fields;
    [mass, offset]
}

/// Second derivatives of −w m |h| γ·(c + R o) by the local variables (`add(i, j, value)` takes each pair once), without
/// those of |h| itself, whose factor is returned.
pub(super) fn second<S: Real>(
    facing: &Facing<S>,
    jets: &FieldJets<S>,
    weight: f64,
    gravity: &Vector3<S>,
    rotation: &Matrix3<S>,
    centre: &Vector3<S>,
    add: &mut impl FnMut(usize, usize, S),
) -> S {
    let body = rotation.transpose() * gravity;
    let along = facing.sin * body.z - facing.cos * body.y;
    let across = facing.sin * body.y + facing.cos * body.z;
    let [mass, [d, d1, d2]] = weighing(jets);
    let [m, m1, m2] = mass.map(|m| m * -weight);
    let arm = gravity.dot(centre) + d * along;
    // S(x, θ) = m · arm, so that F = −w h S.
    let (by_face, by_angle) = (m1 * arm + m * d1 * along, m * d * across);
    let bent = m2 * arm + m1 * d1 * along * 2.0 + m * d2 * along;
    add(local::FACE, local::FACE, facing.h * bent);
    add(local::FACE, local::TH, facing.h * (m1 * d + m * d1) * across);
    add(local::TH, local::TH, -facing.h * m * d * along);
    for (variable, &slope) in facing.dh.iter().enumerate() {
        for (other, by) in [(local::FACE, by_face), (local::TH, by_angle)] {
            // The product rule meets the diagonal twice.
            let twice = if variable == other { 2.0 } else { 1.0 };
            add(variable, other, slope * by * twice);
        }
    }
    m * arm
}
