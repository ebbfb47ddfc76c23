//! Newton's method on what an integration leaves of the conditions, and on the states between its steps.

use super::frame::Frame;
use super::number::{Dual, Number};
use super::steps::Steps;
use super::vector::columns;
use super::walk::{Lost, Walk};
use nalgebra::{DMatrix, DVector, Vector3};

/// Most unknowns and inputs at once; a bundle with more is not solved, and says so.
pub(super) const MOST: usize = 51;
/// Newton's method ends with the step that is below this (scaled) in a solve. The states between have a greater rounding.
pub(super) const SETTLED: f64 = 1e-9;
pub(super) const BETWEEN: f64 = 100.0;
/// The same towards an equilibrium that is near already: what is left is of its square.
pub(super) const SETTLED_NEAR: f64 = 1e-5;
/// Longest Newton step, in scaled unknowns.
pub(super) const LONGEST: f64 = 20.0;
/// Singular values below this part of the greatest are zero.
const SINGULAR: f64 = 1e-14;
/// Forces jump where an event passes another one: so many steps across may make things worse.
const CROSSINGS: usize = 8;
/// Steps of the integration are cut where that is needed until Newton's step is below this, and where some have come to be too coarse.
pub(super) const ROUGH: f64 = 1e-2;

/// How far Newton's method goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    /// Most steps.
    pub steps: usize,
    /// Most steps that may be shortened.
    pub shortened: usize,
}

impl Budget {
    /// So few steps, and so few of them shortened, that they lead to the branch from which it was sought.
    pub const DIRECT: Self = Self { steps: 8, shortened: 2 };
    /// The same in steps that are to be whole.
    pub const WHOLE: Self = Self { steps: 8, shortened: 0 };
    /// Steps without regard to the branch.
    pub fn far(steps: usize) -> Self {
        Self { steps, shortened: usize::MAX }
    }
}

/// The conditions near given unknowns.
pub(super) struct Tangent {
    /// Scaled residual, at the linear estimate of where the integration arrives once its steps meet.
    pub residual: DVector<f64>,
    /// Its slopes by the [coordinates](super::coordinates) at the tip, and by the fraction of a path.
    pub matrix: DMatrix<f64>,
    /// By which its determinant is that by the scaled unknowns.
    pub determinant: f64,
    /// Last tip (m) likewise.
    pub tip: Vector3<f64>,
    /// Slopes of the last tip by the length, and of the tangent there; by the coordinates there, and by the fraction.
    pub pose_slopes: DMatrix<f64>,
    /// Greatest scaled residual, and gap between the steps.
    pub defect: f64,
}

/// A converged point.
pub(super) struct Found {
    pub unknowns: Vec<f64>,
    pub steps: Steps,
    pub determinant: f64,
    pub iterations: usize,
}

impl Tangent {
    pub fn new(frame: &Frame, unknowns: &[f64], walk: &Walk, steps: &mut Steps) -> Result<Self, Lost> {
        match unknowns.len() + usize::from(frame.rates.is_some()) + 1 {
            0..=7 => Self::with::<8>(frame, unknowns, walk, steps),
            8..=11 => Self::with::<12>(frame, unknowns, walk, steps),
            12..=15 => Self::with::<16>(frame, unknowns, walk, steps),
            16..=23 => Self::with::<24>(frame, unknowns, walk, steps),
            24..=MOST => Self::with::<{ 1 + MOST }>(frame, unknowns, walk, steps),
            _ => Err(Lost::Steps),
        }
    }

    fn with<const N: usize>(
        frame: &Frame,
        unknowns: &[f64],
        walk: &Walk,
        steps: &mut Steps,
    ) -> Result<Self, Lost> {
        let inputs: Vec<Dual<N>> = unknowns.iter().enumerate().map(|(i, u)| Dual::input(*u, i)).collect();
        let fraction = unknowns.len();
        let moving = |value: f64, rate: f64| Dual::<N>::input(0.0, fraction) * rate + value;
        let still = || frame.drives().into_iter().map(|pair| pair.map(Dual::constant)).collect();
        let (drives, load, width): (Vec<[Dual<N>; 2]>, _, _) = match &frame.rates {
            None => (still(), Dual::constant(frame.load), fraction),
            Some(rates) => {
                let own = |(pair, rate): ([f64; 2], &[f64; 2])| [0, 1].map(|k| moving(pair[k], rate[k]));
                let drives = frame.drives().into_iter().zip(&rates.drives).map(own);
                (drives.collect(), moving(frame.load, rates.load), fraction + 1)
            }
        };
        let base = frame.base_under(&inputs, &drives, load);
        let outcome = walk.run(&base, steps, None)?;
        let coordinates = &steps.coordinates;
        let (matrix, residual) = coordinates.system(width - fraction).ok_or(Lost::Order)?;
        let [along, ..] = columns(outcome.turn);
        let length = walk.bundle.length;
        Ok(Self {
            residual: DVector::from_vec(residual),
            matrix,
            determinant: coordinates.determinant,
            tip: Vector3::from(outcome.centre.map(|c| c.value() + c.slopes()[N - 2])),
            pose_slopes: DMatrix::from_fn(6, width, |i, j| match i {
                0..3 => outcome.centre[i].slopes()[j] / length,
                _ => along[i - 3].slopes()[j],
            }),
            defect: coordinates.greatest().max(steps.defect),
        })
    }
}

/// Newton's step somewhere.
struct Point {
    unknowns: Vec<f64>,
    steps: Steps,
    /// Of the coordinates at the tip, and of the unknowns.
    last: DVector<f64>,
    change: Vec<f64>,
    /// Of the conditions' slopes; NaN where these are singular.
    determinant: f64,
    /// Greatest changes of the unknowns and of the states between.
    size: [f64; 2],
    defect: f64,
}

/// The step and the determinant. Where inextensible tubes without lever lie side by side between two joints, how they share their force is not
/// determined, and the matrix is singular: the shortest step is taken then.
pub(super) fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
    let lu = matrix.clone().lu();
    let pivots = lu.u().diagonal();
    if pivots.amin() > SINGULAR * pivots.amax() {
        return Some((lu.solve(right)?, lu.determinant()));
    }
    let svd = matrix.svd(true, true);
    let least = SINGULAR * svd.singular_values.amax();
    let determinant = if svd.singular_values.amin() > least { lu.determinant() } else { f64::NAN };
    Some((svd.solve(right, least).ok()?, determinant))
}

impl Point {
    fn new(frame: &Frame, walk: &Walk, unknowns: Vec<f64>, mut steps: Steps) -> Result<Self, Lost> {
        let tangent = Tangent::new(frame, &unknowns, walk, &mut steps)?;
        let (last, determinant) = solve(tangent.matrix, &-tangent.residual).ok_or(Lost::Section)?;
        let determinant = tangent.determinant * determinant;
        let (change, between) = steps.at_plate(last.as_slice(), walk);
        let size = [change.iter().fold(0.0, |most: f64, own| most.max(own.abs())), between];
        if !(size.iter().all(|s| s.is_finite()) && change.iter().all(|own| own.is_finite())) {
            return Err(Lost::Steps);
        }
        Ok(Self { unknowns, steps, last, change, determinant, size, defect: tangent.defect })
    }

    fn greatest(&self) -> f64 {
        self.size[0].max(self.size[1])
    }

    /// Unknowns and states moved by a part of the step.
    fn moved(&self, factor: f64) -> (Vec<f64>, Steps) {
        let unknowns = self.unknowns.iter().zip(self.change.iter()).map(|(u, s)| u + factor * s).collect();
        let mut steps = self.steps.clone();
        steps.advance(self.last.as_slice(), 1.0, factor);
        (unknowns, steps)
    }
}

/// Finds unknowns at which the conditions are met, from unknowns and states nearby. A step is shortened until the next one is shorter, or
/// until what is left of the conditions is less.
pub(super) fn newton(
    frame: &Frame,
    walk: &Walk,
    start: Vec<f64>,
    mut steps: Steps,
    budget: Budget,
    settled: f64,
) -> Result<Found, Lost> {
    steps.adapt = true;
    let mut here = Point::new(frame, walk, start, steps)?;
    let walk = &Walk { course: None, ..*walk };
    let (mut crossings, mut shortened) = (0, 0);
    for iterations in 1..=budget.steps {
        let size = here.greatest();
        let coarse = here.steps.are_coarse();
        if here.size[0] <= settled && here.size[1] <= BETWEEN * settled && !coarse {
            let (unknowns, mut steps) = here.moved(1.0);
            steps.settle();
            return Ok(Found { unknowns, steps, determinant: here.determinant, iterations });
        }
        let mut factor = f64::min(1.0, LONGEST / size);
        loop {
            if factor < 1.0 && shortened >= budget.shortened {
                return Err(Lost::Steps);
            }
            let (unknowns, mut steps) = here.moved(factor);
            steps.adapt = size > ROUGH || coarse;
            if let Ok(next) = Point::new(frame, walk, unknowns, steps) {
                let enough = 1.0 - 0.25 * factor;
                let crosses = crossings < CROSSINGS && next.steps.keys() != here.steps.keys();
                if crosses || next.greatest() <= enough * size || next.defect <= enough * here.defect {
                    crossings += usize::from(crosses);
                    shortened += usize::from(factor < 1.0);
                    here = next;
                    break;
                }
            }
            factor *= 0.5;
            if factor < 1e-3 {
                return Err(Lost::Steps);
            }
        }
    }
    Err(Lost::Steps)
}
