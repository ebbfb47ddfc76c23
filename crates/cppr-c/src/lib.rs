//! The C interface of cppr: robots, equilibria, derivatives and many poses behind two opaque handles.
//!
//! `include/cppr.h` is made from this crate by cbindgen and kept in the repository; `tests/header.rs` holds both together.
//!
//! - [`robot`]: a checked robot, immutable;
//! - [`solver`]: buffers, a command and the last equilibrium of one robot;
//! - [`many`]: many poses in one call;
//! - [`status`]: codes, and the sentence of the last failure;
//! - `model`, `session`, `asked`: a robot of either kind, what is asked of it;
//! - `modal`, `values`, `poses`: tubes of one length, joined at the tip; `bundle`, `bundle_poses`: parts and joints.
//!
//! What may grow later (inputs, values, fields, options) is numbered: a new number breaks no compiled program. Arrays over tubes have a
//! place for every tube, also for one that has no actuator (NaN), so that places do not move when it gets one.
//!
//! Every entry point checks its pointers and sizes and catches panics.

// In the order of the header.
pub mod status;

pub mod robot;

pub mod solver;

pub mod many;

mod asked;
mod bundle;
mod bundle_poses;
mod modal;
mod model;
mod names;
mod pointer;
mod poses;
mod session;
mod values;

pub use names::{cppr_field, cppr_frame, cppr_input, cppr_option, cppr_start, cppr_value};
