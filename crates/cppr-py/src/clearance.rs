//! Gaps between the tubes as dictionaries of arrays.

use crate::arrays::line;
use crate::errors;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The gap (m) that is given for all pairs, checked, or those that the radii leave.
pub fn gaps(given: Option<f64>, known: Vec<Option<f64>>) -> PyResult<Vec<Option<f64>>> {
    match given {
        Some(gap) if !(gap.is_finite() && gap >= 0.0) => {
            let text = format!("the gap is {gap} m; it must be finite and at least 0, or None");
            Err(PyValueError::new_err(text))
        }
        Some(gap) => Ok(vec![Some(gap); known.len()]),
        None => Ok(known),
    }
}

/// What clearance makes of an equilibrium, estimated.
pub fn estimate<'py>(
    py: Python<'py>,
    solver: &mut BundleSolver<'_>,
    found: &BundleEquilibrium,
    gaps: &[Option<f64>],
) -> PyResult<Bound<'py, PyDict>> {
    let told = py.detach(|| cppr::clearance::estimate(solver, found, gaps)).ok_or_else(|| {
        let text = "no equilibrium was found at the pulls that the gaps leave, so that there is no estimate";
        errors::error(py, "NoEquilibrium", text)
    })?;
    let dict = PyDict::new(py);
    let pairs = told.pairs.iter().map(|pair| {
        let own = PyDict::new(py);
        own.set_item("outer", pair.outer + 1)?;
        own.set_item("inner", pair.inner + 1)?;
        own.set_item("gap", pair.gap)?;
        own.set_item("offset", pair.offset)?;
        own.set_item("layer", pair.layer)?;
        own.set_item("touches", pair.touches)?;
        Ok(own)
    });
    dict.set_item("pairs", pairs.collect::<PyResult<Vec<_>>>()?)?;
    dict.set_item("tip_position", line(py, told.tip.iter().copied()))?;
    dict.set_item("tip_direction", line(py, told.frame.column(0).iter().copied()))?;
    dict.set_item("pull", line(py, told.efforts.iter().map(|own| own.label)))?;
    dict.set_item("tension", line(py, told.efforts.iter().map(|own| own.force)))?;
    dict.set_item("backlash", line(py, told.backlash.iter().map(|own| own.unwrap_or(f64::NAN))))?;
    Ok(dict)
}
