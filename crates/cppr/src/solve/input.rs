//! Inputs of actuators and what is conjugate to them: pull and tension, rotation and torque, of which tube, in which unit.
//!
//! Every program, file and page names these quantities; the names and units stand here, and nowhere else.

use super::command::Drive;
use std::f64::consts::PI;

/// Number of the first follower: tube 1 is the leader.
const FIRST_FOLLOWER: usize = 2;

/// Tube number of a follower, of which 0 is the first.
pub(crate) fn tube_of(follower: usize) -> usize {
    follower + FIRST_FOLLOWER
}

/// Which follower a tube is; `None` for the leader.
pub(crate) fn follower_of(tube: usize) -> Option<usize> {
    tube.checked_sub(FIRST_FOLLOWER)
}

/// Which degree of freedom of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Translation: Δa_k (m) and T_k (N).
    PushPull,
    /// Rotation: Ω_k (rad) and Υ_k (N m).
    Rotation,
}

impl Freedom {
    /// Both, in the order in which they are listed everywhere.
    pub const BOTH: [Self; 2] = [Self::PushPull, Self::Rotation];
}

/// One input of a robot: a degree of freedom of one follower, driven by motion or by effort. Column of a Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// Tube number as in the paper: 2 is the first follower.
    pub tube: usize,
    /// Its degree of freedom.
    pub freedom: Freedom,
    /// True where the motion is prescribed, false where the effort is.
    pub is_motion: bool,
}

impl Input {
    /// What is prescribed.
    #[must_use]
    pub const fn quantity(self) -> Quantity {
        Quantity::of(self.freedom, self.is_motion)
    }

    /// A value of it.
    #[must_use]
    pub fn prescribed(self, value: f64) -> Drive {
        if self.is_motion { Drive::Motion(value) } else { Drive::Effort(value) }
    }

    /// What answers: the effort where the motion is prescribed, the motion where the effort is.
    #[must_use]
    pub const fn conjugate(self) -> Self {
        Self { is_motion: !self.is_motion, ..self }
    }

    /// The same degree of freedom of the same tube, however it is driven?
    #[must_use]
    pub fn is_same_freedom(self, other: Self) -> bool {
        self.tube == other.tube && self.freedom == other.freedom
    }
}

/// A motion or an effort: its names, and its units for programs and for people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Degree of freedom.
    pub freedom: Freedom,
    /// A motion, or an effort?
    pub is_motion: bool,
    /// `pull`, `tension`, `rotation`, `torque`.
    pub name: &'static str,
    /// Option or keyword that prescribes it: `pull`, `tension`, `rotate`, `torque`.
    pub keyword: &'static str,
    /// Symbol of the notation page: Δa, T, Ω, Υ.
    pub symbol: &'static str,
    /// Unit of numbers in tables, JSON and Python (SI): `m`, `N`, `rad`, `Nm`.
    pub unit: &'static str,
    /// Unit of numbers that people read: `mm`, `N`, `deg`, `N mm`.
    pub shown_unit: &'static str,
    /// Size of that unit in SI.
    pub shown_size: f64,
}

impl Quantity {
    /// All four: motion and effort of the translation, then of the rotation.
    pub const ALL: [Self; 4] = [Self::PULL, Self::TENSION, Self::ROTATION, Self::TORQUE];

    /// Δa_k, pull positive.
    pub const PULL: Self = Self::new(Freedom::PushPull, true, ["pull", "pull", "Δa", "m", "mm"], 1e-3);
    /// T_k, pull positive.
    pub const TENSION: Self = Self::new(Freedom::PushPull, false, ["tension", "tension", "T", "N", "N"], 1.0);
    /// Ω_k, right-handed about +X.
    pub const ROTATION: Self =
        Self::new(Freedom::Rotation, true, ["rotation", "rotate", "Ω", "rad", "deg"], PI / 180.0);
    /// Υ_k, conjugate to the rotation.
    pub const TORQUE: Self =
        Self::new(Freedom::Rotation, false, ["torque", "torque", "Υ", "Nm", "N mm"], 1e-3);

    const fn new(freedom: Freedom, is_motion: bool, names: [&'static str; 5], shown_size: f64) -> Self {
        let [name, keyword, symbol, unit, shown_unit] = names;
        Self { freedom, is_motion, name, keyword, symbol, unit, shown_unit, shown_size }
    }

    /// The quantity of a degree of freedom.
    #[must_use]
    pub const fn of(freedom: Freedom, is_motion: bool) -> Self {
        match (freedom, is_motion) {
            (Freedom::PushPull, true) => Self::PULL,
            (Freedom::PushPull, false) => Self::TENSION,
            (Freedom::Rotation, true) => Self::ROTATION,
            (Freedom::Rotation, false) => Self::TORQUE,
        }
    }

    /// The quantity that an option or keyword prescribes.
    #[must_use]
    pub fn named(keyword: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.keyword == keyword)
    }

    /// The quantity as the input of a tube.
    #[must_use]
    pub const fn of_tube(self, tube: usize) -> Input {
        Input { tube, freedom: self.freedom, is_motion: self.is_motion }
    }

    /// Name with unit, as columns and keys have it: `pull_m`.
    #[must_use]
    pub fn column(self) -> String {
        format!("{}_{}", self.name, self.unit)
    }

    /// A value (SI) in the unit that people read.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        value / self.shown_size
    }
}
