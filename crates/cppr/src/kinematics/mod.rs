//! From the coordinates q to strains, poses and the positions of the actuators.

pub(crate) mod follower;
pub(crate) mod layout;
pub(crate) mod magnus;
pub(crate) mod pose;
pub(crate) mod rule;
pub(crate) mod so3;
pub(crate) mod state;

pub use layout::Resolution;
pub use pose::TipPose;
