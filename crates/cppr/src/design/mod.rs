//! What is built: sections, profiles along a tube, tubes and the robot made of them.

pub mod cells;
pub(crate) mod fibre;
pub(crate) mod fields;
pub mod metal;
pub mod profile;
pub mod robot;
pub mod section;
pub(crate) mod spline;
pub(crate) mod torsion;
pub mod tube;

pub use cells::{CellFactors, CellProblem, CellRange, CellTable, Cut, PeakStrain, TeethStiffness};
pub use fields::FieldValues;
pub use metal::{Branch, Softening};
pub use profile::{Made, Profile, ProfileError};
pub use robot::{DesignProblem, DesignProblems, JointProblem, Robot, RobotDesign};
pub use section::{Inertia, Outline, SectionError, SectionProperties};
pub use tube::{BelowPlate, Material, NotchPattern, NotchedTube, StiffnessTube, Torsion, TubeDesign};
