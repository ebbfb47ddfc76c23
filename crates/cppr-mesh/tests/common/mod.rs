//! Robots for tests, written as robot files, and where a mesh has material.
// Not every test file needs all.
#![allow(dead_code)]

use cppr_io::RobotFile;
use cppr_mesh::Mesh;
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

/// Crossings of a ray with the surface, counted: odd inside.
pub fn inside(mesh: &Mesh, point: [f64; 3]) -> bool {
    // Along a direction that meets no edge head-on.
    let direction = cppr::Vector3::new(0.123, 0.777, 0.617).normalize();
    let origin = cppr::Vector3::from(point);
    let crossings = mesh
        .triangles
        .iter()
        .filter(|t| {
            let [a, b, c] = t.map(|v| cppr::Vector3::from(mesh.positions[v as usize]) - origin);
            let volumes = [a.cross(&b), b.cross(&c), c.cross(&a)].map(|n| n.dot(&direction));
            let same = volumes.iter().all(|v| *v > 0.0) || volumes.iter().all(|v| *v < 0.0);
            let normal = (b - a).cross(&(c - a));
            same && a.dot(&normal) * direction.dot(&normal) > 0.0
        })
        .count();
    crossings % 2 == 1
}
