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
