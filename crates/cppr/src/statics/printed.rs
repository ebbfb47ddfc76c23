//! The generalised force of the paper as printed (eq 48, 59–64; 90 and 91 in space), with its misprints mended.
//!
//! Every tube is cut free and carries what its end gives it: follower k the force T_k e_X and the moment −Υ_k e_X that
//! its actuator puts on its centroid at the plate, the leader the rest at the tip. These wrenches, constant in
//! space but for gravity, are projected on the strains' variation **at fixed label X** of the leader:
//!
//! ```text
//! Q = Σ_i ∫ |h_i| δξ_iᵀ (Λ_ext − Λ_int) dX
//! ```
//!
//! The variation at fixed X leaves out that the follower's sections move along the leader; for a stress that a
//! frictionless guide cannot bear (a moment T·y about the centroid) this is not small wherever the curvature
//! varies. Kept for comparison with the paper's figures; `assembly` holds what is right.

use super::assembly::{Efforts, Setting, applied};
use super::load::Loads;
use crate::dense::axpy;
use crate::design::fields::FieldJets;
use crate::kinematics::follower::local;
use crate::kinematics::pose::{Poses, base_rotation, point};
use crate::kinematics::so3;
use crate::kinematics::state::{State, part, row};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// A force and its moment about the origin of the base frame.
#[derive(Clone, Copy, Default)]
struct Wrench {
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Wrench {
    fn at(place: &Vector3<f64>, force: Vector3<f64>) -> Self {
        Self { force, moment: place.cross(&force) }
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.force += other.force * factor;
        self.moment += other.moment * factor;
    }

    /// Components in a section's axes, moment about `place`.
    fn seen(&self, rotation: &Matrix3<f64>, place: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let moment = self.moment - place.cross(&self.force);
        (rotation.transpose() * self.force, rotation.transpose() * moment)
    }
}

/// −Q by the modes; entries of edges stay zero. `jets` are the fields at the nodes.
pub(crate) fn residual(
    setting: &Setting,
    coordinates: &[f64],
    state: &State,
    poses: &Poses,
    jets: &[FieldJets],
    efforts: &Efforts,
    result: &mut Vec<f64>,
) {
    let layout = setting.layout;
    let edges = layout.edges.len();
    result.clear();
    result.resize(state.unknowns, 0.0);
    let mut tip = Wrench::default();
    let mut all = Vec::new();
    applied(setting, poses, coordinates, &mut all);
    let last = poses.centre.len() - 1;
    for (_, load) in all.iter().filter(|(at, _)| *at == last) {
        tip.add(&Wrench::at(&(poses.centre[last] + load.arm), load.force), 1.0);
        tip.moment += load.moment;
    }
    for f in 0..layout.tubes - 1 {
        let end = follower(setting, state, poses, jets, efforts, f, result);
        tip.add(&end, -1.0);
    }
    // The leader, from the tip to the base.
    for (e, element) in layout.elements.iter().enumerate().rev() {
        let rule = &layout.rules[element.rule];
        let length = state.lengths[e];
        if e + 1 < layout.elements.len() {
            let end = point(layout, e, rule.n);
            for (_, load) in all.iter().filter(|(at, _)| *at == end) {
                tip.add(&Wrench::at(&(poses.centre[end] + load.arm), load.force), 1.0);
                tip.moment += load.moment;
            }
        }
        let spread: Vec<Wrench> = (0..rule.n).map(|i| on_leader(setting, state, poses, jets, e, i)).collect();
        for i in 0..rule.n {
            let (node, at) = (element.first_node + i, point(layout, e, i));
            let mut wrench = tip;
            for (j, own) in spread.iter().enumerate() {
                wrench.add(own, length * rule.to_end[i * rule.n + j]);
            }
            let own = &jets[node * layout.tubes];
            let offset = own.offset[0];
            let place = poses.centre[at] + poses.rotation[at].column(1) * offset;
            let (force, moment) = wrench.seen(&poses.rotation[at], &place);
            let v = &state.local[node * layout.rows()..];
            let mut stress = [
                own.torsion[0] * (v[local::KX] - own.direction[1]) - moment.x - offset * force.z,
                own.bending_y[0] * v[local::KY] - moment.y,
                own.bending_z[0] * v[local::KZ] - moment.z,
                0.0,
            ];
            if layout.stretch {
                stress[3] = own.axial[0] * v[local::E1] - force.x;
            }
            for (strain, stress) in stress.into_iter().enumerate() {
                axpy(
                    &mut result[edges..],
                    length * rule.weights[i] * stress,
                    &state.z_row(node, strain)[edges..],
                );
            }
        }
        for (i, own) in spread.iter().enumerate() {
            tip.add(own, length * rule.weights[i]);
        }
    }
}

/// Load per length of the leader at a node: its own weight and the distributed forces.
fn on_leader(
    setting: &Setting,
    state: &State,
    poses: &Poses,
    jets: &[FieldJets],
    e: usize,
    i: usize,
) -> Wrench {
    let layout = setting.layout;
    let (node, at) = (layout.elements[e].first_node + i, point(layout, e, i));
    let label = state.local[node * layout.rows() + local::X];
    let mut wrench = Wrench::default();
    // Wrenches and threads act at the ends of elements.
    let Loads { distributed: _, gravity: _, wrenches: _, threads: _ } = setting.kinds();
    for force in setting.distributed(label) {
        wrench.add(&Wrench::at(&poses.centre[at], force), 1.0);
    }
    if let Some(gravity) = setting.gravity::<f64>() {
        let own = &jets[node * layout.tubes];
        let place = poses.centre[at] + poses.rotation[at].column(1) * own.offset[0];
        wrench.add(&Wrench::at(&place, gravity * own.mass[0]), 1.0);
    }
    wrench
}

/// Adds the projection of one follower's stress and returns the wrench that it passes on at the tip.
fn follower(
    setting: &Setting,
    state: &State,
    poses: &Poses,
    jets: &[FieldJets],
    efforts: &Efforts,
    f: usize,
    result: &mut [f64],
) -> Wrench {
    let Setting { robot, layout, .. } = setting;
    let edges = layout.edges.len();
    let followers = layout.tubes - 1;
    let mut wrench = at_plate(setting, state, efforts, f);
    for (e, element) in layout.elements.iter().enumerate() {
        let rule = &layout.rules[element.rule];
        let length = state.lengths[e];
        let mut spread = vec![Wrench::default(); rule.n];
        let section = |i: usize| {
            let (node, at) = (element.first_node + i, point(layout, e, i));
            let angle = state.local[node * layout.rows() + row(f, local::TH)];
            let rotation = poses.rotation[at] * so3::about_x(PI - angle);
            let offset = jets[node * layout.tubes + f + 1].offset[0];
            let place: Vector3<f64> = poses.centre[at] + rotation.column(1) * offset;
            (rotation, place)
        };
        if let Some(gravity) = setting.gravity::<f64>() {
            for (i, spread) in spread.iter_mut().enumerate() {
                let node = element.first_node + i;
                let mass = jets[node * layout.tubes + f + 1].mass[0] * state.facing[node * followers + f].h;
                *spread = Wrench::at(&section(i).1, gravity * mass);
            }
        }
        for i in 0..rule.n {
            let node = element.first_node + i;
            let mut here = wrench;
            for (j, own) in spread.iter().enumerate() {
                here.add(own, -length * rule.from_start[i * rule.n + j]);
            }
            let (rotation, place) = section(i);
            let (force, moment) = here.seen(&rotation, &place);
            let facing = &state.facing[node * followers + f];
            let own = robot.fields()[f + 1]
                .jets(state.local[node * layout.rows() + row(f, local::FACE)], part(element, f + 1));
            let strain = Vector3::new(facing.a, -facing.p, -facing.r) / facing.h;
            let stress = Vector3::new(
                own.torsion[0] * (strain.x - own.direction[1]) - moment.x - own.offset[0] * force.z,
                own.bending_y[0] * strain.y - moment.y,
                own.bending_z[0] * strain.z - moment.z,
            );
            // |h| δκ = δ(a, −p, −r) − κ δ|h| and |h| δΓ_Y = −Γ_Y δ|h|: everything at fixed X, the fields of
            // the follower and their slopes by X held.
            let along_h = force.y * own.offset[1] - stress.dot(&strain);
            let mut slopes = facing.dh.map(|slope| slope * along_h);
            let (s, c) = (facing.sin, facing.cos);
            slopes[local::KX] += stress.x;
            slopes[local::DTH] -= stress.x;
            slopes[local::KY] -= stress.y * c + stress.z * s;
            slopes[local::KZ] += stress.y * s - stress.z * c;
            slopes[local::TH] += stress.y * facing.r - stress.z * facing.p;
            if layout.stretch {
                let stretch = state.local[node * layout.rows() + row(f, local::EK)];
                slopes[local::EK] += facing.h * (own.axial[0] * stretch - force.x);
            }
            for (variable, slope) in slopes.into_iter().enumerate() {
                if variable != local::FACE && variable != local::X {
                    axpy(
                        &mut result[edges..],
                        length * rule.weights[i] * slope,
                        &state.z_row(node, row(f, variable))[edges..],
                    );
                }
            }
        }
        for (i, own) in spread.iter().enumerate() {
            wrench.add(own, -length * rule.weights[i]);
        }
    }
    wrench
}

/// What the actuator puts into a follower where it leaves the guide.
fn at_plate(setting: &Setting, state: &State, efforts: &Efforts, f: usize) -> Wrench {
    let Setting { robot, layout, .. } = setting;
    let [face, angle] = state.joints[f];
    let offset = robot.fields()[f + 1].offset(face, part(&layout.elements[0], f + 1))[0];
    let turned = so3::about_x(PI - robot.rest_angle(f + 1, 0.0)[0] - angle);
    let place: Vector3<f64> = (base_rotation(robot) * turned).column(1) * offset;
    let mut wrench = Wrench::at(&place, Vector3::x() * efforts.tension[f]);
    wrench.moment -= Vector3::x() * efforts.torque[f];
    wrench
}
