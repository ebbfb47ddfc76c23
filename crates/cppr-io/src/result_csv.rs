//! The fields along the robot as CSV: one row per section, the unit in each column's name.

use crate::contact_record::column;
use cppr::analysis::{Section, Shape, TubeSection};
use cppr::bundle::Contact;
use std::fmt::Write;

const SECTION: [&str; 5] = ["x_m", "centre_x_m", "centre_y_m", "centre_z_m", "energy_density_J_m"];

/// Per tube, with `tube1_` and so on before it.
const TUBE: [&str; 15] = [
    "abscissa_m",
    "centroid_x_m",
    "centroid_y_m",
    "centroid_z_m",
    "face_to_face_rate",
    "twist_rad_m",
    "curvature_y_1_m",
    "curvature_z_1_m",
    "stretch",
    "torque_Nm",
    "moment_y_Nm",
    "moment_z_Nm",
    "axial_force_N",
    "shear_y_N",
    "shear_z_N",
];

fn section(s: &Section) -> [f64; SECTION.len()] {
    [s.label, s.centre.x, s.centre.y, s.centre.z, s.energy_density]
}

fn tube(t: &TubeSection) -> [f64; TUBE.len()] {
    [
        t.abscissa,
        t.centroid.x,
        t.centroid.y,
        t.centroid.z,
        t.rate,
        t.strain.x,
        t.strain.y,
        t.strain.z,
        t.stretch,
        t.moment.x,
        t.moment.y,
        t.moment.z,
        t.force.x,
        t.force.y,
        t.force.z,
    ]
}

/// The whole table, its header first.
///
/// Columns are named as the keys of [`crate::result`]; each tube's begin with `tube1_`, `tube2_` and so on. The last ones are the forces with which
/// neighbours press on each other.
#[must_use]
pub fn csv(shape: &Shape, contact: &Contact) -> String {
    let tubes = shape.sections.first().map_or(0, |s| s.tubes.len());
    let mut text = SECTION.join(",");
    for number in 1..=tubes {
        for column in TUBE {
            let _ = write!(text, ",tube{number}_{column}");
        }
    }
    for pair in &contact.pairs {
        let _ = write!(text, ",{}", column(pair));
    }
    text.push('\n');
    for s in &shape.sections {
        let numbers = section(s).into_iter().chain(s.tubes.iter().flat_map(tube));
        for (column, number) in numbers.enumerate() {
            let comma = if column == 0 { "" } else { "," };
            let _ = write!(text, "{comma}{number}");
        }
        for pair in &contact.pairs {
            let pressed = s.tubes.get(pair.outer).and_then(|tube| pair.at(tube.abscissa));
            let _ = write!(text, ",{}", pressed.map_or(String::new(), |force| force.norm().to_string()));
        }
        text.push('\n');
    }
    text
}
