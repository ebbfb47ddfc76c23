//! Many solves of one robot, several side by side in the lanes of vector registers.

mod batch;
mod lane;
mod march;

pub use batch::{Batch, WIDTH};
pub use march::{March, Solved, Start};
