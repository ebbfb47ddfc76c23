//! What plate and joints leave open under one command: the unknowns of Newton's method, in units of their own.

use super::Bundle;
use super::number::Number;
use super::prepared::{Lengthening, Prepared};
use super::section::TubeState;
use super::solve::BundleCommand;
use super::walk::{Base, Walk};
use crate::solve::Drive;

/// Values of the unknowns by what they are.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Unknowns {
    pub tubes: Vec<[f64; 4]>,
    pub force: [f64; 3],
    pub moment: [f64; 2],
    pub handed: Vec<[f64; 2]>,
}

/// How drives and the factor of the loads change along a path.
pub(super) struct Rates {
    pub drives: Vec<[f64; 2]>,
    pub load: f64,
}

/// The unknowns of one command.
pub(super) struct Frame<'a> {
    bundle: &'a Bundle,
    command: &'a BundleCommand,
    pub prepared: Prepared,
    /// Factor of the loads.
    pub load: f64,
    /// Of a path.
    pub rates: Option<Rates>,
    present: Vec<bool>,
    handed: usize,
}

impl<'a> Frame<'a> {
    pub fn new(bundle: &'a Bundle, command: &'a BundleCommand, lengthening: Lengthening) -> Self {
        let prepared = Prepared::new(bundle, &command.loads, lengthening);
        let present = (0..bundle.tubes.len())
            .map(|i| match command.drives[i].translation {
                Drive::Motion(label) => label < bundle.tubes[i].tip,
                Drive::Effort(_) => true,
            })
            .collect();
        let handed = bundle
            .stations
            .iter()
            .map(|s| s.iter().filter(|&&(t, label)| label < bundle.tubes[t].tip).count().saturating_sub(1));
        let handed = handed.sum();
        Self { bundle, command, prepared, load: 1.0, rates: None, present, handed }
    }

    pub fn units(&self) -> [f64; 4] {
        let length = self.bundle.length;
        let force = self.prepared.force_scale;
        [length, force, 1.0, force * length]
    }

    pub fn count(&self) -> usize {
        2 * self.present.iter().filter(|p| **p).count()
            + if self.prepared.loaded { 2 } else { 0 }
            + if self.prepared.seeks_force { 3 } else { 0 }
            + 2 * self.handed
    }

    /// The start of the walk for scaled unknowns and the drives' values.
    pub fn base<S: Number>(&self, unknowns: &[S], drives: &[[S; 2]]) -> Base<S> {
        self.base_under(unknowns, drives, S::constant(self.load))
    }

    /// The same for a factor of the loads.
    pub fn base_under<S: Number>(&self, unknowns: &[S], drives: &[[S; 2]], load: S) -> Base<S> {
        let [length, force, _, moment] = self.units();
        let mut next = unknowns.iter();
        let mut take = |unit: f64| next.next().map_or(S::constant(0.0), |u| *u * unit);
        let mut tubes = Vec::with_capacity(self.present.len());
        let mut twist = S::constant(0.0);
        for (i, drive) in self.command.drives.iter().enumerate() {
            let [travel, turn] = drives[i];
            if !self.present[i] {
                let zero = S::constant(0.0);
                tubes.push(TubeState { label: travel, tension: zero, angle: turn, torque: zero });
                continue;
            }
            let shaft = self.bundle.tubes[i].shaft;
            let (label, tension) = match drive.translation {
                Drive::Motion(_) => {
                    let tension = take(force);
                    let label = match shaft {
                        Some(s) => travel - tension * (1.0 / s.axial),
                        None => travel,
                    };
                    (label, tension)
                }
                Drive::Effort(_) => (take(length), travel),
            };
            let (angle, torque) = match drive.rotation {
                Drive::Motion(_) => {
                    let torque = take(moment);
                    let angle = match shaft {
                        Some(s) => turn + torque * (1.0 / s.torsional),
                        None => turn,
                    };
                    (angle, torque)
                }
                Drive::Effort(_) => (take(1.0), -turn),
            };
            twist += torque;
            tubes.push(TubeState { label, tension, angle, torque });
        }
        let zero = S::constant(0.0);
        let mut base = Base {
            tubes,
            force: self.prepared.dead_force.map(|f| load * f),
            moment: [zero; 3],
            handed: Vec::new(),
            wrench: None,
            load,
            unknowns: unknowns.len(),
        };
        if self.prepared.loaded {
            base.moment = [twist, take(moment), take(moment)];
        }
        if self.prepared.seeks_force {
            base.force = [take(force), take(force), take(force)];
        }
        for _ in 0..self.handed {
            base.handed.push([take(force), take(moment)]);
        }
        base
    }

    pub fn drives(&self) -> Vec<[f64; 2]> {
        self.command.drives.iter().map(|d| [d.translation.value(), d.rotation.value()]).collect()
    }

    /// For translation and rotation of every tube, the scaled unknown that answers what is prescribed of it, and its unit; none of a tube that is not there.
    pub fn conjugates(&self) -> Vec<Option<(usize, f64)>> {
        let [length, force, _, moment] = self.units();
        let mut conjugates = Vec::with_capacity(2 * self.present.len());
        let mut row = 0;
        for (drive, present) in self.command.drives.iter().zip(&self.present) {
            if !present {
                conjugates.extend([None, None]);
                continue;
            }
            let translation = if drive.translation.is_motion() { force } else { length };
            // A motor's torque is −π.
            let rotation = if drive.rotation.is_motion() { -moment } else { 1.0 };
            conjugates.extend([Some((row, translation)), Some((row + 1, rotation))]);
            row += 2;
        }
        conjugates
    }

    /// Scaled unknowns from what is known of a neighbour.
    pub fn scaled(&self, from: &Unknowns) -> Vec<f64> {
        let [length, force, _, moment] = self.units();
        let mut result = Vec::with_capacity(self.count());
        for (i, drive) in self.command.drives.iter().enumerate() {
            if self.present[i] {
                let [label, tension, angle, torque] = from.tubes.get(i).copied().unwrap_or_default();
                result.push(if drive.translation.is_motion() { tension / force } else { label / length });
                result.push(if drive.rotation.is_motion() { torque / moment } else { angle });
            }
        }
        if self.prepared.loaded {
            result.extend(from.moment.map(|m| m / moment));
        }
        if self.prepared.seeks_force {
            result.extend(from.force.map(|f| f / force));
        }
        for i in 0..self.handed {
            let [t, p] = from.handed.get(i).copied().unwrap_or_default();
            result.extend([t / force, p / moment]);
        }
        result
    }

    pub fn unknowns(&self, scaled: &[f64]) -> Unknowns {
        let base = self.base(scaled, &self.drives());
        Unknowns {
            tubes: base.tubes.iter().map(|t| [t.label, t.tension, t.angle, t.torque]).collect(),
            force: base.force,
            moment: [base.moment[1], base.moment[2]],
            handed: base.handed,
        }
    }

    pub fn walk(&self, tolerance: f64) -> Walk<'_> {
        Walk {
            bundle: self.bundle,
            command: &self.prepared,
            posed: self.prepared.loaded,
            tolerance,
            longest: f64::INFINITY,
            spacing: f64::INFINITY,
            course: None,
        }
    }
}
