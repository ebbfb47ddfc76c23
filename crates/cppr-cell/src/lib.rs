//! Stiffness of tubes with notches and teeth: one cell, a notch and a tooth, solved by three-dimensional finite elements.
//!
//! A tube of equal cells bends, stretches and twists like a uniform beam whose stiffness is that of one cell under mean strains of the
//! beam: homogenisation of a periodic beam. The crate meshes a quarter of a cell with 27-node hexahedra, solves the unit strains with a sparse Cholesky
//! factorisation, and refines until the stiffness settles. [`table`] gives what `cppr::design::TeethStiffness` takes.
//!
//! ```
//! use cppr::design::{Cut, Outline};
//! let outline = Outline::Round { outer_radius: 3e-3, inner_radius: 2e-3 };
//! let cell = cppr_cell::Cell {
//!     outline, depth: 5e-3, notch: 5e-3, tooth: 5e-3, cut: Cut::Plane, corner_radius: None, poissons_ratio: 0.35,
//! };
//! let stiffness = cell.stiffness()?;
//! assert!((stiffness.bending_z * 1e12 - 0.324).abs() < 0.003); // EI_Z / E in mm⁴
//! # Ok::<(), cppr_cell::CellError>(())
//! ```

mod cache;
mod cell;
mod closed;
mod contour;
mod element;
mod mesh;
mod peak;
mod section;
mod system;
mod table;
mod vtk;

pub use cache::stiffness;
pub use cell::{Cell, CellError, CellStiffness};
pub use closed::bending_estimate;
pub use table::table;
