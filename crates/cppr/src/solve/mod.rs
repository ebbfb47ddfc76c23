//! From a command to the equilibrium, or to the reason why there is none.

pub(crate) mod acceptance;
pub(crate) mod command;
pub(crate) mod constraint;
mod draft;
pub(crate) mod edges;
pub(crate) mod equilibrium;
mod forces;
pub(crate) mod input;
pub(crate) mod newton;
pub(crate) mod path;
pub(crate) mod reduced;
#[cfg(feature = "serde")]
mod saved;
mod settings;
mod solver;
pub(crate) mod stability;
pub(crate) mod system;
#[cfg(test)]
mod work;

pub use command::{Actuator, Command, CommandProblem, Drive};
pub use draft::Draft;
pub use equilibrium::{ActuatorState, Equilibrium};
pub use forces::GeneralisedForces;
pub use input::{Freedom, Input, Quantity};
#[cfg(feature = "serde")]
pub use saved::SavedEquilibrium;
pub use settings::{Formulation, Settings, SettingsProblem};
pub use solver::Solver;

use std::fmt;

/// What came out of a solve. Look at it before using anything else.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// An equilibrium, and a minimum of the energy under the prescribed motions.
    Converged,
    /// An equilibrium that the robot leaves at the slightest disturbance. From rest, no stable one was found in steps either:
    /// the path loses its stability on the way, or the robot would leave its plane to either side.
    Unstable,
    /// No equilibrium was found; the state is the last iterate and means nothing.
    NotConverged(Reason),
}

/// Why no equilibrium was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// Load stepping from rest came to an end before the whole command: at a fold, at the end of what the robot can do, or because
    /// the solver failed. Continuation tells which.
    PathEnds {
        /// Greatest fraction of the command at which an equilibrium was found.
        fraction: f64,
    },
    /// Newton's method did not settle on one set of edges between notched and plain parts.
    Edges,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged, stable"),
            Self::Unstable => write!(f, "converged, unstable: the robot would snap to another shape"),
            Self::NotConverged(Reason::PathEnds { fraction }) if *fraction <= 0.0 => write!(
                f,
                "not converged: applied step by step from rest, no equilibrium was found for even the first small part of the \
                 command. Following the path of equilibria (continue) tells more"
            ),
            Self::NotConverged(Reason::PathEnds { fraction }) => write!(
                f,
                "not converged: applied step by step from rest, no equilibrium was found beyond {:.1} % of the command. \
                 Following the path of equilibria (continue) tells whether the robot folds there; or ask for less",
                100.0 * fraction
            ),
            Self::NotConverged(Reason::Edges) => {
                write!(f, "not converged: no consistent entry of the uncut part below the plate was found")
            }
        }
    }
}

impl Status {
    /// True where there is an equilibrium, stable or not.
    #[must_use]
    pub fn is_equilibrium(self) -> bool {
        !matches!(self, Self::NotConverged(_))
    }

    /// One word, for files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Unstable => "unstable",
            Self::NotConverged(_) => "not_converged",
        }
    }
}

/// What one solve cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Statistics {
    /// Newton steps taken.
    pub iterations: usize,
    /// Residual and tangent evaluations.
    pub evaluations: usize,
    /// Load steps after the first attempt failed; 0 where it did not.
    pub load_steps: usize,
}
