//! Binary messages: a JSON head and 32-bit floats.
//!
//! | bytes | what |
//! |---|---|
//! | 4 | length of the head, little-endian, a multiple of 4 |
//! | that many | the head: JSON, padded with spaces |
//! | the rest | floats, little-endian |
//!
//! The floats of a pose are, section by section from the baseplate to the tip and tube by tube, the [`COLUMNS`].
//! Those of a mesh are positions and normals of its vertices (x, y, z; mm), then, as bits of whole numbers, three vertices for each
//! triangle.

use cppr::Matrix3;
use cppr::analysis::Shape;
use cppr::design::Robot;
use cppr_mesh::Shaded;
use nalgebra::{Rotation3, UnitQuaternion};
use serde::Serialize;

/// A message to the page.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// JSON.
    Text(String),
    /// As above.
    Binary(Vec<u8>),
}

/// Sections of a pose.
pub const SECTIONS: usize = 97;

/// Values of one tube at one section. Lengths in mm, rates per m, forces in N, moments in N mm. `q` is
/// the rotation of the tube's material from rest: the section's own axes turned back by its direction φ.
pub const COLUMNS: [&str; 21] = [
    "abscissa",
    "x",
    "y",
    "z",
    "qx",
    "qy",
    "qz",
    "qw",
    "centroid_x",
    "centroid_y",
    "centroid_z",
    "twist",
    "curvature_y",
    "curvature_z",
    "stretch",
    "offset",
    "direction",
    "torque",
    "moment_y",
    "moment_z",
    "axial_force",
];

/// Head and floats as one message.
#[must_use]
pub fn encode(head: &impl Serialize, floats: &[f32]) -> Vec<u8> {
    // A head is made of finite numbers and strings; where it were not, an empty one says nothing wrong.
    let mut head = serde_json::to_vec(head).unwrap_or_else(|_| b"{}".to_vec());
    head.resize(head.len().next_multiple_of(4), b' ');
    let length = u32::try_from(head.len()).unwrap_or(0);
    let mut bytes = Vec::with_capacity(4 + head.len() + 4 * floats.len());
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(&head);
    bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
    bytes
}

/// The floats of a pose.
#[must_use]
pub fn floats(robot: &Robot, shape: &Shape) -> Vec<f32> {
    let mut out = Vec::with_capacity(shape.sections.len() * robot.tube_count() * COLUMNS.len());
    #[allow(clippy::cast_possible_truncation, reason = "for drawing")]
    let mut push = |values: &[f64]| out.extend(values.iter().map(|&v| v as f32));
    for section in &shape.sections {
        for (index, tube) in section.tubes.iter().enumerate() {
            let fields = robot.fields_at(index, tube.abscissa);
            let turn = Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), -fields.direction);
            let material: Matrix3<f64> = tube.rotation * turn.matrix();
            let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(material));
            push(&[tube.abscissa * 1e3]);
            push((section.centre * 1e3).as_slice());
            push(q.coords.as_slice());
            push((tube.centroid * 1e3).as_slice());
            push(tube.strain.as_slice());
            push(&[tube.stretch, fields.centroid_offset * 1e3, fields.direction]);
            push((tube.moment * 1e3).as_slice());
            push(&[tube.force.x]);
        }
    }
    out
}

/// The body of a tube, counted from 0; `coarse` is for pictures in haste.
#[must_use]
pub fn mesh(tube: usize, coarse: bool, body: &Shaded) -> Vec<u8> {
    let head = serde_json::json!({
        "kind": "mesh", "tube": tube, "coarse": coarse, "vertices": body.positions.len(), "triangles": body.triangles.len(),
    });
    #[allow(clippy::cast_possible_truncation, reason = "for drawing")]
    let floats =
        |list: &[[f64; 3]], unit: f64| list.iter().flatten().map(|v| (v * unit) as f32).collect::<Vec<_>>();
    let mut all = floats(&body.positions, 1e3);
    all.extend(floats(&body.normals, 1.0));
    all.extend(body.triangles.iter().flatten().map(|&v| f32::from_bits(v)));
    encode(&head, &all)
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, SECTIONS, encode, floats};

    use cppr::design::Robot;
    use cppr::solve::{Command, Solver};

    #[test]
    fn heads_are_padded() {
        let bytes = encode(&serde_json::json!({"id": 7}), &[1.5]);
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!(length % 4, 0);
        let head: serde_json::Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!(head["id"], 7);
        assert_eq!(bytes[4 + length..], 1.5_f32.to_le_bytes());
    }

    /// The material frame carries a point of the tube at rest to where the section has it: for the centroid,
    /// which the shape gives by itself, on a robot whose pattern winds.
    #[test]
    fn frames_carry_the_centroid() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/helicoid.toml");
        let robot = Robot::from_design(cppr_io::robot_file::read(path).unwrap().design).unwrap();
        let mut solver = Solver::new(&robot);
        let command = Command::pull(&[6e-3]);
        let found = solver.solve(&command).unwrap();
        let shape = solver.shape(&found, SECTIONS);
        let values = floats(&robot, &shape);
        assert_eq!(values.len(), SECTIONS * 2 * COLUMNS.len());
        let mut bent = 0.0_f32;
        for row in values.chunks(COLUMNS.len()) {
            let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
                row[7], row[4], row[5], row[6],
            ));
            let rest = nalgebra::Vector3::new(0.0, row[15] * row[16].cos(), row[15] * row[16].sin());
            let carried = q * rest + nalgebra::Vector3::new(row[1], row[2], row[3]);
            let centroid = nalgebra::Vector3::new(row[8], row[9], row[10]);
            assert!((carried - centroid).norm() < 1e-3, "{carried} {centroid}");
            bent = bent.max(row[4].abs().max(row[5].abs()).max(row[6].abs()));
        }
        assert!(bent > 0.2, "the robot hardly moves: {bent}");
    }
}
