//! Calibration (section 4.4 of Tummers et al. 2024, eq 93 and 94, for any subset of parameters).
//!
//! Measured points and directions along the robot are compared with the equilibrium under the same
//! actuation and loads; the sum of squares, each residual divided by its standard deviation, is minimised by
//! the Levenberg–Marquardt method. Derivatives by the parameters come from the tangent of each equilibrium
//! of a robot whose tubes are of one length and joined at the tip, and from neighbours of each equilibrium of any other.
//! What the data cannot see is refused, with the combination of parameters that is invisible.

mod bundle;
mod data;
mod design;
mod file;
mod fit;
mod observe;
mod parameter;
mod units;

pub use data::{Line, Measurement, read};
pub use design::Design;
pub use file::{FileProblem, fitted_file};
pub use fit::{Estimate, Fit, FitProblem, Residual, fit};
pub use parameter::{Parameter, ParameterKind, ParameterProblem};
