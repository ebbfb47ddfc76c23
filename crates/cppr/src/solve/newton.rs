//! Newton's method on the conditions of equilibrium of one layout.
//!
//! Trial steps ask for residuals alone. A tangent is made where a step has been accepted, and serves once more where the
//! residuals promise that it will do.

use super::acceptance::{
    MOST_REUSES, SHORTEST, arrived, expected_ratio, is_rounding, keeps, longest_part, promises, shrinks,
};
use super::settings::{Formulation, Settings};
use super::system::{Buffers, Factors, Point, PoseStage, Scale, System, add_step};
use crate::kinematics::pose::Poses;
use crate::kinematics::state::{Infeasible, State};
use crate::real::Each;
use crate::statics::assembly::{Assembly, Setting};
use crate::statics::{Loads, printed};

/// Why Newton's method stopped without an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NewtonFailure {
    /// The first point already is no bundle.
    Infeasible,
    Singular,
    Stalled,
    IterationLimit,
}

impl Buffers {
    /// Residual and Jacobian at a point, scaled.
    pub(crate) fn evaluate(&mut self, system: &System, point: &Point) -> Result<(), Infeasible> {
        let broken = if system.formulation == Formulation::Consistent {
            self.evaluate_consistent(system, point) != 0
        } else {
            self.evaluate_printed(system, point)?;
            self.residual.iter().any(|r| !r.is_finite())
        };
        if broken { Err(Infeasible) } else { Ok(()) }
    }

    /// Residual at a point, without the tangent where the formulation does not need it.
    pub(crate) fn residual_at(&mut self, system: &System, point: &Point) -> Result<(), Infeasible> {
        match system.formulation {
            Formulation::Consistent if self.evaluate_residual(system, point) != 0 => Err(Infeasible),
            Formulation::Consistent => Ok(()),
            Formulation::Printed => self.evaluate(system, point),
        }
    }

    /// Residual and Jacobian of the printed formulation. Its generalised force is the derivative of nothing; its Jacobian is taken
    /// by central differences, to about 1e-9 of its size.
    fn evaluate_printed(&mut self, system: &System, point: &Point) -> Result<(), Infeasible> {
        let System { robot, layout, .. } = *system;
        let setting = system.setting();
        self.begin();
        if self.state.evaluate(robot, layout, &point.coordinates) != 0
            || self.state.differentiate(robot, layout, &point.coordinates) != 0
        {
            return Err(Infeasible);
        }
        self.poses.evaluate(robot, layout, &self.state);
        self.poses.differentiate(layout, &self.state, true);
        self.pose_stage = PoseStage::Rows;
        let Self { state, poses, assembly, .. } = self;
        assembly.residual(&setting, &point.coordinates, state, poses, &point.efforts);
        assembly.condition_rows(&setting, state);
        let n_u = layout.unknowns();
        assembly.hessian.clear();
        assembly.hessian.resize(n_u * n_u, 0.0);
        assembly.symmetric = false;
        self.compose_residual(system);
        (self.factors, self.composed) = (Factors::None, false);
        self.compose_matrix(system);
        let n = self.residual.len();
        let energy = Scale::of(robot).energy;
        let (mut state, mut poses, mut assembly) = (State::default(), Poses::default(), Assembly::default());
        // Only the fields at the nodes are wanted of the assembly.
        let unloaded = Loads::none();
        let fields = Setting { loads: Each::same(&unloaded), ..setting };
        let mut projected = |at: &Point| -> Result<Vec<f64>, Infeasible> {
            if state.evaluate(robot, layout, &at.coordinates) != 0
                || state.differentiate(robot, layout, &at.coordinates) != 0
            {
                return Err(Infeasible);
            }
            poses.evaluate(robot, layout, &state);
            assembly.residual(&fields, &at.coordinates, &state, &poses, &at.efforts);
            let mut result = Vec::new();
            printed::residual(
                &setting,
                &at.coordinates,
                &state,
                &poses,
                &assembly.jets,
                &at.efforts,
                &mut result,
            );
            Ok(result)
        };
        let here = projected(point)?;
        let units = self.units.clone();
        for (i, value) in here.iter().enumerate() {
            self.residual[i] = value * units[i] / energy;
        }
        self.step.clear();
        self.step.resize(n, 0.0);
        for j in 0..n {
            self.step.fill(0.0);
            self.step[j] = 1.0;
            let mut sides = [Vec::new(), Vec::new()];
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                self.advance(system, point, sign * DIFFERENCE);
                *side = projected(&self.trial)?;
            }
            for i in 0..n_u {
                self.matrix[i * n + j] = (sides[0][i] - sides[1][i]) / (2.0 * DIFFERENCE) * units[i] / energy;
            }
        }
        // An edge has no equation of its own here, and needs no multiplier.
        for (b, edge) in (0..layout.edges.len()).enumerate() {
            let multiplier = n - layout.edges.len() + b;
            self.residual[edge] = point.efforts.edge[b];
            self.matrix[edge * n + multiplier] = 1.0;
        }
        Ok(())
    }

    /// Factors the tangent evaluated last, where that has not been done.
    pub(crate) fn factor(&mut self, system: &System) -> Result<(), NewtonFailure> {
        if self.factors != Factors::None {
            return Ok(());
        }
        let consistent = system.formulation == Formulation::Consistent;
        if !consistent || self.factor_in_order(system) != 1 {
            self.factors = Factors::None;
            self.compose_matrix(system);
            self.lu.factor(&self.matrix, self.residual.len()).map_err(|_| NewtonFailure::Singular)?;
            self.factors = Factors::Pivoted;
        }
        Ok(())
    }

    /// The signs of the factored tangent's pivots are those of a stable equilibrium, if it is symmetric.
    pub(crate) fn is_in_order(&self) -> bool {
        matches!(self.factors, Factors::InOrder { positive: 1 })
    }

    /// Newton's method from `point`, which ends at the equilibrium. Where `evaluated`, the buffers hold that
    /// point's evaluation already and only the prescribed motions are new. On failure `point` is the best iterate.
    pub(crate) fn newton(
        &mut self,
        system: &System,
        settings: &Settings,
        point: &mut Point,
        evaluated: bool,
    ) -> Result<(), NewtonFailure> {
        if evaluated {
            self.mark = 0;
            self.compose_residual(system);
        } else {
            self.evaluate(system, point).map_err(|_| NewtonFailure::Infeasible)?;
        }
        // How far the last tangent saw the equilibrium from the point.
        let mut distance = 0.0;
        for _ in 0..settings.iterations {
            let reached = self.largest();
            if arrived(reached, distance, settings.tolerance) == 1 {
                return Ok(());
            }
            self.factor(system)?;
            self.step.clear();
            self.step.extend(self.residual.iter().map(|r| -r));
            let mut step = std::mem::take(&mut self.step);
            self.solve(&mut step, 1);
            self.step = step;
            let length = norm(&self.step);
            if !length.is_finite() {
                return Err(NewtonFailure::Singular);
            }
            self.iterations += 1;
            let mut factor = self.longest();
            loop {
                self.advance(system, point, factor);
                if self.try_trial(system) && self.corrects(length, factor) {
                    if factor >= 1.0 {
                        self.reuse_tangent(system, settings.tolerance, reached);
                    }
                    if self.complete_trial(system) {
                        self.shortened += usize::from(factor < 1.0);
                        distance = norm(&self.correction);
                        std::mem::swap(point, &mut self.trial);
                        break;
                    }
                }
                if is_rounding(reached) {
                    // Rounding is all that is left.
                    return self.evaluate(system, point).map_err(|_| NewtonFailure::Infeasible);
                }
                factor *= 0.5;
                if factor < SHORTEST {
                    return self
                        .evaluate(system, point)
                        .map_err(|_| NewtonFailure::Infeasible)
                        .and(Err(NewtonFailure::Stalled));
                }
            }
        }
        if is_rounding(self.largest()) { Ok(()) } else { Err(NewtonFailure::IterationLimit) }
    }

    /// Finds what the same tangent makes of the residual at `trial`; is that short enough?
    fn corrects(&mut self, length: f64, factor: f64) -> bool {
        self.find_correction();
        shrinks(norm(&self.correction), length, factor) == 1
    }

    /// Evaluates the residual at `trial`; true where it is one.
    fn try_trial(&mut self, system: &System) -> bool {
        let trial = std::mem::take(&mut self.trial);
        let found = self.residual_at(system, &trial).is_ok();
        self.trial = trial;
        found
    }

    /// Adds the tangent to the residual at `trial`.
    fn complete_trial(&mut self, system: &System) -> bool {
        let trial = std::mem::take(&mut self.trial);
        let whole = system.formulation == Formulation::Printed || self.complete(system, &trial) == 0;
        self.trial = trial;
        whole
    }

    /// Moves `trial` on with the tangent of the step that led to it, as long as that promises to come below the tolerance in
    /// fewer operations than a new one: each time the residual shrinks by about the same ratio, twice that of the whole step
    /// from `before`. `correction` holds what the tangent makes of the residual.
    fn reuse_tangent(&mut self, system: &System, tolerance: f64, before: f64) {
        if system.formulation == Formulation::Printed {
            return;
        }
        let mut reached = self.largest();
        let mut ratio = expected_ratio(reached, before);
        for left in (1..=MOST_REUSES).rev() {
            let distance = norm(&self.correction);
            let there = arrived(reached, distance, tolerance) == 1;
            if there || promises(reached, distance, ratio, left, tolerance) == 0 {
                return;
            }
            add_step(system, &mut self.trial, &self.units, &self.correction, -1.0);
            let shrunk = self.try_trial(system) && keeps(self.largest(), reached) == 1;
            if !shrunk {
                add_step(system, &mut self.trial, &self.units, &self.correction, 1.0);
                self.try_trial(system);
                return;
            }
            self.iterations += 1;
            ratio = self.largest() / reached;
            reached = self.largest();
            self.find_correction();
        }
    }

    fn find_correction(&mut self) {
        let mut correction = std::mem::take(&mut self.correction);
        self.correct(&mut correction);
        self.correction = correction;
    }

    fn largest(&self) -> f64 {
        self.residual.iter().fold(0.0, |m, r| r.abs().max(m))
    }

    /// The factor that keeps every scaled coordinate of a step in bounds.
    fn longest(&self) -> f64 {
        let largest = self.step.iter().take(self.state.unknowns).fold(0.0_f64, |m, s| m.max(s.abs()));
        longest_part(largest)
    }

    /// trial = point + factor · step.
    fn advance(&mut self, system: &System, point: &Point, factor: f64) {
        self.trial.copy(point);
        add_step(system, &mut self.trial, &self.units, &self.step, factor);
    }
}

/// Step of central differences in scaled unknowns.
const DIFFERENCE: f64 = 1e-5;

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
