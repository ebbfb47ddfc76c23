//! `cppr continue` as a user meets it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::text;
use serde_json::Value;
use std::process::Output;

fn cppr(arguments: &[&str]) -> Output {
    common::cppr(&[&["continue"], arguments].concat())
}

#[track_caller]
fn fails(code: i32, arguments: &[&str], fragment: &str) {
    let output = cppr(arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.contains(fragment), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    assert!(output.stdout.is_empty());
}

/// The lateral snap of R3 that the book shows.
const SNAP: [&str; 10] = [
    "robots/r3.toml",
    "--along",
    "load",
    "--to",
    "2",
    "--pull",
    "-5mm",
    "--tip-force",
    "-1,0,0N",
    "--branches",
];

#[test]
fn a_snap_as_table_json_csv_and_figure() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (json, csv, svg) = (file("a.json"), file("a.csv"), file("a.svg"));
    let output = cppr(&[&SNAP[..], &["--json", &json, "--csv", &csv, "--plot", &svg]].concat());
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for part in [
        "branch point",
        "1.54215",
        "fold",
        "1.33503",
        "critical, then unstable, 1",
        "critical, then stable",
        "leaves branch 1",
        "reached the end",
    ] {
        assert!(table.contains(part), "{part} is missing in\n{table}");
    }
    let record: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!((&record["schema"], &record["schema_version"]), (&"cppr/continuation".into(), &1.into()));
    assert_eq!(record["parameter"], "load_factor");
    assert!((record["first_command"]["actuators"][0]["pull_m"].as_f64().unwrap() + 5e-3).abs() < 1e-15);
    let branches = record["branches"].as_array().unwrap();
    assert_eq!(branches.len(), 3);
    assert_eq!(branches[1]["end"], "last");
    assert_eq!(branches[1]["origin"]["branch"], 0);
    let points = |branch: &Value| branch["points"].as_array().unwrap().clone();
    let rows: usize = branches.iter().map(|b| points(b).len()).sum();
    let mut keys: Vec<_> = branches[0]["points"][0].as_object().unwrap().keys().cloned().collect();
    keys.sort_unstable();
    assert_eq!(
        keys.join(" "),
        "actuators elastic_energy_J inertia kind margin_to_instability parameter stable tip_position_m"
    );
    for point in branches.iter().flat_map(points) {
        let unstable = point["inertia"].as_u64().unwrap() > 0;
        assert_eq!(point["stable"], !unstable);
    }
    let mut reader = csv_rows(&std::fs::read_to_string(csv).unwrap());
    let header = reader.remove(0);
    assert_eq!(header[2], "parameter_load_factor");
    assert_eq!(
        header[header.len() - 4..],
        ["tube2_pull_m", "tube2_rotation_rad", "tube2_tension_N", "tube2_torque_Nm"]
    );
    assert_eq!(reader.len(), rows);
    assert!(reader.iter().all(|row| row.len() == header.len()));
    let figure = std::fs::read_to_string(svg).unwrap();
    for part in ["stable", "unstable", "fold", "branch point", "load factor", "deflection of the tip"] {
        assert!(figure.contains(part), "{part}");
    }
}

fn csv_rows(text: &str) -> Vec<Vec<String>> {
    text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
}

#[test]
fn data_on_standard_output_is_alone_there() {
    let output = cppr(&["robots/r1.toml", "--along", "pull", "--to", "-3mm", "--csv", "-"]);
    let rows = csv_rows(&text(&output.stdout));
    assert_eq!(rows[0][2], "parameter_pull_m");
    assert!((rows.last().unwrap()[2].parse::<f64>().unwrap() + 3e-3).abs() < 1e-15);
    assert!(text(&output.stderr).contains("edge of tube 2"));
}

#[test]
fn the_beginning_is_what_the_other_options_say() {
    let first = |arguments: &[&str]| {
        let output = cppr(&[arguments, &["--csv", "-"]].concat());
        csv_rows(&text(&output.stdout))[1][2].parse::<f64>().unwrap()
    };
    let pull = ["robots/r3.toml", "--along", "pull", "--to", "5mm"];
    assert!(first(&pull).abs() < 1e-15);
    assert!((first(&[&pull[..], &["--pull", "2mm"]].concat()) - 2e-3).abs() < 1e-15);
    assert!((first(&[&pull[..], &["--pull", "2mm", "--from", "-1mm"]].concat()) + 1e-3).abs() < 1e-15);
    let third = ["robots/childs3.toml", "--along", "rotate=3", "--to", "20deg", "--rotate", "3=10deg"];
    assert!((first(&third) - 10_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn what_is_wrong_is_said() {
    let r3 = "robots/r3.toml";
    for (arguments, fragment) in [
        (&["--along", "push", "--to", "5mm"][..], "write pull, rotate"),
        (&["--along", "load=2", "--to", "5", "--tip-force", "0,0,1N"], "everything at once"),
        (&["--along", "pull=1", "--to", "5mm"], "no follower"),
        (&["--along", "pull=3", "--to", "5mm"], "there is no tube 3"),
        (&["--along", "pull", "--to", "5"], "5 has no unit"),
        (&["--along", "pull", "--to", "nanmm"], "not a finite number"),
        (&["--along", "pull", "--to", "5N"], "known units here"),
        (&["--along", "pull", "--to", "200mm"], "only 150.000 mm long"),
        (&["--along", "pull", "--to", "0mm"], "nothing varies"),
        (&["--along", "tension", "--to", "5N", "--pull", "1mm"], "choose one"),
        (&["--along", "load", "--to", "5"], "there is no load"),
        (&["--along", "load", "--to", "inf", "--tip-force", "0,0,1N"], "plain number"),
        (&["--along", "command", "--to", "1"], "nothing varies"),
        (&["--along", "pull", "--to", "5mm", "--step", "0"], "write a part of the path"),
        (&["--along", "pull", "--to", "5mm", "--plot", "a.pdf"], "written as .svg or .png"),
        (&["--along", "pull", "--to", "5mm", "--json", "-", "--csv", "-"], "cannot both go"),
    ] {
        fails(2, &[&[r3], arguments].concat(), fragment);
    }
    fails(
        3,
        &[r3, "--along", "pull", "--to", "5mm", "--from", "149mm", "--tip-force", "1e6,0,0N"],
        "no equilibrium to begin with",
    );
}
