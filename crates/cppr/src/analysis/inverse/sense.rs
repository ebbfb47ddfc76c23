//! The wrench on the tip from what it does to the robot: efforts of the actuators, position and direction of the tip.
//!
//! Motions and all other loads are those of the command. Measured numbers, each divided by its standard deviation, are fitted by
//! the dead wrench on the tip's centre; the covariance follows from the same Jacobian (`response_by_wrench`, `compliance`).

use super::InverseProblem;
use super::least_squares::{Evaluated, minimise};
use super::uncertainty::Uncertainty;
use crate::analysis::model::Model;
use crate::solve::{Command, Equilibrium, Freedom, Input, Solver};
use crate::statics::Wrench;
use nalgebra::{DMatrix, DVector, Vector3};

/// One measurement, with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Force or torque of an actuator whose motion is prescribed: tube number, freedom, value (N or N m), deviation.
    Effort(usize, Freedom, f64, f64),
    /// Centre of the tip section (m), deviation of each coordinate (m).
    Position(Vector3<f64>, f64),
    /// Tangent of the tip, deviation (rad).
    Direction(Vector3<f64>, f64),
}

/// The wrench that explains the measurements best.
#[derive(Clone, Debug)]
pub struct Sensed<E = Equilibrium> {
    /// Force on the tip's centre, base frame (N).
    pub force: Vector3<f64>,
    /// Moment, base frame (N m); zero where only a force was looked for.
    pub moment: Vector3<f64>,
    /// Uncertainty of the force's components and, if looked for, of the moment's.
    pub uncertainty: Uncertainty,
    /// How far every measurement, in the order given, lies from what it would be under the wrench, in its standard deviations. Where one is
    /// missed by many, no wrench explains it.
    pub misses: Vec<f64>,
    /// The equilibrium under it.
    pub equilibrium: E,
}

/// Units of the search against the force that bends the robot by 1 rad: known to no better than that is not known.
const RANGE: f64 = 10.0;

impl Solver {
    /// Finds a force on the tip, with `with_moment` a whole wrench.
    ///
    /// # Errors
    /// Where the measurements cannot be used, or no stable equilibrium explains them.
    pub fn sense(
        &mut self,
        command: &Command,
        measured: &[Measured],
        with_moment: bool,
    ) -> Result<Sensed, InverseProblem> {
        let start = self.solve(command).map_err(InverseProblem::Command)?;
        self.sense_near(&start, measured, with_moment)
    }

    /// The same from an equilibrium without the wrench that is looked for, whose robot, command and settings hold. Where its loads have a wrench
    /// on the tip already, what is found comes on top of it: an observer needs only a correction then, and fewer steps.
    ///
    /// # Errors
    /// As [`Solver::sense`].
    pub fn sense_near(
        &mut self,
        start: &Equilibrium,
        measured: &[Measured],
        with_moment: bool,
    ) -> Result<Sensed, InverseProblem> {
        (self.robot, self.settings) = (start.robot().clone(), *start.settings());
        let command = start.command();
        sense(self, command, Some(start.clone()), measured, with_moment)
    }
}

/// The wrench on the tip of any robot, from its equilibrium under the command.
pub(in crate::analysis) fn sense<M: Model>(
    model: &mut M,
    command: &M::Command,
    start: Option<M::Found>,
    measured: &[Measured],
    with_moment: bool,
) -> Result<Sensed<M::Found>, InverseProblem> {
    let unknowns = if with_moment { 6 } else { 3 };
    check::<M>(model.length(), command, measured)?;
    let (length, [stiffness, ..]) = (model.length(), model.stiffness());
    let force = RANGE * stiffness / (length * length);
    let units: Vec<f64> = (0..unknowns).map(|i| if i < 3 { force } else { force * length }).collect();
    let bounds = vec![[f64::NEG_INFINITY, f64::INFINITY]; unknowns];
    let zero = DVector::zeros(unknowns);
    let first = start
        .filter(M::is_stable)
        .and_then(|found| evaluated(model, found, measured, unknowns))
        .ok_or(InverseProblem::NoEquilibrium)?;
    let outcome = minimise(zero, first, &bounds, &units, |wrench, near| {
        let found = model.stable(&M::with_wrench(command, wrench_of(wrench)), Some(near))?;
        evaluated(model, found, measured, unknowns)
    });
    let wrench = wrench_of(&outcome.values);
    let Evaluated { residual, jacobian, .. } = &outcome.best;
    Ok(Sensed {
        force: wrench.force,
        moment: wrench.moment,
        uncertainty: Uncertainty::new(residual, jacobian, residual.len(), &units),
        misses: misses(measured, residual),
        equilibrium: outcome.best.state,
    })
}

/// Sizes of the residuals that belong to each measurement.
fn misses(measured: &[Measured], residual: &DVector<f64>) -> Vec<f64> {
    let mut from = 0;
    let sizes = measured.iter().map(|one| {
        let numbers = match one {
            Measured::Effort(..) => 1,
            Measured::Position(..) => 3,
            Measured::Direction(..) => 2,
        };
        from += numbers;
        residual.rows(from - numbers, numbers).norm()
    });
    sizes.collect()
}

fn wrench_of(values: &DVector<f64>) -> Wrench {
    let part = |from: usize| match values.as_slice().get(from..from + 3) {
        Some([x, y, z]) => Vector3::new(*x, *y, *z),
        _ => Vector3::zeros(),
    };
    Wrench { moment: part(3), ..Wrench::tip_force(part(0)) }
}

fn check<M: Model>(length: f64, command: &M::Command, measured: &[Measured]) -> Result<(), InverseProblem> {
    if measured.is_empty() {
        return Err(InverseProblem::NothingGiven);
    }
    for one in measured {
        let (values, deviation, what) = match *one {
            Measured::Effort(tube, freedom, value, deviation) => {
                if !M::is_motion(command, Input { tube, freedom, is_motion: true }) {
                    return Err(InverseProblem::EffortPrescribed(tube));
                }
                (Vector3::new(value, 0.0, 0.0), deviation, "a measured effort")
            }
            Measured::Position(position, deviation) => {
                (position, deviation / length, "the measured position")
            }
            Measured::Direction(direction, deviation) => (direction, deviation, "the measured direction"),
        };
        let finite = values.iter().all(|v| v.is_finite());
        let direction = !matches!(one, Measured::Direction(..)) || values.norm() > 0.0;
        if !(finite && direction && deviation.is_finite() && deviation > 0.0) {
            return Err(InverseProblem::NotFinite(what));
        }
    }
    Ok(())
}

fn evaluated<M: Model>(
    model: &mut M,
    found: M::Found,
    measured: &[Measured],
    unknowns: usize,
) -> Option<Evaluated<M::Found>> {
    let exact = model.slopes(&found)?;
    let tip = model.tip(&found);
    let (position, tangent) = (tip.centre, tip.tangent());
    let (mut residual, mut rows) = (Vec::new(), Vec::new());
    let mut add = |difference: f64, row: Vec<f64>, deviation: f64| {
        residual.push(difference / deviation);
        rows.extend(row[..unknowns].iter().map(|v| v / deviation));
    };
    for one in measured {
        match *one {
            Measured::Effort(tube, freedom, value, deviation) => {
                let place = exact.inputs.iter().position(|i| i.tube == tube && i.freedom == freedom)?;
                let effort = M::actual(&found, Input { tube, freedom, is_motion: false })?;
                let row = exact.response_by_wrench.row(place).iter().copied().collect();
                add(effort - value, row, deviation);
            }
            Measured::Position(wanted, deviation) => {
                for axis in 0..3 {
                    let row = exact.compliance.row(axis).iter().copied().collect();
                    add(position[axis] - wanted[axis], row, deviation);
                }
            }
            Measured::Direction(wanted, deviation) => {
                // Two angles across the measured direction; the third component says nothing.
                let wanted = wanted.normalize();
                let helper = if wanted.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
                let first = wanted.cross(&helper).normalize();
                for axis in [first, wanted.cross(&first)] {
                    let row = (0..6)
                        .map(|c| {
                            let spin = Vector3::from(exact.compliance.column(c).fixed_rows::<3>(3));
                            axis.dot(&spin.cross(&tangent))
                        })
                        .collect();
                    add(axis.dot(&tangent), row, deviation);
                }
            }
        }
    }
    let jacobian = DMatrix::from_row_slice(residual.len(), unknowns, &rows);
    Some(Evaluated { residual: DVector::from_vec(residual), jacobian, state: found })
}
