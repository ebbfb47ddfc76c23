//! Derivatives of the conditions of equilibrium by parameters of the design, against dual numbers.
//!
//! `analysis::sensitivity` differences the assembled gradient of 𝓛 over robots whose parameter has moved. Here the same
//! derivative is the mixed part of a hyper-dual number: one direction in the coordinates, the other in the material fields, whose rates
//! are those of the tables.

use super::assembly::RotationMeans;
use super::check::{Case, Noise, inner, potential_loads, primal_along};
use crate::design::fields::{FieldValues, Fields};
use crate::design::{Robot, TubeDesign};
use num_dual::HyperDual64;

/// Cells of the tables.
const CELLS: u16 = 256;
/// Places of a fourth-order difference and their weights.
pub(super) const SHARES: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];

/// Σ share · field over the four robots, divided by 12 steps.
fn rate(values: [FieldValues; 4], step: f64) -> FieldValues {
    let sum = |pick: fn(&FieldValues) -> f64| {
        values.iter().zip(SHARES).map(|(v, (_, share))| share * pick(v)).sum::<f64>() / (12.0 * step)
    };
    FieldValues {
        centroid_offset: sum(|v| v.centroid_offset),
        bending_y: sum(|v| v.bending_y),
        bending_z: sum(|v| v.bending_z),
        torsion: sum(|v| v.torsion),
        axial: sum(|v| v.axial),
        mass_per_length: sum(|v| v.mass_per_length),
        direction: 0.0,
    }
}

/// Rates of all fields of a tube.
pub(super) fn rates(robots: &[Robot; 4], tube: usize, step: f64) -> Fields {
    let length = robots[0].length();
    let at = |x: f64| rate(robots.each_ref().map(|r| r.fields_at(tube, x)), step);
    let samples: Vec<FieldValues> =
        (0..=CELLS).map(|i| at(length * f64::from(i) / f64::from(CELLS))).collect();
    Fields::new(length, &samples, at(-1e-3), 0.0)
}

pub(super) type Change = fn(&mut TubeDesign, f64);

/// Name, tube (from 0) and what a parameter does to it.
pub(super) const PARAMETERS: [(&str, usize, Change); 7] = [
    ("centroid offset factor", 0, |tube, p| {
        if let TubeDesign::Stiffness(t) = tube {
            t.centroid_offset_factor += p;
        }
    }),
    ("soft bending stiffness", 1, |tube, p| {
        if let TubeDesign::Stiffness(t) = tube {
            t.bending_z = t.bending_z.scaled(1.0 + p);
        }
    }),
    ("torsional stiffness", 0, |tube, p| {
        if let TubeDesign::Stiffness(t) = tube {
            t.torsion = t.torsion.scaled(1.0 + p);
        }
    }),
    ("centroid offset", 1, |tube, p| {
        if let TubeDesign::Stiffness(t) = tube {
            t.centroid_offset = t.centroid_offset.shifted(1e-3 * p);
        }
    }),
    ("Young's modulus", 2, |tube, p| {
        if let TubeDesign::Notched(t) = tube {
            t.material.youngs_modulus *= 1.0 + p;
        }
    }),
    ("notch depth", 2, |tube, p| {
        if let TubeDesign::Notched(t) = tube {
            t.depth = t.depth.shifted(1e-3 * p);
        }
    }),
    ("density", 2, |tube, p| {
        if let TubeDesign::Notched(t) = tube {
            t.material.density *= 1.0 + p;
        }
    }),
];

#[test]
fn conditions_by_parameters_are_those_of_dual_numbers() {
    let step = 1e-3;
    for (stretch, rotation_means) in [(false, RotationMeans::Base), (true, RotationMeans::RelativeAngle)] {
        let case = Case::new(potential_loads(), stretch, true, 7);
        for (name, tube, change) in PARAMETERS {
            let robots = SHARES.map(|(at, _)| {
                let mut design = case.robot.design().clone();
                change(&mut design.tubes[tube], at * step);
                Robot::from_design(design).unwrap()
            });
            // What the sensitivity differences.
            let mut difference = vec![0.0; case.u.len()];
            for (robot, (_, share)) in robots.iter().zip(SHARES) {
                let mut moved = Case::new(potential_loads(), stretch, true, 7);
                moved.robot = robot.clone();
                for (d, g) in difference.iter_mut().zip(&moved.assemble(rotation_means, &case.u).gradient) {
                    *d += share * g / (12.0 * step);
                }
            }
            let fields: Vec<Fields> = (0..3).map(|t| rates(&robots, t, step)).collect();
            let mut noise = Noise(31);
            let mut largest = 0.0_f64;
            for _ in 0..4 {
                let v = case.direction(&mut noise);
                let u: Vec<HyperDual64> =
                    case.u.iter().zip(&v).map(|(u, v)| HyperDual64::new(*u, *v, 0.0, 0.0)).collect();
                let p = HyperDual64::new(0.0, 0.0, 1.0, 0.0);
                let exact =
                    primal_along(&case.setting(rotation_means), &case.efforts, &u, Some((&fields, p)))
                        .lagrangian;
                let (got, want) = (inner(&difference, &v), exact.eps1eps2);
                largest = largest.max(want.abs());
                assert!((got - want).abs() < 1e-9 * (want.abs() + 1e-2), "{name}: {got} {want}");
            }
            assert!(largest > 1e-6, "{name} changes nothing");
        }
    }
}
