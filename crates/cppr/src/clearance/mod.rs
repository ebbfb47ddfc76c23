//! Clearance: neighbouring tubes with a radial gap between them.
//!
//! Without clearance all tubes have one centreline. With a gap δ the inner tube of a pair bends aside in the bore of the outer one until it meets its
//! wall, which raises the lever between both. [`estimate()`] tells by how much from an equilibrium without clearance;
//! [`BundleSolver::with_clearance`](crate::bundle::solve::BundleSolver::with_clearance) solves for it, and [`Solver::with_clearance`](crate::solve::Solver::with_clearance) for
//! the bundle of a robot.

mod banded;
mod element;
mod equilibrium;
mod estimate;
mod mesh;
mod number;
mod state;
mod system;

pub use equilibrium::{
    Clearance, ClearanceEquilibrium, ClearanceProblem, FollowerClearance, Guide, PairClearance, Zone,
};
pub use estimate::{Estimate, PairEstimate, estimate};
