//! The robots that are shipped, and everything that a robot file can say.
#![allow(clippy::panic, clippy::unwrap_used, clippy::expect_used, reason = "a test fails by panicking")]

use cppr::bundle::Friction;
use cppr::design::{
    BelowPlate, Branch, Material, NotchedTube, Outline, Profile, Robot, Softening, StiffnessTube,
    TeethStiffness, Torsion, TubeDesign,
};
use cppr_io::{NotchPattern, RobotFile, bundle_file, robot_file, robot_text};
use std::f64::consts::PI;
use std::path::PathBuf;

const PLA: Material = Material {
    youngs_modulus: 5.39e9,
    poissons_ratio: 0.35,
    density: 1240.0,
    allowable_strain: Some(0.015),
    softening: None,
};
const PATTERN: NotchPattern = NotchPattern { length: 0.005, tooth: 0.005, count: 15 };

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name)
}

fn shipped(name: &str) -> RobotFile {
    robot_file::read(path(name)).unwrap_or_else(|problems| panic!("{problems}"))
}

fn parsed(text: &str) -> RobotFile {
    robot_file::parse(text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// A planar tube of the prototypes; lengths in mm.
fn planar(outer: f64, inner: f64, depth: Profile, direction: f64, factor: f64) -> TubeDesign {
    TubeDesign::Notched(NotchedTube {
        outline: Outline::Round { outer_radius: outer / 1e3, inner_radius: inner / 1e3 },
        depth,
        direction: Profile::constant(direction),
        pattern: Some(PATTERN),
        teeth: TeethStiffness::Flexible,
        contact: false,
        material: PLA,
        torsion: Torsion::SaintVenant,
        below: BelowPlate::Plain,
        centroid_offset_factor: factor,
    })
}

fn check_planar(file: &str, name: &str, factor: f64, radii: [f64; 4], depths: [Profile; 2]) {
    let robot = shipped(file);
    let [first, second] = depths;
    assert_eq!(robot.design.name, name);
    assert_eq!(robot.design.length.to_bits(), 0.15_f64.to_bits());
    assert_eq!(robot.centroid_offset_factor.to_bits(), factor.to_bits());
    let [ro1, ri1, ro2, ri2] = radii;
    assert_eq!(
        robot.design.tubes,
        [planar(ro1, ri1, first, 0.0, factor), planar(ro2, ri2, second, PI, factor)],
        "{file}"
    );
    for (tube, (outer, inner)) in robot.tubes.iter().zip([(ro1, ri1), (ro2, ri2)]) {
        assert_eq!((tube.outer_radius, tube.inner_radius), (Some(outer / 1e3), Some(inner / 1e3)));
        assert_eq!(tube.notches, Some(PATTERN));
    }
}

#[test]
fn the_prototypes_of_table_1() {
    let constant = |mm: f64| Profile::constant(mm / 1e3);
    let linear = |base: f64, tip: f64| Profile::linear(base / 1e3, tip / 1e3);
    check_planar("r1.toml", "R1", 1.27, [3.0, 2.0, 1.5, 0.5], [constant(5.0), constant(2.0)]);
    check_planar("r2.toml", "R2", 1.27, [5.5, 4.5, 4.0, 3.0], [constant(10.0), constant(7.0)]);
    check_planar("r3.toml", "R3", 1.32, [4.5, 3.7, 3.2, 2.4], [linear(8.2, 7.2), linear(5.6, 4.95)]);
    check_planar("r4.toml", "R4", 1.06, [4.5, 3.7, 3.2, 2.4], [linear(7.2, 8.2), linear(4.95, 5.6)]);
}

#[test]
fn every_shipped_robot_can_be_built() {
    for name in ["r1", "r2", "r3", "r4", "childs2", "childs3", "helicoid"] {
        let design = shipped(&format!("{name}.toml")).design;
        let robot = Robot::from_design(design).unwrap_or_else(|problems| panic!("{name}: {problems:?}"));
        assert_eq!(robot.is_planar(), !["childs3", "helicoid"].contains(&name), "{name}");
    }
}

/// Offset in mm, stiffness in N cm² as printed, direction in degrees.
fn given(tube: &TubeDesign, offset: f64, [ei_y, ei_z, gj]: [f64; 3], direction: f64) {
    let TubeDesign::Stiffness(StiffnessTube {
        centroid_offset,
        direction: phi,
        bending_y,
        bending_z,
        torsion,
        axial,
        mass_per_length,
        centroid_offset_factor,
    }) = tube
    else {
        panic!("{tube:?} should be a stiffness");
    };
    let close = |profile: &Profile, value: f64| {
        let [found, slope, _] = profile.eval(0.01, 0.03);
        assert!((found - value).abs() <= 1e-12 * value.abs() && slope.abs() < 1e-15, "{found} {value}");
    };
    close(centroid_offset, offset / 1e3);
    close(bending_y, ei_y * 1e-4);
    close(bending_z, ei_z * 1e-4);
    close(torsion, gj * 1e-4);
    close(phi, direction.to_radians());
    close(mass_per_length, 0.0);
    assert_eq!(*axial, None);
    assert_eq!(centroid_offset_factor.to_bits(), 1.0_f64.to_bits());
}

#[test]
fn the_robots_of_childs_and_rucker() {
    let two = shipped("childs2.toml");
    assert_eq!(two.design.length.to_bits(), 0.033_f64.to_bits());
    let [leader, follower] = two.design.tubes.as_slice() else { panic!("two tubes") };
    given(leader, 1.09, [17.83, 1.25, 1.08], 0.0);
    given(follower, 0.94, [20.7, 1.85, 1.71], 180.0);

    let three = shipped("childs3.toml");
    assert_eq!(three.design.length.to_bits(), 0.03_f64.to_bits());
    let [leader, second, third] = three.design.tubes.as_slice() else { panic!("three tubes") };
    given(leader, 1.12, [1.96, 1.78, 2.73], 0.0);
    given(second, 0.983, [1.81, 1.78, 2.78], 120.0);
    given(third, 0.764, [1.83, 1.89, 2.91], -120.0);
    assert!(three.tubes.iter().all(|tube| tube.outer_radius.is_none()));
}

#[test]
fn the_helicoid() {
    let robot = shipped("helicoid.toml");
    for (tube, phi) in robot.design.tubes.iter().zip([0.0, PI]) {
        let TubeDesign::Notched(tube) = tube else { panic!("a notched tube") };
        assert_eq!(tube.direction, Profile::linear(phi, phi + 2.0 * PI));
        assert_eq!(tube.below, BelowPlate::Continued);
        assert_eq!(tube.torsion, Torsion::Polar);
        assert!((tube.material.shear_modulus() - 1e9).abs() < 1.0);
        assert_eq!(tube.material.youngs_modulus.to_bits(), 5.39e9_f64.to_bits());
        assert_eq!(tube.centroid_offset_factor.to_bits(), 1.27_f64.to_bits());
    }
}

const HEAD: &str = "name = \"T\"\nlength_mm = 40\n[material]\nyoungs_modulus_GPa = 1\npoissons_ratio = 0.3\ndensity_kg_m3 = 0\n";

/// A robot of one tube whose notches are given.
fn leader(notches: &str) -> NotchedTube {
    let text = format!("{HEAD}[[tube]]\nouter_radius_mm = 3\ninner_radius_mm = 2\n[tube.notches]\n{notches}");
    match parsed(&text).design.tubes.remove(0) {
        TubeDesign::Notched(tube) => tube,
        TubeDesign::Stiffness(_) => panic!("a notched tube"),
    }
}

#[test]
fn allowable_strains_belong_to_the_material() {
    let tubes = "[[tube]]\nouter_radius_mm = 3\ninner_radius_mm = 2\n[[tube]]\nouter_radius_mm = 1.5\ninner_radius_mm = 1\n";
    let own = format!(
        "{HEAD}allowable_strain_percent = 2\n{tubes}[tube.material]\nallowable_strain_percent = 4\n",
    );
    let allowed = |text: &str| -> Vec<Option<f64>> {
        let tubes = parsed(text).design.tubes;
        let strain = |tube: &TubeDesign| match tube {
            TubeDesign::Notched(tube) => tube.material.allowable_strain,
            TubeDesign::Stiffness(_) => panic!("a notched tube"),
        };
        tubes.iter().map(strain).collect()
    };
    assert_eq!(allowed(&own), [Some(0.02), Some(0.04)]);
    assert_eq!(allowed(&format!("{HEAD}{tubes}")), [None, None]);
    // A strain written as a plain number is a hundred times too small.
    let slip = robot_file::parse(&own.replace("percent = 2", "percent = 0.02")).unwrap_err().to_string();
    assert!(
        slip.contains("a strain of 0.015 is 1.5 percent")
            || slip.contains("A strain of 0.015 is 1.5 percent"),
        "{slip}"
    );
}

#[test]
fn depths_per_notch_stand_at_the_middles() {
    let tube = leader("depth_mm = [1, 2, 4, 3]\nlength_mm = 4\ntooth_mm = 6\n");
    let expected = Profile::per_notch(&[0.001, 0.002, 0.004, 0.003], &[0.005, 0.015, 0.025, 0.035]);
    let expected = expected.unwrap();
    for x in [0.0, 0.005, 0.011, 0.025, 0.04] {
        let (found, wanted) = (tube.depth.eval(x, 0.04)[0], expected.eval(x, 0.04)[0]);
        assert!((found - wanted).abs() < 1e-15, "{x}: {found} {wanted}");
    }
}

#[test]
fn two_depths_are_base_and_tip_even_for_two_notches() {
    let tube = leader("depth_mm = [1, 2]\nlength_mm = 10\ntooth_mm = 10\n");
    assert_eq!(tube.depth, Profile::linear(0.001, 0.002));
}

#[test]
fn tables_over_x() {
    let tube = leader(
        "depth_mm = { x_mm = [0, 10, 40], depth_mm = [1.0, 2.0, 2.5] }\n\
         opening_deg = { x_mm = [0, 40], opening_deg = [180, 270] }\n\
         torsion = { stiffness_Nmm2 = [100, 200] }\n",
    );
    assert!((tube.depth.eval(0.01, 0.04)[0] - 0.002).abs() < 1e-15);
    assert!(tube.direction.eval(0.0, 0.04)[0].abs() < 1e-15);
    assert!((tube.direction.eval(0.04, 0.04)[0] - 0.5 * PI).abs() < 1e-15);
    assert_eq!(tube.torsion, Torsion::Given(Profile::linear(1e-4, 2e-4)));
}

#[test]
fn shapes_materials_and_factors_of_single_tubes() {
    let robot = parsed(&format!(
        "{HEAD}[calibration]\ncentroid_offset_factor = 1.2\n\
         [[tube]]\nshape = \"square\"\nouter_radius_mm = 4\ninner_radius_mm = 3\ncentroid_offset_factor = 1.1\n\
         [[tube]]\nshape = \"hexagon\"\nouter_radius_mm = 2.5\ninner_radius_mm = 0\n\
         [tube.material]\nshear_modulus_GPa = 0.5\ndensity_kg_m3 = 8000\n"
    ));
    let [TubeDesign::Notched(first), TubeDesign::Notched(second)] = robot.design.tubes.as_slice() else {
        panic!("two tubes with geometry")
    };
    assert_eq!(first.outline, Outline::Polygon { sides: 4, outer_apothem: 0.004, inner_apothem: 0.003 });
    assert_eq!(second.outline, Outline::Polygon { sides: 6, outer_apothem: 0.0025, inner_apothem: 0.0 });
    assert_eq!(
        first.material,
        Material {
            youngs_modulus: 1e9,
            poissons_ratio: 0.3,
            density: 0.0,
            allowable_strain: None,
            softening: None
        }
    );
    assert_eq!(
        second.material,
        Material {
            youngs_modulus: 1e9,
            poissons_ratio: 0.0,
            density: 8000.0,
            allowable_strain: None,
            softening: None
        }
    );
    assert_eq!(first.centroid_offset_factor.to_bits(), 1.1_f64.to_bits());
    assert_eq!(second.centroid_offset_factor.to_bits(), 1.2_f64.to_bits());
    assert_eq!((&first.depth, &first.direction), (&Profile::constant(0.0), &Profile::constant(0.0)));
}

#[test]
fn the_openings_of_a_full_turn_become_one_direction() {
    for (opening, phi) in
        [(180.0, 0.0), (0.0, PI), (360.0, PI), (-180.0, 0.0), (900.0, 0.0), (90.0, -PI / 2.0)]
    {
        let tube = leader(&format!("depth_mm = 1\nopening_deg = {opening:?}\n"));
        let found = tube.direction.eval(0.0, 0.04)[0];
        assert!((found - phi).abs() < 1e-15, "{opening}: {found}");
    }
}

#[test]
fn optional_fields_of_a_stiffness() {
    let robot = parsed(
        "name = \"T\"\nlength_mm = 40\n[[tube]]\n[tube.stiffness]\ncentroid_offset_mm = [1, 2]\n\
         bending_y_Nmm2 = 300\nbending_z_Nmm2 = { x_mm = [0, 40], bending_z_Nmm2 = [100, 50] }\n\
         torsion_Nmm2 = 100\naxial_N = 5e4\nmass_per_length_g_m = 3.5\nopening_deg = 90\ntwist_deg = -90\n",
    );
    let Some(TubeDesign::Stiffness(tube)) = robot.design.tubes.first() else { panic!("a stiffness") };
    assert_eq!(tube.centroid_offset, Profile::linear(0.001, 0.002));
    assert_eq!(tube.axial, Some(Profile::constant(5e4)));
    assert_eq!(tube.mass_per_length, Profile::constant(0.0035));
    assert_eq!(tube.direction, Profile::linear(-PI / 2.0, -PI));
    assert!((tube.bending_z.eval(0.04, 0.04)[0] - 5e-5).abs() < 1e-18);
}

#[test]
fn diameters_are_twice_the_radii() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/r1.toml")).unwrap();
    let other = text
        .replace("outer_radius_mm = 3.0", "outer_diameter_mm = 6.0")
        .replace("inner_radius_mm = 2.0", "inner_diameter_mm = 4.0")
        .replace("outer_radius_mm = 1.5", "outer_diameter_mm = 3");
    assert_eq!(other.matches("diameter").count(), 3);
    assert_eq!(parsed(&other), parsed(&text));
}

/// Every shipped robot, and one with all that a file can say, is the same after it was written and read.
#[test]
fn a_design_survives_its_text() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    // Robots of parts and joints lie in a folder of their own.
    let files = files.filter(|path| path.is_file());
    let mut designs: Vec<_> = files.map(|path| robot_file::read(path).unwrap().design).collect();
    assert!(designs.len() >= 7);
    let rich = "name = \"all \\\"that\\\" there is\"\nlength_mm = 60.1\n
        [[tube]]\nouter_diameter_mm = 5.3\ninner_diameter_mm = 4.1\nshape = \"hexagon\"\n
        [tube.material]\nyoungs_modulus_GPa = 60\nshear_modulus_GPa = 17\ndensity_kg_m3 = 6450\nallowable_strain_percent = 3.7\n
        [tube.notches]\ndepth_mm = { x_mm = [3, 31, 50], depth_mm = [1.1, 2.3, 2.2] }\ntwist_deg = 77\ntorsion = \"polar\"\nbelow_plate = \"continued\"\n
        [[tube]]\nouter_radius_mm = 1.9\ninner_radius_mm = 1.3\ncentroid_offset_factor = 1.13\n
        [tube.material]\nyoungs_modulus_GPa = 3.1\npoissons_ratio = 0.36\ndensity_kg_m3 = 1200\n
        [tube.notches]\nlength_mm = 7.1\ntooth_mm = 5\ndepth_mm = [1.3, 1.7, 1.9, 2.1]\nopening_deg = [-30, 11]\n
        torsion = { stiffness_Nmm2 = { x_mm = [0, 20, 60], stiffness_Nmm2 = [300, 410, 555] } }\ncount = 4\n
        [[tube]]\nouter_radius_mm = 0.9\ninner_radius_mm = 0\n
        [tube.material]\nyoungs_modulus_GPa = 3.1\npoissons_ratio = 0.36\ndensity_kg_m3 = 1200\n
        [[tube]]\n[tube.stiffness]\ncentroid_offset_mm = [0.2, 0.3]\nbending_y_Nmm2 = 20.7\nbending_z_Nmm2 = 9.1\n
        torsion_Nmm2 = 7.7\naxial_N = 11300\nmass_per_length_g_m = 3.3\nopening_deg = 123.4\n";
    designs.push(parsed(rich).design);
    for (number, design) in designs.into_iter().enumerate() {
        let rubs = Friction { coefficient: 0.15, guide: Some(20.1e-3) };
        let rubs = [None, Some(rubs), Some(Friction { guide: None, ..rubs })][number % 3];
        let text = robot_text::write(&design, rubs).unwrap();
        let again = parsed(&text);
        assert_eq!(again.friction, rubs);
        let again = again.design;
        assert_eq!((&again.name, again.length.to_bits()), (&design.name, design.length.to_bits()), "{text}");
        let (one, other) = (Robot::from_design(design).unwrap(), Robot::from_design(again).unwrap());
        for tube in 0..one.tube_count() {
            for i in 0..=20 {
                let x = one.length() * f64::from(i) / 20.0;
                let numbers = |robot: &Robot| {
                    let f = robot.fields_at(tube, x);
                    [
                        f.centroid_offset,
                        f.bending_y,
                        f.bending_z,
                        f.torsion,
                        f.axial,
                        f.mass_per_length,
                        f.direction,
                    ]
                };
                for (a, b) in numbers(&one).into_iter().zip(numbers(&other)) {
                    let same = (a - b).abs() <= 1e-12 * a.abs() || (a.is_nan() && b.is_nan());
                    assert!(same, "tube {tube} at {x}: {a} and {b}\n{text}");
                }
            }
            let below = |robot: &Robot| robot.fields_at(tube, -1e-3).centroid_offset;
            assert!((below(&one) - below(&other)).abs() <= 1e-12 * below(&one).abs());
        }
        let strains = |robot: &Robot| -> Vec<Option<f64>> {
            let tubes = robot.design().tubes.iter();
            tubes
                .map(|t| if let TubeDesign::Notched(t) = t { t.material.allowable_strain } else { None })
                .collect()
        };
        assert_eq!(strains(&one), strains(&other));
    }
}

/// Files of either kind say how tubes rub; what cannot be is refused with its place.
#[test]
fn friction_is_read_and_refused() {
    for file in ["r1.toml", "bundles/hybrid.toml"] {
        let text = std::fs::read_to_string(path(file)).unwrap();
        let with = |table: &str| bundle_file::parse_either(&format!("{text}\n[friction]\n{table}"));
        let own = |table: &str| with(table).unwrap().friction();
        assert_eq!(own("coefficient = 0.2"), Some(Friction { coefficient: 0.2, guide: None }));
        let guided = own("coefficient = 0\nguide_mm = 20");
        assert_eq!(guided, Some(Friction { coefficient: 0.0, guide: Some(0.02) }));
        let integrated = with("coefficient = 0.2").unwrap().integrated().0;
        assert_eq!(integrated.friction(), own("coefficient = 0.2"));
        for (table, said) in [
            ("guide_mm = 20", "friction.coefficient: this key is missing"),
            ("coefficient = -0.1", "cannot be negative"),
            ("coefficient = nan", "must be a finite number"),
            ("coefficient = 2.5", "tubes jam"),
            ("coefficient = 0.2\nguide_mm = 0", "cannot be zero"),
            ("coefficient = 0.2\nguide_gap_mm = 0.1", "friction.guide_gap_mm: this key is not known here"),
            ("mu = 0.2", "Did you mean coefficient?"),
        ] {
            let problems = with(table).unwrap_err().to_string();
            assert!(problems.contains(said) && problems.contains("line "), "{file}, {table}: {problems}");
        }
    }
    assert_eq!(shipped("r1.toml").friction, None);
}

/// What only bundles have is written too: metal that softens, one tube's or that of all, and teeth that meet.
#[test]
fn softening_and_contact_are_written() {
    for both in [false, true] {
        let mut design = shipped("r1.toml").design;
        for tube in design.tubes.iter_mut().take(1 + usize::from(both)) {
            let TubeDesign::Notched(tube) = tube else { panic!() };
            let branch = Branch { onset: 0.011, modulus: 1.7e9, unloading_onset: Some(0.004) };
            let compression = Branch { onset: 0.0125, modulus: 2.1e9, unloading_onset: None };
            tube.material.softening = Some(Softening { tension: branch, compression });
            tube.contact = true;
        }
        let text = robot_text::write(&design, None).unwrap();
        let said = robot_file::parse(&text).unwrap_err().to_string();
        assert!(said.contains("metal that softens"), "{said}");
        let again = bundle_file::parse_either(&text).unwrap().into_bundle();
        for (own, made) in again.tubes.iter().zip(&design.tubes) {
            let (TubeDesign::Notched(own), TubeDesign::Notched(made)) = (&own.parts[0].body, made) else {
                panic!()
            };
            let mut material = made.material;
            if let Some(softening) = &mut material.softening {
                // Metal that unloads from where it softened unloads as it loads.
                softening.compression.unloading_onset = Some(softening.compression.onset);
            }
            assert_eq!((own.material, own.contact), (material, made.contact), "{text}");
        }
    }
}

#[test]
fn what_no_file_can_say_is_refused() {
    let mut design = shipped("r1.toml").design;
    let TubeDesign::Notched(tube) = &mut design.tubes[1] else { panic!() };
    tube.material.youngs_modulus = 1.0;
    let said = robot_text::write(&design, None).unwrap_err().to_string();
    assert!(said.contains("less than any robot has"), "{said}");
    let TubeDesign::Notched(tube) = &mut design.tubes[1] else { panic!() };
    tube.depth = Profile::constant(0.0);
    tube.torsion = Torsion::Given(Profile::constant(1e-4));
    let said = robot_text::write(&design, None).unwrap_err().to_string();
    assert!(said.starts_with("tube 2: ") && said.contains("StiffnessTube"), "{said}");
}
