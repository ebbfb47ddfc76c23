//! Stable equilibria that a solve from rest does not find: at the end of the path of equilibria from rest, or beside an unstable one under the same command.
//!
//! Where a robot could leave a symmetric shape to either side, the solver may find the shape between the two, which no real robot
//! keeps. The command is applied from rest by `continuation`, and every branch that leaves the path on the way is followed: where
//! one arrives at the whole command and is stable there, the robot may be in that shape. A robot that mirrors itself has such
//! shapes in pairs.

use super::continuation::{End, Family, PointKind, Tracing};
use crate::solve::{Command, Equilibrium, Formulation, Solver, Status};

/// Most steps along all branches. The shipped robots, pressed on the tip, take up to 560.
const STEPS: usize = 2000;

/// Most steps of a path that is followed for its end.
const FOLLOWED: usize = 600;

/// A stable equilibrium at the end of the path of equilibria from rest.
#[derive(Clone, Debug)]
pub struct Followed {
    /// The equilibrium under the whole command.
    pub equilibrium: Equilibrium,
    /// Parts of the command at which the path turns back: a robot that is driven there snaps.
    pub folds: Vec<f64>,
}

impl Solver {
    /// The stable equilibrium at which the path of equilibria from rest arrives under a whole command, all of it in proportion, past all folds. `None` where it
    /// arrives at none within 600 steps, and in the printed formulation. Takes as long as tracing the path.
    #[must_use]
    pub fn follow(&mut self, command: &Command) -> Option<Followed> {
        if self.settings.formulation == Formulation::Printed {
            return None;
        }
        let family = Family::between(command.scaled(0.0), command.clone()).ok()?;
        let tracing = Tracing { steps: FOLLOWED, ..Tracing::default() };
        let branch = self.trace(&family, &tracing).ok()?.into_iter().next()?;
        let last =
            branch.points.last().filter(|point| branch.end == End::Last && point.inertia == Some(0))?;
        let equilibrium = self.solve_from(command, &last.equilibrium).ok()?;
        let folds = branch.points.iter().filter(|point| point.kind == PointKind::Fold);
        let folds = folds.map(|point| point.fraction).collect();
        (equilibrium.status() == Status::Converged && equilibrium.statistics().load_steps == 0)
            .then_some(Followed { equilibrium, folds })
    }

    /// The stable equilibrium under the same command whose tip is nearest, on the path from rest or on a branch that leaves it; `None`
    /// where the given one is not unstable, and where no such branch arrives within 2000 steps. Takes as long as tracing
    /// these branches: 0.2 to 2.2 s for the shipped robots pressed on the tip, and not more than some four times that.
    #[must_use]
    pub fn stable_aside(&mut self, unstable: &Equilibrium) -> Option<Equilibrium> {
        if unstable.status() != Status::Unstable {
            return None;
        }
        let command = unstable.command();
        let tip = self.tip(unstable).centre;
        let family = Family::between(command.scaled(0.0), command.clone()).ok()?;
        let tracing = Tracing { depth: 1, steps: STEPS, ..Tracing::default() };
        let branches = self.trace(&family, &tracing).ok()?;
        let ends = branches.iter().filter(|branch| branch.end == End::Last).filter_map(|b| b.points.last());
        let nearest = ends
            .filter(|point| point.inertia == Some(0))
            .min_by(|a, b| (a.tip - tip).norm().total_cmp(&(b.tip - tip).norm()))?;
        let found = self.solve_from(command, &nearest.equilibrium).ok()?;
        (found.status() == Status::Converged && found.statistics().load_steps == 0).then_some(found)
    }
}
