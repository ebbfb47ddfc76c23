//! Actuator values under which the centreline passes through given points: least squares over their distances.
//!
//! A point with a label X is compared with the centre there; one without, with the nearest place of the centreline, so that
//! only its distance across the line counts. Distances are divided by each point's standard deviation.

use super::least_squares::{Evaluated, minimise};
use super::uncertainty::Uncertainty;
use super::{FreeInput, InverseProblem, STARTS, Search, check, farthest};
use crate::analysis::model::Model;
use crate::solve::{Command, Equilibrium, Input, Solver};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A point on the centreline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePoint {
    /// Label X of its section, where it is known (m).
    pub label: Option<f64>,
    /// Base frame (m).
    pub position: Vector3<f64>,
    /// Standard deviation of each coordinate (m).
    pub deviation: f64,
}

/// Answer to a set of points.
#[derive(Clone, Debug)]
pub struct ShapeMatch<E = Equilibrium> {
    /// Value of each free input (m, rad, N or N m).
    pub values: Vec<f64>,
    /// Uncertainty of the values.
    pub uncertainty: Uncertainty,
    /// Is the value at its lower or upper bound?
    pub at_bound: Vec<bool>,
    /// The equilibrium, with the whole command.
    pub equilibrium: E,
    /// Distance of every point from its place on the centreline (m).
    pub distances: Vec<f64>,
    /// Root mean square of the distances (m).
    pub rms: f64,
}

/// Farther than so many standard deviations beyond the robot's reach no point lies by chance.
const DEVIATIONS: f64 = 5.0;
/// Points that are all nearer to the baseplate than this part of the length show nothing: they are given in another unit.
const SLIP: f64 = 0.01;
/// Sections among which the nearest place is looked for, less one.
const SPACES: u32 = 100;

impl Solver {
    /// Values of the free inputs for which the centreline is nearest to the points; all other inputs and the loads are those
    /// of `command`.
    ///
    /// # Errors
    /// Where nothing can be searched for.
    pub fn shape_match(
        &mut self,
        command: &Command,
        free: &[FreeInput],
        points: &[ShapePoint],
    ) -> Result<ShapeMatch, InverseProblem> {
        self.check(command).map_err(InverseProblem::Command)?;
        shape_match(self, command, free, points)
    }
}

/// Values of the free inputs for which the centreline of any robot is nearest to the points.
pub(in crate::analysis) fn shape_match<M: Model>(
    model: &mut M,
    command: &M::Command,
    free: &[FreeInput],
    points: &[ShapePoint],
) -> Result<ShapeMatch<M::Found>, InverseProblem> {
    check::<M>(command, free)?;
    if points.is_empty() {
        return Err(InverseProblem::NothingGiven);
    }
    check_points(points, model.length())?;
    // A point without label says nothing along the line.
    let numbers: usize = points.iter().map(|p| if p.label.is_some() { 3 } else { 2 }).sum();
    if numbers < free.len() {
        return Err(InverseProblem::TooFew(numbers, free.len()));
    }
    let mut search = Search { model, command, free };
    let (units, bounds) = (search.units(), search.bounds());
    let starts = search.scout(STARTS, |search, found| places(search, points, found).residual(points).norm());
    let mut best: Option<(f64, DVector<f64>, Evaluated<M::Found>)> = None;
    for (_, values, found) in starts {
        let Some(first) = evaluated(&mut search, found, points) else { continue };
        let outcome = minimise(values, first, &bounds, &units, |values, near| {
            let found = search.at(values, Some(near))?;
            evaluated(&mut search, found, points)
        });
        let left = outcome.best.residual.norm();
        if best.as_ref().is_none_or(|b| left < b.0) {
            best = Some((left, outcome.values, outcome.best));
        }
    }
    let (_, values, best) = search.unless_stopped(best)?;
    let at_end = places(&mut search, points, &best.state);
    let distances: Vec<f64> =
        at_end.offsets.iter().zip(&at_end.across).map(|(offset, across)| (across * offset).norm()).collect();
    let uncertainty = Uncertainty::new(&best.residual, &best.jacobian, numbers, &units);
    Ok(ShapeMatch {
        at_bound: bounds
            .iter()
            .zip(values.iter())
            .map(|([low, high], v)| (v - low).min(high - v) <= 1e-6 * (high - low))
            .collect(),
        values: values.as_slice().to_vec(),
        uncertainty,
        equilibrium: best.state,
        rms: (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt(),
        distances,
    })
}

/// Are the points finite, and where a robot of this length may be?
fn check_points(points: &[ShapePoint], length: f64) -> Result<(), InverseProblem> {
    for (point, number) in points.iter().zip(1..) {
        let finite = point.position.iter().all(|c| c.is_finite());
        if !(finite && point.deviation.is_finite() && point.deviation > 0.0) {
            return Err(InverseProblem::NotFinite("a point"));
        }
        if let Some(label) = point.label.filter(|x| !(0.0..=length * (1.0 + 1e-9)).contains(x)) {
            return Err(InverseProblem::Label(label));
        }
        let distance = point.position.norm();
        if distance > farthest(point.label.unwrap_or(length), length) + DEVIATIONS * point.deviation {
            return Err(InverseProblem::Beyond { point: number, distance, length });
        }
    }
    let distance = points.iter().map(|p| p.position.norm()).fold(0.0, f64::max);
    let looked_at = |p: &ShapePoint| p.label.is_none_or(|x| x > SLIP * length);
    if distance < SLIP * length && points.iter().any(looked_at) {
        return Err(InverseProblem::AllAtPlate { distance, length });
    }
    Ok(())
}

/// Where the points lie against the centreline.
struct Places {
    labels: Vec<f64>,
    /// Centre minus point (m).
    offsets: Vec<Vector3<f64>>,
    /// What of an offset counts.
    across: Vec<Matrix3<f64>>,
}

impl Places {
    fn residual(&self, points: &[ShapePoint]) -> DVector<f64> {
        let weighted = self
            .offsets
            .iter()
            .zip(&self.across)
            .zip(points)
            .map(|((d, across), p)| across * d / p.deviation);
        DVector::from_iterator(3 * points.len(), weighted.flat_map(|v| [v.x, v.y, v.z]))
    }
}

fn places<M: Model>(search: &mut Search<M>, points: &[ShapePoint], found: &M::Found) -> Places {
    let model = &mut *search.model;
    let length = model.length();
    let known = points.iter().all(|p| p.label.is_some());
    let line: Vec<(f64, Vector3<f64>)> = if known {
        Vec::new()
    } else {
        let samples: Vec<f64> = (0..=SPACES).map(|i| length * f64::from(i) / f64::from(SPACES)).collect();
        let places = model.places(found, &samples);
        samples.iter().zip(&places).map(|(label, [centre, _])| (*label, *centre)).collect()
    };
    let labels: Vec<f64> = points
        .iter()
        .map(|p| p.label.map_or_else(|| nearest(&line, &p.position), |x| x.min(length)))
        .collect();
    let sections = model.places(found, &labels);
    let offsets = sections.iter().zip(points).map(|([centre, _], p)| centre - p.position).collect();
    let across = sections.iter().zip(&labels).zip(points).map(|(([_, tangent], label), point)| {
        // At the ends a point may lie beyond the line.
        let inside = *label > 0.0 && *label < length;
        if point.label.is_none() && inside {
            Matrix3::identity() - tangent * tangent.transpose()
        } else {
            Matrix3::identity()
        }
    });
    Places { across: across.collect(), offsets, labels }
}

/// Label of the nearest place on a polyline.
fn nearest(line: &[(f64, Vector3<f64>)], point: &Vector3<f64>) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for pair in line.windows(2) {
        let ((a, from), (b, to)) = (pair[0], pair[1]);
        let way = to - from;
        let share = ((point - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        let distance = (from + way * share - point).norm();
        if distance < best.0 {
            best = (distance, a + share * (b - a));
        }
    }
    best.1
}

fn evaluated<M: Model>(
    search: &mut Search<M>,
    found: M::Found,
    points: &[ShapePoint],
) -> Option<Evaluated<M::Found>> {
    let here = places(search, points, &found);
    let inputs: Vec<Input> = search.free.iter().map(|free| free.input).collect();
    let own = search.model.place_slopes(&found, &here.labels, &inputs)?;
    let mut jacobian = DMatrix::zeros(3 * points.len(), own.ncols());
    for (i, (across, point)) in here.across.iter().zip(points).enumerate() {
        let block = across * own.fixed_rows::<3>(3 * i) / point.deviation;
        jacobian.fixed_rows_mut::<3>(3 * i).copy_from(&block);
    }
    Some(Evaluated { residual: here.residual(points), jacobian, state: found })
}
