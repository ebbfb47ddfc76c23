//! Rust numbers as NumPy arrays and back.

use crate::errors;
use cppr::{Matrix3, Vector3};
use nalgebra::{DMatrix, Dim, Matrix, RawStorage};
use numpy::{PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;

/// The value itself, unless it is a masked array with masked values: what a mask hides is no number.
pub fn unmasked<'a, 'py>(what: &str, value: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyAny>> {
    let py = value.py();
    let masked = value.hasattr(intern!(py, "mask"))?
        && py.import("numpy.ma")?.call_method1("is_masked", (value,))?.is_truthy()?;
    if masked {
        return Err(PyValueError::new_err(format!(
            "{what} has masked values: leave them out, or put numbers in their places with filled()"
        )));
    }
    Ok(value)
}

/// A number: Python's or NumPy's, no truth value.
pub fn number(what: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let wrong = || errors::wrong_type(what, "a number", value);
    if value.is_instance_of::<pyo3::types::PyBool>() {
        return Err(wrong());
    }
    unmasked(what, value)?.extract().map_err(|_| wrong())
}

/// Three numbers.
pub fn vector(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vector3<f64>> {
    let wrong = || errors::wrong_type(what, "a sequence of three numbers", value);
    let list: Vec<f64> = unmasked(what, value)?.extract().map_err(|_| wrong())?;
    let three: [f64; 3] = list.try_into().map_err(|l: Vec<f64>| {
        PyValueError::new_err(format!("{what} has {} components; give three", l.len()))
    })?;
    Ok(three.into())
}

/// Shape (n,).
pub fn line(py: Python<'_>, values: impl IntoIterator<Item = f64>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_iter(py, values)
}

/// Shape (n, m).
pub fn table(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// Shape (n, m, k).
pub fn block(
    py: Python<'_>,
    values: Vec<f64>,
    [columns, deep]: [usize; 2],
) -> PyResult<Bound<'_, PyArray3<f64>>> {
    let rows = values.len() / (columns * deep).max(1);
    PyArray1::from_vec(py, values).reshape([rows, columns, deep])
}

/// Shape (n, m, 3, 3).
pub fn rotations(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyArray4<f64>>> {
    let rows = values.len() / (9 * columns).max(1);
    PyArray1::from_vec(py, values).reshape([rows, columns, 3, 3])
}

/// A rotation by its rows.
pub fn rows(rotation: &Matrix3<f64>) -> impl Iterator<Item = f64> + '_ {
    (0..9).map(|i| rotation[(i / 3, i % 3)])
}

/// A matrix of any size.
pub fn matrix<R: Dim, C: Dim, S: RawStorage<f64, R, C>>(
    py: Python<'_>,
    value: &Matrix<f64, R, C, S>,
) -> PyResult<Py<PyArray2<f64>>> {
    let (n, m) = value.shape();
    let list: Vec<f64> = (0..n * m).map(|i| value[(i / m, i % m)]).collect();
    // An empty table keeps both of its sides.
    Ok(PyArray1::from_vec(py, list).reshape([n, m])?.unbind())
}

/// A matrix of dynamic size; see [`matrix`].
pub fn dynamic(py: Python<'_>, value: &DMatrix<f64>) -> PyResult<Py<PyArray2<f64>>> {
    matrix(py, value)
}
