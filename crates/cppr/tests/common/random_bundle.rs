//! Bundles of all kinds and commands for them: one for every seed, always the same.
//!
//! Sizes are those of instruments. Every part of a command is drawn by the angle through which it would bend or turn the bundle
//! by itself.

use super::Random;
use super::cases::{chance, decade, pick};
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{BundleDesign, Part, Shaft, TubeParts};
use cppr::design::{Profile, StiffnessTube};
use cppr::solve::Drive;
use cppr::statics::{Loads, Wrench};
use std::f64::consts::{PI, TAU};

/// A bundle of 1 to 5 tubes with up to 3 joints, and a command for it.
pub fn random_bundle(seed: u64) -> (BundleDesign, BundleCommand) {
    let mut random = Random::new(seed.wrapping_add(0xB00D));
    // The first numbers of neighbouring seeds are alike.
    for _ in 0..16 {
        random.next();
    }
    let random = &mut random;
    let count = [1, 2, 2, 2, 3, 3, 3, 4, 4, 5][pick(random, 10) as usize];
    let longest = decade(random, 0.03, 0.2);
    // Lengths shrink outwards, or are one.
    let one_length = chance(random, 0.4);
    let mut lengths = vec![longest; count];
    for tube in (0..count.saturating_sub(1)).rev() {
        let shorter = !one_length && chance(random, 0.6);
        lengths[tube] = lengths[tube + 1] * if shorter { random.between(0.5, 0.95) } else { 1.0 };
    }
    let modulus = decade(random, 2e9, 70e9);
    let mut outer = longest * random.between(0.01, 0.03);
    let tubes: Vec<TubeParts> = lengths
        .iter()
        .enumerate()
        .map(|(tube, &length)| {
            let inner = outer * random.between(0.7, 0.88);
            let direction = TAU * tube as f64 / count.max(2) as f64 + random.between(-0.4, 0.4);
            let parts = parts(random, length, [outer, inner], modulus, direction);
            outer = inner * random.between(0.8, 0.97);
            let shaft = chance(random, 0.15).then(|| {
                let soft = modulus * (outer * outer - inner * inner).abs() * decade(random, 1.0, 20.0);
                Shaft { axial: soft / longest, torsional: soft * outer * outer / longest, of_material: false }
            });
            TubeParts { parts, shaft }
        })
        .collect();
    let levers: Vec<f64> = tubes.iter().map(mean_lever).collect();
    let joints = joints(random, &lengths, &levers);
    let design = BundleDesign { name: format!("random {seed}"), tubes, joints };
    let command = command(random, &design);
    (design, command)
}

fn parts(random: &mut Random, length: f64, radii: [f64; 2], modulus: f64, direction: f64) -> Vec<Part> {
    let count = 1 + pick(random, 4);
    let mut ends: Vec<f64> = (1..count).map(|_| length * random.between(0.05, 0.95)).collect();
    ends.sort_by(f64::total_cmp);
    ends.push(length);
    let uncut = modulus * PI / 4.0 * (radii[0].powi(4) - radii[1].powi(4));
    let curved = chance(random, 0.25);
    let mut from = 0.0;
    let mut direction = direction;
    ends.iter()
        .map(|&to| {
            let own = to - from;
            from = to;
            let notched = chance(random, 0.7);
            if chance(random, 0.2) {
                direction += PI * random.between(0.5, 1.0);
            }
            let constant = Profile::constant;
            let body = if notched {
                let soft = decade(random, 0.02, 0.3);
                let taper = random.between(0.8, 1.25);
                let profile = |value: f64, tapered: bool| {
                    if tapered { Profile::linear(value, value * taper) } else { constant(value) }
                };
                let tapered = chance(random, 0.3);
                let turn = if chance(random, 0.15) { random.between(-PI, PI) } else { 0.0 };
                StiffnessTube {
                    centroid_offset: constant(radii[1] * random.between(0.5, 1.05)),
                    direction: Profile::linear(direction, direction + turn),
                    bending_y: profile(uncut * random.between(0.3, 0.7), tapered),
                    bending_z: profile(uncut * soft, tapered),
                    torsion: profile(uncut * soft * random.between(0.1, 0.8), tapered),
                    axial: None,
                    mass_per_length: constant(0.0),
                    centroid_offset_factor: 1.0,
                }
            } else {
                StiffnessTube {
                    centroid_offset: constant(0.0),
                    direction: constant(0.0),
                    bending_y: constant(uncut),
                    bending_z: constant(uncut),
                    torsion: constant(uncut / 1.3),
                    axial: None,
                    mass_per_length: constant(0.0),
                    centroid_offset_factor: 1.0,
                }
            };
            let bend = if curved && chance(random, 0.6) { random.between(0.1, 1.2) } else { 0.0 };
            Part {
                length: own,
                body: body.into(),
                rest_curvature: bend / length,
                rest_direction: random.between(-PI, PI),
            }
        })
        .collect()
}

/// Joints of neighbouring tubes at one distance from the plate, the outer tubes' tips first.
fn joints(random: &mut Random, lengths: &[f64], levers: &[f64]) -> Vec<Vec<(usize, f64)>> {
    let count = lengths.len();
    let mut joints: Vec<Vec<(usize, f64)>> = Vec::new();
    if count < 2 || chance(random, 0.15) {
        return joints;
    }
    let last = count - 1;
    for tube in 0..last {
        let place = lengths[tube];
        // A tube's tip is joined to those inside it that reach as far.
        if chance(random, 0.75) && !joints.iter().flatten().any(|&(_, label)| (label - place).abs() < 1e-6) {
            let first = pick(random, (tube + 1) as u32) as usize;
            let mut joint: Vec<(usize, f64)> =
                (first..=tube).filter(|&own| lengths[own] >= place).map(|own| (own, place)).collect();
            joint.extend((tube + 1..count).filter(|_| chance(random, 0.8)).map(|own| (own, place)));
            // Three tubes hold a section that bends and twists; more of them contradict one another.
            while joint.len() > 3 {
                joint.remove(pick(random, joint.len() as u32) as usize);
            }
            // Two tubes without any lever cannot be pulled against each other.
            let idle = joint.iter().filter(|own| levers[own.0] <= 0.0).count();
            if joint.len() > 1 && joints.len() < 3 && idle < 2 {
                joints.push(joint);
            }
        }
    }
    joints
}

fn command(random: &mut Random, design: &BundleDesign) -> BundleCommand {
    let length = design.tubes.iter().fold(0.0_f64, |most, tube| most.max(tube.length()));
    // What a tube's travel bends by: its own lever and that of a tube beside it.
    let levers: Vec<f64> = design.tubes.iter().map(mean_lever).collect();
    let least = levers.iter().fold(f64::INFINITY, |least, own| own.min(least));
    let inserted = if chance(random, 0.2) { length * random.between(-0.15, 0.15) } else { 0.0 };
    let turning = chance(random, 0.6);
    let drives = design
        .tubes
        .iter()
        .enumerate()
        .map(|(tube, _)| {
            let joined = design.joints.iter().flatten().any(|joint| joint.0 == tube);
            let bend = if tube > 0 && chance(random, 0.8) { random.between(-1.2, 1.2) } else { 0.0 };
            let pull =
                if joined { bend * (levers[tube] + least) } else { random.between(-0.2, 0.2) * length };
            let turn = if turning && tube > 0 { random.between(-PI, PI) * 0.7 } else { 0.0 };
            TubeDrive { translation: Drive::Motion(inserted + pull), rotation: Drive::Motion(turn) }
        })
        .collect();
    let mut loads = Loads::none();
    if chance(random, 0.3) {
        let least =
            design.tubes.iter().flat_map(|t| &t.parts).fold(f64::INFINITY, |least, part| match &part.body {
                cppr::design::TubeDesign::Stiffness(t) => least.min(t.bending_z.eval(0.0, 1.0)[0]),
                cppr::design::TubeDesign::Notched(_) => least,
            });
        let size = least / (length * length) * decade(random, 0.01, 1.0);
        loads.wrenches.push(Wrench::tip_force(random.vector(size)));
    }
    BundleCommand { drives, loads }
}

/// Mean centroid offset (m) along a tube.
fn mean_lever(tube: &TubeParts) -> f64 {
    let own = tube.parts.iter().map(|part| match &part.body {
        cppr::design::TubeDesign::Stiffness(t) => part.length * t.centroid_offset.eval(0.0, 1.0)[0],
        cppr::design::TubeDesign::Notched(_) => 0.0,
    });
    own.sum::<f64>() / tube.length()
}
