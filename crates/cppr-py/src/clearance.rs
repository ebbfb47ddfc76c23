//! Gaps between the tubes as dictionaries of arrays.

use crate::arrays::{block, line, table};
use crate::errors;
use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::clearance::{Clearance, ClearanceEquilibrium, ClearanceProblem, Guide};
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

/// Gaps that are asked for, where the radii leave `known`.
pub fn asked(
    gap: Option<f64>,
    known: Vec<Option<f64>>,
    guide: Option<(f64, f64)>,
    elements: usize,
) -> PyResult<Clearance> {
    let own = Clearance::known(&gap.map_or(known.clone(), |gap| vec![Some(gap); known.len()]));
    let guide = guide.map(|(length, gap)| Guide { length, gap });
    Ok(Clearance { guide, elements, ..own.map_err(wrong)? })
}

fn wrong(problem: ClearanceProblem) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// The equilibrium with gaps.
pub fn solved(
    py: Python<'_>,
    found: Result<Option<ClearanceEquilibrium>, ClearanceProblem>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = found.map_err(wrong)?.ok_or_else(|| {
        errors::error(py, "NoEquilibrium", "no equilibrium with gaps was found next to that without")
    })?;
    let dict = PyDict::new(py);
    dict.set_item("tip_position", line(py, found.tip().iter().copied()))?;
    dict.set_item("bend_angle", found.bend())?;
    dict.set_item("error", (found.error[0], found.error[1]))?;
    dict.set_item("pull", line(py, found.followers.iter().map(|own| own.pull)))?;
    dict.set_item("tension", line(py, found.followers.iter().map(|own| own.tension)))?;
    dict.set_item("torque", line(py, found.followers.iter().map(|own| own.torque)))?;
    let leader = PyDict::new(py);
    leader.set_item("pull", found.leader.label)?;
    leader.set_item("rotation", found.leader.rotation)?;
    leader.set_item("tension", found.leader.force)?;
    leader.set_item("torque", found.leader.torque)?;
    dict.set_item("leader", leader)?;
    dict.set_item("labels", line(py, found.labels.iter().copied()))?;
    dict.set_item("centres", table(py, found.centres.iter().flat_map(|c| [c.x, c.y, c.z]).collect(), 3)?)?;
    let axes = found.frames.iter().flat_map(|own| own.transpose().iter().copied().collect::<Vec<_>>());
    dict.set_item("frames", block(py, axes.collect(), [3, 3])?)?;
    let pairs = found.pairs.iter().map(|pair| {
        let own = PyDict::new(py);
        own.set_item("outer", pair.outer + 1)?;
        own.set_item("inner", pair.inner + 1)?;
        own.set_item("gap", pair.gap)?;
        own.set_item("mean_offset", pair.mean(&found)[0])?;
        own.set_item("offset", table(py, pair.offset.concat(), 2)?)?;
        own.set_item("force", table(py, pair.force.concat(), 2)?)?;
        let zones = pair.zones.iter().map(|zone| (zone.from, zone.to, zone.angles, zone.force));
        own.set_item("zones", zones.collect::<Vec<_>>())?;
        Ok(own)
    });
    dict.set_item("pairs", pairs.collect::<PyResult<Vec<_>>>()?)?;
    Ok(dict)
}
