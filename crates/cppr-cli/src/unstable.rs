//! What to do with an unstable equilibrium: a stable shape under the same command, and how to see all of them.

use crate::table::plain;
use cppr::Vector3;
use cppr::solve::{Equilibrium, Solver, Status};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// An unstable equilibrium, and a stable one under the same command.
pub struct Unstable {
    stable: Option<Stable>,
    /// The robot's file.
    robot: String,
    /// What the stable shape took to find.
    pub time: Duration,
}

/// The stable shape.
struct Stable {
    tip: Vector3<f64>,
    direction: Vector3<f64>,
    energy: f64,
}

impl Unstable {
    /// `None` where the equilibrium is stable; `robot` is its file.
    pub fn of(solver: &mut Solver, found: &Equilibrium, robot: &Path) -> Option<Self> {
        if found.status() != Status::Unstable {
            return None;
        }
        let start = Instant::now();
        let stable = solver.stable_aside(found).map(|stable| {
            let tip = solver.tip(&stable);
            Stable { tip: tip.centre, direction: tip.tangent(), energy: stable.elastic_energy() }
        });
        Some(Self { stable, robot: robot.display().to_string(), time: start.elapsed() })
    }

    /// In sentences.
    pub fn text(&self) -> [String; 3] {
        let three = |v: Vector3<f64>, digits| [v.x, v.y, v.z].map(|c| plain(c, digits)).join(", ");
        let stable = match &self.stable {
            Some(stable) => format!(
                "a stable shape under the same command: tip at {} mm, direction {}; where robot and loads are symmetric, its mirror \
                 image too",
                three(stable.tip * 1e3, 3),
                three(stable.direction, 5)
            ),
            None => {
                "no stable shape was found in a bounded search of the branches that leave the path from rest"
                    .into()
            }
        };
        [
            "this equilibrium is unstable; a real robot is in another shape".into(),
            stable,
            format!(
                "for all branches: cppr continue {} --along command --to 1 --branches, and the options of this command",
                self.robot
            ),
        ]
    }

    /// The stable shape, for JSON.
    pub fn json(&self) -> Option<Value> {
        let stable = self.stable.as_ref()?;
        let three = |v: Vector3<f64>| [v.x, v.y, v.z];
        Some(json!({
            "tip_position_m": three(stable.tip),
            "tip_direction": three(stable.direction),
            "elastic_energy_J": stable.energy,
        }))
    }
}
