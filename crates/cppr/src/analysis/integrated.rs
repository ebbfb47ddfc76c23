//! The bundle that is integrated along its length in place of an equilibrium of the modal solver. It knows no modes, and tells how the tubes press on each other and what
//! friction does.

use crate::bundle::Bundle;
use crate::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use crate::solve::{Command, Equilibrium, Solver};
use std::sync::Arc;

/// An equilibrium of the modal solver, integrated.
#[derive(Clone, Debug)]
pub struct Integrated {
    /// The robot.
    pub bundle: Arc<Bundle>,
    /// The equilibrium; its stability is that of the modal solver.
    pub equilibrium: BundleEquilibrium,
    stretch: bool,
}

impl Integrated {
    /// What it can be asked, such as [`BundleSolver::contact`] and [`BundleSolver::full_slip`].
    #[must_use]
    pub fn solver(&self) -> BundleSolver<'_> {
        BundleSolver::new(&self.bundle).with_stretch(self.stretch)
    }
}

impl Solver {
    /// An equilibrium, integrated as finely as bundles are. `None` as for [`Self::accuracy`].
    #[must_use]
    pub fn integrated(&mut self, equilibrium: &Equilibrium) -> Option<Integrated> {
        let (bundle, found) = self.integration(equilibrium)?;
        let stretch = equilibrium.settings().resolution.stretch > 0;
        let solver = BundleSolver::new(&bundle).with_stretch(stretch);
        let equilibrium = solver.settle(found.command(), &found)?;
        Some(Integrated { bundle, equilibrium, stretch })
    }
}

/// The same command with a leader that is held; rotations are those of the followers' bases.
impl From<&Command> for BundleCommand {
    fn from(command: &Command) -> Self {
        let followers = command.actuators.iter();
        let followers = followers.map(|own| TubeDrive { translation: own.push_pull, rotation: own.rotation });
        Self {
            drives: std::iter::once(TubeDrive::HELD).chain(followers).collect(),
            loads: command.loads.clone(),
        }
    }
}
