//! Newton's method on the conditions of equilibrium of one layout.
//!
//! Unknowns y = (u, efforts of the actuators whose motion is prescribed, λ of the edges); conditions
//! (𝓛_u, −(knob − prescribed), x_b). Everything is scaled by the length L, by E_0 = EI/L for energies and by
//! E_0/L for forces, so that one tolerance serves all rows.

use super::command::{Actuator, Drive, Formulation, Settings};
use crate::dense::Lu;
use crate::design::Robot;
use crate::kinematics::layout::{Layout, Layouts};
use crate::kinematics::pose::Poses;
use crate::kinematics::state::{Infeasible, State};
use crate::statics::assembly::{Assembly, Efforts, Setting};
use crate::statics::{Loads, RotationKnob, printed};

/// Why Newton's method stopped without an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The first point already is no bundle.
    Infeasible,
    Singular,
    Stalled,
    IterationLimit,
}

/// One system of equations.
pub(crate) struct System<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    pub loads: &'a Loads,
    pub knob: RotationKnob,
    pub actuators: &'a [Actuator],
    pub formulation: Formulation,
}

/// A point: coordinates and efforts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Point {
    pub coordinates: Vec<f64>,
    pub efforts: Efforts,
}

impl Point {
    /// All zero: the robot at rest.
    pub fn rest(layout: &Layout) -> Self {
        let zeros = |n: usize| vec![0.0; n];
        let followers = layout.tubes - 1;
        let efforts =
            Efforts { tension: zeros(followers), torque: zeros(followers), edge: zeros(layout.edges.len()) };
        Self { coordinates: zeros(layout.unknowns()), efforts }
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
        let bending: f64 = (0..robot.tube_count()).map(|t| robot.fields_at(t, 0.5 * length).bending_z).sum();
        Self { length, energy: bending / length }
    }

    /// Units of the coordinates: 1/L for curvatures and twist, 1 for stretch, L for edges.
    pub fn units(&self, layout: &Layout, units: &mut Vec<f64>) {
        units.clear();
        units.resize(layout.modes, 1.0 / self.length);
        units.resize(layout.unknowns(), self.length);
        for element in layout.elements.iter().filter(|_| layout.stretch) {
            for &(first, count) in &element.modes[layout.tubes + 2..] {
                units[first..first + count].fill(1.0);
            }
        }
    }
}

/// Every buffer that a solve needs. Reuse it: after the first solve of a robot, later ones find their memory here.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(crate) state: State,
    pub(crate) poses: Poses,
    pub(crate) assembly: Assembly,
    pub(crate) residual: Vec<f64>,
    pub(crate) matrix: Vec<f64>,
    pub(crate) lu: Lu,
    /// Unit of every coordinate.
    pub(crate) units: Vec<f64>,
    /// Scratch of the stability test.
    pub(crate) penalty: Vec<f64>,
    step: Vec<f64>,
    correction: Vec<f64>,
    trial: Point,
    /// Where an attempt starts.
    pub(crate) start: Point,
    pub(crate) layouts: Layouts,
    /// Newton steps taken since the workspace was made.
    pub(crate) iterations: usize,
    /// Evaluations of the residual since the workspace was made.
    pub(crate) evaluations: usize,
}

impl Workspace {
    /// An empty workspace.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Residual and Jacobian at a point, scaled.
    pub(crate) fn evaluate(&mut self, system: &System, point: &Point) -> Result<(), Infeasible> {
        self.evaluations += 1;
        let System { robot, layout, loads, knob, .. } = *system;
        self.state.evaluate(robot, layout, &point.coordinates, true)?;
        let posed = !loads.is_empty() || system.formulation == Formulation::Printed;
        if posed {
            self.poses.evaluate(robot, layout, &self.state);
            let everywhere = loads.gravity.is_some() || !loads.distributed.is_empty();
            self.poses.differentiate(layout, &self.state, everywhere);
        }
        let setting = Setting { robot, layout, loads, knob };
        let consistent = system.formulation == Formulation::Consistent;
        self.assembly.assemble(
            &setting,
            &point.coordinates,
            &self.state,
            &self.poses,
            &point.efforts,
            consistent,
        );
        if consistent {
            self.compose(system);
        } else {
            self.compose_printed(system, point)?;
        }
        if self.residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(Infeasible) }
    }

    /// Puts residual and KKT matrix together.
    fn compose(&mut self, system: &System) {
        let layout = system.layout;
        let scale = Scale::of(system.robot);
        scale.units(layout, &mut self.units);
        let units = &self.units;
        let n_u = layout.unknowns();
        let conditions = condition_count(system);
        let n = n_u + conditions;
        self.residual.clear();
        self.residual.resize(n, 0.0);
        self.matrix.clear();
        self.matrix.resize(n * n, 0.0);
        let inverse = 1.0 / scale.energy;
        for i in 0..n_u {
            self.residual[i] = self.assembly.gradient[i] * units[i] * inverse;
            for j in 0..n_u {
                self.matrix[i * n + j] = self.assembly.hessian[i * n_u + j] * units[i] * units[j] * inverse;
            }
        }
        let mut at = n_u;
        let mut condition = |value: f64, row: &[f64], sign: f64, unit: f64| {
            self.residual[at] = sign * value / unit;
            for (j, &slope) in row.iter().enumerate() {
                let entry = sign * slope * units[j] / unit;
                self.matrix[at * n + j] = entry;
                self.matrix[j * n + at] = entry;
            }
            at += 1;
        };
        for (f, actuator) in system.actuators.iter().enumerate() {
            for (which, drive, unit) in [(0, actuator.push_pull, scale.length), (1, actuator.rotation, 1.0)] {
                if let Drive::Motion(wanted) = drive {
                    let value = self.assembly.knobs[f][which] - wanted;
                    condition(value, &self.assembly.knob_rows[f][which], -1.0, unit);
                }
            }
        }
        for (b, row) in self.assembly.edge_rows.iter().enumerate() {
            condition(self.assembly.edges[b], row, 1.0, scale.length);
        }
    }

    /// The same for the printed formulation. Its generalised force is the derivative of nothing; its Jacobian is taken
    /// by central differences, to about 1e-9 of its size.
    fn compose_printed(&mut self, system: &System, point: &Point) -> Result<(), Infeasible> {
        let System { robot, layout, loads, knob, .. } = *system;
        let setting = Setting { robot, layout, loads, knob };
        let n_u = layout.unknowns();
        self.assembly.hessian.clear();
        self.assembly.hessian.resize(n_u * n_u, 0.0);
        self.compose(system);
        let n = self.residual.len();
        let energy = Scale::of(robot).energy;
        let (mut state, mut poses, mut assembly) = (State::default(), Poses::default(), Assembly::default());
        // Only the fields at the nodes are wanted of the assembly.
        let unloaded = Loads::none();
        let fields = Setting { loads: &unloaded, ..setting };
        let mut projected = |at: &Point| -> Result<Vec<f64>, Infeasible> {
            state.evaluate(robot, layout, &at.coordinates, true)?;
            poses.evaluate(robot, layout, &state);
            assembly.assemble(&fields, &at.coordinates, &state, &poses, &at.efforts, false);
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
        for (b, edge) in (layout.modes..n_u).enumerate() {
            let multiplier = n - layout.edges.len() + b;
            self.residual[edge] = point.efforts.edge[b];
            self.matrix[edge * n + multiplier] = 1.0;
        }
        Ok(())
    }

    /// Newton's method from `point`, which ends at the equilibrium. On failure `point` is the best iterate.
    pub(crate) fn newton(
        &mut self,
        system: &System,
        settings: &Settings,
        point: &mut Point,
    ) -> Result<(), Failure> {
        self.evaluate(system, point).map_err(|_| Failure::Infeasible)?;
        for _ in 0..settings.iterations {
            let reached = self.largest();
            if reached <= settings.tolerance {
                return Ok(());
            }
            let n = self.residual.len();
            self.lu.factor(&self.matrix, n).map_err(|_| Failure::Singular)?;
            self.step.clear();
            self.step.extend(self.residual.iter().map(|r| -r));
            self.lu.solve(&mut self.step, 1);
            let length = norm(&self.step);
            if !length.is_finite() {
                return Err(Failure::Singular);
            }
            self.iterations += 1;
            let mut factor = self.longest();
            loop {
                self.advance(system, point, factor);
                let trial = std::mem::take(&mut self.trial);
                let evaluated = self.evaluate(system, &trial);
                self.trial = trial;
                if evaluated.is_ok() && self.shrinks(length, factor) {
                    std::mem::swap(point, &mut self.trial);
                    break;
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
        self.correction.clear();
        self.correction.extend_from_slice(&self.residual);
        self.lu.solve(&mut self.correction, 1);
        norm(&self.correction) <= (1.0 - 0.25 * factor) * length
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

/// point + factor · step, the step in scaled unknowns.
pub(crate) fn advanced(system: &System, point: &Point, step: &[f64], factor: f64) -> Point {
    let (mut result, mut units) = (point.clone(), Vec::new());
    Scale::of(system.robot).units(system.layout, &mut units);
    add_step(system, &mut result, &units, step, factor);
    result
}

fn add_step(system: &System, point: &mut Point, units: &[f64], step: &[f64], factor: f64) {
    let scale = Scale::of(system.robot);
    let n_u = system.layout.unknowns();
    for ((coordinate, step), unit) in point.coordinates.iter_mut().zip(step).zip(units) {
        *coordinate += factor * step * unit;
    }
    let mut steps = step[n_u..].iter().map(|s| factor * s);
    let force = scale.energy / scale.length;
    let mut add = |target: &mut f64, unit: f64| {
        if let Some(step) = steps.next() {
            *target += step * unit;
        }
    };
    for (f, actuator) in system.actuators.iter().enumerate() {
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

/// Step of central differences in scaled unknowns.
const DIFFERENCE: f64 = 1e-5;
/// Below this the scaled residual is rounding error of the assembly.
pub(crate) const FLOOR: f64 = 1e-8;
/// Shortest part of a Newton step that is tried.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Largest change of a scaled coordinate (curvature times length: an angle in rad) in one step.
const LONGEST: f64 = 20.0;

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How many conditions join the gradient.
pub(crate) fn condition_count(system: &System) -> usize {
    let held = |a: &Actuator| {
        usize::from(matches!(a.push_pull, Drive::Motion(_)))
            + usize::from(matches!(a.rotation, Drive::Motion(_)))
    };
    system.actuators.iter().map(held).sum::<usize>() + system.layout.edges.len()
}
