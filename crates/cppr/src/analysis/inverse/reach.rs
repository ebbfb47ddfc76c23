//! Actuator values that bring the tip to a position, a direction, or both.
//!
//! Residuals: (p − p*)/L, and w (t − t*) with the tip's tangent t; with both wanted, an angle of 1 rad counts like a distance of
//! w L. Many places between the bounds are scouted, and the search starts at the best of them. Where no start arrives, the
//! nearest pose found is the answer.

use super::least_squares::{Evaluated, minimise};
use super::{FreeInput, InverseProblem, STARTS, Search, check, columns};
use crate::analysis::model::Model;
use crate::analysis::sensitivity::Sensitivity;
use crate::kinematics::TipPose;
use crate::solve::{Command, Equilibrium, Solver};
use nalgebra::{DMatrix, DVector, Vector3};

/// What is wanted of the tip, in the base frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Centre of the tip section (m).
    pub position: Option<Vector3<f64>>,
    /// Tangent of the tip; its length does not matter.
    pub direction: Option<Vector3<f64>>,
}

/// Standard deviations of the actuators' positions and efforts about their set values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Of translations (m).
    pub translation: f64,
    /// Of rotations (rad).
    pub rotation: f64,
    /// Of forces (N).
    pub force: f64,
    /// Of torques (N m).
    pub torque: f64,
}

impl Default for Accuracy {
    /// 0.1 mm, 1°, 0.05 N, 1 N mm: simple stages and load cells.
    fn default() -> Self {
        Self { translation: 1e-4, rotation: 1.0_f64.to_radians(), force: 0.05, torque: 1e-3 }
    }
}

impl Accuracy {
    /// Deviation of one input.
    fn of(&self, free: &FreeInput) -> f64 {
        use crate::solve::Freedom::{PushPull, Rotation};
        match (free.input.freedom, free.input.is_motion) {
            (PushPull, true) => self.translation,
            (PushPull, false) => self.force,
            (Rotation, true) => self.rotation,
            (Rotation, false) => self.torque,
        }
    }
}

/// A principal axis of the tip's position under small motions of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct TipAxis {
    /// Unit vector, base frame.
    pub direction: Vector3<f64>,
    /// Standard deviation of the tip along it if every input deviates by its accuracy (m).
    pub deviation: f64,
    /// Change of each input that moves the tip by 1 m along it alone (input unit per m), the least that does; empty where no input does.
    pub inputs: Vec<f64>,
}

/// What the inputs do to the tip at a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditioning {
    /// Three axes, the best movable first.
    pub axes: Vec<TipAxis>,
    /// Greatest over least deviation of the axes that move at all.
    pub condition: f64,
    /// √det(J Jᵀ) with inputs in units of their accuracy (m³): the volume of the tip's uncertainty, 0 where a direction cannot be reached.
    pub manipulability: f64,
    /// Combinations of the inputs (unit vectors in units of their accuracy) that leave the tip's position where it is.
    pub idle: Vec<Vec<f64>>,
}

/// Answer to a target.
#[derive(Clone, Debug)]
pub struct Reach<E = Equilibrium> {
    /// Did the tip get there?
    pub reached: bool,
    /// Value of each free input (m, rad, N or N m).
    pub values: Vec<f64>,
    /// Is the value at its lower or upper bound?
    pub at_bound: Vec<bool>,
    /// The equilibrium, with the whole command.
    pub equilibrium: E,
    /// Tip position (m).
    pub position: Vector3<f64>,
    /// Tip tangent.
    pub direction: Vector3<f64>,
    /// Distance from the wanted position (m).
    pub distance: Option<f64>,
    /// Angle from the wanted direction (rad).
    pub angle: Option<f64>,
    /// True where the same command, applied from rest, leads to another pose: come from the pose given.
    pub depends_on_path: bool,
    /// What the inputs do to the tip there; `None` where the tangent is singular.
    pub conditioning: Option<Conditioning>,
}

/// Part of the length that an angle of 1 rad counts for.
const ANGLE: f64 = 0.1;
/// A target is reached within this part of the length, and within this angle (rad).
const ARRIVED: f64 = 1e-6;
/// Singular values below this part of the largest move nothing.
const IDLE: f64 = 1e-7;

impl Solver {
    /// Values of the free inputs for a target; all other inputs and the loads are those of `command`.
    ///
    /// # Errors
    /// Where nothing can be searched for. That the target is out of reach is no error: see [`Reach::reached`].
    pub fn reach(
        &mut self,
        command: &Command,
        free: &[FreeInput],
        target: &Target,
        accuracy: &Accuracy,
    ) -> Result<Reach, InverseProblem> {
        self.check(command).map_err(InverseProblem::Command)?;
        reach(self, command, free, target, accuracy)
    }

    /// Actuator values for a wanted tip, sought from one equilibrium, whose robot, command and settings hold: the search stays on its branch and looks nowhere else. Where
    /// the target is near, this takes some five steps instead of some hundred; where it is not, the answer may be a pose that is the nearest
    /// only among its neighbours.
    ///
    /// # Errors
    /// As [`Solver::reach`].
    pub fn reach_near(
        &mut self,
        start: &Equilibrium,
        free: &[FreeInput],
        target: &Target,
        accuracy: &Accuracy,
    ) -> Result<Reach, InverseProblem> {
        (self.robot, self.settings) = (start.robot().clone(), *start.settings());
        let command = start.command();
        self.check(command).map_err(InverseProblem::Command)?;
        reach_near(self, command, start, free, target, accuracy)
    }
}

/// Values of the free inputs for a target, sought from an equilibrium under the command.
pub(in crate::analysis) fn reach_near<M: Model>(
    model: &mut M,
    command: &M::Command,
    start: &M::Found,
    free: &[FreeInput],
    target: &Target,
    accuracy: &Accuracy,
) -> Result<Reach<M::Found>, InverseProblem> {
    let target = target.checked()?;
    check::<M>(command, free)?;
    let value = |free: &FreeInput| M::value(command, free.input).unwrap_or_default();
    let values = DVector::from_iterator(free.len(), free.iter().map(value));
    let mut search = Search { model, command, free };
    searched(&mut search, &target, accuracy, vec![(values, start.clone())])
}

/// Values of the free inputs for a target, sought from the best of many places between their bounds.
pub(in crate::analysis) fn reach<M: Model>(
    model: &mut M,
    command: &M::Command,
    free: &[FreeInput],
    target: &Target,
    accuracy: &Accuracy,
) -> Result<Reach<M::Found>, InverseProblem> {
    let target = target.checked()?;
    check::<M>(command, free)?;
    let length = model.length();
    let mut search = Search { model, command, free };
    let starts =
        search.scout(STARTS, |search, found| target.residual(&search.model.tip(found), length).norm());
    let starts = starts.into_iter().map(|(_, values, found)| (values, found)).collect();
    searched(&mut search, &target, accuracy, starts)
}

/// The best that is found from several starts, the most promising first.
fn searched<M: Model>(
    search: &mut Search<M>,
    target: &Target,
    accuracy: &Accuracy,
    starts: Vec<(DVector<f64>, M::Found)>,
) -> Result<Reach<M::Found>, InverseProblem> {
    let (units, bounds) = (search.units(), search.bounds());
    let mut best: Option<(f64, DVector<f64>, M::Found)> = None;
    for (values, found) in starts {
        let Some(first) = evaluated(search, found, target) else { continue };
        let outcome = minimise(values, first, &bounds, &units, |values, near| {
            let found = search.at(values, Some(near))?;
            evaluated(search, found, target)
        });
        let left = outcome.best.residual.norm();
        if best.as_ref().is_none_or(|b| left < b.0) {
            best = Some((left, outcome.values, outcome.best.state));
        }
        if left < ARRIVED * ANGLE {
            break;
        }
    }
    let (_, values, equilibrium) = search.unless_stopped(best)?;
    Ok(conclude(search, target, accuracy, &values, equilibrium))
}

impl Target {
    /// With a direction of length 1.
    fn checked(&self) -> Result<Self, InverseProblem> {
        if self.position.is_none() && self.direction.is_none() {
            return Err(InverseProblem::NothingGiven);
        }
        let target = Self { position: self.position, direction: self.direction.map(|d| d.normalize()) };
        for (vector, what) in
            [(target.position, "the wanted position"), (target.direction, "the wanted direction")]
        {
            if vector.is_some_and(|v| !v.iter().all(|c| c.is_finite())) {
                return Err(InverseProblem::NotFinite(what));
            }
        }
        Ok(target)
    }

    fn residual(&self, tip: &TipPose, length: f64) -> DVector<f64> {
        let shift = self.position.map(|wanted| (tip.centre - wanted) / length);
        let turn = self.direction.map(|wanted| (tip.tangent() - wanted) * ANGLE);
        DVector::from_iterator(
            3 * (usize::from(shift.is_some()) + usize::from(turn.is_some())),
            shift.into_iter().chain(turn).flat_map(|v| [v.x, v.y, v.z]),
        )
    }
}

fn evaluated<M: Model>(
    search: &mut Search<M>,
    found: M::Found,
    target: &Target,
) -> Option<Evaluated<M::Found>> {
    let length = search.model.length();
    let exact = search.model.slopes(&found)?;
    let tip = search.model.tip(&found);
    let own = exact.tip_jacobian.select_columns(&columns(&exact.inputs, search.free));
    let tangent = tip.tangent();
    let residual = target.residual(&tip, length);
    let mut jacobian = DMatrix::zeros(residual.len(), own.ncols());
    for (c, column) in own.column_iter().enumerate() {
        let shift = column.fixed_rows::<3>(0) / length;
        let turn = Vector3::from(column.fixed_rows::<3>(3)).cross(&tangent) * ANGLE;
        let parts = target.position.map(|_| shift).into_iter().chain(target.direction.map(|_| turn));
        for (row, value) in parts.flat_map(|v| [v.x, v.y, v.z]).enumerate() {
            jacobian[(row, c)] = value;
        }
    }
    Some(Evaluated { residual, jacobian, state: found })
}

fn conclude<M: Model>(
    search: &mut Search<M>,
    target: &Target,
    accuracy: &Accuracy,
    values: &DVector<f64>,
    equilibrium: M::Found,
) -> Reach<M::Found> {
    let length = search.model.length();
    let tip = search.model.tip(&equilibrium);
    let (position, direction) = (tip.centre, tip.tangent());
    let distance = target.position.map(|wanted| (position - wanted).norm());
    let angle = target.direction.map(|wanted| direction.cross(&wanted).norm().atan2(direction.dot(&wanted)));
    let depends_on_path = search
        .at(values, None)
        .is_none_or(|other| (search.model.tip(&other).centre - position).norm() > ARRIVED * length);
    let exact = search.model.slopes(&equilibrium);
    let conditioning = exact.map(|exact| Conditioning::new(&exact, search.free, accuracy));
    let near = |i: usize, end: usize| {
        let [low, high] = search.free[i].bounds;
        (values[i] - search.free[i].bounds[end]).abs() <= ARRIVED * (high - low)
    };
    Reach {
        reached: distance.is_none_or(|d| d <= ARRIVED * length) && angle.is_none_or(|a| a <= ARRIVED),
        values: values.as_slice().to_vec(),
        at_bound: (0..values.len()).map(|i| near(i, 0) || near(i, 1)).collect(),
        equilibrium,
        position,
        direction,
        distance,
        angle,
        depends_on_path,
        conditioning,
    }
}

impl Conditioning {
    fn new(exact: &Sensitivity, free: &[FreeInput], accuracy: &Accuracy) -> Self {
        let deviations: Vec<f64> = free.iter().map(|f| accuracy.of(f)).collect();
        let mut own = exact.tip_jacobian.rows(0, 3).select_columns(&columns(&exact.inputs, free));
        own.column_iter_mut().zip(&deviations).for_each(|(mut column, deviation)| column *= *deviation);
        let by_size = |matrix: DMatrix<f64>| {
            let eigen = matrix.symmetric_eigen();
            let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
            order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
            order.into_iter().map(|i| eigen.eigenvectors.column(i).into_owned()).collect::<Vec<_>>()
        };
        let mut axes = Vec::new();
        let mut largest = 0.0_f64;
        for direction in by_size(&own * own.transpose()) {
            let back = own.tr_mul(&direction);
            let size = back.norm();
            largest = largest.max(size);
            let moves = size > IDLE * largest;
            let inputs = if moves {
                back.iter().zip(&deviations).map(|(b, d)| b * d / (size * size)).collect()
            } else {
                Vec::new()
            };
            let deviation = if moves { size } else { 0.0 };
            axes.push(TipAxis {
                direction: Vector3::new(direction[0], direction[1], direction[2]),
                deviation,
                inputs,
            });
        }
        let idle = by_size(own.tr_mul(&own))
            .into_iter()
            .filter(|v| (&own * v).norm() <= IDLE * largest)
            .map(|v| v.as_slice().to_vec())
            .collect();
        let moving = axes.iter().map(|a| a.deviation).filter(|d| *d > 0.0);
        let least = moving.fold(f64::INFINITY, f64::min);
        Self {
            condition: if largest > 0.0 { largest / least } else { f64::NAN },
            manipulability: axes.iter().map(|a| a.deviation).product(),
            axes,
            idle,
        }
    }
}
