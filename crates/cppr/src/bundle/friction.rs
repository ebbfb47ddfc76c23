//! Equilibria of tubes that rub on each other: Coulomb's law with the contact force without clearance.
//!
//! The force p that tubes press on each other with ([`super::contact`]) and friction μ |p| depend on one another; p is found by a fixed point ([`super::limits`]) around the
//! equilibrium under friction that is given ([`super::rubbing`]).
//!
//! **Full slip.** Everywhere the tubes slip the way they would without friction, were the motors driven on from rest along their command a little (loading), or
//! back (unloading). In the plane and for two tubes any history of one motor lies between the two.
//!
//! **At the plate** a tube bends at once, which takes a couple C. A guide of length b holds it by two forces C/b, and their friction is 2 μ C/b.

use super::Bundle;
use super::contact::Cut;
use super::frame::Frame;
use super::history::remembered;
use super::limits::{Limits, Turns};
use super::newton::{Budget, newton};
use super::rubbing::{Columns, Law, Pair, Rubbing, Table};
use super::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort};
use super::steps::Steps;
use crate::solve::Drive;
use std::sync::Arc;

/// How tubes rub.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient μ, at least 0.
    pub coefficient: f64,
    /// Length of the guide below the plate over which a tube is held there (m); `None` leaves its friction out.
    pub guide: Option<f64>,
}

/// Which way tubes slip everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slip {
    /// As where motors are driven on from rest.
    Loading,
    /// As where they are driven back.
    Unloading,
}

/// An equilibrium with friction.
#[derive(Clone, Debug)]
pub struct Rubbed {
    /// Motors, with what rubs in the guide: one per tube.
    pub efforts: Vec<TubeEffort>,
    /// The equilibrium above the plate; its shape is asked of a solver of `bundle`.
    pub equilibrium: BundleEquilibrium,
    /// The bundle with its friction.
    pub bundle: Bundle,
    /// Solves of the fixed point.
    pub rounds: usize,
}

/// Sections at which contact is known for friction, at most per length, and how many of the lengths μ D they are apart at least: friction
/// enters the contact force by its slope, times such a length, and shorter waves would grow from one turn of the fixed point to the next.
const SECTIONS: f64 = 200.0;
const APART: f64 = 3.0;
/// Sections per length, at least.
const FEWEST: f64 = 25.0;
/// Part of the command by which the motors are driven on to see how tubes slip.
const ON: f64 = 1e-4;
/// Turns of the fixed point, and changes with which it ends: of the tip as a part of the length, of forces as a part of the greatest.
const ROUNDS: usize = 40;
const SETTLED: f64 = 1e-7;
const AGREED: f64 = 1e-6;
/// Newton steps of one solve, and the scaled step with which they end.
const ITERATIONS: usize = 40;
const NEWTON: f64 = 1e-7;

/// Rows of one pair, by span and the outer tube's label.
pub(super) fn rows<const C: usize>(
    cuts: &[Cut],
    [outer, inner]: [usize; 2],
    of: impl Fn(&Cut, usize) -> [f64; C],
) -> Columns<C> {
    let place = |cut: &Cut| cut.tubes.windows(2).position(|pair| pair == [outer, inner]);
    let own = cuts.iter().filter_map(|cut| Some((cut, place(cut)?)));
    own.map(|(cut, place)| (cut.span, cut.sides[place].label, of(cut, place))).collect()
}

/// Neighbours anywhere along the robot.
pub(super) fn neighbours(cuts: &[Cut]) -> Vec<[usize; 2]> {
    let mut pairs: Vec<[usize; 2]> =
        cuts.iter().flat_map(|cut| cut.tubes.windows(2)).map(|pair| [pair[0], pair[1]]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The command as it arrives above the guide.
fn above(bundle: &Bundle, command: &BundleCommand, more: &[f64]) -> BundleCommand {
    let mut above = command.clone();
    for ((drive, tube), more) in above.drives.iter_mut().zip(&bundle.tubes).zip(more) {
        drive.translation = match (drive.translation, tube.shaft) {
            (Drive::Effort(force), _) => Drive::Effort(force - more),
            (Drive::Motion(travel), Some(shaft)) => Drive::Motion(travel - more / shaft.axial),
            (motion, None) => motion,
        };
    }
    above
}

pub(super) fn radius(bundle: &Bundle, inner: usize) -> f64 {
    bundle.tubes[inner].radius
}

impl BundleSolver<'_> {
    /// The equilibrium to which Newton's method leads from a neighbour; its stability is not judged.
    pub(crate) fn settle(
        &self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
    ) -> Option<BundleEquilibrium> {
        self.settle_with(command, start, start.between.coarsened(self.tolerance))
    }

    /// The same with the steps that the integration begins with.
    fn settle_with(
        &self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
        steps: Steps,
    ) -> Option<BundleEquilibrium> {
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let walk = frame.walk(self.tolerance);
        let begin = frame.scaled(&start.unknowns);
        let found = newton(&frame, &walk, begin, steps, Budget::far(ITERATIONS), NEWTON).ok()?;
        self.posed(&frame, command, found)
    }

    pub(super) fn spacing(&self, friction: &Friction) -> f64 {
        let [.., lever] = self.bundle.stiffness();
        let length = self.bundle.length();
        (APART * friction.coefficient * lever).clamp(length / SECTIONS, length / FEWEST)
    }

    /// Solves until friction and contact force agree: `rubbing` makes friction, and what every motor has to pull more, of what limits it, and `limits` is what it
    /// begins with; `spans` are those that stay, of the first solve where there are none.
    pub(super) fn agree(
        &self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
        friction: &Friction,
        mut limits: Limits,
        mut spans: Vec<usize>,
        rubbing: impl Fn(&Limits) -> (Rubbing, Vec<f64>),
    ) -> Option<(Rubbed, Vec<Cut>)> {
        let (spacing, length) = (self.spacing(friction), self.bundle.length());
        let mut turns = Turns::default();
        let mut last = start.clone();
        let mut before: Option<Vec<TubeEffort>> = None;
        for rounds in 1..=ROUNDS {
            let (own, more) = rubbing(&limits);
            let bundle = Bundle { rubbing: Some(Arc::new(own)), ..self.bundle.clone() };
            let solver = BundleSolver::new(&bundle).with_stretch(self.stretch).with_tolerance(self.tolerance);
            // Steps that stay make one turn of the fixed point a smooth function of the one before.
            let steps =
                if rounds == 1 { last.between.coarsened(self.tolerance) } else { last.between.clone() };
            let found = solver.settle_with(&above(&bundle, command, &more), &last, steps)?;
            let cuts = solver.cuts(&found, spacing, &mut spans)?;
            let efforts: Vec<TubeEffort> = found
                .efforts
                .iter()
                .zip(&more)
                .map(|(own, more)| TubeEffort { force: own.force + more, ..*own })
                .collect();
            let moved = (found.tip - last.tip).norm();
            let largest = efforts.iter().fold(0.0, |most: f64, own| most.max(own.force.abs()));
            let changed = before.as_ref().map_or(f64::INFINITY, |before| {
                efforts.iter().zip(before).fold(0.0, |most: f64, (a, b)| most.max((a.force - b.force).abs()))
            });
            let least = self.bundle.bending / length.powi(2);
            if moved <= SETTLED * length && changed <= AGREED * largest.max(least) {
                return Some((Rubbed { efforts, equilibrium: found, bundle, rounds }, cuts));
            }
            limits = turns.next(limits, Limits::new(self.bundle, friction, &cuts), length);
            (before, last) = (Some(efforts), found);
        }
        None
    }

    /// The equilibria with friction everywhere against the slip of motors that are driven on (loading), and of motors that are driven back (unloading), from an equilibrium without
    /// friction. Motors are driven along their way from rest, and where they all stand still, the loads grow. `None` where one is not found.
    #[must_use]
    pub fn full_slip(&self, equilibrium: &BundleEquilibrium, friction: &Friction) -> Option<[Rubbed; 2]> {
        let slipping = self.slipping(equilibrium, friction)?;
        let of = |slip| self.slipped(equilibrium, friction, &slipping, slip);
        Some([of(Slip::Loading)?, of(Slip::Unloading)?])
    }

    /// The same for one way alone.
    #[must_use]
    pub fn full_slip_of(
        &self,
        equilibrium: &BundleEquilibrium,
        friction: &Friction,
        slip: Slip,
    ) -> Option<Rubbed> {
        self.slipped(equilibrium, friction, &self.slipping(equilibrium, friction)?, slip)
    }

    /// How tubes slip where motors are driven on.
    fn slipping(&self, equilibrium: &BundleEquilibrium, friction: &Friction) -> Option<Slipping> {
        let spacing = self.spacing(friction);
        let mut spans = Vec::new();
        let cuts = self.cuts(equilibrium, spacing, &mut spans)?;
        let moved = self.settle(&driven_on(equilibrium.command()), equilibrium)?;
        let beyond = self.cuts(&moved, spacing, &mut spans)?;
        let of =
            |pair: [usize; 2]| (pair, slip_directions(&cuts, &beyond, pair, radius(self.bundle, pair[1])));
        let pairs = neighbours(&cuts).into_iter().map(of).collect();
        let travels = moved.efforts.iter().zip(&equilibrium.efforts).map(|(a, b)| a.label - b.label);
        Some(Slipping {
            pairs,
            ways: travels.map(way).collect(),
            limits: Limits::new(self.bundle, friction, &cuts),
            spans,
        })
    }

    fn slipped(
        &self,
        equilibrium: &BundleEquilibrium,
        friction: &Friction,
        slipping: &Slipping,
        slip: Slip,
    ) -> Option<Rubbed> {
        let Slipping { pairs, ways, limits, spans } = slipping;
        let sign = if slip == Slip::Loading { 1.0 } else { -1.0 };
        let ways: Vec<f64> = ways.iter().map(|way| way * sign).collect();
        let rubbing = |limits: &Limits| {
            let own = pairs.iter().map(|(pair, directions)| {
                let force = limits.along(*pair).iter().map(|&(span, label, [limit])| {
                    (span, label, directions.at(span, label).map(|way: f64| sign * limit * way))
                });
                let (law, [outer, inner]) = (Law::Given(Table::new(&force.collect::<Columns<2>>())), *pair);
                Pair { outer, inner, radius: radius(self.bundle, inner), law }
            });
            (Rubbing(own.collect()), limits.more(&ways))
        };
        let command = equilibrium.command();
        Some(self.agree(command, equilibrium, friction, limits.clone(), spans.clone(), rubbing)?.0)
    }
}

/// How tubes slip where motors are driven on from rest.
struct Slipping {
    /// Directions along and around of every pair.
    pairs: Vec<([usize; 2], Table<2>)>,
    /// Which way every tube slides in the guide.
    ways: Vec<f64>,
    /// Limits and spans without friction.
    limits: Limits,
    spans: Vec<usize>,
}

/// 1, −1, or 0 of what does not move.
pub(super) fn way(travel: f64) -> f64 {
    if travel.abs() > 0.0 { travel.signum() } else { 0.0 }
}

/// The command with its motors a little further on their way from rest; where they stand still, with loads that are a little greater.
fn driven_on(command: &BundleCommand) -> BundleCommand {
    let mut on = command.clone();
    let mut driven = false;
    for drive in on.drives.iter_mut().flat_map(|own| [&mut own.translation, &mut own.rotation]) {
        driven |= drive.value().abs() > 0.0;
        *drive = drive.with_value(drive.value() * (1.0 + ON));
    }
    if !driven {
        on.loads = on.loads.scaled(1.0 + ON);
    }
    on
}

/// Unit vectors along and around the tubes of the slip from one course of sections to another; where nothing slips, that of the section before.
fn slip_directions(from: &[Cut], to: &[Cut], pair: [usize; 2], radius: f64) -> Table<2> {
    let [outer, inner] = pair;
    let law = Law::History {
        limit: Table::default(),
        before: Table::new(&remembered(from, pair, |_, _| [0.0; 2])),
        stiffness: 1.0,
    };
    let own = Pair { outer, inner, radius, law };
    let slips = rows(to, pair, |cut, place| own.trial(cut.passed, &cut.sides[place], &cut.sides[place + 1]));
    let most = slips.iter().fold(0.0, |most: f64, (.., [a, b])| most.max(a.hypot(*b)));
    let mut last = [0.0; 2];
    let mut ways: Columns<2> = slips
        .into_iter()
        .map(|(span, label, [along, around])| {
            let size = along.hypot(around);
            if size > NOTHING * most {
                last = [along / size, around / size];
            }
            (span, label, last)
        })
        .collect();
    // Before the first slip the direction is that of the first.
    let first = ways.iter().map(|row| row.2).find(|way| way[0].hypot(way[1]) > 0.0).unwrap_or_default();
    for row in ways.iter_mut().take_while(|row| row.2[0].hypot(row.2[1]) <= 0.0) {
        row.2 = first;
    }
    Table::new(&ways)
}

/// Slip below this part of the greatest has no direction.
const NOTHING: f64 = 1e-6;
