//! Bundle files: what they describe, against an independent program's tips, and what is said of wrong ones.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::Robot;
use cppr::solve::{Command, Drive, Solver};
use cppr::statics::Loads;
use cppr_io::bundle_file::{self, Described};
use cppr_io::robot_file;
use serde_json::Value;
use std::fmt::Write;
use std::path::PathBuf;

fn robots() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots")
}

fn shipped(name: &str) -> String {
    std::fs::read_to_string(robots().join("bundles").join(name)).unwrap()
}

/// Solves with pulls (m), one per tube.
fn pulled(design: &BundleDesign, pulls: &[f64]) -> BundleEquilibrium {
    let bundle = Bundle::new(design).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let mut command: BundleCommand = solver.held();
    for (drive, pull) in command.drives.iter_mut().zip(pulls) {
        drive.translation = Drive::Motion(*pull);
    }
    let found = solver.solve(&command);
    assert!(found.converged && found.stable, "{}", design.name);
    found
}

#[test]
fn files_give_the_tips_of_an_independent_program() {
    let cases: Vec<Value> =
        serde_json::from_str(include_str!("../../cppr/tests/data/general_bundles.json")).unwrap();
    for (file, name, pulls) in [
        ("s_shape.toml", "s_shape_pull", &[0.0, 5e-3][..]),
        ("two_sections.toml", "two_sections", &[0.0, 3e-3, 0.0, 2e-3]),
    ] {
        let case = cases.iter().find(|c| c["name"] == name).unwrap();
        let tip: Vec<f64> =
            case["expected"]["tip_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let found = pulled(&bundle_file::parse(&shipped(file)).unwrap(), pulls);
        let off = (found.tip - Vector3::from_vec(tip)).norm();
        assert!(off < 3e-8, "{file}: the tip is off by {off:e} m");
    }
}

/// A case of the independent program as the text of a robot file.
fn text_of(case: &Value) -> String {
    let number = |v: &Value, key: &str| v[key].as_f64().unwrap_or(0.0);
    let mut text = format!("name = {}\n", case["name"]);
    if case["joints"].as_array().unwrap().is_empty() {
        text += "joint = []\n";
    }
    for tube in case["tubes"].as_array().unwrap() {
        text += "[[tube]]\n";
        let mut from = 0.0;
        for part in tube.as_array().unwrap() {
            let direction = number(part, "centroid_direction_deg");
            writeln!(text, "[[tube.part]]\nlength_mm = {}", number(part, "to_mm") - from).unwrap();
            from = number(part, "to_mm");
            text += "stiffness = { ";
            for key in ["centroid_offset_mm", "bending_y_Nmm2", "bending_z_Nmm2", "torsion_Nmm2"] {
                write!(text, "{key} = {}, ", number(part, key)).unwrap();
            }
            writeln!(text, "opening_deg = {} }}", direction - 180.0).unwrap();
            writeln!(text, "rest_curvature_1_m = {}", number(part, "rest_curvature_z_1_m")).unwrap();
            writeln!(text, "rest_direction_deg = {direction}").unwrap();
        }
    }
    for joint in case["joints"].as_array().unwrap() {
        let joint = joint.as_object().unwrap();
        let places: Vec<String> = joint.values().map(Value::to_string).collect();
        let tubes: Vec<&str> = joint.keys().map(String::as_str).collect();
        writeln!(text, "[[joint]]\ntubes = [{}]\nat_mm = [{}]", tubes.join(", "), places.join(", ")).unwrap();
    }
    text
}

#[test]
fn every_case_of_the_independent_program_can_be_written_as_a_file() {
    let cases: Vec<Value> =
        serde_json::from_str(include_str!("../../cppr/tests/data/general_bundles.json")).unwrap();
    for case in &cases {
        let design = bundle_file::parse(&text_of(case)).unwrap_or_else(|p| panic!("{}: {p}", case["name"]));
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let mut command = solver.held();
        for (drive, told) in command.drives.iter_mut().zip(case["actuators"].as_array().unwrap()) {
            drive.translation = Drive::Motion(told["abscissa_at_plate_m"].as_f64().unwrap());
            drive.rotation = Drive::Motion(told["rotation_rad"].as_f64().unwrap());
        }
        let three = |v: &Value| {
            let list: Vec<f64> = v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
            Vector3::from_vec(list)
        };
        let force = three(&case["tip_force_N"]);
        if force.norm() > 0.0 {
            command.loads = Loads::tip_force(force);
        }
        let found = solver.solve(&command);
        let off = (found.tip - three(&case["expected"]["tip_m"])).norm();
        assert!(found.converged && off < 2e-7 * bundle.length(), "{}: off by {off:e} m", case["name"]);
    }
    assert_eq!(cases.len(), 9);
}

#[test]
fn uncut_ends_are_parts() {
    let found = pulled(&bundle_file::parse(&shipped("uncut_ends.toml")).unwrap(), &[0.0, 2e-3]);
    let off = (found.tip * 1e3 - Vector3::new(88.599, -50.173, 0.0)).norm();
    assert!(off < 1e-3, "the tip is at {} mm", found.tip * 1e3);
    assert!((found.efforts[1].force - 1.8538).abs() < 1e-4, "{} N", found.efforts[1].force);
}

#[test]
fn a_robot_file_means_the_same_as_a_bundle() {
    for name in ["r1.toml", "r3.toml", "childs2.toml"] {
        let path = robots().join(name);
        assert!(matches!(bundle_file::read(&path).unwrap(), Described::Robot(_)), "{name}");
        let robot = Robot::from_design(robot_file::read(&path).unwrap().design).unwrap();
        let modal = Solver::new(&robot).solve(&Command::pull(&[2e-3])).unwrap().tip().centre;
        let found = pulled(&cppr_io::read_bundle(&path).unwrap(), &[0.0, 2e-3]);
        // The default modes hold the tip within 1e-4 of the length.
        assert!((found.tip - modal).norm() < 1e-4 * robot.length(), "{name}: {} {modal}", found.tip);
    }
}

#[test]
fn every_shipped_bundle_is_sound_and_no_ordinary_robot() {
    let mut seen = 0;
    for entry in std::fs::read_dir(robots().join("bundles")).unwrap() {
        let path = entry.unwrap().path();
        let Described::Bundle { design, .. } = bundle_file::read(&path).unwrap_or_else(|p| panic!("{p}"))
        else {
            panic!("{} is an ordinary robot", path.display())
        };
        Bundle::new(&design).unwrap();
        let refused = robot_file::read(&path).unwrap_err();
        assert_eq!(refused.list.len(), 1);
        assert!(refused.to_string().contains("`cppr solve`, `check`, `sweep`"), "{refused}");
        seen += 1;
    }
    assert_eq!(seen, 6);
}

#[test]
fn a_shaft_has_the_stiffness_of_its_section_or_the_given_one() {
    let text = shipped("hybrid.toml");
    let shaft = bundle_file::parse(&text).unwrap().tubes[2].shaft.unwrap();
    let (area, polar) = (0.5_f64.powi(2) - 0.35_f64.powi(2), 0.5_f64.powi(4) - 0.35_f64.powi(4));
    let axial = 60e9 * std::f64::consts::PI * area * 1e-6 / 0.3;
    let torsional = 60e9 / 2.6 * std::f64::consts::FRAC_PI_2 * polar * 1e-12 / 0.3;
    assert!((shaft.axial / axial - 1.0).abs() < 1e-9, "{} {axial}", shaft.axial);
    assert!((shaft.torsional / torsional - 1.0).abs() < 1e-6, "{} {torsional}", shaft.torsional);
    let given = text.replace("length_mm = 300", "axial_N_mm = 2.0\ntorsional_Nmm_deg = 3.0");
    let shaft = bundle_file::parse(&given).unwrap().tubes[2].shaft.unwrap();
    assert!((shaft.axial - 2e3).abs() < 1e-9);
    assert!((shaft.torsional - 3e-3_f64 / 1_f64.to_radians()).abs() < 1e-12);
}

/// The problems of a shipped file with one text changed.
#[track_caller]
fn expect(file: &str, from: &str, to: &str, fragments: &[&str]) {
    let text = shipped(file);
    assert!(text.contains(from), "{file} has no {from}");
    let said = bundle_file::parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
    for fragment in fragments {
        assert!(said.contains(fragment), "{fragment} is missing in\n{said}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let two = "two_sections.toml";
    expect(two, "tubes = [3, 4]", "tubes = [3, 5]", &["there is no tube 5", "^"]);
    expect(two, "tubes = [3, 4]", "tubes = [3, 3]", &["tube 3 is named twice"]);
    expect(two, "tubes = [3, 4]", "tubes = [3]", &["two or more tubes"]);
    expect(two, "tubes = [3, 4]", "tubes = [3, 4]\nat_mm = [60]", &["1 labels stand for 2 tubes"]);
    expect(two, "tubes = [3, 4]", "tubes = [3, 4]\nat_mm = [130, 120]", &["beyond the tip of tube 3"]);
    expect(two, "tubes = [3, 4]", "tubes = [1, 4]", &["joint 1 bonds tube 1 there already"]);
    expect(two, "length_mm = 50", "length_mm = 0", &["this part has no length", "below the plate"]);
    expect(two, "length_mm = 60\n", "", &["this tube has no length"]);
    let ends = "uncut_ends.toml";
    expect(
        ends,
        "[[tube.part]]\nlength_mm = 30",
        "notches = { depth_mm = 1.6 }\n[[tube.part]]\nlength_mm = 30",
        &["belongs to one of them", "[tube.part.notches]"],
    );
    expect(ends, "length_mm = 5\n", "length_mm = 6\n", &["116.0, 115.0", "[[joint]]"]);
    expect(ends, "length_mm = 5", "length_mm = 5\nrest_direction_deg = 90", &["without a curvature"]);
    expect(ends, "length_mm = 5", "length_mm = 5\nrest_curvature_1_mm = 0.01", &["rest_curvature_1_m = 10"]);
    expect(ends, "outer_radius_mm = 1.0\n", "", &["outer_radius_mm"]);
    expect(ends, "name =", "joint = 3\nname =", &["[[joint]]"]);
    expect("hybrid.toml", "length_mm = 300", "axial_N_mm = 2.0", &["torsional_Nmm_deg"]);
    expect(
        "hybrid.toml",
        "length_mm = 300",
        "length_mm = 300\naxial_N_mm = 2.0",
        &["a stiffness is given too"],
    );
}

/// A step makes a bundle of tubes of one length, of a tube alone too; a depth that changes slowly leaves them as they are.
#[test]
fn sudden_changes_are_told_apart() {
    let r1 = std::fs::read_to_string(robots().join("r1.toml")).unwrap();
    let (leader, _) = r1.split_once("[[tube]] # the follower").unwrap();
    let step = "depth_mm = { x_mm = [0, 60, 60.1, 150], depth_mm = [3, 3, 5, 5] }";
    for (text, tubes) in [(r1.as_str(), 2), (leader, 1)] {
        let read = |depth: &str| {
            bundle_file::parse_either(&text.replacen("depth_mm = 5.0", depth, 1)).unwrap().integrated()
        };
        let (Described::Bundle { design, .. }, Some(places)) = read(step) else { panic!("{tubes} tubes") };
        assert!(places.starts_with("notch depth of tube 1 at 60.") && !places.contains("tube 2"), "{places}");
        assert_eq!((design.tubes.len(), design.joints.len()), (tubes, tubes - 1));
        Bundle::new(&design).unwrap();
        assert!(matches!(read("depth_mm = [5.0, 4.0]"), (Described::Robot(_), None)));
    }
    let parts = bundle_file::parse_either(&shipped("uncut_ends.toml")).unwrap();
    assert!(matches!(parts.integrated(), (Described::Bundle { .. }, None)));
}
