//! The conditions of equilibrium of one layout, their tangent and its factors.
//!
//! Unknowns y = (u, efforts of the actuators whose motion is prescribed, λ of the edges); conditions
//! (𝓛_u, −(rotation_means − prescribed), x_b). Everything is scaled by the length L, by E_0 = EI/L for energies and by
//! E_0/L for forces, so that one tolerance serves all rows.
//!
//! Before the tangent is factored, ρ c_u times the row of every condition c is added to the rows of the coordinates, on both
//! sides of the equations. That changes no solution, and where the equilibrium is stable it makes the tangent positive on
//! all coordinates: eliminating in their order is then safe, and the signs of the pivots prove the stability.

use super::command::Actuator;
use super::settings::Formulation;
use crate::dense::{Lu, axpy, dot};
use crate::design::Robot;
use crate::kinematics::layout::{Layout, Layouts, field};
use crate::kinematics::pose::Poses;
use crate::kinematics::state::State;
use crate::real::{Each, Real, every};
use crate::statics::assembly::{Assembly, Efforts, Setting};
use crate::statics::{Loads, RotationMeans};
use num_traits::Zero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// One system of equations, of one command or of several side by side that differ in numbers only.
#[derive(Clone, Copy)]
pub(crate) struct System<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    pub loads: Each<'a, Loads>,
    pub rotation_means: RotationMeans,
    pub actuators: Each<'a, [Actuator]>,
    pub formulation: Formulation,
}

impl<'a> System<'a> {
    pub(super) fn setting(&self) -> Setting<'a> {
        Setting {
            robot: self.robot,
            layout: self.layout,
            loads: self.loads,
            rotation_means: self.rotation_means,
        }
    }
}

/// A point: coordinates and efforts.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
        Self { length, energy: robot.bending() / length }
    }

    /// Units of the coordinates: 1/L for curvatures and twist, 1 for stretch, L for edges.
    pub fn units(&self, layout: &Layout, units: &mut Vec<f64>) {
        units.clear();
        units.resize(layout.edges.len(), self.length);
        units.resize(layout.unknowns(), 1.0 / self.length);
        for element in layout.elements.iter().filter(|_| layout.stretch) {
            for &(first, count) in &element.modes[field::stretch(layout.tubes - 1, 0)..] {
                units[first..first + count].fill(1.0);
            }
        }
    }
}

/// Every buffer that a solve needs: after the first solve of a robot, later ones find their memory here.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buffers<S: Real = f64> {
    pub(crate) state: State<S>,
    pub(crate) poses: Poses<S>,
    pub(crate) assembly: Assembly<S>,
    pub(crate) residual: Vec<S>,
    /// The whole KKT matrix, where it has been asked for.
    pub(crate) matrix: Vec<S>,
    pub(crate) composed: bool,
    pub(super) lu: Lu<S>,
    /// Scaled rows of the conditions, and the weights of their penalties.
    conditions: Vec<S>,
    weights: Vec<S>,
    /// Unit of every coordinate.
    pub(crate) units: Vec<f64>,
    /// Right sides of the derivatives.
    pub(crate) right: Vec<S>,
    pub(super) step: Vec<S>,
    pub(super) correction: Vec<S>,
    pub(super) trial: Point<S>,
    /// Where an attempt starts, and scratch for its drives.
    pub(crate) start: Point<S>,
    pub(crate) edge_ratios: Vec<f64>,
    pub(crate) drives: Vec<Actuator>,
    pub(crate) layouts: Layouts,
    /// Newton steps taken since the buffers were made.
    pub(crate) iterations: usize,
    /// Of these, steps that were shortened.
    pub(crate) shortened: usize,
    /// Evaluations of the residual since the buffers were made.
    pub(crate) evaluations: usize,
    /// What `lu` holds of the tangent evaluated last.
    pub(super) factors: Factors,
    /// What `poses` holds of the state evaluated last.
    pub(super) pose_stage: PoseStage,
    /// Mark of the equilibrium that was evaluated last; 0 for none.
    pub(crate) mark: u64,
    /// Set from outside to end a long analysis.
    pub(super) stop: Option<Arc<AtomicBool>>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Factors {
    /// Nothing yet.
    #[default]
    None,
    /// Factors of the whole matrix.
    Pivoted,
    /// Eliminated in order, with penalties.
    InOrder {
        /// The lanes in which all pivots have the signs of a stable equilibrium.
        positive: u64,
    },
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd)]
pub(super) enum PoseStage {
    #[default]
    None,
    Values,
    /// With their rows at the ends of elements.
    Rows,
}

impl<S: Real> Buffers<S> {
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
            self.pose_stage = PoseStage::Values;
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
            self.poses.differentiate(layout, &self.state, loads.act_along());
            self.pose_stage = PoseStage::Rows;
        }
        self.assembly.tangent(&system.setting(), &self.state, &self.poses, &point.efforts);
        (self.factors, self.composed) = (Factors::None, false);
        broken
    }

    pub(super) fn begin(&mut self) {
        self.evaluations += 1;
        (self.mark, self.pose_stage) = (0, PoseStage::None);
    }

    /// Finds the poses of the state evaluated last, where they are not there.
    pub(crate) fn pose(&mut self, robot: &Robot, layout: &Layout) {
        if self.pose_stage < PoseStage::Values {
            self.poses.evaluate(robot, layout, &self.state);
            self.pose_stage = PoseStage::Values;
        }
    }

    /// Finds the poses, and their rows at the ends of elements, where they are not there.
    pub(crate) fn pose_rows(&mut self, robot: &Robot, layout: &Layout) {
        self.pose(robot, layout);
        if self.pose_stage < PoseStage::Rows {
            self.poses.differentiate(layout, &self.state, false);
            self.pose_stage = PoseStage::Rows;
        }
    }

    /// Was the equilibrium with this mark evaluated last?
    pub(crate) fn holds(&self, mark: u64) -> bool {
        mark != 0 && mark == self.mark
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
        let assembly = &self.assembly;
        self.residual.extend(system.constraints().map(|constraint| {
            (constraint.value(assembly) - constraint.target::<S>(system)) * constraint.scale(scale)
        }));
    }

    /// Puts the whole KKT matrix together, unless that has been done for the tangent evaluated last.
    pub(crate) fn compose_matrix(&mut self, system: &System) {
        if self.composed {
            return;
        }
        let (n, n_u) = (self.residual.len(), system.layout.unknowns());
        self.compose_conditions(system);
        self.matrix.clear();
        self.matrix.resize(n * n, S::zero());
        let inverse = 1.0 / Scale::of(system.robot).energy;
        for i in 0..n_u {
            let unit = self.units[i] * inverse;
            for (j, other) in self.units.iter().enumerate() {
                self.matrix[i * n + j] = self.assembly.second(i, j) * (unit * other);
            }
            for (c, own) in self.conditions.chunks_exact(n_u).enumerate() {
                self.matrix[i * n + n_u + c] = own[i];
                self.matrix[(n_u + c) * n + i] = own[i];
            }
        }
        self.composed = true;
    }

    /// Scaled rows of the conditions.
    fn compose_conditions(&mut self, system: &System) {
        let scale = Scale::of(system.robot);
        let Self { conditions, units, assembly, .. } = self;
        conditions.clear();
        for constraint in system.constraints() {
            let (row, factor) = (constraint.row(assembly), constraint.scale(scale));
            conditions.extend(row.iter().zip(&*units).map(|(slope, unit)| *slope * (factor * unit)));
        }
    }

    /// Factors the tangent with its penalties by elimination in order; returns the lanes in which all pivots have the signs of a
    /// stable equilibrium.
    pub(crate) fn factor_in_order(&mut self, system: &System) -> u64 {
        let (n, n_u) = (self.residual.len(), system.layout.unknowns());
        self.compose_conditions(system);
        let Self { conditions, weights, lu, units, assembly, .. } = self;
        let inverse = 1.0 / Scale::of(system.robot).energy;
        let weight = |own: &[S]| S::splat(PENALTY) / (dot(own, own) + f64::MIN_POSITIVE);
        weights.clear();
        weights.extend(conditions.chunks_exact(n_u).map(weight));
        let symmetric = assembly.symmetric;
        let factors = lu.begin(n);
        let (above, below) = factors.split_at_mut(n_u * n);
        for (i, target) in above.chunks_exact_mut(n).enumerate() {
            let from = if symmetric { i } else { 0 };
            let (target, across) = target.split_at_mut(n_u);
            let target = &mut target[from..];
            let unit = units[i] * inverse;
            let own = &assembly.hessian[i * n_u + from..(i + 1) * n_u];
            for ((entry, h), other) in target.iter_mut().zip(own).zip(&units[from..]) {
                *entry = *h * (unit * other);
            }
            for ((row, weight), across) in conditions.chunks_exact(n_u).zip(&*weights).zip(across) {
                axpy(target, *weight * row[i], &row[from..]);
                *across = row[i];
            }
        }
        for (target, row) in below.chunks_exact_mut(n).zip(conditions.chunks_exact(n_u)) {
            target[..n_u].copy_from_slice(row);
            target[n_u..].fill(S::zero());
        }
        let positive = self.lu.eliminate_in_order(n_u, symmetric);
        self.factors = Factors::InOrder { positive };
        positive
    }

    /// [`Self::factor_in_order`], unless that has been done with the tangent evaluated last.
    pub(crate) fn ensure_in_order(&mut self, system: &System) -> u64 {
        match self.factors {
            Factors::InOrder { positive } => positive,
            Factors::None | Factors::Pivoted => self.factor_in_order(system),
        }
    }

    /// Solves with the factored tangent; `right` is n × columns, row-major.
    pub(crate) fn solve(&self, right: &mut [S], columns: usize) {
        if let Factors::InOrder { .. } = self.factors {
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

impl Buffers {
    /// Has another thread asked to end?
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
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
    for (constraint, step) in system.constraints().zip(&step[n_u..]) {
        *constraint.effort(&mut point.efforts) += factor * *step * constraint.effort_unit(scale);
    }
}

/// Stiffness of a condition's penalty; bending of the whole robot has the stiffness 1.
const PENALTY: f64 = 10.0;
