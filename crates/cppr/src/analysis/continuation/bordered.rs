//! The bordered system: the conditions of equilibrium r(y, λ) = 0 with the fraction λ as one more unknown, and one more
//! row c·δ = 0 that says in which direction nothing moves.
//!
//! ```text
//! B = ⎡ r_y  r_λ ⎤        z = (y, λ), scaled as in solve::newton
//!     ⎣   cᵀ     ⎦
//! ```
//!
//! Along a path c = W t with the tangent t, r_y t_y + r_λ t_λ = 0. W is 1 on coordinates and on λ and 0 on efforts, which
//! follow from them. B is regular at folds and singular at branch points. r is affine in λ at fixed y, so that
//! r_λ = r(y, λ + 1) − r(y, λ) exactly.

use super::family::Family;
use super::{PathPoint, PointKind};
use crate::dense::{Determinant, Lu, dot};
use crate::design::Robot;
use crate::kinematics::layout::Layout;
use crate::real::Each;
use crate::solve::acceptance::{contracts, is_rounding};
use crate::solve::constraint::{drives, prescribe};
use crate::solve::stability;
use crate::solve::system::{Buffers, Point, System, advanced};
use crate::solve::{
    Actuator, ActuatorState, Command, Drive, Equilibrium, Settings, Solver, Statistics, Status,
};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The unknowns of one stretch of a path.
#[derive(Clone)]
pub(super) struct Stage {
    pub layout: Arc<Layout>,
    /// One bit per follower: driven by force and standing at the plate, between the forces of both sides.
    pub standing: u64,
}

impl Stage {
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.layout, &other.layout) && self.standing == other.standing
    }

    /// Coordinates, which the metric sees; efforts lie between them and the fraction.
    pub fn unknowns(&self) -> usize {
        self.layout.unknowns()
    }

    fn drives(&self, robot: &Robot, command: &Command, settings: &Settings) -> Vec<Actuator> {
        let mut list = Vec::new();
        drives(robot, command, settings, self.standing, &mut list);
        list
    }
}

/// A point and its fraction.
#[derive(Clone)]
pub(super) struct PathState {
    pub point: Point,
    pub fraction: f64,
}

/// An equilibrium on a path, with what the next step needs.
#[derive(Clone)]
pub(super) struct Node {
    pub stage: Stage,
    pub place: PathState,
    /// dz/ds, scaled.
    pub tangent: Vec<f64>,
    /// Of B with c = W t.
    pub determinant: Determinant,
    /// Eigenvalues of the constrained tangent, ascending; `None` for the printed formulation.
    pub spectrum: Option<Vec<f64>>,
    /// dΔa_k/ds (m).
    pub sliding: Vec<f64>,
    pub point: PathPoint,
}

impl Node {
    pub fn slope(&self) -> f64 {
        self.tangent.last().copied().unwrap_or(0.0)
    }

    /// Reverses the direction in which the path passes this point.
    pub fn turn(&mut self) {
        self.tangent.iter_mut().chain(&mut self.sliding).for_each(|rate| *rate = -*rate);
        self.determinant.sign = -self.determinant.sign;
    }

    /// Sets an event between two neighbours: the eigenvalue that vanishes there counts as not negative.
    pub fn mark(&mut self, kind: PointKind, here: &Self, next: &Self) {
        self.point.kind = kind;
        self.point.inertia = here.point.inertia.min(next.point.inertia);
        self.point.equilibrium.status =
            if self.inertia() == 0 { Status::Converged } else { Status::Unstable };
    }

    pub fn inertia(&self) -> usize {
        self.point.inertia.unwrap_or(0)
    }
}

/// W v.
pub(super) fn weigh(stage: &Stage, v: &[f64]) -> Vec<f64> {
    let (n_u, last) = (stage.unknowns(), v.len() - 1);
    v.iter().enumerate().map(|(i, &x)| if i < n_u || i == last { x } else { 0.0 }).collect()
}

pub(super) fn length(stage: &Stage, v: &[f64]) -> f64 {
    dot(v, &weigh(stage, v)).sqrt()
}

/// Unknowns and λ of the bordered system of an equilibrium.
pub(super) fn size_of(found: &Equilibrium) -> usize {
    found.layout.unknowns() + found.system().constraints().count() + 1
}

/// Most corrections of one predicted point.
const MOST_TURNS: usize = 10;

/// Evaluates, corrects, and reads what an equilibrium tells.
pub(super) struct Bordered<'a> {
    pub robot: &'a Robot,
    pub buffers: &'a mut Buffers,
    pub family: &'a Family,
    pub settings: &'a Settings,
    rate: Vec<f64>,
    matrix: Vec<f64>,
    lu: Lu,
}

impl<'a> Bordered<'a> {
    pub fn new(solver: &'a mut Solver, family: &'a Family) -> Self {
        let Solver { robot, settings, buffers, .. } = solver;
        Self { robot, buffers, family, settings, rate: Vec::new(), matrix: Vec::new(), lu: Lu::default() }
    }

    fn with_system<T>(
        &mut self,
        stage: &Stage,
        fraction: f64,
        work: impl FnOnce(&mut Self, &System) -> T,
    ) -> T {
        let command = self.family.at(fraction);
        let drives = stage.drives(self.robot, &command, self.settings);
        let system = System {
            robot: self.robot,
            layout: &stage.layout,
            loads: Each::same(&command.loads),
            rotation_means: command.rotation_means,
            actuators: Each::same(&drives),
            formulation: self.settings.formulation,
        };
        work(self, &system)
    }

    /// Residual and r_y at a place, whose prescribed efforts are brought to its fraction.
    fn conditions(&mut self, stage: &Stage, place: &mut PathState) -> Option<()> {
        self.with_system(stage, place.fraction, |solver, system| {
            prescribe(&system.actuators, &mut place.point.efforts);
            solver.buffers.evaluate(system, &place.point).ok()?;
            solver.buffers.compose_matrix(system);
            Some(())
        })
    }

    /// Residual, r_y and r_λ.
    fn evaluate(&mut self, stage: &Stage, place: &mut PathState) -> Option<()> {
        let mut ahead = PathState { fraction: place.fraction + 1.0, point: place.point.clone() };
        self.conditions(stage, &mut ahead)?;
        self.rate.clone_from(&self.buffers.residual);
        self.conditions(stage, place)?;
        for (rate, here) in self.rate.iter_mut().zip(&self.buffers.residual) {
            *rate -= here;
        }
        Some(())
    }

    /// B with the given last row, at the evaluated place.
    fn compose(&mut self, row: &[f64]) -> usize {
        let n = self.rate.len();
        self.matrix.clear();
        for (own, rate) in self.buffers.matrix.chunks_exact(n).zip(&self.rate) {
            self.matrix.extend_from_slice(own);
            self.matrix.push(*rate);
        }
        self.matrix.extend_from_slice(row);
        n + 1
    }

    fn factor(&mut self, row: &[f64]) -> Option<()> {
        let n = self.compose(row);
        self.lu.factor(&self.matrix, n).ok()
    }

    fn advance(&mut self, stage: &Stage, place: &mut PathState, step: &[f64], factor: f64) {
        self.with_system(stage, place.fraction, |_, system| {
            place.point = advanced(system, &place.point, &step[..step.len() - 1], factor);
        });
        place.fraction += factor * step[step.len() - 1];
    }

    /// The place at a distance along a direction.
    pub fn predicted(
        &mut self,
        stage: &Stage,
        from: &PathState,
        direction: &[f64],
        distance: f64,
    ) -> PathState {
        let mut place = from.clone();
        self.advance(stage, &mut place, direction, distance);
        place
    }

    /// Newton's method on the bordered system; the number of corrections, or `None` where it does not contract.
    /// `tolerance` is that of the scaled residual.
    pub fn correct(
        &mut self,
        stage: &Stage,
        place: &mut PathState,
        row: &[f64],
        tolerance: f64,
    ) -> Option<usize> {
        let mut before = f64::INFINITY;
        for turn in 0..=MOST_TURNS {
            self.evaluate(stage, place)?;
            let reached = self.buffers.residual.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
            if reached <= tolerance {
                return Some(turn);
            }
            self.factor(row)?;
            let mut step: Vec<f64> = self.buffers.residual.iter().map(|r| -r).chain([0.0]).collect();
            self.lu.solve(&mut step, 1);
            let size = length(stage, &step);
            if !contracts(size, before) {
                // Where only rounding is left, corrections stop getting shorter.
                return (is_rounding(reached) && turn > 0).then_some(turn);
            }
            before = size;
            self.advance(stage, place, &step, 1.0);
        }
        None
    }

    /// How far another place of the same stage lies along a weighed direction.
    pub fn offset(&self, from: &PathState, to: &PathState, row: &[f64]) -> f64 {
        let moved = from.point.coordinates.iter().zip(&to.point.coordinates).zip(&self.buffers.units);
        let along: f64 = moved.zip(row).map(|(((a, b), unit), r)| r * (b - a) / unit).sum();
        along + row[row.len() - 1] * (to.fraction - from.fraction)
    }

    /// Distance of two places of one stage.
    pub fn distance(&self, from: &PathState, to: &PathState) -> f64 {
        let moved = from.point.coordinates.iter().zip(&to.point.coordinates).zip(&self.buffers.units);
        let square: f64 = moved.map(|((a, b), unit)| ((b - a) / unit).powi(2)).sum();
        (square + (to.fraction - from.fraction).powi(2)).sqrt()
    }

    /// What there is to know at the corrected place; its tangent points along `row`.
    pub fn node(&mut self, stage: &Stage, place: &PathState, row: &[f64]) -> Option<Node> {
        self.factor(row)?;
        let mut determinant = self.lu.determinant();
        let mut tangent = vec![0.0; row.len()];
        tangent[row.len() - 1] = 1.0;
        self.lu.solve(&mut tangent, 1);
        let size = length(stage, &tangent);
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        for t in &mut tangent {
            *t /= size;
        }
        // det B is linear in its last row: from the row given, on which the tangent has the share 1/size, to W t.
        determinant.ln += size.ln();
        let spectrum =
            self.with_system(stage, place.fraction, |s, system| stability::spectrum(s.buffers, system));
        let Buffers { assembly, units, .. } = &*self.buffers;
        let rate = |row: &[f64]| row.iter().zip(units).zip(&tangent).map(|((r, u), t)| r * u * t).sum();
        let sliding = assembly.motion_rows.iter().map(|rows| rate(&rows[0])).collect();
        let point = self.read(stage, place, spectrum.as_deref());
        let (stage, place) = (stage.clone(), place.clone());
        Some(Node { stage, place, tangent, determinant, spectrum, sliding, point })
    }

    /// The evaluated place as an equilibrium.
    fn read(&mut self, stage: &Stage, place: &PathState, spectrum: Option<&[f64]>) -> PathPoint {
        let command = self.family.at(place.fraction);
        let inertia = spectrum.map(stability::negative);
        let mut equilibrium = Equilibrium {
            robot: self.robot.clone(),
            status: if inertia.unwrap_or(0) == 0 { Status::Converged } else { Status::Unstable },
            statistics: Statistics::default(),
            elastic_energy: 0.0,
            actuators: vec![ActuatorState::default(); command.actuators.len()],
            settings: *self.settings,
            residual: 0.0,
            layout: Arc::clone(&stage.layout),
            point: place.point.clone(),
            drives: stage.drives(self.robot, &command, self.settings),
            mark: 0,
            command,
        };
        equilibrium.read(self.buffers);
        for (f, (state, actuator)) in
            equilibrium.actuators.iter_mut().zip(&equilibrium.command.actuators).enumerate()
        {
            // A follower that stands at the plate leaves the rest of its force to the jump there.
            if let (1, Drive::Effort(force)) = (stage.standing >> f & 1, actuator.push_pull) {
                state.tension = force;
            }
        }
        self.buffers.pose(self.robot, &stage.layout);
        let tip = self.buffers.poses.centre.last().copied().unwrap_or_default();
        PathPoint {
            parameter: self.family.value(place.fraction),
            fraction: place.fraction,
            kind: PointKind::Regular,
            tip,
            inertia,
            margin: spectrum.and_then(|s| s.first().copied()),
            equilibrium,
        }
    }

    /// An orthonormal basis of the `count` directions that B, with the row W t, maps to the least: where a path crosses
    /// others, and the least singular value.
    pub fn critical(&mut self, node: &Node, count: usize) -> Option<(Vec<Vec<f64>>, f64)> {
        let mut place = node.place.clone();
        self.evaluate(&node.stage, &mut place)?;
        let n = self.compose(&weigh(&node.stage, &node.tangent));
        let svd = DMatrix::from_row_slice(n, n, &self.matrix).svd(false, true);
        let right = svd.v_t?;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_unstable_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
        let directions = order.iter().take(count).map(|&i| {
            let direction: Vec<f64> = right.row(i).iter().copied().collect();
            let size = length(&node.stage, &direction);
            let largest = direction[..node.stage.unknowns()]
                .iter()
                .fold(0.0_f64, |m, &x| if x.abs() > m.abs() { x } else { m });
            direction.iter().map(|x| x / (size * largest.signum())).collect()
        });
        Some((directions.collect(), svd.singular_values[*order.first()?]))
    }
}
