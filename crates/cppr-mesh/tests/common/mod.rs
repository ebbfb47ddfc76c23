//! Robots for tests, written as robot files.
// Not every test file needs both.
#![allow(dead_code)]

use cppr_io::RobotFile;
use std::path::Path;

/// A shipped robot.
pub fn shipped(name: &str) -> RobotFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(format!("{name}.toml"));
    cppr_io::robot_file::read(path).unwrap()
}

/// A robot of one tube, 60 mm long; `tube` are the lines under `[[tube]]`.
pub fn single(tube: &str) -> RobotFile {
    cppr_io::robot_file::parse(&format!(
        "name = \"T\"\nlength_mm = 60\n[material]\nyoungs_modulus_GPa = 5\npoissons_ratio = 0.3\ndensity_kg_m3 = 1000\n[[tube]]\n{tube}"
    ))
    .unwrap_or_else(|problems| panic!("{problems}\n{tube}"))
}
