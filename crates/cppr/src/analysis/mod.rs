//! What an equilibrium tells: its fields along the robot, its derivatives, its stability, its limits.

pub mod bend;
pub(crate) mod beside;
pub mod capacity;
pub mod continuation;
pub mod demand;
pub mod inverse;
pub mod limits;
pub mod range;
mod reduced;
pub mod sensitivity;
pub mod shape;
pub mod stability;
mod strains;

pub use bend::total_bend;
pub use capacity::{NotchCapacity, euler_load, notch_capacities};
pub use demand::{Asked, Demand, absurd_demand, explained, greatest_demand};
pub use limits::{
    Governing, Limit, Place, SectionLimit, Teeth, Utilisation, first_greatest, governing, section_limits,
    utilisation,
};
pub use range::{Bound, RangeEnd, RangeProblem, SafeRange, safe_part, safe_ranges};
pub use sensitivity::{
    Freedom, Input, Perturbed, Sensitivity, outputs_by_inputs, parameter_sensitivity, sensitivity,
    sensitivity_into,
};
pub use shape::{Section, Shape, TubeSection};
