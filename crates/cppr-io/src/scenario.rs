//! Scenario files: TOML that says what is asked of a robot. Actuation, loads, how to solve, changes of the
//! notches. What `cppr solve --scenario` reads and the live view writes.
//!
//! Every table may be left out: actuators that are not named are held, nothing acts, notches stay as they are.
//! Lengths are in mm, angles in degrees, moments in N mm, as the keys say; vectors are in the base frame
//! unless said otherwise.
//!
//! | table | keys |
//! |---|---|
//! | the file | `formulation` ("consistent" or "printed"), `stretch` (false), `modes` ("default", "paper" or "planar"), `refine` (1 to 8), `rotation_means` ("base" or "relative_angle"), `gravity_m_s2` |
//! | `[[actuator]]` | `tube` (2, 3, …; with parts or joints 1 as well), `pull_mm` or `tension_N`, `rotate_deg` or `torque_Nmm` |
//! | `[tip]` | `force_N`, `moment_Nmm`, `point_mm` (in the tip's frame), `turns_with_tip` (false) |
//! | `[[point_force]]` | `at_mm`, `force_N` |
//! | `[[distributed]]` | `from_mm`, `to_mm`, `force_N_m` |
//! | `[[thread]]` | `tension_N`, `pulley_mm`, `radius_mm` (0), `side` ("left" or "right"), `point_mm` (in the tip's frame) |
//! | `[[notches]]` | `tube` (1, 2, …), `deeper_mm`: added to the notch depth everywhere |

// The keys are the fields' names, and a unit such as N is a capital.
#![allow(non_snake_case)]

use cppr::Vector3;
use cppr::design::{Robot, RobotDesign, TubeDesign};
use cppr::kinematics::Resolution;
use cppr::solve::{Command, CommandProblem, Draft, Formulation, Freedom, Quantity, Settings};
use cppr::statics::{DistributedForce, Frame, Loads, RotationMeans, Station, Thread, Wrench};
use serde::{Deserialize, Serialize};

/// Largest scenario file (bytes).
pub const LARGEST: usize = 1 << 16;

/// What is asked of a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// Which conditions of equilibrium are solved.
    pub formulation: FormulationName,
    /// Do the tubes stretch?
    pub stretch: bool,
    /// Modes of the fields.
    #[serde(skip_serializing_if = "is_default")]
    pub modes: ModesName,
    /// By how much modes and nodes are multiplied, 1 to 8, to see whether the answer stays.
    #[serde(skip_serializing_if = "is_default")]
    pub refine: Refinement,
    /// What a rotation is.
    pub rotation_means: RotationName,
    /// Gravitational acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_m_s2: Option<[f64; 3]>,
    /// Load on the tip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<TipLoad>,
    /// Motion or effort of followers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub actuator: Vec<ActuatorEntry>,
    /// Forces along the robot.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub point_force: Vec<PointForce>,
    /// Forces per length.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub distributed: Vec<Distributed>,
    /// Threads from the tip over pulleys.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub thread: Vec<ThreadEntry>,
    /// Changes of the notches.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notches: Vec<NotchChange>,
}

/// Which conditions of equilibrium are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FormulationName {
    /// Stationary total energy.
    #[default]
    Consistent,
    /// The paper's projection of wrenches.
    Printed,
}

/// Modes of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModesName {
    /// Tip within 1e-4 of the length, for every robot shipped.
    #[default]
    Default,
    /// The paper's 3 + 3 + 3 + 2.
    Paper,
    /// Five modes, nothing leaves the plane.
    Planar,
}

/// A factor on modes and nodes from 1 to 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "usize")]
pub struct Refinement(usize);

impl Default for Refinement {
    fn default() -> Self {
        Self(1)
    }
}

impl TryFrom<usize> for Refinement {
    type Error = String;

    fn try_from(factor: usize) -> Result<Self, String> {
        if (1..=Resolution::FINEST_REFINEMENT).contains(&factor) {
            return Ok(Self(factor));
        }
        Err(format!("refine is {factor}; it must be from 1 to {}", Resolution::FINEST_REFINEMENT))
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// What a rotation is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotationName {
    /// Of the follower's base, below the plate.
    #[default]
    Base,
    /// The angle between follower and leader at the plate.
    RelativeAngle,
}

/// Motion or effort of one follower; what is left out is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorEntry {
    /// Number of the tube, from 2; where the robot has parts or joints from 1.
    pub tube: usize,
    /// Translation, pull positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pull_mm: Option<f64>,
    /// Force instead, pull positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_N: Option<f64>,
    /// Rotation, right-handed about +X.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<f64>,
    /// Torque instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_Nmm: Option<f64>,
}

/// Load on the tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TipLoad {
    /// Force.
    pub force_N: [f64; 3],
    /// Moment.
    pub moment_Nmm: [f64; 3],
    /// Where the force acts, in the tip's frame.
    pub point_mm: [f64; 3],
    /// Do both turn with the tip?
    pub turns_with_tip: bool,
}

/// A dead force on the centre of a section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointForce {
    /// The leader's abscissa.
    pub at_mm: f64,
    /// Force.
    pub force_N: [f64; 3],
}

/// A dead force per length of the leader.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Distributed {
    /// First abscissa of the leader.
    pub from_mm: f64,
    /// Last abscissa of the leader.
    pub to_mm: f64,
    /// Force per length.
    pub force_N_m: [f64; 3],
}

/// A thread from the tip over a pulley.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThreadEntry {
    /// Its tension.
    pub tension_N: f64,
    /// Centre of the pulley.
    pub pulley_mm: [f64; 3],
    /// Radius of the pulley.
    #[serde(default)]
    pub radius_mm: f64,
    /// Side on which the thread runs onto it.
    #[serde(default)]
    pub side: Side,
    /// Where it is tied, in the tip's frame.
    #[serde(default)]
    pub point_mm: [f64; 3],
}

/// Side of a pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Seen from the tip along the thread with +Z up.
    #[default]
    Left,
    /// The other.
    Right,
}

/// Notches of one tube, cut deeper or less deep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotchChange {
    /// Number of the tube, from 1.
    pub tube: usize,
    /// Added to the depth everywhere.
    pub deeper_mm: f64,
}

fn metres(v: [f64; 3]) -> Vector3<f64> {
    Vector3::from(v) * 1e-3
}

impl Scenario {
    /// Reads a scenario from the text of a file.
    ///
    /// # Errors
    /// The first problem, with its line.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.len() > LARGEST {
            return Err("a scenario of more than 64 KiB: is it another file?".into());
        }
        let people =
            |message: &str| message.trim_end().replace("expected usize", "expected the number of a tube");
        toml::from_str(text).map_err(|e| people(&e.to_string()))
    }

    /// The scenario as the text of a file, for [`Scenario::parse`].
    ///
    /// # Errors
    /// What the TOML writer says.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|e| e.to_string())
    }

    /// How to solve.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let formulation = match self.formulation {
            FormulationName::Consistent => Formulation::Consistent,
            FormulationName::Printed => Formulation::Printed,
        };
        let modes = match self.modes {
            ModesName::Default => Resolution::SPATIAL,
            ModesName::Paper => Resolution::PAPER,
            ModesName::Planar => Resolution::PLANAR,
        };
        let resolution = modes.refined(self.refine.0);
        let settings = Settings { formulation, resolution, ..Settings::default() };
        if self.stretch { settings.with_stretch() } else { settings }
    }

    /// The design with its notches changed.
    ///
    /// # Errors
    /// Every change that cannot be made. Whether the changed notches leave anything of a tube, [`Robot::from_design`] says.
    pub fn changed(&self, mut design: RobotDesign) -> Result<RobotDesign, Vec<String>> {
        let mut problems = Vec::new();
        let count = design.tubes.len();
        for change in &self.notches {
            let number = change.tube;
            if !change.deeper_mm.is_finite() {
                problems.push(format!("notches, tube {number}: deeper_mm is {}", change.deeper_mm));
                continue;
            }
            match number.checked_sub(1).and_then(|i| design.tubes.get_mut(i)) {
                Some(TubeDesign::Notched(tube)) => tube.depth = tube.depth.shifted(change.deeper_mm * 1e-3),
                Some(TubeDesign::Stiffness(_)) => problems.push(format!(
                    "notches, tube {number}: it is given by its stiffness and has no notches to change"
                )),
                None => problems
                    .push(format!("notches: there is no tube {number}; this robot has tubes 1 to {count}")),
            }
        }
        if problems.is_empty() { Ok(design) } else { Err(problems) }
    }

    /// The command for a robot.
    ///
    /// # Errors
    /// Every entry that cannot be asked of it. What concerns single numbers, [`Command::check`] says.
    pub fn command(&self, robot: &Robot) -> Result<Command, Vec<String>> {
        let mut draft = Draft::new(robot);
        draft.command.loads = self.loads();
        if self.rotation_means == RotationName::RelativeAngle {
            draft.command.rotation_means = RotationMeans::RelativeAngle;
        }
        let mut problems = Vec::new();
        if let Err(problem) = draft.command.loads.check(robot) {
            problems.push(problem.to_string());
        }
        let mut entries: Vec<usize> = Vec::new();
        for entry in &self.actuator {
            let number = entry.tube;
            if entries.contains(&number) {
                problems.push(format!("actuator: tube {number} is given twice"));
                continue;
            }
            entries.push(number);
            if draft.command.actuator(number).is_none() {
                problems.push(format!("actuator: {}", draft.command.no_such_tube(number)));
            }
            for (quantity, key, value) in entry.given() {
                match draft.set(quantity.of_tube(number), value) {
                    Ok(()) | Err(CommandProblem::NoSuchTube { .. }) => {}
                    Err(CommandProblem::Twice { earlier, .. }) => {
                        let other = ActuatorEntry::key(earlier.quantity());
                        problems.push(format!("actuator of tube {number}: give {other} or {key}, not both"));
                    }
                    Err(problem) => problems.push(format!("actuator: {problem}")),
                }
            }
        }
        if problems.is_empty() { Ok(draft.command) } else { Err(problems) }
    }

    pub(crate) fn loads(&self) -> Loads {
        let on_tip = self.tip.map(|tip| Wrench {
            force: tip.force_N.into(),
            moment: Vector3::from(tip.moment_Nmm) * 1e-3,
            frame: if tip.turns_with_tip { Frame::Section } else { Frame::World },
            station: Station::Tip,
            point: metres(tip.point_mm),
        });
        let along = self.point_force.iter().map(|p| Wrench {
            station: Station::Label(p.at_mm * 1e-3),
            ..Wrench::tip_force(p.force_N.into())
        });
        let distributed = self.distributed.iter().map(|d| DistributedForce {
            force: d.force_N_m.into(),
            from: d.from_mm * 1e-3,
            to: d.to_mm * 1e-3,
        });
        let threads = self.thread.iter().map(|t| Thread {
            tension: t.tension_N,
            pulley: metres(t.pulley_mm),
            radius: t.radius_mm * 1e-3,
            left: t.side == Side::Left,
            point: metres(t.point_mm),
        });
        Loads {
            wrenches: on_tip.into_iter().chain(along).collect(),
            distributed: distributed.collect(),
            gravity: self.gravity_m_s2.map(Vector3::from),
            threads: threads.collect(),
        }
    }
}

impl ActuatorEntry {
    /// What is given, with its key and its value in SI.
    pub(crate) fn given(&self) -> impl Iterator<Item = (Quantity, &'static str, f64)> {
        let values = [self.pull_mm, self.tension_N, self.rotate_deg, self.torque_Nmm];
        let all = Quantity::ALL.into_iter().zip(values);
        all.filter_map(|(quantity, value)| {
            Some((quantity, Self::key(quantity), value? * quantity.shown_size))
        })
    }

    /// The key of a quantity.
    fn key(quantity: Quantity) -> &'static str {
        match (quantity.freedom, quantity.is_motion) {
            (Freedom::PushPull, true) => "pull_mm",
            (Freedom::PushPull, false) => "tension_N",
            (Freedom::Rotation, true) => "rotate_deg",
            (Freedom::Rotation, false) => "torque_Nmm",
        }
    }
}
