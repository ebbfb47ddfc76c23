//! What superelastic metal that unloads makes of a pose.

use crate::Failure;
use crate::bundle::{Ready, no_equilibrium};
use crate::rubbing::motors;
use crate::table::plain;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign, BundleSection};
use cppr_io::contact_record;
use serde_json::Value;
use std::path::Path;

/// The equilibrium of the same command with all metal on its curve of unloading.
pub struct Unloading {
    bundle: Bundle,
    stretch: bool,
    found: BundleEquilibrium,
}

impl Unloading {
    /// Solves for it.
    pub fn of(
        design: &BundleDesign,
        command: &BundleCommand,
        stretch: bool,
        robot: &Path,
    ) -> Result<Self, Failure> {
        let design = design.unloading().ok_or_else(without)?;
        let Ready { bundle, command, stretch } = Ready::with((command.clone(), stretch), robot, &design)?;
        let found = BundleSolver::new(&bundle).with_stretch(stretch).solve(&command);
        if !found.converged {
            return Err(no_equilibrium(&format!("--hysteresis: {}, unloading", design.name), &found));
        }
        Ok(Self { bundle, stretch, found })
    }

    pub fn json(&self) -> Value {
        contact_record::bound(&self.found, &self.found.efforts)
    }

    /// Names and values of the table's lines.
    pub fn lines(&self) -> Vec<(String, String)> {
        let tip = <[f64; 3]>::from(self.found.tip * 1e3).map(|c| format!("{:>10}", plain(c, 3))).join(" ");
        let mut lines = vec![("metal unloading".into(), format!("{tip} mm, the tip"))];
        lines.extend(motors(&self.found.efforts));
        lines
    }

    /// Its shape.
    pub fn shape(&self, spacing: f64) -> Vec<BundleSection> {
        BundleSolver::new(&self.bundle).with_stretch(self.stretch).shape(&self.found, spacing)
    }
}

/// Why there is none.
pub fn without() -> Failure {
    Failure::Input(
        "--hysteresis: no metal of this robot unloads along another curve than it loads; write unloading_onset_strain_percent beside onset_strain_percent under \
         [material]"
            .into(),
    )
}
