//! Keyword arguments as [`Command`] and [`Settings`].
//!
//! A bare number belongs to tube 2, the first follower; `{2: ..., 3: ...}` names tubes. What is not prescribed is held.

use crate::arrays::{number, vector};
use crate::design::pick;
use crate::errors;
use cppr::Vector3;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Draft, Formulation, Freedom, Quantity, Settings};
use cppr::statics::{DistributedForce, Frame, Loads, RotationMeans, Station, Thread, Wrench};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::f64::consts::TAU;

/// Turns beyond which an angle is taken for degrees.
const TURNS: f64 = 1.0;
/// Forces beyond this multiple of Σ EI/L² are taken for another unit.
const STRONG: f64 = 300.0;
/// Torques that twist the stiffest tube by more turns than this are taken for another unit.
const TWISTS: f64 = 5.0;

/// A sentence where an angle looks like degrees.
pub fn full_turns(quantity: Quantity, value: f64) -> Option<String> {
    (quantity == Quantity::ROTATION && value.abs() > TURNS * TAU).then(|| {
        format!(
            "rotate is {value} rad, {:.1} turns; angles are in radians: 90 degrees is 1.5708",
            value / TAU
        )
    })
}

/// A sentence where a number looks like another unit.
pub fn suspicious(quantity: Quantity, robot: &Robot, value: f64) -> Option<String> {
    let middle = 0.5 * robot.length();
    let fields = || (0..robot.tube_count()).map(|t| robot.fields_at(t, middle));
    let (size, length) = (value.abs(), robot.length());
    let bending = || fields().map(|f| f.bending_z).sum::<f64>();
    let torsion = || fields().map(|f| f.torsion).fold(0.0, f64::max);
    match (quantity.freedom, quantity.is_motion) {
        (Freedom::Rotation, true) => full_turns(quantity, value),
        (Freedom::PushPull, false) if size > STRONG * bending() / (length * length) => {
            Some(format!("tension is {value} N, far more than this robot can carry; forces are in newtons"))
        }
        (Freedom::Rotation, false) if size > TWISTS * TAU * torsion() / length => Some(format!(
            "torque is {value} N m, which twists this robot by many turns; torques are in newton metres: 20 N mm is 0.020"
        )),
        _ => None,
    }
}

fn drive(draft: &mut Draft, robot: &Robot, quantity: Quantity, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let py = value.py();
    let mut set = |tube: usize, value: f64| -> PyResult<()> {
        let refused = |problem| errors::command(py, format!("{}: {problem}", quantity.keyword));
        draft.set(quantity.of_tube(tube), value).map_err(refused)?;
        match suspicious(quantity, robot, value) {
            Some(text) => errors::warn(py, "UnitWarning", &text),
            None => Ok(()),
        }
    };
    if let Ok(tubes) = value.cast::<PyDict>() {
        for (tube, value) in tubes {
            set(tube_number(quantity, &tube)?, number(quantity.keyword, &value)?)?;
        }
        return Ok(());
    }
    let wanted = "a number (for tube 2) or a dict from tube number to number; solve_many takes arrays";
    set(2, number(quantity.keyword, value).map_err(|_| errors::wrong_type(quantity.keyword, wanted, value))?)
}

/// A key of a dict of tubes.
pub fn tube_number(quantity: Quantity, key: &Bound<'_, PyAny>) -> PyResult<usize> {
    let what = format!("a tube of {}", quantity.keyword);
    let number: i64 = key.extract().map_err(|_| errors::wrong_type(&what, "a tube number", key))?;
    // No tube has a negative number, nor the largest one.
    Ok(usize::try_from(number).unwrap_or(usize::MAX))
}

/// The quantities in the order of the keywords: `pull`, `rotate`, `tension`, `torque`.
pub const KEYWORDS: [Quantity; 4] = [Quantity::PULL, Quantity::ROTATION, Quantity::TENSION, Quantity::TORQUE];

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
        let (settings, rotation_means) = settings(self.settings)?;
        let mut command = Command { rotation_means, ..Command::held(robot) };
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
            add_loads(&mut command.loads, list)?;
        }
        Ok((command, settings))
    }

    /// Puts the prescribed values into a command; what is not given stays.
    pub fn put(&self, robot: &Robot, command: &mut Command) -> PyResult<()> {
        let mut draft = Draft::of(command.clone());
        for (quantity, value) in KEYWORDS.into_iter().zip(self.drives) {
            if let Some(value) = value {
                drive(&mut draft, robot, quantity, value)?;
            }
        }
        *command = draft.command;
        Ok(())
    }
}

/// Adds the dataclasses of `cppr._loads`.
pub fn add_loads(loads: &mut Loads, list: &Bound<'_, PyAny>) -> PyResult<()> {
    let wanted = "a list of Wrench, DistributedForce, Gravity and Thread";
    let module = list.py().import("cppr._loads")?;
    for load in list.try_iter().map_err(|_| errors::wrong_type("loads", wanted, list))? {
        let load = load?;
        let is = |class: &str| load.is_instance(&module.getattr(class)?);
        let get = |name: &str| load.getattr(name);
        let three = |name: &str| vector(&format!("{name} of a load"), &get(name)?);
        let scalar = |name: &str| number(&format!("{name} of a load"), &get(name)?);
        if is("Wrench")? {
            let at = get("at")?;
            loads.wrenches.push(Wrench {
                force: three("force")?,
                moment: three("moment")?,
                frame: match pick("frame of a load", &get("frame")?, &["base", "section"])? {
                    0 => Frame::World,
                    _ => Frame::Section,
                },
                station: if at.is_none() { Station::Tip } else { Station::Label(scalar("at")?) },
                point: three("point")?,
            });
        } else if is("DistributedForce")? {
            loads.distributed.push(DistributedForce {
                force: three("force")?,
                from: scalar("start")?,
                to: scalar("end")?,
            });
        } else if is("Gravity")? {
            let own = three("acceleration")?;
            loads.gravity = Some(loads.gravity.map_or(own, |g| g + own));
        } else if is("Thread")? {
            loads.threads.push(Thread {
                tension: scalar("tension")?,
                pulley: three("pulley")?,
                radius: scalar("radius")?,
                left: pick("side of a thread", &get("side")?, &["left", "right"])? == 0,
                point: three("point")?,
            });
        } else {
            return Err(errors::wrong_type("a load", "a Wrench, DistributedForce, Gravity or Thread", &load));
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
    let Loads { wrenches, distributed, gravity, threads } = loads;
    for w in wrenches {
        let at = match w.station {
            Station::Tip => None,
            Station::Label(label) => Some(label),
        };
        let frame = if w.frame == Frame::World { "base" } else { "section" };
        list.push(class("Wrench")?.call1((three(&w.force), three(&w.moment), at, three(&w.point), frame))?);
    }
    for d in distributed {
        list.push(class("DistributedForce")?.call1((three(&d.force), d.from, d.to))?);
    }
    if let Some(gravity) = gravity {
        list.push(class("Gravity")?.call1((three(gravity),))?);
    }
    for t in threads {
        let side = if t.left { "left" } else { "right" };
        let own = (t.tension, three(&t.pulley), t.radius, side, three(&t.point));
        list.push(class("Thread")?.call1(own)?);
    }
    PyTuple::new(py, list)
}

/// The dataclass `Settings`.
pub fn settings(value: Option<&Bound<'_, PyAny>>) -> PyResult<(Settings, RotationMeans)> {
    let Some(value) = value else { return Ok((Settings::default(), RotationMeans::Base)) };
    if !value.is_instance(&value.py().import("cppr._design")?.getattr("Settings")?)? {
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
    let refine = number("refine of the settings", &get("refine")?)?;
    let resolution = base.multiplied(refine).ok_or_else(|| {
        PyValueError::new_err(format!(
            "refine of the settings is {refine}; it must be from 1 to 8 and whole, or 0.375, 0.5 or 0.75"
        ))
    })?;
    let formulation = match pick("formulation", &get("formulation")?, &["consistent", "printed"])? {
        0 => Formulation::Consistent,
        _ => Formulation::Printed,
    };
    let settings = Settings {
        formulation,
        resolution,
        tolerance: positive("tolerance")?,
        iterations: count("iterations", 100_000)?,
        smallest_step: positive("smallest_step")?,
    };
    let rotation_means =
        if flag("relative_angle")? { RotationMeans::RelativeAngle } else { RotationMeans::Base };
    Ok((if flag("stretch")? { settings.with_stretch() } else { settings }, rotation_means))
}
