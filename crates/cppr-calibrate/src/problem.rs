//! The model beside the measurements: differences and their derivatives, wherever the search is.

use crate::clearance::{ClearanceModel, Loose};
use crate::data::{Driven, Measurement, Observed};
use crate::design::Design;
use crate::fit::FitProblem;
use crate::observe::{Found, Model, Observer, settings_for};
use crate::parameter::{Parameter, ParameterKind, Values};
use cppr::solve::Settings;
use nalgebra::{DMatrix, DVector};
use std::cell::Cell;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Neighbouring measurements of the same robot in the same pose: which robot, and which.
pub(crate) fn poses(measurements: &[Measurement], groups: &[usize]) -> Vec<(usize, Range<usize>)> {
    let mut poses: Vec<(usize, Range<usize>)> = Vec::new();
    for (i, (m, group)) in measurements.iter().zip(groups).enumerate() {
        match poses.last_mut() {
            Some((_, last)) if measurements[last.start].is_of_the_pose(m) => last.end = i + 1,
            _ => poses.push((*group, i..i + 1)),
        }
    }
    poses
}

pub(crate) struct Problem<'a> {
    pub designs: &'a [Design],
    pub measurements: &'a [Measurement],
    /// Robot and measurements of every pose.
    pub poses: Vec<(usize, Range<usize>)>,
    pub start: Values<'a>,
    /// Of every robot's solver.
    pub settings: Vec<Settings>,
    pub stop: Option<Arc<AtomicBool>>,
    pub evaluations: Cell<usize>,
}

/// The model beside the measurements.
#[derive(Clone)]
pub(crate) struct Evaluation {
    /// Where the search is: logarithms of the values over the start, or differences in units of their own.
    pub place: DVector<f64>,
    /// The model's numbers less those measured, in the order of the measurements, and over their standard deviations.
    pub differences: Vec<f64>,
    pub weighted: DVector<f64>,
    /// One per pose.
    pub found: Vec<Found>,
}

impl Evaluation {
    /// Sum of the squares that is to be least.
    pub fn squares(&self) -> f64 {
        self.weighted.norm_squared()
    }

    /// Row, what, and model less measurement.
    pub fn plain(&self, measurements: &[Measurement]) -> Vec<(usize, Observed, f64)> {
        let numbers = measurements.iter().flat_map(|m| m.numbers().into_iter().map(|n| (m.row, n.0)));
        numbers.zip(&self.differences).map(|((row, what), difference)| (row, what, *difference)).collect()
    }
}

/// Measurements of a robot that are looked at for the error of the model, at most.
const LOOKED_AT: usize = 8;
/// What to do where the search runs astray.
const CHECK: &str = "Check the frame and the units of the data, and begin nearer to the truth";

impl Problem<'_> {
    pub fn values(&self, place: &DVector<f64>) -> Values<'_> {
        let own = self.start.list.iter().zip(&self.start.numbers).zip(place.iter());
        let numbers = own.map(|((p, start), moved)| p.value(*start, *moved)).collect();
        Values { numbers, ..self.start.clone() }
    }

    /// Bounds of where the search may go.
    pub fn bounds(&self, place: &DVector<f64>) -> Vec<[f64; 2]> {
        let values = self.values(place);
        let designs: Vec<Design> = self.designs.iter().map(|d| values.design(d)).collect();
        let own = self.start.list.iter().zip(&self.start.numbers);
        own.map(|(p, start)| p.bounds(&designs).map(|bound| p.place(*start, bound))).collect()
    }

    /// Poses of a robot that are looked at for the error, the first and the last among them.
    fn looked_at(&self, group: usize) -> Vec<usize> {
        let own: Vec<usize> = (0..self.poses.len()).filter(|pose| self.poses[*pose].0 == group).collect();
        let last = own.len().saturating_sub(1);
        let mut places: Vec<usize> = (0..LOOKED_AT).map(|i| i * last / (LOOKED_AT - 1)).collect();
        places.dedup();
        places.into_iter().filter_map(|place| own.get(place).copied()).collect()
    }

    /// Settings with which every robot's solver resolves the measurements that are looked at, with the values at the start.
    pub fn settings_found(&self) -> Result<Vec<Settings>, FitProblem> {
        let one = |(group, design): (usize, &Design)| {
            let poses = self.looked_at(group).into_iter();
            let measurements: Vec<_> =
                poses.map(|pose| &self.measurements[self.poses[pose].1.start]).collect();
            Ok(match Model::new(design, &self.start, false)? {
                Model::Robot(robot, _)
                | Model::Clearance(ClearanceModel { own: Loose { robot, .. }, .. }) => {
                    settings_for(&robot, &measurements, self.stop.as_ref())
                }
                Model::Bundle(_) => Settings::default(),
            })
        };
        self.designs.iter().enumerate().map(one).collect()
    }

    /// Greatest error of the tip, as a part of the length, of the equilibria that are looked at, and of how many it is known.
    pub fn accuracy(&self, at: &Evaluation) -> (f64, usize) {
        let looked_at = (0..self.designs.len()).flat_map(|group| self.looked_at(group));
        let errors = looked_at.filter_map(|pose| at.found[pose].error().filter(|own| own.is_finite()));
        errors.fold((0.0, 0), |(most, known), own| (most.max(own), known + 1))
    }

    fn models(&self, values: &Values<'_>, derivatives: bool) -> Result<Vec<Model>, FitProblem> {
        self.designs.iter().map(|d| Model::new(d, values, derivatives)).collect()
    }

    fn observers<'a>(&'a self, models: &'a [Model]) -> Vec<Box<dyn Observer + 'a>> {
        let own = models.iter().zip(&self.settings);
        own.map(|(model, settings)| model.observer(self.start.list, *settings, self.stop.as_ref())).collect()
    }

    /// Compares; from the equilibria of an earlier evaluation, if there is one.
    pub fn evaluate(&self, place: &DVector<f64>, near: Option<&[Found]>) -> Result<Evaluation, FitProblem> {
        self.evaluations.set(self.evaluations.get() + 1);
        let wrong = |problem| self.at(place, problem);
        let models = self.models(&self.values(place), false).map_err(wrong)?;
        let mut observers = self.observers(&models);
        let (mut outputs, mut found) = (Vec::new(), Vec::new());
        for (i, (group, rows)) in self.poses.iter().enumerate() {
            let pose = &self.measurements[rows.clone()];
            let own = observers[*group].solve(&pose[0], near.map(|near| &near[i])).map_err(wrong)?;
            outputs.extend(observers[*group].read(pose, &own).map_err(wrong)?);
            found.push(own);
        }
        let numbers = self.measurements.iter().flat_map(Measurement::numbers);
        let (differences, weighted): (Vec<f64>, Vec<f64>) = numbers
            .zip(outputs)
            .map(|((_, measured, sigma), output)| (output - measured, (output - measured) / sigma))
            .unzip();
        Ok(Evaluation { place: place.clone(), differences, weighted: DVector::from_vec(weighted), found })
    }

    /// Derivatives of the weighted differences by what the search moves.
    pub fn jacobian(&self, at: &Evaluation) -> Result<DMatrix<f64>, FitProblem> {
        let wrong = |problem| self.at(&at.place, problem);
        let models = self.models(&self.values(&at.place), true).map_err(wrong)?;
        let mut observers = self.observers(&models);
        let mut jacobian = DMatrix::zeros(at.weighted.len(), self.start.list.len());
        let mut first = 0;
        for ((group, rows), found) in self.poses.iter().zip(&at.found) {
            let pose = &self.measurements[rows.clone()];
            let numbers: Vec<_> = pose.iter().flat_map(Measurement::numbers).collect();
            let own = numbers.iter().zip(&at.differences[first..]);
            let outputs: Vec<f64> = own.map(|(number, difference)| number.1 + difference).collect();
            let slopes = observers[*group].slopes(pose, found, &outputs).map_err(wrong)?;
            for (p, slopes) in slopes.into_iter().enumerate() {
                for (i, (slope, (.., sigma))) in slopes.into_iter().zip(&numbers).enumerate() {
                    jacobian[(first + i, p)] = slope / sigma;
                }
            }
            first += numbers.len();
        }
        Ok(jacobian)
    }

    /// A problem with the values at which it came up.
    pub fn at(&self, place: &DVector<f64>, problem: FitProblem) -> FitProblem {
        match problem {
            FitProblem::NoEquilibrium(row, why) if self.start.list.is_empty() => {
                FitProblem::NoEquilibrium(row, why)
            }
            FitProblem::NoEquilibrium(row, why) => {
                let own = |(p, v): (&Parameter, &f64)| format!("{p} = {:.3} {}", v / p.unit().1, p.unit().0);
                let at: Vec<String> =
                    self.start.list.iter().zip(&self.values(place).numbers).map(own).collect();
                FitProblem::NoEquilibrium(row, format!("with {}: {why}. {CHECK}", at.join(", ")))
            }
            FitProblem::Search(why) => FitProblem::Search(format!("{why}. {CHECK}")),
            other => other,
        }
    }

    /// Why a combination of parameters is not seen, and what to do.
    pub fn why(&self, at: &Evaluation, combination: &[(Parameter, f64)]) -> String {
        let has = |kinds: &[ParameterKind]| combination.iter().find(|(p, _)| kinds.contains(&p.kind));
        let mut why: Vec<String> = Vec::new();
        let only = |way| self.measurements.iter().all(|m| m.driven == Some(way));
        if has(&[ParameterKind::Friction]).is_some() {
            let told = "which does not tell friction from stiffness: measure with motors driven";
            if only(Driven::On) {
                why.push(format!("All motors were driven on, {told} back as well."));
            } else if only(Driven::Back) {
                why.push(format!("All motors were driven back, {told} on as well."));
            }
        }
        if let Some((parameter, _)) = has(&[ParameterKind::OnsetStrain, ParameterKind::SecondModulus])
            && let Some([least, most]) = self.strains(at, parameter.tube)
        {
            let values = self.values(&at.place);
            let designs: Vec<Design> = self.designs.iter().map(|d| values.design(d)).collect();
            let onset = Parameter { kind: ParameterKind::OnsetStrain, ..*parameter }.present(&designs);
            why.push(format!(
                "The greatest strain in any pose is {:.3} % with teeth that bend as the notches do and {:.3} % with rigid ones, \
                 and the metal softens from {:.3} % on.",
                least * 100.0,
                most * 100.0,
                onset * 100.0
            ));
        }
        if has(&[ParameterKind::Gap]).is_some() {
            why.push(
                "A gap is seen where a tube lies on the wall and comes off it, and acts much as a longer lever does: pull farther, load the robot \
                 across, measure along it, or fit no centroid_offset_factor beside it."
                    .into(),
            );
        }
        let moduli = has(&[ParameterKind::YoungsModulus, ParameterKind::ShearModulus]);
        if has(&[ParameterKind::ToothFactor]).is_some() && moduli.is_some() {
            why.push(
                "Teeth that bend more look like softer metal: tubes of one material whose notches and teeth differ in \
                 length tell them apart, or a known modulus."
                    .into(),
            );
        } else if moduli.is_some() || why.is_empty() {
            why.push(
                "Motions of unloaded robots do not show a common modulus (Remark 19), motions without rotation no \
                 shear modulus. Add loaded or turned measurements, or fit less"
                    .into(),
            );
        }
        why.join(" ")
    }

    fn strains(&self, at: &Evaluation, tube: Option<usize>) -> Option<[f64; 2]> {
        let models = self.models(&self.values(&at.place), false).ok()?;
        let observers = self.observers(&models);
        let own = self.poses.iter().zip(&at.found);
        let strains = own.map(|((group, _), found)| observers[*group].strains(found, tube));
        strains.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }
}
