//! `teeth`, `cut`, `corner_radius_mm` and `tooth_factor` of a robot file.
#![allow(clippy::unwrap_used, clippy::panic)]

use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::{FieldValues, Outline, Robot, TubeDesign};
use cppr::statics::{Loads, Wrench};
use cppr_io::{bundle_file, robot_file, robot_text};

fn text(notches: &str) -> String {
    format!(
        "name = \"R1's leader\"\nlength_mm = 150.0\n\n[material]\nyoungs_modulus_GPa = 5.39\npoissons_ratio = 0.35\n\
         density_kg_m3 = 1240\n\n[[tube]]\nouter_radius_mm = 3.0\ninner_radius_mm = 2.0\n\n[tube.notches]\n\
         depth_mm = 5.0\n{notches}\n"
    )
}

const LENGTHS: &str = "length_mm = 5.0\ntooth_mm = 5.0\n";

fn fields(notches: &str) -> FieldValues {
    let file = robot_file::parse(&text(notches)).unwrap_or_else(|problems| panic!("{problems}"));
    Robot::from_design(file.design).unwrap().fields_at(0, 0.05)
}

#[track_caller]
fn refused(notches: &str, words: &str) {
    let problems = robot_file::parse(&text(notches)).unwrap_err().to_string();
    assert!(problems.contains(words), "{problems}");
}

#[test]
fn flexible_teeth_are_the_default_and_rigid_ones_a_bound() {
    let plain = fields(LENGTHS);
    assert_eq!(plain, fields(&format!("{LENGTHS}teeth = \"flexible\"")));
    let rigid = fields(&format!("{LENGTHS}teeth = \"rigid\""));
    for (rigid, plain) in [
        (rigid.bending_z, plain.bending_z),
        (rigid.bending_y, plain.bending_y),
        (rigid.torsion, plain.torsion),
        (rigid.axial, plain.axial),
    ] {
        assert!((rigid / plain - 2.0).abs() < 1e-12, "{rigid} {plain}");
    }
    assert!((rigid.centroid_offset - plain.centroid_offset).abs() <= 0.0);
    // Half of the length are rings.
    let ring = std::f64::consts::PI * (9.0 - 4.0) * 1e-6 * 1240.0;
    assert!((rigid.mass_per_length - 0.5 * (plain.mass_per_length + ring)).abs() < 1e-9);
}

#[test]
fn cells_make_r1_stiffer_by_half() {
    let (plain, cell) = (fields(LENGTHS), fields(&format!("{LENGTHS}teeth = \"cell\"")));
    // The ratios of an independent program: crates/cppr-cell/tests/data/cells.json.
    for (what, ratio, want) in [
        ("EI_Z", cell.bending_z / plain.bending_z, 1.5141),
        ("EI_Y", cell.bending_y / plain.bending_y, 1.3096),
        ("EA", cell.axial / plain.axial, 1.1096),
        ("D", cell.centroid_offset / plain.centroid_offset, 0.9871),
        ("GJ", cell.torsion / plain.torsion, 1.1858 / 0.67054),
    ] {
        assert!((ratio / want - 1.0).abs() < 5e-3, "{what}: {ratio} instead of {want}");
    }
}

/// Of every stiffness f of a cell, relative to the section at the notch, the teeth's δ is (ℓ + t)/f − ℓ.
#[test]
fn a_factor_on_teeth_scales_what_they_bend() {
    let cell = |factor: &str| fields(&format!("{LENGTHS}teeth = \"cell\"\n{factor}"));
    let (plain, own) = (fields(LENGTHS), cell(""));
    assert_eq!(cell("tooth_factor = 1.0"), own);
    let (none, more) = (cell("tooth_factor = 0"), cell("tooth_factor = 1.3"));
    let read: [fn(&FieldValues) -> f64; 4] = [|f| f.bending_y, |f| f.bending_z, |f| f.torsion, |f| f.axial];
    for of in read {
        let [own, none, more] = [&own, &none, &more].map(|fields| of(fields) / of(&plain));
        let delta = 10.0 / own - 5.0;
        assert!(delta > 0.1 && (none / 2.0 - 1.0).abs() < 1e-12, "{delta} {none}");
        assert!((more / (10.0 / (5.0 + 1.3 * delta)) - 1.0).abs() < 1e-12, "{more}");
    }
    assert!((more.centroid_offset - own.centroid_offset).abs() <= 0.0);
}

#[test]
fn what_cells_cannot_be_is_said_with_its_place() {
    refused("teeth = \"rigid\"", "the stiffness of teeth needs the lengths of notch and tooth");
    refused(&format!("{LENGTHS}teeth = \"stiff\""), "Known are \"flexible\", \"rigid\" and \"cell\"");
    refused(&format!("{LENGTHS}cut = \"radial\""), "needs the finite elements of a cell");
    refused(&format!("{LENGTHS}corner_radius_mm = 0.2"), "needs the finite elements of a cell");
    refused(&format!("{LENGTHS}tooth_factor = 1.2"), "needs the finite elements of a cell");
    refused(&format!("{LENGTHS}teeth = \"cell\"\ntooth_factor = -1"), "tooth_factor");
    refused(
        &format!("{LENGTHS}teeth = \"cell\"\ncut = \"radial\""),
        "needs the radius of the notch's corners",
    );
    refused(&format!("{LENGTHS}teeth = \"cell\"\ncorner_radius_mm = 3.0"), "may be up to 2.500000 mm");
}

#[test]
fn a_part_of_a_tube_has_teeth_as_a_tube_has() {
    let text = |teeth: &str| {
        text("").replace("length_mm = 150.0\n", "").replace("[tube.notches]\ndepth_mm = 5.0\n", "")
            + &format!(
                "[[tube.part]]\nlength_mm = 50.0\n\n[[tube.part]]\nlength_mm = 100.0\n\n[tube.part.notches]\n\
                 depth_mm = 5.0\n{LENGTHS}teeth = \"{teeth}\"\n"
            )
    };
    let force = 1e-6;
    let sag = |teeth: &str| {
        let design = bundle_file::parse(&text(teeth)).unwrap_or_else(|problems| panic!("{problems}"));
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let command =
            BundleCommand { loads: Loads::tip_force(Vector3::new(0.0, force, 0.0)), ..solver.held() };
        solver.solve(&command).tip.y
    };
    // The outer 100 mm are notched, F L³/(3 EI) of their own.
    let inertia = Outline::Round { outer_radius: 3e-3, inner_radius: 2e-3 }.inertia(5e-3).unwrap().inertia_z;
    let own = force * 1e-3 / (3.0 * 5.39e9 * inertia);
    let (flexible, rigid) = (sag("flexible"), sag("rigid"));
    assert!(((flexible - rigid) / (0.5 * own) - 1.0).abs() < 1e-5, "{flexible} {rigid} {own}");
}

#[test]
fn teeth_are_written_as_they_are_read() {
    for teeth in ["teeth = \"rigid\"", "teeth = \"cell\"", "teeth = \"cell\"\ntooth_factor = 1.25"] {
        let design = robot_file::parse(&text(&format!("{LENGTHS}{teeth}"))).unwrap().design;
        let written = robot_text::write(&design, None).unwrap();
        assert_eq!(robot_file::parse(&written).unwrap().design, design, "{written}");
    }
}

/// A rod of 1 mm radius, 50 mm long, of E = 40 GPa that softens at 1 % to 4 GPa.
const ROD: &str = "name = \"rod\"\nlength_mm = 50.0\n\n[material]\nyoungs_modulus_GPa = 40\npoissons_ratio = 0.33\n\
                   density_kg_m3 = 6450\nonset_strain_percent = 1.0\nsecond_modulus_GPa = 4.0\n\n\
                   [[tube]]\nouter_diameter_mm = 2.0\ninner_diameter_mm = 0.0\n";

/// The angle (rad) by which the tip of a bundle turns about Z under a moment (N m) there.
fn turned(text: &str, moment: f64) -> f64 {
    turn(&bundle_file::parse(text).unwrap_or_else(|problems| panic!("{problems}")), moment)
}

fn turn(design: &BundleDesign, moment: f64) -> f64 {
    let bundle = Bundle::new(design).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let wrenches = vec![Wrench::tip_moment(Vector3::new(0.0, 0.0, moment))];
    let loads = Loads { wrenches, ..Loads::none() };
    let found = solver.solve(&BundleCommand { loads, ..solver.held() });
    assert!(found.converged);
    found.frame[(1, 0)].atan2(found.frame[(0, 0)])
}

/// The moment (N m) of the rod bent to a curvature (1/m): E_2 I κ and (E − E_2) times what an ideally plastic one would bear.
fn moment(onset: f64, curvature: f64) -> f64 {
    let radius = 1e-3_f64;
    let elastic = (onset / curvature).min(radius);
    let root = (radius * radius - elastic * elastic).sqrt();
    let core = radius.powi(4) / 8.0 * (elastic / radius).asin()
        - elastic / 8.0 * (radius * radius - 2.0 * elastic * elastic) * root;
    let plastic = 4.0 * (curvature * core + onset * root.powi(3) / 3.0);
    4e9 * inertia() * curvature + 36e9 * plastic
}

/// Second moment of area of the rod (m⁴).
fn inertia() -> f64 {
    std::f64::consts::PI / 4.0 * 1e-3_f64.powi(4)
}

#[test]
fn a_rod_that_softens_bends_as_plasticity_says() {
    let curvature = 50.0;
    let moment = moment(0.01, curvature);
    assert!(moment < 0.6 * 40e9 * inertia() * curvature, "it hardly softens");
    let found = turned(ROD, moment);
    assert!((found / (curvature * 0.05) - 1.0).abs() < 2e-3, "{found}");
    assert!((turned(ROD, 40e9 * inertia() * 3.0) - 3.0 * 0.05).abs() < 1e-9);
}

/// Metal that unloads below where it loads: both moments are those of plasticity, and the area between their curves up to a curvature is what all fibres lose
/// between theirs, ½ (E − E_2) ∫ (|ε| − ε_u)₊² − (|ε| − ε_on)₊² dA.
#[test]
fn between_loading_and_unloading_lies_the_energy_of_the_fibres() {
    let (onsets, curvature, radius) = ([0.01, 0.004], 50.0, 1e-3);
    let text = ROD.replace("second_modulus", "unloading_onset_strain_percent = 0.4\nsecond_modulus");
    let design = bundle_file::parse(&text).unwrap();
    let lower = design.unloading().unwrap();
    assert_eq!(turned(&text, 0.01).to_bits(), turned(ROD, 0.01).to_bits(), "loading has changed");
    // ∫ M dκ = M κ − ∫ κ dM, by Simpson's rule.
    let steps = 40;
    let energies = [&design, &lower].into_iter().zip(onsets).map(|(design, onset)| {
        let most = moment(onset, curvature);
        let reached = turn(design, most) / 0.05;
        assert!((reached / curvature - 1.0).abs() < 2e-3, "{onset}: {reached}");
        let weight = |i: i32| if i == steps { 1.0 } else { f64::from(2 + i % 2 * 2) } / f64::from(3 * steps);
        let at = |i: i32| most * f64::from(i) / f64::from(steps);
        most * reached - (1..=steps).map(|i| weight(i) * most * turn(design, at(i)) / 0.05).sum::<f64>()
    });
    let energies: Vec<f64> = energies.collect();
    let fibres = 100_000;
    let beyond = |onset: f64| -> f64 {
        let width = radius / f64::from(fibres);
        let at = (0..fibres).map(|i| (f64::from(i) + 0.5) * width);
        let squares = at.map(|y| (curvature * y - onset).max(0.0).powi(2) * (radius * radius - y * y).sqrt());
        4.0 * width * squares.sum::<f64>()
    };
    let lost = 0.5 * 36e9 * (beyond(onsets[1]) - beyond(onsets[0]));
    assert!(lost > 0.3 * energies[0], "it hardly loses anything");
    assert!(((energies[0] - energies[1]) / lost - 1.0).abs() < 5e-3, "{energies:?} {lost}");
}

/// Compression unloads from the same part of its onset on, and what no metal does is refused.
#[test]
fn unloading_is_read() {
    let more = "compression_onset_strain_percent = 1.5\nunloading_onset_strain_percent = 0.4\nsecond_modulus";
    let text = ROD.replace("second_modulus", more);
    let design = bundle_file::parse(&text).unwrap();
    let TubeDesign::Notched(tube) = &design.tubes[0].parts[0].body else { panic!("it has a geometry") };
    let softening = tube.material.softening.unwrap();
    assert!((softening.compression.unloading_onset.unwrap() - 0.006).abs() < 1e-12);
    assert!(bundle_file::parse(ROD).unwrap().unloading().is_none());
    for (more, said) in [
        ("unloading_onset_strain_percent = 1.1\nsecond_modulus", "above its onset of 1.0 %"),
        ("compression_unloading_onset_strain_percent = 1.2\nsecond_modulus", "above its onset of 1.0 %"),
    ] {
        let problems = bundle_file::parse(&ROD.replace("second_modulus", more)).unwrap_err();
        assert!(problems.to_string().contains(said), "{problems}");
    }
    let alone = ROD.replace(
        "onset_strain_percent = 1.0\nsecond_modulus_GPa = 4.0",
        "unloading_onset_strain_percent = 0.4",
    );
    let problems = bundle_file::parse(&alone).unwrap_err().to_string();
    assert!(problems.contains("material.onset_strain_percent"), "{problems}");
}

/// Teeth that meet stop a wrist near the angle at which they touch, ℓ/(ρ̄ + D) a notch.
#[test]
fn teeth_that_meet_carry_load() {
    let text = |contact: bool| {
        format!(
            "name = \"wrist\"\nlength_mm = 10.0\n\n[material]\nyoungs_modulus_GPa = 40\npoissons_ratio = 0.33\n\
             density_kg_m3 = 6450\n\n[[tube]]\nouter_diameter_mm = 1.62\ninner_diameter_mm = 1.4\n\n[tube.notches]\n\
             depth_mm = 1.4\nlength_mm = 0.8\ntooth_mm = 1.2\ncontact = {contact}\n"
        )
    };
    assert!(robot_file::parse(&text(true)).is_err() && robot_file::parse(&text(false)).is_err());
    let outline = Outline::Round { outer_radius: 0.81e-3, inner_radius: 0.7e-3 };
    let section = outline.inertia(1.4e-3).unwrap();
    // The leader's notches open towards −Y, and a negative moment closes them.
    let touch = 5.0 * 0.8e-3 / (0.81e-3 + section.centroid_offset);
    let moment = -touch / 10e-3 * 40e9 * section.inertia_z;
    let near = turned(&text(true), 0.9 * moment);
    assert!((near / (-0.9 * touch) - 1.0).abs() < 1e-6, "{near} {touch}");
    let beyond = turned(&text(true), 1.1 * moment);
    assert!(beyond < -touch && beyond > -1.01 * touch, "{beyond} {touch}");
}
