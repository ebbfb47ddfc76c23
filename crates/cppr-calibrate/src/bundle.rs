//! What the model of any bundle says to measurements, and how that changes with the parameters.

use crate::data::{Driven, Line, Measurement};
use crate::fit::FitProblem;
use crate::observe::{Found, Observer, no_derivative, numbers};
use crate::parameter::Parameter;
use cppr::Vector3;
use cppr::analysis::{BundleAnalysis, Teeth, absurd_bundle_demand};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort};
use cppr::bundle::{Bundle, BundleDesign, BundleSection, Friction, Slip};
use cppr::solve::Freedom;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sections between which points are looked for, per length.
const SECTIONS: f64 = 100.0;
/// Equilibria a step apart whose tips are farther apart than this part of the length are on different branches.
const BRANCH: f64 = 0.05;
/// Points so near beyond the ends of a line (m) are at its ends: tables are rounded.
const NEAR: f64 = 1e-6;

/// A bundle at some values of the parameters, and how its tubes rub.
pub(crate) struct State {
    pub bundle: Bundle,
    pub friction: Option<Friction>,
}

/// A bundle and, for derivatives, the same with every parameter changed.
pub(crate) struct BundleModel {
    pub design: BundleDesign,
    /// Are places told by the leader's label, as of robots whose tubes are of one length?
    pub by_leader: bool,
    pub own: State,
    /// For every parameter, the states and how far (in what the search moves) they lie from the bundle's own.
    pub moved: Vec<Vec<(State, f64)>>,
}

impl BundleModel {
    pub(crate) fn observer<'a>(
        &'a self,
        list: &'a [Parameter],
        stop: Option<&Arc<AtomicBool>>,
    ) -> BundleObserver<'a> {
        let solver = BundleSolver::new(&self.own.bundle);
        BundleObserver { model: self, solver, list, stop: stop.cloned() }
    }
}

pub(crate) struct BundleObserver<'a> {
    model: &'a BundleModel,
    solver: BundleSolver<'a>,
    list: &'a [Parameter],
    stop: Option<Arc<AtomicBool>>,
}

impl BundleObserver<'_> {
    fn look(&self) -> Result<(), FitProblem> {
        let stopped = self.stop.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed));
        if stopped { Err(FitProblem::Stopped) } else { Ok(()) }
    }
}

impl Observer for BundleObserver<'_> {
    fn solve(&mut self, m: &Measurement, start: Option<&Found>) -> Result<Found, FitProblem> {
        self.look()?;
        let bundle = self.solver.bundle();
        let command = command(m, bundle.tube_count());
        let refuse = |why: String| FitProblem::Measurement(m.row, why);
        if let Some((tube, label)) = bundle.joint_behind_plate(&command.drives) {
            let (tube, label) = (tube + 1, label * 1e3);
            return Err(refuse(format!("the joint at {label} mm of tube {tube} would lie behind the plate")));
        }
        if let Some(demand) = absurd_bundle_demand(bundle, &command) {
            return Err(refuse(demand.to_string()));
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
        Ok(Found::Bundle(Box::new(found)))
    }

    fn read(&mut self, pose: &[Measurement], found: &Found) -> Result<Vec<f64>, FitProblem> {
        self.look()?;
        let Found::Bundle(found) = found else { return Ok(Vec::new()) };
        read(pose, &self.solver, found, self.model.own.friction, self.model.by_leader)
    }

    fn slopes(
        &mut self,
        pose: &[Measurement],
        found: &Found,
        outputs: &[f64],
    ) -> Result<Vec<Vec<f64>>, FitProblem> {
        let Found::Bundle(found) = found else { return Ok(Vec::new()) };
        let mut slopes = Vec::new();
        for (states, parameter) in self.model.moved.iter().zip(self.list) {
            self.look()?;
            let mut sides = vec![(outputs.to_vec(), 0.0)];
            for (state, by) in states {
                let mut solver = self.solver.of_another(&state.bundle);
                let near =
                    solver.continued(found.command(), found).unwrap_or_else(|| solver.solve(found.command()));
                let same_branch = near.converged && (near.tip - found.tip).norm() < BRANCH * found.length;
                let read = || read(pose, &solver, &near, state.friction, self.model.by_leader).ok();
                let values = if same_branch { read() } else { None };
                sides.push((values.ok_or_else(|| no_derivative(&pose[0], *parameter))?, *by));
            }
            // Between both sides, or from the bundle to the only one.
            let [(from, at), (to, end)] = [&sides[sides.len() - 2], &sides[sides.len() - 1]];
            slopes.push(from.iter().zip(to).map(|(a, b)| (b - a) / (end - at)).collect());
        }
        Ok(slopes)
    }

    fn strains(&self, found: &Found, tube: Option<usize>) -> [f64; 2] {
        let Found::Bundle(found) = found else { return [0.0; 2] };
        let analysis = BundleAnalysis::new(self.solver.clone(), &self.model.design);
        [Teeth::Bending, Teeth::Rigid].map(|teeth| {
            let limits = analysis.section_limits(found, teeth);
            let own = limits.iter().filter(|limit| tube.is_none_or(|tube| limit.tube == tube));
            own.fold(0.0, |most: f64, limit| most.max(limit.strain.abs()))
        })
    }
}

fn command(m: &Measurement, tubes: usize) -> BundleCommand {
    BundleCommand { drives: m.drives[..tubes].to_vec(), loads: m.loads() }
}

/// All numbers of the measurements of one pose, as friction leaves it.
fn read(
    pose: &[Measurement],
    solver: &BundleSolver<'_>,
    found: &BundleEquilibrium,
    friction: Option<Friction>,
    by_leader: bool,
) -> Result<Vec<f64>, FitProblem> {
    let m = &pose[0];
    let all = |solver: &BundleSolver<'_>, found: &BundleEquilibrium, efforts: &[TubeEffort]| {
        let one = |m: &Measurement| {
            let place = place(m, solver, found, by_leader);
            let [point, direction] = place.map_err(|why| FitProblem::Measurement(m.row, why))?;
            Ok(numbers(m, point, direction, |tube, freedom| match freedom {
                Freedom::PushPull => efforts[tube].force,
                Freedom::Rotation => efforts[tube].torque,
            }))
        };
        Ok(pose.iter().map(one).collect::<Result<Vec<_>, _>>()?.concat())
    };
    let Some((friction, way)) = friction.filter(|own| own.coefficient > 0.0).zip(m.driven) else {
        return all(solver, found, &found.efforts);
    };
    let coefficient = friction.coefficient;
    let none = || {
        let why = format!(
            "no equilibrium with full slip was found with a coefficient of friction of {coefficient:.3}"
        );
        FitProblem::NoEquilibrium(m.row, why)
    };
    let slip = if way == Driven::On { Slip::Loading } else { Slip::Unloading };
    let rubbed = solver.full_slip_of(found, &friction, slip).ok_or_else(none)?;
    all(&solver.of_another(&rubbed.bundle), &rubbed.equilibrium, &rubbed.efforts)
}

/// Point (m) that a measurement was made at and direction of the axis there, or why there is none.
fn place(
    m: &Measurement,
    solver: &BundleSolver<'_>,
    found: &BundleEquilibrium,
    by_leader: bool,
) -> Result<[Vector3<f64>; 2], String> {
    if m.line == Line::Centre && m.at.is_none() {
        return Ok([found.tip, found.frame.column(0).into()]);
    }
    let shape = solver.shape(found, found.length / SECTIONS);
    // Abscissa, section, and how far from its centre the line is.
    let row = |section| {
        let on_leader = || BundleSection::tube(section, 0).map(|own| own.label);
        let (own, offset) = match m.line {
            Line::Centre => (section.length, Vector3::zeros()),
            Line::Tube(tube) => {
                let own = section.tube(tube)?;
                (own.label, section.offset(own))
            }
        };
        Some((if by_leader { on_leader()? } else { own }, section, offset))
    };
    let rows: Vec<(f64, &BundleSection, Vector3<f64>)> = shape.iter().filter_map(row).collect();
    let (Some(&(first, ..)), Some(&(last, end, offset))) = (rows.first(), rows.last()) else {
        return Err("the whole tube is behind the plate".into());
    };
    let Some(at) = m.at else { return Ok([end.centre + offset, end.frame.column(0).into()]) };
    if !(first - NEAR..=last + NEAR).contains(&at) {
        let [at, first, last] = [at, first, last].map(|v| v * 1e3);
        return Err(format!("at_mm is {at}, but this line goes from {first:.3} to {last:.3} mm"));
    }
    let next = rows.partition_point(|row| row.0 < at).clamp(1, rows.len().max(2) - 1);
    let (Some((from, a, here)), Some((to, b, there))) = (rows.get(next - 1), rows.get(next)) else {
        return Ok([end.centre + offset, end.frame.column(0).into()]);
    };
    let share = if to > from { ((at - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    let [centre, tangent] = a.towards(b, share);
    Ok([centre + here.lerp(there, share), tangent])
}
