//! Tables that people bring: with the commas of their country, and with numbers in another unit.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{cppr, json, refused, root, text};
use serde_json::Value;

const FACTOR: [&str; 2] = ["--fit", "centroid_offset_factor"];

fn data(name: &str) -> String {
    format!("crates/cppr-cli/tests/data/{name}")
}

fn calibrated(table: &str) -> Value {
    json(&[&["calibrate", "robots/r1.toml", "--data", table, "--json", "-"], &FACTOR[..]].concat())
}

#[test]
fn semicolons_with_decimal_commas_say_what_commas_with_points_say() {
    let (commas, folder) = (data("semicolon_calibration.csv"), tempfile::tempdir().unwrap());
    let own = std::fs::read_to_string(root().join(&commas)).unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, own.replace(',', ".").replace(';', ",")).unwrap();
    let (one, other) = (calibrated(&commas), calibrated(file.to_str().unwrap()));
    assert_eq!(one, other);
    let factor = one["estimates"][0]["value"].as_f64().unwrap();
    assert!((factor - 1.226).abs() < 0.001, "{factor}");

    let shape = std::fs::read_to_string(root().join("examples/shapes/r3.csv")).unwrap();
    std::fs::write(&file, shape.replace(',', ";").replace('.', ",")).unwrap();
    let bounds = ["--pull-bounds", "0..10mm", "--rotate-bounds", "0..60deg", "--json", "-"];
    let matched =
        |points: &str| json(&[&["match", "robots/r3.toml", "--points", points], &bounds[..]].concat());
    let (one, other) = (matched("examples/shapes/r3.csv"), matched(file.to_str().unwrap()));
    assert_eq!(one["inputs"], other["inputs"]);
}

#[test]
fn decimal_commas_between_commas_are_refused_once_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    let path = file.to_str().unwrap();
    std::fs::write(&file, "# camera 1\n\nx_mm,y_mm,z_mm\n14,4,-6,2,-2,7\n28,6,-8,7,-4,4\n").unwrap();
    let output = cppr(&["match", "robots/r3.toml", "--points", path]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("line 4: 6 fields here, but line 3 names 3 fields"), "{message}");
    assert_eq!(message.matches("decimal points").count(), 1, "{message}");
    std::fs::write(&file, "# a\n# b\n# c\nx_m;y_m;z_m\n0;0;0\n").unwrap();
    refused(&["match", "robots/r3.toml", "--points", path], "line 4: the column x_m is not known here");
    std::fs::write(&file, "# a\n# b\n# c\npull2_mm;x_m\n0;0\n").unwrap();
    refused(
        &[&["calibrate", "robots/r1.toml", "--data", path], &FACTOR[..]].concat(),
        "line 4: there is no column x_m",
    );
}

#[test]
fn points_in_another_unit_are_refused() {
    let metres = data("metres_calibration.csv");
    refused(
        &[&["calibrate", "robots/r1.toml", "--data", &metres], &FACTOR[..]].concat(),
        "line 2: this point lies 0.138 mm from the baseplate, where the robot would be at",
    );
    let points = data("ten_times_points.csv");
    refused(
        &["match", "robots/r3.toml", "--points", &points],
        "point 2 lies 288.266 mm from the baseplate, out of reach of a robot 150.000 mm long",
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    let path = file.to_str().unwrap();
    let bounds = ["--pull-bounds", "0..10mm", "--rotate-bounds", "0..60deg"];
    std::fs::write(&file, "x_mm,y_mm,z_mm\n0.0286,-0.0028,0\n0.0557,-0.0125,0\n0.1066,-0.0422,0\n").unwrap();
    refused(
        &[&["match", "robots/r3.toml", "--points", path], &bounds[..]].concat(),
        "all points lie within 0.115 mm of the baseplate's centre",
    );
    std::fs::write(&file, "pull2_mm,tip_force_y_N,x_mm,y_mm,z_mm\n5,0,114,-77,0\n3,196,135,-50,0\n").unwrap();
    refused(
        &[&["calibrate", "robots/r1.toml", "--data", path], &FACTOR[..]].concat(),
        "line 3: The tip force is 196 N",
    );
    std::fs::write(&file, "pull2_mm,x_mm,y_mm,z_mm\n5,1144,-770,0\n").unwrap();
    refused(
        &[&["calibrate", "robots/r1.toml", "--data", path], &FACTOR[..]].concat(),
        "line 2: the point lies 1378.998 mm from the baseplate, out of reach of R1",
    );
}
