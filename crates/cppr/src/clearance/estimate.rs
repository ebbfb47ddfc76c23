//! What clearance changes, estimated from an equilibrium without it.
//!
//! The outer tube of a pair presses on the inner one with the force p per length. With a radial gap δ the inner tube gives way against p, up to the wall, and
//! is held on the axis at the plate and at joints alone. Near such an end it is a beam of EI_r = EI_1 EI_2/(EI_1 + EI_2) under q = |p| that lies down on the wall at the distance
//! ℓ: with no couple and no slope there, from the clamped end,
//!
//! ```text
//! ℓ = (72 EI_r δ/q)^¼ ,   ∫_0^ℓ y dx = 0.6 δ ℓ ,   so that   ȳ = δ [1 − 0.4 (ℓ_plate + ℓ_tip)/L] .
//! ```
//!
//! Where ℓ is so long that the wall is not met, the beam between two clamped ends gives way by ȳ = q L⁴/(720 EI_r), that from one end by ȳ = q L⁴/(20 EI_r).
//!
//! The offsets of all pairs outside of tube k, each of the size ȳ against its p, add to its own, y_k. A line at y_k beside the centreline is shorter by
//! s_k = ∫ y_k·dt, t the tangent: the bundle bends as one without clearance whose tube k is pulled by Δa_k − s_k. The virtual work of this
//! slack gives the forces, T = (1 + ∂s/∂Δa)⁻ᵀ T_without at the same shape, and the contact force falls as they do. In the plane with constant curvature that is the lever ΣD + ȳ in place of ΣD.
//!
//! Left out: play below the plate, and what the layers at the ends do to the shape.

use crate::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort};
use crate::bundle::{Bundle, BundleSection, ContactPoint, PairContact};
use crate::solve::Drive;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// One pair of neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairEstimate {
    /// Tubes (index from 0).
    pub outer: usize,
    /// The one inside it.
    pub inner: usize,
    /// Radial gap δ (m).
    pub gap: f64,
    /// Mean distance ȳ of the inner tube's axis from that of the outer one (m).
    pub offset: f64,
    /// Length ℓ (m) of the layer next to the plate, beyond which the inner tube lies on the wall; infinite where nothing presses.
    pub layer: f64,
    /// Does it lie on the wall anywhere?
    pub touches: bool,
}

/// What clearance makes of an equilibrium, estimated.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Pairs that have a gap, from outside to inside.
    pub pairs: Vec<PairEstimate>,
    /// Motors of every tube.
    pub efforts: Vec<TubeEffort>,
    /// Centre of the last tip (m).
    pub tip: Vector3<f64>,
    /// Its section frame.
    pub frame: Matrix3<f64>,
    /// Per tube: travel of its motor (m) over which its force passes zero, under the loads and the other motors as given, while the inner tubes go from one wall to the
    /// other. `None` of the outermost tube, of tubes without a gap around them, and where no equilibrium was found for it.
    pub backlash: Vec<Option<f64>>,
}

/// Sections at which contact is read, per length.
const SECTIONS: f64 = 100.0;
/// Rounds of the fixed point, and the change, in units of the length and of EI/L², with which they end.
const ROUNDS: usize = 20;
const SETTLED: f64 = 1e-5;
/// Forces are hundreds of EI/L² where a robot is bent, so that this part of a change counts.
const SOFTER: f64 = 1e-2;
/// Step by which slopes are taken, in the same units.
const STEP: f64 = 1e-4;
/// Gaps below this part of the length are none.
const NO_GAP: f64 = 1e-9;
/// Rounds of a layer's length.
const LAYER_ROUNDS: usize = 40;
/// Contact below this part of the greatest has no direction.
const FAINT: f64 = 1e-3;

/// Estimates what radial gaps (m), from outside to inside, make of an equilibrium. `None` where a section of it does not balance, where no equilibrium
/// without clearance is found at the pulls that the gaps leave, or where these do not settle.
#[must_use]
pub fn estimate(
    solver: &mut BundleSolver,
    found: &BundleEquilibrium,
    gaps: &[Option<f64>],
) -> Option<Estimate> {
    let command = found.command();
    let (length, force) = scales(solver.bundle());
    let count = found.efforts.len();
    let mut now = found.clone();
    let mut efforts = DVector::from_iterator(count, now.efforts.iter().map(|own| own.force));
    for _ in 0..ROUNDS {
        let offsets = Offsets::of(solver, &now, gaps, &efforts)?;
        let slack = offsets.slack(&solver.shape(&now, length / SECTIONS), count);
        let slopes = DMatrix::identity(count, count) + slopes(solver, &now, &offsets)?;
        let without = DVector::from_iterator(count, now.efforts.iter().map(|own| own.force));
        let mut real = slopes.transpose().lu().solve(&without)?;
        let mut missing = DVector::zeros(count);
        for (tube, (told, own)) in command.drives.iter().zip(&now.command().drives).enumerate() {
            match told.translation {
                Drive::Motion(pull) => missing[tube] = pull - own.translation.value() - slack[tube],
                Drive::Effort(given) => real[tube] = given,
            }
        }
        let forces = slopes.transpose() * &real;
        // What of a given force is not there yet, and by how much the others changed.
        let off = DVector::from_fn(count, |tube, _| match command.drives[tube].translation {
            Drive::Motion(_) => real[tube] - efforts[tube],
            Drive::Effort(_) => forces[tube] - without[tube],
        });
        let moved = (&missing / length).amax().max((off / force).amax() * SOFTER);
        efforts = real;
        if moved < SETTLED {
            let own = now.efforts.iter().zip(efforts.iter().zip(&slack));
            let own = own.map(|(own, (force, slack))| TubeEffort {
                label: own.label + slack,
                force: *force,
                ..*own
            });
            return Some(Estimate {
                efforts: own.collect(),
                tip: now.tip,
                frame: now.frame,
                backlash: backlash(solver, &now, &offsets.pairs),
                pairs: offsets.pairs,
            });
        }
        let step = slopes.clone().lu().solve(&missing)?;
        let mut eased = now.command().clone();
        for (tube, own) in eased.drives.iter_mut().enumerate() {
            own.translation = match own.translation {
                Drive::Motion(pull) => Drive::Motion(pull + step[tube]),
                Drive::Effort(_) => Drive::Effort(forces[tube]),
            };
        }
        now = solved(solver, &eased, &now)?;
    }
    None
}

/// Length (m) and force EI/L² (N) in whose units changes are judged.
fn scales(bundle: &Bundle) -> (f64, f64) {
    let length = bundle.length();
    (length, bundle.bending / (length * length))
}

fn solved(
    solver: &mut BundleSolver,
    command: &BundleCommand,
    near: &BundleEquilibrium,
) -> Option<BundleEquilibrium> {
    let found = solver.continued(command, near).unwrap_or_else(|| solver.solve_from(command, near));
    found.converged.then_some(found)
}

/// Where the axes of inner tubes lie.
struct Offsets {
    pairs: Vec<PairEstimate>,
    /// Per pair: places along the centreline (m), and there the offset of the inner axis (m), y and z of the untwisted frame.
    courses: Vec<Course>,
}

type Course = Vec<(f64, [f64; 2])>;

impl Offsets {
    /// Of an equilibrium without clearance whose motors pull with other forces (N) where there is clearance.
    fn of(
        solver: &BundleSolver,
        found: &BundleEquilibrium,
        gaps: &[Option<f64>],
        efforts: &DVector<f64>,
    ) -> Option<Self> {
        let bundle = solver.bundle();
        let contact = solver.contact(found, bundle.length() / SECTIONS)?;
        let shape = solver.shape(found, bundle.length() / SECTIONS);
        let mut offsets = Self { pairs: Vec::new(), courses: Vec::new() };
        for pair in contact.pairs.iter().filter(|pair| pair.inner == pair.outer + 1) {
            let Some(&Some(gap)) = gaps.get(pair.outer) else { continue };
            if gap <= NO_GAP * bundle.length() {
                continue;
            }
            let sum =
                |forces: &mut dyn Iterator<Item = f64>| forces.skip(pair.inner).map(f64::abs).sum::<f64>();
            let without = sum(&mut found.efforts.iter().map(|own| own.force));
            let eased = if without > 0.0 { sum(&mut efforts.iter().copied()) / without } else { 1.0 };
            let (own, course) = course(bundle, &shape, pair, [gap, eased]);
            offsets.pairs.push(own);
            offsets.courses.push(course);
        }
        Some(offsets)
    }

    /// By how much every tube (of `count`) is longer than the centreline at its place, less what it is without offset (m).
    fn slack(&self, shape: &[BundleSection], count: usize) -> DVector<f64> {
        let mut slack = DVector::zeros(count);
        for (pair, course) in self.pairs.iter().zip(&self.courses) {
            let own: f64 = shape
                .windows(2)
                .filter_map(|step| {
                    let [y, z] = at(course, 0.5 * (step[0].length + step[1].length))?;
                    let across = |i: usize| step[0].frame.column(i) + step[1].frame.column(i);
                    let turned = step[1].frame.column(0) - step[0].frame.column(0);
                    Some(0.5 * (across(1) * y + across(2) * z).dot(&turned))
                })
                .sum();
            for k in pair.inner..count {
                slack[k] += own;
            }
        }
        slack
    }
}

/// Linear between the places of a course; `None` beyond its ends.
fn at(course: &[(f64, [f64; 2])], length: f64) -> Option<[f64; 2]> {
    let next = course.partition_point(|own| own.0 < length).max(1);
    let ((from, a), (to, b)) = (course.get(next - 1)?, course.get(next)?);
    let share = if to > from { (length - from) / (to - from) } else { 1.0 };
    Some([0, 1].map(|i| a[i] + share * (b[i] - a[i])))
}

/// How far the inner tube of a pair gives way, and to where.
///
/// The force between both is that without clearance, p, times a factor.
fn course(
    bundle: &Bundle,
    shape: &[BundleSection],
    pair: &PairContact,
    [gap, eased]: [f64; 2],
) -> (PairEstimate, Course) {
    let label =
        |station: &[(usize, f64)], tube: usize| station.iter().find(|own| own.0 == tube).map(|own| own.1);
    let joints = bundle.stations.iter().filter_map(|s| label(s, pair.inner).and(label(s, pair.outer)));
    let mut joints: Vec<f64> = joints.collect();
    joints.sort_by(f64::total_cmp);
    let faint = FAINT * pair.greatest();
    let (mut course, mut whole, mut sum, mut first_layer) = (Vec::new(), 0.0, 0.0, None);
    let mut touches = false;
    let mut rest = pair.points.as_slice();
    let mut held = rest.first().is_some_and(|first| first.length <= 0.0);
    while let Some(begin) = rest.first() {
        let joint = joints.iter().copied().find(|joint| *joint > begin.labels[0]);
        let to = joint.map_or(rest.len(), |joint| {
            let before = joint - NO_GAP * bundle.length();
            (rest.partition_point(|point| point.labels[0] < before) + 1).min(rest.len())
        });
        let (span, beyond) = rest.split_at(to);
        let length = span[span.len() - 1].length - begin.length;
        let ends = [held.then_some(false), joint.map(|_| true)];
        let layers: Vec<f64> = ends
            .into_iter()
            .flatten()
            .map(|far| layer(bundle, shape, pair, span, gap / eased, far))
            .collect();
        first_layer = first_layer.or_else(|| layers.first().copied());
        let inside = layers.iter().sum::<f64>();
        let times = (layers.len() as f64 * length / inside).powi(4);
        // Between two ends both formulas meet at 1.37; from one end they come nearest at 2.
        let (meets_wall, between) = match layers.len() {
            0 => (true, 1.0),
            1 => (inside < 2.0 * length, 72.0 / 20.0 * times),
            _ => (inside < 1.37 * length, 72.0 / 720.0 * times),
        };
        let offset = gap * if meets_wall { 1.0 - 0.4 * inside / length } else { between };
        touches |= meets_wall;
        whole += length;
        sum += offset * length;
        course.extend(span.iter().map(|point| {
            let size = point.across[0].hypot(point.across[1]).hypot(faint).max(f64::MIN_POSITIVE);
            (point.length, point.across.map(|p| -offset * p / size))
        }));
        (rest, held) = (beyond, joint.is_some());
    }
    let layer = first_layer.unwrap_or(0.0);
    let offset = if whole > 0.0 { sum / whole } else { 0.0 };
    (PairEstimate { outer: pair.outer, inner: pair.inner, gap, offset, layer, touches }, course)
}

/// Length (m) of the layer at an end of a span, under the mean of the contact force in it; the gap is that over the factor on the force.
fn layer(
    bundle: &Bundle,
    shape: &[BundleSection],
    pair: &PairContact,
    span: &[ContactPoint],
    gap: f64,
    far: bool,
) -> f64 {
    let Some(end) = (if far { span.last() } else { span.first() }) else { return 0.0 };
    let whole = (span[span.len() - 1].length - span[0].length).max(f64::MIN_POSITIVE);
    let mut length = whole;
    for _ in 0..LAYER_ROUNDS {
        let (mut pressed, mut over) = ([0.0; 2], 0.0);
        for step in span.windows(2) {
            let middle = 0.5 * (step[0].length + step[1].length);
            if (middle - end.length).abs() <= length {
                let way = step[1].length - step[0].length;
                over += way;
                for axis in 0..2 {
                    pressed[axis] += 0.5 * way * (step[0].across[axis] + step[1].across[axis]);
                }
            }
        }
        let force = pressed[0].hypot(pressed[1]) / over.max(f64::MIN_POSITIVE);
        let towards = pressed[1].atan2(pressed[0]);
        let [outer, inner] =
            [pair.outer, pair.inner].map(|tube| bending(bundle, shape, tube, end.length, towards));
        length = (72.0 * gap * outer * inner / (outer + inner) / force).powf(0.25);
    }
    length
}

/// Bending stiffness (N m²) of a tube against a deflection of a direction (angle in the untwisted frame) at a place of the centreline (m).
fn bending(bundle: &Bundle, shape: &[BundleSection], tube: usize, length: f64, towards: f64) -> f64 {
    let next = shape.partition_point(|section| section.length < length).min(shape.len() - 1);
    let Some(own) = shape[next].tube(tube) else { return f64::INFINITY };
    let [_, stiff, soft, ..] = bundle.tubes[tube].piece_at(own.label).table_at(own.label);
    let (sin, cos) = (towards - own.angle).sin_cos();
    soft * cos * cos + stiff * sin * sin
}

/// Slopes of every tube's slack by the pulls (index 0 is the outermost), the offsets held as they are.
fn slopes(solver: &mut BundleSolver, found: &BundleEquilibrium, offsets: &Offsets) -> Option<DMatrix<f64>> {
    let count = found.efforts.len();
    let (length, force) = scales(solver.bundle());
    let (mut pulls, mut slacks) = (DMatrix::identity(count, count), DMatrix::zeros(count, count));
    for tube in 1..count {
        let drive = found.command().drives[tube].translation;
        let step = STEP * if drive.is_motion() { length } else { force };
        let mut sides = Vec::with_capacity(2);
        for side in [-step, step] {
            let mut command = found.command().clone();
            command.drives[tube].translation = drive.with_value(drive.value() + side);
            let moved = solved(solver, &command, found)?;
            let slack = offsets.slack(&solver.shape(&moved, length / SECTIONS), count);
            let pull = DVector::from_iterator(count, moved.efforts.iter().map(|own| own.label));
            sides.push((pull, slack));
        }
        pulls.set_column(tube, &((&sides[1].0 - &sides[0].0) / (2.0 * step)));
        slacks.set_column(tube, &((&sides[1].1 - &sides[0].1) / (2.0 * step)));
    }
    Some(slacks * pulls.try_inverse()?)
}

/// Travel of every motor while the inner tubes change walls.
fn backlash(
    solver: &mut BundleSolver,
    found: &BundleEquilibrium,
    pairs: &[PairEstimate],
) -> Vec<Option<f64>> {
    let length = solver.bundle().length();
    let of = |tube: usize| {
        let play: f64 = pairs.iter().filter(|pair| pair.inner <= tube).map(|pair| 2.0 * pair.offset).sum();
        if tube == 0 || play <= 0.0 {
            return None;
        }
        let mut command = found.command().clone();
        command.drives[tube].translation = Drive::Effort(0.0);
        let slack = solved(solver, &command, found)?;
        let shape = solver.shape(&slack, length / SECTIONS);
        let bend: f64 = shape
            .windows(2)
            .filter_map(|step| {
                let [a, b] = [step[0].tube(tube)?.angle, step[1].tube(tube)?.angle];
                let (sin, cos) = (0.5 * (a + b)).sin_cos();
                let across = |i: usize| step[0].frame.column(i) + step[1].frame.column(i);
                let turned = step[1].frame.column(0) - step[0].frame.column(0);
                Some(0.5 * (across(1) * cos + across(2) * sin).dot(&turned))
            })
            .sum();
        Some(play * bend.abs())
    };
    (0..found.efforts.len()).map(of).collect()
}
