//! Keyword arguments as [`Command`] and [`Settings`].
//!
//! A bare number belongs to tube 2, the first follower; `{2: ..., 3: ...}` names tubes. What is not prescribed is held.

use crate::arrays::{number, vector};
use crate::design::pick;
use crate::errors;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Drive, Formulation, Settings};
use cppr::statics::{DistributedForce, Frame, Loads, RotationKnob, Station, Thread, Wrench};
use cppr::{Vector3, solve::Actuator};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::f64::consts::TAU;

/// Turns beyond which an angle is taken for degrees.
const TURNS: f64 = 2.0;
/// Forces beyond this multiple of Σ EI/L² are taken for another unit.
const STRONG: f64 = 300.0;
/// Torques that twist the stiffest tube by more turns than this are taken for another unit.
const TWISTS: f64 = 5.0;

/// How an actuator is driven: `pull`, `rotate`, `tension`, `torque`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Means {
    Pull,
    Rotate,
    Tension,
    Torque,
}

impl Means {
    pub const ALL: [Self; 4] = [Self::Pull, Self::Rotate, Self::Tension, Self::Torque];

    pub fn name(self) -> &'static str {
        ["pull", "rotate", "tension", "torque"][self as usize]
    }

    /// Sets a value of one follower.
    pub fn set(self, actuator: &mut Actuator, value: f64) {
        match self {
            Self::Pull => actuator.push_pull = Drive::Motion(value),
            Self::Tension => actuator.push_pull = Drive::Effort(value),
            Self::Rotate => actuator.rotation = Drive::Motion(value),
            Self::Torque => actuator.rotation = Drive::Effort(value),
        }
    }

    fn turns(self) -> bool {
        matches!(self, Self::Rotate | Self::Torque)
    }

    /// A sentence where a number looks like another unit.
    pub fn suspicious(self, robot: &Robot, value: f64) -> Option<String> {
        let middle = 0.5 * robot.length();
        let fields = || (0..robot.tube_count()).map(|t| robot.fields_at(t, middle));
        let (size, length) = (value.abs(), robot.length());
        let bending = || fields().map(|f| f.bending_z).sum::<f64>();
        let torsion = || fields().map(|f| f.torsion).fold(0.0, f64::max);
        match self {
            Self::Rotate if size > TURNS * TAU => Some(format!(
                "rotate is {value} rad, {:.1} turns; angles are in radians: 90 degrees is 1.5708",
                value / TAU
            )),
            Self::Tension if size > STRONG * bending() / (length * length) => Some(format!(
                "tension is {value} N, far more than this robot can carry; forces are in newtons"
            )),
            Self::Torque if size > TWISTS * TAU * torsion() / length => Some(format!(
                "torque is {value} N m, which twists this robot by many turns; torques are in newton metres: 20 N mm is 0.020"
            )),
            _ => None,
        }
    }
}

/// Which followers' degrees of freedom are taken already.
pub struct Taken<'a> {
    robot: &'a Robot,
    list: Vec<(usize, bool)>,
}

impl<'a> Taken<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        Self { robot, list: Vec::new() }
    }

    /// Index of the follower with a tube number, where it is free.
    pub fn claim(&mut self, py: Python<'_>, means: Means, tube: i64) -> PyResult<usize> {
        let (name, followers) = (means.name(), self.robot.follower_count());
        let Some(follower) = usize::try_from(tube - 2).ok().filter(|f| *f < followers) else {
            return Err(errors::command(
                py,
                match (followers, tube) {
                    (0, _) => format!("{name}: this robot has only its leader, nothing to actuate"),
                    (_, 1) => format!(
                        "{name}: tube 1 is the leader, clamped in the baseplate; followers are 2 to {}",
                        followers + 1
                    ),
                    (1, _) => {
                        format!("{name}: there is no tube {tube}; the only follower of this robot is tube 2")
                    }
                    _ => format!(
                        "{name}: there is no tube {tube}; the followers of this robot are 2 to {}",
                        followers + 1
                    ),
                },
            ));
        };
        if self.list.contains(&(follower, means.turns())) {
            let (one, other) = if means.turns() { ("rotate", "torque") } else { ("pull", "tension") };
            return Err(errors::command(
                py,
                format!("tube {tube} is given both {one} and {other}: give one of them"),
            ));
        }
        self.list.push((follower, means.turns()));
        Ok(follower)
    }
}

fn drive(
    command: &mut Command,
    taken: &mut Taken<'_>,
    means: Means,
    value: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let py = value.py();
    let mut set = |tube: i64, value: f64| -> PyResult<()> {
        let follower = taken.claim(py, means, tube)?;
        if let Some(text) = means.suspicious(taken.robot, value) {
            errors::unit_warning(py, &text)?;
        }
        if let Some(actuator) = command.actuators.get_mut(follower) {
            means.set(actuator, value);
        }
        Ok(())
    };
    if let Ok(tubes) = value.cast::<PyDict>() {
        for (tube, value) in tubes {
            set(tube_number(means, &tube)?, number(means.name(), &value)?)?;
        }
        return Ok(());
    }
    let wanted = "a number (for tube 2) or a dict from tube number to number; solve_many takes arrays";
    set(2, number(means.name(), value).map_err(|_| errors::wrong_type(means.name(), wanted, value))?)
}

/// A key of a dict of tubes.
pub fn tube_number(means: Means, key: &Bound<'_, PyAny>) -> PyResult<i64> {
    key.extract()
        .map_err(|_| errors::wrong_type(&format!("a tube of {}", means.name()), "a tube number", key))
}

/// `pull`, `rotate`, `tension`, `torque`, as far as they are given.
pub type Drives<'py> = [Option<Bound<'py, PyAny>>; 4];

/// What is asked of a robot.
#[derive(Default)]
pub struct Asked<'a, 'py> {
    pub drives: [Option<&'a Bound<'py, PyAny>>; 4],
    pub tip_force: Option<&'a Bound<'py, PyAny>>,
    pub tip_moment: Option<&'a Bound<'py, PyAny>>,
    pub loads: Option<&'a Bound<'py, PyAny>>,
    pub settings: Option<&'a Bound<'py, PyAny>>,
}

impl Asked<'_, '_> {
    /// The command and the settings, unchecked.
    pub fn read(&self, robot: &Robot) -> PyResult<(Command, Settings)> {
        let (settings, knob) = settings(self.settings)?;
        let mut command = Command { knob, ..Command::held(robot) };
        self.put(robot, &mut command)?;
        if self.tip_force.is_some() || self.tip_moment.is_some() {
            let read = |what, value: Option<&Bound<'_, PyAny>>| {
                value.map_or(Ok(Vector3::zeros()), |value| vector(what, value))
            };
            let mut wrench = Wrench::tip_force(read("tip_force", self.tip_force)?);
            wrench.moment = read("tip_moment", self.tip_moment)?;
            command.loads.wrenches.push(wrench);
        }
        if let Some(list) = self.loads {
            add_loads(&mut command, robot, list)?;
        }
        Ok((command, settings))
    }

    /// Puts the prescribed values into a command; what is not given stays.
    pub fn put(&self, robot: &Robot, command: &mut Command) -> PyResult<()> {
        let mut taken = Taken::new(robot);
        for (means, value) in Means::ALL.into_iter().zip(self.drives) {
            if let Some(value) = value {
                drive(command, &mut taken, means, value)?;
            }
        }
        Ok(())
    }
}

/// Adds the dataclasses of `cppr._loads`.
fn add_loads(command: &mut Command, robot: &Robot, list: &Bound<'_, PyAny>) -> PyResult<()> {
    let wanted = "a list of Wrench, DistributedForce, Gravity and Thread";
    for load in list.try_iter().map_err(|_| errors::wrong_type("loads", wanted, list))? {
        let load = load?;
        let class = load.get_type();
        let get = |name: &str| load.getattr(name);
        let three = |name: &str| vector(&format!("{name} of a load"), &get(name)?);
        let scalar = |name: &str| number(&format!("{name} of a load"), &get(name)?);
        match class.name()?.to_str()? {
            "Wrench" => {
                let at = get("at")?;
                command.loads.wrenches.push(Wrench {
                    force: three("force")?,
                    moment: three("moment")?,
                    frame: match pick("frame of a load", &get("frame")?, &["base", "section"])? {
                        0 => Frame::World,
                        _ => Frame::Section,
                    },
                    station: if at.is_none() { Station::Tip } else { Station::Label(scalar("at")?) },
                    point: three("point")?,
                });
            }
            "DistributedForce" => command.loads.distributed.push(DistributedForce {
                force: three("force")?,
                from: scalar("start")?,
                to: scalar("end")?,
            }),
            "Gravity" => {
                let massless = |tube| robot.fields_at(tube, robot.length()).mass_per_length <= 0.0;
                if (0..robot.tube_count()).all(massless) {
                    let text = "gravity acts on nothing: this robot has no mass; give its tubes a density or a mass per length";
                    return Err(errors::command(load.py(), text));
                }
                let own = three("acceleration")?;
                command.loads.gravity = Some(command.loads.gravity.map_or(own, |g| g + own));
            }
            "Thread" => command.loads.threads.push(Thread {
                tension: scalar("tension")?,
                pulley: three("pulley")?,
                radius: scalar("radius")?,
                left: pick("side of a thread", &get("side")?, &["left", "right"])? == 0,
                point: three("point")?,
            }),
            _ => {
                return Err(errors::wrong_type(
                    "a load",
                    "a Wrench, DistributedForce, Gravity or Thread",
                    &load,
                ));
            }
        }
    }
    Ok(())
}

/// Loads as dataclasses.
pub fn loads<'py>(py: Python<'py>, loads: &Loads) -> PyResult<Bound<'py, PyTuple>> {
    let module = py.import("cppr._loads")?;
    let class = |name: &str| module.getattr(name);
    let three = |v: &Vector3<f64>| (v.x, v.y, v.z);
    let mut list = Vec::new();
    for w in &loads.wrenches {
        let at = match w.station {
            Station::Tip => None,
            Station::Label(label) => Some(label),
        };
        let frame = if w.frame == Frame::World { "base" } else { "section" };
        list.push(class("Wrench")?.call1((three(&w.force), three(&w.moment), at, three(&w.point), frame))?);
    }
    for d in &loads.distributed {
        list.push(class("DistributedForce")?.call1((three(&d.force), d.from, d.to))?);
    }
    if let Some(gravity) = &loads.gravity {
        list.push(class("Gravity")?.call1((three(gravity),))?);
    }
    for t in &loads.threads {
        let side = if t.left { "left" } else { "right" };
        let own = (t.tension, three(&t.pulley), t.radius, side, three(&t.point));
        list.push(class("Thread")?.call1(own)?);
    }
    PyTuple::new(py, list)
}

/// The dataclass `Settings`.
pub fn settings(value: Option<&Bound<'_, PyAny>>) -> PyResult<(Settings, RotationKnob)> {
    let Some(value) = value else { return Ok((Settings::default(), RotationKnob::Base)) };
    if value.get_type().name()? != "Settings" {
        return Err(errors::wrong_type("settings", "a Settings", value));
    }
    let get = |name: &str| value.getattr(name);
    let flag = |name: &str| get(name)?.is_truthy();
    let count = |name: &str, most: usize| -> PyResult<usize> {
        let own = get(name)?;
        let what = format!("{name} of the settings");
        let number: i64 = own.extract().map_err(|_| errors::wrong_type(&what, "a whole number", &own))?;
        let fits = usize::try_from(number).ok().filter(|n| (1..=most).contains(n));
        fits.ok_or_else(|| PyValueError::new_err(format!("{what} is {number}; it must be from 1 to {most}")))
    };
    let positive = |name: &str| -> PyResult<f64> {
        let number = number(&format!("{name} of the settings"), &get(name)?)?;
        if number > 0.0 && number < 1.0 {
            return Ok(number);
        }
        Err(PyValueError::new_err(format!("{name} of the settings is {number}; it must lie between 0 and 1")))
    };
    let base = if flag("planar")? { Resolution::PLANAR } else { Resolution::SPATIAL };
    let formulation = match pick("formulation", &get("formulation")?, &["consistent", "printed"])? {
        0 => Formulation::Consistent,
        _ => Formulation::Printed,
    };
    let settings = Settings {
        formulation,
        resolution: base.refined(count("refine", 8)?),
        tolerance: positive("tolerance")?,
        iterations: count("iterations", 100_000)?,
        smallest_step: positive("smallest_step")?,
    };
    let knob = if flag("relative_angle")? { RotationKnob::RelativeAngle } else { RotationKnob::Base };
    Ok((if flag("stretch")? { settings.with_stretch() } else { settings }, knob))
}
