//! What can be asked of a bundle, said before anything is solved; and whether an equilibrium that was stored is one of it.

use super::solve::{BundleCommand, BundleEquilibrium};
use super::{Bundle, BundleDesign, TubeParts};
use crate::statics::LoadProblem;
use std::fmt;

/// A command that cannot be asked of a bundle. Tubes are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum BundleProblem {
    /// There are not as many drives as tubes.
    Drives {
        /// Drives given.
        given: usize,
        /// Tubes of the bundle.
        tubes: usize,
    },
    /// A motion or an effort is NaN or infinite.
    NotFinite {
        /// Tube number.
        tube: usize,
    },
    /// A joint would lie behind the plate.
    BehindPlate {
        /// Tube number.
        tube: usize,
        /// Label of the joint on it (m).
        label: f64,
    },
    /// A load is wrong.
    Load(LoadProblem),
    /// Tubes are to stretch, but the axial stiffness of a part is not known.
    NoAxialStiffness,
}

impl fmt::Display for BundleProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drives { given, tubes } => {
                write!(f, "drives are given for {given} tubes; this robot has {tubes}")
            }
            Self::NotFinite { tube } => {
                write!(f, "the actuator of tube {tube} is given a value that is not finite")
            }
            Self::BehindPlate { tube, label } => write!(
                f,
                "tube {tube} is joined to another at {:.3} mm, which would lie behind the plate: pull less. Check the unit",
                label * 1e3
            ),
            Self::Load(problem) => write!(f, "{problem}"),
            Self::NoAxialStiffness => write!(
                f,
                "the axial stiffness of a part is not known, so that nothing says how the tubes stretch: give it to the robot"
            ),
        }
    }
}

impl std::error::Error for BundleProblem {}

impl BundleCommand {
    /// Checks the command against a bundle and what it is made of. Whether a load acts on what is drawn in behind the plate shows in the
    /// equilibrium alone: [`load_behind_plate`](super::solve::load_behind_plate).
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self, design: &BundleDesign, bundle: &Bundle, stretch: bool) -> Result<(), BundleProblem> {
        let (given, tubes) = (self.drives.len(), bundle.tubes.len());
        if given != tubes {
            return Err(BundleProblem::Drives { given, tubes });
        }
        let finite = |value: f64| value.is_finite();
        let wild = self
            .drives
            .iter()
            .position(|own| !(finite(own.translation.value()) && finite(own.rotation.value())));
        if let Some(index) = wild {
            return Err(BundleProblem::NotFinite { tube: index + 1 });
        }
        if let Some((index, label)) = bundle.joint_behind_plate(&self.drives) {
            return Err(BundleProblem::BehindPlate { tube: index + 1, label });
        }
        let leader = design.tubes.first().map_or(0.0, TubeParts::length);
        self.loads.check_on(leader, design.has_mass()).map_err(BundleProblem::Load)?;
        if stretch && !design.has_axial_stiffness() {
            return Err(BundleProblem::NoAxialStiffness);
        }
        Ok(())
    }
}

impl BundleEquilibrium {
    /// Has it as many tubes and joints as a bundle? Ask it of what was stored elsewhere.
    #[must_use]
    pub fn fits(&self, bundle: &Bundle) -> bool {
        let tubes = bundle.tubes.len();
        let most: usize = bundle.stations.iter().map(|station| station.len().saturating_sub(1)).sum();
        let counts = [self.efforts.len(), self.unknowns.tubes.len()];
        self.command.drives.len() == tubes
            && (!self.converged || counts == [tubes; 2] && self.unknowns.handed.len() <= most)
    }
}
