//! Statics of concentric push-pull robots.
//!
//! Nested, asymmetrically notched tubes, joined at the tip, that bend when one is pushed or pulled inside
//! the other and twist when it is turned. Every tube is a Cosserat rod with an offset centroid line (Tummers
//! et al. 2024); the bundle is reduced to the leader's curvatures and the followers' angles, and its
//! equilibrium is the stationary point of the total energy under the actuation constraints.
//!
//! SI units throughout: m, rad, N, N m, Pa. The base frame has its origin at the centre of the baseplate,
//! X along the robot at rest; angles about the axis run from +Y towards +Z. The bundle is a cantilever clamped at X = 0.
//!
//! Data flows from [`design`] (what is built) over [`kinematics`] (coordinates to strains and poses) and
//! [`statics`] (energy, loads) to [`solve`] (equilibrium) and [`analysis`] (what an equilibrium tells).

pub mod analysis;
mod dense;
pub mod design;
pub mod kinematics;
mod real;
pub mod solve;
pub mod statics;

pub use nalgebra::{Matrix3, Vector3};
