//! Robots with parts and joints from the shell.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, json, refused, root, text};

const S: &str = "robots/bundles/s_shape.toml";

#[test]
fn every_motor_is_driven_and_the_result_is_written() {
    let whole = json(&["solve", S, "--pull", "5mm", "--json", "-"]);
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("../../cppr/tests/data/general_bundles.json")).unwrap();
    let case = reference.as_array().unwrap().iter().find(|c| c["name"] == "s_shape_pull").unwrap();
    for axis in 0..3 {
        let (own, other) = (&whole["tip_position_m"][axis], &case["expected"]["tip_m"][axis]);
        assert!((own.as_f64().unwrap() - other.as_f64().unwrap()).abs() < 3e-8, "{own} {other}");
    }
    assert_eq!(whole["status"], "converged");
    let sections = whole["sections"].as_array().unwrap();
    assert!(sections.len() > 100 && sections[0]["tubes"].as_array().unwrap().len() == 2);
    // The whole robot advanced, and the inner tube pulled against the outer by as much: the same S, 20 mm further out.
    let advanced = json(&["solve", S, "--pull", "1=-20mm", "--pull", "2=-15mm", "--json", "-"]);
    let x = |v: &serde_json::Value| v["tip_position_m"][0].as_f64().unwrap();
    assert!((x(&advanced) - x(&whole) - 0.02).abs() < 1e-5, "{} {}", x(&advanced), x(&whole));
    // What moved with a torque is turned by it.
    let torque = json(&["solve", S, "--torque", "1=3Nmm", "--rotate", "2=10deg", "--json", "-"]);
    assert!((torque["actuators"][0]["torque_Nm"].as_f64().unwrap() - 3e-3).abs() < 1e-12);
}

/// The same force bends metal that unloads further, and the same pull takes less force; where no metal unloads otherwise that is said.
#[test]
fn superelastic_metal_has_two_answers() {
    let solve = ["solve", "robots/wrists/superelastic.toml", "--hysteresis", "--samples", "2", "--json", "-"];
    let number = |v: &serde_json::Value, key: &str| v["actuators"][1][key].as_f64().unwrap();
    let forced = json(&[&solve[..], &["--tension", "2=1N"]].concat());
    let pulled = json(&[&solve[..], &["--pull", "2=1mm"]].concat());
    assert!(number(&forced["unloading"], "pull_m") > 1.5 * number(&forced, "pull_m"), "{forced}");
    assert!(number(&pulled["unloading"], "tension_N") < 0.6 * number(&pulled, "tension_N"), "{pulled}");
    assert!((number(&pulled["unloading"], "pull_m") - 1e-3).abs() < 1e-12);
    for robot in ["robots/r1.toml", "robots/wrists/wrist90.toml"] {
        refused(&["solve", robot, "--hysteresis"], "write unloading_onset_strain_percent");
    }
}

#[test]
fn a_figure_shows_joints_and_tubes() {
    let folder = tempfile::tempdir().unwrap();
    let two = [
        "solve",
        "robots/bundles/two_sections.toml",
        "--pull",
        "2=3mm",
        "--pull",
        "4=2mm",
        "--plot",
        "f.svg",
    ];
    assert!(cppr_in(folder.path(), &two).status.success());
    let svg = std::fs::read_to_string(folder.path().join("f.svg")).unwrap();
    for word in ["joint", "tube 4", "at rest", "X (mm)"] {
        assert!(svg.contains(word), "{word} is missing");
    }
}

#[test]
fn what_cannot_be_asked_is_said() {
    for (arguments, fragment) in [
        (&["--pull", "3=1mm"][..], "there is no tube 3"),
        (&["--pull", "2=1mm", "--tension", "2=1N"], "twice"),
        (&["--pull", "2=200mm"], "behind the plate"),
        (&["--planar"], "no modes"),
        (&["--gravity", "0,0,-1g"], "no mass"),
        (&["--stretch"], "axial_N"),
        (&["--point-force", "160mm:0,1,0N"], "150.000 mm long"),
        (&["--scenario", "examples/scenario.toml"], "there is no tube 3"),
    ] {
        refused(&[&["solve", S][..], arguments].concat(), fragment);
    }
    let none = cppr(&["solve", S, "--pull", "2=100mm"]);
    assert_eq!(none.status.code(), Some(3));
    assert!(text(&none.stderr).contains("no equilibrium was found"));
}

#[test]
fn other_commands_say_what_takes_such_a_robot() {
    refused(
        &["section", S],
        "`cppr solve`, `check`, `sweep`, `derivatives`, `limits`, `reach`, `match`, `sense`, `calibrate`, `continue`, `export` and `view` take it",
    );
    refused(
        &["calibrate", S, "--data", "examples/calibration/r1.csv", "--fit", "youngs_modulus"],
        "has no modulus to fit",
    );
    refused(&["derivatives", S, "--by", "length_mm"], "the robot file has no length_mm");
    refused(&["sweep", S, "--pull", "0..1mm:2", "--output", "x.glb"], ".csv, .npz or .parquet");
    refused(
        &["sweep", S, "--pull", "0..1mm:2", "--margin", "--output", "x.csv"],
        "a margin to instability is not known",
    );
}

#[test]
fn limits_and_inverse_problems_take_bundles() {
    const UNCUT: &str = "robots/bundles/uncut_ends.toml";
    let json = |arguments: &[&str]| json(&[arguments, &["--json", "-"]].concat());
    let limits = json(&["limits", UNCUT, "--pull", "1mm"]);
    assert_eq!(
        limits["pose"]["sections"].as_array().unwrap().iter().filter(|s| s["place"] == "notch").count(),
        200
    );
    assert!(limits["pose"]["governing"]["utilisation"].as_f64().unwrap() > 0.05);
    let pull =
        limits["ranges"].as_array().unwrap().iter().find(|r| r["tube"] == 2 && r["actuator"] == "pull");
    let high = pull.unwrap()["high"]["value"].as_f64().unwrap();
    assert!((3e-3..2e-2).contains(&high), "{high}");
    // What a pull of 2 mm does is led back to it.
    let pulled = json(&["solve", UNCUT, "--pull", "2mm"]);
    let tip: Vec<f64> =
        pulled["tip_position_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let at = format!("{},{},{}m", tip[0], tip[1], tip[2]);
    let bounds = ["--rotate", "0deg", "--pull-bounds", "0..3mm"];
    let reached = json(&[&["reach", UNCUT, "--position", &at][..], &bounds].concat());
    assert_eq!(reached["reached"], true);
    assert!((reached["inputs"][0]["value"].as_f64().unwrap() - 2e-3).abs() < 1e-6, "{reached}");
    let force = pulled["actuators"][1]["tension_N"].as_f64().unwrap();
    let tension = format!("{force}N");
    let sensed =
        json(&["sense", UNCUT, "--pull", "2mm", "--measured-tension", &tension, "--measured-position", &at]);
    for component in sensed["force_N"].as_array().unwrap() {
        assert!(component.as_f64().unwrap().abs() < 1e-4, "{sensed}");
    }
    let folder = tempfile::tempdir().unwrap();
    let points = folder.path().join("points.csv");
    std::fs::write(&points, format!("x_mm,y_mm,z_mm\n{},{},{}\n", tip[0] * 1e3, tip[1] * 1e3, tip[2] * 1e3))
        .unwrap();
    let matched = json(&[&["match", UNCUT, "--points", points.to_str().unwrap()][..], &bounds].concat());
    assert!((matched["inputs"][0]["value"].as_f64().unwrap() - 2e-3).abs() < 1e-5, "{matched}");
}

#[test]
fn files_of_bundles_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let export = |robot: &str, extra: &[&str]| {
        cppr_in(folder.path(), &[&["export", &format!("robots/bundles/{robot}.toml")], extra].concat())
    };
    let cuts = text(&export("uncut_ends", &["--tube", "1", "--output", "cuts.dxf"]).stdout);
    assert!(cuts.contains("notches      100"), "{cuts}");
    let bent = export("uncut_ends", &["--pull", "1=-20mm", "--pull", "2=-19mm", "--output", "bent.glb"]);
    assert!(text(&bent.stdout).contains("Uncut ends, tube 2"), "{}", text(&bent.stderr));
    let straight = text(&export("hybrid", &["--tube", "3", "--output", "tube.stl"]).stdout);
    assert!(straight.contains("straight, before it is given its rest curvature"), "{straight}");
    for (robot, extra, code, fragment) in [
        ("s_shape", &["--output", "x.glb"][..], 2, "by its stiffness, which has no shape"),
        ("uncut_ends", &["--tube", "3", "--output", "x.stl"], 2, "there is no tube 3"),
        ("uncut_ends", &["--pull", "2=200mm", "--output", "x.glb"], 2, "behind the plate"),
        ("uncut_ends", &["--pull", "2=100mm", "--output", "x.glb"], 3, "no equilibrium was found"),
        ("uncut_ends", &["--planar", "--output", "x.glb"], 2, "no modes"),
    ] {
        let output = export(robot, extra);
        assert_eq!(output.status.code(), Some(code), "{robot} {extra:?}");
        assert!(text(&output.stderr).contains(fragment), "{}", text(&output.stderr));
    }
    // Beside robots and examples.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
}

/// The path passes the fold at 238.36 deg (docs/src/snap.md) and a second one, and comes back after a whole turn.
#[test]
fn a_path_passes_the_folds_of_curved_tubes() {
    let task = ["continue", "robots/bundles/two_curved.toml", "--along", "rotate=2", "--to", "360deg"];
    let whole = json(&[&task[..], &["--json", "-"]].concat());
    let points = whole["branches"][0]["points"].as_array().unwrap();
    let folds: Vec<f64> = points
        .iter()
        .filter(|p| p["kind"] == "fold")
        .map(|p| p["parameter"].as_f64().unwrap().to_degrees())
        .collect();
    assert_eq!(folds.len(), 2, "{folds:?}");
    assert!((folds[0] - 238.36).abs() < 0.01 && (folds[1] - 121.64).abs() < 0.01, "{folds:?}");
    assert!(points.iter().any(|p| p["stable"] == false));
    let folder = tempfile::tempdir().unwrap();
    let files = ["path.csv", "path.svg"].map(|name| folder.path().join(name).display().to_string());
    let written = cppr(&[&task[..], &["--csv", &files[0], "--plot", &files[1]]].concat());
    assert!(written.status.success() && text(&written.stdout).contains("fold"), "{}", text(&written.stderr));
    let table = std::fs::read_to_string(&files[0]).unwrap();
    assert_eq!(table.lines().count(), points.len() + 1);
    refused(&["continue", S, "--along", "pull=9", "--to", "5mm"], "there is no tube 9");
    refused(&["continue", S, "--along", "load", "--to", "2"], "there is no load");
}

#[test]
fn a_sweep_follows_a_branch_until_it_snaps() {
    let folder = tempfile::tempdir().unwrap();
    let task = ["robots/bundles/two_curved.toml", "--rotate", "2=180..240deg:7", "--output", "snap.csv"];
    let output = cppr_in(folder.path(), &[&["sweep"][..], &task].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(folder.path().join("snap.csv")).unwrap();
    let rows: Vec<&str> = table.lines().skip(2).collect();
    assert!(table.lines().nth(1).unwrap().starts_with("input_tube2_rotation_rad,status,status_text,tip_x_m"));
    let z = |row: &str| row.split(',').nth(5).unwrap().parse::<f64>().unwrap();
    // The branch from rest lies on the side to which the inner tube was turned; the snap is at 238.36 deg (docs/src/snap.md).
    assert!(
        rows.len() == 7 && rows[..6].iter().all(|row| row.contains("converged") && z(row) > 0.03),
        "{table}"
    );
    assert!(z(rows[6]).is_nan() || z(rows[6]) < 0.0, "{}", rows[6]);
    // Threads change nothing, and a joint behind the plate is a row's matter.
    let two = |threads: &str, name: &str| {
        let task = [
            "sweep",
            S,
            "--pull",
            "1=-10..0mm:2",
            "--pull",
            "2=0..200mm:3",
            "--threads",
            threads,
            "--output",
            name,
        ];
        assert!(cppr_in(folder.path(), &task).status.success());
        std::fs::read_to_string(folder.path().join(name)).unwrap()
    };
    let one = two("1", "one.csv");
    assert_eq!(one, two("3", "three.csv"));
    assert_eq!(one.matches("behind the plate").count(), 2, "{one}");
}

/// A table with steps: modes answer (88.37, -45.22) mm and 2.46 N; integrated, the robot of an independent program with parts is found, (88.599, -50.173) mm and 1.8538 N, up to the table's flanks of 0.01 mm.
#[test]
fn a_step_in_a_table_is_told_and_can_be_integrated() {
    let folder = tempfile::tempdir().unwrap();
    let usual = std::fs::read_to_string(root().join("crates/cppr-cli/tests/data/steps.toml")).unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let told = text(&cppr(&["check", &write("steps.toml", &usual)]).stdout);
    let place = "notch depth of tube 1 at 30 mm, notch depth of tube 2 at 30 mm";
    assert!(told.contains(place) && told.contains("[[tube.part]]"), "{told}");
    let said = text(&cppr(&["solve", &write("steps.toml", &usual), "--pull", "2mm"]).stderr);
    assert!(said.contains(place) && said.contains("integrated"), "{said}");
    let joined = write("joined.toml", &(usual + "\n[[joint]]\ntubes = [1, 2]\n"));
    assert!(!text(&cppr(&["check", &joined]).stdout).contains("sudden"));
    let whole = json(&["solve", &joined, "--pull", "2mm", "--json", "-"]);
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let (x, y) = (number(&whole["tip_position_m"][0]), number(&whole["tip_position_m"][1]));
    assert!((x - 88.599e-3).hypot(y + 50.173e-3) < 1e-5, "{x} {y}");
    assert!((number(&whole["actuators"][1]["tension_N"]) - 1.8538).abs() < 1e-3);
}

/// Turns of the opening by different angles over different lengths: where nothing is said, the usual equations are right.
#[test]
fn what_is_not_told_of_a_turn_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (mut told, mut followed) = (0, 0);
    for turn in [4.0, 10.0, 45.0, 180.0] {
        for width in [2.0, 15.0, 30.0, 50.0] {
            let (a, b) = (25.0 - 0.5 * width, 25.0 + 0.5 * width);
            let tube = |opening: f64| {
                let end = opening - turn;
                let along = if width < 50.0 {
                    format!(
                        "{{ x_mm = [0, {a}, {b}, 50], opening_deg = [{opening}, {opening}, {end}, {end}] }}"
                    )
                } else {
                    format!("[{opening}, {end}]")
                };
                format!(
                    "[[tube]]\n[tube.stiffness]\ncentroid_offset_mm = 1.0\nbending_y_Nmm2 = 100\nbending_z_Nmm2 = 100\n\
                     torsion_Nmm2 = 100\nopening_deg = {along}\n"
                )
            };
            let text = format!("name = \"turn\"\nlength_mm = 50\n{}{}", tube(180.0), tube(0.0));
            let solved = |name: &str, text: &str| {
                let path = folder.path().join(name);
                std::fs::write(&path, text).unwrap();
                let whole = json(&["solve", path.to_str().unwrap(), "--pull", "1mm", "--json", "-"]);
                [0, 1, 2].map(|axis| whole["tip_position_m"][axis].as_f64().unwrap())
            };
            let usual = solved("turn.toml", &text);
            let integrated = solved("joined.toml", &(text + "\n[[joint]]\ntubes = [1, 2]\n"));
            let off = usual.iter().zip(integrated).map(|(u, i)| (u - i).powi(2)).sum::<f64>().sqrt() / 0.05;
            let path = folder.path().join("turn.toml");
            if common::text(&cppr(&["check", path.to_str().unwrap()]).stdout).contains("uneven") {
                told += 1;
            } else {
                followed += 1;
                assert!(off < 5e-4, "{turn} deg over {width} mm: off by {off:e} of the length");
            }
        }
    }
    assert!(told >= 6 && followed >= 5, "{told} {followed}");
}
