//! `cppr derivatives` against what dimensions alone say.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::cppr;
use serde_json::Value;

fn by_modulus(drive: [&str; 2]) -> Value {
    let head = ["derivatives", "robots/r3.toml", "--by", "material.youngs_modulus_GPa", "--json", "-"];
    let output = cppr(&[&head[..], &drive, &["--rotate", "20deg"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

const MODULUS: f64 = 5.39;

#[test]
fn under_given_motions_efforts_follow_the_modulus_and_the_shape_does_not() {
    let answer = by_modulus(["--pull", "5mm"]);
    let (state, by) = (&answer["actuators"][0], &answer["by"][0]);
    for (i, key) in ["tension_N", "torque_Nm"].into_iter().enumerate() {
        let (effort, slope) = (state[key].as_f64().unwrap(), by["response_per_unit"][i].as_f64().unwrap());
        assert!((slope - effort / MODULUS).abs() < 1e-8 * effort.abs(), "{key}: {slope} {effort}");
    }
    for component in by["tip_twist_per_unit"].as_array().unwrap() {
        assert!(component.as_f64().unwrap().abs() < 1e-10, "{component}");
    }
}

#[test]
fn under_a_given_force_the_motion_depends_on_force_over_modulus() {
    let answer = by_modulus(["--tension", "1.5N"]);
    let by_force = |row: &Value| row[0].as_f64().unwrap();
    let slope = answer["by"][0]["response_per_unit"][0].as_f64().unwrap();
    // The torque that holds the rotation goes with the modulus too, so that only T/E counts.
    let want = -1.5 / MODULUS * by_force(&answer["response"][0]);
    assert!((slope - want).abs() < 1e-7 * want.abs(), "{slope} {want}");
    for axis in 0..6 {
        let slope = answer["by"][0]["tip_twist_per_unit"][axis].as_f64().unwrap();
        let want = -1.5 / MODULUS * by_force(&answer["tip_jacobian"][axis]);
        assert!((slope - want).abs() < 1e-7 * want.abs() + 1e-10, "{axis}: {slope} {want}");
    }
}

#[test]
fn unknown_keys_are_refused() {
    for (key, part) in [("material.modulus", "has no material.modulus"), ("name", "is a text")] {
        let output = cppr(&["derivatives", "robots/r3.toml", "--by", key]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(part), "{said}");
    }
}

fn answered(robot: &str, by: &str, drives: &[&str]) -> Value {
    let head = ["derivatives", robot, "--by", by, "--json", "-"];
    let output = cppr(&[&head[..], drives].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Two uniform tubes bend by the pull over the sum of their centroid offsets, whatever their stiffness.
#[test]
fn of_parts_by_a_centroid_offset_is_in_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("parts.toml");
    let tube = |offset: f64, opening: u32| {
        format!(
            "[[tube]]\nlength_mm = 100\nstiffness = {{ centroid_offset_mm = {offset:?}, bending_y_Nmm2 = 20000.0, \
             bending_z_Nmm2 = 10000.0, torsion_Nmm2 = 8000.0, opening_deg = {opening} }}\n"
        )
    };
    let text = format!("name = \"parts\"\n{}{}[[joint]]\ntubes = [1, 2]\n", tube(2.0, 180), tube(1.0, 0));
    std::fs::write(&file, text).unwrap();
    let robot = file.to_str().unwrap();
    let (pull, sum) = (5.0, 3.0);
    for key in ["tube1.stiffness.centroid_offset_mm", "tube2.stiffness.centroid_offset_mm"] {
        let answer = answered(robot, key, &["--pull", "5mm"]);
        let by = &answer["by"][0];
        let slopes = numbers(&by["tip_twist_per_unit"]);
        assert!(slopes[5].abs() > 0.5, "{slopes:?}");
        for (row, slope) in slopes.into_iter().enumerate() {
            // Column of the pull of tube 2, per mm.
            let of_pull = 1e-3 * numbers(&answer["tip_jacobian"][row])[2];
            let want = -pull / sum * of_pull;
            // The leader's offset also changes how long the centreline is, along which the tip lies.
            let moves = key.starts_with("tube1") && row < 2;
            assert!((slope - want).abs() < 1e-6 || moves, "{key} {row}: {slope} {want}");
        }
        assert!(by["change_on_halving"].as_f64().unwrap() < 1e-4, "{by}");
    }
}

/// A robot of one length is one of parts too: both kinds of derivatives agree on it.
#[test]
fn of_parts_agree_with_those_of_the_modes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("parts.toml");
    let text = std::fs::read_to_string("../../robots/r3.toml").unwrap();
    std::fs::write(&file, text.replace("[[tube]]", "[[tube]]\nlength_mm = 150")).unwrap();
    let keys = "material.youngs_modulus_GPa,tube2.notches.depth_mm.0";
    let drives = ["--pull", "5mm", "--rotate", "20deg", "--tip-force", "0,0,0.05N"];
    // Slopes need more modes than the pose: those of the usual ones are 2e-3 off.
    let finer = [&drives[..], &["--refine", "2"]].concat();
    let (modes, parts) =
        (answered("robots/r3.toml", keys, &finer), answered(file.to_str().unwrap(), keys, &drives));
    for (a, b) in modes["by"].as_array().unwrap().iter().zip(parts["by"].as_array().unwrap()) {
        let near = |a: &[f64], b: &[f64]| {
            let greatest = a.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            assert!(greatest > 1e-5, "{a:?}");
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-3 * greatest, "{a} {b} of {greatest}");
            }
        };
        let (of_modes, of_parts) = (numbers(&a["tip_twist_per_unit"]), numbers(&b["tip_twist_per_unit"]));
        near(&of_modes[..3], &of_parts[..3]);
        near(&of_modes[3..], &of_parts[3..]);
        // Tube 1 of a robot of parts has motors too.
        let (of_modes, of_parts) = (numbers(&a["response_per_unit"]), numbers(&b["response_per_unit"]));
        near(&of_modes[..1], &of_parts[2..3]);
        near(&of_modes[1..], &of_parts[3..]);
    }
}

#[test]
fn of_parts_are_told_in_two_blocks() {
    let robot = "robots/bundles/two_sections.toml";
    let output = cppr(&["derivatives", robot, "--pull", "2=3mm", "--by", "tube3.part2.length_mm"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(text.lines().filter(|l| l.trim_start().starts_with("by ")).count(), 3, "{text}");
    assert_eq!(text.lines().filter(|l| l.contains("tube3.part2.length_mm")).count(), 2, "{text}");
    assert!(
        text.contains("x mm") && text.contains("t4 torque N mm") && text.contains("tip moment z (N mm)"),
        "{text}"
    );
    let refused = cppr(&["derivatives", robot, "--by", "tube3.part9.length_mm"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("its list ends with"), "{said}");
}
