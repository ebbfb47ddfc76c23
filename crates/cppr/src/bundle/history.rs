//! Histories of tubes that rub on each other: steps from one command to the next.
//!
//! In a step the pair of tubes holds t = t_before + k · (slip since then) as long as that is below μ |p|, and slips beyond; what slips is dissipated. Such a
//! step does not depend on its size while the slip goes one way. The stiffness k lets what sticks give way by μ |p|/k before it slips. The error that this makes is
//! proportional to 1/k, and is taken off by doing every step with two stiffnesses, one half of the other.

use super::Bundle;
use super::contact::Cut;
use super::frame::Unknowns;
use super::friction::{Friction, Rubbed, neighbours, radius, rows};
use super::limits::{Limits, along};
use super::rubbing::{BEYOND, Columns, Law, Pair, Rubbing, Table};
use super::solve::{BundleCommand, BundleSolver, TubeEffort};
use super::steps::Steps;
use nalgebra::Vector3;

/// Over how many of its lengths of decay a stuck robot of two tubes is long: a stuck state grows by the exponential of this along it. More pairs make it softer.
const LENGTHS: f64 = 11.0;
/// Error allowed in one step of the integration of a history: what tables hold is smooth to about this.
const TOLERANCE: f64 = 1e-7;
/// Shortest part of a step, which is halved where it does not arrive.
const SHORTEST: f64 = 1.0 / 64.0;

/// What a pair remembers of a state: x_j − x_i (m), α_j − α_i (rad), t along and around (N/m), by the outer tube's label.
pub(super) fn remembered(
    cuts: &[Cut],
    pair: [usize; 2],
    held: impl Fn(&Cut, usize) -> [f64; 2],
) -> Columns<4> {
    rows(cuts, pair, |cut, place| {
        let (outer, inner) = (&cut.sides[place], &cut.sides[place + 1]);
        let [along, around] = held(cut, place);
        [inner.label - outer.label, inner.angle - outer.angle, along, around]
    })
}

/// What a pair takes from one step to the next.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Memory {
    pair: [usize; 2],
    before: Columns<4>,
    /// μ |p| (N/m).
    limits: Columns<1>,
}

/// A history with one stiffness of what sticks.
#[derive(Clone, Debug)]
struct Level {
    rubbed: Rubbed,
    memory: Vec<Memory>,
    /// Part of the length on which neighbours slip.
    slipping: f64,
    /// Which way every tube slid in the guide last.
    ways: Vec<f64>,
    /// As a part of the greatest stiffness that can be integrated.
    share: f64,
}

/// A robot that is driven from one command to the next, with friction.
#[derive(Clone, Debug)]
pub struct SlipHistory {
    bundle: Bundle,
    stretch: bool,
    friction: Friction,
    levels: [Level; 2],
}

/// A history as numbers.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedHistory {
    levels: [SavedLevel; 2],
}

#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct SavedLevel {
    tubes: Vec<[f64; 4]>,
    force: [f64; 3],
    moment: [f64; 2],
    handed: Vec<[f64; 2]>,
    tip: [f64; 3],
    efforts: Vec<[f64; 4]>,
    memory: Vec<Memory>,
    slipping: f64,
    ways: Vec<f64>,
}

/// Where a history stands.
#[derive(Clone, Debug)]
pub struct HistoryPoint {
    /// Centre of the last tip (m).
    pub tip: Vector3<f64>,
    /// Motors, with what rubs in the guide: one per tube.
    pub efforts: Vec<TubeEffort>,
    /// Part of the length on which neighbours slip; where one pair sticks the other may not.
    pub slipping: f64,
    /// How far tip (m) and forces (N) were corrected for the elasticity of what sticks: what is left is far less.
    pub corrected: [f64; 2],
}

impl SlipHistory {
    /// At rest, where nothing has slipped yet. `None` where rest is not found.
    #[must_use]
    pub fn new(solver: &mut BundleSolver, friction: Friction) -> Option<Self> {
        let rest = solver.rest()?.clone();
        let level = |share: f64| {
            let cuts = solver.cuts(&rest, solver.spacing(&friction), &mut Vec::new())?;
            let memory = memories(&cuts, &friction, &Rubbing::default());
            let ways = vec![0.0; rest.efforts.len()];
            let (efforts, bundle) = (rest.efforts.clone(), solver.bundle.clone());
            let rubbed = Rubbed { efforts, equilibrium: rest.clone(), bundle, rounds: 0 };
            Some(Level { rubbed, memory, slipping: 0.0, ways, share })
        };
        let levels = [level(1.0)?, level(0.5)?];
        Some(Self { bundle: solver.bundle.clone(), stretch: solver.stretch, friction, levels })
    }

    /// All that it takes to go on later, as numbers.
    #[must_use]
    pub fn saved(&self) -> SavedHistory {
        let level = |own: &Level| {
            let Unknowns { tubes, force, moment, handed } = own.rubbed.equilibrium.unknowns.clone();
            let efforts = own.rubbed.efforts.iter();
            SavedLevel {
                tubes,
                force,
                moment,
                handed,
                tip: own.rubbed.equilibrium.tip.into(),
                efforts: efforts.map(|e| [e.label, e.rotation, e.force, e.torque]).collect(),
                memory: own.memory.clone(),
                slipping: own.slipping,
                ways: own.ways.clone(),
            }
        };
        SavedHistory { levels: self.levels.each_ref().map(level) }
    }

    /// Goes on from what was saved under a command. `None` where that is not of this robot.
    #[must_use]
    pub fn restored(
        solver: &mut BundleSolver,
        friction: Friction,
        saved: SavedHistory,
        command: &BundleCommand,
    ) -> Option<Self> {
        let mut history = Self::new(solver, friction)?;
        for (own, saved) in history.levels.iter_mut().zip(saved.levels) {
            let SavedLevel { tubes, force, moment, handed, tip, efforts, memory, slipping, ways } = saved;
            let count = own.ways.len();
            let other = [tubes.len(), efforts.len(), ways.len(), command.drives.len()];
            if other.iter().any(|own| *own != count)
                || memory.iter().any(|own| own.pair.iter().any(|t| *t >= count))
            {
                return None;
            }
            own.rubbed.equilibrium.unknowns = Unknowns { tubes, force, moment, handed };
            own.rubbed.equilibrium.between = Steps::default();
            own.rubbed.equilibrium.command = command.clone();
            own.rubbed.equilibrium.tip = tip.into();
            let efforts = efforts.into_iter();
            own.rubbed.efforts = efforts
                .map(|[label, rotation, force, torque]| TubeEffort { label, rotation, force, torque })
                .collect();
            (own.memory, own.slipping, own.ways) = (memory, slipping, ways);
        }
        Some(history)
    }

    /// Where it stands.
    #[must_use]
    pub fn point(&self) -> HistoryPoint {
        let [fine, coarse] = &self.levels;
        let beyond = |a: f64, b: f64| 2.0 * a - b;
        let pairs = fine.rubbed.efforts.iter().zip(&coarse.rubbed.efforts);
        let efforts: Vec<TubeEffort> = pairs
            .map(|(a, b)| TubeEffort {
                label: beyond(a.label, b.label),
                rotation: beyond(a.rotation, b.rotation),
                force: beyond(a.force, b.force),
                torque: beyond(a.torque, b.torque),
            })
            .collect();
        let shift = fine.rubbed.equilibrium.tip - coarse.rubbed.equilibrium.tip;
        let most = efforts.iter().zip(&fine.rubbed.efforts).map(|(a, b)| (a.force - b.force).abs());
        HistoryPoint {
            tip: fine.rubbed.equilibrium.tip + shift,
            slipping: fine.slipping,
            corrected: [shift.norm(), most.fold(0.0, f64::max)],
            efforts,
        }
    }

    /// Drives the robot to a command. `false` where it does not get there: then it stands where it stood.
    pub fn drive(&mut self, command: &BundleCommand) -> bool {
        let from = self.levels[0].rubbed.equilibrium.command.clone();
        let before = self.levels.clone();
        let done = self.levels.iter_mut().all(|level| {
            level.drive(&self.bundle, self.stretch, &self.friction, [&from, command], [0.0, 1.0])
        });
        if !done {
            self.levels = before;
        }
        done
    }
}

impl BundleCommand {
    /// A part of the way from another command to this one. Loads that are not the same grow from none.
    #[must_use]
    pub fn on_the_way_from(&self, start: &Self, share: f64) -> Self {
        let own = self.between(start, share);
        if self.loads == start.loads { Self { loads: self.loads.clone(), ..own } } else { own }
    }
}

impl Level {
    /// In one step, or in two halves where that does not arrive; `span` is the part of the way.
    fn drive(
        &mut self,
        bundle: &Bundle,
        stretch: bool,
        friction: &Friction,
        ends: [&BundleCommand; 2],
        span: [f64; 2],
    ) -> bool {
        let at = |share: f64| ends[1].on_the_way_from(ends[0], share);
        if self.step(bundle, stretch, friction, &at(span[0]), &at(span[1])).is_some() {
            return true;
        }
        let middle = 0.5 * (span[0] + span[1]);
        span[1] - span[0] > SHORTEST
            && self.drive(bundle, stretch, friction, ends, [span[0], middle])
            && self.drive(bundle, stretch, friction, ends, [middle, span[1]])
    }

    fn step(
        &mut self,
        bundle: &Bundle,
        stretch: bool,
        friction: &Friction,
        from: &BundleCommand,
        to: &BundleCommand,
    ) -> Option<()> {
        let mut ways = self.ways.clone();
        for (way, (a, b)) in ways.iter_mut().zip(from.drives.iter().zip(&to.drives)) {
            let travel = b.translation.value() - a.translation.value();
            if travel.abs() > 0.0 {
                *way = travel.signum();
            }
        }
        let rubbing = |limits: &Limits| {
            let pairs = self.memory.iter().map(|own| {
                let [outer, inner] = own.pair;
                let law = Law::History {
                    limit: Table::new(limits.along(own.pair)),
                    before: Table::new(&own.before),
                    stiffness: self.share * stiffest(bundle, own.pair),
                };
                Pair { outer, inner, radius: radius(bundle, inner), law }
            });
            (Rubbing(pairs.collect()), limits.more(&ways))
        };
        let pairs = self.memory.iter().map(|own| (own.pair, own.limits.clone())).collect();
        let first = Limits { pairs, guide: Vec::new() };
        let solver = BundleSolver::new(bundle).with_stretch(stretch).with_tolerance(TOLERANCE);
        let start = &self.rubbed.equilibrium;
        let (rubbed, cuts) = solver.agree(to, start, friction, first, Vec::new(), rubbing)?;
        let none = Rubbing::default();
        let rubbing = rubbed.bundle.rubbing.as_deref().unwrap_or(&none);
        self.slipping = slipping(&cuts, rubbing);
        self.memory = memories(&cuts, friction, rubbing);
        (self.rubbed, self.ways) = (rubbed, ways);
        Some(())
    }
}

fn memories(cuts: &[Cut], friction: &Friction, rubbing: &Rubbing) -> Vec<Memory> {
    let each = neighbours(cuts).into_iter().map(|pair| Memory {
        pair,
        before: remembered(cuts, pair, |cut, place| held(rubbing, cut, place)),
        limits: along(cuts, pair, friction),
    });
    each.collect()
}

/// What a pair would hold at a section if it stuck, and what it can (N/m).
fn trial(rubbing: &Rubbing, cut: &Cut, place: usize) -> ([f64; 2], f64) {
    let pair = rubbing.pair(cut.tubes[place], cut.tubes[place + 1]);
    match pair.map(|pair| (pair, &pair.law)) {
        Some((pair, Law::History { limit, .. })) => {
            let [limit] = limit.at(cut.passed, cut.sides[place].label);
            (pair.trial(cut.passed, &cut.sides[place], &cut.sides[place + 1]), limit)
        }
        _ => ([0.0; 2], 0.0),
    }
}

/// What a pair holds at a section (N/m): not far beyond its limit.
fn held(rubbing: &Rubbing, cut: &Cut, place: usize) -> [f64; 2] {
    let ([along, around], limit) = trial(rubbing, cut, place);
    let share = (BEYOND * limit / along.hypot(around)).min(1.0);
    [along, around].map(|own| if share.is_finite() { own * share } else { 0.0 })
}

/// Part of the length on which neighbours slip.
fn slipping(cuts: &[Cut], rubbing: &Rubbing) -> f64 {
    let [mut all, mut slips] = [0.0; 2];
    for pair in cuts.windows(2) {
        let way = pair[1].length - pair[0].length;
        for place in 0..pair[0].tubes.len().saturating_sub(1) {
            let cut = &pair[0];
            all += way;
            let law = rubbing.pair(cut.tubes[place], cut.tubes[place + 1]);
            if law.is_some_and(|own| own.slips(cut.passed, &cut.sides[place], &cut.sides[place + 1])) {
                slips += way;
            }
        }
    }
    if all > 0.0 { slips / all } else { 0.0 }
}

/// The greatest stiffness (N/m²) with which a pair may stick: state and slip decay over the length divided by [`LENGTHS`].
fn stiffest(bundle: &Bundle, [outer, inner]: [usize; 2]) -> f64 {
    let of = |tube: usize| {
        let middle = 0.5 * bundle.tubes[tube].tip;
        let [offset, _, _, torsion, ..] = bundle.tubes[tube].piece_at(middle).table_at(middle);
        (offset, torsion)
    };
    let ((d, gj), (other, own)) = (of(outer), of(inner));
    let lever = (d + other).max(LEAST_LEVER * bundle.length);
    let around = radius(bundle, inner).powi(2) * (1.0 / gj + 1.0 / own);
    let pairs = bundle.tubes.len() as f64 - 1.0;
    (LENGTHS / (pairs * bundle.length)).powi(2) / (lever * lever / bundle.bending).max(around)
}

/// Least lever that counts, as a part of the length.
const LEAST_LEVER: f64 = 1e-3;
