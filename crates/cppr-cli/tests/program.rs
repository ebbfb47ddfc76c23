//! The program as a user meets it: what it prints, writes, refuses, and its exit codes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, json, refused, root, text};
use serde_json::Value;
use std::process::Command;

#[test]
fn the_table_holds_what_a_person_looks_for() {
    let output = cppr(&["solve", "robots/r3.toml", "--pull", "5mm"]);
    let table = text(&output.stdout);
    for part in [
        "R3",
        "converged, stable",
        "134.383",
        "-54.908",
        "33.345 deg",
        "1.5122 N",
        "margin",
        "1.00000 of the tip",
        "Newton steps",
    ] {
        assert!(table.contains(part), "{part} is missing in\n{table}");
    }
}

fn no_null(value: &Value, path: &str) {
    match value {
        // A number that is not finite becomes null.
        Value::Null => assert!(path.ends_with("gravity_m_s2"), "{path} is null"),
        Value::Array(list) => list.iter().for_each(|v| no_null(v, path)),
        Value::Object(map) => map.iter().for_each(|(k, v)| no_null(v, &format!("{path}/{k}"))),
        _ => {}
    }
}

#[test]
fn json_is_whole_and_finite() {
    let result = json(&[
        "solve",
        "robots/childs3.toml",
        "--pull",
        "2=1mm",
        "--pull",
        "3=-0.5mm",
        "--rotate",
        "2=30deg",
        "--tip-force",
        "0,0,-0.5N",
        "--samples",
        "11",
        "--json",
        "-",
    ]);
    assert_eq!(result["schema_version"], 1);
    assert_eq!(result["status"], "converged");
    assert_eq!(result["sections"].as_array().unwrap().len(), 11);
    assert_eq!(result["sections"][3]["tubes"].as_array().unwrap().len(), 3);
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&result["actuators"][0]["pull_m"]) - 1e-3).abs() < 1e-12);
    assert!((number(&result["actuators"][0]["rotation_rad"]) - 30_f64.to_radians()).abs() < 1e-9);
    assert!((number(&result["command"]["loads"]["wrenches"][0]["force_N"][2]) + 0.5).abs() < 1e-15);
    // Rotations come by rows: the first column is the tangent, which the centreline shows as well.
    let (last, before) = (&result["sections"][10]["centre_m"], &result["sections"][9]["centre_m"]);
    for axis in 0..3 {
        let step = number(&last[axis]) - number(&before[axis]);
        let tangent = number(&result["tip_rotation"][axis][0]);
        assert!((step / 3e-3 - tangent).abs() < 0.15, "axis {axis}: {step} against {tangent}");
    }
    // The tip is the last section.
    assert_eq!(result["tip_position_m"], result["sections"][10]["centre_m"]);
    no_null(&result, "");
}

#[test]
fn the_keys_of_schema_1() {
    let keys = |value: &Value| {
        let mut keys: Vec<_> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort_unstable();
        keys.join(" ")
    };
    let result = json(&["solve", "robots/r1.toml", "--tension", "1N", "--samples", "2", "--json", "-"]);
    assert_eq!(
        keys(&result),
        "accuracy actuators command cppr_version critical_tip_direction elastic_energy_J formulation margin_to_instability \
         resolution robot schema schema_version sections statistics status status_text tip_position_m tip_rotation \
         total_bend_rad"
    );
    assert_eq!(keys(&result["actuators"][0]), "pull_m rotation_rad tension_N torque_Nm tube");
    assert_eq!(keys(&result["command"]["actuators"][0]), "rotation_rad tension_N tube");
    assert_eq!(keys(&result["command"]["loads"]), "distributed gravity_m_s2 threads wrenches");
    assert_eq!(
        keys(&result["sections"][0]),
        "centre_m energy_density_J_m follower_angles_rad leader_curvature_1_m rotation tubes x_m"
    );
    assert_eq!(
        keys(&result["sections"][0]["tubes"][0]),
        "abscissa_m axial_force_N centroid_m curvature_y_1_m curvature_z_1_m face_to_face_rate moment_y_Nm \
         moment_z_Nm rotation shear_y_N shear_z_N stretch torque_Nm twist_rad_m"
    );
}

/// Notches bend on in the mechanics after their teeth have met. What is said to be safe is so, and no more is.
#[test]
fn beyond_the_limits_of_notches_there_is_a_warning() {
    let solved =
        |pull: &str| json(&["solve", "robots/r1.toml", "--pull", pull, "--samples", "2", "--json", "-"]);
    for (pull, verb, far) in
        [("140mm", "pulled", 0.14), ("0.14m", "pulled", 0.14), ("-40mm", "pushed", -0.04)]
    {
        let output = cppr(&["solve", "robots/r1.toml", "--pull", pull]);
        let table = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "an equilibrium it is: {table}");
        let warning = table.lines().find(|line| line.contains("% of what is allowed")).expect("a warning");
        let beyond = solved(pull);
        let told = &beyond["limit_exceeded"];
        assert!(warning.contains(told["text"].as_str().unwrap()), "{warning}");
        assert_eq!(told["governing"]["limit"], "strain");
        assert!(told["governing"]["utilisation"].as_f64().unwrap() > 4.0);
        assert!(told["governing"]["section"]["notch"].is_i64());
        let safe = told["safe_part"].as_f64().unwrap() * far;
        assert!(warning.ends_with(&format!("tube 2 {verb} by {:.3} mm", safe.abs() * 1e3)), "{warning}");
        for (share, within) in [(0.999, true), (1.001, false)] {
            let result = solved(&format!("{}m", share * safe));
            assert_eq!(result.get("limit_exceeded").is_none(), within, "{share} of {safe} m");
        }
    }
    // A path whose end is slow to find: the limit takes hundreds of equilibria at most, and the table says how long.
    let slow = "--pull 2=0.137179mm --pull 3=-0.0612785mm --torque 3=17.9569Nmm --tension 4=-2.15063N \
        --gravity -5.62332,7.93893,0m/s2";
    let slow: Vec<&str> = slow.split(' ').collect();
    let output = cppr(&[&["solve", "crates/cppr-cli/tests/data/slow15.toml"], &slow[..]].concat());
    let table = text(&output.stdout);
    let cost = table.lines().find(|line| line.contains("cost")).expect("a cost");
    assert!(cost.contains("; the limit ") && table.contains("all limits are kept up to"), "{table}");
    let both = cppr(&["solve", "robots/r1.toml", "--pull", "12mm", "--rotate", "50deg"]);
    assert!(text(&both.stdout).contains("% of this command"), "{}", text(&both.stdout));
    let limits = text(&cppr(&["limits", "robots/r1.toml", "--pull", "40mm"]).stdout);
    assert!(
        limits.contains("no safe range: tube 2 notch") && limits.contains("pulled by 7.684 mm"),
        "{limits}"
    );
}

#[test]
fn the_bend_goes_on_beyond_half_a_turn() {
    let table = |pull: &str| text(&cppr(&["solve", "robots/r1.toml", "--pull", pull]).stdout);
    assert!(!table("5mm").contains("along the robot"));
    let far = table("40mm");
    // More than half a turn: what both angles have in common is the tip's direction.
    let line = far.lines().find(|line| line.contains("bend angle")).unwrap();
    let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [tip, along] = numbers[..] else { panic!("{line}") };
    assert!(along > 360.0 && (tip.to_radians().cos() - along.to_radians().cos()).abs() < 1e-4, "{line}");
}

#[test]
fn a_mistaken_unit_is_named() {
    for (arguments, code, words) in [
        (
            ["--tension", "1e9N"],
            3,
            "The tension of tube 2 is 1.0e9 N; on this robot about 4.78 N bends by 90°",
        ),
        (["--tip-force", "0,1e9,0N"], 3, "The tip force is 1.0e9 N"),
        (["--tip-force", "1e9,0,0N"], 0, "The tip force is 1.0e9 N"),
        (["--torque", "1e6Nm"], 3, "The torque of tube 2 is 1.0e9 N mm"),
        (["--distributed", "0..100mm:0,-1e9,0N/m"], 3, "The distributed force from 0 to 100 mm is 1.0e9 N/m"),
        (["--point-force", "60mm:0,1e9,0N"], 3, "The force at 60 mm is 1.0e9 N"),
        (["--thread", "1e9N:150,-24,0mm"], 3, "The tension of the thread is 1.0e9 N"),
        (["--gravity", "0,0,-1e6m/s2"], 0, "Gravity is 1.0e6 m/s²"),
        (["--pull", "140mm"], 0, "The pull of tube 2 is 140 mm"),
    ] {
        let output = cppr(&[&["solve", "robots/r1.toml"][..], &arguments[..]].concat());
        let message = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(
            message.contains(words) && message.contains("Check number and unit"),
            "{arguments:?}: {message}"
        );
        assert!(!message.contains("0.0 %"), "{message}");
    }
}

#[test]
fn loads_reach_the_solver() {
    let tip = |extra: &[&str]| -> Vec<f64> {
        let arguments = [&["solve", "robots/r1.toml", "--pull", "2mm", "--json", "-"], extra].concat();
        let result = json(&arguments);
        result["tip_position_m"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let free = tip(&[]);
    let moved = |extra: &[&str], axis: usize, sign: f64| {
        let by = tip(extra)[axis] - free[axis];
        assert!(by * sign > 1e-6, "{extra:?} moves the tip by {by} m along {axis}");
    };
    moved(&["--tip-force", "0,0,0.1N"], 2, 1.0);
    moved(&["--tip-force", "0,-100,0mN"], 1, -1.0);
    moved(&["--tip-moment", "0,5,0Nmm"], 2, -1.0);
    moved(&["--point-force", "80mm:0,0,0.2N"], 2, 1.0);
    moved(&["--distributed", "20..100mm:0,0,-2N/m"], 2, -1.0);
    moved(&["--gravity", "0,0,-1g"], 2, -1.0);
    moved(&["--thread", "0.1962N:150,-240,0mm:4mm:right"], 1, -1.0);
    moved(&["--rotate", "20deg"], 2, -1.0);
    let stretched = tip(&["--stretch"]);
    assert!((stretched[1] - free[1]).abs() > 1e-6);
    let printed = tip(&["--formulation", "printed", "--tip-force", "0,0.1,0N"]);
    let consistent = tip(&["--tip-force", "0,0.1,0N"]);
    assert!((printed[1] - consistent[1]).abs() > 1e-5, "both formulations give the same");
    let planar = tip(&["--planar", "--tip-force", "0,0.1,0N"]);
    assert!((planar[1] - consistent[1]).abs() < 1e-6);
}

#[test]
fn forces_may_be_given_instead_of_motions() {
    let pulled = json(&["solve", "robots/r1.toml", "--pull", "3mm", "--rotate", "10deg", "--json", "-"]);
    let actuator = &pulled["actuators"][0];
    let tension = format!("{}N", actuator["tension_N"]);
    let torque = format!("{}Nm", actuator["torque_Nm"]);
    let driven =
        json(&["solve", "robots/r1.toml", "--tension", &tension, "--torque", &torque, "--json", "-"]);
    let motion = driven["actuators"][0]["pull_m"].as_f64().unwrap();
    assert!((motion - 3e-3).abs() < 1e-8, "{motion}");
}

#[test]
fn csv_has_a_row_per_section_and_a_unit_per_column() {
    let output = cppr(&["solve", "robots/r3.toml", "--pull", "-5mm", "--samples", "21", "--csv", "-"]);
    let csv = text(&output.stdout);
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(head.len(), 5 + 2 * 15);
    for name in &head {
        let unitless = name.ends_with("rate") || name.ends_with("stretch");
        let units = ["_m", "_N", "_Nm", "_1_m", "_rad_m", "_J_m"];
        assert!(unitless || units.iter().any(|u| name.ends_with(u)), "{name} has no unit");
    }
    let rows: Vec<Vec<f64>> =
        lines.map(|l| l.split(',').map(|v| v.parse::<f64>().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 21);
    assert!(rows.iter().flatten().all(|v| v.is_finite()));
    // Pushed by 5 mm: the section of tube 2 at the plate was 5 mm below it.
    let face = head.iter().position(|h| *h == "tube2_abscissa_m").unwrap();
    assert!((rows[0][face] + 5e-3).abs() < 1e-9);
    assert!(text(&output.stderr).contains("converged"), "the table goes to standard error");
}

#[test]
fn figures_are_well_formed() {
    let folder = tempfile::tempdir().unwrap();
    let plot = |arguments: &[&str]| assert_eq!(cppr_in(folder.path(), arguments).status.code(), Some(0));
    plot(&["solve", "robots/r3.toml", "--pull", "5mm", "--plot", "r3.svg"]);
    plot(&["solve", "robots/helicoid.toml", "--pull", "10mm", "--plot", "helicoid.png"]);
    plot(&["section", "robots/r3.toml", "--plot", "sections.svg"]);
    for name in ["r3.svg", "sections.svg"] {
        let svg = std::fs::read_to_string(folder.path().join(name)).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg");
        assert!(svg.contains("tube 2") && svg.contains("mm"));
    }
    let png = std::fs::read(folder.path().join("helicoid.png")).unwrap();
    assert_eq!(&png[1..4], b"PNG");
}

#[test]
fn a_figure_does_not_depend_on_the_samples_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let svg = |samples: &str| {
        let load = ["--pull", "-3mm", "--point-force", "60mm:0,0.2,0N", "--thread", "0.1N:150,-90,0mm:4mm"];
        let arguments =
            [&["solve", "robots/r1.toml", "--samples", samples, "--plot", "f.svg"][..], &load].concat();
        assert_eq!(cppr_in(folder.path(), &arguments).status.code(), Some(0));
        std::fs::read_to_string(folder.path().join("f.svg")).unwrap()
    };
    let coarse = svg("2");
    assert!(coarse.contains("force") && coarse.contains("−3"), "arrows and title");
    assert_eq!(coarse, svg("101"));
}

#[test]
fn a_figure_names_the_printed_formulation_and_the_knob() {
    let folder = tempfile::tempdir().unwrap();
    let turned = ["solve", "robots/r1.toml", "--rotate", "60deg", "--relative-angle", "--plot", "f.svg"];
    let printed = [&turned[..], &["--formulation", "printed"]].concat();
    for (arguments, as_printed) in [(&turned[..], false), (&printed[..], true)] {
        assert_eq!(cppr_in(folder.path(), arguments).status.code(), Some(0));
        let svg = std::fs::read_to_string(folder.path().join("f.svg")).unwrap();
        assert_eq!(svg.contains("as printed"), as_printed);
        assert!(svg.contains("−Δθ") && !svg.contains('Ω'), "the angle is not the motor's");
    }
}

#[test]
fn section_prints_the_properties() {
    let table = text(&cppr(&["section", "robots/r1.toml", "--tube", "1", "--samples", "2"]).stdout);
    // A = 3.0975 mm², D = 2.4063 mm (appendix B), f_D D = 3.0560 mm, EI_Z = 1153.2 N mm².
    for number in ["3.0975", "2.4063", "3.0560", "1153.24"] {
        assert!(table.contains(number), "{number} is missing in\n{table}");
    }
    let known_stiffness =
        text(&cppr(&["section", "robots/childs2.toml", "--csv", "-", "--samples", "2"]).stdout);
    assert!(known_stiffness.lines().nth(1).unwrap().starts_with("1,0,,,1"), "{known_stiffness}");
    refused(&["section", "robots/r1.toml", "--tube", "4"], "there is no tube 4; this robot has 1 to 2");
}

#[test]
fn wrong_values_are_refused_with_what_to_write() {
    let solve = |extra: &[&'static str], fragment: &str| {
        refused(&[&["solve", "robots/r1.toml"], extra].concat(), fragment);
    };
    solve(&["--pull", "5"], "5 has no unit: write for instance 5mm");
    solve(&["--pull", "5N"], "known units here: mm");
    solve(&["--pull", "nanmm"], "not a finite number");
    solve(&["--pull", "infm"], "not a finite number");
    solve(&["--pull", "3=5mm"], "there is no tube 3; the only follower of this robot is tube 2");
    solve(&["--pull", "1=5mm"], "tube 1 is the leader");
    solve(&["--pull", "5mm", "--tension", "2N"], "given twice");
    solve(&["--pull", "5m"], "Check the unit");
    solve(&["--tip-force", "0,0N"], "2 components");
    solve(&["--tip-force", "0,0,1"], "1 has no unit");
    solve(&["--point-force", "200mm:0,1,0N"], "200.000 mm");
    solve(&["--thread", "-1N:1,1,1mm"], "the tension of the thread is -1N; it cannot be negative");
    solve(&["--thread", "1N:1,1,1mm:-3mm"], "the radius of the pulley is -3mm");
    solve(&["--pull", "1e300m"], "more than any robot meets");
    solve(&["--distributed", "100..20mm:0,1,0N/m"], "the smaller abscissa first");
    solve(&["--thread", "1N:1,1,1mm:1mm:up"], "left or right");
    solve(&["--plot", "shape.pdf"], ".svg or .png");
    solve(&["--plot", "no/such/folder/shape.svg"], "no/such/folder");
    solve(&["--json", "-", "--csv", "-"], "cannot both go to standard output");
    solve(&["--json", "a", "--csv", "a"], "cannot both go to a");
    solve(&["--json", "robots"], "this is a folder");
    solve(&["--json", "robots/../robots/r1.toml"], "would overwrite the robot");
    solve(&["--tip-point", "0,1,0mm"], "add --tip-force");
    solve(
        &["--tip-point", "0,1,0mm", "--thread", "1N:1,1,1mm"],
        "--thread 0.2N:150,-24,0mm:0mm:left:0,3,0mm",
    );
    solve(&["--follower-load"], "add --tip-force or --tip-moment");
    solve(&["--samples", "1"], "2..=100000");
    solve(&["--planar", "--rotate", "5deg"], "planar");
    for (option, value) in [
        ("--tip-force", "0,1,1N"),
        ("--tip-moment", "1,0,0Nmm"),
        ("--point-force", "60mm:0,0,1N"),
        ("--distributed", "0..60mm:0,0,1N/m"),
        ("--gravity", "0,0,-1g"),
        ("--thread", "1N:100,100,1mm"),
    ] {
        solve(&["--planar", option, value], &format!("{option} acts out of the plane"));
    }
    refused(&["solve", "robots/helicoid.toml", "--planar"], "leave --planar away");
    refused(&["solve", "robots/childs2.toml", "--gravity", "0,0,-1g"], "no mass");
    solve(&["--pul", "5mm"], "--pull");
    refused(&["solve", "robots/childs2.toml", "--stretch"], "axial stiffness");
    refused(&["solve", "robots/none.toml"], "none.toml");
    refused(&["solve", "robots"], "robots");
    let both = cppr(&["check", "Cargo.toml", "robots/r1.toml"]);
    assert_eq!(both.status.code(), Some(2));
    assert!(text(&both.stderr).contains("Cargo.toml:1") && text(&both.stdout).contains("fine"));
}

#[test]
fn check_reports_every_problem_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.toml");
    let good = std::fs::read_to_string(root().join("robots/r1.toml")).unwrap();
    let broken = good
        .replace("length_mm = 150", "length = 150")
        .replace("outer_radius_mm = 1.5", "outer_radius_mm = 2.5");
    assert_ne!(good, broken);
    std::fs::write(&path, broken).unwrap();
    let output = cppr(&["check", path.to_str().unwrap()]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("length_mm = 150") && message.contains("does not fit"), "{message}");
    std::fs::write(&path, "").unwrap();
    assert_eq!(cppr(&["check", path.to_str().unwrap()]).status.code(), Some(2));
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    assert_eq!(cppr(&["check", path.to_str().unwrap()]).status.code(), Some(2));
}

#[test]
fn where_there_is_no_equilibrium_the_program_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "solve",
        "robots/r1.toml",
        "--tension",
        "1e6N",
        "--json",
        "out.json",
        "--csv",
        "out.csv",
        "--plot",
        "out.svg",
    ];
    let output = cppr_in(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("not converged"), "{}", text(&output.stderr));
    assert!(output.stdout.is_empty());
    let result: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("out.json")).unwrap()).unwrap();
    assert_eq!(result["status"], "not_converged");
    assert!(result.get("tip_position_m").is_none(), "numbers that mean nothing are written");
    assert!(!folder.path().join("out.csv").exists() && !folder.path().join("out.svg").exists());
}

#[test]
fn a_thread_whose_eyelet_is_at_the_tip_is_refused() {
    let output = cppr(&["solve", "robots/r3.toml", "--thread", "1N:150,0,0mm"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("pulls in no direction"), "{}", text(&output.stderr));
}

#[test]
fn an_unstable_equilibrium_is_shown_with_a_warning() {
    let arguments = ["solve", "robots/childs2.toml", "--tip-force", "-50,0,0N"];
    let output = cppr(&arguments);
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{table}");
    assert!(table.contains("warning") && table.contains("unstable"), "{table}");
    assert_eq!(json(&[&arguments[..], &["--json", "-"]].concat())["status"], "unstable");
}

/// The stable shape that is given is an end of the branches that the message names.
#[test]
fn an_unstable_equilibrium_is_not_the_end() {
    let command = ["robots/r3.toml", "--pull", "-5mm", "--tip-force", "-2,0,0N"];
    let table = text(&cppr(&[&["solve"], &command[..]].concat()).stdout);
    let hint = "cppr continue robots/r3.toml --along command --to 1 --branches";
    assert!(
        table.contains(hint) && table.contains("a stable shape under the same command: tip at"),
        "{table}"
    );
    let result = json(&[&["solve"], &command[..], &["--json", "-"]].concat());
    let tip = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let stable = tip(&result["stable_aside"]["tip_position_m"]);
    assert!(stable[2].abs() > 0.01, "it leaves the plane: {stable:?}");
    let path = ["continue", "--along", "command", "--to", "1", "--branches", "--json", "-"];
    let branches = json(&[&path[..], &command[..]].concat());
    let ends = branches["branches"].as_array().unwrap().iter().filter_map(|b| b["points"].as_array()?.last());
    let met = ends.filter(|p| p["stable"] == true).map(|p| tip(&p["tip_position_m"]));
    let nearest = met
        .map(|t| t.iter().zip(&stable).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-9, "{nearest} m from the nearest end of a branch");
    // Nothing of this where the robot is stable.
    let stable = json(&["solve", "robots/r3.toml", "--pull", "5mm", "--json", "-"]);
    assert!(stable.get("stable_aside").is_none());
}

#[test]
fn results_keep_links_modes_and_pipes() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let solve = |file: &str| {
        let output = cppr_in(folder.path(), &["solve", "robots/r1.toml", "--samples", "2", "--json", file]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    };
    std::fs::write(at("real"), "old").unwrap();
    std::fs::set_permissions(at("real"), std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real", at("link")).unwrap();
    solve("link");
    assert!(std::fs::symlink_metadata(at("link")).unwrap().is_symlink());
    assert_eq!(std::fs::metadata(at("real")).unwrap().permissions().mode() & 0o777, 0o640);
    serde_json::from_slice::<Value>(&std::fs::read(at("real")).unwrap()).unwrap();

    // A new file gets the mode that any new file gets.
    solve("new");
    std::fs::write(at("any"), "").unwrap();
    let mode = |name: &str| std::fs::metadata(at(name)).unwrap().permissions().mode();
    assert_eq!(mode("new"), mode("any"));

    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    let reader = Command::new("cat").arg(at("pipe")).stdout(std::process::Stdio::piped()).spawn().unwrap();
    solve("pipe");
    serde_json::from_slice::<Value>(&reader.wait_with_output().unwrap().stdout).unwrap();
    assert!(std::fs::metadata(at("pipe")).unwrap().file_type().is_fifo());
}

#[test]
fn nobody_listening_on_standard_error_is_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let code = folder.path().join("code");
    let line = format!(
        "{{ {} solve robots/r3.toml --samples 20000 --csv -; echo $? >{}; }} 2>&1 | head -1",
        env!("CARGO_BIN_EXE_cppr"),
        code.display()
    );
    Command::new("sh").args(["-c", &line]).current_dir(root()).output().unwrap();
    assert_eq!(std::fs::read_to_string(code).unwrap().trim(), "0");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let line = format!(
        "{} solve robots/r3.toml --samples 20000 --csv - 2>/dev/null | head -1",
        env!("CARGO_BIN_EXE_cppr")
    );
    let output = Command::new("sh").args(["-c", &line]).current_dir(root()).output().unwrap();
    assert!(text(&output.stdout).starts_with("x_m,"));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn calibrate_tells_what_the_data_cannot_see() {
    let data = ["--data", "examples/calibration/r1.csv"];
    let calibrate = |extra: &[&'static str]| [&["calibrate", "robots/r1.toml"], &data[..], extra].concat();
    refused(&calibrate(&["--fit", "centroid_offset_factor,youngs_modulus"]), "Remark 19");
    refused(&calibrate(&["--fit", "weight"]), "cannot be fitted");
    refused(&["calibrate", "robots/r1.toml", "--data", "none.csv", "--fit", "youngs_modulus"], "none.csv");
    refused(
        &["calibrate", "robots/r1.toml", "--data", "robots/r1.toml", "--fit", "youngs_modulus"],
        "there is no column",
    );
    let output = cppr(&calibrate(&["--fit", "centroid_offset_factor", "--json", "-"]));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let estimate = &result["estimates"][0];
    let number = |key: &str| estimate[key].as_f64().unwrap();
    // Made with 1.22.
    assert!((number("value") - 1.22).abs() < number("interval_95"), "{estimate}");
}

#[test]
fn calibrate_never_writes_over_a_robot() {
    let fit =
        ["calibrate", "robots/r1.toml", "--data", "examples/calibration/r1.csv", "--fit", "youngs_modulus"];
    refused(&[&fit[..], &["--output", "robots"]].concat(), "would be overwritten; give another folder");
    refused(&[&fit[..], &["--output", "robots/r2.toml"]].concat(), "this is no folder");
    refused(&[&fit[..], &["robots/../robots/r1.toml", "--output", "x"]].concat(), "rename one");
}

#[test]
fn paper_writes_a_folder_whole_or_refuses_it() {
    let folder = tempfile::tempdir().unwrap();
    let paper = ["paper", "--only", "table1", "--only", "figure07", "--output", "report"];
    for _ in 0..2 {
        assert_eq!(cppr_in(folder.path(), &paper).status.code(), Some(0));
    }
    for name in ["report.html", "numbers.json", "figure07.svg", "figure07.png"] {
        assert!(folder.path().join("report").join(name).exists(), "{name} is missing");
    }
    let other = cppr_in(folder.path(), &["paper", "--only", "table1", "--output", "robots"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("not of an earlier report"));
    assert!(root().join("robots/r1.toml").exists());
    // Somebody's file beside the figures is not swept away with them.
    std::fs::write(folder.path().join("report/notes.txt"), "mine").unwrap();
    assert_eq!(cppr_in(folder.path(), &paper).status.code(), Some(2));
    assert!(folder.path().join("report/notes.txt").exists());
    let nowhere = cppr_in(folder.path(), &["paper", "--only", "table1", "--output", "a/b"]);
    assert!(text(&nowhere.stderr).contains("there is no folder a; make it first"));
    let hidden = |entry: &std::fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
    let left = std::fs::read_dir(folder.path()).unwrap().map(Result::unwrap).filter(hidden).count();
    assert_eq!(left, 0, "a folder on the way was left behind");
    refused(&["paper", "--only", "figure99", "--output", "x"], "there is no page figure99");
}

#[test]
fn export_says_what_it_wrote_and_refuses_what_it_cannot() {
    let folder = tempfile::tempdir().unwrap();
    let export = |extra: &[&str]| cppr_in(folder.path(), &[&["export", "robots/r1.toml"], extra].concat());
    let table = text(&export(&["--tube", "1", "--output", "one.stl"]).stdout);
    for part in ["R1, tube 1, at rest", "closed", "150.000 × 6.000 × 6.000 mm", "1409.967 mm³", "one.stl"]
    {
        assert!(table.contains(part), "{part} is missing in\n{table}");
    }
    assert_eq!(std::fs::metadata(folder.path().join("one.stl")).unwrap().len(), 84 + 50 * 20668);
    let pattern = text(&export(&["--tube", "1", "--output", "one.dxf"]).stdout);
    assert!(pattern.contains("4.2053 mm²"), "{pattern}");
    // A format that the ending does not say, and a file that is there already.
    assert!(export(&["--pull", "3mm", "--format", "glb", "--output", "one.stl.bin"]).status.success());
    assert!(export(&["--tube", "2", "--format", "stl", "--output", "one.stl.bin"]).status.success());
    assert_eq!(export(&["--tension", "1e6N", "--output", "none.glb"]).status.code(), Some(3));
    assert!(!folder.path().join("none.glb").exists());

    let no = |extra: &[&'static str], fragment: &str| {
        refused(&[&["export", "robots/r1.toml"], extra].concat(), fragment);
    };
    no(&["--tube", "9", "--output", "x.stl"], "there is no tube 9; this robot has 1 to 2");
    no(&["--tube", "0", "--output", "x.stl"], "there is no tube 0");
    no(&["--tube", "1", "--output", "x.step"], "the ending says no known format; choose among .stl");
    no(&["--tube", "1", "--output", "x"], "add --format");
    no(&["--tube", "1", "--format", "stl", "--output", "x.obj"], "contradict each other");
    no(&["--tube", "1", "--output", "robots"], "known format");
    no(&["--tube", "1", "--format", "stl", "--output", "robots"], "this is a folder");
    no(&["--tube", "1", "--output", "no/such/x.stl"], "there is no folder");
    no(&["--tube", "1", "--output", "-"], "goes into a file");
    no(&["--tube", "1", "--format", "stl", "--output", "robots/r1.toml"], "would overwrite the robot");
    no(&["--tube", "1", "--pull", "5mm", "--output", "x.stl"], "cannot be used with");
    no(&["--output", "x.dxf"], "add --tube 1");
    no(&["--tip-cap", "1mm", "--output", "x.stl"], "--tube");
    no(&["--tube", "1", "--kerf", "20um", "--output", "x.stl"], "--kerf is for cut patterns");
    no(&["--tube", "1", "--kerf", "6mm", "--output", "x.dxf"], "narrower than a kerf");
    no(&["--tube", "1", "--tip-cap", "1mm", "--output", "x.dxf"], "are no cuts");
    no(&["--tube", "1", "--flange", "8mm", "--output", "x.stl"], "radius and thickness");
    no(&["--tube", "1", "--flange", "2mm,1mm", "--output", "x.stl"], "lies inside the tube");
    for tolerance in ["0mm", "10m", "1e-9mm"] {
        no(&["--tube", "1", "--tolerance", tolerance, "--output", "x.stl"], "a tolerance of");
    }
    no(&["--pull", "5mm", "--tolerance", "0mm", "--output", "x.glb"], "a tolerance of");
    no(&["--pull", "5mm", "--below", "-20mm", "--output", "x.glb"], "the length below the plate is -20 mm");
    no(&["--tube", "1", "--below", "-20mm", "--output", "x.stl"], "the length below the plate is -20 mm");
    no(&["--tube", "1", "--tolerance", "0.01", "--output", "x.stl"], "0.01 has no unit");
    refused(&["export", "robots/childs2.toml", "--output", "x.glb"], "by its stiffness, which has no shape");
    refused(&["export", "robots/childs2.toml", "--tube", "1", "--output", "x.dxf"], "by its stiffness");
    assert!(!root().join("x.stl").exists() && !root().join("x.glb").exists());
}

/// A scenario says the same as options and as an edited robot file.
#[test]
fn scenarios_say_what_options_say() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state.toml");
    let path = file.to_str().unwrap();
    let tip = |arguments: &[&str]| {
        json(&[arguments, &["--samples", "2", "--json", "-"]].concat())["tip_position_m"].clone()
    };
    let text = "stretch = true\ngravity_m_s2 = [0, 0, -9.81]\n[tip]\nforce_N = [0, 0.05, 0]\npoint_mm = [0, 3, 0]\n\
        [[actuator]]\ntube = 2\npull_mm = 3\ntorque_Nmm = 2\n[[point_force]]\nat_mm = 60\nforce_N = [0, 0, 0.02]\n";
    std::fs::write(&file, text).unwrap();
    let options = [
        "solve",
        "robots/r1.toml",
        "--stretch",
        "--gravity",
        "0,0,-1g",
        "--tip-force",
        "0,0.05,0N",
        "--tip-point",
        "0,3,0mm",
        "--pull",
        "3mm",
        "--torque",
        "2Nmm",
        "--point-force",
        "60mm:0,0,0.02N",
    ];
    assert_eq!(tip(&["solve", "robots/r1.toml", "--scenario", path]), tip(&options));

    // A thread is tied where it says, wherever the tip force acts.
    for (tied, point) in [("0,0,0", ""), ("0,2,1", ":0mm:left:0,2,1mm")] {
        let text = format!(
            "[[actuator]]\ntube = 2\npull_mm = 3.0\n[tip]\nforce_N = [0, 0, 0.01]\npoint_mm = [0, 3, 0]\n\
             [[thread]]\ntension_N = 0.5\npulley_mm = [150, -24, 0]\npoint_mm = [{tied}]\n"
        );
        std::fs::write(&file, text).unwrap();
        let thread = format!("0.5N:150,-24,0mm{point}");
        let options =
            ["--pull", "3mm", "--tip-force", "0,0,0.01N", "--tip-point", "0,3,0mm", "--thread", &thread];
        let solved = tip(&[&["solve", "robots/r1.toml"], &options[..]].concat());
        assert_eq!(tip(&["solve", "robots/r1.toml", "--scenario", path]), solved);
    }

    std::fs::write(&file, "[[notches]]\ntube = 1\ndeeper_mm = 0.25\n[[actuator]]\ntube = 2\npull_mm = 6\n")
        .unwrap();
    let robot = std::fs::read_to_string(root().join("robots/r3.toml")).unwrap();
    let deeper = folder.path().join("deeper.toml");
    std::fs::write(&deeper, robot.replace("[8.2, 7.2]", "[8.45, 7.45]")).unwrap();
    let (changed, edited) = (
        tip(&["solve", "robots/r3.toml", "--scenario", path]),
        tip(&["solve", deeper.to_str().unwrap(), "--pull", "6mm"]),
    );
    let same = tip(&["solve", "robots/r3.toml", "--pull", "6mm"]);
    for axis in 0..2 {
        let number = |v: &Value| v[axis].as_f64().unwrap();
        assert!((number(&changed) - number(&edited)).abs() < 1e-12);
        assert!((number(&changed) - number(&same)).abs() > 1e-5);
    }
}

#[test]
fn wrong_scenarios_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state.toml");
    let path = file.to_str().unwrap();
    refused(&["solve", "robots/r1.toml", "--scenario", "none.toml"], "cannot be read");
    refused(&["solve", "robots/r1.toml", "--scenario", path, "--pull", "1mm"], "cannot be used with");
    for (text, fragment) in [
        ("pull_mm = 3", "unknown field"),
        ("[[actuator]]\ntube = 2\npull_mm = 1\ntension_N = 2", "pull_mm or tension_N, not both"),
        ("[[actuator]]\ntube = 2\nrotate_deg = 1\ntorque_Nmm = 2", "rotate_deg or torque_Nmm, not both"),
        ("[[actuator]]\ntube = 1", "tube 1 is no follower"),
        ("[[actuator]]\ntube = 2\n[[actuator]]\ntube = 2", "tube 2 is given twice"),
        (
            "[[actuator]]\ntube = 2\npull_mm = nan",
            "state.toml: the actuator of tube 2 is given a value that is not finite",
        ),
        ("[[actuator]]\ntube = nan", "expected the number of a tube"),
        ("[tip]\nforce_N = [0, inf, 0]", "state.toml: a wrench has a component"),
        ("[[point_force]]\nat_mm = 1000\nforce_N = [0, 1, 0]", "state.toml: a load acts at 1000.000 mm"),
        ("[[actuator]]\ntube = 2\npull_mm = 5000", "Check the unit"),
        ("[[notches]]\ntube = 1\ndeeper_mm = 50", "leaves nothing of a tube"),
        ("[[notches]]\ntube = 1\ndeeper_mm = nan", "deeper_mm is NaN"),
        ("[[notches]]\ntube = 7\ndeeper_mm = 0.1", "there is no tube 7"),
        ("[tip]\nforce_N = [1, 2]", "line 2"),
        ("formulation = \"best\"", "consistent"),
        ("a = ", "line 1"),
    ] {
        std::fs::write(&file, text).unwrap();
        refused(&["solve", "robots/r1.toml", "--scenario", path], fragment);
    }
    std::fs::write(&file, "gravity_m_s2 = [0, 0, -9.81]\n[[notches]]\ntube = 1\ndeeper_mm = 0.1\n").unwrap();
    refused(&["solve", "robots/childs3.toml", "--scenario", path], "has no notches to change");
    std::fs::write(&file, "gravity_m_s2 = [0, 0, -9.81]").unwrap();
    refused(&["solve", "robots/childs3.toml", "--scenario", path], "has no mass");
    std::fs::write(&file, "#".repeat(100_000)).unwrap();
    refused(&["solve", "robots/r1.toml", "--scenario", path], "64 KiB");
}
