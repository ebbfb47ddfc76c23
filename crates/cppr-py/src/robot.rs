//! The class `Robot`.

use crate::arrays::{line, unmasked};
use crate::command::Asked;
use crate::design::{self, Reader};
use crate::equilibrium::Equilibrium;
use crate::watch::stoppable;
use crate::{errors, rubbing, stored};
use cppr::analysis::ACCURACY;
use cppr::analysis::explained;
use cppr::bundle::Friction;
use cppr::design::{BelowPlate, RobotDesign, TubeDesign};
use cppr::solve::{Command, SettingsProblem, Solver, Status};
use cppr_io::{robot_file, robot_text, sudden_changes};
use cppr_sweep::Memory;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A robot and the solvers that have worked on it: as many as ever ran at the same time.
pub struct Shared {
    pub robot: cppr::design::Robot,
    /// How its tubes rub, where that is known.
    pub friction: Option<Friction>,
    idle: Mutex<Vec<Solver>>,
    /// The same for many poses in one call.
    pub many: Memory,
}

impl Shared {
    /// Runs with a solver of the robot. The lock is held to take and to give back, never in between.
    pub fn with<R>(&self, run: impl FnOnce(&mut Solver) -> R) -> R {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = idle().pop();
        let mut solver = taken.unwrap_or_else(|| Solver::new(&self.robot));
        let result = run(&mut solver);
        idle().push(solver);
        result
    }
}

/// A checked robot. Immutable; any number of threads may solve with it at the same time.
#[pyclass(frozen, module = "cppr")]
pub struct Robot {
    pub shared: Arc<Shared>,
}

impl Robot {
    /// Checks a design.
    pub fn build(py: Python<'_>, design: RobotDesign, friction: Option<Friction>) -> PyResult<Self> {
        let robot = py
            .detach(|| cppr::design::Robot::from_design(design))
            .map_err(|problems| errors::design(py, &problems.0))?;
        Ok(Self { shared: Arc::new(Shared { robot, friction, idle: Mutex::default(), many: Memory::new() }) })
    }

    /// Checks a design that a person gives, and warns where modes do not follow it.
    fn made(py: Python<'_>, design: RobotDesign, friction: Option<Friction>) -> PyResult<Self> {
        let robot = Self::build(py, design, friction)?;
        if let Some(places) = sudden_changes(robot.design()) {
            let text = format!(
                "modes do not follow sudden changes ({places}): integrate along the robot instead, with cppr.Bundle.of(robot), or read its file with \
                 cppr.Bundle.from_toml"
            );
            errors::warn(py, "AccuracyWarning", &text)?;
        }
        Ok(robot)
    }

    fn design(&self) -> &RobotDesign {
        self.shared.robot.design()
    }
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (length, tubes, name = "robot", *, friction = None, guide = None))]
    fn new(
        length: &Bound<'_, PyAny>,
        tubes: Vec<Bound<'_, PyAny>>,
        name: &str,
        friction: Option<f64>,
        guide: Option<f64>,
    ) -> PyResult<Self> {
        let py = length.py();
        let length = crate::arrays::number("length", length)?;
        let friction = rubbing::chosen(friction, guide, None)?;
        Self::made(py, Reader::read(py, name.into(), length, &tubes)?, friction)
    }

    /// Reads a robot file.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = robot_file::read(&path).map_err(|problems| errors::file(py, &problems))?;
        Self::made(py, file.design, file.friction)
    }

    /// Reads a robot from the text of a robot file.
    #[staticmethod]
    fn from_toml_text(py: Python<'_>, text: &str) -> PyResult<Self> {
        let file = robot_file::parse(text).map_err(|problems| errors::file(py, &problems))?;
        Self::made(py, file.design, file.friction)
    }

    /// Writes a robot file that reads back as this robot.
    fn to_toml(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let text = self.to_toml_text(py)?;
        // Whole or not at all.
        let mut draft = path.clone().into_os_string();
        draft.push(".part");
        std::fs::write(&draft, text)?;
        Ok(std::fs::rename(&draft, &path)?)
    }

    /// The text of a robot file that reads back as this robot.
    fn to_toml_text(&self, py: Python<'_>) -> PyResult<String> {
        robot_text::write(self.design(), self.shared.friction).map_err(|problems| errors::file(py, &problems))
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        &self.design().name
    }

    /// Rest length (m).
    #[getter]
    fn length(&self) -> f64 {
        self.design().length
    }

    /// Coefficient of friction between the tubes.
    #[getter]
    fn friction(&self) -> Option<f64> {
        self.shared.friction.map(|own| own.coefficient)
    }

    /// Length of the guide below the plate in which tubes rub too (m).
    #[getter]
    fn guide(&self) -> Option<f64> {
        self.shared.friction?.guide
    }

    /// The tubes, the leader first.
    #[getter]
    fn tubes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let design = self.design();
        let list = design.tubes.iter().map(|tube| design::tube(py, tube, design.length));
        PyTuple::new(py, list.collect::<PyResult<Vec<_>>>()?)
    }

    /// Tube numbers of the followers.
    #[getter]
    fn followers(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        Ok(PyTuple::new(py, self.shared.robot.followers().collect::<Vec<_>>())?.unbind())
    }

    /// True where all centroid lines at rest lie in the X-Y plane.
    #[getter]
    fn is_planar(&self) -> bool {
        self.shared.robot.is_planar()
    }

    /// Fields of a tube at rest abscissae.
    #[pyo3(signature = (x, tube = 1))]
    fn fields<'py>(&self, x: &Bound<'py, PyAny>, tube: i64) -> PyResult<Bound<'py, PyDict>> {
        let py = x.py();
        let robot = &self.shared.robot;
        let Some(index) = usize::try_from(tube - 1).ok().filter(|t| *t < robot.tube_count()) else {
            let text = format!("there is no tube {tube}; this robot has tubes 1 to {}", robot.tube_count());
            return Err(errors::command(py, text));
        };
        let x: Vec<f64> = unmasked("x", x)?
            .extract()
            .map_err(|_| errors::wrong_type("x", "a one-dimensional array of numbers", x))?;
        if let Some(bad) = x.iter().find(|x| x.is_nan() || **x > robot.length()) {
            let text = format!("x is {bad} m; abscissae end at the tip, {} m", robot.length());
            return Err(PyValueError::new_err(text));
        }
        let values: Vec<_> = x.iter().map(|&x| robot.fields_at(index, x)).collect();
        let fields = PyDict::new(py);
        let add = |name: &str, get: fn(&cppr::design::FieldValues) -> f64| {
            fields.set_item(name, line(py, values.iter().map(get)))
        };
        add("centroid_offset", |f| f.centroid_offset)?;
        add("bending_y", |f| f.bending_y)?;
        add("bending_z", |f| f.bending_z)?;
        add("torsion", |f| f.torsion)?;
        add("axial", |f| f.axial)?;
        add("mass_per_length", |f| f.mass_per_length)?;
        add("direction", |f| f.direction)?;
        let depth = |x: f64| match &self.design().tubes[index] {
            TubeDesign::Notched(tube) if x >= 0.0 || tube.below == BelowPlate::Continued => {
                tube.depth.eval(x.max(0.0), robot.length())[0]
            }
            TubeDesign::Notched(_) => 0.0,
            TubeDesign::Stiffness(_) => f64::NAN,
        };
        fields.set_item("depth", line(py, x.iter().map(|&x| depth(x))))?;
        Ok(fields)
    }

    /// How many times as many modes as usual some commands need, or bear with.
    #[pyo3(signature = (commands, accuracy = ACCURACY, settings = None), text_signature = "($self, commands, accuracy=0.0001, settings=None)")]
    fn fewest_modes<'py>(
        &self,
        py: Python<'py>,
        commands: Vec<Bound<'py, PyDict>>,
        accuracy: f64,
        settings: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if !(accuracy > 0.0 && accuracy <= 1.0) {
            let text =
                format!("accuracy is {accuracy}; it is a part of the robot's length above 0 and up to 1");
            return Err(PyValueError::new_err(text));
        }
        let module = py.import("cppr._design")?;
        let settings = settings.map_or_else(|| module.getattr("Settings")?.call0(), Ok)?;
        let with = |refine: f64| -> PyResult<Bound<'py, PyAny>> {
            let changes = PyDict::new(py);
            changes.set_item("refine", refine)?;
            py.import("dataclasses")?.getattr("replace")?.call((&settings,), Some(&changes))
        };
        let usual = with(1.0)?;
        let (resolved, _) = crate::command::settings(Some(&usual))?;
        let read = |own: &Bound<'py, PyDict>| -> PyResult<Command> {
            let known = ["pull", "rotate", "tension", "torque", "tip_force", "tip_moment", "loads"];
            for key in own.keys() {
                let key: String = key.extract()?;
                if !known.contains(&key.as_str()) {
                    let text = format!("a command says {}; it has no {key}", known.join(", "));
                    return Err(PyValueError::new_err(text));
                }
            }
            let given = known.iter().map(|key| own.get_item(key)).collect::<PyResult<Vec<_>>>()?;
            let get = |index: usize| given[index].as_ref();
            let asked = Asked {
                drives: [get(0), get(1), get(2), get(3)],
                tip_force: get(4),
                tip_moment: get(5),
                loads: get(6),
                settings: Some(&usual),
            };
            Ok(asked.read(&self.shared.robot)?.0)
        };
        let commands = commands.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        let found = stoppable(py, |stop| {
            self.shared.with(|solver| {
                solver.set_settings(resolved)?;
                for command in &commands {
                    if let Err(problem) = solver.check(command) {
                        return Ok(Err(problem));
                    }
                }
                solver.stop_by(Some(Arc::clone(stop)));
                let found = solver.fewest_modes(&commands, accuracy);
                solver.stop_by(None);
                Ok(Ok(found))
            })
        })?;
        let found = found.map_err(|problem: SettingsProblem| errors::command(py, problem))?;
        let found = found.map_err(|problem| errors::command(py, problem))?;
        if found.known == 0 {
            let text = "no command has an equilibrium whose discretisation error is known, which the printed formulation never has";
            return Err(errors::error(py, "NoEquilibrium", text));
        }
        with(found.settings.resolution.multiple_of(resolved.resolution).unwrap_or(1.0))
    }

    /// The equilibrium under a command.
    #[pyo3(signature = (pull = None, rotate = None, tension = None, torque = None, *, tip_force = None, tip_moment = None, loads = None, start = None, settings = None, accuracy = Some(ACCURACY)), text_signature = "($self, pull=None, rotate=None, tension=None, torque=None, *, tip_force=None, tip_moment=None, loads=None, start=None, settings=None, accuracy=0.0001)")]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        pull: Option<Bound<'py, PyAny>>,
        rotate: Option<Bound<'py, PyAny>>,
        tension: Option<Bound<'py, PyAny>>,
        torque: Option<Bound<'py, PyAny>>,
        tip_force: Option<Bound<'py, PyAny>>,
        tip_moment: Option<Bound<'py, PyAny>>,
        loads: Option<Bound<'py, PyAny>>,
        start: Option<PyRef<'py, Equilibrium>>,
        settings: Option<Bound<'py, PyAny>>,
        accuracy: Option<f64>,
    ) -> PyResult<Bound<'py, Equilibrium>> {
        if let Some(part) = accuracy
            && !(part > 0.0 && part <= 1.0)
        {
            return Err(PyValueError::new_err(format!(
                "accuracy is {part}; it is a part of the robot's length above 0 and up to 1, or None for the modes of the settings"
            )));
        }
        let asked = Asked {
            drives: [pull.as_ref(), rotate.as_ref(), tension.as_ref(), torque.as_ref()],
            tip_force: tip_force.as_ref(),
            tip_moment: tip_moment.as_ref(),
            loads: loads.as_ref(),
            settings: settings.as_ref(),
        };
        let (command, settings) = asked.read(&self.shared.robot)?;
        let start = start.as_ref().map(|start| start.start(&self.shared)).transpose()?;
        let found = py.detach(|| {
            self.shared.with(|solver| {
                solver.set_settings(settings)?;
                let solved = match start {
                    None => solver.solve(&command),
                    Some(start) => solver.solve_from(&command, start),
                };
                Ok(solved.and_then(|found| {
                    // Where a solve from rest finds no stable equilibrium, the path from rest may lead to one.
                    let lost = start.is_none() && found.status() != Status::Converged;
                    let followed = if lost { solver.follow(&command) } else { None };
                    let (found, folds) =
                        followed.map_or((found, Vec::new()), |own| (own.equilibrium, own.folds));
                    Ok(match accuracy {
                        Some(part) if start.is_none() => {
                            let (found, error) = solver.resolve(found, part)?;
                            (found, error, folds)
                        }
                        _ => (found, None, folds),
                    })
                }))
            })
        });
        let found = found.map_err(|problem: SettingsProblem| errors::command(py, problem))?;
        let (found, error, folds) = found.map_err(|problem| errors::refused(py, &problem))?;
        if let Some(first) = folds.first() {
            let text = format!(
                "driven from rest the robot snaps at {:.1} % of this command; this stable shape lies beyond, where the path of equilibria leads past its folds",
                100.0 * first
            );
            errors::warn(py, "SnapWarning", &text)?;
        }
        let length = self.shared.robot.length();
        if let (Some(own), Some(part)) = (error, accuracy)
            && own.tip > part * length
        {
            let text = format!(
                "the tip is within {:.1e} of the length only, not {part:.1e}: the fields of this robot change faster along it than four times \
                 as many modes follow; cppr.Bundle.of(robot) solves without modes",
                own.tip / length
            );
            errors::warn(py, "AccuracyWarning", &text)?;
        }
        let status = found.status();
        if error.is_some_and(|own| !own.confirms(status)) {
            let text = "the modes and the integration without modes do not agree on its stability: the robot is next to a snap";
            errors::warn(py, "AccuracyWarning", text)?;
        }
        let why = (!status.is_equilibrium()).then(|| explained(&self.shared.robot, &command, found.status()));
        let found = Equilibrium::resolved(Arc::clone(&self.shared), found, error).into_pyobject(py)?;
        match why {
            None => Ok(found),
            Some(why) => Err(errors::no_equilibrium(py, status, &why, found.into_any())),
        }
    }

    /// Pickled and copied as its design, to the last digit.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, own) = (slf.py(), slf.get());
        let state = stored::write(&(own.design(), rubbing::stored(own.shared.friction)))?;
        let restore = py.import("cppr._cppr")?.getattr("_robot")?;
        Ok((restore, (PyBytes::new(py, &state), stored::VERSION).into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        let design = self.design();
        format!("Robot({}: {} tubes, {:.1} mm)", design.name, design.tubes.len(), design.length * 1e3)
    }
}

/// A robot from what [`Robot::__reduce__`] stored.
#[pyfunction]
pub fn _robot(py: Python<'_>, state: &[u8], version: &str) -> PyResult<Robot> {
    let (design, friction) = stored::read(state, version)?;
    Robot::build(py, design, rubbing::restored(friction))
}
