//! Inverse problems: actuator values for a wanted tip or shape, and the force on the tip from what it does to the robot.
//!
//! All three are least squares over exact equilibria and their exact Jacobians (`sensitivity`), solved by the
//! Levenberg–Marquardt method with bounds (`least_squares`). Wherever an answer depends on measurements or on
//! the actuators' accuracy, its uncertainty is propagated through the same Jacobian, and combinations that it does not
//! determine are named.

mod least_squares;
mod reach;
mod sense;
mod shape_match;
mod uncertainty;

pub use reach::{Accuracy, Conditioning, Reach, Target, TipAxis};
pub(super) use reach::{reach, reach_near};
pub(super) use sense::sense;
pub use sense::{Measured, Sensed};
pub(super) use shape_match::shape_match;
pub use shape_match::{ShapeMatch, ShapePoint};
pub use uncertainty::{Principal, Uncertainty};

use super::model::Model;
use super::{Bound, SafeRange};
use crate::design::{FieldValues, Robot};
use crate::solve::{CommandProblem, Equilibrium, Freedom, Input};
use nalgebra::DVector;
use std::fmt;

/// An input that may be chosen, between bounds (m, rad, N or N m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeInput {
    /// Which.
    pub input: Input,
    /// Least and greatest value.
    pub bounds: [f64; 2],
}

/// Why an inverse problem has no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum InverseProblem {
    /// The command cannot be asked of the robot.
    Command(CommandProblem),
    /// Nothing may be chosen.
    NothingFree,
    /// The bounds of a tube's input are no interval.
    Bounds(Input),
    /// Nothing is wanted, or nothing was measured.
    NothingGiven,
    /// Fewer measured numbers than unknowns: both.
    TooFew(usize, usize),
    /// A measured number or its deviation is not finite or not positive.
    NotFinite(&'static str),
    /// A point lies off the robot's labels (m).
    Label(f64),
    /// A point lies where the robot cannot be.
    Beyond {
        /// Which, from 1.
        point: usize,
        /// How far from the baseplate's centre (m).
        distance: f64,
        /// The robot's length (m).
        length: f64,
    },
    /// All points lie at the baseplate.
    AllAtPlate {
        /// How far the farthest is from its centre (m).
        distance: f64,
        /// The robot's length (m).
        length: f64,
    },
    /// An effort is measured of an input whose effort is prescribed.
    EffortPrescribed(usize),
    /// No stable equilibrium was found under any value that was tried.
    NoEquilibrium,
    /// [`Solver::stop_by`](crate::solve::Solver::stop_by).
    Stopped,
}

impl fmt::Display for InverseProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(problem) => problem.fmt(f),
            Self::NothingFree => write!(f, "every actuator is given; leave at least one free"),
            Self::Bounds(input) => {
                let what = if input.freedom == Freedom::PushPull { "translation" } else { "rotation" };
                write!(
                    f,
                    "the bounds of the {what} of tube {} are no interval from least to greatest",
                    input.tube
                )
            }
            Self::NothingGiven => write!(f, "nothing is given to start from: no target, no measurement"),
            Self::TooFew(numbers, unknowns) => {
                write!(f, "{numbers} measured numbers cannot determine {unknowns} unknowns; measure more")
            }
            Self::NotFinite(what) => {
                write!(f, "{what} is not a finite number, or its deviation is not positive")
            }
            Self::Label(x) => write!(f, "a point at {:.3} mm lies off the robot", x * 1e3),
            Self::Beyond { point, distance, length } => write!(
                f,
                "point {point} lies {:.3} mm from the baseplate, out of reach of a robot {:.3} mm long. Check the unit and the \
                 frame",
                distance * 1e3,
                length * 1e3
            ),
            Self::AllAtPlate { distance, length } => write!(
                f,
                "all points lie within {:.3} mm of the baseplate's centre, but the robot is {:.3} mm long. Check the unit",
                distance * 1e3,
                length * 1e3
            ),
            Self::EffortPrescribed(tube) => {
                write!(
                    f,
                    "the effort of tube {tube} is prescribed; only efforts of prescribed motions are measured"
                )
            }
            Self::NoEquilibrium => write!(f, "no stable equilibrium was found between the bounds"),
            Self::Stopped => write!(f, "stopped before an answer was found"),
        }
    }
}

impl std::error::Error for InverseProblem {}

/// Bend and turn (rad) up to which an actuator without limits is searched.
const HALF_TURN: f64 = std::f64::consts::PI;

/// Inputs between the ends of their safe ranges; where nothing was met, up to half a turn of bend or rotation.
#[must_use]
pub fn free_within(robot: &Robot, ranges: &[SafeRange]) -> Vec<FreeInput> {
    let middle = 0.5 * robot.length();
    let offset = |tube: usize| robot.fields().get(tube).map_or(0.0, |f| f.values(middle).centroid_offset);
    ranges
        .iter()
        .map(|range| {
            let natural = match (range.input.freedom, range.input.is_motion) {
                (Freedom::PushPull, true) => HALF_TURN * (offset(0) + offset(range.input.tube - 1)),
                (Freedom::Rotation, true) => HALF_TURN,
                _ => f64::INFINITY,
            };
            let cut = |end: &super::RangeEnd| match end.bound {
                Bound::Open => end.value.clamp(range.start.min(-natural), range.start.max(natural)),
                _ => end.value,
            };
            FreeInput { input: range.input, bounds: [cut(&range.low), cut(&range.high)] }
        })
        .collect()
}

/// All inputs of an equilibrium's command about their present values, for a search that stays near: half a turn of bend or rotation to
/// either side for motions, what would bend or twist the robot that far for efforts. Planar settings have no rotations.
#[must_use]
pub fn free_near(start: &Equilibrium) -> Vec<FreeInput> {
    let robot = start.robot();
    let middle: Vec<_> =
        (0..robot.tube_count()).map(|tube| robot.fields_at(tube, 0.5 * robot.length())).collect();
    let sum = |value: fn(&FieldValues) -> f64| middle.iter().map(value).sum::<f64>();
    let inputs = start.command.inputs();
    inputs
        .filter(|(input, _)| input.freedom == Freedom::PushPull || start.settings.resolution.angle > 0)
        .map(|(input, at)| {
            let lever = middle[0].centroid_offset + middle[input.tube - 1].centroid_offset;
            let reach = HALF_TURN
                * match (input.freedom, input.is_motion) {
                    (Freedom::PushPull, true) => lever,
                    (Freedom::Rotation, true) => 1.0,
                    (Freedom::PushPull, false) => sum(|f| f.bending_z) / (robot.length() * lever),
                    (Freedom::Rotation, false) => sum(|f| f.torsion) / robot.length(),
                };
            FreeInput { input, bounds: [at - reach, at + reach] }
        })
        .filter(|free| free.bounds[0] < free.bounds[1] && free.bounds[1].is_finite())
        .collect()
}

/// How far from the baseplate's centre the section at label X can be seen (m). The centreline is some per cent longer or shorter
/// than its label where the leader bends, and frames are known to so much; beyond, the unit is mistaken.
#[must_use]
pub fn farthest(label: f64, length: f64) -> f64 {
    label + 0.25 * length
}

/// Checks what every inverse problem with free inputs needs.
fn check<M: Model>(command: &M::Command, free: &[FreeInput]) -> Result<(), InverseProblem> {
    if free.is_empty() {
        return Err(InverseProblem::NothingFree);
    }
    for own in free {
        let [low, high] = own.bounds;
        let known = M::value(command, own.input).is_some();
        if !(known && low.is_finite() && high.is_finite() && low < high) {
            return Err(InverseProblem::Bounds(own.input));
        }
    }
    Ok(())
}

/// Columns of a Jacobian over all inputs that belong to the free ones.
fn columns(inputs: &[Input], free: &[FreeInput]) -> Vec<usize> {
    let place = |own: &FreeInput| inputs.iter().position(|input| input.is_same_freedom(own.input));
    free.iter().filter_map(place).collect()
}

/// What a search works on.
struct Search<'a, M: Model> {
    model: &'a mut M,
    command: &'a M::Command,
    free: &'a [FreeInput],
}

impl<M: Model> Search<'_, M> {
    /// The stable equilibrium at some values: near another one, or from rest.
    fn at(&mut self, values: &DVector<f64>, near: Option<&M::Found>) -> Option<M::Found> {
        let command = self.commanded(values)?;
        self.model.stable(&command, near)
    }

    /// The command with some values of the free inputs; `None` where somebody asked to stop.
    fn commanded(&self, values: &DVector<f64>) -> Option<M::Command> {
        let inputs = self.free.iter().zip(values.iter());
        let command = inputs.fold(self.command.clone(), |c, (f, &value)| M::with_input(&c, f.input, value));
        (!self.model.is_stopped()).then_some(command)
    }

    /// A stopped search has no answer, whatever it has found.
    fn unless_stopped<T>(&self, best: Option<T>) -> Result<T, InverseProblem> {
        if self.model.is_stopped() {
            return Err(InverseProblem::Stopped);
        }
        best.ok_or(InverseProblem::NoEquilibrium)
    }

    /// Half widths of the bounds: units in which all inputs count alike.
    fn units(&self) -> Vec<f64> {
        self.free.iter().map(|f| 0.5 * (f.bounds[1] - f.bounds[0])).collect()
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.free.iter().map(|f| f.bounds).collect()
    }

    /// The `best` of many places between the bounds by a cost, each with its equilibrium, the best first: the command's own values,
    /// then an additive quasi-random sequence (Roberts 2018), which fills any number of dimensions evenly.
    fn scout(
        &mut self,
        best: usize,
        mut cost: impl FnMut(&mut Self, &M::Found) -> f64,
    ) -> Vec<(f64, DVector<f64>, M::Found)> {
        let mut list: Vec<(f64, DVector<f64>, M::Found)> = Vec::new();
        let dimensions = self.free.len();
        let ratio = plastic_number(dimensions);
        for n in 0..SCOUTS * dimensions {
            let values = DVector::from_iterator(
                dimensions,
                self.free.iter().enumerate().map(|(i, own)| {
                    let [low, high] = own.bounds;
                    if n == 0 {
                        return M::value(self.command, own.input).unwrap_or_default().clamp(low, high);
                    }
                    let power = i32::try_from(i).unwrap_or(i32::MAX).saturating_add(1);
                    let share = (0.5 + n as f64 * ratio.powi(-power)).fract();
                    low + share * (high - low)
                }),
            );
            let found = self.commanded(&values).and_then(|command| self.model.scouted(&command));
            let Some(found) = found else { continue };
            let value = cost(self, &found);
            if value.is_finite() {
                list.push((value, values, found));
                list.sort_by(|a, b| a.0.total_cmp(&b.0));
                list.truncate(best);
            }
        }
        list
    }
}

/// Places scouted per free input.
const SCOUTS: usize = 64;
/// Best places from which a search starts.
const STARTS: usize = 8;

/// The positive root of x^(d+1) = x + 1.
fn plastic_number(dimensions: usize) -> f64 {
    let power = 1.0 / (dimensions as f64 + 1.0);
    (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(power))
}
