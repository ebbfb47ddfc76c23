//! Contact force between tubes, full slip and histories with friction, against closed forms and independent programs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{bundle_cases, prototype, reference, robot, stiff_tube, vector};
use cppr::Vector3;
use cppr::analysis::BundleAnalysis;
use cppr::analysis::inverse::Measured;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign, Friction, PairContact, Rubbed, Slip, SlipHistory};
use cppr::design::{BelowPlate, Outline, Profile, StiffnessTube, TubeDesign};
use cppr::solve::{Command, Drive, Freedom, Settings, Solver};
use cppr::statics::{Loads, Wrench};
use serde_json::Value;
use std::f64::consts::PI;

fn pulled(solver: &BundleSolver, travel: f64) -> BundleCommand {
    let mut command = solver.held();
    command.drives[1].translation = Drive::Motion(travel);
    command
}

fn dry(coefficient: f64) -> Friction {
    Friction { coefficient, guide: None }
}

/// A leader on a strip, and a follower that bends nothing: a rope in a guide.
fn capstan() -> Bundle {
    let leader = stiff_tube(3e-3, [1e-3, 1e-3], 1e-3, 0.0, 0.0);
    let rope = stiff_tube(0.0, [1e-13, 1e-13], 1e-3, PI, 0.0);
    Bundle::from_robot(&robot(0.15, vec![leader, rope])).unwrap()
}

fn r1() -> Bundle {
    Bundle::from_robot(&prototype("R1", 1.27, BelowPlate::Continued)).unwrap()
}

/// Three tubes in three directions, stiffness and offset changing along them, with weight.
fn three() -> Bundle {
    let tube = |offset: f64, stiffness: f64, direction: f64| {
        TubeDesign::Stiffness(StiffnessTube {
            centroid_offset: Profile::linear(offset, 0.8 * offset),
            direction: Profile::linear(direction, direction + 0.7),
            bending_y: Profile::constant(3.0 * stiffness),
            bending_z: Profile::linear(stiffness, 0.6 * stiffness),
            torsion: Profile::constant(stiffness),
            axial: None,
            mass_per_length: Profile::constant(0.01),
            centroid_offset_factor: 1.0,
        })
    };
    let tubes = vec![tube(1.5e-3, 6e-3, 0.0), tube(1.2e-3, 4e-3, 2.1), tube(0.8e-3, 2e-3, -2.1)];
    Bundle::from_robot(&robot(0.1, tubes)).unwrap()
}

fn three_bent(solver: &mut BundleSolver) -> BundleEquilibrium {
    let mut command = solver.held();
    command.drives[1].translation = Drive::Motion(1.5e-3);
    command.drives[2].translation = Drive::Motion(-1e-3);
    command.drives[2].rotation = Drive::Motion(0.4);
    command.loads = Loads::tip_force(Vector3::new(-0.1, 0.2, 0.3));
    command.loads.gravity = Some(Vector3::new(0.0, -9.81, 3.0));
    let found = solver.solve(&command);
    assert!(found.converged && found.stable);
    found
}

/// In the plane, p = −(N K + Q'), Q = −(EI_2 κ_2 + N D_2)' and N = T − ½ EI_2 κ_2², here with slopes by differences of a much finer shape.
#[test]
fn in_the_plane_contact_has_a_closed_form() {
    let (d2, ei2) = (1.5e-3, 1.2e-3);
    let follower = stiff_tube(d2, [4e-3, ei2], 1e-3, PI, 0.0);
    let bundle =
        Bundle::from_robot(&robot(0.15, vec![stiff_tube(3e-3, [8e-3, 2e-3], 2e-3, 0.0, 0.0), follower]))
            .unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let mut command = pulled(&solver, 4e-3);
    command.loads = Loads::tip_force(Vector3::new(0.0, 0.3, 0.0));
    let found = solver.solve(&command);
    let contact = solver.contact(&found, 0.15 / 200.0).unwrap();
    let shape = solver.shape(&found, 0.15 / 1000.0);
    let rows: Vec<[f64; 4]> = shape
        .iter()
        .map(|section| {
            let own = &section.tubes[1];
            let (curvature, turning) = (-own.strains[1], (own.advance - 1.0) / d2);
            let axial = own.tension - 0.5 * ei2 * curvature * curvature;
            [section.length, axial, turning, ei2 * curvature + axial * d2]
        })
        .collect();
    let slope =
        |of: &dyn Fn(usize) -> f64, i: usize| (of(i + 1) - of(i - 1)) / (rows[i + 1][0] - rows[i - 1][0]);
    let shear = |i: usize| -slope(&|i| rows[i][3], i);
    let most = contact.pairs[0].greatest();
    let mut met = 0;
    for i in (20..rows.len() - 20).step_by(50) {
        let expected = -(rows[i][1] * rows[i][2] + slope(&shear, i));
        let found = contact.pairs[0].at(shape[i].tubes[0].label).unwrap();
        let normal = shape[i].frame.column(1).dot(&found);
        assert!((normal - expected).abs() < 2e-4 * most, "{i}: {normal} for {expected}");
        assert!((found.norm() - normal.abs()).abs() < 1e-9 * most);
        met += 1;
    }
    assert!(met > 15 && most > 10.0, "{met}, {most}");
}

/// Neighbours press alike, so that nothing is left over all tubes but the loads; finer sections change nothing; the mirrored robot presses the other way.
#[test]
fn contact_balances_in_space() {
    let bundle = three();
    let mut solver = BundleSolver::new(&bundle);
    let found = three_bent(&mut solver);
    let contact = solver.contact(&found, 0.1 / 200.0).unwrap();
    let most = contact.pairs.iter().map(PairContact::greatest).fold(0.0, f64::max);
    assert_eq!(contact.pairs.len(), 2);
    assert!(most > 5.0 && contact.residual < 1e-6 * most, "{} of {most} N/m", contact.residual);
    let finer = solver.contact(&found, 0.1 / 500.0).unwrap();
    for (pair, fine) in contact.pairs.iter().zip(&finer.pairs) {
        for point in pair.points.iter().step_by(17) {
            let off = (point.force - fine.at(point.labels[0]).unwrap()).norm();
            assert!(off < 2e-5 * most, "{}: {off} of {most} N/m", point.length);
        }
    }
    let at_plate = contact.points.iter().filter(|point| point.length <= 0.0).count();
    assert_eq!(
        (at_plate, contact.points.len()),
        (2, 6),
        "plate, the pushed tube's edge, and tip, for both followers"
    );

    let mut turned = found.command().clone();
    for drive in &mut turned.drives {
        drive.rotation = Drive::Motion(drive.rotation.value() + PI);
    }
    turned.loads.wrenches[0].force = Vector3::new(-0.1, -0.2, -0.3);
    turned.loads.gravity = Some(Vector3::new(0.0, 9.81, -3.0));
    let other = solver.solve(&turned);
    let other = solver.contact(&other, 0.1 / 200.0).unwrap();
    for (pair, turned) in contact.pairs.iter().zip(&other.pairs) {
        let middle = Vector3::new(1.0, -1.0, -1.0).component_mul(&pair.at(0.05).unwrap());
        assert!((turned.at(0.05).unwrap() - middle).norm() < 1e-5 * most);
    }
}

/// Free tips, tubes curved at rest, joints on the way and jumps of stiffness.
#[test]
fn contact_balances_in_any_bundle() {
    for case in bundle_cases::cases() {
        let bundle = Bundle::new(&bundle_cases::design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let found = solver.solve(&bundle_cases::command(&case));
        let contact = solver.contact(&found, bundle.length() / 300.0).unwrap();
        let most = contact.pairs.iter().map(PairContact::greatest).fold(0.0, f64::max);
        assert!(
            most > 0.5 && contact.residual < 1e-4 * most,
            "{}: {} of {most} N/m",
            case["name"],
            contact.residual
        );
    }
}

fn force(side: &Rubbed) -> f64 {
    side.efforts[1].force
}

#[test]
fn a_rope_that_slips_everywhere_is_a_capstan() {
    let exact = reference("friction")["capstan"]["T_exact"].as_f64().unwrap();
    let bundle = capstan();
    let mut solver = BundleSolver::new(&bundle);
    let found = solver.solve(&pulled(&solver, 5e-3));
    let [loading, unloading] = solver.full_slip(&found, &dry(0.3)).unwrap();
    assert!((force(&loading) / exact - 1.0).abs() < 1e-6, "{}", force(&loading));
    // A rope that slips back: k = k₀/(1 − μ k₀ X) and θ = −ln(1 − μ k₀ L)/μ.
    let turn: f64 = 0.3 * 5.0 / 3.0;
    let back = 1e-3 / 3e-3 * (1.0 - (-turn).exp()) / (0.3 * 0.15);
    assert!((force(&unloading) / back - 1.0).abs() < 1e-6, "{}", force(&unloading));
    for (slip, side) in [(Slip::Loading, &loading), (Slip::Unloading, &unloading)] {
        let alone = solver.full_slip_of(&found, &dry(0.3), slip).unwrap();
        assert!((force(&alone) - force(side)).abs() <= 0.0, "{slip:?}");
    }
    let [one, other] = solver.full_slip(&found, &dry(0.0)).unwrap();
    let own = found.efforts[1].force;
    assert!((force(&one) / own - 1.0).abs() < 1e-9 && (force(&other) / own - 1.0).abs() < 1e-9);
}

#[test]
fn r1_slips_between_its_bounds() {
    let cases = &reference("friction")["friction_loops_R1"]["mu 0.1"];
    let case = &cases["bounds"];
    let bundle = r1();
    let mut solver = BundleSolver::new(&bundle);
    let mut met = 0;
    for (travel, name) in [(3e-3, "3"), (6e-3, "6"), (7e-3, "7")] {
        let found = solver.solve(&pulled(&solver, travel));
        let sides = solver.full_slip(&found, &dry(0.1)).unwrap();
        for (side, sign) in sides.iter().zip(["1", "-1"]) {
            let expected: Vec<f64> = serde_json::from_value(case[format!("{name}_{sign}")].clone()).unwrap();
            assert!((force(side) / expected[0] - 1.0).abs() < 1e-6, "{name} {sign}: {}", force(side));
            let tip = Vector3::new(expected[1], expected[2], 0.0) * 1e-3;
            assert!((side.equilibrium.tip - tip).norm() < 1e-8, "{name} {sign}: {}", side.equilibrium.tip);
            met += 1;
        }
    }
    assert_eq!(met, 6);
    // Pushed, the follower's edge stands above the plate, where stiffness jumps. The loop has slipped everywhere there.
    let found = solver.solve(&pulled(&solver, -6e-3));
    let [loading, _] = solver.full_slip(&found, &dry(0.1)).unwrap();
    let wanted = cases["at"]["-6"]["T_down"].as_f64().unwrap();
    assert!((force(&loading) / wanted - 1.0).abs() < 1e-5, "{} for {wanted} N", force(&loading));
}

/// The bounds of a robot of the modal solver are those of its bundle, and a guide adds 2 μ C/b, with C = EI_2 κ_2 (1 + ½ D_2 κ_2).
#[test]
fn a_guide_adds_its_friction() {
    let robot = prototype("R1", 1.27, BelowPlate::Continued);
    let mut modal = Solver::with_settings(&robot, Settings::planar()).unwrap();
    let found = modal.solve(&Command::pull(&[6e-3])).unwrap();
    let own = modal.integrated(&found).unwrap();
    let solver = own.solver();
    let [without, _] = solver.full_slip(&own.equilibrium, &dry(0.1)).unwrap();
    assert!((force(&without) - 4.775_537).abs() < 1e-6, "{}", force(&without));
    let with = Friction { coefficient: 0.1, guide: Some(0.02) };
    let [with, back] = solver.full_slip(&own.equilibrium, &with).unwrap();
    let section = &BundleSolver::new(&without.bundle).shape(&without.equilibrium, 1e-3)[0];
    let (curvature, offset) = (section.tubes[1].strains[1], section.tubes[1].centroid_offset);
    let outline = Outline::Round { outer_radius: 1.5e-3, inner_radius: 0.5e-3 };
    let bending = 5.39e9 * outline.inertia(2e-3).unwrap().inertia_z;
    let couple = (bending * curvature * (1.0 + 0.5 * offset * curvature)).abs();
    let more = force(&with) - force(&without);
    assert!((more / (2.0 * 0.1 * couple / 0.02) - 1.0).abs() < 1e-3, "{more} N for a couple of {couple} N m");
    assert!(force(&back) < force(&without) - more);
}

#[test]
fn a_rope_that_is_let_go_slips_from_the_plate_on() {
    let exact = reference("friction")["capstan"]["T_unload_exact"].as_f64().unwrap();
    let bundle = capstan();
    let mut solver = BundleSolver::new(&bundle);
    let mut history = SlipHistory::new(&mut solver, dry(0.3)).unwrap();
    for travel in [1e-3, 3e-3, 5e-3, 4.75e-3, 4.25e-3] {
        assert!(history.drive(&pulled(&solver, travel)), "{travel}");
    }
    let force = history.point().efforts[1].force;
    assert!((force / exact - 1.0).abs() < 1e-3, "{force} for {exact} N");
}

/// Forces and tips on the way up and down, and the energy of a cycle, for a friction of 0.1.
#[test]
fn r1_goes_through_its_loop() {
    let case = &reference("friction")["friction_loops_R1"]["mu 0.1"];
    let bundle = r1();
    let mut solver = BundleSolver::new(&bundle);
    let mut history = SlipHistory::new(&mut solver, dry(0.1)).unwrap();
    let (mut energy, mut met, mut last) = (0.0, 0, [0.0; 2]);
    let quarters = [7, 14, 21, 28].into_iter().chain((-28..28).rev()).chain(-27..=28).enumerate();
    for (number, quarter) in quarters {
        let travel = f64::from(quarter) * 0.25;
        assert!(history.drive(&pulled(&solver, travel * 1e-3)), "{travel}");
        let point = history.point();
        let here = [travel, point.efforts[1].force];
        if number > 3 {
            energy += 0.5 * (here[1] + last[1]) * (here[0] - last[0]);
        }
        last = here;
        let expected: &Value = &case["at"][format!("{travel}")];
        if number > 3 && expected.is_object() && travel != 0.0 {
            let way = if number < 4 + 56 { "down" } else { "up" };
            let wanted = expected[format!("T_{way}")].as_f64().unwrap();
            assert!((here[1] / wanted - 1.0).abs() < 2e-3, "{travel} {way}: {} for {wanted} N", here[1]);
            let tip = vector(&serde_json::json!([
                expected[format!("tip_{way}")][0],
                expected[format!("tip_{way}")][1],
                0.0
            ]));
            assert!((point.tip * 1e3 - tip).norm() < 0.06, "{travel} {way}: {} mm", point.tip * 1e3);
            met += 1;
        }
    }
    let wanted = case["energy_Nmm"].as_f64().unwrap();
    assert!(met == 8 && (energy / wanted - 1.0).abs() < 5e-3, "{energy} for {wanted} N mm");
}

/// In space, with slip along and around: a closed path takes energy, and full slip is reached from both sides.
#[test]
fn a_cycle_in_space_takes_energy() {
    let bundle = three();
    let mut solver = BundleSolver::new(&bundle);
    let mut history = SlipHistory::new(&mut solver, dry(0.2)).unwrap();
    let command = |solver: &BundleSolver, share: f64| {
        let mut command = solver.held();
        command.drives[1].translation = Drive::Motion(8e-4 * share);
        command.drives[2].translation = Drive::Motion(-4e-4 * share);
        command.drives[2].rotation = Drive::Motion(0.4 * share);
        command
    };
    let (mut energy, mut last) = (0.0, None::<Vec<[f64; 4]>>);
    for share in [0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.5, 1.0] {
        assert!(history.drive(&command(&solver, share)), "{share}");
        let own = history
            .point()
            .efforts
            .iter()
            .map(|e| [e.label, e.rotation, e.force, e.torque])
            .collect::<Vec<_>>();
        if let Some(last) = last {
            for (a, b) in own.iter().zip(&last) {
                energy += 0.5 * ((a[2] + b[2]) * (a[0] - b[0]) + (a[3] + b[3]) * (a[1] - b[1]));
            }
        }
        last = Some(own);
    }
    let found = solver.solve(&command(&solver, 1.0));
    let [loading, unloading] = solver.full_slip(&found, &dry(0.2)).unwrap();
    let reached = history.point().efforts[1].force;
    println!("{energy} {reached} {} {} {}", force(&loading), found.efforts[1].force, force(&unloading));
    assert!(energy > 0.0);
    assert!(force(&loading) > found.efforts[1].force && found.efforts[1].force > force(&unloading));
    assert!((reached / force(&loading) - 1.0).abs() < 0.05);
}

/// What is measured where tubes slip everywhere is explained by the force that acts, once friction is known.
#[test]
fn the_force_on_the_tip_is_sensed_through_friction() {
    let design = BundleDesign::from(prototype("R1", 1.27, BelowPlate::Continued).design());
    let bundle = Bundle::new(&design).unwrap();
    let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle), &design);
    let acting = Vector3::new(0.02, 0.15, 0.0);
    let command = pulled(&analysis.solver, 5e-3);
    let loaded = BundleCommand {
        loads: Loads { wrenches: vec![Wrench::tip_force(acting)], ..Loads::none() },
        ..command.clone()
    };
    let free = analysis.solver.solve(&loaded);
    let friction = Friction { coefficient: 0.2, guide: Some(20e-3) };
    let sides = analysis.solver.full_slip(&free, &friction).unwrap();
    for (which, side) in sides.iter().enumerate() {
        let measured = [
            Measured::Effort(2, Freedom::PushPull, side.efforts[1].force, 0.05),
            Measured::Position(side.equilibrium.tip, 5e-4),
            Measured::Direction(side.equilibrium.frame.column(0).into_owned(), 0.02),
        ];
        let blind = analysis.sense(&command, &measured, false).unwrap();
        let sensed = analysis.sense_rubbed(&blind, &command, &measured, false, &friction).unwrap();
        let sensed = sensed.map(|side| side.map(|own| own.force));
        assert!((sensed[which].unwrap() - acting).norm() < 1e-3, "{which}: {sensed:?}");
        assert!((blind.force - acting).norm() > 0.01, "friction is taken for a force: {}", blind.force);
        assert!(sensed[1 - which].is_none_or(|other| (other - acting).norm() > 0.02), "{sensed:?}");
    }
}
