//! What an equilibrium tells: its fields along the robot, its derivatives, its stability, its limits, its discretisation error.

mod accuracy;
mod aside;
pub mod bend;
mod bundle;
pub mod capacity;
pub mod continuation;
pub mod demand;
mod integrated;
pub mod inverse;
pub mod limits;
mod model;
mod pulls;
pub mod range;
mod report;
pub mod sensitivity;
mod settled;
pub mod shape;
pub mod stability;
mod strains;

pub use accuracy::{ACCURACY, Accuracy, Against, SettingsFound};
pub use aside::Followed;
pub use bend::total_bend;
pub use bundle::BundleAnalysis;
pub use capacity::{NotchCapacity, euler_load, notch_capacities};
pub use demand::{Asked, Demand, absurd_bundle_demand, absurd_demand, explained, greatest_demand};
pub use integrated::Integrated;
pub use limits::{
    Governing, Limit, Place, SectionLimit, Spot, Teeth, Utilisation, first_greatest, governing,
};
pub use pulls::contradicting_pulls;
pub use range::{Bound, RangeEnd, RangeProblem, SafeRange};
pub use sensitivity::{NoDerivatives, Perturbed, Sensitivity};
pub use settled::{MovedBundle, Settled};
pub use shape::{Section, Shape, TubeSection};
pub use stability::Stability;
