//! The Python package `cppr`, its compiled part.
//!
//! Plain data (tubes, loads, settings) are dataclasses in `python/cppr`; here they become what the solver takes, and
//! what the solver gives becomes NumPy arrays. Everything slow runs detached from the interpreter. SI throughout.

// PyO3's macros expand to the unsafe glue between C and Rust; none is written by hand.
#![allow(unsafe_code)]
// Python passes arguments by value; every public item is documented where Python sees it.
#![allow(clippy::needless_pass_by_value, clippy::too_many_arguments)]

mod analysis;
mod arrays;
mod bundle;
mod calibrate;
mod clearance;
mod command;
mod design;
mod equilibrium;
mod errors;
mod inverse;
mod many;
mod many_bundle;
mod robot;
mod rubbing;
mod stored;
mod sweep;
mod twin;
mod watch;

use pyo3::prelude::*;

#[pymodule]
fn _cppr(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<robot::Robot>()?;
    m.add_class::<equilibrium::Equilibrium>()?;
    m.add_class::<equilibrium::Shape>()?;
    m.add_function(wrap_pyfunction!(robot::_robot, m)?)?;
    m.add_function(wrap_pyfunction!(equilibrium::_equilibrium, m)?)?;
    m.add_function(wrap_pyfunction!(equilibrium::_shape, m)?)?;
    m.add_class::<bundle::Bundle>()?;
    m.add_class::<bundle::BundleEquilibrium>()?;
    m.add_function(wrap_pyfunction!(bundle::_bundle, m)?)?;
    m.add_function(wrap_pyfunction!(bundle::_bundle_equilibrium, m)?)?;
    m.add_function(wrap_pyfunction!(design::section, m)?)?;
    m.add_function(wrap_pyfunction!(calibrate::calibrate, m)?)?;
    m.add_function(wrap_pyfunction!(analysis::limits, m)?)?;
    m.add_function(wrap_pyfunction!(analysis::ranges, m)?)?;
    m.add_function(wrap_pyfunction!(analysis::part, m)?)?;
    m.add_function(wrap_pyfunction!(analysis::trace, m)?)?;
    m.add_function(wrap_pyfunction!(inverse::reach, m)?)?;
    m.add_function(wrap_pyfunction!(inverse::match_shape, m)?)?;
    m.add_function(wrap_pyfunction!(inverse::sense, m)?)?;
    m.add_function(wrap_pyfunction!(many::solve_many, m)?)?;
    m.add_function(wrap_pyfunction!(many_bundle::solve_many_of_bundle, m)?)?;
    m.add_function(wrap_pyfunction!(many::modes_for, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::sweep, m)?)?;
    m.add_function(wrap_pyfunction!(twin::time_solves, m)?)?;
    m.add_function(wrap_pyfunction!(twin::time_many, m)?)
}

/// Does the processor lack instructions that this library was compiled to use? `_processor.py` asks before it imports the module, since
/// PyO3's own glue uses them.
#[unsafe(no_mangle)]
pub extern "C" fn cppr_processor_lacks() -> bool {
    cppr_io::processor::lacking().is_some()
}
