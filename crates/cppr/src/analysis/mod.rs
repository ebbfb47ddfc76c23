//! What an equilibrium tells: its fields along the robot, its derivatives, its stability.

pub mod sensitivity;
pub mod shape;
pub mod stability;

pub use sensitivity::{Freedom, Input, Perturbed, Sensitivity, parameter_sensitivity, sensitivity};
pub use shape::{Section, Shape, TubeSection};
