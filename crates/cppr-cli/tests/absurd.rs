//! Absurd robots, scenarios and commands, through every sub-command that takes them: a sentence that says what is wrong, where, and
//! what to do; exit code 2, or 3 where there is no equilibrium; nothing written.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, root, text};
use std::path::Path;

/// What stands in r1.toml, what is put there instead, and what must be said: the line, and what to do.
const ROBOTS: [(&str, &str, &str); 30] = [
    (
        "length_mm = 150.0",
        "length_mm = 0.15",
        ":19: tube 1, outer_radius_mm: a radius of 3.0 mm is larger than the tube is long",
    ),
    ("length_mm = 150.0", "length_mm = 150000.0", ":7: length_mm: 150000.0 mm is more than any robot has"),
    ("length_mm = 150.0", "length_mm = -150.0", ":7: length_mm: a length cannot be negative"),
    ("length_mm = 150.0", "length_mm = 0", ":7: length_mm: a length cannot be zero"),
    ("length_mm = 150.0", "length_mm = inf", ":7: length_mm: a length must be a finite number"),
    ("length_mm = 150.0", "length_mm = \"150 mm\"", "Write length_mm = 150; the unit is in the key"),
    ("length_mm = 150.0", "length_m = 0.15", "Write length_mm = 150.0"),
    ("length_mm = 150.0", "", "length_mm: this key is missing"),
    (
        "length_mm = 150.0",
        "length_mm = 150.0\nlength_mm = 15.0",
        "this key is there already. Keep one of the two",
    ),
    ("youngs_modulus_GPa = 5.39", "youngs_modulus_GPa = 0", "an elastic modulus cannot be zero"),
    ("youngs_modulus_GPa = 5.39", "youngs_modulus_GPa = -5.39", "an elastic modulus cannot be negative"),
    ("youngs_modulus_GPa = 5.39", "youngs_modulus_GPa = nan", "must be a finite number"),
    (
        "youngs_modulus_GPa = 5.39",
        "youngs_modulus_GPa = 5.39e9",
        "Write it in gigapascals, such as 5.39 for 5390 MPa",
    ),
    ("poissons_ratio = 0.35", "poissons_ratio = 0.7", "Poisson's ratio lies between -1 and 0.5"),
    ("density_kg_m3 = 1240", "density_kg_m3 = 1.24", "1.24 g/cm³ is 1240 kg/m³"),
    ("allowable_strain_percent = 1.5", "allowable_strain_percent = 0", "Write a number above 0, such as 1.5"),
    ("allowable_strain_percent = 1.5", "allowable_strain_percent = 1500", "A strain of 0.015 is 1.5 percent"),
    ("centroid_offset_factor = 1.27", "centroid_offset_factor = 1e6", "stays near 1"),
    ("outer_radius_mm = 3.0", "outer_radius_mm = 3e9", "is more than any robot has"),
    ("inner_radius_mm = 2.0", "inner_radius_mm = 3.0", "leaves no wall"),
    ("inner_radius_mm = 2.0", "inner_radius_mm = 2.9999999", "thinner wall than any robot has"),
    (
        "outer_radius_mm = 1.5",
        "outer_radius_mm = 2.5",
        "does not fit into the bore of tube 1 (2.0 mm). Write an outer radius of at most 2.0",
    ),
    ("depth_mm = 5.0", "depth_mm = 7.0", "deeper than the tube is wide"),
    ("depth_mm = 5.0", "depth_mm = 6.0", "cuts the tube through: nothing is left"),
    ("depth_mm = 5.0", "depth_mm = 5.9999999", "leaves less of the tube than any robot has (0.001 mm)"),
    ("depth_mm = 5.0", "depth_mm = -5.0", "a notch depth cannot be negative"),
    ("tooth_mm = 5.0", "tooth_mm = 500.0", "the pattern is longer than the tube"),
    ("tooth_mm = 5.0", "tooth_mm = 1e-9", "is less than any robot has (0.001 mm)"),
    ("opening_deg = 180.0", "opening_deg = 1e9", "more than a hundred turns; write degrees"),
    ("below_plate = \"plain\"", "below_plate = \"perhaps\"", "Known are \"plain\" and \"continued\""),
];

/// Every sub-command that reads a robot, and where it would write.
fn readers<'a>(robot: &'a str, output: &'a str) -> Vec<Vec<&'a str>> {
    vec![
        vec!["solve", robot, "--pull", "5mm", "--json", output],
        vec!["limits", robot, "--json", output],
        vec!["continue", robot, "--along", "pull", "--to", "5mm", "--csv", output],
        vec!["sweep", robot, "--pull", "-1..1mm:3", "--output", output],
        vec!["reach", robot, "--position", "140,-30,0mm", "--json", output],
        vec!["match", robot, "--points", "examples/shapes/r3.csv", "--json", output],
        vec!["sense", robot, "--measured-tension", "1N", "--json", output],
        vec!["derivatives", robot, "--json", output],
        vec!["section", robot, "--csv", output],
        vec!["check", robot],
        vec![
            "calibrate",
            robot,
            "--data",
            "examples/calibration/r1.csv",
            "--fit",
            "youngs_modulus",
            "--json",
            output,
        ],
        vec!["export", robot, "--format", "glb", "--output", output],
        vec!["view", robot, "--sweep", "pull=-1..1mm:3", "--save", output],
    ]
}

#[track_caller]
fn says(arguments: &[&str], code: i32, fragment: &str) {
    let output = cppr(arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.contains(fragment), "{arguments:?}: {message}");
    assert!(!message.contains("panicked") && !message.contains("NaN"), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?} prints {}", text(&output.stdout));
}

fn refused_by_all(robot: &Path, words: &str) {
    let output = robot.with_file_name("output.csv");
    let (robot, output) = (robot.to_str().unwrap(), output.to_str().unwrap());
    for arguments in readers(robot, output) {
        says(&arguments, 2, words);
        says(&arguments, 2, robot);
        assert!(!Path::new(output).exists(), "{arguments:?} wrote something");
    }
    assert_eq!(std::fs::read_dir(Path::new(robot).parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn robots_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    let good = std::fs::read_to_string(root().join("robots/r1.toml")).unwrap();
    for (old, new, words) in ROBOTS {
        assert!(good.contains(old), "{old}");
        std::fs::write(&file, good.replacen(old, new, 1)).unwrap();
        refused_by_all(&file, words);
    }
}

#[test]
fn files_that_are_no_robots() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    for (bytes, words) in [
        (Vec::new(), "the file is empty"),
        (vec![0, 1, 0xff, 0xfe], "not UTF-8 text"),
        (vec![b'#'; 2_000_000], "larger than 1 MiB"),
        (b"[[tube]]\n".repeat(300), "this key is missing"),
        (b"name = ".to_vec(), ":1:"),
    ] {
        std::fs::write(&file, bytes).unwrap();
        refused_by_all(&file, words);
    }
    std::fs::remove_file(&file).unwrap();
    std::fs::create_dir(&file).unwrap();
    refused_by_all(&file, "cannot be read");
}

#[test]
fn no_load_is_too_large_to_be_named() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("rows.csv");
    let table = table.to_str().unwrap();
    for (arguments, words) in [
        (&["solve", "robots/r1.toml", "--tip-force", "0,1e9,0N"][..], "The tip force is 1.0e9 N"),
        (&["limits", "robots/r1.toml", "--tension", "1e9N"], "The tension of tube 2 is 1.0e9 N"),
        (
            &["derivatives", "robots/r3.toml", "--tip-moment", "0,0,1e9Nm", "--tension", "1e9N"],
            "The tip moment is 1.0e12 N mm",
        ),
        (
            &["export", "robots/r1.toml", "--output", "x.glb", "--tip-force", "0,1e9,0N"],
            "The tip force is 1.0e9 N",
        ),
        (
            &["continue", "robots/r1.toml", "--along", "pull", "--to", "5mm", "--tip-force", "0,1e9,0N"],
            "The tip force is 1.0e9 N",
        ),
        (
            &["sweep", "robots/r1.toml", "--tension", "1e8..1e9N:3", "--output", table],
            "The tension of tube 2 is 1.0e8 N",
        ),
        (
            &["view", "robots/r1.toml", "--sweep", "tension=1e8..1e9N:3", "--save", "x.html"],
            "sweep a smaller range",
        ),
    ] {
        says(arguments, 3, words);
    }
    assert!(!root().join("x.glb").exists() && !root().join("x.html").exists());
}

#[test]
fn where_a_search_cannot_begin_the_unit_is_named() {
    says(
        &["sense", "robots/r1.toml", "--measured-position", "140,30,0m"],
        2,
        "a robot of 150 mm cannot be 143178.210633 mm away from its base. Check the unit",
    );
    says(
        &["reach", "robots/r1.toml", "--position", "100,0,0mm", "--tip-force", "0,1e9,0N"],
        2,
        "The tip force is 1.0e9 N; on this robot about 0.27 N bends by 90°",
    );
}
