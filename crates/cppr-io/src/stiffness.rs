//! `[tube.stiffness]`: a tube whose stiffness is given instead of its geometry.

use crate::cursor::Cursor;
use crate::problems::Collector;
use crate::profile_value::{Direction, read};
use crate::quantity::{AXIAL, MASS, OFFSET, Quantity, STIFFNESS};
use cppr::design::{Profile, StiffnessTube};

const KEYS: [&str; 8] = [
    "centroid_offset_mm",
    "bending_y_Nmm2",
    "bending_z_Nmm2",
    "torsion_Nmm2",
    "axial_N",
    "mass_per_length_g_m",
    "opening_deg",
    "twist_deg",
];

/// Reads the stiffness of tube `tube` (from 1); `length` (m) may be unknown after a problem.
pub(crate) fn read_stiffness(
    parent: &Cursor<'_, '_>,
    tube: usize,
    length: Option<f64>,
    factor: Option<f64>,
    out: &mut Collector,
) -> Option<StiffnessTube> {
    let cursor = parent.child("stiffness", &KEYS, out)?;
    let mut required = |key: &'static str, quantity: &Quantity| -> Option<Profile> {
        let help = format!("Write {key} = {}.", quantity.example);
        let entry = cursor.require(key, &help, out)?;
        read(&entry, quantity, false, length, out)?.plain(out)
    };
    let centroid_offset = required("centroid_offset_mm", &OFFSET);
    let bending_y = required("bending_y_Nmm2", &STIFFNESS);
    let bending_z = required("bending_z_Nmm2", &STIFFNESS);
    let torsion = required("torsion_Nmm2", &STIFFNESS);
    let mut optional = |key: &'static str, quantity: &Quantity| -> Option<Profile> {
        read(&cursor.get(key)?, quantity, false, length, out)?.plain(out)
    };
    let axial = optional("axial_N", &AXIAL);
    let mass_per_length = optional("mass_per_length_g_m", &MASS).unwrap_or_else(|| Profile::constant(0.0));
    let direction = Direction::read(&cursor, tube, false, length, out).build(&[], out);
    Some(StiffnessTube {
        centroid_offset: centroid_offset?,
        direction: direction?,
        bending_y: bending_y?,
        bending_z: bending_z?,
        torsion: torsion?,
        axial,
        mass_per_length,
        centroid_offset_factor: factor?,
    })
}
