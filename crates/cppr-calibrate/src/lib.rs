//! Calibration (section 4.4 of Tummers et al. 2024, eq 93 and 94, for any subset of parameters).
//!
//! Measured points, directions and bends along the robot and efforts of its motors are compared with the equilibrium under the same
//! actuation and loads, where tubes rub with full slip the way the motors were driven; the sum of squares, each residual divided by its standard deviation, is minimised by
//! the Levenberg–Marquardt method. Derivatives by the parameters come from the tangent of each equilibrium
//! of a robot whose tubes are of one length and joined at the tip, and from neighbours of each equilibrium of any other.
//! What the data cannot see is refused, with the combination of parameters that is invisible.

mod bundle;
mod clearance;
mod data;
mod design;
mod file;
mod fit;
mod observe;
mod parameter;
mod problem;
mod search;
mod units;

pub use data::{Driven, Line, Measurement, Observed, read};
pub use design::Design;
pub use file::{FileProblem, fitted_file};
pub use fit::{Estimate, Fit, FitProblem, Misses, Residual, fit};
pub use parameter::{Parameter, ParameterKind, ParameterProblem, common_friction};
