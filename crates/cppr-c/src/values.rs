//! What can be read of an equilibrium, as rows of numbers.

use crate::model::Model;
use crate::names::{cppr_field, cppr_value};
use cppr::analysis::{Sensitivity, total_bend};
use cppr::kinematics::TipPose;
use cppr::solve::{Equilibrium, Reason, Solver, Status};

/// Numbers per value.
pub(crate) fn size(model: &Model, value: cppr_value) -> usize {
    let n = model.tubes();
    match value {
        cppr_value::TipPosition | cppr_value::Error => 3,
        cppr_value::TipRotation => 9,
        cppr_value::Pull | cppr_value::Rotation | cppr_value::Tension | cppr_value::Torque => n,
        cppr_value::Jacobian | cppr_value::JacobianBody | cppr_value::ResponseByWrench => 12 * n,
        cppr_value::Response => 4 * n * n,
        cppr_value::Compliance => 36,
        _ => 1,
    }
}

/// Numbers per section.
pub(crate) fn field_size(model: &Model, field: cppr_field) -> usize {
    match field {
        cppr_field::Centre | cppr_field::Curvature => 3,
        cppr_field::Rotation => 9,
        cppr_field::Abscissa => model.tubes(),
        cppr_field::Centroid | cppr_field::Moment | cppr_field::Force => 3 * model.tubes(),
        cppr_field::EnergyDensity => 1,
    }
}

/// One equilibrium and what has been derived from it.
pub(crate) struct Reader<'a> {
    pub solver: &'a mut Solver,
    pub found: &'a Equilibrium,
    pub pose: Option<TipPose>,
    pub sensitivity: &'a mut Sensitivity,
    pub derived: &'a mut Option<bool>,
}

/// Inputs of the leader before those of the mechanics, which has none for it.
const LEADER: usize = 2;

impl Reader<'_> {
    /// Writes a value into as many numbers as [`size`] says, NaN before; false where there is none.
    pub fn read(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let found = self.found;
        let count = |number: usize| number as f64;
        let single = match value {
            cppr_value::Status => match found.status() {
                Status::Converged => 0.0,
                Status::Unstable => 1.0,
                Status::NotConverged(_) => 2.0,
            },
            cppr_value::Fraction => match found.status() {
                Status::NotConverged(Reason::PathEnds { fraction }) => fraction,
                Status::NotConverged(Reason::Edges) => 0.0,
                _ => 1.0,
            },
            cppr_value::Iterations => count(found.statistics().iterations),
            cppr_value::Evaluations => count(found.statistics().evaluations),
            cppr_value::LoadSteps => count(found.statistics().load_steps),
            cppr_value::Residual => found.residual(),
            _ if !found.status().is_equilibrium() => return false,
            cppr_value::ElasticEnergy => found.elastic_energy(),
            cppr_value::TotalBend => total_bend(found),
            cppr_value::Length => found.robot().length(),
            cppr_value::Margin => match self.solver.margin(found) {
                Some(margin) => margin,
                None => return false,
            },
            cppr_value::Error => match self.solver.accuracy(found) {
                Some(own) => {
                    out.copy_from_slice(&[own.tip, own.force, own.torque]);
                    return true;
                }
                None => return false,
            },
            _ => return self.read_many(value, out),
        };
        out.fill(single);
        true
    }

    fn read_many(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let found = self.found;
        match value {
            cppr_value::TipPosition | cppr_value::TipRotation => {
                let TipPose { rotation, centre } = *self.pose.get_or_insert_with(|| self.solver.tip(found));
                if value == cppr_value::TipPosition {
                    out.copy_from_slice(centre.as_slice());
                } else {
                    out.copy_from_slice(rotation.transpose().as_slice());
                }
                return true;
            }
            cppr_value::Pull | cppr_value::Rotation | cppr_value::Tension | cppr_value::Torque => {
                for (cell, own) in out.iter_mut().skip(LEADER / 2).zip(found.actuators()) {
                    *cell = match value {
                        cppr_value::Pull => own.motion,
                        cppr_value::Rotation => own.rotation,
                        cppr_value::Tension => own.tension,
                        _ => own.torque,
                    };
                }
                return true;
            }
            _ => {}
        }
        let Self { solver, sensitivity, derived, .. } = self;
        if !*derived.get_or_insert_with(|| solver.sensitivity_into(found, sensitivity).is_ok()) {
            return false;
        }
        write_derivatives(value, sensitivity, LEADER, out);
        true
    }
}

/// Writes a matrix of derivatives into rows and columns for two inputs of every tube; the first `before` inputs have none.
pub(crate) fn write_derivatives(value: cppr_value, own: &Sensitivity, before: usize, out: &mut [f64]) {
    let all = own.inputs.len();
    let width = before + all;
    match value {
        cppr_value::Jacobian => {
            spread(out, width, [0, before], [6, all], |r, c| own.tip_jacobian[(r, c)]);
        }
        cppr_value::JacobianBody => {
            spread(out, width, [0, before], [6, all], |r, c| own.tip_jacobian_body[(r, c)]);
        }
        cppr_value::Response => spread(out, width, [before; 2], [all; 2], |r, c| own.response[(r, c)]),
        cppr_value::Compliance => spread(out, 6, [0; 2], [6; 2], |r, c| own.compliance[(r, c)]),
        _ => spread(out, 6, [before, 0], [all, 6], |r, c| own.response_by_wrench[(r, c)]),
    }
}

/// Writes a block of a matrix of `width` columns, from a first row and column on.
fn spread(
    out: &mut [f64],
    width: usize,
    from: [usize; 2],
    size: [usize; 2],
    value: impl Fn(usize, usize) -> f64,
) {
    for (r, row) in out.chunks_exact_mut(width).skip(from[0]).take(size[0]).enumerate() {
        for (c, cell) in row.iter_mut().skip(from[1]).take(size[1]).enumerate() {
            *cell = value(r, c);
        }
    }
}
