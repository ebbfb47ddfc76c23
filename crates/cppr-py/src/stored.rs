//! Robots and equilibria as bytes, for pickling and copying: read by the version that wrote them, and by no other.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Of what is stored now.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The bytes.
pub fn write(own: &impl Serialize) -> PyResult<Vec<u8>> {
    postcard::to_stdvec(own).map_err(|e| PyValueError::new_err(format!("this cannot be stored: {e}")))
}

/// What bytes of a version hold.
pub fn read<T: DeserializeOwned>(state: &[u8], version: &str) -> PyResult<T> {
    if version != VERSION {
        return Err(unreadable("another version", version));
    }
    postcard::from_bytes(state).map_err(|e| unreadable(&e.to_string(), version))
}

/// Why they hold nothing.
pub fn unreadable(why: &str, version: &str) -> PyErr {
    PyValueError::new_err(format!(
        "what was stored cannot be read ({why}): it is of cppr {version}, this is cppr {VERSION}"
    ))
}
