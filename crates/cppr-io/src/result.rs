//! The whole result of a solve as JSON: SI units, the unit in every key.
//!
//! Frames: baseplate at x = 0, the robot at rest along +X. Rotations are given by their rows. A key keeps its
//! meaning as long as [`SCHEMA_VERSION`] stays; new keys may come.

// The keys are the fields' names, and a unit such as N is a capital.
#![allow(non_snake_case)]

use crate::result_format::Lines;
use cppr::analysis::{Accuracy, Against};
use cppr::analysis::{Section, Shape, TubeSection, total_bend};
use cppr::bundle::solve::BundleCommand;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Equilibrium, Formulation};
use cppr::statics::{Frame, Loads, RotationMeans, Station};
use cppr::{Matrix3, Vector3};
use serde::Serialize;

/// Raised whenever a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// What the file is, robot, command and status; [`SolutionRecord`] where there is an equilibrium.
#[derive(Clone, Debug, Serialize)]
pub struct ResultRecord {
    /// `cppr/equilibrium`.
    pub schema: &'static str,
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Version of the software that wrote it.
    pub cppr_version: &'static str,
    /// The robot.
    pub robot: RobotRecord,
    /// What was asked for.
    pub command: CommandRecord,
    /// `consistent` or `printed`.
    pub formulation: &'static str,
    /// Number of modes and nodes.
    pub resolution: ResolutionRecord,
    /// `converged` (and stable), `unstable` or `not_converged`.
    pub status: &'static str,
    /// The same as a sentence.
    pub status_text: String,
    /// What the solve cost.
    pub statistics: StatisticsRecord,
    /// Discretisation error; absent where there is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyRecord>,
    /// Where the pose is beyond a limit of the robot, which, where, and how much of the command is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_exceeded: Option<serde_json::Value>,
    /// Parts of the command at which the path of equilibria from rest turns back and the robot snaps, where it was followed past that.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub snaps_at: Vec<f64>,
    /// Where the equilibrium is unstable, a stable shape under the same command.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stable_aside: Option<serde_json::Value>,
    /// How the tubes press on each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<serde_json::Value>,
    /// Where friction is asked for, the equilibria between which it leaves the pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<serde_json::Value>,
    /// What gaps between the tubes make of the pose, where that is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<serde_json::Value>,
    /// Its keys follow those above; none of them where the status is `not_converged`.
    #[serde(flatten)]
    pub solution: Option<SolutionRecord>,
}

/// Discretisation error of the solution.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyRecord {
    /// Of the tip.
    pub tip_m: f64,
    /// Of the tip, as a part of the robot's length.
    pub tip_of_length: f64,
    /// Greatest of an actuation force.
    pub force_N: f64,
    /// Greatest of an actuation torque.
    pub torque_Nm: f64,
    /// Of the stability margin, where that is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// `integration`: against the bundle integrated along its length; `half_the_modes`: against the solution with half as many modes.
    pub against: &'static str,
    /// Is that stable? Not told where an eigenvalue is close to zero.
    pub reference_stable: Option<bool>,
    /// Tip of that, in the base frame.
    pub reference_tip_position_m: [f64; 3],
}

impl AccuracyRecord {
    /// The error of the solution of a robot.
    #[must_use]
    pub fn new(robot: &Robot, accuracy: &Accuracy) -> Self {
        let Accuracy { tip, force, torque, stable, against, reference } = *accuracy;
        Self {
            tip_m: tip,
            tip_of_length: tip / robot.length(),
            force_N: force,
            torque_Nm: torque,
            margin: None,
            reference_stable: stable,
            against: match against {
                Against::Integration => "integration",
                Against::HalfTheModes => "half_the_modes",
            },
            reference_tip_position_m: reference.into(),
        }
    }
}

/// The robot that was solved.
#[derive(Clone, Debug, Serialize)]
pub struct RobotRecord {
    /// From its file.
    pub name: String,
    /// Length above the baseplate at rest.
    pub length_m: f64,
    /// Number of tubes, the leader included.
    pub tubes: usize,
}

/// The command that was solved.
#[derive(Clone, Debug, Serialize)]
pub struct CommandRecord {
    /// One per follower, tube 2 first; of a bundle one per tube.
    pub actuators: Vec<DriveRecord>,
    /// `base`: the rotation of the follower's base; `relative_angle`: the angle between follower and leader at
    /// the plate.
    pub rotation_means: &'static str,
    /// External loads.
    pub loads: LoadsRecord,
}

/// What is prescribed of one actuator: motion or effort for its translation and its rotation.
#[derive(Clone, Debug, Serialize)]
pub struct DriveRecord {
    /// Number of the tube.
    pub tube: usize,
    /// Prescribed Δa, pull positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pull_m: Option<f64>,
    /// Prescribed force, pull positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_N: Option<f64>,
    /// Prescribed rotation, right-handed about +X.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_rad: Option<f64>,
    /// Prescribed torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_Nm: Option<f64>,
}

/// External loads.
#[derive(Clone, Debug, Serialize)]
pub struct LoadsRecord {
    /// Concentrated ones.
    pub wrenches: Vec<WrenchRecord>,
    /// Distributed ones.
    pub distributed: Vec<DistributedRecord>,
    /// Threads over pulleys.
    pub threads: Vec<ThreadRecord>,
    /// Acceleration, null where no gravity acts.
    pub gravity_m_s2: Option<[f64; 3]>,
}

/// A concentrated load.
#[derive(Clone, Debug, Serialize)]
pub struct WrenchRecord {
    /// `tip` or `section`.
    pub on: &'static str,
    /// The leader's abscissa of the loaded section.
    pub at_m: f64,
    /// Frame of force and moment: `base` (dead) or `section` (turns with the robot).
    pub frame: &'static str,
    /// Force.
    pub force_N: [f64; 3],
    /// Moment.
    pub moment_Nm: [f64; 3],
    /// Point of action in the section's frame.
    pub point_m: [f64; 3],
}

/// A distributed load.
#[derive(Clone, Debug, Serialize)]
pub struct DistributedRecord {
    /// First abscissa of the leader.
    pub from_m: f64,
    /// Last abscissa of the leader.
    pub to_m: f64,
    /// Force per length of the leader, base frame.
    pub force_N_m: [f64; 3],
}

/// A thread from the tip over a pulley.
#[derive(Clone, Debug, Serialize)]
pub struct ThreadRecord {
    /// Tension in the thread.
    pub tension_N: f64,
    /// Centre of the pulley, base frame.
    pub pulley_m: [f64; 3],
    /// Radius of the pulley.
    pub radius_m: f64,
    /// Side on which the thread runs onto it: `left` or `right`.
    pub side: &'static str,
    /// Where it is tied, in the tip's frame.
    pub point_m: [f64; 3],
}

/// Number of modes per field, and of nodes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ResolutionRecord {
    /// Of K_X.
    pub twist_modes: usize,
    /// Of K_Y.
    pub bending_y_modes: usize,
    /// Of K_Z.
    pub bending_z_modes: usize,
    /// Of each Δθ_k.
    pub angle_modes: usize,
    /// Of each tube's stretch.
    pub stretch_modes: usize,
    /// Quadrature nodes.
    pub nodes: usize,
}

/// What the solve cost.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StatisticsRecord {
    /// Newton steps.
    pub newton_iterations: usize,
    /// Residual and tangent evaluations.
    pub evaluations: usize,
    /// Load steps after the first attempt failed.
    pub load_steps: usize,
    /// Largest scaled residual.
    pub largest_scaled_residual: f64,
}

/// The equilibrium.
#[derive(Clone, Debug, Serialize)]
pub struct SolutionRecord {
    /// Centre of the tip section.
    pub tip_position_m: [f64; 3],
    /// Rotation of the tip; columns: tangent, direction of the leader's centroid, normal to both.
    pub tip_rotation: [[f64; 3]; 3],
    /// One per follower, tube 2 first.
    pub actuators: Vec<ActuatorRecord>,
    /// Angles by which the centreline turns, added up along it.
    pub total_bend_rad: f64,
    /// Of all tubes.
    pub elastic_energy_J: f64,
    /// 1 at rest, 0 where the robot snaps, below where it is unstable; null in the printed formulation, which is
    /// not the derivative of an energy.
    pub margin_to_instability: Option<f64>,
    /// Where the tip goes under the mode of the lowest eigenvalue, either way: unit vector of the base frame.
    pub critical_tip_direction: Option<[f64; 3]>,
    /// From the baseplate to the tip.
    pub sections: Vec<SectionRecord>,
}

/// Where an actuator stands and what it exerts.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ActuatorRecord {
    /// Number of the tube.
    pub tube: usize,
    /// Δa, pull positive.
    pub pull_m: f64,
    /// Rotation, in the meaning of the command's `rotation_means`.
    pub rotation_rad: f64,
    /// T, pull positive.
    pub tension_N: f64,
    /// Υ.
    pub torque_Nm: f64,
}

/// The robot at one section of the leader.
#[derive(Clone, Debug, Serialize)]
pub struct SectionRecord {
    /// Abscissa of the leader at rest.
    pub x_m: f64,
    /// Centre of the section.
    pub centre_m: [f64; 3],
    /// The leader's rotation.
    pub rotation: [[f64; 3]; 3],
    /// The leader's curvature vector K in its own frame, twist of the pattern included.
    pub leader_curvature_1_m: [f64; 3],
    /// Δθ_k, tube 2 first.
    pub follower_angles_rad: Vec<f64>,
    /// Elastic energy of all tubes per length of the leader.
    pub energy_density_J_m: f64,
    /// The leader first.
    pub tubes: Vec<TubeRecord>,
}

/// One tube at one section; axes: tangent, direction of its centroid (y), normal to both (z).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TubeRecord {
    /// Rest abscissa of the section that stands here, negative if it came up from below the plate.
    pub abscissa_m: f64,
    /// Centroid.
    pub centroid_m: [f64; 3],
    /// Rotation of the section.
    pub rotation: [[f64; 3]; 3],
    /// |h|: length of the tube per length of the leader.
    pub face_to_face_rate: f64,
    /// Twist rate against rest.
    pub twist_rad_m: f64,
    /// Curvature about y.
    pub curvature_y_1_m: f64,
    /// Curvature about z.
    pub curvature_z_1_m: f64,
    /// Relative stretch.
    pub stretch: f64,
    /// About the tube's centre.
    pub torque_Nm: f64,
    /// Bending moment about y through the centroid.
    pub moment_y_Nm: f64,
    /// Bending moment about z through the centroid.
    pub moment_z_Nm: f64,
    /// Tension positive.
    pub axial_force_N: f64,
    /// Shear force along y.
    pub shear_y_N: f64,
    /// Shear force along z.
    pub shear_z_N: f64,
}

impl ResultRecord {
    /// Everything about an equilibrium; the status alone where none was found.
    #[must_use]
    pub fn new(found: &Equilibrium, shape: &Shape, margin: Option<f64>, direction: Option<[f64; 3]>) -> Self {
        let mut record = Self::status_only(found);
        if let (true, Some(tip)) = (found.status().is_equilibrium(), shape.sections.last()) {
            record.solution = Some(SolutionRecord {
                tip_position_m: tip.centre.into(),
                tip_rotation: rows(&tip.rotation),
                actuators: actuators(found),
                total_bend_rad: total_bend(found),
                elastic_energy_J: found.elastic_energy(),
                margin_to_instability: margin,
                critical_tip_direction: direction,
                sections: shape.sections.iter().map(SectionRecord::from).collect(),
            });
        }
        record
    }

    /// What was asked and how it ended, without any number of the state.
    #[must_use]
    pub fn status_only(found: &Equilibrium) -> Self {
        Self {
            schema: "cppr/equilibrium",
            schema_version: SCHEMA_VERSION,
            cppr_version: env!("CARGO_PKG_VERSION"),
            robot: RobotRecord::new(found.robot()),
            command: CommandRecord::new(found.command(), found.robot()),
            formulation: formulation_name(found.settings().formulation),
            resolution: found.settings().resolution.into(),
            status: found.status().word(),
            status_text: found.status().to_string(),
            statistics: StatisticsRecord {
                newton_iterations: found.statistics().iterations,
                evaluations: found.statistics().evaluations,
                load_steps: found.statistics().load_steps,
                largest_scaled_residual: found.residual(),
            },
            accuracy: None,
            limit_exceeded: None,
            stable_aside: None,
            snaps_at: Vec::new(),
            contact: None,
            friction: None,
            clearance: None,
            solution: None,
        }
    }

    /// As JSON, the outer levels one key per line, each section along the robot on its own line.
    ///
    /// # Errors
    /// None in practice: every key is a string and memory is written to.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let mut bytes = Vec::new();
        self.serialize(&mut serde_json::Serializer::with_formatter(&mut bytes, Lines::default()))?;
        bytes.push(b'\n');
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

impl RobotRecord {
    pub(crate) fn new(robot: &Robot) -> Self {
        Self { name: robot.design().name.clone(), length_m: robot.length(), tubes: robot.tube_count() }
    }
}

/// Word for a formulation.
#[must_use]
pub fn formulation_name(formulation: Formulation) -> &'static str {
    match formulation {
        Formulation::Consistent => "consistent",
        Formulation::Printed => "printed",
    }
}

impl From<Resolution> for ResolutionRecord {
    fn from(resolution: Resolution) -> Self {
        Self {
            twist_modes: resolution.twist,
            bending_y_modes: resolution.bending_y,
            bending_z_modes: resolution.bending_z,
            angle_modes: resolution.angle,
            stretch_modes: resolution.stretch,
            nodes: resolution.nodes,
        }
    }
}

impl CommandRecord {
    /// What was asked of a robot.
    #[must_use]
    pub fn new(command: &Command, robot: &Robot) -> Self {
        let drives = command.actuators.iter().zip(robot.followers()).map(|(a, tube)| DriveRecord {
            tube,
            pull_m: a.push_pull.motion(),
            tension_N: a.push_pull.effort(),
            rotation_rad: a.rotation.motion(),
            torque_Nm: a.rotation.effort(),
        });
        Self {
            actuators: drives.collect(),
            rotation_means: match command.rotation_means {
                RotationMeans::Base => "base",
                RotationMeans::RelativeAngle => "relative_angle",
            },
            loads: LoadsRecord::new(&command.loads, robot.length()),
        }
    }

    /// What was asked of a bundle whose first tube has a length (m): one drive for every tube.
    #[must_use]
    pub fn of_bundle(command: &BundleCommand, length: f64) -> Self {
        let drives = (1..).zip(&command.drives).map(|(tube, own)| DriveRecord {
            tube,
            pull_m: own.translation.motion(),
            tension_N: own.translation.effort(),
            rotation_rad: own.rotation.motion(),
            torque_Nm: own.rotation.effort(),
        });
        Self {
            actuators: drives.collect(),
            rotation_means: "base",
            loads: LoadsRecord::new(&command.loads, length),
        }
    }
}

impl LoadsRecord {
    fn new(loads: &Loads, length: f64) -> Self {
        let Loads { wrenches, distributed, gravity, threads } = loads;
        let wrenches = wrenches.iter().map(|w| {
            let (on, at_m) = match w.station {
                Station::Tip => ("tip", length),
                Station::Label(label) => ("section", label),
            };
            WrenchRecord {
                on,
                at_m,
                frame: if w.frame == Frame::World { "base" } else { "section" },
                force_N: w.force.into(),
                moment_Nm: w.moment.into(),
                point_m: w.point.into(),
            }
        });
        let threads = threads.iter().map(|t| ThreadRecord {
            tension_N: t.tension,
            pulley_m: t.pulley.into(),
            radius_m: t.radius,
            side: if t.left { "left" } else { "right" },
            point_m: t.point.into(),
        });
        Self {
            wrenches: wrenches.collect(),
            distributed: distributed
                .iter()
                .map(|d| DistributedRecord { from_m: d.from, to_m: d.to, force_N_m: d.force.into() })
                .collect(),
            threads: threads.collect(),
            gravity_m_s2: gravity.map(Vector3::into),
        }
    }
}

pub(crate) fn actuators(found: &Equilibrium) -> Vec<ActuatorRecord> {
    let states = found.followers();
    states
        .map(|(tube, a)| ActuatorRecord {
            tube,
            pull_m: a.motion,
            rotation_rad: a.rotation,
            tension_N: a.tension,
            torque_Nm: a.torque,
        })
        .collect()
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    m.transpose().into()
}

impl From<&Section> for SectionRecord {
    fn from(s: &Section) -> Self {
        Self {
            x_m: s.label,
            centre_m: s.centre.into(),
            rotation: rows(&s.rotation),
            leader_curvature_1_m: s.curvature.into(),
            follower_angles_rad: s.angles.clone(),
            energy_density_J_m: s.energy_density,
            tubes: s.tubes.iter().map(TubeRecord::from).collect(),
        }
    }
}

impl From<&TubeSection> for TubeRecord {
    fn from(t: &TubeSection) -> Self {
        Self {
            abscissa_m: t.abscissa,
            centroid_m: t.centroid.into(),
            rotation: rows(&t.rotation),
            face_to_face_rate: t.rate,
            twist_rad_m: t.strain.x,
            curvature_y_1_m: t.strain.y,
            curvature_z_1_m: t.strain.z,
            stretch: t.stretch,
            torque_Nm: t.moment.x,
            moment_y_Nm: t.moment.y,
            moment_z_Nm: t.moment.z,
            axial_force_N: t.force.x,
            shear_y_N: t.force.y,
            shear_z_N: t.force.z,
        }
    }
}
