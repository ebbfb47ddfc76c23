//! What an equilibrium tells: its fields along the robot, its stability.

pub mod shape;
pub mod stability;

pub use shape::{Section, Shape, TubeSection};
