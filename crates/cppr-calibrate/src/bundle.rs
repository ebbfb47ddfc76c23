//! What the model of any bundle says to a measurement, and how that changes with the parameters.

use crate::data::{Line, Measurement};
use crate::fit::FitProblem;
use crate::observe::{Found, Observer, STEP, Seen, loads, no_derivative, outputs};
use crate::parameter::Parameter;
use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use cppr::bundle::{Bundle, BundleSection};
use cppr::solve::Drive;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sections between which points are looked for, per length.
const SECTIONS: f64 = 100.0;
/// Equilibria a step apart whose points are farther apart than this part of the length are on different branches.
const BRANCH: f64 = 0.05;
/// Points so near beyond the ends of a line (m) are at its ends: tables are rounded.
const NEAR: f64 = 1e-6;

/// A bundle and, for derivatives, the same with every parameter a step greater and a step less.
pub(crate) struct BundleModel {
    pub bundle: Bundle,
    pub moved: Vec<[Bundle; 2]>,
}

impl BundleModel {
    pub(crate) fn observer<'a>(
        &'a self,
        list: &'a [Parameter],
        stop: Option<&Arc<AtomicBool>>,
    ) -> BundleObserver<'a> {
        let solver = BundleSolver::new;
        let moved = self.moved.iter().map(|[more, less]| [solver(more), solver(less)]).collect();
        BundleObserver { solver: solver(&self.bundle), moved, list, stop: stop.cloned() }
    }
}

pub(crate) struct BundleObserver<'a> {
    solver: BundleSolver<'a>,
    moved: Vec<[BundleSolver<'a>; 2]>,
    list: &'a [Parameter],
    stop: Option<Arc<AtomicBool>>,
}

impl Observer for BundleObserver<'_> {
    fn see(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Seen, FitProblem> {
        if self.stop.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            return Err(FitProblem::Stopped);
        }
        let bundle = self.solver.bundle();
        let command = command(m, bundle.tube_count());
        let refuse = |why: String| FitProblem::Measurement(m.row, why);
        if let Some((tube, label)) = bundle.joint_behind_plate(&command.drives) {
            let (tube, label) = (tube + 1, label * 1e3);
            return Err(refuse(format!("the joint at {label} mm of tube {tube} would lie behind the plate")));
        }
        let near = match start {
            Some(Found::Bundle(start)) => Some(self.solver.solve_from(&command, start)),
            _ => None,
        };
        // Now and then none is found from so near, but from rest.
        let found = near.filter(|near| near.converged).unwrap_or_else(|| self.solver.solve(&command));
        if !found.converged {
            return Err(FitProblem::NoEquilibrium(m.row, found.verdict()));
        }
        let outputs = observe(m, &self.solver, &found).map_err(refuse)?;
        let mut slopes = Vec::new();
        for (pair, parameter) in self.moved.iter_mut().zip(self.list) {
            let mut slope = [0.0; 6];
            for (solver, side) in pair.iter_mut().zip([1.0, -1.0]) {
                let near = solver.continued(&command, &found).unwrap_or_else(|| solver.solve(&command));
                let values = if near.converged { observe(m, solver, &near).ok() } else { None };
                let same_branch = |values: &[f64; 6]| {
                    (0..3).all(|axis| (values[axis] - outputs[axis]).abs() < BRANCH * found.length)
                };
                let values = values.filter(same_branch).ok_or_else(|| no_derivative(m, *parameter))?;
                for (own, value) in slope.iter_mut().zip(values) {
                    *own += side * value / (2.0 * STEP);
                }
            }
            slopes.push(slope);
        }
        Ok(Seen { outputs, slopes, found: Found::Bundle(Box::new(found)) })
    }
}

fn command(m: &Measurement, tubes: usize) -> BundleCommand {
    let drives = (0..tubes)
        .map(|k| TubeDrive {
            translation: Drive::Motion(m.pulls[k]),
            rotation: Drive::Motion(m.rotations[k]),
        })
        .collect();
    BundleCommand { drives, loads: loads(m) }
}

/// The model's point and direction for a measurement, or why there is none.
fn observe(
    m: &Measurement,
    solver: &BundleSolver<'_>,
    found: &BundleEquilibrium,
) -> Result<[f64; 6], String> {
    if m.line == Line::Centre && m.at.is_none() {
        return Ok(outputs(found.tip, found.frame.column(0).into()));
    }
    let shape = solver.shape(found, found.length / SECTIONS);
    // Abscissa, section, and how far from its centre the line is.
    let rows: Vec<(f64, &BundleSection, Vector3<f64>)> = match m.line {
        Line::Centre => shape.iter().map(|s| (s.length, s, Vector3::zeros())).collect(),
        Line::Tube(tube) => {
            let own = |s| Some((s, BundleSection::tube(s, tube)?));
            shape.iter().filter_map(own).map(|(s, own)| (own.label, s, s.offset(own))).collect()
        }
    };
    let (Some(&(first, ..)), Some(&(last, end, offset))) = (rows.first(), rows.last()) else {
        return Err("the whole tube is behind the plate".into());
    };
    let Some(at) = m.at else { return Ok(outputs(end.centre + offset, end.frame.column(0).into())) };
    if !(first - NEAR..=last + NEAR).contains(&at) {
        let [at, first, last] = [at, first, last].map(|v| v * 1e3);
        return Err(format!("at_mm is {at}, but this line goes from {first:.3} to {last:.3} mm"));
    }
    let next = rows.partition_point(|row| row.0 < at).clamp(1, rows.len().max(2) - 1);
    let (Some((from, a, here)), Some((to, b, there))) = (rows.get(next - 1), rows.get(next)) else {
        return Ok(outputs(end.centre + offset, end.frame.column(0).into()));
    };
    let share = if to > from { ((at - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    let [centre, tangent] = a.towards(b, share);
    Ok(outputs(centre + here.lerp(there, share), tangent))
}
