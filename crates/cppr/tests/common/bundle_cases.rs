//! The cases of an independent program for any bundle, as designs and commands.

use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{BundleDesign, Part, TubeParts};
use cppr::design::{Profile, StiffnessTube};
use cppr::solve::Drive;
use cppr::statics::Loads;
use serde_json::Value;

pub fn number(v: &Value, key: &str) -> f64 {
    v[key].as_f64().unwrap_or(0.0)
}

pub fn list(v: &Value, key: &str) -> Vec<f64> {
    v[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap_or(0.0)).collect()
}

pub fn cases() -> Vec<Value> {
    serde_json::from_str(include_str!("../data/general_bundles.json")).unwrap()
}

pub fn design(case: &Value) -> BundleDesign {
    let tube = |tube: &Value| {
        let mut from = 0.0;
        let part = |part: &Value| {
            let to = number(part, "to_mm");
            let length = 1e-3 * (to - from);
            from = to;
            let stiffness = |key| Profile::constant(1e-6 * number(part, key));
            let body = StiffnessTube {
                centroid_offset: Profile::constant(1e-3 * number(part, "centroid_offset_mm")),
                direction: Profile::constant(number(part, "centroid_direction_deg").to_radians()),
                bending_y: stiffness("bending_y_Nmm2"),
                bending_z: stiffness("bending_z_Nmm2"),
                torsion: stiffness("torsion_Nmm2"),
                axial: None,
                mass_per_length: Profile::constant(0.0),
                centroid_offset_factor: 1.0,
            };
            assert!(number(part, "rest_curvature_y_1_m") == 0.0 && number(part, "twist_deg_per_m") == 0.0);
            let direction = number(part, "centroid_direction_deg").to_radians();
            Part {
                length,
                body: body.into(),
                rest_curvature: number(part, "rest_curvature_z_1_m"),
                rest_direction: direction,
            }
        };
        TubeParts { parts: tube.as_array().unwrap().iter().map(part).collect(), shaft: None }
    };
    let joint = |joint: &Value| {
        let places = joint.as_object().unwrap().iter();
        places.map(|(tube, at)| (tube.parse::<usize>().unwrap() - 1, 1e-3 * at.as_f64().unwrap())).collect()
    };
    BundleDesign {
        name: case["name"].as_str().unwrap().into(),
        tubes: case["tubes"].as_array().unwrap().iter().map(tube).collect(),
        joints: case["joints"].as_array().unwrap().iter().map(joint).collect(),
    }
}

pub fn command(case: &Value) -> BundleCommand {
    let drive = |a: &Value| TubeDrive {
        translation: Drive::Motion(number(a, "abscissa_at_plate_m")),
        rotation: Drive::Motion(number(a, "rotation_rad")),
    };
    let force = Vector3::from_vec(list(case, "tip_force_N"));
    BundleCommand {
        drives: case["actuators"].as_array().unwrap().iter().map(drive).collect(),
        loads: if force.norm() > 0.0 { Loads::tip_force(force) } else { Loads::none() },
    }
}
