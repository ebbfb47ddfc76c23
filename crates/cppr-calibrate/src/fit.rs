//! The fit and what it is worth.

use crate::data::{Line, Measurement, Observed};
use crate::design::Design;
use crate::parameter::{Parameter, ParameterKind, ParameterProblem, Values};
use crate::problem::{Evaluation, Problem, poses};
use crate::search::{held, search};
use crate::units;
use cppr::bundle::Friction;
use cppr::bundle::solve::TubeDrive;
use cppr::solve::Settings;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::cell::Cell;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq)]
pub enum FitProblem {
    /// A parameter cannot be fitted.
    Parameter(ParameterProblem),
    /// A measurement does not go with the robots: line of the file and why.
    Measurement(usize, String),
    /// Fewer measured numbers than parameters: both.
    TooFew(usize, usize),
    /// The data do not determine a combination of parameters: its share of each parameter, in relative changes, and the
    /// uncertainty of that combination (-).
    Invisible {
        /// Parameters with their share, largest first, without those below 5 %.
        combination: Vec<(Parameter, f64)>,
        /// Standard deviation of the combination, relative; infinite where the data do not see it at all.
        uncertainty: f64,
        /// Why, in sentences, and what to do.
        why: String,
    },
    /// No equilibrium was found under a measurement's command: line of the file and why.
    NoEquilibrium(usize, String),
    /// The search did not settle: why.
    Search(String),
    /// Another thread has asked for it.
    Stopped,
}

impl fmt::Display for FitProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(problem) => problem.fmt(f),
            Self::Measurement(row, why) | Self::NoEquilibrium(row, why) => write!(f, "line {row}: {why}"),
            Self::TooFew(numbers, parameters) => {
                write!(
                    f,
                    "{numbers} measured numbers cannot determine {parameters} parameters; measure more or fit less"
                )
            }
            Self::Invisible { combination, uncertainty, why } => {
                let parts: Vec<String> =
                    combination.iter().map(|(parameter, share)| format!("{share:+.2} {parameter}")).collect();
                let parts = parts.join(" ");
                let of = combination.iter().filter_map(|(parameter, _)| {
                    let (unit, size) = parameter.unit();
                    let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
                    Some(format!(", of {parameter} by {}{unit}", parameter.full()? / size))
                });
                let of: String = of.collect();
                write!(f, "the data cannot see the combination {parts} (relative changes{of}): ")?;
                if uncertainty.is_finite() {
                    write!(f, "its standard deviation is {:.0} %. ", uncertainty * 100.0)?;
                } else {
                    write!(f, "it changes nothing that was measured. ")?;
                }
                write!(f, "{why}")
            }
            Self::Search(why) => write!(f, "the search for the least squares ended without a result: {why}"),
            Self::Stopped => write!(f, "stopped before the parameters were known"),
        }
    }
}

impl std::error::Error for FitProblem {}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Value (SI).
    pub value: f64,
    /// Value before the fit (SI).
    pub before: f64,
    /// Standard deviation (SI).
    pub deviation: f64,
    /// Half width of the 95 % confidence interval (SI).
    pub interval: f64,
    /// Does it stand at a bound of its values, beyond which the data would be met better?
    pub at_bound: bool,
}

/// One measured number against the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Line of the file.
    pub row: usize,
    /// What was measured.
    pub what: Observed,
    /// Model minus measurement, in the unit of what was measured.
    pub value: f64,
    /// Divided by its own expected deviation after the fit.
    pub studentised: f64,
    /// Improbable: one such residual among all would be expected in less than one of twenty data sets.
    pub outlier: bool,
}

/// Root mean squares of measured bends, or of the efforts of a motor (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misses {
    /// Bend, or an effort.
    pub what: Observed,
    /// Of model minus measurement before the fit.
    pub before: f64,
    /// The same with the fitted values.
    pub fitted: f64,
    /// Of the measured values.
    pub measured: f64,
}

/// Result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// One per parameter, in the order asked for.
    pub estimates: Vec<Estimate>,
    /// Correlation matrix of the estimates, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// Residuals in the order of the file.
    pub residuals: Vec<Residual>,
    /// Root mean square of the weighted residuals: 1 where the stated deviations are right.
    pub scale: f64,
    /// Root mean square distance of the measured points (m); NaN without points.
    pub rms: f64,
    /// The same before the fit.
    pub rms_before: f64,
    /// How far measured bends and efforts are missed.
    pub misses: Vec<Misses>,
    /// Designs with the fitted values.
    pub designs: Vec<Design>,
    /// Greatest error of the model's tip among some measurements, as a part of its length, and among how many it is known; 0 where of none.
    pub accuracy: (f64, usize),
    /// Evaluations of all equilibria.
    pub evaluations: usize,
}

/// Fits parameters, shared among all robots, to measurements. `friction` is how tubes rub: its coefficient is where that parameter begins, or
/// holds where it is not fitted. Without any parameter the robots are compared as they are. Another thread ends the search by setting `stop`.
///
/// # Errors
/// See [`FitProblem`]; what the data cannot determine is refused.
pub fn fit(
    designs: &[Design],
    measurements: &[Measurement],
    list: &[Parameter],
    friction: Option<Friction>,
    stop: Option<Arc<AtomicBool>>,
) -> Result<Fit, FitProblem> {
    Parameter::check(list, designs).map_err(FitProblem::Parameter)?;
    let groups = measurements.iter().map(|m| robot_of(designs, m)).collect::<Result<Vec<_>, _>>()?;
    let rubs = friction.is_some() || list.iter().any(|p| p.kind == ParameterKind::Friction);
    if rubs && list.iter().any(|p| p.kind == ParameterKind::Gap) {
        return Err(FitProblem::Parameter(ParameterProblem::GapAndFriction));
    }
    if let Some(m) = measurements.iter().find(|m| rubs && m.driven.is_none()) {
        let why = "with friction the column driven has to say which way the motors came: on or back; a friction of 0 leaves it out";
        return Err(FitProblem::Measurement(m.row, why.into()));
    }
    let start = list.iter().map(|p| match (p.kind, friction) {
        (ParameterKind::Friction, Some(known)) => known.coefficient,
        _ => p.present(designs),
    });
    let mut problem = Problem {
        designs,
        measurements,
        poses: poses(measurements, &groups),
        start: Values { list, numbers: start.collect(), known: friction },
        settings: vec![Settings::default(); designs.len()],
        stop,
        evaluations: Cell::new(0),
    };
    let nowhere = DVector::zeros(list.len());
    let mut before = problem.evaluate(&nowhere, None)?;
    units::not_all_at_the_plate(measurements, &before.plain(measurements))
        .map_err(|(row, why)| FitProblem::Measurement(row, why))?;
    let settings = problem.settings_found()?;
    if settings != problem.settings {
        problem.settings = settings;
        before = problem.evaluate(&nowhere, None)?;
    }
    let numbers = before.weighted.len();
    if numbers <= list.len() {
        return Err(FitProblem::TooFew(numbers, list.len()));
    }
    if list.is_empty() {
        let none = DMatrix::zeros(numbers, 0);
        return conclude(&problem, &before, &before, &none);
    }
    // What is invisible at the start would send the search astray.
    visible(&problem, &before, &problem.jacobian(&before)?, 1.0)?;
    let (found, jacobian) = search(&problem, before.clone())?;
    conclude(&problem, &before, &found, &jacobian)
}

fn robot_of(designs: &[Design], m: &Measurement) -> Result<usize, FitProblem> {
    let names = || designs.iter().map(Design::name).collect::<Vec<_>>().join(", ");
    let fail = |why: String| Err(FitProblem::Measurement(m.row, why));
    let index = if m.robot.is_empty() && designs.len() == 1 {
        0
    } else if let Some(index) = designs.iter().position(|d| d.name().eq_ignore_ascii_case(&m.robot)) {
        index
    } else if m.robot.is_empty() {
        return fail(format!("the column robot is needed with several robots: {}", names()));
    } else {
        return fail(format!("there is no robot {}; there are {}", m.robot, names()));
    };
    let design = &designs[index];
    let (name, tubes) = (design.name(), design.tube_count());
    let moved = |tube: usize| m.drives[tube] != TubeDrive::HELD;
    let on_line = match m.line {
        Line::Centre => 0,
        Line::Tube(tube) => tube,
    };
    let measured = m.efforts.iter().map(|effort| effort.0).chain([on_line]);
    if measured.chain((0..m.drives.len()).filter(|tube| moved(*tube))).any(|tube| tube >= tubes) {
        return fail(format!("{name} has tubes 1 to {tubes}"));
    }
    if let Design::Robot(design) = design {
        if moved(0) || m.efforts.iter().any(|effort| effort.0 == 0) {
            return fail(format!(
                "tube 1 of {name} stands still; only a robot with parts or joints has a motor of it"
            ));
        }
        if let Some(at) = m.at
            && !(0.0..=design.length).contains(&at)
        {
            let [at, length] = [at, design.length].map(|v| v * 1e3);
            return fail(format!("at_mm is {at}, but {name} reaches from 0 to {length} mm"));
        }
    }
    if let Err(why) = units::within_reach(m, design) {
        return fail(why);
    }
    Ok(index)
}

/// A combination that is known to no better than itself is not known.
const WORST: f64 = 1.0;
/// Below this part of the largest singular value a combination is lost in rounding.
const ROUNDING: f64 = 1e-7;
/// Shares of a combination below this are not told.
const SHARE: f64 = 0.05;

fn visible(
    problem: &Problem<'_>,
    at: &Evaluation,
    jacobian: &DMatrix<f64>,
    noise: f64,
) -> Result<(), FitProblem> {
    let svd = jacobian.clone().svd(false, true);
    let Some(v) = svd.v_t else { return Ok(()) };
    let largest = svd.singular_values.max();
    let weakest = svd.singular_values.imin();
    let value = svd.singular_values[weakest];
    let unseen = value <= ROUNDING * largest || value <= f64::MIN_POSITIVE;
    if unseen || noise / value > WORST {
        let own = v.row(weakest);
        let shares = problem.start.list.iter().copied().zip(own.iter().copied());
        let mut combination: Vec<(Parameter, f64)> =
            shares.filter(|(_, share)| share.abs() > SHARE).collect();
        combination.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let uncertainty = if unseen { f64::INFINITY } else { noise / value };
        let why = problem.why(at, &combination);
        return Err(FitProblem::Invisible { combination, uncertainty, why });
    }
    Ok(())
}

fn conclude(
    problem: &Problem<'_>,
    before: &Evaluation,
    found: &Evaluation,
    jacobian: &DMatrix<f64>,
) -> Result<Fit, FitProblem> {
    let (n, m) = jacobian.shape();
    let freedom = (n - m) as f64;
    let scale = (found.squares() / freedom).sqrt();
    if m > 0 {
        visible(problem, found, jacobian, scale)?;
    }
    let inverse = jacobian
        .tr_mul(jacobian)
        .try_inverse()
        .ok_or_else(|| FitProblem::Search("the normal equations are singular".into()))?;
    let quantile = |p: f64| StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(p));
    let student = quantile(0.975);
    let values = problem.values(&found.place);
    let bound = held(&found.place, &problem.bounds(&found.place), &jacobian.tr_mul(&found.weighted));
    let estimates = (0..m)
        .map(|p| {
            let (parameter, value, before) = (values.list[p], values.numbers[p], problem.start.numbers[p]);
            let deviation = scale * inverse[(p, p)].sqrt() * parameter.size(value);
            let interval = student * deviation;
            Estimate { parameter, value, before, deviation, interval, at_bound: bound[p] }
        })
        .collect();
    let correlation = (0..m)
        .map(|i| (0..m).map(|j| inverse[(i, j)] / (inverse[(i, i)] * inverse[(j, j)]).sqrt()).collect())
        .collect();
    // Bonferroni: 5 % shared by all residuals, both sides.
    let limit = quantile(1.0 - 0.025 / n as f64);
    let plain = found.plain(problem.measurements);
    let residuals = plain
        .iter()
        .enumerate()
        .map(|(i, &(row, what, value))| {
            let own = jacobian.row(i);
            let leverage = (own * &inverse).dot(&own);
            let expected = scale * (1.0 - leverage).max(1e-12).sqrt();
            let studentised = if expected > 0.0 { found.weighted[i] / expected } else { 0.0 };
            Residual { row, what, value, studentised, outlier: studentised.abs() > limit }
        })
        .collect();
    let rms = |e: &Evaluation| {
        let plain = e.plain(problem.measurements).into_iter();
        let points: Vec<_> = plain.filter(|p| matches!(p.1, Observed::Coordinate(_))).collect();
        let mut rows: Vec<usize> = points.iter().map(|p| p.0).collect();
        rows.dedup();
        (points.iter().map(|p| p.2 * p.2).sum::<f64>() / rows.len() as f64).sqrt()
    };
    Ok(Fit {
        estimates,
        correlation,
        residuals,
        scale,
        rms: rms(found),
        rms_before: rms(before),
        misses: misses(problem.measurements, before, found),
        designs: problem.designs.iter().map(|d| values.design(d)).collect(),
        accuracy: problem.accuracy(found),
        evaluations: problem.evaluations.get(),
    })
}

fn misses(measurements: &[Measurement], before: &Evaluation, found: &Evaluation) -> Vec<Misses> {
    let mut all: Vec<(Misses, f64)> = Vec::new();
    let numbers = measurements.iter().flat_map(Measurement::numbers);
    for ((what, measured, _), (was, is)) in numbers.zip(before.differences.iter().zip(&found.differences)) {
        if matches!(what, Observed::Coordinate(_) | Observed::Direction(_)) {
            continue;
        }
        let place = all.iter().position(|(own, _)| own.what == what).unwrap_or_else(|| {
            all.push((Misses { what, before: 0.0, fitted: 0.0, measured: 0.0 }, 0.0));
            all.len() - 1
        });
        let (own, count) = &mut all[place];
        own.before += was * was;
        own.fitted += is * is;
        own.measured += measured * measured;
        *count += 1.0;
    }
    let root = |(own, count): (Misses, f64)| {
        let [before, fitted, measured] =
            [own.before, own.fitted, own.measured].map(|sum| (sum / count).sqrt());
        Misses { before, fitted, measured, ..own }
    };
    all.into_iter().map(root).collect()
}
