//! Results as JSON (everything, units in the keys) and CSV (fields along the robot).

use cppr::analysis::{Section, Shape};
use cppr::design::Robot;
use cppr::solve::{Actuator, Drive, Equilibrium, Formulation, Status};
use cppr::statics::{Frame, Loads, RotationKnob, Station};
use cppr::{Matrix3, Vector3};
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Raised whenever a key of the JSON changes its meaning or goes away.
const SCHEMA_VERSION: u32 = 1;

fn vector(v: &Vector3<f64>) -> Value {
    json!([v.x, v.y, v.z])
}

fn rows(m: &Matrix3<f64>) -> Value {
    let row = |i: usize| json!([m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
    json!([row(0), row(1), row(2)])
}

fn head(robot: &Robot, found: &Equilibrium) -> Map<String, Value> {
    let status = match found.status {
        Status::Converged => "converged",
        Status::Unstable => "unstable",
        Status::NotConverged(_) => "not_converged",
    };
    let formulation = match found.settings.formulation {
        Formulation::Consistent => "consistent",
        Formulation::Printed => "printed",
    };
    let resolution = found.settings.resolution;
    let value = json!({
        "schema": "cppr/equilibrium",
        "schema_version": SCHEMA_VERSION,
        "robot": { "name": robot.design().name, "length_m": robot.length(), "tubes": robot.tube_count() },
        "command": command(found),
        "formulation": formulation,
        "resolution": {
            "twist_modes": resolution.twist,
            "bending_y_modes": resolution.bending_y,
            "bending_z_modes": resolution.bending_z,
            "angle_modes": resolution.angle,
            "stretch_modes": resolution.stretch,
            "nodes": resolution.nodes,
        },
        "status": status,
        "status_text": crate::table::status(found),
        "statistics": {
            "newton_iterations": found.statistics.iterations,
            "evaluations": found.statistics.evaluations,
            "load_steps": found.statistics.load_steps,
            "largest_scaled_residual": found.residual,
        },
    });
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

fn command(found: &Equilibrium) -> Value {
    let knob = match found.command.knob {
        RotationKnob::Base => "base",
        RotationKnob::RelativeAngle => "relative_angle",
    };
    let actuators: Vec<Value> = found
        .command
        .actuators
        .iter()
        .enumerate()
        .map(|(f, Actuator { push_pull, rotation })| {
            let (key, value) = match push_pull {
                Drive::Motion(v) => ("pull_m", v),
                Drive::Effort(v) => ("tension_N", v),
            };
            let (turn_key, turn) = match rotation {
                Drive::Motion(v) => ("rotation_rad", v),
                Drive::Effort(v) => ("torque_Nm", v),
            };
            json!({ "tube": f + 2, key: value, turn_key: turn })
        })
        .collect();
    json!({ "actuators": actuators, "rotation_means": knob, "loads": loads(&found.command.loads) })
}

fn loads(loads: &Loads) -> Value {
    let wrenches: Vec<Value> = loads
        .wrenches
        .iter()
        .map(|w| {
            let at = match w.station {
                Station::Tip => json!("tip"),
                Station::Label(label) => json!(label),
            };
            let frame = if w.frame == Frame::World { "base" } else { "section" };
            json!({ "at_m": at, "frame": frame, "force_N": vector(&w.force), "moment_Nm": vector(&w.moment),
                "point_m": vector(&w.point) })
        })
        .collect();
    let distributed: Vec<Value> = loads
        .distributed
        .iter()
        .map(|d| json!({ "from_m": d.from, "to_m": d.to, "force_N_m": vector(&d.force) }))
        .collect();
    let threads: Vec<Value> = loads
        .threads
        .iter()
        .map(|t| {
            json!({ "tension_N": t.tension, "pulley_m": vector(&t.pulley), "radius_m": t.radius,
                "side": if t.left { "left" } else { "right" }, "point_m": vector(&t.point) })
        })
        .collect();
    json!({ "wrenches": wrenches, "distributed": distributed, "threads": threads,
        "gravity_m_s2": loads.gravity.as_ref().map(vector) })
}

/// The status where there is nothing else to say.
pub fn failure(robot: &Robot, found: &Equilibrium) -> String {
    pretty(&Value::Object(head(robot, found)))
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

/// Everything.
pub fn json(robot: &Robot, found: &Equilibrium, shape: &Shape, margin: Option<f64>) -> String {
    let mut map = head(robot, found);
    let mut put = |key: &str, value: Value| {
        map.insert(key.into(), value);
    };
    if let Some(tip) = shape.sections.last() {
        put("tip_position_m", vector(&tip.centre));
        put("tip_rotation", rows(&tip.rotation));
    }
    let actuators: Vec<Value> = found
        .actuators
        .iter()
        .enumerate()
        .map(|(f, a)| {
            json!({ "tube": f + 2, "pull_m": a.motion, "rotation_rad": a.rotation, "tension_N": a.tension,
                "torque_Nm": a.torque })
        })
        .collect();
    put("actuators", Value::Array(actuators));
    put("elastic_energy_J", json!(found.elastic_energy));
    put("margin_to_instability", json!(margin));
    put("sections", Value::Array(shape.sections.iter().map(section).collect()));
    pretty(&Value::Object(map))
}

fn section(section: &Section) -> Value {
    let tubes: Vec<Value> = section
        .tubes
        .iter()
        .map(|t| {
            json!({
                "abscissa_m": t.abscissa,
                "centroid_m": vector(&t.centroid),
                "rotation": rows(&t.rotation),
                "face_to_face_rate": t.rate,
                "twist_rad_m": t.strain.x,
                "curvature_y_1_m": t.strain.y,
                "curvature_z_1_m": t.strain.z,
                "stretch": t.stretch,
                "torque_Nm": t.moment.x,
                "moment_y_Nm": t.moment.y,
                "moment_z_Nm": t.moment.z,
                "axial_force_N": t.force.x,
                "shear_y_N": t.force.y,
                "shear_z_N": t.force.z,
            })
        })
        .collect();
    json!({
        "x_m": section.label,
        "centre_m": vector(&section.centre),
        "rotation": rows(&section.rotation),
        "leader_curvature_1_m": vector(&section.curvature),
        "follower_angles_rad": section.angles,
        "energy_density_J_m": section.energy_density,
        "tubes": tubes,
    })
}

/// One row per section.
pub fn csv(shape: &Shape) -> String {
    let tubes = shape.sections.first().map_or(0, |s| s.tubes.len());
    let mut text = String::from("x_m,centre_x_m,centre_y_m,centre_z_m,energy_density_J_m");
    for t in 1..=tubes {
        for key in [
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
        ] {
            let _ = write!(text, ",tube{t}_{key}");
        }
    }
    text.push('\n');
    for s in &shape.sections {
        let _ = write!(text, "{},{},{},{},{}", s.label, s.centre.x, s.centre.y, s.centre.z, s.energy_density);
        for t in &s.tubes {
            let numbers = [
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
            ];
            for number in numbers {
                let _ = write!(text, ",{number}");
            }
        }
        text.push('\n');
    }
    text
}
