//! Gaps between the tubes of any bundle: without a gap the equilibrium of an independent program, beams in closed form, virtual work, and what must be.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::bundle_cases::{cases, command, design};
use common::random_bundle::random_bundle;
use common::{seeds, stiff_tube};
use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign, Part, Shaft, TubeParts};
use cppr::clearance::{Clearance, ClearanceEquilibrium, ClearanceProblem};
use cppr::design::{
    BelowPlate, Branch, Material, NotchedTube, Outline, Profile, Softening, TeethStiffness, Torsion,
    TubeDesign,
};
use cppr::solve::{Command, Drive, Solver};
use cppr::statics::Loads;
use nalgebra::Rotation3;
use serde_json::Value;
use std::f64::consts::PI;

/// Random bundles that are tried; `CPPR_CASES` sets others.
const CASES: u64 = 12;

/// A uniform part, curved when free.
fn part(length: f64, body: TubeDesign, rest_curvature: f64) -> Part {
    Part { length, body, rest_curvature, rest_direction: 0.0 }
}

/// A round uncut tube of one bending stiffness.
fn round(length: f64, bending: f64, rest_curvature: f64) -> TubeParts {
    let body = stiff_tube(0.0, [bending, bending], 0.8 * bending, 0.0, 0.0);
    TubeParts::new(vec![part(length, body, rest_curvature)], None)
}

/// An uncut tube of a material.
fn pipe(length: f64, outer_radius: f64, inner_radius: f64, softening: Option<Softening>) -> TubeParts {
    let body = NotchedTube {
        outline: Outline::Round { outer_radius, inner_radius },
        depth: Profile::constant(0.0),
        direction: Profile::constant(0.0),
        material: Material {
            youngs_modulus: 60e9,
            poissons_ratio: 0.3,
            density: 0.0,
            allowable_strain: None,
            softening,
        },
        torsion: Torsion::SaintVenant,
        below: BelowPlate::Continued,
        centroid_offset_factor: 1.0,
        pattern: None,
        teeth: TeethStiffness::Flexible,
        contact: false,
    };
    TubeParts::new(vec![part(length, TubeDesign::Notched(body), 0.0)], None)
}

fn bundle(tubes: Vec<TubeParts>, joints: Vec<Vec<(usize, f64)>>) -> Bundle {
    Bundle::new(&BundleDesign { name: "test".into(), tubes, joints }).unwrap()
}

fn loose(
    solver: &BundleSolver,
    start: &BundleEquilibrium,
    gap: f64,
    elements: usize,
) -> Option<ClearanceEquilibrium> {
    let clearance = Clearance { elements, ..Clearance::between(vec![gap; solver.bundle().tube_count() - 1]) };
    solver.with_clearance(start, &clearance).unwrap()
}

fn solved(bundle: &Bundle, command: &BundleCommand, gap: f64, elements: usize) -> ClearanceEquilibrium {
    let mut solver = BundleSolver::new(bundle);
    let start = solver.solve(command);
    assert!(start.converged);
    loose(&solver, &start, gap, elements).unwrap()
}

fn named(name: &str) -> (Bundle, BundleCommand) {
    let case: Value = cases().into_iter().find(|case| case["name"] == name).unwrap();
    (Bundle::new(&design(&case)).unwrap(), command(&case))
}

/// Parts, joints, free tips, insertion, curved tubes, loads: tip, forces and torques are those of the bundle, which an independent program tells.
#[test]
fn without_a_gap_it_is_the_ordinary_equilibrium() {
    let mut met = 0;
    for case in cases() {
        let (name, bundle) = (&case["name"], Bundle::new(&design(&case)).unwrap());
        let mut solver = BundleSolver::new(&bundle);
        let start = solver.solve(&command(&case));
        let found = loose(&solver, &start, 0.0, 40).unwrap();
        let off = (found.tip() - start.tip).norm();
        assert!(off < 5e-9, "{name}: the tip is {off:e} m away");
        let motors = found.followers.iter().map(|own| [own.tension, own.torque]);
        let motors = std::iter::once([found.leader.force, found.leader.torque]).chain(motors);
        for ([force, torque], own) in motors.zip(&start.efforts) {
            assert!((force - own.force).abs() < 1e-6, "{name}: {force} for {} N", own.force);
            assert!((torque - own.torque).abs() < 1e-9, "{name}: {torque} for {} N m", own.torque);
        }
        met += 1;
    }
    assert_eq!(met, 9);
}

/// The same of random bundles, within the error that is told; with gaps an equilibrium is found of most of them, in which every tube stays in its gap.
#[test]
fn random_bundles_have_gaps() {
    let (mut all, mut lost, mut coarse) = (0, Vec::new(), Vec::new());
    for seed in seeds(CASES) {
        let (design, command) = random_bundle(seed);
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let start = solver.solve(&command);
        if design.tubes.len() < 2 || !start.converged || !start.stable {
            continue;
        }
        all += 1;
        let tight = loose(&solver, &start, 0.0, 40).unwrap();
        let off = (tight.tip() - start.tip).norm();
        if off > 3.0 * tight.error[0] + 1e-5 * bundle.length() {
            coarse.push((seed, off));
        }
        let Some(found) = loose(&solver, &start, 1e-3 * bundle.length(), 40) else {
            lost.push(seed);
            continue;
        };
        for pair in &found.pairs {
            let sizes = pair.offset.iter().map(|[y, z]| y.hypot(*z)).filter(|own| own.is_finite());
            assert!(sizes.fold(0.0, f64::max) <= pair.gap * (1.0 + 1e-9), "{seed}: {:?}", pair.zones);
        }
    }
    println!("{all} bundles: none found {lost:?}, coarser than said {coarse:?}");
    assert!(all > 0 && lost.len() * 4 <= all && coarse.is_empty());
}

/// Towards no gap: in proportion to it; where tubes meet a step, which takes a couple, with its root.
#[test]
fn small_gaps_lead_to_the_ordinary_equilibrium() {
    for (name, orders) in [("precurved_pair", 0.8..1.1), ("s_shape_pull", 0.3..0.7)] {
        let (bundle, command) = named(name);
        let mut solver = BundleSolver::new(&bundle);
        let start = solver.solve(&command);
        let moved =
            [0.2e-3, 0.05e-3].map(|gap| (loose(&solver, &start, gap, 80).unwrap().tip() - start.tip).norm());
        let order = (moved[0] / moved[1]).log(4.0);
        assert!(orders.contains(&order), "{name}: {moved:?}");
    }
}

/// The bundle of a robot does what the robot does, and a part that is cut in two the same.
#[test]
fn a_part_that_is_cut_is_the_same() {
    let bodies =
        [stiff_tube(3e-3, [8e-3, 1.5e-3], 2e-3, 0.0, 0.0), stiff_tube(1.5e-3, [4e-3, 0.8e-3], 1e-3, PI, 0.0)];
    let length = 0.15;
    let robot = common::robot(length, bodies.to_vec());
    let asked = Command::pull(&[5e-3]).with_loads(Loads::tip_force(Vector3::new(0.0, 0.1, 0.05)));
    let mut solver = Solver::new(&robot);
    let start = solver.solve(&asked).unwrap();
    let clearance = Clearance { elements: 60, ..Clearance::equal(&robot, 0.3e-3) };
    let known = solver.with_clearance(&start, &clearance).unwrap().unwrap();
    let of = |parts: &[f64]| {
        let tube = |body: &TubeDesign| {
            TubeParts::new(parts.iter().map(|own| part(own * length, body.clone(), 0.0)).collect(), None)
        };
        let own = bundle(bodies.iter().map(tube).collect(), vec![vec![(0, length), (1, length)]]);
        solved(&own, &BundleCommand::from(&asked), 0.3e-3, 60)
    };
    for parts in [&[1.0][..], &[0.4, 0.6]] {
        let found = of(parts);
        assert!((found.tip() - known.tip()).norm() < 5e-7, "{parts:?}: {}", found.tip() - known.tip());
        assert!((found.followers[0].tension - known.followers[0].tension).abs() < 1e-5);
        assert_eq!(found.pairs[0].zones.len(), known.pairs[0].zones.len());
    }
}

/// Turned with its loads it does the same, turned: tubes that are curved, with a joint on the way and free tips.
#[test]
fn a_turned_bundle_does_the_same() {
    let (bundle, command) = named("precurved_two_load");
    let found = solved(&bundle, &command, 0.1e-3, 40);
    let angle = 1.1;
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
    let mut other = command.clone();
    for drive in &mut other.drives {
        drive.rotation = Drive::Motion(drive.rotation.value() + angle);
    }
    for wrench in &mut other.loads.wrenches {
        (wrench.force, wrench.moment) = (turn * wrench.force, turn * wrench.moment);
    }
    let turned = solved(&bundle, &other, 0.1e-3, 40);
    assert!((turn * found.tip() - turned.tip()).norm() < 1e-8);
    assert!((found.followers[0].torque - turned.followers[0].torque).abs() < 1e-8);
    assert!(!found.pairs[0].zones.is_empty());
}

/// A tube with the curvature κ when free, in a straight and stiff one: below ½ κ L² = δ it is free; above, its tip lies on the wall with F = 3 EI/L³ (½ κ L² − δ), tilted by κ L/4 + 3 δ/(2 L).
#[test]
fn a_curved_tube_meets_the_wall_with_its_tip() {
    let (length, stiffness, gap) = (0.1, 1e-3, 0.2e-3);
    for curvature in [0.03, 0.06, 0.3] {
        let tubes = vec![round(length, 10.0, 0.0), round(length, stiffness, curvature)];
        let own = bundle(tubes, Vec::new());
        let held = BundleSolver::new(&own).held();
        let found = solved(&own, &held, gap, 40);
        let free = 0.5 * curvature * length * length;
        let (zones, offset) = (&found.pairs[0].zones, found.pairs[0].offset.last().unwrap());
        let tilt = *found.followers[0].tilt.last().unwrap();
        if free < gap {
            assert!(zones.is_empty() && (offset[0] / free - 1.0).abs() < 2e-3, "{offset:?}");
            assert!((tilt / (curvature * length) - 1.0).abs() < 2e-3, "{tilt}");
            continue;
        }
        let force = 3.0 * stiffness / length.powi(3) * (free - gap);
        assert!(zones.len() == 1 && (zones[0].force / force - 1.0).abs() < 2e-3, "{force}: {zones:?}");
        assert!((zones[0].from - length).abs() < 1e-9 && zones[0].angles[0].abs() < 1e-6, "{zones:?}");
        let known = 0.25 * curvature * length + 1.5 * gap / length;
        assert!((tilt / known - 1.0).abs() < 2e-3, "{tilt} for {known}");
    }
}

/// A longer tube that carries the moment M where a stiff one around it ends, b from the plate, lies on the rim there, tilted by 3 δ/(2 b) + M b/(4 EI).
#[test]
fn a_longer_tube_lies_on_the_rim_of_the_outer_one() {
    let (rim, length, stiffness, gap, force) = (0.06, 0.1, 4e-3, 0.2e-3, 0.02);
    let own = bundle(vec![round(rim, 50.0, 0.0), round(length, stiffness, 0.0)], Vec::new());
    let held = BundleSolver::new(&own).held();
    let command = BundleCommand { loads: Loads::tip_force(Vector3::new(0.0, 0.0, force)), ..held };
    let found = solved(&own, &command, gap, 60);
    let at = found.labels.iter().position(|own| *own > rim - 1e-9).unwrap();
    let known = 1.5 * gap / rim + force * (length - rim) * rim / (4.0 * stiffness);
    let tilt = found.followers[0].tilt[at];
    assert!((tilt / known - 1.0).abs() < 2e-3, "{tilt} for {known}");
    assert!(
        found.labels.last().unwrap() > &(length - 1e-4) && found.pairs[0].offset.last().unwrap()[0].is_nan()
    );
    // Beyond the rim it is a cantilever.
    let beam = gap + tilt * (length - rim) + force * (length - rim).powi(3) / (3.0 * stiffness);
    assert!((found.tip().z / beam - 1.0).abs() < 2e-3, "{} for {beam}", found.tip().z);
}

/// Where the tube between two has ended, the gap between these is what both gaps and its wall leave.
#[test]
fn beyond_a_tube_its_neighbours_meet() {
    let tubes = vec![round(0.1, 10.0, 0.0), round(0.04, 1.0, 0.0), round(0.1, 1e-3, 0.5)];
    let own = bundle(tubes, Vec::new());
    let held = BundleSolver::new(&own).held();
    let found = solved(&own, &held, 0.1e-3, 40);
    let pairs: Vec<(usize, usize)> = found.pairs.iter().map(|own| (own.outer, own.inner)).collect();
    assert_eq!(pairs, [(0, 1), (0, 2), (1, 2)]);
    assert!((found.pairs[1].gap - 0.2e-3).abs() < 1e-12);
    let last = found.pairs[1].offset.last().unwrap();
    assert!((last[0] - 0.2e-3).abs() < 1e-6, "{last:?}");
    assert!(found.pairs[2].offset.last().unwrap()[0].is_nan());
    // Of walls that are known.
    let tubes = vec![
        pipe(0.1, 2e-3, 1.7e-3, None),
        pipe(0.05, 1.5e-3, 1.2e-3, None),
        pipe(0.1, 1.1e-3, 0.8e-3, None),
    ];
    let design = BundleDesign { name: "pipes".into(), tubes, joints: Vec::new() };
    let gaps = Clearance::known(&design.gaps()).unwrap().gaps;
    let own = Bundle::new(&design).unwrap();
    let mut solver = BundleSolver::new(&own);
    let start = solver.solve(&solver.held());
    let found = solver.with_clearance(&start, &Clearance { elements: 20, ..Clearance::between(gaps) });
    assert!((found.unwrap().unwrap().pairs[1].gap - 0.6e-3).abs() < 1e-9);
}

/// T = dΠ/dΔa with edges, a shaft that gives way, a force that another motor holds, and a joint on the way; and a given force needs the motion that needs it.
#[test]
fn forces_are_slopes_of_the_energy() {
    for name in ["joint_on_the_way", "plain_ends_load"] {
        let case: Value = cases().into_iter().find(|case| case["name"] == name).unwrap();
        let mut design = design(&case);
        design.tubes[1].shaft = Some(Shaft { axial: 5e4, torsional: 2.0, of_material: false });
        let own = Bundle::new(&design).unwrap();
        let command = command(&case);
        let moved = |step: f64| {
            let mut other = command.clone();
            let pulled = &mut other.drives[1].translation;
            *pulled = Drive::Motion(pulled.value() + step);
            other
        };
        let step = 0.02e-3;
        let [before, found, after] = [-step, 0.0, step].map(|s| solved(&own, &moved(s), 0.1e-3, 40));
        let (slope, force) = ((after.energy - before.energy) / (2.0 * step), found.followers[0].tension);
        assert!((slope / force - 1.0).abs() < 2e-3, "{name}: {slope} for {force}");
        assert!((found.followers[0].pull + force / 5e4 - command.drives[1].translation.value()).abs() < 1e-7);
        let mut given = command.clone();
        given.drives[1].translation = Drive::Effort(force);
        let other = solved(&own, &given, 0.1e-3, 40);
        assert!((other.tip() - found.tip()).norm() < 1e-6, "{name}");
    }
}

/// Finer elements move the tip less and less, and by about as much as is told.
#[test]
fn finer_elements_change_less() {
    let (bundle, command) = named("plain_ends_load");
    let mut solver = BundleSolver::new(&bundle);
    let start = solver.solve(&command);
    let found = [40, 80, 160].map(|elements| loose(&solver, &start, 0.2e-3, elements).unwrap());
    let moved = [0, 1].map(|i| (found[i + 1].tip() - found[i].tip()).norm());
    assert!(moved[0] < 4e-5 && moved[1] < 0.6 * moved[0], "{moved:?}");
    assert!((found[1].error[0] / moved[0] - 1.0).abs() < 1e-6, "{:?} for {moved:?}", found[1].error);
}

#[test]
fn what_is_not_covered_is_refused() {
    let (own, command) = named("plain_ends_pull");
    let mut solver = BundleSolver::new(&own);
    let start = solver.solve(&command);
    let refuse = |gaps: Vec<f64>| solver.with_clearance(&start, &Clearance::between(gaps)).unwrap_err();
    assert_eq!(refuse(vec![1e-4; 2]), ClearanceProblem::Gaps { given: 2, needed: 1 });
    let branch = Branch { onset: 0.01, modulus: 1e9, unloading_onset: None };
    let softening = Some(Softening { tension: branch, compression: branch });
    let own = bundle(vec![pipe(0.05, 1e-3, 0.8e-3, softening), round(0.05, 0.01, 0.0)], Vec::new());
    let mut solver = BundleSolver::new(&own);
    let start = solver.solve(&solver.held());
    let refused = solver.with_clearance(&start, &Clearance::between(vec![1e-4])).unwrap_err();
    assert_eq!(refused, ClearanceProblem::Nonlinear { tube: 1 });
}
