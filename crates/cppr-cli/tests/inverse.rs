//! `cppr reach`, `cppr match` and `cppr sense` as a user meets them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, refused, text};
use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    let output = cppr(&[arguments, &["--json", "-"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn what_reach_answers_leads_there() {
    let bounds = ["--pull-bounds", "-7..7mm", "--rotate-bounds", "-90..90deg"];
    let answer =
        json(&[&["reach", "robots/r1.toml", "--position", "128,-58.3,-12.8mm"], &bounds[..]].concat());
    assert_eq!(answer["reached"], true);
    let value = |i: usize| answer["inputs"][i]["value"].as_f64().unwrap();
    let (pull, turn) = (format!("{}m", value(0)), format!("{}rad", value(1)));
    let solved = json(&["solve", "robots/r1.toml", "--pull", &pull, "--rotate", &turn]);
    for axis in 0..3 {
        let there = solved["tip_position_m"][axis].as_f64().unwrap();
        assert!((there - answer["tip_position_m"][axis].as_f64().unwrap()).abs() < 1e-9);
        assert!((there - [0.128, -0.0583, -0.0128][axis]).abs() < 1e-4);
    }
    let far = json(&[&["reach", "robots/r1.toml", "--position", "10,300,0mm"], &bounds[..]].concat());
    assert_eq!(far["reached"], false);
    assert!(far["distance_m"].as_f64().unwrap() > 0.15);
    assert_eq!(far["inputs"][0]["at_bound"], true);
}

#[test]
fn a_given_actuator_keeps_its_value() {
    let arguments = [
        "reach",
        "robots/r4.toml",
        "--direction",
        "0.7,0.7,0",
        "--rotate",
        "0deg",
        "--pull-bounds",
        "-6..6mm",
    ];
    let answer = json(&arguments);
    assert_eq!(answer["inputs"].as_array().unwrap().len(), 1);
    assert!(answer["angle_rad"].as_f64().unwrap() < 1e-6);
    refused(
        &[&arguments[..], &["--rotate-bounds", "0..5deg"]].concat(),
        "one that is given a value keeps it",
    );
    let all = ["reach", "robots/r1.toml", "--position", "1,2,3mm", "--pull", "1mm", "--rotate", "0deg"];
    refused(&all, "every actuator is given");
}

#[test]
fn the_shape_of_the_example_has_its_actuation_inside_the_intervals() {
    let answer = json(&["match", "robots/r3.toml", "--points", "examples/shapes/r3.csv"]);
    for (i, want) in [6e-3, 25.0_f64.to_radians()].into_iter().enumerate() {
        let input = &answer["inputs"][i];
        let (value, deviation) =
            (input["value"].as_f64().unwrap(), input["standard_deviation"].as_f64().unwrap());
        assert!((value - want).abs() < 1.96 * deviation, "{input}");
    }
}

#[test]
fn a_sensed_force_is_the_one_that_acts() {
    let loaded = json(&["solve", "robots/r1.toml", "--pull", "5mm", "--tip-force", "0,0.1,0.05N"]);
    let tension = format!("{}N", loaded["actuators"][0]["tension_N"]);
    let position = loaded["tip_position_m"].as_array().unwrap();
    let place: Vec<String> = position.iter().map(|v| format!("{}m", v.as_f64().unwrap())).collect();
    let answer = json(&[
        "sense",
        "robots/r1.toml",
        "--pull",
        "5mm",
        "--measured-tension",
        &tension,
        "--measured-position",
        &place.join(","),
    ]);
    for (axis, want) in [0.0, 0.1, 0.05].into_iter().enumerate() {
        assert!((answer["force_N"][axis].as_f64().unwrap() - want).abs() < 1e-6, "{answer}");
    }
    let table = text(&cppr(&["sense", "robots/r1.toml", "--pull", "5mm", "--measured-tension", "4N"]).stdout);
    assert!(table.contains("not seen") && table.contains("seen "), "{table}");
    assert!(!table.contains("not explained"), "{table}");
    // No force holds R1 with half a kilonewton.
    let table =
        text(&cppr(&["sense", "robots/r1.toml", "--pull", "5mm", "--measured-tension", "500N"]).stdout);
    assert!(table.contains("not explained     the measured tension of tube 2 is off by"), "{table}");
}

#[test]
fn wrong_questions_are_refused() {
    refused(&["reach", "robots/r1.toml"], "say where to");
    refused(&["reach", "robots/r1.toml", "--direction", "0,0,0"], "points nowhere");
    refused(&["reach", "robots/r1.toml", "--position", "1,2,3"], "no unit");
    refused(&["reach", "robots/r1.toml", "--position", "1,2,3mm", "--pull-accuracy", "0mm"], "above 0");
    refused(
        &["reach", "robots/r1.toml", "--position", "1,2,3mm", "--pull-bounds", "5..1mm"],
        "smaller value first",
    );
    refused(
        &["reach", "robots/r1.toml", "--position", "1,2,3mm", "--pull-bounds", "3=1..2mm"],
        "tube 3 has no such",
    );
    refused(&["reach", "robots/r1.toml", "--position", "1,2,3mm", "--tension", "20N"], "no bounds follow");
    refused(
        &["match", "robots/r1.toml", "--points", "robots/r1.toml"],
        "robots/r1.toml: line 6: the column name",
    );
    refused(&["match", "robots/r1.toml", "--points", "no/such.csv"], "cannot be read");
    refused(&["sense", "robots/r1.toml"], "say what was measured");
    refused(&["sense", "robots/r1.toml", "--tension", "1N", "--measured-tension", "1N"], "is prescribed");
    let deviation = ["--measured-tension", "1N", "--tension-deviation", "0N"];
    refused(&[&["sense", "robots/r1.toml"], &deviation[..]].concat(), "deviation is not positive");
}
