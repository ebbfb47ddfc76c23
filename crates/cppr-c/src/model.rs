//! A robot of either kind: tubes of one length joined at the tip, which the modal solver takes, or of parts and joints.

use crate::asked::Misplaced;
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::{DesignProblems, Robot};
use cppr_io::bundle_file::Described;
use cppr_sweep::Memory;
use std::sync::Arc;

/// A robot that stands at rest within this part of its length from a plane lies in it.
const FLAT: f64 = 1e-9;
/// Sections at which it is looked at, per length.
const SECTIONS: f64 = 100.0;

/// A checked robot.
pub(crate) enum Model {
    /// Tubes of one length, and the buffers of calls for many poses.
    Modal { robot: Robot, memory: Memory },
    /// Parts and joints.
    Bundle(Arc<Parts>),
}

/// What a bundle is made of, and the bundle.
pub(crate) struct Parts {
    pub design: BundleDesign,
    pub bundle: Bundle,
}

impl Model {
    pub fn new(described: Described) -> Result<Self, DesignProblems> {
        Ok(match described {
            Described::Robot(file) => {
                Self::Modal { robot: Robot::from_design(file.design)?, memory: Memory::new() }
            }
            Described::Bundle { design, .. } => {
                let bundle = Bundle::new(&design)?;
                Self::Bundle(Arc::new(Parts { design, bundle }))
            }
        })
    }

    pub fn name(&self) -> &str {
        match self {
            Self::Modal { robot, .. } => &robot.design().name,
            Self::Bundle(own) => &own.design.name,
        }
    }

    pub fn length(&self) -> f64 {
        match self {
            Self::Modal { robot, .. } => robot.length(),
            Self::Bundle(own) => own.bundle.length(),
        }
    }

    pub fn tubes(&self) -> usize {
        match self {
            Self::Modal { robot, .. } => robot.tube_count(),
            Self::Bundle(own) => own.bundle.tube_count(),
        }
    }

    pub fn has_parts(&self) -> bool {
        matches!(self, Self::Bundle(_))
    }

    pub fn is_planar(&self) -> bool {
        match self {
            Self::Modal { robot, .. } => robot.is_planar(),
            Self::Bundle(own) => rests_in_plane(&own.bundle),
        }
    }

    /// Place of a tube's actuator in a command.
    pub fn actuator(&self, tube: u32) -> Result<usize, Misplaced> {
        let tubes = self.tubes();
        let index = usize::try_from(tube).ok().filter(|tube| (1..=tubes).contains(tube));
        match (index, self) {
            (None, _) => Err(Misplaced::NoTube { tube, tubes }),
            (Some(tube), Self::Modal { robot, .. }) => {
                robot.followers().position(|own| own == tube).ok_or(Misplaced::Leader)
            }
            (Some(tube), Self::Bundle(_)) => Ok(tube - 1),
        }
    }

    /// How many actuators there are.
    pub fn actuators(&self) -> usize {
        match self {
            Self::Modal { robot, .. } => robot.follower_count(),
            Self::Bundle(own) => own.bundle.tube_count(),
        }
    }
}

/// Do the centroid lines of a bundle at rest lie in the X-Y plane?
fn rests_in_plane(bundle: &Bundle) -> bool {
    let mut solver = BundleSolver::new(bundle);
    let Some(rest) = solver.rest().cloned() else { return false };
    let near = FLAT * bundle.length();
    let shape = solver.shape(&rest, bundle.length() / SECTIONS);
    shape.iter().all(|s| s.tubes.iter().all(|tube| (s.centre + s.offset(tube)).z.abs() <= near))
}
