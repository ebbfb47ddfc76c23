//! Limits, ranges and inverse problems of a bundle, by the same methods as those of the modal solver.

use super::inverse;
use super::inverse::{
    Accuracy, FreeInput, InverseProblem, Measured, Reach, Sensed, ShapeMatch, ShapePoint, Target,
};
use super::limits::{Governing, SectionLimit, Teeth, governing, part_limits};
use super::model::Model;
use super::range::{Bound, RangeEnd, RangeProblem, SafeRange, safe_part, safe_ranges};
use super::sensitivity::Sensitivity;
use crate::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort};
use crate::bundle::{BundleDesign, Friction, Rubbed};
use crate::design::TubeDesign;
use crate::design::fibre::TubeFibres;
use crate::kinematics::TipPose;
use crate::solve::{Drive, Freedom, Input, Status};
use crate::statics::Wrench;
use nalgebra::{DMatrix, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bundle with what it is made of.
#[derive(Debug)]
pub struct BundleAnalysis<'a> {
    /// Its solver.
    pub solver: BundleSolver<'a>,
    design: &'a BundleDesign,
    /// Of the notched parts of every tube: the label at which it begins (m), how many notches there are before it, its sections.
    parts: Vec<Vec<(f64, i32, Option<TubeFibres>)>>,
    stop: Option<Arc<AtomicBool>>,
}

/// Sections at which fields are read, per length.
const SECTIONS: f64 = 400.0;
/// Part of its length from the ends of a part up to which its fields are read.
const ASIDE: f64 = 1e-6;
/// Parts of an input's extent by which slopes of places are taken.
const SMALL: f64 = 1e-5;
/// Turns in which a wrench and what friction adds under it agree at most, and the change of a measurement, in its standard deviations, with which they do.
const RUBBED: usize = 15;
const SAME: f64 = 1e-3;

impl<'a> BundleAnalysis<'a> {
    /// Of the bundle that a solver has and a design describes.
    #[must_use]
    pub fn new(solver: BundleSolver<'a>, design: &'a BundleDesign) -> Self {
        let parts = design.tubes.iter().map(|tube| {
            let (mut from, mut notches) = (0.0, 0);
            let own = tube.parts.iter().map(|part| {
                let fibres = match &part.body {
                    TubeDesign::Notched(notched) => Some(TubeFibres::of(notched, part.length)),
                    TubeDesign::Stiffness(_) => None,
                };
                let count = fibres.as_ref().map_or(0, |fibres| fibres.notches.len());
                let own = (from, notches, fibres);
                from += part.length;
                notches += i32::try_from(count).unwrap_or(i32::MAX);
                own
            });
            own.collect()
        });
        Self { solver, design, parts: parts.collect(), stop: None }
    }

    /// Ranges and searches end where this is set, as [`Solver::stop_by`](crate::solve::Solver::stop_by) has it.
    pub fn stop_by(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.stop = flag;
    }

    /// What the bundle is made of.
    #[must_use]
    pub fn design(&self) -> &'a BundleDesign {
        self.design
    }

    /// Motors that a search may choose: all of them, or where tubes are joined all but those of the outermost, which advance the whole robot.
    #[must_use]
    pub fn choosable(&self, command: &BundleCommand) -> Vec<Input> {
        let joined = !self.design.joints.is_empty();
        command.inputs().into_iter().filter(|input| input.tube > 1 || !joined).collect()
    }

    /// Motors about their values in a command, for a search that stays near: half a turn of bend or rotation to either side, or
    /// what would bend or twist the robot so far.
    #[must_use]
    pub fn free_near(&self, command: &BundleCommand) -> Vec<FreeInput> {
        let (length, [bending, torsion, lever]) = (self.length(), self.stiffness());
        let about = |input: Input| {
            let reach = PI
                * match (input.freedom, input.is_motion) {
                    // Tubes without lever slide in each other.
                    (Freedom::PushPull, true) => {
                        if lever > 0.0 {
                            2.0 * lever
                        } else {
                            length / PI
                        }
                    }
                    (Freedom::Rotation, true) => 1.0,
                    (Freedom::PushPull, false) => bending / (length * lever.max(f64::MIN_POSITIVE)),
                    (Freedom::Rotation, false) => torsion / length,
                };
            let at = Self::value(command, input)?;
            (at + reach).is_finite().then_some(FreeInput { input, bounds: [at - reach, at + reach] })
        };
        self.choosable(command).into_iter().filter_map(about).collect()
    }

    /// Does any part have fibres, whose strain and closure limits judge? Parts given by their stiffness have none.
    fn is_judged(&self) -> bool {
        self.parts.iter().flatten().any(|(.., fibres)| fibres.is_some())
    }

    /// [Motors that may be chosen](Self::choosable) for a search about a command: between the ends of their safe ranges, or where nothing of the bundle is judged within what
    /// [`Self::free_near`] gives.
    ///
    /// # Errors
    /// Where the command itself is not safe.
    pub fn free(&mut self, command: &BundleCommand) -> Result<Vec<FreeInput>, RangeProblem> {
        if !self.is_judged() {
            return Ok(self.free_near(command));
        }
        let start = self.start(command)?;
        let ranges = safe_ranges(self, command, start, &self.choosable(command), Teeth::Rigid)?;
        Ok(self.free_within(&ranges))
    }

    /// Motors between the ends of their safe ranges; where nothing was met, up to half a turn of bend or rotation.
    fn free_within(&self, ranges: &[SafeRange]) -> Vec<FreeInput> {
        let [.., lever] = self.stiffness();
        let free = |range: &SafeRange| {
            let natural = match (range.input.freedom, range.input.is_motion) {
                (Freedom::PushPull, true) if lever > 0.0 => 2.0 * PI * lever,
                (Freedom::Rotation, true) => PI,
                _ => f64::INFINITY,
            };
            let cut = |end: &RangeEnd| match end.bound {
                Bound::Open => end.value.clamp(range.start.min(-natural), range.start.max(natural)),
                _ => end.value,
            };
            FreeInput { input: range.input, bounds: [cut(&range.low), cut(&range.high)] }
        };
        ranges.iter().map(free).filter(|free| free.bounds[0] < free.bounds[1]).collect()
    }

    /// State of every notch that stands before the plate, tube by tube; sections of uncut parts likewise. Parts given by their stiffness have
    /// no fibres and are left out, and so is what comes up from below the plate but for the first part.
    #[must_use]
    pub fn section_limits(&self, found: &BundleEquilibrium, teeth: Teeth) -> Vec<SectionLimit> {
        if !(found.converged && self.is_judged()) {
            return Vec::new();
        }
        let shape = self.solver.shape(found, self.solver.bundle().length() / SECTIONS);
        let mut limits = Vec::new();
        for (tube, (design, parts)) in self.design.tubes.iter().zip(&self.parts).enumerate() {
            // Label, facing label of the leader, κ_Y, κ_Z, stretch, twist.
            let mut rows: Vec<[f64; 6]> = Vec::new();
            for section in &shape {
                let Some(own) = section.tubes.iter().find(|own| own.tube == tube) else { continue };
                let leader = section.tubes.iter().find(|own| own.tube == 0);
                let [y, z, twist] = own.strains;
                rows.push([own.label, leader.map_or(section.length, |l| l.label), y, z, own.stretch, twist]);
            }
            let Some(&[plate, ..]) = rows.first() else { continue };
            let at = |label: f64| {
                let [_, facing, values @ ..] = interpolated(&rows, label);
                (facing, values)
            };
            for (number, (part, (from, notches, fibres))) in design.parts.iter().zip(parts).enumerate() {
                let (TubeDesign::Notched(notched), Some(fibres)) = (&part.body, fibres) else { continue };
                let first = design.parts[..number].iter().all(|before| before.length <= 0.0);
                let base = if first { plate - from } else { (plate - from).max(0.0) };
                if part.length <= 0.0 || base >= part.length {
                    continue;
                }
                let place = [*from, base, part.length];
                // Fields jump at the ends of a part: its own side counts.
                let side = ASIDE * part.length;
                let inside = |label: f64| at(label.clamp(from + side, from + part.length - side));
                limits.extend(part_limits(tube + 1, notched, fibres, place, *notches, teeth, inside));
            }
        }
        limits
    }

    /// Safe ranges of all motors about a command.
    ///
    /// # Errors
    /// Where the command itself is not safe.
    pub fn safe_ranges(
        &mut self,
        command: &BundleCommand,
        teeth: Teeth,
    ) -> Result<Vec<SafeRange>, RangeProblem> {
        let start = self.start(command)?;
        safe_ranges(self, command, start, &command.inputs(), teeth)
    }

    /// The safe range of one motor.
    ///
    /// # Errors
    /// As [`Self::safe_ranges`].
    pub fn safe_range(
        &mut self,
        command: &BundleCommand,
        input: Input,
        teeth: Teeth,
    ) -> Result<SafeRange, RangeProblem> {
        let start = self.start(command)?;
        Ok(safe_ranges(self, command, start, &[input], teeth)?.swap_remove(0))
    }

    /// How much of a command the robot can follow from rest with all limits kept, a part in [0, 1].
    ///
    /// # Errors
    /// Where rest itself is not found.
    pub fn safe_part(&mut self, command: &BundleCommand, teeth: Teeth) -> Result<RangeEnd, RangeProblem> {
        let held = self.solver.held();
        let rest = self.start(&command.between(&held, 0.0))?;
        safe_part(self, rest, teeth, &|part| command.between(&held, part))
    }

    fn start(&mut self, command: &BundleCommand) -> Result<BundleEquilibrium, RangeProblem> {
        let found = self.solver.solve(command);
        match found.status() {
            Status::Converged => Ok(found),
            other => Err(RangeProblem::NoEquilibrium(other)),
        }
    }

    /// Values of the free inputs for a wanted tip.
    ///
    /// # Errors
    /// Where nothing can be searched for.
    pub fn reach(
        &mut self,
        command: &BundleCommand,
        free: &[FreeInput],
        target: &Target,
        accuracy: &Accuracy,
    ) -> Result<Reach<BundleEquilibrium>, InverseProblem> {
        inverse::reach(self, command, free, target, accuracy)
    }

    /// The same sought from an equilibrium on, whose command holds: on its branch, and nowhere else.
    ///
    /// # Errors
    /// Where nothing can be searched for.
    pub fn reach_near(
        &mut self,
        start: &BundleEquilibrium,
        free: &[FreeInput],
        target: &Target,
        accuracy: &Accuracy,
    ) -> Result<Reach<BundleEquilibrium>, InverseProblem> {
        inverse::reach_near(self, start.command(), start, free, target, accuracy)
    }

    /// The force, or wrench, on the tip that explains measurements best.
    ///
    /// # Errors
    /// Where the measurements cannot be used, or no stable equilibrium explains them.
    pub fn sense(
        &mut self,
        command: &BundleCommand,
        measured: &[Measured],
        with_moment: bool,
    ) -> Result<Sensed<BundleEquilibrium>, InverseProblem> {
        let start = self.stable(command, None);
        inverse::sense(self, command, start, measured, with_moment)
    }

    /// What [`Self::sense`] found, `free`, where tubes rub and slip everywhere: for measurements while the motors were driven on (loading), and while they were driven back. `None` where
    /// no such equilibrium agrees with the measurements.
    ///
    /// What friction adds to efforts and tip in the equilibrium found is taken off the measurements, which are then fitted again, until that changes
    /// no more.
    ///
    /// # Errors
    /// As [`Self::sense`].
    pub fn sense_rubbed(
        &mut self,
        free: &Sensed<BundleEquilibrium>,
        command: &BundleCommand,
        measured: &[Measured],
        with_moment: bool,
        friction: &Friction,
    ) -> Result<[Option<Sensed<BundleEquilibrium>>; 2], InverseProblem> {
        let start = self.stable(command, None);
        let mut sides = [None, None];
        for (side, answer) in sides.iter_mut().enumerate() {
            let mut found = free.clone();
            let mut before = measured.to_vec();
            let agreed = (0..RUBBED).find_map(|_| {
                let Some(rubbed) = self.solver.full_slip(&found.equilibrium, friction) else {
                    return Some(Ok(None));
                };
                let clean: Vec<Measured> =
                    measured.iter().map(|one| without(one, &found.equilibrium, &rubbed[side])).collect();
                let moved = clean.iter().zip(&before).fold(0.0, |most: f64, (a, b)| most.max(apart(a, b)));
                if moved < SAME {
                    return Some(Ok(Some(found.clone())));
                }
                before = clean;
                match inverse::sense(self, command, start.clone(), &before, with_moment) {
                    Ok(own) => found = own,
                    Err(problem) => return Some(Err(problem)),
                }
                None
            });
            *answer = agreed.transpose()?.flatten();
        }
        Ok(sides)
    }

    /// The same from an equilibrium without the wrench that is looked for, whose command holds.
    ///
    /// # Errors
    /// As [`Self::sense`].
    pub fn sense_near(
        &mut self,
        start: &BundleEquilibrium,
        measured: &[Measured],
        with_moment: bool,
    ) -> Result<Sensed<BundleEquilibrium>, InverseProblem> {
        inverse::sense(self, start.command(), Some(start.clone()), measured, with_moment)
    }

    /// Values of the free inputs for which the centreline is nearest to points; a point's label is the length of the centreline up to it.
    ///
    /// # Errors
    /// Where nothing can be searched for.
    pub fn shape_match(
        &mut self,
        command: &BundleCommand,
        free: &[FreeInput],
        points: &[ShapePoint],
    ) -> Result<ShapeMatch<BundleEquilibrium>, InverseProblem> {
        inverse::shape_match(self, command, free, points)
    }
}

/// A measurement without what friction adds to it.
fn without(measured: &Measured, free: &BundleEquilibrium, rubbed: &Rubbed) -> Measured {
    match *measured {
        Measured::Effort(tube, freedom, value, deviation) => {
            let own = |efforts: &[TubeEffort]| {
                efforts.get(tube.wrapping_sub(1)).map_or(0.0, |own| match freedom {
                    Freedom::PushPull => own.force,
                    Freedom::Rotation => own.torque,
                })
            };
            Measured::Effort(tube, freedom, value - own(&rubbed.efforts) + own(&free.efforts), deviation)
        }
        Measured::Position(value, deviation) => {
            Measured::Position(value - rubbed.equilibrium.tip + free.tip, deviation)
        }
        Measured::Direction(value, deviation) => {
            let turned = rubbed.equilibrium.frame.column(0) - free.frame.column(0);
            Measured::Direction((value.normalize() - turned).normalize(), deviation)
        }
    }
}

/// How far two values of one measurement are apart, in its standard deviations.
fn apart(one: &Measured, other: &Measured) -> f64 {
    match (one, other) {
        (Measured::Effort(.., a, deviation), Measured::Effort(.., b, _)) => (a - b).abs() / deviation,
        (Measured::Position(a, deviation), Measured::Position(b, _))
        | (Measured::Direction(a, deviation), Measured::Direction(b, _)) => (a - b).norm() / deviation,
        _ => f64::INFINITY,
    }
}

/// A row at a label between those that are known: they grow, and where two are alike the fields jump.
fn interpolated(rows: &[[f64; 6]], label: f64) -> [f64; 6] {
    let next = rows.partition_point(|row| row[0] < label).clamp(1, rows.len().max(2) - 1);
    let (Some(a), Some(b)) = (rows.get(next - 1), rows.get(next)) else { return rows[0] };
    let way = b[0] - a[0];
    let share = if way > 0.0 { ((label - a[0]) / way).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

fn drive(command: &BundleCommand, input: Input) -> Option<Drive> {
    let own = command.drives.get(input.tube.checked_sub(1)?)?;
    Some(match input.freedom {
        Freedom::PushPull => own.translation,
        Freedom::Rotation => own.rotation,
    })
}

impl Model for BundleAnalysis<'_> {
    type Command = BundleCommand;
    type Found = BundleEquilibrium;

    fn length(&self) -> f64 {
        self.solver.bundle().length()
    }

    fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    fn stiffness(&self) -> [f64; 3] {
        self.solver.bundle().stiffness()
    }

    fn value(command: &BundleCommand, input: Input) -> Option<f64> {
        drive(command, input).map(Drive::value)
    }

    fn is_motion(command: &BundleCommand, input: Input) -> bool {
        drive(command, input).is_some_and(Drive::is_motion)
    }

    fn with_input(command: &BundleCommand, input: Input, value: f64) -> BundleCommand {
        command.with_input(input, value)
    }

    fn with_wrench(command: &BundleCommand, wrench: Wrench) -> BundleCommand {
        let mut loaded = command.clone();
        loaded.loads.wrenches.push(wrench);
        loaded
    }

    fn is_stable(found: &BundleEquilibrium) -> bool {
        found.converged && found.stable
    }

    fn stable(
        &mut self,
        command: &BundleCommand,
        near: Option<&BundleEquilibrium>,
    ) -> Option<BundleEquilibrium> {
        if self.solver.bundle().joint_behind_plate(&command.drives).is_some() {
            return None;
        }
        let found = match near {
            Some(start) => self.solver.solve_from(command, start),
            None => self.solver.solve(command),
        };
        Self::is_stable(&found).then_some(found)
    }

    fn scouted(&mut self, command: &BundleCommand) -> Option<BundleEquilibrium> {
        let rest = self.solver.rest().cloned()?;
        self.continued(command, &rest)
    }

    fn continued(&mut self, command: &BundleCommand, from: &BundleEquilibrium) -> Option<BundleEquilibrium> {
        if self.solver.bundle().joint_behind_plate(&command.drives).is_some() {
            return None;
        }
        self.solver.continued(command, from).filter(Self::is_stable)
    }

    fn tip(&mut self, found: &BundleEquilibrium) -> TipPose {
        TipPose { rotation: found.frame, centre: found.tip }
    }

    fn slopes(&mut self, found: &BundleEquilibrium) -> Option<Sensitivity> {
        self.solver.sensitivity(found)
    }

    fn places(&mut self, found: &BundleEquilibrium, labels: &[f64]) -> Vec<[Vector3<f64>; 2]> {
        let shape = self.solver.shape(found, self.length() / SECTIONS);
        let place = |label: f64| {
            let next = shape.partition_point(|s| s.length < label).clamp(1, shape.len().max(2) - 1);
            let (Some(a), Some(b)) = (shape.get(next - 1), shape.get(next)) else {
                return [found.tip, found.frame.column(0).into()];
            };
            let way = b.length - a.length;
            a.towards(b, if way > 0.0 { ((label - a.length) / way).clamp(0.0, 1.0) } else { 0.0 })
        };
        labels.iter().map(|label| place(*label)).collect()
    }

    fn place_slopes(
        &mut self,
        found: &BundleEquilibrium,
        labels: &[f64],
        inputs: &[Input],
    ) -> Option<DMatrix<f64>> {
        let command = found.command().clone();
        let mut slopes = DMatrix::zeros(3 * labels.len(), inputs.len());
        for (column, &input) in inputs.iter().enumerate() {
            let (value, step) = (Self::value(&command, input)?, SMALL * self.extent(input));
            for side in [1.0, -1.0] {
                let moved = self.continued(&command.with_input(input, value + side * step), found)?;
                for (row, [centre, _]) in self.places(&moved, labels).iter().enumerate() {
                    for axis in 0..3 {
                        slopes[(3 * row + axis, column)] += 0.5 * side * centre[axis] / step;
                    }
                }
            }
        }
        Some(slopes)
    }

    fn actual(found: &BundleEquilibrium, input: Input) -> Option<f64> {
        let own = found.efforts.get(input.tube.checked_sub(1)?)?;
        Some(match (input.freedom, input.is_motion) {
            (Freedom::PushPull, true) => own.label,
            (Freedom::PushPull, false) => own.force,
            (Freedom::Rotation, true) => own.rotation,
            (Freedom::Rotation, false) => own.torque,
        })
    }

    fn nearest_limit(&mut self, found: &BundleEquilibrium, teeth: Teeth) -> Option<Governing> {
        governing(&self.section_limits(found, teeth), None)
    }
}
