//! What a bundle is asked: its motors and loads.

use crate::solve::{Drive, Freedom, Input};
use crate::statics::Loads;

/// Longest turn of a motor (rad) in one step: further on, two eigenvalues may have changed their signs, and the determinant that of neither.
const LONGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// What the motors of one tube do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TubeDrive {
    /// Travel of the motor (m), pull positive: the label that stands at the plate, were the shaft rigid; or the force (N) with which
    /// it pulls.
    pub translation: Drive,
    /// Rotation of the motor (rad), right-handed about +X, or its torque (N m).
    pub rotation: Drive,
}

impl TubeDrive {
    /// Held where it stands at rest.
    pub const HELD: Self = Self { translation: Drive::Motion(0.0), rotation: Drive::Motion(0.0) };
}

/// Motors and loads of a bundle.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BundleCommand {
    /// One per tube.
    pub drives: Vec<TubeDrive>,
    /// External loads.
    pub loads: Loads,
}

impl BundleCommand {
    /// What is prescribed: translation and rotation of tube 1, then of tube 2, …
    #[must_use]
    pub fn inputs(&self) -> Vec<Input> {
        let own = |(tube, drive): (usize, &TubeDrive)| {
            [(Freedom::PushPull, drive.translation), (Freedom::Rotation, drive.rotation)]
                .map(|(freedom, told)| Input { tube, freedom, is_motion: told.is_motion() })
        };
        (1..).zip(&self.drives).flat_map(own).collect()
    }

    /// The same command with one input at another value; an input that is not there changes nothing.
    #[must_use]
    pub fn with_input(&self, input: Input, value: f64) -> Self {
        let mut command = self.clone();
        if let Some(own) = input.tube.checked_sub(1).and_then(|tube| command.drives.get_mut(tube)) {
            *(match input.freedom {
                Freedom::PushPull => &mut own.translation,
                Freedom::Rotation => &mut own.rotation,
            }) = input.prescribed(value);
        }
        command
    }

    pub(crate) fn between(&self, start: &Self, share: f64) -> Self {
        let mix = |a: Drive, b: Drive| {
            let from = if a.is_motion() == b.is_motion() { a.value() } else { 0.0 };
            b.with_value(from + share * (b.value() - from))
        };
        let drives = start.drives.iter().zip(&self.drives);
        Self {
            drives: drives
                .map(|(a, b)| TubeDrive {
                    translation: mix(a.translation, b.translation),
                    rotation: mix(a.rotation, b.rotation),
                })
                .collect(),
            loads: self.loads.scaled(share),
        }
    }

    /// Is the same prescribed of every tube as in another command?
    pub(super) fn driven_as(&self, other: &Self) -> bool {
        let same = |a: Drive, b: Drive| a.is_motion() == b.is_motion();
        let both = self.drives.iter().zip(&other.drives);
        both.into_iter().all(|(a, b)| same(a.translation, b.translation) && same(a.rotation, b.rotation))
    }

    /// Which part of the way from another command turns no motor by more than [`LONGEST_TURN`].
    pub(super) fn share_of_turn(&self, start: &Self) -> f64 {
        let drives = self.drives.iter().zip(&start.drives);
        let turned = |(a, b): (&TubeDrive, &TubeDrive)| {
            let both = a.rotation.motion().zip(b.rotation.motion());
            both.map_or(0.0, |(to, from)| (to - from).abs())
        };
        LONGEST_TURN / drives.map(turned).fold(LONGEST_TURN, f64::max)
    }
}
