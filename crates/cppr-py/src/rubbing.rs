//! Contact force and friction as dictionaries of arrays.

use crate::arrays::{line, table};
use crate::errors;
use cppr::Vector3;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver, TubeEffort};
use cppr::bundle::{Contact, ContactPoint, Friction, HistoryPoint};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Sections at which contact is told, per length.
const SECTIONS: f64 = 100.0;

/// Checks how tubes rub.
pub fn friction(coefficient: f64, guide: Option<f64>) -> PyResult<Friction> {
    if !(coefficient.is_finite() && coefficient >= 0.0) {
        let text = format!("the coefficient of friction is {coefficient}; it must be finite and at least 0");
        return Err(PyValueError::new_err(text));
    }
    match guide {
        Some(length) if !(length.is_finite() && length > 0.0) => {
            let text = format!("the guide is {length} m long; it needs a positive length, or None");
            Err(PyValueError::new_err(text))
        }
        _ => Ok(Friction { coefficient, guide }),
    }
}

/// How tubes rub: as given, else as those of the robot do; `None` where neither says it.
pub fn chosen(
    coefficient: Option<f64>,
    guide: Option<f64>,
    own: Option<Friction>,
) -> PyResult<Option<Friction>> {
    match coefficient.or(own.map(|own| own.coefficient)) {
        Some(coefficient) => friction(coefficient, guide.or(own.and_then(|own| own.guide))).map(Some),
        None if guide.is_some() => {
            let text = "guide is given, and nothing rubs there: give friction, or a robot that has it";
            Err(PyValueError::new_err(text))
        }
        None => Ok(None),
    }
}

/// The same where a coefficient of 0 leaves friction out.
pub fn felt(
    coefficient: Option<f64>,
    guide: Option<f64>,
    own: Option<Friction>,
) -> PyResult<Option<Friction>> {
    Ok(chosen(coefficient, guide, own)?.filter(|own| own.coefficient > 0.0))
}

/// How tubes rub, where something has to say it.
pub fn needed(coefficient: Option<f64>, guide: Option<f64>, own: Option<Friction>) -> PyResult<Friction> {
    chosen(coefficient, guide, own)?.ok_or_else(|| {
        PyValueError::new_err(
            "say how the tubes rub: give the coefficient of friction, or a robot that has it",
        )
    })
}

/// As it is stored.
pub type Stored = Option<(f64, Option<f64>)>;

/// Of what was stored.
pub fn restored(own: Stored) -> Option<Friction> {
    own.map(|(coefficient, guide)| Friction { coefficient, guide })
}

/// To be stored.
pub fn stored(own: Option<Friction>) -> Stored {
    own.map(|Friction { coefficient, guide }| (coefficient, guide))
}

/// How the tubes of an equilibrium press on each other: one dict per pair of neighbours.
pub fn contact<'py>(
    py: Python<'py>,
    solver: &BundleSolver<'_>,
    found: &BundleEquilibrium,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let length = solver.bundle().length();
    let Contact { pairs, .. } = py
        .detach(|| solver.contact(found, length / SECTIONS))
        .ok_or_else(|| errors::error(py, "NoEquilibrium", "a section of the equilibrium does not balance"))?;
    let each = pairs.iter().map(|pair| {
        let own = PyDict::new(py);
        let of = |get: &dyn Fn(&ContactPoint) -> f64| line(py, pair.points.iter().map(get));
        own.set_item("outer", pair.outer + 1)?;
        own.set_item("inner", pair.inner + 1)?;
        own.set_item("length", of(&|p| p.length))?;
        own.set_item("outer_abscissa", of(&|p| p.labels[0]))?;
        own.set_item("inner_abscissa", of(&|p| p.labels[1]))?;
        own.set_item(
            "force",
            table(py, pair.points.iter().flat_map(|p| p.force.iter().copied()).collect(), 3)?,
        )?;
        Ok(own)
    });
    each.collect()
}

/// The equilibria between which friction leaves a pose.
pub fn bounds<'py>(
    py: Python<'py>,
    solver: &BundleSolver<'_>,
    found: &BundleEquilibrium,
    friction: &Friction,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let [loading, unloading] = py.detach(|| solver.full_slip(found, friction)).ok_or_else(|| {
        errors::error(
            py,
            "NoEquilibrium",
            "no equilibrium with full slip was found; take less friction, or command less",
        )
    })?;
    let side = |own: &cppr::bundle::Rubbed| -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("tip_position", line(py, own.equilibrium.tip.iter().copied()))?;
        efforts(py, &dict, std::slice::from_ref(&own.efforts), true)?;
        Ok(dict)
    };
    Ok((side(&loading)?, side(&unloading)?))
}

/// Motors of every tube, a row per pose, or one row alone.
fn efforts(py: Python<'_>, dict: &Bound<'_, PyDict>, rows: &[Vec<TubeEffort>], single: bool) -> PyResult<()> {
    let add = |name: &str, get: fn(&TubeEffort) -> f64| -> PyResult<()> {
        let values = rows.iter().flatten().map(get);
        if single {
            return dict.set_item(name, line(py, values));
        }
        dict.set_item(name, table(py, values.collect(), rows.first().map_or(0, Vec::len))?)
    };
    add("pull", |own| own.label)?;
    add("rotation", |own| own.rotation)?;
    add("tension", |own| own.force)?;
    add("torque", |own| own.torque)
}

/// The points of a history.
pub fn history<'py>(py: Python<'py>, points: &[(usize, HistoryPoint)]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let tips = points.iter().flat_map(|(_, own): &(usize, HistoryPoint)| {
        let tip: Vector3<f64> = own.tip;
        [tip.x, tip.y, tip.z]
    });
    dict.set_item("leg", points.iter().map(|(leg, _)| *leg).collect::<Vec<_>>())?;
    dict.set_item("tip_position", table(py, tips.collect(), 3)?)?;
    dict.set_item("slipping", line(py, points.iter().map(|(_, own)| own.slipping)))?;
    let rows: Vec<Vec<TubeEffort>> = points.iter().map(|(_, own)| own.efforts.clone()).collect();
    efforts(py, &dict, &rows, false)?;
    Ok(dict)
}
