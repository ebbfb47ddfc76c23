//! What an equilibrium tells: limits of its notches, safe ranges of its actuators, the path that it lies on.

use crate::arrays::{line, table};
use crate::bundle::{self, BundleEquilibrium};
use crate::command::{Asked, Drives};
use crate::design::pick;
use crate::equilibrium::Equilibrium;
use crate::errors;
use crate::watch::analysed;
use cppr::analysis::continuation::{Branch, End, Family, FamilyProblem, PointKind, Tracing};
use cppr::analysis::{Bound as Why, Governing, Limit, Place, RangeEnd, SectionLimit, Teeth, governing};
use cppr::bundle::BundleFamily;
use cppr::solve::Input;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use std::sync::Arc;

/// An equilibrium of a robot of either kind.
#[derive(FromPyObject)]
pub enum Either<'py> {
    Robot(PyRef<'py, Equilibrium>),
    Bundle(PyRef<'py, BundleEquilibrium>),
}

/// ("pull", 2) and its like.
pub fn input(input: &Input) -> (&'static str, usize) {
    (input.quantity().keyword, input.tube)
}

fn teeth(py: Python<'_>, text: &str) -> PyResult<Teeth> {
    let bending = pick("teeth", PyString::new(py, text).as_any(), &["rigid", "bending"])?;
    Ok(if bending == 1 { Teeth::Bending } else { Teeth::Rigid })
}

/// The fields of `SectionLimit` in their order.
fn section<'py>(py: Python<'py>, s: &SectionLimit) -> PyResult<Bound<'py, PyTuple>> {
    let (place, number) = match s.place {
        Place::Notch(number) => ("notch", Some(number)),
        Place::Section => ("section", None),
        Place::Uncut => ("uncut", None),
    };
    let [y, z] = s.curvature;
    let place = (s.tube, place, number, s.abscissa, s.label, y, z).into_pyobject(py)?;
    let state =
        (s.strain, s.allowable_strain, s.closure, s.gap, s.shear, s.allowable_shear).into_pyobject(py)?;
    PyTuple::new(py, place.iter().chain(state.iter()).collect::<Vec<_>>())
}

/// The fields of `Governing` in their order.
fn nearest<'py>(py: Python<'py>, found: Option<&Governing>) -> PyResult<Option<Bound<'py, PyTuple>>> {
    let Some(found) = found else { return Ok(None) };
    let limit = match found.limit {
        Limit::Strain => "strain",
        Limit::Closure => "closure",
        Limit::Torsion => "torsion",
        Limit::Stability => "stability",
    };
    let place = found.section.as_ref().map(|s| section(py, s)).transpose()?;
    Ok(Some((limit, found.utilisation, place).into_pyobject(py)?))
}

/// Sections and the nearest limit.
#[pyfunction]
pub fn limits<'py>(py: Python<'py>, equilibrium: Either<'py>, teeth: &str) -> PyResult<Bound<'py, PyTuple>> {
    let teeth = self::teeth(py, teeth)?;
    let (sections, margin) = match &equilibrium {
        Either::Robot(own) => {
            let (shared, found) = (&own.shared, &own.found);
            py.detach(|| {
                shared.with(|solver| {
                    let sections = solver.section_limits(found, teeth);
                    (sections, solver.stability(found).map(|s| s.margin))
                })
            })
        }
        Either::Bundle(own) => {
            let found = &own.found;
            (own.analysed(py, |a| a.section_limits(found, teeth))?, None)
        }
    };
    let list = sections.iter().map(|s| section(py, s)).collect::<PyResult<Vec<_>>>()?;
    (list, nearest(py, governing(&sections, margin).as_ref())?).into_pyobject(py)
}

fn end<'py>(py: Python<'py>, end: &RangeEnd) -> PyResult<Bound<'py, PyTuple>> {
    let (bound, limit) = match &end.bound {
        Why::Limit(found) => ("limit", Some(found)),
        Why::BranchEnds => ("branch", None),
        Why::Open => ("open", None),
    };
    (end.value, bound, nearest(py, limit)?).into_pyobject(py)
}

/// The fields of `SafeRange`, one list per input.
#[pyfunction]
pub fn ranges<'py>(py: Python<'py>, equilibrium: Either<'py>, teeth: &str) -> PyResult<Bound<'py, PyList>> {
    let teeth = self::teeth(py, teeth)?;
    let ranges = match &equilibrium {
        Either::Robot(own) => {
            let found = &own.found;
            analysed(py, found, |w| w.safe_ranges(found.command(), teeth))?
        }
        Either::Bundle(own) => {
            let command = own.found.command();
            own.analysed(py, |a| a.safe_ranges(command, teeth))?
        }
    };
    let ranges = ranges.map_err(|problem| errors::command(py, problem))?;
    let list = ranges.iter().map(|r| {
        let (means, tube) = input(&r.input);
        (means, tube, r.start, end(py, &r.low)?, end(py, &r.high)?).into_pyobject(py)
    });
    PyList::new(py, list.collect::<PyResult<Vec<_>>>()?)
}

/// The fields of `RangeEnd`.
#[pyfunction]
pub fn part<'py>(py: Python<'py>, equilibrium: Either<'py>, teeth: &str) -> PyResult<Bound<'py, PyTuple>> {
    let teeth = self::teeth(py, teeth)?;
    let part = match &equilibrium {
        Either::Robot(own) => {
            let found = &own.found;
            analysed(py, found, |w| w.safe_part(found.command(), teeth))?
        }
        Either::Bundle(own) => {
            let command = own.found.command();
            own.analysed(py, |a| a.safe_part(command, teeth))?
        }
    };
    end(py, &part.map_err(|problem| errors::command(py, problem))?)
}

/// The path from an equilibrium towards other actuator values or another load factor; fields of `Branch`, one dict each.
#[pyfunction]
pub fn trace<'py>(
    py: Python<'py>,
    equilibrium: Either<'py>,
    drives: Drives<'py>,
    load_factor: Option<f64>,
    step: f64,
    points: usize,
    depth: usize,
) -> PyResult<Bound<'py, PyList>> {
    let tracing = Tracing { step, points, depth, ..Tracing::default() };
    let refused = |problem: FamilyProblem| errors::command(py, problem);
    match &equilibrium {
        Either::Robot(own) => {
            let (shared, found) = (&own.shared, &own.found);
            let first = found.command().clone();
            let mut last = first.clone();
            Asked { drives: drives.each_ref().map(Option::as_ref), ..Asked::default() }
                .put(&shared.robot, &mut last)?;
            let family = match load_factor {
                None => Family::between(first, last),
                Some(_) if last != first => return Err(errors::command(py, BOTH)),
                Some(factor) => Family::load(first, 1.0, factor),
            };
            let family = family.map_err(refused)?;
            let branches =
                analysed(py, found, |w| w.trace_from(&family, &tracing, found))?.map_err(refused)?;
            told(py, branches, |e| Py::new(py, Equilibrium::new(Arc::clone(shared), e)).map(Py::into_any))
        }
        Either::Bundle(own) => {
            let found = &own.found;
            let first = found.command().clone();
            let mut last = first.drives.clone();
            bundle::put(py, &mut last, &drives)?;
            let family = match load_factor {
                None => BundleFamily::between(first, last),
                Some(_) if last != first.drives => return Err(errors::command(py, BOTH)),
                Some(factor) => BundleFamily::load(first, 1.0, factor),
            };
            let family = family.map_err(refused)?;
            let branches =
                own.stoppable(py, |solver, stop| solver.trace_until(&family, &tracing, found, stop))?;
            told(py, branches, |e| Py::new(py, own.other(e)).map(Py::into_any))
        }
    }
}

const BOTH: &str = "give actuator values or load_factor, not both";

fn told<E>(
    py: Python<'_>,
    branches: Vec<Branch<E>>,
    wrap: impl Fn(E) -> PyResult<Py<PyAny>>,
) -> PyResult<Bound<'_, PyList>> {
    PyList::new(py, branches.into_iter().map(|b| branch(py, b, &wrap)).collect::<PyResult<Vec<_>>>()?)
}

fn branch<E>(
    py: Python<'_>,
    branch: Branch<E>,
    wrap: impl Fn(E) -> PyResult<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let points = &branch.points;
    let own = PyDict::new(py);
    let kinds = points.iter().map(|p| match p.kind {
        PointKind::Regular => "regular",
        PointKind::Fold => "fold",
        PointKind::BranchPoint { .. } => "branch point",
        PointKind::Edge { .. } => "edge",
    });
    own.set_item("parameter", line(py, points.iter().map(|p| p.parameter)))?;
    own.set_item("fraction", line(py, points.iter().map(|p| p.fraction)))?;
    own.set_item("kind", PyTuple::new(py, kinds)?)?;
    let tips = points.iter().flat_map(|p| p.tip.iter().copied()).collect();
    own.set_item("tip_position", table(py, tips, 3)?)?;
    own.set_item(
        "stable",
        points.iter().map(cppr::analysis::continuation::PathPoint::is_stable).collect::<Vec<_>>(),
    )?;
    own.set_item("margin", line(py, points.iter().map(|p| p.margin.unwrap_or(f64::NAN))))?;
    own.set_item("reached", branch.end == End::Last)?;
    own.set_item("end", branch.end.to_string())?;
    own.set_item("origin", branch.origin.map(|o| (o.branch, o.point, o.mode, o.along)))?;
    let equilibria = branch.points.into_iter().map(|p| wrap(p.equilibrium)).collect::<PyResult<Vec<_>>>()?;
    own.set_item("equilibria", PyTuple::new(py, equilibria)?)?;
    Ok(own)
}
