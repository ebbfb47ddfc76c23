//! An equilibrium as numbers, to be stored and to be made again for the same robot: later, or in another process.

use super::command::Actuator;
use super::system::Point;
use super::{ActuatorState, Command, Equilibrium, Settings, Statistics, Status};
use crate::design::Robot;
use crate::kinematics::layout::{Cut, Layouts};
use serde::{Deserialize, Serialize};

/// Everything about an [`Equilibrium`] but its robot. SI; the rest is for this version of the library alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SavedEquilibrium {
    status: Status,
    statistics: Statistics,
    elastic_energy: f64,
    actuators: Vec<ActuatorState>,
    command: Command,
    settings: Settings,
    residual: f64,
    cuts: Vec<Cut>,
    point: Point,
    drives: Vec<Actuator>,
}

impl From<&Equilibrium> for SavedEquilibrium {
    fn from(found: &Equilibrium) -> Self {
        Self {
            status: found.status,
            statistics: found.statistics,
            elastic_energy: found.elastic_energy,
            actuators: found.actuators.clone(),
            command: found.command.clone(),
            settings: found.settings,
            residual: found.residual,
            cuts: found.layout.cuts().to_vec(),
            point: found.point.clone(),
            drives: found.drives.clone(),
        }
    }
}

impl SavedEquilibrium {
    /// The same equilibrium, bit by bit; none where it is of a robot with other tubes or another number of unknowns.
    #[must_use]
    pub fn restore(self, robot: &Robot) -> Option<Equilibrium> {
        let (tubes, followers) = (robot.tube_count(), robot.follower_count());
        let cuts = self.cuts.into_iter();
        let layout = Layouts::default().get(tubes, robot.length(), self.settings.resolution, cuts);
        let rest = Point::<f64>::rest(&layout);
        let fits = self.point.coordinates.len() == rest.coordinates.len()
            && self.point.efforts.tension.len() == followers
            && self.point.efforts.torque.len() == followers
            && self.point.efforts.edge.len() == rest.efforts.edge.len()
            && [self.actuators.len(), self.drives.len(), self.command.actuators.len()] == [followers; 3];
        fits.then(|| Equilibrium {
            robot: robot.clone(),
            status: self.status,
            statistics: self.statistics,
            elastic_energy: self.elastic_energy,
            actuators: self.actuators,
            command: self.command,
            settings: self.settings,
            residual: self.residual,
            layout,
            point: self.point,
            drives: self.drives,
            mark: 0,
        })
    }
}
