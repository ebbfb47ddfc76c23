//! Equilibria of a bundle.

use super::command::BundleCommand;
use super::frame::Unknowns;
use super::load_path::PathEnd;
use super::prepared::Lengthening;
use super::sensitivity::Slopes;
use super::steps::Steps;
use crate::solve::{Reason, Status};
use crate::statics::Station;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// Label (m) of a load that acts on what was drawn in behind the plate, if there is one.
#[must_use]
pub fn load_behind_plate(command: &BundleCommand, found: &BundleEquilibrium) -> Option<f64> {
    let plate = found.efforts.first()?.label;
    let wrenches = command.loads.wrenches.iter().filter_map(|w| match w.station {
        Station::Label(label) => Some(label),
        Station::Tip => None,
    });
    wrenches.chain(command.loads.distributed.iter().map(|d| d.from)).find(|label| *label < plate)
}

/// Motion and effort of one tube's motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TubeEffort {
    /// Label at the plate (m).
    pub label: f64,
    /// Rotation of the material at the plate (rad).
    pub rotation: f64,
    /// Force with which the motor pulls (N).
    pub force: f64,
    /// Torque of the motor (N m), right-handed about +X.
    pub torque: f64,
}

/// What came out of a solve.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BundleEquilibrium {
    /// Was an equilibrium found?
    pub converged: bool,
    /// Motors, one per tube.
    pub efforts: Vec<TubeEffort>,
    /// Centre of the last tip (m).
    pub tip: Vector3<f64>,
    /// Its section frame: columns tangent, towards the centroid of the tube that counts it, across.
    pub frame: Matrix3<f64>,
    /// Length of the centreline (m).
    pub length: f64,
    /// Has the second variation no negative eigenvalue, see [`inertia`](super::solve::BundleSolver::inertia)?
    pub stable: bool,
    /// What [`inertia`](super::solve::BundleSolver::inertia) counted.
    pub(crate) inertia: Option<usize>,
    /// Where the path of stable equilibria from rest or a neighbour ended, if it did not arrive.
    pub(crate) ended: Option<PathEnd>,
    /// Steps of the integration, and Newton steps.
    pub steps: usize,
    /// Newton steps.
    pub iterations: usize,
    /// How far tip (m) and forces (N) move when every step is halved; NaN where that was not tried, see [`error`](super::solve::BundleSolver::error).
    pub error: [f64; 2],
    /// How its tubes give way along their lengths.
    pub(super) lengthening: Lengthening,
    pub(super) unknowns: Unknowns,
    /// States at the ends of the steps.
    pub(super) between: Steps,
    pub(super) command: BundleCommand,
    /// To first order next to it, where it was found so.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(super) slopes: Option<Arc<Slopes>>,
}

impl BundleEquilibrium {
    /// What became of the command, in a sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let end = match self.ended {
            None => "no equilibrium was found with all motors held and no load".into(),
            Some(PathEnd { share, .. }) if share <= 0.0 => {
                "no equilibrium was found for even the first small part of the command".into()
            }
            Some(PathEnd { share, turns: true }) => format!(
                "stable equilibria were followed to {:.1} % of the command, where they end in a fold or lose their stability: \
                 the robot snaps there",
                100.0 * share
            ),
            Some(PathEnd { share, turns: false }) => {
                format!("no equilibrium was found beyond {:.1} % of the command", 100.0 * share)
            }
        };
        match (self.converged, self.stable, self.ended) {
            (false, ..) => format!(
                "{end}; command less, or look whether tubes reach their joints with these pulls and whether tubes without lever are \
                 pulled against each other"
            ),
            (true, true, Some(_)) => format!("converged, stable, but {end}: another branch"),
            (true, false, Some(_)) => format!("converged, unstable; {end}"),
            (true, _, None) => self.status().to_string(),
        }
    }

    /// What it is the equilibrium under.
    #[must_use]
    pub fn command(&self) -> &BundleCommand {
        &self.command
    }

    /// How its tubes give way along their lengths.
    pub(crate) fn lengthening(&self) -> Lengthening {
        self.lengthening
    }

    /// Whether it was found, and is stable.
    #[must_use]
    pub fn status(&self) -> Status {
        match (self.converged, self.stable) {
            (true, true) => Status::Converged,
            (true, false) => Status::Unstable,
            (false, _) => {
                Status::NotConverged(Reason::PathEnds { fraction: self.ended.map_or(0.0, |end| end.share) })
            }
        }
    }
}
