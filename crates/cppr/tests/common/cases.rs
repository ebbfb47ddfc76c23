//! Robots and commands of all kinds, as somebody may think of them: one for every seed, always the same.
//!
//! Sizes are those of instruments, from needles to endoscopes. Every part of a command is drawn by the angle through which it
//! would bend or turn the robot by itself, so that few poses fold it and none is beyond what may be meant.

use super::Random;
use cppr::Vector3;
use cppr::design::{
    BelowPlate, Material, NotchPattern, NotchedTube, Outline, Profile, Robot, RobotDesign, StiffnessTube,
    TeethStiffness, Torsion, TubeDesign,
};
use cppr::solve::{Actuator, Command, Drive};
use cppr::statics::{DistributedForce, Frame, Loads, RotationMeans, Station, Thread, Wrench};
use std::f64::consts::{PI, TAU};

/// A robot of 1 to 4 tubes and a command for it. The robot can be built and the command asked of it.
pub fn random_case(seed: u64) -> (RobotDesign, Command) {
    let mut random = Random::new(seed.wrapping_add(0x5EED));
    // The first numbers of neighbouring seeds are alike.
    for _ in 0..16 {
        random.next();
    }
    loop {
        let design = design(&mut random, seed);
        if let Ok(robot) = Robot::from_design(design.clone()) {
            return (design, command(&mut random, &robot));
        }
    }
}

/// A number below `count`, each as likely.
pub fn pick(random: &mut Random, count: u32) -> u32 {
    (random.between(0.0, f64::from(count)) as u32).min(count - 1)
}

pub fn chance(random: &mut Random, probability: f64) -> bool {
    random.between(0.0, 1.0) < probability
}

/// As likely to lie in every decade.
pub fn decade(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

fn design(random: &mut Random, seed: u64) -> RobotDesign {
    let count = [1, 2, 2, 2, 3, 3, 3, 4, 4][pick(random, 9) as usize];
    let length = decade(random, 0.015, 0.2);
    let material = Material {
        youngs_modulus: decade(random, 1e9, 70e9),
        poissons_ratio: random.between(0.1, 0.4),
        density: [0.0, 1240.0, 6450.0][pick(random, 3) as usize],
        allowable_strain: chance(random, 0.7).then(|| decade(random, 5e-3, 0.1)),
        softening: None,
    };
    let mut bore = length * random.between(0.02, 0.06);
    let mut tubes = Vec::new();
    for tube in 0..count {
        let direction = TAU * f64::from(tube) / f64::from(count.max(2)) + random.between(-0.4, 0.4);
        let outer = bore * random.between(0.75, 0.95);
        bore = outer * random.between(0.65, 0.85);
        // A leader that does not bend leaves nothing to see.
        let kind = if tube == 0 { 0 } else { pick(random, 6) };
        tubes.push(match kind {
            0..4 => notched(random, [outer, bore], direction, length, material, true),
            4 => notched(random, [outer, bore], direction, length, material, false),
            _ => stiff(random, outer, direction, length, material),
        });
    }
    RobotDesign { name: format!("case {seed}"), length, tubes }
}

/// Round where `cut` leaves the choice to a tube without notches; polygons reach beyond their flats.
fn notched(
    random: &mut Random,
    [outer, inner]: [f64; 2],
    direction: f64,
    length: f64,
    material: Material,
    cut: bool,
) -> TubeDesign {
    let sides = [0, 0, 0, 4, 6][pick(random, 5) as usize];
    let (outline, radius) = if sides == 0 {
        (Outline::Round { outer_radius: outer, inner_radius: inner }, outer)
    } else {
        let apothem = outer * (PI / f64::from(sides)).cos();
        let sides = sides as usize;
        (Outline::Polygon { sides, outer_apothem: apothem, inner_apothem: apothem * inner / outer }, apothem)
    };
    let count = 3 + pick(random, 38);
    let pitch = length / f64::from(count);
    let notch = pitch * random.between(0.3, 0.8);
    let pattern = NotchPattern { length: notch, tooth: pitch - notch, count };
    let deep = 2.0 * radius * random.between(0.5, 0.88);
    let depth = if cut { profile(random, deep, 0.12, length, &pattern) } else { Profile::constant(0.0) };
    TubeDesign::Notched(NotchedTube {
        outline,
        depth,
        direction: helix(random, direction),
        pattern: (cut && chance(random, 0.7)).then_some(pattern),
        teeth: TeethStiffness::Flexible,
        contact: false,
        material,
        torsion: match pick(random, 4) {
            0 => Torsion::Polar,
            _ => Torsion::SaintVenant,
        },
        below: if chance(random, 0.6) { BelowPlate::Plain } else { BelowPlate::Continued },
        centroid_offset_factor: if chance(random, 0.3) { random.between(1.0, 1.3) } else { 1.0 },
    })
}

fn stiff(random: &mut Random, radius: f64, direction: f64, length: f64, material: Material) -> TubeDesign {
    let whole = material.youngs_modulus * PI / 4.0 * radius.powi(4);
    let soft = whole * decade(random, 5e-3, 0.2);
    let pattern = NotchPattern { length: length / 24.0, tooth: length / 24.0, count: 12 };
    let (offset, torsion) = (radius * random.between(0.3, 0.9), soft * random.between(0.3, 3.0));
    TubeDesign::Stiffness(StiffnessTube {
        centroid_offset: profile(random, offset, 0.2, length, &pattern),
        direction: helix(random, direction),
        bending_y: Profile::constant(soft * random.between(1.0, 8.0)),
        bending_z: profile(random, soft, 0.3, length, &pattern),
        torsion: profile(random, torsion, 0.3, length, &pattern),
        axial: None,
        mass_per_length: Profile::constant(material.density * PI * radius.powi(2) / 2.0),
        centroid_offset_factor: 1.0,
    })
}

/// About `value`, away from it by up to `scatter` of it.
fn profile(random: &mut Random, value: f64, scatter: f64, length: f64, pattern: &NotchPattern) -> Profile {
    let kind = pick(random, 6);
    let mut near = || value * (1.0 + scatter * random.next());
    match kind {
        0 | 1 => Profile::constant(value),
        2 | 3 => Profile::linear(near(), near()),
        4 => {
            let places = [0.0, 0.15, 0.4, 0.65, 0.8, 1.0].map(|part| part * length);
            Profile::table(&places, &places.map(|_| near())).unwrap()
        }
        _ => {
            // Measured notches differ by less than designed ones.
            let depths: Vec<f64> = (0..pattern.count).map(|_| value + 0.1 * (near() - value)).collect();
            Profile::per_notch(&depths, &pattern.middles()).unwrap()
        }
    }
}

fn helix(random: &mut Random, direction: f64) -> Profile {
    let turn = match pick(random, 6) {
        0 => random.between(-PI, PI),
        1 => [TAU, -TAU][pick(random, 2) as usize],
        _ => 0.0,
    };
    Profile::linear(direction, direction + turn)
}

fn command(random: &mut Random, robot: &Robot) -> Command {
    let length = robot.length();
    let middle: Vec<_> = (0..robot.tube_count()).map(|tube| robot.fields_at(tube, 0.5 * length)).collect();
    let bending: f64 = middle.iter().map(|f| f.bending_z).sum();
    let torsion: f64 = middle.iter().map(|f| f.torsion).sum();
    // More than two prescribed pulls over-determine how the robot bends.
    let mut pulls = 2;
    let mut actuators = Vec::new();
    for field in &middle[1..] {
        let lever = middle[0].centroid_offset + field.centroid_offset;
        let by_force = pulls == 0 || chance(random, 0.35);
        let bend = random.between(-1.0, 1.0);
        let push_pull = if by_force {
            Drive::Effort(bend * bending / (length * lever))
        } else {
            pulls -= 1;
            Drive::Motion((bend * lever).clamp(-0.2 * length, 0.2 * length))
        };
        let turn = random.next();
        let rotation = match pick(random, 5) {
            0 | 1 => Drive::Motion(0.0),
            2 | 3 => Drive::Motion(1.5 * turn),
            _ => Drive::Effort(turn * torsion / length),
        };
        actuators.push(Actuator { push_pull, rotation });
    }
    let rotation_means = if chance(random, 0.1) { RotationMeans::RelativeAngle } else { RotationMeans::Base };
    Command { actuators, loads: loads(random, robot, bending), rotation_means }
}

/// None in half of all cases where there is something else to move the robot, and seldom more than two.
fn loads(random: &mut Random, robot: &Robot, bending: f64) -> Loads {
    let (length, mut loads) = (robot.length(), Loads::none());
    if robot.follower_count() > 0 && chance(random, 0.5) {
        return loads;
    }
    // A force that would bend the robot by about half a radian.
    let force = bending / length.powi(2);
    let any = |random: &mut Random| chance(random, 0.3);
    let frame = |random: &mut Random| if chance(random, 0.3) { Frame::Section } else { Frame::World };
    if any(random) || robot.follower_count() == 0 {
        loads.wrenches.push(Wrench {
            moment: if any(random) { random.vector(0.5 * force * length) } else { Vector3::zeros() },
            frame: frame(random),
            point: if any(random) { random.vector(0.05 * length) } else { Vector3::zeros() },
            ..Wrench::tip_force(random.vector(force))
        });
    }
    if any(random) {
        let station = Station::Label(length * random.between(0.1, 1.0));
        let frame = frame(random);
        loads.wrenches.push(Wrench { station, frame, ..Wrench::tip_force(random.vector(force)) });
    }
    if any(random) {
        let (from, to) = (random.between(0.0, 0.5) * length, random.between(0.6, 1.0) * length);
        loads.distributed.push(DistributedForce { force: random.vector(force / (to - from)), from, to });
    }
    if any(random) {
        loads.gravity = Some(random.vector(9.81));
    }
    if any(random) {
        let away = Vector3::new(random.between(-0.5, 0.5), random.between(0.6, 1.5), random.next());
        loads.threads.push(Thread {
            tension: 0.5 * force * random.between(0.0, 1.0),
            pulley: Vector3::new(length, 0.0, 0.0) + length * away,
            radius: if any(random) { 0.05 * length } else { 0.0 },
            left: any(random),
            point: Vector3::zeros(),
        });
    }
    loads
}
