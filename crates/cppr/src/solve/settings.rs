//! How to solve, and what of it makes no sense.

use crate::design::Robot;
use crate::kinematics::Resolution;
use std::fmt;

/// Which conditions are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Formulation {
    /// Stationary total energy: right for every robot.
    #[default]
    Consistent,
    /// The projected wrenches of the paper as printed (eq 48 and 64, 90 and 91): for comparison only.
    Printed,
}

/// How to solve. A [`Solver`](super::Solver) checks its settings when it is built and when they are changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Conditions of equilibrium. Default: consistent.
    pub formulation: Formulation,
    /// Modes and nodes. Default: [`Resolution::SPATIAL`].
    pub resolution: Resolution,
    /// Largest scaled residual at convergence, above 0 and at most 1e-6. Default 1e-11: actuation forces to about 1e-10.
    pub tolerance: f64,
    /// Newton iterations of one attempt, at least 1. Default 40; most robots take 3 to 8.
    pub iterations: usize,
    /// Smallest fraction of the command that load stepping tries to add, above 0 and at most 1. Default 1/256.
    pub smallest_step: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            formulation: Formulation::Consistent,
            resolution: Resolution::SPATIAL,
            tolerance: 1e-11,
            iterations: 40,
            smallest_step: 1.0 / 256.0,
        }
    }
}

/// Above this a scaled residual says nothing: angles would be off by as many radians.
const LOOSEST: f64 = 1e-6;
/// Load steps smaller than this part of a command are rounding.
const SMALLEST_STEP: f64 = 1e-12;
/// Most modes of a field and nodes of an element: a tangent of more unknowns does not fit into memory.
const FINEST: usize = 512;

impl Settings {
    /// Nothing leaves the X–Y plane: for planar robots under planar loads. Lateral instability is not seen.
    #[must_use]
    pub fn planar() -> Self {
        Self { resolution: Resolution::PLANAR, ..Self::default() }
    }

    /// The same with stretch of every tube.
    #[must_use]
    pub fn with_stretch(self) -> Self {
        Self { resolution: self.resolution.with_stretch(), ..self }
    }

    /// The same with the given modes and nodes.
    #[must_use]
    pub fn with_resolution(self, resolution: Resolution) -> Self {
        Self { resolution, ..self }
    }

    /// Were numbers of modes chosen other than [`Resolution::SPATIAL`] and [`Resolution::PLANAR`]?
    #[must_use]
    pub fn modes_are_chosen(&self) -> bool {
        let own = Resolution { stretch: 0, ..self.resolution };
        own != Resolution::SPATIAL && own != Resolution::PLANAR
    }

    /// Can a follower (0 is the first) be pulled at all? Not where it bends nothing and nothing stretches.
    #[must_use]
    pub fn can_slide(&self, robot: &Robot, follower: usize) -> bool {
        self.resolution.stretch > 0 || robot.has_lever(follower)
    }

    /// Can a robot be solved with these settings?
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self, robot: &Robot) -> Result<(), SettingsProblem> {
        let Self { formulation: _, resolution, tolerance, iterations, smallest_step } = *self;
        let Resolution { twist, bending_y, bending_z, angle, stretch, nodes } = resolution;
        if !(tolerance > 0.0 && tolerance <= LOOSEST) {
            return Err(SettingsProblem::Tolerance(tolerance));
        }
        if iterations == 0 {
            return Err(SettingsProblem::NoIteration);
        }
        if !(SMALLEST_STEP..=1.0).contains(&smallest_step) {
            return Err(SettingsProblem::SmallestStep(smallest_step));
        }
        if bending_z == 0 || nodes == 0 {
            return Err(SettingsProblem::NoModes);
        }
        let most = [twist, bending_y, bending_z, angle, stretch, nodes].into_iter().fold(0, usize::max);
        if most > FINEST {
            return Err(SettingsProblem::TooFine(most));
        }
        if stretch > 0 && !robot.has_axial_stiffness() {
            return Err(SettingsProblem::NoAxialStiffness);
        }
        Ok(())
    }
}

/// Settings with which a robot cannot be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingsProblem {
    /// The tolerance is NaN, not positive, or so large that it says nothing.
    Tolerance(f64),
    /// Newton's method may take no step.
    NoIteration,
    /// The smallest load step is NaN, not positive (load stepping would not end) or above 1.
    SmallestStep(f64),
    /// The resolution has no bending modes or no nodes.
    NoModes,
    /// The resolution has more modes or nodes than fit into memory.
    TooFine(usize),
    /// Stretch is asked for, but a tube has no axial stiffness.
    NoAxialStiffness,
}

impl fmt::Display for SettingsProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tolerance(value) => {
                write!(f, "the tolerance is {value}; it must be above 0 and at most {LOOSEST:e}")
            }
            Self::NoIteration => write!(f, "no Newton iteration is allowed; allow at least one"),
            Self::SmallestStep(value) => {
                write!(f, "the smallest load step is {value}; it must be from {SMALLEST_STEP:e} to 1")
            }
            Self::NoModes => write!(f, "the resolution needs at least one mode of bending and one node"),
            Self::TooFine(count) => {
                write!(f, "the resolution has {count} modes or nodes of one kind; take at most {FINEST}")
            }
            Self::NoAxialStiffness => {
                write!(
                    f,
                    "stretch needs the axial stiffness of every tube; a tube given by its stiffness lacks it"
                )
            }
        }
    }
}

impl std::error::Error for SettingsProblem {}
