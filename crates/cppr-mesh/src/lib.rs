//! Geometry of concentric push-pull robots as triangle meshes.
//!
//! [`tube_mesh`] builds the closed surface of a notched tube at rest, as the robot file describes it; [`bent_tubes`]
//! those of all tubes of a solved robot, [`bent_bundle`] of a solved bundle. [`stl`], [`three_mf`] and [`obj`] write bodies for printing and CAD, [`gltf()`]
//! and [`glb`] for display. [`unrolled()`] lays the cut pattern of a tube flat for [`dxf()`].
//!
//! # Bending a mesh
//!
//! Sections of a tube stay plane and keep their shape. With the frame F(x) of the tube at rest abscissa x and the
//! centre c(x) of the section there, a vertex (x, y, z) of the mesh at rest goes to
//!
//!   p = c(x) + F(x) (0, y, z)ᵀ
//!
//! and a normal n to F(x) n. A solved robot gives both at labels X of the leader: in a [`cppr::analysis::Section`],
//! c is `centre`, x is `tubes[k].abscissa`, and F is `tubes[k].rotation` turned back by the direction φ of the tube's
//! pattern, F = R · Rot_x(−φ(x)) ([`cppr::design::Robot::fields_at`]). F runs smoothly along the tube even
//! where φ winds, so that a program that draws may interpolate c and F between a few dozen sections, with x as
//! the parameter. Below the plate, x < x_k(0), F keeps its value and c goes on along −X. [`bend`] does all this. A solved bundle
//! gives F by the rotation of the material against the section's frame ([`cppr::bundle::TubeSection`]).
//!
//! Vertices lie on planes across the axis, at most [`Detail::step`] apart. Their rest abscissa is the first
//! coordinate, and their angle about the axis atan2(z, y): what colours by strain need.

mod bend;
mod bend_bundle;
mod body;
mod contour;
mod error;
mod gltf;
mod mesh;
mod options;
mod part;
mod ring;
#[cfg(feature = "files")]
mod solid_files;
mod stretch;
mod tube;
#[cfg(feature = "files")]
mod unrolled;

pub use bend::{bend, bent_tubes};
pub use bend_bundle::bent_bundle;
pub use error::MeshError;
pub use gltf::{glb, gltf};
pub use mesh::{Flaws, Mesh, Shaded};
pub use options::{Detail, Flange, TubeOptions};
pub use part::{FileError, Part};
#[cfg(feature = "files")]
pub use solid_files::{obj, stl, three_mf};
pub use stretch::Tubes;
pub use tube::{tube_mesh, tube_volume};
#[cfg(feature = "files")]
pub use unrolled::{CUT_LAYER, OUTLINE_LAYER, Unrolled, UnrolledOptions, dxf, unrolled};
