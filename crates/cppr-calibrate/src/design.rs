//! Designs of either kind: tubes of one length, joined at the tip, or any bundle of parts and joints.

use cppr::bundle::{BundleDesign, TubeParts};
use cppr::design::{RobotDesign, TubeDesign};
use cppr_io::bundle_file::Described;

/// What a robot is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Design {
    /// Tubes of one length, joined at the tip, one pattern along each.
    Robot(RobotDesign),
    /// Anything else.
    Bundle(BundleDesign),
}

impl From<RobotDesign> for Design {
    fn from(design: RobotDesign) -> Self {
        Self::Robot(design)
    }
}

impl From<BundleDesign> for Design {
    fn from(design: BundleDesign) -> Self {
        Self::Bundle(design)
    }
}

impl From<Described> for Design {
    fn from(described: Described) -> Self {
        match described {
            Described::Robot(file) => Self::Robot(file.design),
            Described::Bundle { design, .. } => Self::Bundle(design),
        }
    }
}

impl Design {
    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Robot(design) => &design.name,
            Self::Bundle(design) => &design.name,
        }
    }

    /// Number of tubes.
    #[must_use]
    pub fn tube_count(&self) -> usize {
        match self {
            Self::Robot(design) => design.tubes.len(),
            Self::Bundle(design) => design.tubes.len(),
        }
    }

    /// Length of the longest tube above the baseplate (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Robot(design) => design.length,
            Self::Bundle(design) => design.tubes.iter().map(TubeParts::length).fold(0.0, f64::max),
        }
    }

    /// As the bundle that is integrated.
    pub(crate) fn integrated(self) -> BundleDesign {
        match self {
            Self::Robot(design) => BundleDesign::from(&design),
            Self::Bundle(design) => design,
        }
    }

    /// What a tube (index from 0) is made of, from base to tip.
    pub(crate) fn bodies(&self, tube: usize) -> Vec<&TubeDesign> {
        match self {
            Self::Robot(design) => vec![&design.tubes[tube]],
            Self::Bundle(design) => design.tubes[tube].parts.iter().map(|part| &part.body).collect(),
        }
    }

    /// The same, to be changed.
    pub(crate) fn bodies_mut(&mut self, tube: usize) -> Vec<&mut TubeDesign> {
        match self {
            Self::Robot(design) => vec![&mut design.tubes[tube]],
            Self::Bundle(design) => design.tubes[tube].parts.iter_mut().map(|part| &mut part.body).collect(),
        }
    }

    /// E and G (Pa) of a tube (index from 0); `None` where it is given by its stiffness all along.
    pub(crate) fn moduli(&self, tube: usize) -> Option<[f64; 2]> {
        self.bodies(tube).into_iter().find_map(|body| match body {
            TubeDesign::Notched(tube) => Some([tube.material.youngs_modulus, tube.material.shear_modulus()]),
            TubeDesign::Stiffness(_) => None,
        })
    }
}
