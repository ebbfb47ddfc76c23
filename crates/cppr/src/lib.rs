//! Statics of concentric push-pull robots.
//!
//! Nested, asymmetrically notched tubes, joined at the tip, that bend when one is pushed or pulled inside
//! the other and twist when it is turned. Every tube is a Cosserat rod with an offset centroid line (Tummers
//! et al. 2024); the bundle is reduced to the leader's curvatures and the followers' angles, and its
//! equilibrium is the stationary point of the total energy under the actuation constraints.
//!
//! SI units throughout: m, rad, N, N m, Pa. The base frame has its origin at the centre of the baseplate,
//! X along the robot at rest; angles about the axis run from +Y towards +Z. The bundle is a cantilever clamped at X = 0.
//!
//! ```
//! use cppr::design::{Robot, RobotDesign, StiffnessTube};
//! use cppr::solve::{Command, Solver};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two opposed tubes, 150 mm long: centroid offset, its direction, stiffness in bending and in torsion.
//! let leader = StiffnessTube::uniform(3e-3, 0.0, [12e-3, 1e-3], 4e-3);
//! let follower = StiffnessTube::uniform(1.1e-3, std::f64::consts::PI, [5e-3, 0.7e-3], 2e-3);
//! let tubes = vec![leader.into(), follower.into()];
//! let robot = Robot::from_design(RobotDesign { name: "pair".into(), length: 0.15, tubes })?;
//!
//! let mut solver = Solver::new(&robot);
//! let eq = solver.solve(&Command::pull(&[5e-3]))?;
//! println!("{}: tip {} mm", eq.status(), eq.tip().centre * 1e3);
//! let tip_jacobian = solver.sensitivity(&eq)?.tip_jacobian;
//! # assert!(eq.tip().centre.y < -0.07 && tip_jacobian[(1, 0)] < -10.0);
//! # Ok(())
//! # }
//! ```
//!
//! Robot files are read by the crate `cppr-io`: `cppr_io::read_robot("r1.toml")?`.
//!
//! A [`solve::Solver`] owns its robot, its settings and every buffer, so that a loop of solves allocates nothing. An
//! [`solve::Equilibrium`] knows its robot, its command and how it was solved: whatever is derived of it belongs to it. Look
//! at its status first; that no equilibrium was found is a status, not an error.
//!
//! Data flows from [`design`] (what is built) over [`kinematics`] (coordinates to strains and poses) and
//! [`statics`] (energy, loads) to [`solve`] (equilibrium), [`analysis`] (what an equilibrium tells) and [`many`] (many of
//! them side by side).

pub mod analysis;
pub mod bundle;
pub mod clearance;
mod dense;
pub mod design;
pub mod kinematics;
pub mod many;
mod real;
pub mod solve;
pub mod statics;

pub use nalgebra::{Matrix3, Vector3};
