//! Any bundle of tubes: parts, joints on the way, tubes of different length, free tips, tubes curved at rest, insertion.
//!
//! Every tube is treated alike. Its rotation is that of its material, so that patterns may turn over at a step; its section at
//! a place is known by the label x on its own axis. The equilibrium is an extremal of the energy, and its equations are Hamilton's, with
//! tensions and torques as momenta (`section`). They are integrated from the plate to the last tip, from one event to the
//! next (`walk`, `steps`); Newton's method finds what plate and joints leave open ([`solve`]). Nothing has modes: how accurate an answer
//! is depends on the steps of the integration alone, which are chosen by their estimated error.
//!
//! Under `solve` in this crate stands the faster solver for tubes of one length that are joined at the tip.

mod build;
mod check;
mod command;
mod contact;
mod coordinates;
pub(crate) mod course;
pub(crate) mod curve;
mod equilibrium;
mod flow;
pub(crate) mod frame;
mod friction;
mod history;
mod index;
mod limits;
mod load_path;
mod metal;
mod newton;
mod number;
mod order;
mod path;
mod prepared;
mod rubbing;
mod section;
mod sensitivity;
mod shape;
pub mod solve;
mod steps;
mod tableau;
mod track;
mod vector;
mod walk;

use crate::solve::Drive;
pub use build::{BundleDesign, Part, TubeParts};
pub use check::BundleProblem;
pub use contact::{Contact, ContactPoint, PairContact, PointContact};
use curve::Piece;
pub use curve::Values;
pub use friction::{Friction, Rubbed, Slip};
pub use history::{HistoryPoint, SavedHistory, SlipHistory};
pub use path::BundleFamily;
use rubbing::Rubbing;
pub use shape::{BundleSection, TubeSection};
use solve::TubeDrive;
use std::sync::Arc;

/// What lies between the motor of a tube and the plate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shaft {
    /// Axial stiffness (N/m).
    pub axial: f64,
    /// Torsional stiffness (N m/rad).
    pub torsional: f64,
    /// Are both those of an uncut length of the tube, EA/ℓ and GJ/ℓ, so that they follow its moduli?
    pub of_material: bool,
}

/// One tube of a bundle.
#[derive(Clone, Debug)]
pub struct BundleTube {
    /// Pieces from below the plate to the tip.
    pub(crate) pieces: Vec<Piece>,
    /// Label of its tip (m).
    pub(crate) tip: f64,
    /// Between motor and plate; `None` is rigid.
    pub(crate) shaft: Option<Shaft>,
    /// Outer radius (m) and thickness of the wall (m); 0 of a tube that is given by its stiffness.
    pub(crate) radius: f64,
    pub(crate) wall: f64,
}

impl BundleTube {
    /// The piece that holds a label; at a boundary the one beyond.
    pub(crate) fn piece_at(&self, label: f64) -> &Piece {
        let index = self.pieces.partition_point(|piece| piece.to <= label);
        &self.pieces[index.min(self.pieces.len() - 1)]
    }
}

/// Labels this close (as a part of the length) are the same.
const SAME: f64 = 1e-9;

/// A checked bundle.
#[derive(Clone, Debug)]
pub struct Bundle {
    /// From outside to inside.
    pub(crate) tubes: Vec<BundleTube>,
    /// Joints and free tips: tubes (index) and their labels (m) there.
    pub(crate) stations: Vec<Vec<(usize, f64)>>,
    /// Greatest label of a tip (m).
    pub(crate) length: f64,
    /// Scale of the bending stiffness (N m²).
    pub(crate) bending: f64,
    /// Friction between its tubes, in solves that count it.
    pub(crate) rubbing: Option<Arc<Rubbing>>,
}

impl Bundle {
    /// Greatest label of a tip (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// EI_Z and GJ of all tubes together (N m²), each halfway along its own, and the greatest centroid offset there (m).
    pub(crate) fn stiffness(&self) -> [f64; 3] {
        self.tubes.iter().fold([0.0; 3], |[bending, torsion, lever], tube| {
            let middle = 0.5 * tube.tip;
            let [offset, _, own_bending, own_torsion, ..] = tube.piece_at(middle).table_at(middle);
            [bending + own_bending, torsion + own_torsion, f64::max(lever, offset)]
        })
    }

    /// Number of tubes.
    #[must_use]
    pub fn tube_count(&self) -> usize {
        self.tubes.len()
    }

    /// A tube (index) that these motors pull so far that one of its joints, at the label (m), would lie behind the plate.
    #[must_use]
    pub fn joint_behind_plate(&self, drives: &[TubeDrive]) -> Option<(usize, f64)> {
        let joints = self.stations.iter().filter(|station| station.len() > 1);
        joints.flatten().copied().find(|&(tube, label)| match drives.get(tube).map(|d| d.translation) {
            Some(Drive::Motion(pulled)) => pulled >= label,
            Some(Drive::Effort(_)) | None => false,
        })
    }

    /// The same of tubes that curve less when free, by a factor.
    pub(crate) fn curved_by(&self, part: f64) -> Self {
        let mut other = self.clone();
        for piece in other.tubes.iter_mut().flat_map(|tube| &mut tube.pieces) {
            piece.curve_less(part);
        }
        other
    }

    /// A bundle of tubes with joints: for each its tubes (index) and their labels (m). Tips in no joint are free.
    pub(crate) fn assemble(tubes: Vec<BundleTube>, joints: Vec<Vec<(usize, f64)>>) -> Self {
        let length = tubes.iter().fold(0.0, |m: f64, t| m.max(t.tip));
        let bending = tubes
            .iter()
            .map(|t| t.pieces.iter().map(|p| p.field(2, p.to)[0]).fold(f64::INFINITY, f64::min))
            .sum();
        let mut stations = joints;
        for joint in &mut stations {
            joint.sort_unstable_by_key(|&(tube, _)| tube);
            for (tube, label) in joint.iter_mut() {
                // Lengths of parts add up to within rounding.
                let tip = tubes[*tube].tip;
                if (*label - tip).abs() <= SAME * length {
                    *label = tip;
                }
            }
        }
        for (i, tube) in tubes.iter().enumerate() {
            if !stations.iter().any(|s| s.iter().any(|&(t, label)| t == i && label >= tube.tip)) {
                stations.push(vec![(i, tube.tip)]);
            }
        }
        Self { tubes, stations, length, bending, rubbing: None }
    }
}
