//! Energy, loads and the conditions of equilibrium.

pub(crate) mod assembly;
#[cfg(test)]
mod check;
#[cfg(test)]
mod check_parameters;
#[cfg(test)]
mod check_sensitivity;
#[cfg(test)]
mod check_stability;
pub(crate) mod energy;
mod gradient;
mod hessian;
pub mod load;
pub(crate) mod printed;
pub(crate) mod stiffness;
pub(crate) mod weight;

pub use assembly::RotationMeans;
pub(crate) use load::Applied;
pub use load::{DistributedForce, Frame, LoadPart, LoadProblem, Loads, Station, Thread, Wrench};
