//! Newton's method on what an integration leaves of the conditions.

use super::Bundle;
use super::number::{Dual, Number};
use super::prepared::Prepared;
use super::section::TubeState;
use super::steps::Steps;
use super::vector::columns;
use super::walk::{Base, Condition, Lost, Outcome, Walk};
use crate::solve::Drive;
use crate::statics::Loads;
use nalgebra::{DMatrix, DVector, Dyn, LU, Matrix3, Vector3};

/// What the motors of one tube do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeDrive {
    /// Travel of the motor (m), pull positive: the label that stands at the plate, were the shaft rigid; or the force (N) with which
    /// it pulls.
    pub translation: Drive,
    /// Rotation of the motor (rad), right-handed about +X, or its torque (N m).
    pub rotation: Drive,
}

impl TubeDrive {
    /// Held where it stands at rest.
    pub const HELD: Self = Self { translation: Drive::Motion(0.0), rotation: Drive::Motion(0.0) };
}

/// Motors and loads of a bundle.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleCommand {
    /// One per tube.
    pub drives: Vec<TubeDrive>,
    /// External loads.
    pub loads: Loads,
}

impl BundleCommand {
    fn between(&self, start: &Self, share: f64) -> Self {
        let mix = |a: Drive, b: Drive| {
            let from = if a.is_motion() == b.is_motion() { a.value() } else { 0.0 };
            b.with_value(from + share * (b.value() - from))
        };
        let drives = start.drives.iter().zip(&self.drives);
        Self {
            drives: drives
                .map(|(a, b)| TubeDrive {
                    translation: mix(a.translation, b.translation),
                    rotation: mix(a.rotation, b.rotation),
                })
                .collect(),
            loads: self.loads.scaled(share),
        }
    }
}

/// Motion and effort of one tube's motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TubeEffort {
    /// Label at the plate (m).
    pub label: f64,
    /// Rotation of the material at the plate (rad).
    pub rotation: f64,
    /// Force with which the motor pulls (N).
    pub force: f64,
    /// Torque of the motor (N m), right-handed about +X.
    pub torque: f64,
}

/// What came out of a solve.
#[derive(Clone, Debug)]
pub struct BundleEquilibrium {
    /// Was an equilibrium found?
    pub converged: bool,
    /// Motors, one per tube.
    pub efforts: Vec<TubeEffort>,
    /// Centre of the last tip (m).
    pub tip: Vector3<f64>,
    /// Its section frame: columns tangent, towards the centroid of the tube that counts it, across.
    pub frame: Matrix3<f64>,
    /// Length of the centreline (m).
    pub length: f64,
    /// Has the determinant of the conditions the sign that it has at rest? It changes where an eigenvalue does, so that a path on which
    /// it never changed is stable as rest is.
    pub stable: bool,
    /// Steps of the integration, and Newton steps.
    pub steps: usize,
    /// Newton steps.
    pub iterations: usize,
    /// How far tip (m) and forces (N) move when every step is halved.
    pub error: [f64; 2],
    pub(crate) unknowns: Unknowns,
    pub(crate) command: BundleCommand,
}

/// Values of the unknowns by what they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unknowns {
    pub tubes: Vec<[f64; 4]>,
    pub force: [f64; 3],
    pub moment: [f64; 2],
    pub handed: Vec<[f64; 2]>,
}

/// Solver of one bundle.
#[derive(Clone, Debug)]
pub struct BundleSolver<'a> {
    bundle: &'a Bundle,
    /// Error allowed in one step of the integration, in scaled variables.
    pub tolerance: f64,
    /// Are the tubes' centroid lines extensible?
    pub stretch: bool,
    rest: Option<BundleEquilibrium>,
}

/// Most unknowns and inputs at once; a bundle with more is not solved, and says so.
const MOST: usize = 48;
const ITERATIONS: usize = 40;
/// Newton steps below this (scaled) end.
const SETTLED: f64 = 1e-9;
const SHORTEST_STEP: f64 = 1.0 / 4096.0;
/// Newton steps of one load step, and how many make it an easy one.
const ITERATIONS_IN_STEPS: usize = 15;
const EASY: usize = 6;
/// Load steps.
const MOST_STEPS: usize = 400;

/// The unknowns of one command.
struct Frame<'a> {
    bundle: &'a Bundle,
    command: &'a BundleCommand,
    prepared: Prepared,
    present: Vec<bool>,
    handed: usize,
}

impl<'a> Frame<'a> {
    fn new(bundle: &'a Bundle, command: &'a BundleCommand, stretch: bool) -> Self {
        let prepared = Prepared::new(bundle, &command.loads, stretch);
        let present = (0..bundle.tubes.len())
            .map(|i| match command.drives[i].translation {
                Drive::Motion(label) => label < bundle.tubes[i].tip,
                Drive::Effort(_) => true,
            })
            .collect();
        let handed = bundle
            .stations
            .iter()
            .map(|s| s.iter().filter(|&&(t, label)| label < bundle.tubes[t].tip).count().saturating_sub(1));
        let handed = handed.sum();
        Self { bundle, command, prepared, present, handed }
    }

    fn units(&self) -> [f64; 4] {
        let length = self.bundle.length;
        let force = self.prepared.force_scale;
        [length, force, 1.0, force * length]
    }

    fn count(&self) -> usize {
        2 * self.present.iter().filter(|p| **p).count()
            + if self.prepared.loaded { 2 } else { 0 }
            + if self.prepared.seeks_force { 3 } else { 0 }
            + 2 * self.handed
    }

    /// The start of the walk for scaled unknowns and the drives' values.
    fn base<S: Number>(&self, unknowns: &[S], drives: &[[S; 2]]) -> Base<S> {
        let [length, force, _, moment] = self.units();
        let mut next = unknowns.iter();
        let mut take = |unit: f64| next.next().map_or(S::constant(0.0), |u| *u * unit);
        let mut tubes = Vec::with_capacity(self.present.len());
        let mut twist = S::constant(0.0);
        for (i, drive) in self.command.drives.iter().enumerate() {
            let [travel, turn] = drives[i];
            if !self.present[i] {
                let zero = S::constant(0.0);
                tubes.push(TubeState { label: travel, tension: zero, angle: turn, torque: zero });
                continue;
            }
            let shaft = self.bundle.tubes[i].shaft;
            let (label, tension) = match drive.translation {
                Drive::Motion(_) => {
                    let tension = take(force);
                    let label = match shaft {
                        Some(s) => travel - tension * (1.0 / s.axial),
                        None => travel,
                    };
                    (label, tension)
                }
                Drive::Effort(_) => (take(length), travel),
            };
            let (angle, torque) = match drive.rotation {
                Drive::Motion(_) => {
                    let torque = take(moment);
                    let angle = match shaft {
                        Some(s) => turn + torque * (1.0 / s.torsional),
                        None => turn,
                    };
                    (angle, torque)
                }
                Drive::Effort(_) => (take(1.0), -turn),
            };
            twist += torque;
            tubes.push(TubeState { label, tension, angle, torque });
        }
        let zero = S::constant(0.0);
        let mut base = Base {
            tubes,
            force: self.prepared.dead_force.map(S::constant),
            moment: [zero; 3],
            handed: Vec::new(),
        };
        if self.prepared.loaded {
            base.moment = [twist, take(moment), take(moment)];
        }
        if self.prepared.seeks_force {
            base.force = [take(force), take(force), take(force)];
        }
        for _ in 0..self.handed {
            base.handed.push([take(force), take(moment)]);
        }
        base
    }

    fn drives(&self) -> Vec<[f64; 2]> {
        self.command.drives.iter().map(|d| [d.translation.value(), d.rotation.value()]).collect()
    }

    /// Scaled unknowns from what is known of a neighbour.
    fn scaled(&self, from: &Unknowns) -> Vec<f64> {
        let [length, force, _, moment] = self.units();
        let mut result = Vec::with_capacity(self.count());
        for (i, drive) in self.command.drives.iter().enumerate() {
            if self.present[i] {
                let [label, tension, angle, torque] = from.tubes.get(i).copied().unwrap_or_default();
                result.push(if drive.translation.is_motion() { tension / force } else { label / length });
                result.push(if drive.rotation.is_motion() { torque / moment } else { angle });
            }
        }
        if self.prepared.loaded {
            result.extend(from.moment.map(|m| m / moment));
        }
        if self.prepared.seeks_force {
            result.extend(from.force.map(|f| f / force));
        }
        for i in 0..self.handed {
            let [t, p] = from.handed.get(i).copied().unwrap_or_default();
            result.extend([t / force, p / moment]);
        }
        result
    }

    fn unknowns(&self, scaled: &[f64]) -> Unknowns {
        let base = self.base(scaled, &self.drives());
        Unknowns {
            tubes: base.tubes.iter().map(|t| [t.label, t.tension, t.angle, t.torque]).collect(),
            force: base.force,
            moment: [base.moment[1], base.moment[2]],
            handed: base.handed,
        }
    }

    fn residual_units(&self, conditions: &[Condition]) -> Vec<f64> {
        let [length, force, _, moment] = self.units();
        conditions
            .iter()
            .map(|c| match c {
                Condition::Label => length,
                Condition::Angle => 1.0,
                Condition::Energy | Condition::Force => force,
                Condition::Moment => moment,
            })
            .collect()
    }

    fn walk(&self, tolerance: f64) -> Walk<'_> {
        Walk {
            bundle: self.bundle,
            command: &self.prepared,
            posed: self.prepared.loaded,
            tolerance,
            longest: f64::INFINITY,
        }
    }

    /// Scaled residual.
    fn residual(&self, unknowns: &[f64], tolerance: f64, steps: &mut Steps) -> Result<DVector<f64>, Lost> {
        let base = self.base(unknowns, &self.drives());
        let outcome = self.walk(tolerance).run(&base, steps, None)?;
        let units = self.residual_units(&outcome.conditions);
        Ok(DVector::from_iterator(units.len(), outcome.residual.iter().zip(&units).map(|(r, u)| r / u)))
    }

    /// Scaled residual and its matrix of slopes.
    fn tangent(
        &self,
        unknowns: &[f64],
        tolerance: f64,
        steps: &mut Steps,
    ) -> Result<(DVector<f64>, DMatrix<f64>), Lost> {
        match unknowns.len() {
            0..=4 => self.tangent_with::<4>(unknowns, tolerance, steps),
            5..=8 => self.tangent_with::<8>(unknowns, tolerance, steps),
            9..=12 => self.tangent_with::<12>(unknowns, tolerance, steps),
            13..=16 => self.tangent_with::<16>(unknowns, tolerance, steps),
            17..=24 => self.tangent_with::<24>(unknowns, tolerance, steps),
            25..=MOST => self.tangent_with::<MOST>(unknowns, tolerance, steps),
            _ => Err(Lost::Steps),
        }
    }

    fn tangent_with<const P: usize>(
        &self,
        unknowns: &[f64],
        tolerance: f64,
        steps: &mut Steps,
    ) -> Result<(DVector<f64>, DMatrix<f64>), Lost> {
        let inputs: Vec<Dual<P>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let drives: Vec<[Dual<P>; 2]> = self.drives().iter().map(|pair| pair.map(Dual::constant)).collect();
        let base = self.base(&inputs, &drives);
        let outcome = self.walk(tolerance).run(&base, steps, None)?;
        let units = self.residual_units(&outcome.conditions);
        let n = outcome.residual.len();
        let residual = DVector::from_fn(n, |i, _| outcome.residual[i].value / units[i]);
        let matrix = DMatrix::from_fn(n, unknowns.len(), |i, j| outcome.residual[i].slopes[j] / units[i]);
        Ok((residual, matrix))
    }
}

/// A converged point of Newton's method.
struct Found {
    unknowns: Vec<f64>,
    steps: Steps,
    determinant: f64,
    iterations: usize,
    lu: LU<f64, Dyn, Dyn>,
}

impl<'a> BundleSolver<'a> {
    /// A solver with a tolerance of 1e-8 for one step.
    #[must_use]
    pub fn new(bundle: &'a Bundle) -> Self {
        Self { bundle, tolerance: 1e-8, stretch: false, rest: None }
    }

    /// All motors held, no load.
    #[must_use]
    pub fn held(&self) -> BundleCommand {
        BundleCommand { drives: vec![TubeDrive::HELD; self.bundle.tubes.len()], loads: Loads::none() }
    }

    /// Solves for the equilibrium under a command, from rest: in one go, and where that does not arrive at a stable one in steps.
    pub fn solve(&mut self, command: &BundleCommand) -> BundleEquilibrium {
        let rest = match self.rest.take() {
            Some(rest) => rest,
            None => match self.find_rest() {
                Some(rest) => rest,
                None => return Self::lost(command),
            },
        };
        let result = self.solve_from(command, &rest);
        self.rest = Some(rest);
        result
    }

    /// All motors held, no load. Where tubes are curved when free that is a solve of its own.
    fn find_rest(&self) -> Option<BundleEquilibrium> {
        let held = self.held();
        let frame = Frame::new(self.bundle, &held, self.stretch);
        let found = self.newton(&frame, frame.scaled(&Unknowns::default()), ITERATIONS).ok()?;
        Some(self.conclude(&frame, &held, found, 1.0))
    }

    /// The determinant of the conditions at rest, for the kinds of drives and loads of a command.
    fn rest_determinant(&self, command: &BundleCommand, rest: &Unknowns) -> f64 {
        let still = command.between(&self.held(), 0.0);
        let frame = Frame::new(self.bundle, &still, self.stretch);
        self.newton(&frame, frame.scaled(rest), ITERATIONS).map_or(f64::NAN, |found| found.determinant)
    }

    fn lost(command: &BundleCommand) -> BundleEquilibrium {
        BundleEquilibrium {
            converged: false,
            efforts: Vec::new(),
            tip: Vector3::zeros(),
            frame: Matrix3::identity(),
            length: 0.0,
            stable: false,
            steps: 0,
            iterations: 0,
            error: [f64::NAN; 2],
            unknowns: Unknowns::default(),
            command: command.clone(),
        }
    }

    /// The same from a neighbour.
    #[must_use]
    pub fn solve_from(&self, command: &BundleCommand, start: &BundleEquilibrium) -> BundleEquilibrium {
        let frame = Frame::new(self.bundle, command, self.stretch);
        let rest = self.rest.as_ref().map_or(&start.unknowns, |rest| &rest.unknowns);
        let reference = self.rest_determinant(command, rest);
        let direct = self.newton(&frame, frame.scaled(&start.unknowns), ITERATIONS).ok();
        if let Some(found) = &direct
            && found.determinant / reference > 0.0
        {
            return direct
                .map_or_else(|| Self::lost(command), |f| self.conclude(&frame, command, f, reference));
        }
        let found = self.in_steps(command, start, reference).or(direct);
        found.map_or_else(|| Self::lost(command), |f| self.conclude(&frame, command, f, reference))
    }

    /// Moves from a neighbour to the command in steps that halve where Newton's method does not arrive at an equilibrium as stable as
    /// the last, and begin where the last two point.
    fn in_steps(&self, command: &BundleCommand, start: &BundleEquilibrium, reference: f64) -> Option<Found> {
        let (mut reached, mut step) = (0.0, 0.25);
        let still = command.between(&start.command, 0.0);
        let begin = Frame::new(self.bundle, &still, self.stretch);
        let mut last: (f64, Vec<f64>) = (0.0, begin.scaled(&start.unknowns));
        let mut before: Option<(f64, Vec<f64>)> = None;
        for _ in 0..MOST_STEPS {
            let next = f64::min(1.0, reached + step);
            let target = command.between(&start.command, next);
            let frame = Frame::new(self.bundle, &target, self.stretch);
            let mut guess = last.1.clone();
            if let Some((share, values)) = before.as_ref().filter(|b| b.1.len() == guess.len()) {
                let ahead = (next - last.0) / (last.0 - share);
                for (g, b) in guess.iter_mut().zip(values) {
                    *g += ahead * (*g - b);
                }
            }
            let arrived = (guess.len() == frame.count())
                .then(|| self.newton(&frame, guess, ITERATIONS_IN_STEPS).ok())
                .flatten()
                .filter(|found| found.determinant / reference > 0.0);
            match arrived {
                Some(found) if next >= 1.0 => return Some(found),
                Some(found) => {
                    reached = next;
                    step *= if found.iterations <= EASY { 2.0 } else { 1.0 };
                    before = Some(std::mem::replace(&mut last, (next, found.unknowns)));
                }
                None => {
                    step *= 0.5;
                    if step < SHORTEST_STEP {
                        return None;
                    }
                }
            }
        }
        None
    }

    fn newton(&self, frame: &Frame, start: Vec<f64>, most: usize) -> Result<Found, Lost> {
        let mut unknowns = start;
        let mut steps = Steps::default();
        let mut iterations = 0;
        let (mut residual, mut matrix) = frame.tangent(&unknowns, self.tolerance, &mut steps)?;
        loop {
            let lu = matrix.clone().lu();
            let step = lu.solve(&(-&residual)).ok_or(Lost::Section)?;
            let size = step.amax();
            if !size.is_finite() || iterations >= most {
                return Err(Lost::Steps);
            }
            iterations += 1;
            if size <= SETTLED {
                let determinant = lu.determinant();
                for (u, s) in unknowns.iter_mut().zip(step.iter()) {
                    *u += s;
                }
                return Ok(Found { unknowns, steps, determinant, iterations, lu });
            }
            let mut factor = f64::min(1.0, LONGEST / size);
            loop {
                let trial: Vec<f64> = unknowns.iter().zip(step.iter()).map(|(u, s)| u + factor * s).collect();
                let mut trial_steps = steps.clone();
                if let Ok(there) = frame.residual(&trial, self.tolerance, &mut trial_steps)
                    && let Some(correction) = lu.solve(&there)
                    && correction.norm() <= (1.0 - 0.25 * factor) * step.norm()
                {
                    unknowns = trial;
                    break;
                }
                factor *= 0.5;
                if factor < 1e-4 {
                    return Err(Lost::Steps);
                }
            }
            // Steps are chosen anew until the iteration is near its end.
            if size > 1e-2 {
                steps.forget();
            }
            (residual, matrix) = frame.tangent(&unknowns, self.tolerance, &mut steps)?;
        }
    }

    fn conclude(
        &self,
        frame: &Frame,
        command: &BundleCommand,
        found: Found,
        reference: f64,
    ) -> BundleEquilibrium {
        // The pose may ask for shorter steps than what the conditions needed.
        let mut steps = if frame.prepared.loaded { found.steps } else { Steps::default() };
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let base = frame.base(&found.unknowns, &frame.drives());
        let Ok(outcome) = walk.run(&base, &mut steps, None) else {
            return Self::lost(command);
        };
        let error = Self::error(frame, &walk, &found.unknowns, &found.lu, &steps, &outcome);
        let efforts = base.tubes.iter().map(|t| TubeEffort {
            label: t.label,
            rotation: t.angle,
            force: t.tension,
            torque: -t.torque,
        });
        BundleEquilibrium {
            converged: true,
            efforts: efforts.collect(),
            tip: Vector3::from(outcome.centre),
            frame: section_frame(&outcome),
            length: outcome.length,
            stable: found.determinant / reference > 0.0,
            steps: steps.count(),
            iterations: found.iterations,
            error,
            unknowns: frame.unknowns(&found.unknowns),
            command: command.clone(),
        }
    }

    /// How far the tip (m) and the greatest of the forces (N) move when every step of the integration is halved.
    fn error(
        frame: &Frame,
        walk: &Walk,
        unknowns: &[f64],
        lu: &LU<f64, Dyn, Dyn>,
        steps: &Steps,
        outcome: &Outcome<f64>,
    ) -> [f64; 2] {
        let half = |unknowns: &[f64]| {
            walk.run(&frame.base(unknowns, &frame.drives()), &mut steps.halved(), None).ok()
        };
        let finer = half(unknowns).and_then(|finer| {
            let units = frame.residual_units(&finer.conditions);
            let left = finer.residual.iter().zip(&units).map(|(r, u)| -r / u);
            lu.solve(&DVector::from_iterator(units.len(), left))
        });
        let Some(change) = finer else { return [f64::NAN; 2] };
        let moved: Vec<f64> = unknowns.iter().zip(change.iter()).map(|(u, c)| u + c).collect();
        let Some(there) = half(&moved) else { return [f64::NAN; 2] };
        let tip = (Vector3::from(there.centre) - Vector3::from(outcome.centre)).norm();
        let (before, after) = (frame.unknowns(unknowns), frame.unknowns(&moved));
        let force =
            before.tubes.iter().zip(&after.tubes).fold(0.0, |m: f64, (a, b)| m.max((a[1] - b[1]).abs()));
        [tip, force]
    }

    /// Gives the walk and its start at an equilibrium.
    pub(super) fn with_walk<T>(
        &self,
        equilibrium: &BundleEquilibrium,
        look: impl FnOnce(Walk, &Base<f64>) -> T,
    ) -> T {
        let frame = Frame::new(self.bundle, &equilibrium.command, self.stretch);
        let base = frame.base(&frame.scaled(&equilibrium.unknowns), &frame.drives());
        look(frame.walk(self.tolerance), &base)
    }

    /// Slopes of the tip by the motors: rows position (m) and rotation about the world axes (rad), columns translation and rotation of
    /// every tube's motor, by what is prescribed there. `None` where the equilibrium is a fold.
    #[must_use]
    pub fn tip_jacobian(&self, equilibrium: &BundleEquilibrium) -> Option<DMatrix<f64>> {
        let frame = Frame::new(self.bundle, &equilibrium.command, self.stretch);
        match frame.count() + 2 * self.bundle.tubes.len() {
            0..=8 => self.jacobian_with::<8>(&frame, equilibrium),
            9..=12 => self.jacobian_with::<12>(&frame, equilibrium),
            13..=16 => self.jacobian_with::<16>(&frame, equilibrium),
            17..=24 => self.jacobian_with::<24>(&frame, equilibrium),
            25..=MOST => self.jacobian_with::<MOST>(&frame, equilibrium),
            _ => None,
        }
    }

    fn jacobian_with<const P: usize>(
        &self,
        frame: &Frame,
        equilibrium: &BundleEquilibrium,
    ) -> Option<DMatrix<f64>> {
        let unknowns = frame.scaled(&equilibrium.unknowns);
        let n = unknowns.len();
        let inputs: Vec<Dual<P>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let drives: Vec<[Dual<P>; 2]> = frame
            .drives()
            .iter()
            .enumerate()
            .map(|(i, pair)| [Dual::input(pair[0], n + 2 * i), Dual::input(pair[1], n + 2 * i + 1)])
            .collect();
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let outcome = walk.run(&frame.base(&inputs, &drives), &mut Steps::default(), None).ok()?;
        let motors = 2 * drives.len();
        let by_unknowns = DMatrix::from_fn(n, n, |i, j| outcome.residual[i].slopes[j]);
        let by_motors = DMatrix::from_fn(n, motors, |i, j| -outcome.residual[i].slopes[n + j]);
        let moved = by_unknowns.lu().solve(&by_motors)?;
        let axes = section_axes(&outcome);
        let pose = DMatrix::from_fn(6, n + motors, |i, j| {
            if i < 3 {
                outcome.centre[i].slopes[j]
            } else {
                // ω = ½ Σ axis × axis'.
                let (a, b) = ((i - 2) % 3, (i - 1) % 3);
                axes.iter().map(|v| 0.5 * (v[a].value * v[b].slopes[j] - v[b].value * v[a].slopes[j])).sum()
            }
        });
        Some(pose.columns(n, motors) + pose.columns(0, n) * moved)
    }
}

/// Longest Newton step, in scaled unknowns.
const LONGEST: f64 = 20.0;

/// Tangent, towards the centroid, and across, at the tip.
fn section_axes<S: Number>(outcome: &Outcome<S>) -> [[S; 3]; 3] {
    let [x, y, z] = columns(outcome.turn);
    let (sin, cos) = outcome.angle.sin_cos();
    let axes = [0, 1, 2].map(|i| [y[i] * cos + z[i] * sin, z[i] * cos - y[i] * sin]);
    [x, axes.map(|a| a[0]), axes.map(|a| a[1])]
}

fn section_frame(outcome: &Outcome<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&section_axes(outcome).map(Vector3::from))
}
