//! Clearance: neighbouring tubes with a radial gap between them.
//!
//! Without clearance all tubes have one centreline. With a gap δ the inner tube of a pair bends aside in the bore of the outer one until it meets its
//! wall, which raises the lever between both. [`estimate()`] tells by how much from an equilibrium without clearance, for any bundle;
//! [`Solver::with_clearance`](crate::solve::Solver::with_clearance) solves for it, in the plane and for robots whose tubes have one length.

mod banded;
mod element;
mod estimate;
mod number;
mod planar;
mod state;
mod system;

pub use estimate::{Estimate, PairEstimate, estimate};
pub use planar::{Clearance, ClearanceEquilibrium, ClearanceProblem, FollowerClearance, PairClearance, Zone};
