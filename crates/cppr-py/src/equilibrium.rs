//! The classes `Equilibrium` and `Shape`. What costs more than reading a number is computed when it is asked for, once.

use crate::arrays::{block, dynamic, line, matrix, rotations, rows, table, unmasked};
use crate::bundle::BundleEquilibrium;
use crate::robot::{Robot, Shared};
use crate::{analysis, clearance, command, errors, rubbing, stored};
use cppr::Vector3;
use cppr::analysis::{Accuracy, Against, Integrated};
use cppr::analysis::{Section, Sensitivity, total_bend};
use cppr::kinematics::TipPose;
use cppr::solve::{ActuatorState, SavedEquilibrium, Status};
use numpy::{PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::fmt::Write;
use std::sync::{Arc, OnceLock};

/// Sections of the shape where no labels are given.
const SECTIONS: usize = 101;
/// Most sections of one shape.
const MOST: usize = 1_000_000;

/// The state of a robot under a command.
#[pyclass(frozen, module = "cppr")]
pub struct Equilibrium {
    pub shared: Arc<Shared>,
    pub found: cppr::solve::Equilibrium,
    tip: OnceLock<TipPose>,
    derivatives: OnceLock<Option<Sensitivity>>,
    critical: OnceLock<(f64, Vector3<f64>)>,
    accuracy: OnceLock<Option<Accuracy>>,
    shape: OnceLock<Py<Shape>>,
}

impl Equilibrium {
    pub fn new(shared: Arc<Shared>, found: cppr::solve::Equilibrium) -> Self {
        Self {
            shared,
            found,
            tip: OnceLock::new(),
            derivatives: OnceLock::new(),
            critical: OnceLock::new(),
            accuracy: OnceLock::new(),
            shape: OnceLock::new(),
        }
    }

    /// The same with an error that is known.
    pub fn resolved(
        shared: Arc<Shared>,
        found: cppr::solve::Equilibrium,
        accuracy: Option<Accuracy>,
    ) -> Self {
        let own = Self::new(shared, found);
        if accuracy.is_some() {
            own.accuracy.get_or_init(|| accuracy);
        }
        own
    }

    /// As the start of another solve of the same robot.
    pub fn start(&self, shared: &Arc<Shared>) -> PyResult<&cppr::solve::Equilibrium> {
        // A robot that was stored and read again is the same robot.
        if Arc::ptr_eq(&self.shared, shared) || self.shared.robot.design() == shared.robot.design() {
            return Ok(&self.found);
        }
        Err(PyValueError::new_err("start is an equilibrium of another robot; give one of this robot"))
    }

    fn tip(&self) -> &TipPose {
        self.tip.get_or_init(|| self.shared.with(|w| w.tip(&self.found)))
    }

    fn derivatives(&self, py: Python<'_>) -> PyResult<&Sensitivity> {
        let found = self.derivatives.get_or_init(|| self.shared.with(|w| w.sensitivity(&self.found).ok()));
        found.as_ref().ok_or_else(|| {
            let text = if self.found.status().is_equilibrium() {
                "the tangent is singular: the equilibrium stands at a fold, where it has no derivative"
            } else {
                "there is no equilibrium to differentiate"
            };
            errors::error(py, "NoEquilibrium", text)
        })
    }

    /// Margin to instability, and where the tip goes under the critical mode.
    fn critical(&self) -> &(f64, Vector3<f64>) {
        self.critical.get_or_init(|| {
            let judged = self.shared.with(|w| {
                let own = w.stability(&self.found)?;
                Some((own.margin, own.tip_direction))
            });
            judged.unwrap_or((f64::NAN, Vector3::repeat(f64::NAN)))
        })
    }

    fn integrated(&self, py: Python<'_>) -> PyResult<Integrated> {
        let own = py.detach(|| self.shared.with(|w| w.integrated(&self.found)));
        let text = "contact and friction need an equilibrium of the consistent formulation, rotations of the motors, and a pose that the \
                    integration along the robot confirms";
        own.ok_or_else(|| errors::error(py, "NoEquilibrium", text))
    }

    /// The same equilibrium of the bundle that is integrated in its place.
    pub fn as_bundle(&self, py: Python<'_>) -> PyResult<BundleEquilibrium> {
        let stretch = self.found.settings().resolution.stretch > 0;
        let own = self.integrated(py)?;
        Ok(py.detach(|| {
            BundleEquilibrium::of(self.found.robot().design(), self.shared.friction, own, stretch)
        }))
    }

    fn actuators<'py>(&self, py: Python<'py>, get: fn(&ActuatorState) -> f64) -> Bound<'py, PyArray1<f64>> {
        line(py, self.found.actuators().iter().map(get))
    }
}

#[pymethods]
impl Equilibrium {
    /// Forces with which neighbours press on each other.
    fn contact<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let own = self.integrated(py)?;
        rubbing::contact(py, &own.solver(), &own.equilibrium)
    }

    /// The equilibria between which friction leaves the pose.
    #[pyo3(signature = (coefficient = None, guide = None))]
    fn friction<'py>(
        &self,
        py: Python<'py>,
        coefficient: Option<f64>,
        guide: Option<f64>,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let friction = rubbing::needed(coefficient, guide, self.shared.friction)?;
        let own = self.integrated(py)?;
        rubbing::bounds(py, &own.solver(), &own.equilibrium, &friction)
    }

    /// What gaps between the tubes make of the pose, estimated.
    #[pyo3(signature = (gap = None))]
    fn clearance_estimate<'py>(&self, py: Python<'py>, gap: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        let gaps = clearance::gaps(gap, self.found.robot().gaps())?;
        let own = self.integrated(py)?;
        clearance::estimate(py, &mut own.solver(), &own.equilibrium, &gaps)
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
        let asked = clearance::asked(gap, self.found.robot().gaps(), guide, elements)?;
        let found = py.detach(|| self.shared.with(|solver| solver.with_clearance(&self.found, &asked)));
        clearance::solved(py, found)
    }

    #[getter]
    fn robot(&self) -> Robot {
        Robot { shared: Arc::clone(&self.shared) }
    }

    #[getter]
    fn status(&self) -> &'static str {
        match self.found.status() {
            Status::Converged => "converged",
            Status::Unstable => "unstable",
            Status::NotConverged(_) => "not converged",
        }
    }

    #[getter]
    fn stable(&self) -> bool {
        self.found.status() == Status::Converged
    }

    #[getter]
    fn accuracy<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let found =
            py.detach(|| *self.accuracy.get_or_init(|| self.shared.with(|w| w.accuracy(&self.found))));
        let Some(Accuracy { tip, force, torque, stable, against, reference }) = found else {
            return Ok(None);
        };
        let own = PyDict::new(py);
        own.set_item("tip", tip)?;
        own.set_item("force", force)?;
        own.set_item("torque", torque)?;
        own.set_item("margin", py.detach(|| self.shared.with(|w| w.margin_error(&self.found))))?;
        let against = match against {
            Against::Integration => "integration",
            Against::HalfTheModes => "half the modes",
        };
        own.set_item("against", against)?;
        own.set_item("reference_stable", stable)?;
        own.set_item("reference_tip", line(py, reference.iter().copied()))?;
        Ok(Some(own))
    }

    #[getter]
    fn tip_position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        line(py, self.tip().centre.iter().copied())
    }

    #[getter]
    fn tip_rotation(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        matrix(py, &self.tip().rotation)
    }

    #[getter]
    fn pull<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.actuators(py, |a| a.motion)
    }

    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.actuators(py, |a| a.rotation)
    }

    #[getter]
    fn tension<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.actuators(py, |a| a.tension)
    }

    #[getter]
    fn torque<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.actuators(py, |a| a.torque)
    }

    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        command::loads(py, &self.found.command().loads)
    }

    #[getter]
    fn elastic_energy(&self) -> f64 {
        self.found.elastic_energy()
    }

    #[getter]
    fn total_bend(&self) -> f64 {
        total_bend(&self.found)
    }

    #[getter]
    fn residual(&self) -> f64 {
        self.found.residual()
    }

    #[getter]
    fn iterations(&self) -> usize {
        self.found.statistics().iterations
    }

    #[getter]
    fn evaluations(&self) -> usize {
        self.found.statistics().evaluations
    }

    #[getter]
    fn load_steps(&self) -> usize {
        self.found.statistics().load_steps
    }

    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.derivatives(py)?.inputs.iter().map(analysis::input))
    }

    #[getter]
    fn jacobian(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.tip_jacobian)
    }

    #[getter]
    fn jacobian_body(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.tip_jacobian_body)
    }

    #[getter]
    fn response(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.response)
    }

    #[getter]
    fn compliance(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        matrix(py, &self.derivatives(py)?.compliance)
    }

    #[getter]
    fn response_by_wrench(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        dynamic(py, &self.derivatives(py)?.response_by_wrench)
    }

    #[getter]
    fn margin(&self) -> f64 {
        self.critical().0
    }

    #[getter]
    fn critical_direction<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        line(py, self.critical().1.iter().copied())
    }

    #[getter]
    fn shape(&self, py: Python<'_>) -> PyResult<Py<Shape>> {
        if let Some(shape) = self.shape.get() {
            return Ok(shape.clone_ref(py));
        }
        let shape = Py::new(py, self.sample(py, None)?)?;
        Ok(self.shape.get_or_init(|| shape).clone_ref(py))
    }

    /// Fields at given abscissae of the leader, or at a number of equal steps.
    #[pyo3(signature = (x = None))]
    fn sample(&self, py: Python<'_>, x: Option<Bound<'_, PyAny>>) -> PyResult<Shape> {
        let length = self.shared.robot.length();
        let equal = |count: usize| (0..count).map(|i| length * i as f64 / (count - 1) as f64).collect();
        let labels: Vec<f64> = match x {
            None => equal(SECTIONS),
            Some(x) => match x.extract::<i64>() {
                Ok(count) => match usize::try_from(count) {
                    Ok(count @ 2..=MOST) => equal(count),
                    _ => {
                        return Err(PyValueError::new_err(format!(
                            "a shape has from 2 to {MOST} sections, not {count}"
                        )));
                    }
                },
                Err(_) => unmasked("x", &x)?.extract().map_err(|_| {
                    errors::wrong_type(
                        "x",
                        "a number of sections or a one-dimensional array of abscissae",
                        &x,
                    )
                })?,
            },
        };
        if let Some(outside) = labels.iter().find(|x| !(0.0..=length).contains(*x)) {
            return Err(PyValueError::new_err(format!(
                "x is {outside} m; the robot reaches from 0 to {length} m"
            )));
        }
        let sampled = py.detach(|| self.shared.with(|w| w.shape_at(&self.found, &labels)));
        Shape::new(py, &sampled.sections, self.shared.robot.tube_count())
    }

    /// Pickled and copied as its robot and its own numbers; nothing is solved again.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let py = slf.py();
        let own = slf.get();
        let state = stored::write(&SavedEquilibrium::from(&own.found))?;
        let arguments = (own.robot(), PyBytes::new(py, &state), stored::VERSION);
        let restore = py.import("cppr._cppr")?.getattr("_equilibrium")?;
        Ok((restore, arguments.into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        let p = self.tip().centre * 1e3;
        let mut text = format!(
            "Equilibrium({}: {}; tip ({:.3}, {:.3}, {:.3}) mm",
            self.shared.robot.design().name,
            self.status(),
            p.x,
            p.y,
            p.z
        );
        for (tube, a) in self.found.followers() {
            let _ = write!(
                text,
                "; tube {}: {:.3} mm, {:.4} N, {:.4} rad, {:.4} N mm",
                tube,
                a.motion * 1e3,
                a.tension,
                a.rotation,
                a.torque * 1e3
            );
        }
        text + ")"
    }
}

/// Fields along a robot; n sections, N tubes.
#[pyclass(frozen, get_all, module = "cppr")]
pub struct Shape {
    x: Py<PyArray1<f64>>,
    centre: Py<PyArray2<f64>>,
    rotation: Py<PyArray3<f64>>,
    curvature: Py<PyArray2<f64>>,
    angles: Py<PyArray2<f64>>,
    energy_density: Py<PyArray1<f64>>,
    abscissa: Py<PyArray2<f64>>,
    centroid: Py<PyArray3<f64>>,
    tube_rotation: Py<PyArray4<f64>>,
    rate: Py<PyArray2<f64>>,
    strain: Py<PyArray3<f64>>,
    stretch: Py<PyArray2<f64>>,
    moment: Py<PyArray3<f64>>,
    force: Py<PyArray3<f64>>,
}

impl Shape {
    fn new(py: Python<'_>, sections: &[Section], tubes: usize) -> PyResult<Self> {
        let threes = |get: fn(&Section) -> &Vector3<f64>| {
            sections.iter().flat_map(|s| get(s).iter().copied()).collect::<Vec<f64>>()
        };
        let all = || sections.iter().flat_map(|s| &s.tubes);
        let each = |get: fn(&cppr::analysis::TubeSection) -> f64| all().map(get).collect::<Vec<f64>>();
        let vectors = |get: fn(&cppr::analysis::TubeSection) -> &Vector3<f64>| {
            all().flat_map(|t| get(t).iter().copied()).collect::<Vec<f64>>()
        };
        let n = sections.len();
        let flat = |values: Vec<f64>| table(py, values, tubes).map(Bound::unbind);
        let deep = |values: Vec<f64>| block(py, values, [tubes, 3]).map(Bound::unbind);
        let rotation = sections.iter().flat_map(|s| rows(&s.rotation)).collect();
        let angles: Vec<f64> = sections.iter().flat_map(|s| s.angles.iter().copied()).collect();
        Ok(Self {
            x: line(py, sections.iter().map(|s| s.label)).unbind(),
            centre: table(py, threes(|s| &s.centre), 3)?.unbind(),
            rotation: block(py, rotation, [3, 3])?.unbind(),
            curvature: table(py, threes(|s| &s.curvature), 3)?.unbind(),
            // A lone leader has no angles, but as many sections.
            angles: PyArray1::from_vec(py, angles).reshape([n, tubes - 1])?.unbind(),
            energy_density: line(py, sections.iter().map(|s| s.energy_density)).unbind(),
            abscissa: flat(each(|t| t.abscissa))?,
            centroid: deep(vectors(|t| &t.centroid))?,
            tube_rotation: rotations(py, all().flat_map(|t| rows(&t.rotation)).collect(), tubes)?.unbind(),
            rate: flat(each(|t| t.rate))?,
            strain: deep(vectors(|t| &t.strain))?,
            stretch: flat(each(|t| t.stretch))?,
            moment: deep(vectors(|t| &t.moment))?,
            force: deep(vectors(|t| &t.force))?,
        })
    }
}

/// An equilibrium from what [`Equilibrium::__reduce__`] stored.
#[pyfunction]
pub fn _equilibrium(robot: PyRef<'_, Robot>, state: &[u8], version: &str) -> PyResult<Equilibrium> {
    let saved: SavedEquilibrium = stored::read(state, version)?;
    let found =
        saved.restore(&robot.shared.robot).ok_or_else(|| stored::unreadable("another robot", version))?;
    Ok(Equilibrium::new(Arc::clone(&robot.shared), found))
}

/// A shape from its arrays.
#[pyfunction]
pub fn _shape(
    x: Py<PyArray1<f64>>,
    centre: Py<PyArray2<f64>>,
    rotation: Py<PyArray3<f64>>,
    curvature: Py<PyArray2<f64>>,
    angles: Py<PyArray2<f64>>,
    energy_density: Py<PyArray1<f64>>,
    abscissa: Py<PyArray2<f64>>,
    centroid: Py<PyArray3<f64>>,
    tube_rotation: Py<PyArray4<f64>>,
    rate: Py<PyArray2<f64>>,
    strain: Py<PyArray3<f64>>,
    stretch: Py<PyArray2<f64>>,
    moment: Py<PyArray3<f64>>,
    force: Py<PyArray3<f64>>,
) -> Shape {
    Shape {
        x,
        centre,
        rotation,
        curvature,
        angles,
        energy_density,
        abscissa,
        centroid,
        tube_rotation,
        rate,
        strain,
        stretch,
        moment,
        force,
    }
}

/// The arrays of a shape, in the order in which [`_shape`] takes them.
const ARRAYS: [&str; 14] = [
    "x",
    "centre",
    "rotation",
    "curvature",
    "angles",
    "energy_density",
    "abscissa",
    "centroid",
    "tube_rotation",
    "rate",
    "strain",
    "stretch",
    "moment",
    "force",
];

#[pymethods]
impl Shape {
    /// Pickled and copied as its arrays.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let py = slf.py();
        let arrays = ARRAYS.iter().map(|name| slf.getattr(*name)).collect::<PyResult<Vec<_>>>()?;
        Ok((py.import("cppr._cppr")?.getattr("_shape")?, PyTuple::new(py, arrays)?))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape: (usize, usize) = self.abscissa.bind(py).getattr("shape")?.extract()?;
        Ok(format!("Shape({} sections, {} tubes)", shape.0, shape.1))
    }
}
