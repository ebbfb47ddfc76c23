//! Robots and helpers shared by the tests.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod bundle_cases;
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub mod cases;
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
pub mod random_bundle;

use cppr::Vector3;
use cppr::design::{
    BelowPlate, Material, NotchPattern, NotchedTube, Outline, Profile, Robot, RobotDesign, StiffnessTube,
    TeethStiffness, Torsion, TubeDesign,
};
use cppr::solve::{Command, Equilibrium, Settings, Solver, Status};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// Seeds of random cases: so many from 0 on, or those of `CPPR_CASES`, which is a number or a range such as 200..300.
pub fn seeds(usual: u64) -> std::ops::Range<u64> {
    let Ok(told) = std::env::var("CPPR_CASES") else { return 0..usual };
    match told.split_once("..") {
        Some((from, to)) => from.parse().unwrap()..to.parse().unwrap(),
        None => 0..told.parse().unwrap(),
    }
}

/// A file of independent reference values.
pub fn reference(name: &str) -> Value {
    let path = format!("{}/tests/data/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A uniform tube given by its stiffness (SI), its pattern turning by `turn` from base to tip.
pub fn stiff_tube(offset: f64, bending: [f64; 2], torsion: f64, direction: f64, turn: f64) -> TubeDesign {
    TubeDesign::Stiffness(StiffnessTube {
        centroid_offset: Profile::constant(offset),
        direction: Profile::linear(direction, direction + turn),
        bending_y: Profile::constant(bending[0]),
        bending_z: Profile::constant(bending[1]),
        torsion: Profile::constant(torsion),
        axial: None,
        mass_per_length: Profile::constant(0.0),
        centroid_offset_factor: 1.0,
    })
}

pub fn robot(length: f64, tubes: Vec<TubeDesign>) -> Robot {
    Robot::from_design(RobotDesign { name: "test".into(), length, tubes }).unwrap()
}

/// A robot of the bundle reference: `turn` is the helix angle of all patterns.
pub fn bundle(parameters: &Value, turn: f64) -> Robot {
    let number = |v: &Value| v.as_f64().unwrap();
    let tubes = parameters["tubes"].as_array().unwrap();
    let directions: Vec<f64> = match parameters.get("phi_rad") {
        Some(list) => list.as_array().unwrap().iter().map(number).collect(),
        None => vec![0.0, PI],
    };
    let tubes = tubes
        .iter()
        .zip(directions)
        .map(|(t, phi)| {
            let bending = [number(&t["EIY"]), number(&t["EIZ"])];
            stiff_tube(number(&t["D_m"]), bending, number(&t["GJ"]), phi, turn)
        })
        .collect();
    robot(number(&parameters["L_m"]), tubes)
}

/// Three tubes whose followers bring their uncut parts in.
pub fn three_with_edges() -> Robot {
    let mm = 1e-3;
    let tube = |radii: [f64; 2], depth: f64, direction: f64| {
        TubeDesign::Notched(NotchedTube {
            outline: Outline::Round { outer_radius: radii[0] * mm, inner_radius: radii[1] * mm },
            depth: Profile::constant(depth * mm),
            direction: Profile::constant(direction),
            material: Material {
                youngs_modulus: 5e9,
                poissons_ratio: 0.35,
                density: 1240.0,
                allowable_strain: None,
                softening: None,
            },
            torsion: Torsion::SaintVenant,
            below: BelowPlate::Plain,
            centroid_offset_factor: 1.0,
            pattern: None,
            teeth: TeethStiffness::Flexible,
            contact: false,
        })
    };
    let tubes = vec![
        tube([4.5, 3.7], 7.2, 0.0),
        tube([3.2, 2.4], 4.95, TAU / 3.0),
        tube([1.9, 1.1], 2.7, -TAU / 3.0),
    ];
    robot(0.15, tubes)
}

/// The printed prototypes of the paper's Table 1 with a centroid factor.
pub fn prototype(name: &str, factor: f64, below: BelowPlate) -> Robot {
    let mm = 1e-3;
    let (leader, follower, depths) = match name {
        "R1" => ([3.0, 2.0], [1.5, 0.5], [[5.0, 5.0], [2.0, 2.0]]),
        "R2" => ([5.5, 4.5], [4.0, 3.0], [[10.0, 10.0], [7.0, 7.0]]),
        "R3" => ([4.5, 3.7], [3.2, 2.4], [[8.2, 7.2], [5.6, 4.95]]),
        "R4" => ([4.5, 3.7], [3.2, 2.4], [[7.2, 8.2], [4.95, 5.6]]),
        _ => panic!("unknown prototype"),
    };
    let tube = |radii: [f64; 2], depth: [f64; 2], direction: f64| {
        TubeDesign::Notched(NotchedTube {
            outline: Outline::Round { outer_radius: radii[0] * mm, inner_radius: radii[1] * mm },
            depth: Profile::linear(depth[0] * mm, depth[1] * mm),
            direction: Profile::constant(direction),
            pattern: Some(NotchPattern { length: 5.0 * mm, tooth: 5.0 * mm, count: 15 }),
            teeth: TeethStiffness::Flexible,
            contact: false,
            material: Material {
                youngs_modulus: 5.39e9,
                poissons_ratio: 0.35,
                density: 1240.0,
                allowable_strain: None,
                softening: None,
            },
            torsion: Torsion::SaintVenant,
            below,
            centroid_offset_factor: factor,
        })
    };
    robot(0.15, vec![tube(leader, depths[0], 0.0), tube(follower, depths[1], PI)])
}

pub fn vector(value: &Value) -> Vector3<f64> {
    let list = value.as_array().unwrap();
    Vector3::from_iterator(list.iter().map(|v| v.as_f64().unwrap()))
}

/// A full turn, for helical patterns.
pub const HELIX: f64 = TAU;

/// Reproducible numbers in [−1, 1].
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next()) * size
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (self.next() + 1.0)
    }
}

/// Solves from rest and insists on a stable equilibrium.
pub fn converged(robot: &Robot, command: &Command, settings: &Settings) -> Equilibrium {
    let found = Solver::with_settings(robot, *settings).unwrap().solve(command).unwrap();
    assert_eq!(found.status(), Status::Converged, "{command:?}");
    found
}
