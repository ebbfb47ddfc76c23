//! Newton's method on the conditions of equilibrium of one layout.
//!
//! Unknowns y = (u, efforts of the actuators whose motion is prescribed, λ of the edges); conditions
//! (𝓛_u, −(knob − prescribed), x_b). Everything is scaled by the length L, by E_0 = EI/L for energies and by
//! E_0/L for forces, so that one tolerance serves all rows.
//!
//! Before the tangent is factored, ρ c_u times the row of every condition c is added to the rows of the coordinates, on both
//! sides of the equations. That changes no solution, and where the equilibrium is stable it makes the tangent positive on
//! all coordinates: eliminating in their order is then safe, and the signs of the pivots prove the stability.

use super::command::{Actuator, Command, Drive, Formulation, Settings};
use crate::dense::{Lu, axpy, dot};
use crate::design::Robot;
use crate::kinematics::layout::{Cut, Layout, Layouts};
use crate::kinematics::pose::Poses;
use crate::kinematics::state::{Infeasible, State};
use crate::real::{Each, Real, every};
use crate::statics::assembly::{Assembly, Efforts, Setting};
use crate::statics::{Loads, RotationKnob, printed};
use num_traits::Zero;

/// Why Newton's method stopped without an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The first point already is no bundle.
    Infeasible,
    Singular,
    Stalled,
    IterationLimit,
}

/// One system of equations, of one command or of several side by side that differ in numbers only.
#[derive(Clone, Copy)]
pub(crate) struct System<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    pub loads: Each<'a, Loads>,
    pub knob: RotationKnob,
    pub actuators: Each<'a, [Actuator]>,
    pub formulation: Formulation,
}

impl<'a> System<'a> {
    fn setting(&self) -> Setting<'a> {
        Setting { robot: self.robot, layout: self.layout, loads: self.loads, knob: self.knob }
    }
}

/// A point: coordinates and efforts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Point<S = f64> {
    pub coordinates: Vec<S>,
    pub efforts: Efforts<S>,
}

impl<S: Real> Point<S> {
    /// All zero: the robot at rest.
    pub fn rest(layout: &Layout) -> Self {
        let zeros = |n: usize| vec![S::zero(); n];
        let followers = layout.tubes - 1;
        let efforts =
            Efforts { tension: zeros(followers), torque: zeros(followers), edge: zeros(layout.edges.len()) };
        Self { coordinates: zeros(layout.unknowns()), efforts }
    }

    /// Is this the robot at rest?
    pub fn is_rest(&self) -> bool {
        self.coordinates.iter().all(Zero::is_zero)
    }

    /// Copies without giving memory back.
    pub fn copy(&mut self, other: &Self) {
        self.coordinates.clone_from(&other.coordinates);
        self.efforts.tension.clone_from(&other.efforts.tension);
        self.efforts.torque.clone_from(&other.efforts.torque);
        self.efforts.edge.clone_from(&other.efforts.edge);
    }
}

/// Energy and length scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub length: f64,
    pub energy: f64,
}

impl Scale {
    pub fn of(robot: &Robot) -> Self {
        let length = robot.length();
        Self { length, energy: robot.bending / length }
    }

    /// Units of the coordinates: 1/L for curvatures and twist, 1 for stretch, L for edges.
    pub fn units(&self, layout: &Layout, units: &mut Vec<f64>) {
        units.clear();
        units.resize(layout.edges.len(), self.length);
        units.resize(layout.unknowns(), 1.0 / self.length);
        for element in layout.elements.iter().filter(|_| layout.stretch) {
            for &(first, count) in &element.modes[layout.tubes + 2..] {
                units[first..first + count].fill(1.0);
            }
        }
    }
}

/// Every buffer that a solve needs. Reuse it: after the first solve of a robot, later ones find their memory here.
#[derive(Clone, Debug, Default)]
// Lanes are an inner matter: outside there is one.
#[allow(private_bounds)]
pub struct Workspace<S: Real = f64> {
    pub(crate) state: State<S>,
    pub(crate) poses: Poses<S>,
    pub(crate) assembly: Assembly<S>,
    pub(crate) residual: Vec<S>,
    pub(crate) matrix: Vec<S>,
    lu: Lu<S>,
    /// Rows of the conditions as they were factored, and the weights of their penalties.
    conditions: Vec<S>,
    weights: Vec<S>,
    /// Unit of every coordinate.
    pub(crate) units: Vec<f64>,
    /// Right sides of the derivatives.
    pub(crate) right: Vec<S>,
    step: Vec<S>,
    correction: Vec<S>,
    trial: Point<S>,
    /// Where an attempt starts, and scratch for its drives.
    pub(crate) start: Point<S>,
    pub(crate) edge_ratios: Vec<f64>,
    pub(crate) drives: Vec<Actuator>,
    pub(crate) layouts: Layouts,
    /// Newton steps taken since the workspace was made.
    pub(crate) iterations: usize,
    /// Evaluations of the residual since the workspace was made.
    pub(crate) evaluations: usize,
    /// How `lu` was made, and whether from the matrix evaluated last.
    factors: Factors,
    factored: bool,
    /// What `poses` holds of the state evaluated last.
    posed: Posed,
    /// Mark of the equilibrium that was evaluated last; 0 for none.
    pub(crate) mark: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Factors {
    #[default]
    Pivoted,
    /// Eliminated in order, with penalties; all signs as at a stable equilibrium.
    InOrder,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd)]
enum Posed {
    #[default]
    None,
    Values,
    /// With their rows at the ends of elements.
    Rows,
}

#[allow(private_bounds)]
impl<S: Real> Workspace<S> {
    /// Residual and Jacobian of the consistent formulation at a point, scaled. Returns the lanes in which it
    /// describes no bundle.
    pub(crate) fn evaluate_consistent(&mut self, system: &System, point: &Point<S>) -> u64 {
        let broken = self.evaluate_residual(system, point);
        if broken == every::<S>() { broken } else { broken | self.complete(system, point) }
    }

    /// The residual alone, at a fraction of the cost; the factors stay those of the last tangent.
    pub(crate) fn evaluate_residual(&mut self, system: &System, point: &Point<S>) -> u64 {
        let System { robot, layout, .. } = *system;
        self.begin();
        let broken = self.state.evaluate(robot, layout, &point.coordinates);
        if broken == every::<S>() {
            return broken;
        }
        if !system.loads.first().is_empty() {
            self.poses.evaluate(robot, layout, &self.state);
            self.posed = Posed::Values;
        }
        let setting = system.setting();
        self.assembly.residual(&setting, &point.coordinates, &self.state, &self.poses, &point.efforts);
        self.compose_residual(system);
        broken | self.residual.iter().fold(0, |mask, r| mask | r.unless(f64::is_finite))
    }

    /// Adds the tangent to the residual evaluated last, at the same point.
    pub(crate) fn complete(&mut self, system: &System, point: &Point<S>) -> u64 {
        let System { robot, layout, .. } = *system;
        let broken = self.state.differentiate(robot, layout, &point.coordinates);
        let loads = system.loads.first();
        if !loads.is_empty() {
            let everywhere = loads.gravity.is_some() || !loads.distributed.is_empty();
            self.poses.differentiate(layout, &self.state, everywhere);
            self.posed = Posed::Rows;
        }
        self.assembly.tangent(&system.setting(), &self.state, &self.poses, &point.efforts);
        self.compose_matrix(system);
        self.factored = false;
        broken
    }

    fn begin(&mut self) {
        self.evaluations += 1;
        (self.mark, self.posed) = (0, Posed::None);
    }

    /// Poses of the state evaluated last.
    pub(crate) fn pose(&mut self, robot: &Robot, layout: &Layout) {
        if self.posed < Posed::Values {
            self.poses.evaluate(robot, layout, &self.state);
            self.posed = Posed::Values;
        }
    }

    /// The same with their rows at the ends of elements.
    pub(crate) fn pose_rows(&mut self, robot: &Robot, layout: &Layout) {
        self.pose(robot, layout);
        if self.posed < Posed::Rows {
            self.poses.differentiate(layout, &self.state, false);
            self.posed = Posed::Rows;
        }
    }

    /// Has the workspace evaluated this equilibrium of this robot last?
    pub(crate) fn holds(&self, robot: &Robot, mark: u64) -> bool {
        mark != 0 && mark == self.mark && self.assembly.robot() == robot.serial
    }

    /// Puts the residual together.
    pub(crate) fn compose_residual(&mut self, system: &System) {
        let layout = system.layout;
        let scale = Scale::of(system.robot);
        scale.units(layout, &mut self.units);
        let inverse = 1.0 / scale.energy;
        self.residual.clear();
        let slopes = self.assembly.gradient.iter().zip(&self.units);
        self.residual.extend(slopes.map(|(slope, unit)| *slope * (unit * inverse)));
        for (f, which, factor) in held(system) {
            let value = self.assembly.knobs[f][which] - system.wanted::<S>(f, which);
            self.residual.push(value * factor);
        }
        self.residual.extend(self.assembly.edges.iter().map(|edge| *edge * (1.0 / scale.length)));
    }

    /// Puts the KKT matrix together.
    fn compose_matrix(&mut self, system: &System) {
        let layout = system.layout;
        let scale = Scale::of(system.robot);
        let (n_u, n) = (layout.unknowns(), self.residual.len());
        self.matrix.clear();
        self.matrix.resize(n * n, S::zero());
        let inverse = 1.0 / scale.energy;
        for i in 0..n_u {
            let unit = self.units[i] * inverse;
            let own = &self.assembly.hessian[i * n_u..(i + 1) * n_u];
            for ((entry, h), other) in self.matrix[i * n..i * n + n_u].iter_mut().zip(own).zip(&self.units) {
                *entry = *h * (unit * other);
            }
        }
        let Self { matrix, units, assembly, .. } = self;
        let knobs = held(system).map(|(f, which, factor)| (&assembly.knob_rows[f][which], factor));
        let edges = assembly.edge_rows.iter().map(|row| (row, 1.0 / scale.length));
        for (at, (row, factor)) in (n_u..n).zip(knobs.chain(edges)) {
            for (j, (slope, unit)) in row.iter().zip(&*units).enumerate() {
                let entry = *slope * (factor * unit);
                matrix[at * n + j] = entry;
                matrix[j * n + at] = entry;
            }
        }
    }

    /// Factors the tangent with its penalties by elimination in order; returns the lanes in which that was good.
    pub(crate) fn factor_in_order(&mut self, system: &System) -> u64 {
        let (n, n_u) = (self.residual.len(), system.layout.unknowns());
        let Self { matrix, conditions, weights, lu, .. } = self;
        weights.clear();
        conditions.clear();
        let factors = lu.take(matrix, n);
        for own in matrix.chunks_exact(n).skip(n_u).map(|row| &row[..n_u]) {
            let weight = S::splat(PENALTY) / (dot(own, own) + f64::MIN_POSITIVE);
            for (target, &entry) in factors.chunks_exact_mut(n).zip(own) {
                axpy(&mut target[..n_u], weight * entry, own);
            }
            weights.push(weight);
            conditions.extend_from_slice(own);
        }
        self.factors = Factors::InOrder;
        self.lu.eliminate_in_order(n_u)
    }

    /// Solves with the factored tangent; `right` is n × columns, row-major.
    pub(crate) fn solve(&self, right: &mut [S], columns: usize) {
        if self.factors == Factors::InOrder {
            let n = right.len() / columns;
            let n_u = n - self.weights.len();
            let (above, below) = right.split_at_mut(n_u * columns);
            for ((row, weight), own) in
                self.conditions.chunks_exact(n_u).zip(&self.weights).zip(below.chunks_exact(columns))
            {
                for (target, &entry) in above.chunks_exact_mut(columns).zip(row) {
                    axpy(target, *weight * entry, own);
                }
            }
        }
        self.lu.solve(right, columns);
    }

    /// What the tangent factored last makes of the residual.
    pub(crate) fn correct(&self, correction: &mut Vec<S>) {
        correction.clone_from(&self.residual);
        self.solve(correction, 1);
    }
}

impl System<'_> {
    /// What a motion is to become.
    fn wanted<S: Real>(&self, follower: usize, which: usize) -> S {
        S::from_lanes(|l| {
            let actuator = &self.actuators.0[l][follower];
            [actuator.push_pull, actuator.rotation][which].value()
        })
    }
}

impl Workspace {
    /// An empty workspace.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

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

    /// The same for the printed formulation. Its generalised force is the derivative of nothing; its Jacobian is taken
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
        self.posed = Posed::Rows;
        let Self { state, poses, assembly, .. } = self;
        assembly.residual(&setting, &point.coordinates, state, poses, &point.efforts);
        assembly.condition_rows(&setting, state);
        let n_u = layout.unknowns();
        assembly.hessian.clear();
        assembly.hessian.resize(n_u * n_u, 0.0);
        self.compose_residual(system);
        self.compose_matrix(system);
        self.factored = false;
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
    pub(crate) fn factor(&mut self, system: &System) -> Result<(), Failure> {
        if self.factored {
            return Ok(());
        }
        let consistent = system.formulation == Formulation::Consistent;
        if !consistent || self.factor_in_order(system) != 1 {
            self.factors = Factors::Pivoted;
            self.lu.factor(&self.matrix, self.residual.len()).map_err(|_| Failure::Singular)?;
        }
        self.factored = true;
        Ok(())
    }

    /// The signs of the factored tangent's pivots are those of a stable equilibrium, if it is symmetric.
    pub(crate) fn is_in_order(&self) -> bool {
        self.factored && self.factors == Factors::InOrder
    }

    /// Newton's method from `point`, which ends at the equilibrium. Where `evaluated`, the workspace has seen that
    /// point before and only the prescribed motions are new. On failure `point` is the best iterate.
    pub(crate) fn newton(
        &mut self,
        system: &System,
        settings: &Settings,
        point: &mut Point,
        evaluated: bool,
    ) -> Result<(), Failure> {
        if evaluated {
            self.mark = 0;
            self.compose_residual(system);
        } else {
            self.evaluate(system, point).map_err(|_| Failure::Infeasible)?;
        }
        // How far the last tangent saw the equilibrium from the point.
        let mut distance = 0.0;
        for _ in 0..settings.iterations {
            let reached = self.largest();
            if reached <= settings.tolerance && distance <= NEAREST {
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
                return Err(Failure::Singular);
            }
            self.iterations += 1;
            let mut factor = self.longest();
            loop {
                self.advance(system, point, factor);
                if self.try_trial(system) && self.shrinks(length, factor) {
                    if factor >= 1.0 {
                        self.reuse_tangent(system, settings.tolerance, reached);
                    }
                    if self.complete_trial(system) {
                        distance = norm(&self.correction);
                        std::mem::swap(point, &mut self.trial);
                        break;
                    }
                }
                if reached <= FLOOR {
                    // Rounding is all that is left.
                    return self.evaluate(system, point).map_err(|_| Failure::Infeasible);
                }
                factor *= 0.5;
                if factor < SHORTEST {
                    return self
                        .evaluate(system, point)
                        .map_err(|_| Failure::Infeasible)
                        .and(Err(Failure::Stalled));
                }
            }
        }
        if self.largest() <= FLOOR { Ok(()) } else { Err(Failure::IterationLimit) }
    }

    /// Deuflhard's natural monotonicity test: the next correction with the same tangent has to be shorter. Unlike the
    /// residual's norm it does not depend on how equations are scaled, and so does not stop at long steps along
    /// a curved valley of the energy.
    fn shrinks(&mut self, length: f64, factor: f64) -> bool {
        self.find_correction();
        norm(&self.correction) <= (1.0 - 0.25 * factor) * length
    }

    /// Evaluates the residual at `trial`; true where it is one.
    fn try_trial(&mut self, system: &System) -> bool {
        let trial = std::mem::take(&mut self.trial);
        let broken = if system.formulation == Formulation::Consistent {
            self.evaluate_residual(system, &trial) != 0
        } else {
            self.evaluate(system, &trial).is_err()
        };
        self.trial = trial;
        !broken
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
        let mut ratio = 2.0 * reached / before;
        for left in (1..=MOST_REUSES).rev() {
            let distance = norm(&self.correction);
            let promises = |value: f64, bound: f64| value * ratio.powi(left) <= bound;
            if (reached <= tolerance && distance <= NEAREST)
                || !promises(reached, tolerance)
                || !promises(distance, NEAREST)
            {
                return;
            }
            add_step(system, &mut self.trial, &self.units, &self.correction, -1.0);
            let shrunk = self.try_trial(system) && self.largest() < 0.5 * reached;
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

    /// The factor that keeps every scaled coordinate of a step below [`LONGEST`].
    fn longest(&self) -> f64 {
        let largest = self.step.iter().take(self.state.unknowns).fold(0.0_f64, |m, s| m.max(s.abs()));
        (LONGEST / largest).min(1.0)
    }

    /// trial = point + factor · step.
    fn advance(&mut self, system: &System, point: &Point, factor: f64) {
        self.trial.copy(point);
        add_step(system, &mut self.trial, &self.units, &self.step, factor);
    }
}

/// The conditions of equilibrium at given coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedForces {
    /// Slopes of the Lagrangian by the coordinates: elastic, load and actuation forces in balance where they vanish. J per unit
    /// of the coordinate.
    pub forces: Vec<f64>,
    /// Per follower Δa_k (m) and Ω_k (rad).
    pub motions: Vec<[f64; 2]>,
}

/// What the solver brings to zero, for solvers of one's own: generalised forces of the consistent formulation at the given
/// coordinates (for each field its Legendre modes over the robot; 1/m for curvatures), under the efforts of a command;
/// motions that it prescribes count as efforts of zero. No coordinates stand for the robot at rest.
///
/// `None` where the coordinates are not as many as the resolution has, or describe no bundle.
#[must_use]
pub fn generalised_forces(
    robot: &Robot,
    workspace: &mut Workspace,
    command: &Command,
    settings: &Settings,
    coordinates: &[f64],
) -> Option<GeneralisedForces> {
    let cuts = command.loads.cuts().map(Cut::fixed);
    let layout = workspace.layouts.get(robot.tube_count(), robot.length(), settings.resolution, cuts);
    let mut point = Point::rest(&layout);
    if !coordinates.is_empty() {
        if coordinates.len() != layout.unknowns() {
            return None;
        }
        point.coordinates.copy_from_slice(coordinates);
    }
    for (f, actuator) in command.actuators.iter().enumerate().take(robot.follower_count()) {
        let effort = |drive: Drive| if drive.is_motion() { 0.0 } else { drive.value() };
        point.efforts.tension[f] = effort(actuator.push_pull);
        point.efforts.torque[f] = effort(actuator.rotation);
    }
    let setting = Setting { robot, layout: &layout, loads: Each::same(&command.loads), knob: command.knob };
    workspace.begin();
    let Workspace { state, poses, assembly, .. } = workspace;
    if state.evaluate(robot, &layout, &point.coordinates) != 0 {
        return None;
    }
    if !command.loads.is_empty() {
        poses.evaluate(robot, &layout, state);
    }
    assembly.residual(&setting, &point.coordinates, state, poses, &point.efforts);
    Some(GeneralisedForces { forces: assembly.gradient.clone(), motions: assembly.knobs.clone() })
}

/// point + factor · step, the step in scaled unknowns.
pub(crate) fn advanced(system: &System, point: &Point, step: &[f64], factor: f64) -> Point {
    let (mut result, mut units) = (point.clone(), Vec::new());
    Scale::of(system.robot).units(system.layout, &mut units);
    add_step(system, &mut result, &units, step, factor);
    result
}

/// point += factor · step, the factor one of each lane.
pub(crate) fn add_step<S: Real>(system: &System, point: &mut Point<S>, units: &[f64], step: &[S], factor: S) {
    let scale = Scale::of(system.robot);
    let n_u = system.layout.unknowns();
    for ((coordinate, step), unit) in point.coordinates.iter_mut().zip(step).zip(units) {
        *coordinate += factor * *step * *unit;
    }
    let mut steps = step[n_u..].iter().map(|s| factor * *s);
    let force = scale.energy / scale.length;
    let mut add = |target: &mut S, unit: f64| {
        if let Some(step) = steps.next() {
            *target += step * unit;
        }
    };
    for (f, actuator) in system.actuators.first().iter().enumerate() {
        if matches!(actuator.push_pull, Drive::Motion(_)) {
            add(&mut point.efforts.tension[f], force);
        }
        if matches!(actuator.rotation, Drive::Motion(_)) {
            add(&mut point.efforts.torque[f], scale.energy);
        }
    }
    for multiplier in &mut point.efforts.edge {
        add(multiplier, force);
    }
}

/// Stiffness of a condition's penalty; bending of the whole robot has the stiffness 1.
const PENALTY: f64 = 10.0;
/// Step of central differences in scaled unknowns.
const DIFFERENCE: f64 = 1e-5;
/// Below this the scaled residual is rounding error of the assembly.
pub(crate) const FLOOR: f64 = 1e-8;
/// Largest distance from the equilibrium in scaled unknowns: near a bifurcation residuals vanish early.
pub(crate) const NEAREST: f64 = 1e-9;
/// How often a tangent serves once more at most.
pub(crate) const MOST_REUSES: i32 = 3;
/// Shortest part of a Newton step that is tried.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Largest change of a scaled coordinate (curvature times length: an angle in rad) in one step.
pub(crate) const LONGEST: f64 = 20.0;

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Actuators whose motion is prescribed: follower, push-pull (0) or rotation (1), and the factor that scales the condition.
fn held<'a>(system: &System<'a>) -> impl Iterator<Item = (usize, usize, f64)> + use<'a> {
    let length = system.robot.length();
    system.actuators.first().iter().enumerate().flat_map(move |(f, actuator)| {
        let drives = [(0, actuator.push_pull, -1.0 / length), (1, actuator.rotation, -1.0)];
        drives
            .into_iter()
            .filter(|(_, drive, _)| drive.is_motion())
            .map(move |(which, _, factor)| (f, which, factor))
    })
}

/// How many conditions join the gradient.
pub(crate) fn condition_count(system: &System) -> usize {
    held(system).count() + system.layout.edges.len()
}
