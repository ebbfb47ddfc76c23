//! The classes `Bundle` and `BundleEquilibrium`: robots with parts, joints, free tips and curved tubes.

use crate::analysis;
use crate::arrays::{dynamic, line, matrix, number, table, vector};
use crate::command::{KEYWORDS, add_loads, full_turns, tube_number};
use crate::design::Reader;
use crate::robot::Robot;
use crate::watch::stoppable;
use crate::{clearance, errors, rubbing, stored};
use cppr::analysis::{Asked, BundleAnalysis, Demand, Integrated, Sensitivity, absurd_bundle_demand};
use cppr::bundle::solve::{
    BundleCommand, BundleEquilibrium as Found, BundleSolver, TubeDrive, TubeEffort, load_behind_plate,
};
use cppr::bundle::{BundleDesign, BundleSection, Friction, HistoryPoint, SlipHistory};
use cppr::design::RobotDesign;
use cppr::solve::{CommandProblem, Freedom, Input, Quantity};
use cppr::statics::{Loads, Wrench};
use cppr_io::Problems;
use cppr_io::bundle_file::{self, Described};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Most sections of one shape.
const MOST: f64 = 1e5;
/// Greatest error that a step of the integration may make in a loop.
const LOOSEST: f64 = 1e-4;

/// A checked robot of parts and joints. Immutable.
#[pyclass(frozen, module = "cppr")]
#[expect(clippy::struct_field_names, reason = "the kernel's type of the same name")]
pub struct Bundle {
    pub bundle: Arc<cppr::bundle::Bundle>,
    pub design: Arc<BundleDesign>,
    /// How its tubes rub, where that is known.
    pub friction: Option<Friction>,
}

impl Bundle {
    pub fn build(py: Python<'_>, design: BundleDesign, friction: Option<Friction>) -> PyResult<Self> {
        let bundle = py
            .detach(|| cppr::bundle::Bundle::new(&design))
            .map_err(|problems| errors::design(py, &problems.0))?;
        Ok(Self { bundle: Arc::new(bundle), design: Arc::new(design), friction })
    }

    /// That of a file.
    fn read(py: Python<'_>, own: Result<Described, Problems>) -> PyResult<Self> {
        let own = own.map_err(|problems| errors::file(py, &problems))?;
        let friction = own.friction();
        Self::build(py, own.into_bundle(), friction)
    }

    /// Refuses what cannot be asked of this robot, and warns of what looks like another unit.
    fn check(&self, py: Python<'_>, command: &BundleCommand, stretch: bool) -> PyResult<()> {
        command.check(&self.design, &self.bundle, stretch).map_err(|problem| errors::command(py, problem))?;
        match absurd_bundle_demand(&self.bundle, command) {
            // Those were warned of where they were read.
            Some(Demand { asked: Asked::Actuator(Input { is_motion: true, .. }), .. }) | None => Ok(()),
            Some(demand) => errors::warn(py, "UnitWarning", &demand.to_string()),
        }
    }
}

#[pymethods]
impl Bundle {
    #[new]
    #[pyo3(signature = (tubes, joints = None, name = "robot", *, friction = None, guide = None))]
    fn new(
        py: Python<'_>,
        tubes: Vec<Bound<'_, PyAny>>,
        joints: Option<Vec<Bound<'_, PyAny>>>,
        name: &str,
        friction: Option<f64>,
        guide: Option<f64>,
    ) -> PyResult<Self> {
        let friction = rubbing::chosen(friction, guide, None)?;
        Self::build(py, Reader::bundle(py, name.into(), &tubes, joints.as_deref())?, friction)
    }

    /// Reads a robot file of any kind.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::read(py, bundle_file::read(path))
    }

    /// Reads a robot from the text of a robot file of any kind.
    #[staticmethod]
    fn from_toml_text(py: Python<'_>, text: &str) -> PyResult<Self> {
        Self::read(py, bundle_file::parse_either(text))
    }

    /// The same robot without modes: integrated along its length.
    #[staticmethod]
    fn of(py: Python<'_>, robot: PyRef<'_, Robot>) -> PyResult<Self> {
        Self::build(py, robot.shared.robot.design().into(), robot.shared.friction)
    }

    /// The same robot with all of its metal on the curve of unloading.
    fn unloading(&self, py: Python<'_>) -> PyResult<Option<Self>> {
        self.design.unloading().map(|lower| Self::build(py, lower, self.friction)).transpose()
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        &self.design.name
    }

    /// Coefficient of friction between the tubes.
    #[getter]
    fn friction(&self) -> Option<f64> {
        self.friction.map(|own| own.coefficient)
    }

    /// Length of the guide below the plate in which tubes rub too (m).
    #[getter]
    fn guide(&self) -> Option<f64> {
        self.friction?.guide
    }

    /// Greatest length of a tube above the baseplate (m).
    #[getter]
    fn length(&self) -> f64 {
        self.bundle.length()
    }

    /// Lengths of the tubes above the baseplate (m), shape (n,).
    #[getter]
    fn lengths(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        line(py, self.design.tubes.iter().map(cppr::bundle::TubeParts::length)).unbind()
    }

    /// The equilibrium under a command.
    #[pyo3(signature = (pull = None, rotate = None, tension = None, torque = None, *, tip_force = None, tip_moment = None, loads = None, start = None, stretch = false, loop_tolerance = None))]
    fn solve(
        &self,
        py: Python<'_>,
        pull: Option<Bound<'_, PyAny>>,
        rotate: Option<Bound<'_, PyAny>>,
        tension: Option<Bound<'_, PyAny>>,
        torque: Option<Bound<'_, PyAny>>,
        tip_force: Option<Bound<'_, PyAny>>,
        tip_moment: Option<Bound<'_, PyAny>>,
        loads: Option<Bound<'_, PyAny>>,
        start: Option<PyRef<'_, BundleEquilibrium>>,
        stretch: bool,
        loop_tolerance: Option<f64>,
    ) -> PyResult<BundleEquilibrium> {
        let wrong = match loop_tolerance {
            Some(_) if start.is_none() => {
                Some("loop_tolerance is of a step from another equilibrium: give start".to_owned())
            }
            Some(own) if !(own > 0.0 && own <= LOOSEST) => {
                Some(format!("loop_tolerance is {own}; it must be above 0 and at most {LOOSEST:e}"))
            }
            _ => None,
        };
        if let Some(text) = wrong {
            return Err(PyValueError::new_err(text));
        }
        let mut drives = vec![TubeDrive::HELD; self.design.tubes.len()];
        put(py, &mut drives, &[pull, rotate, tension, torque])?;
        let all = read_loads(tip_force.as_ref(), tip_moment.as_ref(), loads.as_ref())?;
        let start = match &start {
            // A robot that was stored and read again is the same robot.
            Some(start) if !Arc::ptr_eq(&start.bundle, &self.bundle) && start.design != self.design => {
                let text = "start is an equilibrium of another robot; give one of this robot";
                return Err(PyValueError::new_err(text));
            }
            other => other.as_ref().map(|start| &start.found),
        };
        let command = BundleCommand { drives, loads: all };
        self.check(py, &command, stretch)?;
        let found = py.detach(|| {
            let mut solver = BundleSolver::new(&self.bundle).with_stretch(stretch);
            match (start, loop_tolerance) {
                (None, _) => solver.solve(&command),
                (Some(start), None) => solver.solve_from(&command, start),
                (Some(start), Some(tolerance)) => {
                    let mut found = start.clone();
                    solver.with_loop_tolerance(tolerance).solve_into(&command, &mut found);
                    found
                }
            }
        });
        if !found.converged {
            return Err(errors::error(py, "NoEquilibrium", found.verdict()));
        }
        if let Some(label) = load_behind_plate(&command, &found) {
            let text =
                format!("a load acts at {label} m on tube 1, which was drawn in behind the plate there");
            return Err(errors::command(py, text));
        }
        Ok(BundleEquilibrium {
            bundle: Arc::clone(&self.bundle),
            design: Arc::clone(&self.design),
            friction: self.friction,
            found,
            stretch,
        })
    }

    /// A history of commands from rest, with friction between the tubes.
    #[pyo3(signature = (waypoints, friction = None, *, guide = None, steps = 14, tip_force = None, loads = None, stretch = false))]
    fn cycle<'py>(
        &self,
        py: Python<'py>,
        waypoints: Vec<Bound<'py, PyDict>>,
        friction: Option<f64>,
        guide: Option<f64>,
        steps: u32,
        tip_force: Option<Bound<'py, PyAny>>,
        loads: Option<Bound<'py, PyAny>>,
        stretch: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let friction = rubbing::needed(friction, guide, self.friction)?;
        let loads = read_loads(tip_force.as_ref(), None, loads.as_ref())?;
        if steps == 0 || waypoints.len() < 2 {
            let text = "a history takes at least two waypoints, and at least one step from each to the next";
            return Err(PyValueError::new_err(text));
        }
        let read = |own: &Bound<'py, PyDict>| -> PyResult<BundleCommand> {
            let names = KEYWORDS.map(|quantity| quantity.keyword);
            for key in own.keys() {
                let key: String = key.extract()?;
                if !names.contains(&key.as_str()) {
                    let text = format!("a waypoint says {}; it has no {key}", names.join(", "));
                    return Err(PyValueError::new_err(text));
                }
            }
            let keywords: Vec<_> = names.iter().map(|name| own.get_item(name)).collect::<PyResult<_>>()?;
            let keywords = <[_; 4]>::try_from(keywords).unwrap_or_default();
            let mut drives = vec![TubeDrive::HELD; self.design.tubes.len()];
            put(py, &mut drives, &keywords)?;
            Ok(BundleCommand { drives, loads: loads.clone() })
        };
        let commands: Vec<BundleCommand> = waypoints.iter().map(read).collect::<PyResult<_>>()?;
        commands.iter().try_for_each(|command| self.check(py, command, stretch))?;
        let points = stoppable(py, |stop| {
            let mut solver = BundleSolver::new(&self.bundle).with_stretch(stretch);
            let mut state = SlipHistory::new(&mut solver, friction)?;
            let first = commands.first()?;
            if *first != solver.held() && !state.drive(first) {
                return None;
            }
            let mut points: Vec<(usize, HistoryPoint)> = vec![(0, state.point())];
            for (leg, ends) in commands.windows(2).enumerate() {
                for step in 1..=steps {
                    if stop.load(Ordering::Relaxed) {
                        return None;
                    }
                    let own = ends[1].on_the_way_from(&ends[0], f64::from(step) / f64::from(steps));
                    if !state.drive(&own) {
                        return None;
                    }
                    points.push((leg + 1, state.point()));
                }
            }
            Some(points)
        })?;
        let text = "a step of the history found no equilibrium; move less, or in more steps";
        let points = points.ok_or_else(|| errors::error(py, "NoEquilibrium", text))?;
        rubbing::history(py, &points)
    }

    /// Pickled and copied as its design, to the last digit.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, own) = (slf.py(), slf.get());
        let state = stored::write(&(&*own.design, rubbing::stored(own.friction)))?;
        let arguments = (PyBytes::new(py, &state), stored::VERSION);
        let restore = py.import("cppr._cppr")?.getattr("_bundle")?;
        Ok((restore, arguments.into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        let (tubes, joints) = (self.design.tubes.len(), self.design.joints.len());
        format!("Bundle({}: {tubes} tubes, {joints} joints, {:.1} mm)", self.name(), self.length() * 1e3)
    }
}

/// Puts what the keywords `pull`, `rotate`, `tension`, `torque` say into the drives of all tubes; the rest stays.
pub fn put(
    py: Python<'_>,
    drives: &mut [TubeDrive],
    keywords: &[Option<Bound<'_, PyAny>>; 4],
) -> PyResult<()> {
    let mut given: Vec<Input> = Vec::new();
    let mut set = |quantity: Quantity, tube: usize, value: f64| -> PyResult<()> {
        let input = quantity.of_tube(tube);
        let refuse =
            |problem: &dyn std::fmt::Display| errors::command(py, format!("{}: {problem}", quantity.keyword));
        if !value.is_finite() {
            return Err(refuse(&format!("{value} is no finite number")));
        }
        if let Some(&earlier) = given.iter().find(|own| own.is_same_freedom(input)) {
            return Err(refuse(&CommandProblem::Twice { earlier, later: input }));
        }
        let count = drives.len();
        let Some(own) = tube.checked_sub(1).and_then(|index| drives.get_mut(index)) else {
            return Err(refuse(&format!("there is no such tube; this robot has tubes 1 to {count}")));
        };
        given.push(input);
        *(match input.freedom {
            Freedom::PushPull => &mut own.translation,
            Freedom::Rotation => &mut own.rotation,
        }) = input.prescribed(value);
        full_turns(quantity, value).map_or(Ok(()), |text| errors::warn(py, "UnitWarning", &text))
    };
    for (quantity, value) in KEYWORDS.into_iter().zip(keywords) {
        let Some(value) = value else { continue };
        if let Ok(tubes) = value.cast::<PyDict>() {
            for (tube, value) in tubes {
                set(quantity, tube_number(quantity, &tube)?, number(quantity.keyword, &value)?)?;
            }
        } else {
            set(quantity, 2, number(quantity.keyword, value)?)?;
        }
    }
    Ok(())
}

pub fn read_loads(
    tip_force: Option<&Bound<'_, PyAny>>,
    tip_moment: Option<&Bound<'_, PyAny>>,
    loads: Option<&Bound<'_, PyAny>>,
) -> PyResult<Loads> {
    let mut all = Loads::none();
    if tip_force.is_some() || tip_moment.is_some() {
        let read = |what, value: Option<&Bound<'_, PyAny>>| {
            value.map_or(Ok(cppr::Vector3::zeros()), |value| vector(what, value))
        };
        let mut wrench = Wrench::tip_force(read("tip_force", tip_force)?);
        wrench.moment = read("tip_moment", tip_moment)?;
        all.wrenches.push(wrench);
    }
    if let Some(list) = loads {
        add_loads(&mut all, list)?;
    }
    Ok(all)
}

/// A bundle under a command.
#[pyclass(frozen, module = "cppr")]
pub struct BundleEquilibrium {
    bundle: Arc<cppr::bundle::Bundle>,
    design: Arc<BundleDesign>,
    pub friction: Option<Friction>,
    pub found: Found,
    stretch: bool,
}

impl BundleEquilibrium {
    fn with<R>(&self, run: impl FnOnce(&BundleSolver<'_>) -> R) -> R {
        run(&BundleSolver::new(&self.bundle).with_stretch(self.stretch))
    }

    /// What stands for an equilibrium of a robot of tubes of one length, its stability counted from rest.
    pub fn of(design: &RobotDesign, friction: Option<Friction>, own: Integrated, stretch: bool) -> Self {
        let design = Arc::new(design.into());
        let found = own.solver().solve_from(own.equilibrium.command(), &own.equilibrium);
        Self { bundle: own.bundle, design, friction, found, stretch }
    }

    /// Another equilibrium of the same robot.
    pub fn other(&self, found: Found) -> Self {
        Self {
            bundle: Arc::clone(&self.bundle),
            design: Arc::clone(&self.design),
            friction: self.friction,
            found,
            stretch: self.stretch,
        }
    }

    /// Runs one long analysis, which ends where it is told to stop.
    pub fn analysed<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut BundleAnalysis<'_>) -> R + Send,
    ) -> PyResult<R> {
        stoppable(py, |stop| {
            let solver = BundleSolver::new(&self.bundle).with_stretch(self.stretch);
            let mut analysis = BundleAnalysis::new(solver, &self.design);
            analysis.stop_by(Some(Arc::clone(stop)));
            work(&mut analysis)
        })
    }

    /// Runs what returns soon after the flag is set, with a solver of its robot.
    pub fn stoppable<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut BundleSolver<'_>, &AtomicBool) -> R + Send,
    ) -> PyResult<R> {
        stoppable(py, |stop| {
            work(&mut BundleSolver::new(&self.bundle).with_stretch(self.stretch), stop.as_ref())
        })
    }

    fn derivatives(&self, py: Python<'_>) -> PyResult<Sensitivity> {
        let found = py.detach(|| self.with(|solver| solver.sensitivity(&self.found)));
        found.ok_or_else(|| {
            let text = "the tangent is singular here, at a fold: nothing has a derivative";
            errors::error(py, "NoEquilibrium", text)
        })
    }

    fn efforts(&self, py: Python<'_>, get: impl Fn(&TubeEffort) -> f64) -> Py<PyArray1<f64>> {
        line(py, self.found.efforts.iter().map(get)).unbind()
    }
}

#[pymethods]
impl BundleEquilibrium {
    /// Its robot.
    #[getter]
    fn robot(&self) -> Bundle {
        Bundle { bundle: Arc::clone(&self.bundle), design: Arc::clone(&self.design), friction: self.friction }
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.design.name
    }

    /// Labels (m) at which tubes are joined: per joint a dict from tube number.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let one = |joint: &Vec<(usize, f64)>| {
            let own = PyDict::new(py);
            joint.iter().try_for_each(|&(tube, label)| own.set_item(tube + 1, label))?;
            Ok(own)
        };
        self.design.joints.iter().map(one).collect()
    }

    /// Has the determinant of the conditions the sign that it has at rest?
    #[getter]
    fn stable(&self) -> bool {
        self.found.stable
    }

    /// Centre of the last tip (m), shape (3,).
    #[getter]
    fn tip_position(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        line(py, self.found.tip.iter().copied()).unbind()
    }

    /// Columns: tangent, direction of the centroid, normal to both; shape (3, 3).
    #[getter]
    fn tip_rotation(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        matrix(py, &self.found.frame)
    }

    /// Label of every tube at the plate (m), shape (n,).
    #[getter]
    fn pull(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.efforts(py, |own| own.label)
    }

    /// Rotation of every tube at the plate (rad), shape (n,).
    #[getter]
    fn rotation(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.efforts(py, |own| own.rotation)
    }

    /// Force with which every motor pulls (N), shape (n,).
    #[getter]
    fn tension(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.efforts(py, |own| own.force)
    }

    /// Torque of every motor (N m), shape (n,).
    #[getter]
    fn torque(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.efforts(py, |own| own.torque)
    }

    /// Length of the centreline (m).
    #[getter]
    fn length(&self) -> f64 {
        self.found.length
    }

    /// Estimated error of the tip (m).
    #[getter]
    fn tip_error(&self) -> f64 {
        self.found.error[0]
    }

    /// Estimated error of the forces (N).
    #[getter]
    fn force_error(&self) -> f64 {
        self.found.error[1]
    }

    /// Newton steps.
    #[getter]
    fn iterations(&self) -> usize {
        self.found.iterations
    }

    /// What the columns of `jacobian` are.
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.found.command().inputs().iter().map(analysis::input))
    }

    /// Slopes of the tip by the motors, shape (6, 2 n).
    #[getter]
    fn jacobian(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.tip_jacobian)
    }

    /// The same in the frame of the tip.
    #[getter]
    fn jacobian_body(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.tip_jacobian_body)
    }

    /// The conjugate of every input by every input, shape (2 n, 2 n).
    #[getter]
    fn response(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.response)
    }

    /// Slopes of the tip by a wrench on it, shape (6, 6).
    #[getter]
    fn compliance(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        matrix(py, &self.derivatives(py)?.compliance)
    }

    /// The conjugate of every input by a wrench on the tip, shape (2 n, 6).
    #[getter]
    fn response_by_wrench(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.response_by_wrench)
    }

    /// Forces with which neighbours press on each other.
    fn contact<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.with(|solver| rubbing::contact(py, solver, &self.found))
    }

    /// The equilibria between which friction leaves the pose.
    #[pyo3(signature = (coefficient = None, guide = None))]
    fn friction<'py>(
        &self,
        py: Python<'py>,
        coefficient: Option<f64>,
        guide: Option<f64>,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let friction = rubbing::needed(coefficient, guide, self.friction)?;
        self.with(|solver| rubbing::bounds(py, solver, &self.found, &friction))
    }

    /// What gaps between the tubes make of the pose, estimated.
    #[pyo3(signature = (gap = None))]
    fn clearance_estimate<'py>(&self, py: Python<'py>, gap: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        let gaps = clearance::gaps(gap, self.design.gaps())?;
        self.with(|solver| clearance::estimate(py, &mut solver.clone(), &self.found, &gaps))
    }

    /// The equilibrium with gaps between the tubes.
    #[pyo3(signature = (gap = None, *, guide = None, elements = 120))]
    fn with_clearance<'py>(
        &self,
        py: Python<'py>,
        gap: Option<f64>,
        guide: Option<(f64, f64)>,
        elements: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let asked = clearance::asked(gap, self.design.gaps(), guide, elements)?;
        let found = py.detach(|| self.with(|solver| solver.with_clearance(&self.found, &asked)));
        clearance::solved(py, found)
    }

    /// Fields at sections at most `spacing` (m) apart, from the plate to the last tip.
    #[pyo3(signature = (spacing = None))]
    fn sample<'py>(&self, py: Python<'py>, spacing: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        let spacing = spacing.unwrap_or(0.01 * self.found.length);
        if spacing.is_nan() || spacing * MOST < self.found.length {
            let text = format!(
                "spacing is {spacing} m; it must be positive, and one shape takes up to {MOST:.0} sections"
            );
            return Err(PyValueError::new_err(text));
        }
        let sections = py.detach(|| self.with(|solver| solver.shape(&self.found, spacing)));
        let fields = PyDict::new(py);
        fields.set_item("length", line(py, sections.iter().map(|s| s.length)))?;
        let centres = sections.iter().flat_map(|s| s.centre.iter().copied()).collect();
        fields.set_item("centre", table(py, centres, 3)?)?;
        let frames = sections.iter().flat_map(|s| crate::arrays::rows(&s.frame)).collect();
        fields.set_item("frame", table(py, frames, 9)?.reshape([sections.len(), 3, 3])?)?;
        let tubes = self.found.efforts.len();
        let add = |name: &str, get: &dyn Fn(&cppr::bundle::TubeSection) -> f64| -> PyResult<()> {
            let own = |s: &BundleSection, tube: usize| {
                s.tubes.iter().find(|t| t.tube == tube).map_or(f64::NAN, get)
            };
            let values = sections.iter().flat_map(|s| (0..tubes).map(move |tube| own(s, tube))).collect();
            fields.set_item(name, table(py, values, tubes)?)
        };
        add("abscissa", &|t| t.label)?;
        add("angle", &|t| t.angle)?;
        add("centroid_offset", &|t| t.centroid_offset)?;
        add("tension", &|t| t.tension)?;
        add("torque", &|t| t.torque)?;
        add("curvature_y", &|t| t.strains[0])?;
        add("curvature_z", &|t| t.strains[1])?;
        add("twist", &|t| t.strains[2])?;
        Ok(fields)
    }

    /// Pickled and copied as its robot and its own numbers; nothing is solved again.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, own) = (slf.py(), slf.get());
        let state = stored::write(&(&own.found, own.stretch))?;
        let arguments = (own.robot(), PyBytes::new(py, &state), stored::VERSION);
        let restore = py.import("cppr._cppr")?.getattr("_bundle_equilibrium")?;
        Ok((restore, arguments.into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        let tip = self.found.tip * 1e3;
        let stable = if self.found.stable { "stable" } else { "unstable" };
        format!(
            "BundleEquilibrium({}: {stable}; tip ({:.3}, {:.3}, {:.3}) mm)",
            self.design.name, tip.x, tip.y, tip.z
        )
    }
}

/// A robot from what [`Bundle::__reduce__`] stored.
#[pyfunction]
pub fn _bundle(py: Python<'_>, state: &[u8], version: &str) -> PyResult<Bundle> {
    let (design, friction) = stored::read(state, version)?;
    Bundle::build(py, design, rubbing::restored(friction))
}

/// An equilibrium from what [`BundleEquilibrium::__reduce__`] stored.
#[pyfunction]
pub fn _bundle_equilibrium(
    robot: PyRef<'_, Bundle>,
    state: &[u8],
    version: &str,
) -> PyResult<BundleEquilibrium> {
    let (found, stretch): (Found, bool) = stored::read(state, version)?;
    if !found.fits(&robot.bundle) {
        return Err(stored::unreadable("another robot", version));
    }
    Ok(BundleEquilibrium {
        bundle: Arc::clone(&robot.bundle),
        design: Arc::clone(&robot.design),
        friction: robot.friction,
        found,
        stretch,
    })
}
