//! What an equilibrium tells: its fields along the robot, its derivatives, its stability, its limits.

pub mod continuation;
pub mod limits;
pub mod sensitivity;
pub mod shape;
pub mod stability;

pub use limits::{Governing, Limit, Place, SectionLimit, Teeth, governing, section_limits};
pub use sensitivity::{Freedom, Input, Perturbed, Sensitivity, parameter_sensitivity, sensitivity};
pub use shape::{Section, Shape, TubeSection};
