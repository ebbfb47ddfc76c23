//! Robots that people bring, and what went wrong with them once.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{cppr, json, refused, text};
use serde_json::Value;
use std::f64::consts::PI;

const COAXIAL: &str = "crates/cppr-cli/tests/data/coaxial.toml";
const HELICAL: &str = "crates/cppr-cli/tests/data/push_force_helical.toml";

fn solved(robot: &str, options: &str) -> Value {
    let options: Vec<&str> = options.split(' ').collect();
    json(&[&["solve", robot, "--samples", "2", "--json", "-"], &options[..]].concat())
}

fn number(result: &Value, key: &str) -> f64 {
    result["actuators"][0][key].as_f64().unwrap()
}

#[track_caller]
fn near(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance * want.abs(), "{got} {want}");
}

/// Two uncut tubes on one axis: shafts in series, by closed forms.
#[test]
fn tubes_without_notches_twist_and_stretch() {
    let (length, young) = (0.1, 5e9);
    let shear = young / 2.6;
    let polar = |outer: f64, inner: f64| PI / 2.0 * (outer.powi(4) - inner.powi(4));
    let twist = 1.0 / (length / (shear * polar(3e-3, 2e-3)) + length / (shear * polar(1.5e-3, 0.5e-3)));
    let turned = solved(COAXIAL, "--rotate 30deg");
    near(number(&turned, "torque_Nm"), twist * 30_f64.to_radians(), 1e-9);
    let tip: Vec<f64> =
        turned["tip_position_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!((tip[0] - length).abs() < 1e-12 && tip[1].abs() < 1e-12 && tip[2].abs() < 1e-12, "{tip:?}");
    near(number(&solved(COAXIAL, "--torque 10Nmm"), "rotation_rad"), 10e-3 / twist, 1e-9);

    refused(&["solve", COAXIAL, "--pull", "0.1mm"], "tube 2 cannot be pulled or pushed");
    let area = |outer: f64, inner: f64| PI * (outer.powi(2) - inner.powi(2));
    let stretch = 1.0 / (length / (young * area(3e-3, 2e-3)) + length / (young * area(1.5e-3, 0.5e-3)));
    near(number(&solved(COAXIAL, "--pull 0.1mm --stretch"), "tension_N"), stretch * 1e-4, 1e-2);

    let away = cppr(&["reach", COAXIAL, "--position", "90,1,1mm"]);
    assert_eq!(away.status.code(), Some(0), "{}", text(&away.stderr));
    let demand = cppr(&["solve", COAXIAL, "--pull", "0.1mm", "--tip-force", "0,1e6,0N"]);
    assert!(!text(&demand.stderr).contains("e-30"), "{}", text(&demand.stderr));
}

/// A push by force finds what the push by that motion finds.
#[test]
fn followers_with_a_helix_are_pushed_by_force() {
    let by_motion = solved(HELICAL, "--pull -0.5mm --refine 2");
    near(number(&by_motion, "tension_N"), -1.7308, 2e-4);
    for force in [-0.2, -1.0, -1.73] {
        let by_force = solved(HELICAL, &format!("--tension {force}N --refine 2"));
        assert_eq!(by_force["status"], "converged", "{force} N");
        let again = solved(HELICAL, &format!("--pull {}m --refine 2", number(&by_force, "pull_m")));
        near(number(&again, "tension_N"), force, 1e-6);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.csv");
    let output = cppr(&["sweep", HELICAL, "--tension", "-2..0N:9", "--output", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(path).unwrap();
    assert_eq!(
        table.lines().filter(|line| line.contains("converged") && !line.contains("not")).count(),
        9,
        "{table}"
    );
}

#[test]
fn what_is_not_found_is_not_said_to_fold() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("four.toml");
    let tube = |opening: f64| {
        format!(
            "[[tube]]\n[tube.stiffness]\ncentroid_offset_mm = 1.0\nbending_y_Nmm2 = 400\nbending_z_Nmm2 = 100\n\
             torsion_Nmm2 = 100\nopening_deg = {opening}\n"
        )
    };
    let robot =
        ["name = \"four\"\nlength_mm = 100\n".to_string(), tube(180.0), tube(60.0), tube(-60.0), tube(0.0)];
    std::fs::write(&file, robot.concat()).unwrap();
    let pulls = ["--pull", "2=1mm", "--pull", "3=1mm", "--pull", "4=-1mm"];
    let output = cppr(&[&["solve", file.to_str().unwrap()], &pulls[..]].concat());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(
        message.contains("over-determined: without stretch the pulls of tubes 2, 3, 4 depend"),
        "{message}"
    );
    assert!(!message.contains("collapses"), "{message}");
}

#[test]
fn notches_that_end_before_the_tip_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.toml");
    let r1 = std::fs::read_to_string(common::root().join("robots/r1.toml")).unwrap();
    std::fs::write(&file, r1.replacen("tooth_mm = 5.0", "tooth_mm = 5.0\ncount = 6", 1)).unwrap();
    let told = "the notches of tube 1 end at 60 mm, but it bends as if notched up to the tip";
    for arguments in [vec!["check"], vec!["solve", "--pull", "2mm"]] {
        let output = cppr(&[&arguments[..1], &[file.to_str().unwrap()], &arguments[1..]].concat());
        assert!(text(&output.stdout).contains(told), "{}", text(&output.stdout));
        let whole = cppr(&[&arguments[..1], &["robots/r1.toml"], &arguments[1..]].concat());
        assert!(!text(&whole.stdout).contains("notched up to the tip"));
    }
    let section = text(&cppr(&["section", "robots/r1.toml"]).stdout);
    assert!(section.contains("the teeth of 5 mm count as notched"), "{section}");
}

/// Every answer has its discretisation error: more modes are taken where they are needed, and where they do not suffice the
/// tip that needs none is told. The right tip of the robot with steps is an independent program's, whose fields have the steps as steps.
#[test]
fn answers_say_how_accurate_they_are() {
    let part = |result: &Value| result["accuracy"]["tip_of_length"].as_f64().unwrap();
    let smooth = solved("robots/r3.toml", "--pull 5mm");
    assert!(part(&smooth) < 1e-6, "{smooth}");
    assert_eq!(smooth["accuracy"]["against"], "integration");

    // No number of modes reaches what rounding leaves.
    let least = ["solve", "robots/r3.toml", "--pull", "5mm", "--accuracy", "1e-14"];
    let table = text(&cppr(&least).stdout);
    for words in
        ["; 4 times as many modes as usual", "of the length only, not 1e-14", "(--integrate) its tip is at"]
    {
        assert!(table.contains(words), "{table}");
    }
    assert_ne!(solved("robots/r3.toml", "--pull 5mm --accuracy 1e-14")["resolution"], smooth["resolution"]);

    // Modes do not follow steps: the robot is integrated, unless modes are chosen, which stay.
    let steps = "crates/cppr-cli/tests/data/steps_in_a_table.toml";
    let shown = cppr(&["solve", steps, "--pull", "2mm"]);
    assert_eq!(shown.status.code(), Some(0));
    assert!(text(&shown.stderr).contains("notch depth of tube 1 at 30 mm"), "{}", text(&shown.stderr));
    let right = solved(steps, "--pull 2mm");
    let tip: Vec<f64> =
        right["tip_position_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!((tip[0] - 88.599e-3).hypot(tip[1] + 50.173e-3) < 1e-4 * 0.115, "{tip:?}");
    let chosen = text(&cppr(&["solve", steps, "--pull", "2mm", "--refine", "2"]).stdout);
    assert!(chosen.contains("consistent formulation") && !chosen.contains("of the length only"), "{chosen}");
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (scenario, table) = (file("scenario.toml"), file("margins.csv"));
    std::fs::write(&scenario, "refine = 2\n[[actuator]]\ntube = 2\npull_mm = 2.0\n").unwrap();
    let said = cppr(&["solve", steps, "--scenario", &scenario]);
    assert_eq!(text(&said.stdout).lines().nth(3), chosen.lines().nth(3), "{}", text(&said.stderr));
    let margins = cppr(&["sweep", steps, "--pull", "1..2mm:2", "--margin", "--output", &table]);
    assert_eq!(margins.status.code(), Some(0), "{}", text(&margins.stderr));
    refused(&["solve", steps, "--pull", "2mm", "--accuracy", "2"], "above 0 and up to 1");
}

/// A robot whose fields have steps: no field leaves the range of what it interpolates.
#[test]
fn fields_stay_within_what_they_interpolate() {
    let steps = "crates/cppr-cli/tests/data/steps_in_a_table.toml";
    let sections = json(&["section", steps, "--samples", "461", "--json", "-"]);
    for tube in sections["tubes"].as_array().unwrap() {
        let of = |key: &str| -> Vec<f64> {
            tube["sections"].as_array().unwrap().iter().map(|s| s[key].as_f64().unwrap()).collect()
        };
        for key in ["bending_y_Nm2", "bending_z_Nm2", "torsion_Nm2", "centroid_offset_m"] {
            let values = of(key);
            let (uncut, notched) = (values[0], values[230]);
            let (low, high) = (uncut.min(notched), uncut.max(notched));
            let allowed = 2e-3 * (high - low);
            assert!(values.iter().all(|v| (low - allowed..=high + allowed).contains(v)), "{key}: {values:?}");
        }
    }
}

/// Every command takes the modes that a robot needs, says what is left, and integrates where it is told to.
#[test]
fn every_command_knows_its_error() {
    let steps = "crates/cppr-cli/tests/data/steps_in_a_table.toml";
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    let mesh = folder.path().join("bent.obj");
    let points = folder.path().join("points.csv");
    std::fs::write(&points, "x_mm,y_mm,z_mm\n60,-10,0\n88.6,-50.17,0\n").unwrap();
    let (table, mesh, points) = (table.to_str().unwrap(), mesh.to_str().unwrap(), points.to_str().unwrap());
    let bounds = ["--pull-bounds", "0..3mm", "--rotate", "0deg"];
    let commands: [&[&str]; 8] = [
        &["limits", steps, "--pull", "2mm"],
        &["sweep", steps, "--pull", "1..2mm:2", "--output", table],
        &["continue", steps, "--along", "pull", "--to", "2mm"],
        &["derivatives", steps, "--pull", "2mm"],
        &["export", steps, "--pull", "2mm", "--output", mesh],
        &["sense", steps, "--pull", "2mm", "--measured-position", "88.6,-50,0.5mm"],
        &[&["reach", steps, "--position", "88.6,-50.17,0mm"], &bounds[..]].concat(),
        &[&["match", steps, "--points", points], &bounds[..]].concat(),
    ];
    for command in commands {
        let said = |options: &[&str]| {
            let output = cppr(&[command, options].concat());
            assert_eq!(output.status.code(), Some(0), "{command:?}: {}", text(&output.stderr));
            // Times differ.
            let lines = text(&output.stdout);
            lines.lines().filter(|line| !line.contains("per second")).map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(said(&[]), said(&["--integrate"]), "{command:?}");
    }
    for command in [
        &["limits", "robots/r3.toml", "--pull", "2mm"][..],
        &["sweep", "robots/r3.toml", "--pull", "1..2mm:2", "--output", table],
        &["continue", "robots/r3.toml", "--along", "pull", "--to", "2mm"],
        &["derivatives", "robots/r3.toml", "--pull", "2mm"],
    ] {
        let own = text(&cppr(&[command, &["--accuracy", "1e-14"]].concat()).stdout);
        assert!(own.contains("of the length") && own.contains("--integrate"), "{command:?}: {own}");
    }
}

/// A solve ends where the path of equilibria from rest ends, as long as that is stable: where it folds on the way, and where steps from rest do not arrive.
#[test]
fn a_solve_ends_where_the_path_from_rest_ends() {
    let tip = |robot: &str, options: &str| -> (Value, Vec<f64>) {
        let found = solved(&format!("crates/cppr-cli/tests/data/{robot}.toml"), options);
        let tip = found["tip_position_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        (found, tip)
    };
    let folds = "--pull 2=0.02310248mm --pull 3=-0.08407234mm --rotate 3=14.037675deg --refine 4";
    let (found, at) = tip("folds_on_the_way", folds);
    assert_eq!(found["status"], "converged");
    let snaps = found["snaps_at"].as_array().unwrap();
    assert!((snaps[0].as_f64().unwrap() - 0.128).abs() < 2e-3, "{snaps:?}");
    for (own, path) in at.iter().zip([19.149e-3, 0.866e-3, -3.158e-3]) {
        assert!((own - path).abs() < 0.01 * 19.5e-3, "{at:?}");
    }
    let (found, _) = tip("path_arrives", "--pull 2=0.726823mm --rotate 3=-16.2982deg");
    assert_eq!(found["status"], "converged");
    assert!(found.get("snaps_at").is_none());
    let margin = found["margin_to_instability"].as_f64().unwrap();
    assert!((0.05..0.25).contains(&margin), "{margin}");
}
