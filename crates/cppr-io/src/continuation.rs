//! Traced paths of equilibria as JSON and CSV: SI units, the unit in every key.

// The keys are the fields' names, and a unit such as N is a capital.
#![allow(non_snake_case)]

use crate::result::{
    ActuatorRecord, CommandRecord, ResolutionRecord, RobotRecord, actuators, formulation_name,
};
use crate::result_format::Lines;
use cppr::analysis::continuation::{Branch, End, Family, Parameter, PathPoint, PointKind};
use cppr::solve::Solver;
use serde::Serialize;
use std::fmt::Write;

/// Raised whenever a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// A path with all its branches.
#[derive(Clone, Debug, Serialize)]
pub struct ContinuationRecord {
    /// `cppr/continuation`.
    pub schema: &'static str,
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Version of the software that wrote it.
    pub cppr_version: &'static str,
    /// The robot.
    pub robot: RobotRecord,
    /// The command at the beginning.
    pub first_command: CommandRecord,
    /// The command at the end.
    pub last_command: CommandRecord,
    /// `consistent` or `printed`.
    pub formulation: &'static str,
    /// Number of modes and nodes.
    pub resolution: ResolutionRecord,
    /// What varies: `pull_m`, `rotation_rad`, `tension_N`, `torque_Nm`, `load_factor` or `command_fraction`.
    pub parameter: String,
    /// Whose actuator it is; null for loads and commands.
    pub parameter_tube: Option<usize>,
    /// The first one, then those that leave it.
    pub branches: Vec<BranchRecord>,
    /// How exact they are.
    pub accuracy: PathAccuracyRecord,
}

/// Discretisation error of some stable points that are spread over all branches.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct PathAccuracyRecord {
    /// How many have a known error.
    pub points: usize,
    /// Greatest error of a tip among them, as a part of the length.
    pub tip_of_length: Option<f64>,
}

/// One branch.
#[derive(Clone, Debug, Serialize)]
pub struct BranchRecord {
    /// `last`, `first`, `closed`, `points`, `step`, `edge`, `left` or `no_start`.
    pub end: &'static str,
    /// The same as a sentence.
    pub end_text: String,
    /// Where it left another branch; null for the first.
    pub origin: Option<OriginRecord>,
    /// In order along the branch.
    pub points: Vec<PointRecord>,
}

/// Where a branch comes from. Indices count from 0.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct OriginRecord {
    /// The branch that was left.
    pub branch: usize,
    /// Its branch point.
    pub point: usize,
    /// Which critical eigenvector was followed.
    pub mode: usize,
    /// Along it or against it.
    pub along: bool,
}

/// One equilibrium.
#[derive(Clone, Debug, Serialize)]
pub struct PointRecord {
    /// `regular`, `fold`, `branch_point` or `edge`.
    pub kind: &'static str,
    /// In the unit that the record's `parameter` names.
    pub parameter: f64,
    /// False where the robot would leave it.
    pub stable: bool,
    /// Negative eigenvalues of the constrained tangent; null for the printed formulation.
    pub inertia: Option<usize>,
    /// 1 at rest, 0 where the robot snaps; null for the printed formulation.
    pub margin_to_instability: Option<f64>,
    /// Centre of the tip section.
    pub tip_position_m: [f64; 3],
    /// Of all tubes.
    pub elastic_energy_J: f64,
    /// One per follower, tube 2 first.
    pub actuators: Vec<ActuatorRecord>,
}

/// The name of a parameter with its unit, and its tube.
#[must_use]
pub fn parameter_name(parameter: Parameter) -> (String, Option<usize>) {
    match parameter {
        Parameter::Actuator(input) => (input.quantity().column(), Some(input.tube)),
        Parameter::LoadFactor => ("load_factor".into(), None),
        Parameter::Fraction => ("command_fraction".into(), None),
    }
}

/// The kind of a point in one word.
#[must_use]
pub fn kind_word(kind: PointKind) -> &'static str {
    match kind {
        PointKind::Regular => "regular",
        PointKind::Fold => "fold",
        PointKind::BranchPoint { .. } => "branch_point",
        PointKind::Edge { .. } => "edge",
    }
}

impl ContinuationRecord {
    /// Everything about a traced path.
    #[must_use]
    pub fn new(solver: &Solver, family: &Family, branches: &[Branch]) -> Self {
        let (robot, settings) = (solver.robot(), solver.settings());
        let (parameter, parameter_tube) = parameter_name(family.parameter());
        Self {
            schema: "cppr/continuation",
            schema_version: SCHEMA_VERSION,
            cppr_version: env!("CARGO_PKG_VERSION"),
            robot: RobotRecord::new(robot),
            first_command: CommandRecord::new(&family.at(0.0), robot),
            last_command: CommandRecord::new(&family.at(1.0), robot),
            formulation: formulation_name(settings.formulation),
            resolution: settings.resolution.into(),
            parameter,
            parameter_tube,
            branches: branches.iter().map(BranchRecord::from).collect(),
            accuracy: PathAccuracyRecord::default(),
        }
    }

    /// As JSON, one branch per line.
    ///
    /// # Errors
    /// None in practice: every key is a string and memory is written to.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let mut bytes = Vec::new();
        self.serialize(&mut serde_json::Serializer::with_formatter(&mut bytes, Lines::default()))?;
        bytes.push(b'\n');
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// As CSV, one row per point, its branch counted from 1. Columns of an actuator begin with `tube2_` and so on.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = format!(
            "branch,kind,parameter_{},stable,inertia,margin_to_instability,tip_x_m,tip_y_m,tip_z_m,elastic_energy_J",
            self.parameter
        );
        for tube in 2..=self.robot.tubes {
            for column in ["pull_m", "rotation_rad", "tension_N", "torque_Nm"] {
                let _ = write!(text, ",tube{tube}_{column}");
            }
        }
        text.push('\n');
        for (branch, record) in self.branches.iter().enumerate() {
            for p in &record.points {
                let [x, y, z] = p.tip_position_m;
                let inertia = p.inertia.map_or(String::new(), |i| i.to_string());
                let margin = p.margin_to_instability.map_or(String::new(), |m| m.to_string());
                let _ = write!(
                    text,
                    "{},{},{},{},{inertia},{margin},{x},{y},{z},{}",
                    branch + 1,
                    p.kind,
                    p.parameter,
                    p.stable,
                    p.elastic_energy_J
                );
                for a in &p.actuators {
                    let _ = write!(text, ",{},{},{},{}", a.pull_m, a.rotation_rad, a.tension_N, a.torque_Nm);
                }
                text.push('\n');
            }
        }
        text
    }
}

/// Why a branch ends, in one word.
#[must_use]
pub fn end_word(end: End) -> &'static str {
    match end {
        End::Last => "last",
        End::First => "first",
        End::Closed => "closed",
        End::Points => "points",
        End::Step => "step",
        End::Edge { .. } => "edge",
        End::Left { .. } => "left",
        End::Stopped => "stopped",
        End::NoStart(_) => "no_start",
    }
}

impl From<&Branch> for BranchRecord {
    fn from(branch: &Branch) -> Self {
        let end = end_word(branch.end);
        let origin = branch.origin.map(|o| OriginRecord {
            branch: o.branch,
            point: o.point,
            mode: o.mode,
            along: o.along,
        });
        let points = branch.points.iter().map(PointRecord::from).collect();
        Self { end, end_text: branch.end.to_string(), origin, points }
    }
}

impl From<&PathPoint> for PointRecord {
    fn from(p: &PathPoint) -> Self {
        Self {
            kind: kind_word(p.kind),
            parameter: p.parameter,
            stable: p.is_stable(),
            inertia: p.inertia,
            margin_to_instability: p.margin,
            tip_position_m: p.tip.into(),
            elastic_energy_J: p.equilibrium.elastic_energy(),
            actuators: actuators(&p.equilibrium),
        }
    }
}
