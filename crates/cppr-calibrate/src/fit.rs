//! The fit and what it is worth.

use crate::data::{Line, Measurement};
use crate::design::Design;
use crate::observe::{Found, Model, settings_for};
use crate::parameter::{Parameter, ParameterProblem, apply};
use crate::units;
use cppr::solve::Settings;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::cell::RefCell;
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
        /// Parameters with their share, largest first.
        combination: Vec<(Parameter, f64)>,
        /// Standard deviation of the combination, relative; infinite where the data do not see it at all.
        uncertainty: f64,
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
            Self::Invisible { combination, uncertainty } => {
                let parts: Vec<String> = combination
                    .iter()
                    .filter(|(_, share)| share.abs() > 0.05)
                    .map(|(parameter, share)| format!("{share:+.2} {parameter}"))
                    .collect();
                let parts = parts.join(" ");
                write!(f, "the data cannot see the combination {parts} (relative changes): ")?;
                if uncertainty.is_finite() {
                    write!(f, "its standard deviation is {:.0} %. ", uncertainty * 100.0)?;
                } else {
                    write!(f, "it changes nothing that was measured. ")?;
                }
                write!(
                    f,
                    "Motions of unloaded robots do not show a common modulus (Remark 19), motions without rotation no \
                     shear modulus. Add loaded or turned measurements, or fit less"
                )
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
}

/// One measured number against the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Line of the file.
    pub row: usize,
    /// x, y, z of a point, or "direction".
    pub what: &'static str,
    /// Model minus measurement (m, or rad for a component of a direction).
    pub value: f64,
    /// Divided by its own expected deviation after the fit.
    pub studentised: f64,
    /// Improbable: one such residual among all would be expected in less than one of twenty data sets.
    pub outlier: bool,
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
    /// Designs with the fitted values.
    pub designs: Vec<Design>,
    /// Greatest error of the model's tip among some measurements, as a part of its length, and among how many it is known; 0 where of none.
    pub accuracy: (f64, usize),
    /// Evaluations of all equilibria.
    pub evaluations: usize,
}

/// Fits parameters, shared among all robots, to measurements. Another thread ends that by setting `stop`.
///
/// # Errors
/// See [`FitProblem`]; what the data cannot determine is refused.
pub fn fit(
    designs: &[Design],
    measurements: &[Measurement],
    list: &[Parameter],
    stop: Option<Arc<AtomicBool>>,
) -> Result<Fit, FitProblem> {
    Parameter::check(list, designs).map_err(FitProblem::Parameter)?;
    let groups = measurements.iter().map(|m| robot_of(designs, m)).collect::<Result<Vec<_>, _>>()?;
    let start: Vec<f64> = list.iter().map(|p| p.present(designs)).collect();
    let mut problem = Problem {
        designs,
        measurements,
        groups,
        list,
        start: start.clone(),
        settings: vec![Settings::default(); designs.len()],
        logarithms: DVector::zeros(list.len()),
        stop,
        last: RefCell::new(vec![None; measurements.len()]),
        failure: RefCell::new(None),
        evaluations: RefCell::new(0),
    };
    let mut before = problem.evaluate(false)?;
    units::not_all_at_the_plate(measurements, &before.plain)
        .map_err(|(row, why)| FitProblem::Measurement(row, why))?;
    let settings = problem.settings_found()?;
    if settings != problem.settings {
        problem.settings = settings;
        problem.last.borrow_mut().fill(None);
        before = problem.evaluate(false)?;
    }
    let numbers = before.weighted.len();
    if numbers <= list.len() {
        return Err(FitProblem::TooFew(numbers, list.len()));
    }
    // What is invisible at the start would send the search astray.
    visible(&problem.evaluate(true)?, list, 1.0)?;
    let (solved, report) = LevenbergMarquardt::new().with_tol(1e-10).minimize(problem);
    problem = solved;
    if let Some(failure) = problem.failure.borrow_mut().take() {
        return Err(failure);
    }
    if !report.termination.was_successful() {
        return Err(FitProblem::Search(format!("{:?}", report.termination)));
    }
    let found = problem.evaluate(true)?;
    conclude(&problem, &before, &found)
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
    let moved = |tube: usize| m.pulls[tube].abs() > 0.0 || m.rotations[tube].abs() > 0.0;
    if (tubes..m.pulls.len()).any(moved) {
        return fail(format!("{name} has tubes 1 to {tubes}"));
    }
    if let Line::Tube(tube) = m.line
        && tube >= tubes
    {
        return fail(format!("{name} has tubes 1 to {tubes}"));
    }
    if let Design::Robot(design) = design {
        if moved(0) {
            return fail(format!(
                "tube 1 of {name} stands still; only a robot with parts or joints moves it"
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

struct Problem<'a> {
    designs: &'a [Design],
    measurements: &'a [Measurement],
    /// Robot of each measurement.
    groups: Vec<usize>,
    list: &'a [Parameter],
    start: Vec<f64>,
    /// Of every robot's solver.
    settings: Vec<Settings>,
    /// Logarithms of the values over the start: what the search moves, since no parameter may turn negative.
    logarithms: DVector<f64>,
    stop: Option<Arc<AtomicBool>>,
    /// Last equilibrium of each measurement, to start from.
    last: RefCell<Vec<Option<Found>>>,
    failure: RefCell<Option<FitProblem>>,
    evaluations: RefCell<usize>,
}

/// All residuals, and their derivatives by relative changes of the parameters.
struct Evaluation {
    /// (row, what, value)
    plain: Vec<(usize, &'static str, f64)>,
    weighted: DVector<f64>,
    jacobian: DMatrix<f64>,
}

/// Measurements of a robot that are looked at for the error of the model, at most.
const LOOKED_AT: usize = 8;
/// What to do where the search runs astray.
const CHECK: &str = "Check the frame and the units of the data, and begin nearer to the truth";

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

impl Problem<'_> {
    fn values(&self) -> Vec<f64> {
        self.start.iter().zip(self.logarithms.iter()).map(|(s, l)| s * l.exp()).collect()
    }

    /// Measurements of a robot that are looked at for the error, the first and the last among them.
    fn looked_at(&self, group: usize) -> Vec<usize> {
        let own: Vec<usize> = (0..self.groups.len()).filter(|m| self.groups[*m] == group).collect();
        let last = own.len().saturating_sub(1);
        let mut places: Vec<usize> = (0..LOOKED_AT).map(|i| i * last / (LOOKED_AT - 1)).collect();
        places.dedup();
        places.into_iter().filter_map(|place| own.get(place).copied()).collect()
    }

    /// Settings with which every robot's solver resolves the measurements that are looked at, with the values at the start.
    fn settings_found(&self) -> Result<Vec<Settings>, FitProblem> {
        let one = |(group, design): (usize, &Design)| {
            let measurements: Vec<_> =
                self.looked_at(group).into_iter().map(|m| &self.measurements[m]).collect();
            Ok(match Model::new(design, self.list, &self.start, false)? {
                Model::Robot(robot, _) => settings_for(&robot, &measurements, self.stop.as_ref()),
                Model::Bundle(_) => Settings::default(),
            })
        };
        self.designs.iter().enumerate().map(one).collect()
    }

    /// Greatest error of the tip, as a part of the length, where the last evaluation left the equilibria that are looked at, and of how many it is known.
    fn accuracy(&self) -> (f64, usize) {
        let last = self.last.borrow();
        let looked_at = (0..self.designs.len()).flat_map(|group| self.looked_at(group));
        let errors = looked_at.filter_map(|m| last[m].as_ref()?.error().filter(|own| own.is_finite()));
        errors.fold((0.0, 0), |(most, known), own| (most.max(own), known + 1))
    }

    fn evaluate(&self, derivatives: bool) -> Result<Evaluation, FitProblem> {
        *self.evaluations.borrow_mut() += 1;
        let values = self.values();
        let models = self.designs.iter().map(|d| Model::new(d, self.list, &values, derivatives));
        let models = models.collect::<Result<Vec<_>, _>>().map_err(|problem| self.at(&values, problem))?;
        let mut observers: Vec<_> = models
            .iter()
            .zip(&self.settings)
            .map(|(m, own)| m.observer(self.list, *own, self.stop.as_ref()))
            .collect();
        let (mut plain, mut weighted, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        let mut last = self.last.borrow_mut();
        for ((m, &group), last) in self.measurements.iter().zip(&self.groups).zip(last.iter_mut()) {
            let seen = observers[group].see(m, last.as_ref()).map_err(|problem| self.at(&values, problem))?;
            for axis in 0..6 {
                let (what, measured, sigma) = match (axis < 3, m.direction) {
                    (true, _) => (AXES[axis], m.point[axis], m.sigma),
                    (false, Some(direction)) => ("direction", direction[axis - 3], m.sigma_direction),
                    (false, None) => ("direction", f64::NAN, 1.0),
                };
                if measured.is_nan() {
                    continue;
                }
                let difference = seen.outputs[axis] - measured;
                plain.push((m.row, what, difference));
                weighted.push(difference / sigma);
                rows.extend(seen.slopes.iter().map(|s| s[axis] / sigma));
            }
            *last = Some(seen.found);
        }
        let columns = if derivatives { self.list.len() } else { 0 };
        Ok(Evaluation {
            jacobian: DMatrix::from_row_slice(weighted.len(), columns, &rows),
            plain,
            weighted: DVector::from_vec(weighted),
        })
    }

    /// A problem with the values at which it came up.
    fn at(&self, values: &[f64], problem: FitProblem) -> FitProblem {
        match problem {
            FitProblem::NoEquilibrium(row, why) => {
                let own = |(p, v): (&Parameter, &f64)| format!("{p} = {:.3} {}", v / p.unit().1, p.unit().0);
                let at: Vec<String> = self.list.iter().zip(values).map(own).collect();
                FitProblem::NoEquilibrium(row, format!("with {}: {why}. {CHECK}", at.join(", ")))
            }
            FitProblem::Search(why) => FitProblem::Search(format!("{why}. {CHECK}")),
            other => other,
        }
    }

    /// For the search, which takes `None` for an answer; the reason is kept.
    fn attempt(&self, derivatives: bool) -> Option<Evaluation> {
        self.evaluate(derivatives).map_err(|problem| *self.failure.borrow_mut() = Some(problem)).ok()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.logarithms.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.logarithms.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.attempt(false).map(|e| e.weighted)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.attempt(true).map(|e| e.jacobian)
    }
}

/// A combination that is known to no better than itself is not known.
const WORST: f64 = 1.0;
/// Below this part of the largest singular value a combination is lost in rounding.
const ROUNDING: f64 = 1e-7;

fn visible(found: &Evaluation, list: &[Parameter], noise: f64) -> Result<(), FitProblem> {
    let svd = found.jacobian.clone().svd(false, true);
    let Some(v) = svd.v_t else { return Ok(()) };
    let largest = svd.singular_values.max();
    let weakest = svd.singular_values.imin();
    let value = svd.singular_values[weakest];
    let unseen = value <= ROUNDING * largest || value <= f64::MIN_POSITIVE;
    if unseen || noise / value > WORST {
        let mut combination: Vec<(Parameter, f64)> =
            list.iter().copied().zip(v.row(weakest).iter().copied()).collect();
        combination.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let uncertainty = if unseen { f64::INFINITY } else { noise / value };
        return Err(FitProblem::Invisible { combination, uncertainty });
    }
    Ok(())
}

fn conclude(problem: &Problem, before: &Evaluation, found: &Evaluation) -> Result<Fit, FitProblem> {
    let (n, m) = found.jacobian.shape();
    let freedom = (n - m) as f64;
    let scale = (found.weighted.norm_squared() / freedom).sqrt();
    visible(found, problem.list, scale)?;
    let inverse = (found.jacobian.transpose() * &found.jacobian)
        .try_inverse()
        .ok_or_else(|| FitProblem::Search("the normal equations are singular".into()))?;
    let quantile = |p: f64| StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(p));
    let student = quantile(0.975);
    let values = problem.values();
    let estimates = problem
        .list
        .iter()
        .enumerate()
        .map(|(p, &parameter)| {
            let (value, before) = (values[p], problem.start[p]);
            let deviation = scale * inverse[(p, p)].sqrt() * value;
            Estimate { parameter, value, before, deviation, interval: student * deviation }
        })
        .collect();
    let correlation = (0..m)
        .map(|i| (0..m).map(|j| inverse[(i, j)] / (inverse[(i, i)] * inverse[(j, j)]).sqrt()).collect())
        .collect();
    // Bonferroni: 5 % shared by all residuals, both sides.
    let limit = quantile(1.0 - 0.025 / n as f64);
    let residuals = found
        .plain
        .iter()
        .enumerate()
        .map(|(i, &(row, what, value))| {
            let own = found.jacobian.row(i);
            let leverage = (own * &inverse * own.transpose())[(0, 0)];
            let expected = scale * (1.0 - leverage).max(1e-12).sqrt();
            let studentised = if expected > 0.0 { found.weighted[i] / expected } else { 0.0 };
            Residual { row, what, value, studentised, outlier: studentised.abs() > limit }
        })
        .collect();
    let rms = |e: &Evaluation| {
        let points: Vec<f64> = e.plain.iter().filter(|p| p.1 != "direction").map(|p| p.2).collect();
        let mut rows: Vec<usize> = e.plain.iter().filter(|p| p.1 != "direction").map(|p| p.0).collect();
        rows.dedup();
        (points.iter().map(|v| v * v).sum::<f64>() / rows.len() as f64).sqrt()
    };
    Ok(Fit {
        estimates,
        correlation,
        residuals,
        scale,
        rms: rms(found),
        rms_before: rms(before),
        designs: problem.designs.iter().map(|d| apply(d, problem.list, &values)).collect(),
        accuracy: problem.accuracy(),
        evaluations: *problem.evaluations.borrow(),
    })
}
