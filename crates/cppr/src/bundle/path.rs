//! Paths of equilibria of a bundle: pseudo-arclength continuation (Keller 1977), past folds and onto other branches.
//!
//! The unknowns u of Newton's method and the fraction λ of the path are followed together along the curve r(u, λ) = 0. Motors and loads are inputs of
//! the integration like u, so that ∂r/∂λ is exact. A point is predicted along the tangent and corrected on the bordered system
//!
//! ```text
//! ⎡ r_u  r_λ ⎤ ⎡δu⎤     ⎡r⎤
//! ⎣   tᵀ Y   ⎦ ⎣δλ⎦ = − ⎣0⎦
//! ```
//!
//! Lengths along the path are those of y = (c/L, tangent, λ) at the last tip: Y holds its slopes, and t is the unit direction in which it is left. In place of u
//! stand the [coordinates](super::coordinates) at the tip. States between the steps of the integration go along as in [`newton`](super::newton).

use super::frame::{Frame, Rates};
use super::newton::{BETWEEN, Found, ROUGH, SETTLED, Tangent, solve};
use super::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use super::steps::Steps;
use super::walk::Walk;
use crate::analysis::continuation::{
    Branch, End, FamilyProblem, Origin, Parameter, PathPoint, PointKind, Tracing,
};
use crate::solve::{Drive, Freedom, Input};
use crate::statics::Loads;
use nalgebra::{DMatrix, DVector};
use std::sync::atomic::{AtomicBool, Ordering};

/// Commands of a bundle between a first and a last one; a fraction λ of the way lies between them.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleFamily {
    /// Drives at the beginning, loads in full.
    first: BundleCommand,
    last: Vec<TubeDrive>,
    /// Factors of the loads at both ends.
    load: [f64; 2],
    parameter: Parameter,
    /// The parameter at both ends.
    ends: [f64; 2],
}

impl BundleFamily {
    /// One motor goes from its value in `command` to `to` (SI), driven as the command drives it.
    ///
    /// # Errors
    /// Where the value is already there or not finite.
    pub fn motor(command: BundleCommand, input: Input, to: f64) -> Result<Self, FamilyProblem> {
        let drives = command.inputs().into_iter().position(|own| own == input);
        let Some(index) = drives else { return Err(FamilyProblem::Drives { tube: input.tube }) };
        let own = command.drives[index / 2];
        let from = match input.freedom {
            Freedom::PushPull => own.translation.value(),
            Freedom::Rotation => own.rotation.value(),
        };
        let last = command.with_input(input, to).drives;
        let parameter = Parameter::Actuator(input);
        Self { first: command, last, load: [1.0; 2], parameter, ends: [from, to] }.checked()
    }

    /// All motors go from their values in `command` to others, driven alike, at once; one alone is the parameter itself.
    ///
    /// # Errors
    /// Where a motor is driven otherwise, or none moves.
    pub fn between(command: BundleCommand, last: Vec<TubeDrive>) -> Result<Self, FamilyProblem> {
        let wanted = BundleCommand { drives: last, loads: Loads::none() };
        let (before, after) = (command.inputs(), wanted.inputs());
        if let Some((own, _)) = before.iter().zip(&after).find(|(a, b)| a != b) {
            return Err(FamilyProblem::Drives { tube: own.tube });
        }
        let values = |command: &BundleCommand| -> Vec<f64> {
            command.drives.iter().flat_map(|d| [d.translation.value(), d.rotation.value()]).collect()
        };
        let (from, to) = (values(&command), values(&wanted));
        let moved: Vec<usize> = (0..to.len()).filter(|i| (to[*i] - from[*i]).abs() > 0.0).collect();
        match moved[..] {
            [only] => Self::motor(command, before[only], to[only]),
            _ => Self {
                first: command,
                last: wanted.drives,
                load: [1.0; 2],
                parameter: Parameter::Fraction,
                ends: [0.0, 1.0],
            }
            .checked(),
        }
    }

    /// All loads go from `from` to `to` times their size.
    ///
    /// # Errors
    /// Where there is no load or the factor does not vary.
    pub fn load(command: BundleCommand, from: f64, to: f64) -> Result<Self, FamilyProblem> {
        if command.loads.is_empty() {
            return Err(FamilyProblem::NoLoad);
        }
        let last = command.drives.clone();
        Self { first: command, last, load: [from, to], parameter: Parameter::LoadFactor, ends: [from, to] }
            .checked()
    }

    /// Everything, motors and loads, goes from `from` to `to` times its size in a command.
    ///
    /// # Errors
    /// Where nothing varies.
    pub fn scaled(command: &BundleCommand, from: f64, to: f64) -> Result<Self, FamilyProblem> {
        let by = |factor: f64| -> Vec<TubeDrive> {
            let scaled = |drive: Drive| drive.with_value(factor * drive.value());
            let own = |d: &TubeDrive| TubeDrive {
                translation: scaled(d.translation),
                rotation: scaled(d.rotation),
            };
            command.drives.iter().map(own).collect()
        };
        let first = BundleCommand { drives: by(from), loads: command.loads.clone() };
        Self { first, last: by(to), load: [from, to], parameter: Parameter::Fraction, ends: [0.0, 1.0] }
            .checked()
    }

    fn checked(self) -> Result<Self, FamilyProblem> {
        let values = |d: &TubeDrive| [d.translation.value(), d.rotation.value()];
        let numbers = self.first.drives.iter().chain(&self.last).flat_map(values);
        if !numbers.chain(self.load).chain(self.ends).all(f64::is_finite) {
            return Err(FamilyProblem::NotFinite);
        }
        let [from, to] = self.load;
        let loads_rest = self.first.loads.is_empty() || (to - from).abs() <= 0.0;
        if self.first.drives == self.last && loads_rest || (self.ends[1] - self.ends[0]).abs() <= 0.0 {
            return Err(FamilyProblem::Nothing);
        }
        Ok(self)
    }

    /// The command at a fraction.
    #[must_use]
    pub fn at(&self, fraction: f64) -> BundleCommand {
        let mut command = self.in_full(fraction);
        if !command.loads.is_empty() {
            command.loads = command.loads.scaled(self.factor(fraction));
        }
        command
    }

    /// The same with all loads in full.
    fn in_full(&self, fraction: f64) -> BundleCommand {
        let mix = |a: Drive, b: Drive| a.with_value(a.value() + fraction * (b.value() - a.value()));
        let own = |(a, b): (&TubeDrive, &TubeDrive)| TubeDrive {
            translation: mix(a.translation, b.translation),
            rotation: mix(a.rotation, b.rotation),
        };
        let drives = self.first.drives.iter().zip(&self.last).map(own).collect();
        BundleCommand { drives, loads: self.first.loads.clone() }
    }

    fn factor(&self, fraction: f64) -> f64 {
        self.load[0] + fraction * (self.load[1] - self.load[0])
    }

    fn rates(&self) -> Rates {
        let own = |(a, b): (&TubeDrive, &TubeDrive)| {
            [b.translation.value() - a.translation.value(), b.rotation.value() - a.rotation.value()]
        };
        Rates {
            drives: self.first.drives.iter().zip(&self.last).map(own).collect(),
            load: self.load[1] - self.load[0],
        }
    }

    /// What varies.
    #[must_use]
    pub fn parameter(&self) -> Parameter {
        self.parameter
    }

    /// The parameter at a fraction, in its own unit.
    #[must_use]
    pub fn value(&self, fraction: f64) -> f64 {
        self.ends[0] + fraction * (self.ends[1] - self.ends[0])
    }
}

/// A place on the curve: unknowns, then λ; and the states between.
#[derive(Clone)]
struct Place {
    point: DVector<f64>,
    steps: Steps,
}

/// A place that is an equilibrium, with what is known there.
#[derive(Clone)]
struct Node {
    place: Place,
    /// Along the curve: coordinates and λ at unit length.
    tangent: DVector<f64>,
    /// Y.
    pose: DMatrix<f64>,
    /// r_u and r_λ.
    slopes: DMatrix<f64>,
    /// Changes its sign where branches cross; NaN where a direction is held by nothing all along the branch.
    crossing: f64,
    equilibrium: BundleEquilibrium,
}

impl Node {
    fn fraction(&self) -> f64 {
        self.place.point[self.place.point.len() - 1]
    }

    /// dλ by the length of the path.
    fn advance(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }

    /// Does the fraction turn back before the next point?
    fn folds(&self, next: &Self) -> bool {
        self.advance() * next.advance() < 0.0
    }

    /// Does another branch cross before the next point?
    fn crosses(&self, next: &Self) -> bool {
        self.crossing * next.crossing < 0.0
    }

    /// t.
    fn direction(&self) -> DVector<f64> {
        &self.pose * &self.tangent
    }
}

/// The count of negative eigenvalues is that of a quadrature, and changes a little beside the place where an eigenvalue vanishes. Between folds and branch
/// points it is one number: the most frequent.
fn settle_counts(points: &mut [PathPoint<BundleEquilibrium>]) {
    let regular = |a: &PathPoint<BundleEquilibrium>, b: &PathPoint<BundleEquilibrium>| {
        a.kind == PointKind::Regular && b.kind == PointKind::Regular
    };
    for stretch in points.chunk_by_mut(regular) {
        let times = |inertia| stretch.iter().filter(|point| point.inertia == inertia).count();
        let most = stretch.iter().map(|point| point.inertia).max_by_key(|inertia| times(*inertia)).flatten();
        for point in stretch {
            point.inertia = most;
            point.equilibrium.inertia = most;
            point.equilibrium.stable = most == Some(0);
        }
    }
}

/// Settles the counts of a branch. Where a determinant changes its sign but no eigenvalue, it is lost in rounding: the branch ends there.
fn settle(
    points: &mut Vec<PathPoint<BundleEquilibrium>>,
    end: End,
    branch: usize,
    crossings: &mut Vec<Crossing>,
) -> End {
    settle_counts(points);
    let count = |point: Option<&PathPoint<BundleEquilibrium>>| point.and_then(|p| p.inertia);
    let lost = (1..points.len()).find(|&i| {
        let crosses = matches!(points[i].kind, PointKind::BranchPoint { .. });
        crosses
            && points[i - 1].kind == PointKind::Regular
            && count(points.get(i - 1)) == count(points.get(i + 1))
    });
    let Some(lost) = lost else { return end };
    points.truncate(lost);
    crossings.retain(|crossing| crossing.branch != branch || crossing.point < lost);
    End::Step
}

/// Y.
fn pose(tangent: &Tangent) -> DMatrix<f64> {
    let [rows, columns] = [tangent.pose_slopes.nrows(), tangent.pose_slopes.ncols()];
    let mut pose = tangent.pose_slopes.clone().insert_row(rows, 0.0);
    pose[(rows, columns - 1)] = 1.0;
    pose
}

fn bordered(slopes: &DMatrix<f64>, pose: &DMatrix<f64>, direction: &DVector<f64>) -> DMatrix<f64> {
    let n = slopes.nrows();
    let mut matrix = slopes.clone().insert_row(n, 0.0);
    matrix.row_mut(n).copy_from(&pose.tr_mul(direction).transpose());
    matrix
}

/// The direction of λ alone.
fn fraction_alone() -> DVector<f64> {
    let mut direction = DVector::zeros(POSE + 1);
    direction[POSE] = 1.0;
    direction
}

/// A determinant in units in which every row has length one; NaN where it is nothing but rounding.
fn sign_of(mut matrix: DMatrix<f64>) -> f64 {
    for mut row in matrix.row_iter_mut() {
        let size = row.norm();
        row /= size;
    }
    let determinant = matrix.clone().lu().determinant();
    let values = matrix.singular_values();
    if values.min() > NEUTRAL * values.max() { determinant } else { f64::NAN }
}

/// The shortest solution where the matrix is singular.
fn shortest(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let svd = matrix.svd(true, true);
    let least = SINGULAR * svd.singular_values.amax();
    svd.solve(right, least).ok()
}

/// A branch point and the directions that leave it.
#[derive(Clone)]
struct Crossing {
    branch: usize,
    point: usize,
    depth: usize,
    node: Node,
    directions: Vec<DVector<f64>>,
}

/// Components of a pose.
const POSE: usize = 6;
/// Singular values of the bordered matrix below this part of the greatest are zero.
const SINGULAR: f64 = 1e-9;
/// The same with rows of length one, where a direction is held by nothing.
const NEUTRAL: f64 = 1e-11;
/// Corrections of one point.
const CORRECTIONS: usize = 10;
/// Least cosine of the angle between the tangents of neighbours.
const STRAIGHT: f64 = 0.94;
/// Steps that make a place of an event.
const SEARCH: usize = 60;
/// Part of the longest step at which another branch is entered.
const ASIDE: f64 = 0.2;
/// How near two branch points are one.
const SAME: f64 = 1e-4;

struct Tracer<'a, 'b> {
    solver: &'a BundleSolver<'b>,
    family: &'a BundleFamily,
    tracing: &'a Tracing,
    left: usize,
    stop: &'a AtomicBool,
}

impl BundleSolver<'_> {
    /// Traces the equilibria of a family of commands from its first to its last, past folds, and the branches that leave them; margins are not computed.
    pub fn trace(&mut self, family: &BundleFamily, tracing: &Tracing) -> Vec<Branch<BundleEquilibrium>> {
        let start = self.solve(&family.at(0.0));
        self.trace_from(family, tracing, &start)
    }

    /// The same from an equilibrium under the first command.
    pub fn trace_from(
        &mut self,
        family: &BundleFamily,
        tracing: &Tracing,
        start: &BundleEquilibrium,
    ) -> Vec<Branch<BundleEquilibrium>> {
        self.trace_until(family, tracing, start, &AtomicBool::new(false))
    }

    /// The same; soon after the flag is set it returns what was found, and the branch that was followed then ends with [`End::Stopped`].
    pub fn trace_until(
        &mut self,
        family: &BundleFamily,
        tracing: &Tracing,
        start: &BundleEquilibrium,
        stop: &AtomicBool,
    ) -> Vec<Branch<BundleEquilibrium>> {
        let mut tracer = Tracer { solver: self, family, tracing, left: tracing.steps, stop };
        let Some(first) = tracer.begin(start) else {
            return vec![Branch { points: Vec::new(), end: End::NoStart(start.status()), origin: None }];
        };
        let (mut branches, mut crossings) = (Vec::new(), Vec::<Crossing>::new());
        let mut points = vec![tracer.point(&first, PointKind::Regular)];
        let end = tracer.follow(first, &mut points, [0, 0], &mut crossings);
        let end = settle(&mut points, end, 0, &mut crossings);
        branches.push(Branch { points, end, origin: None });
        let mut next = 0;
        while next < crossings.len() {
            let Crossing { branch, point, depth, node, directions } = crossings[next].clone();
            next += 1;
            if depth >= tracing.depth || stop.load(Ordering::Relaxed) {
                continue;
            }
            for (mode, direction) in directions.iter().enumerate() {
                for along in [true, false] {
                    let Some(leaving) = tracer.leave(&node, direction, along) else { continue };
                    let multiplicity = directions.len();
                    let mut points = vec![
                        tracer.point(&node, PointKind::BranchPoint { multiplicity }),
                        tracer.point(&leaving, PointKind::Regular),
                    ];
                    let end =
                        tracer.follow(leaving, &mut points, [branches.len(), depth + 1], &mut crossings);
                    let end = settle(&mut points, end, branches.len(), &mut crossings);
                    branches.push(Branch {
                        points,
                        end,
                        origin: Some(Origin { branch, point, mode, along }),
                    });
                }
            }
        }
        branches
    }
}

impl Tracer<'_, '_> {
    fn point(&self, node: &Node, kind: PointKind) -> PathPoint<BundleEquilibrium> {
        PathPoint {
            parameter: self.family.value(node.fraction()),
            fraction: node.fraction(),
            kind,
            tip: node.equilibrium.tip,
            inertia: node.equilibrium.inertia,
            margin: None,
            equilibrium: node.equilibrium.clone(),
        }
    }

    /// Residual and slopes at a place.
    fn evaluate(&self, place: &mut Place) -> Option<Tangent> {
        let n = place.point.len() - 1;
        let fraction = place.point[n];
        let command = self.family.in_full(fraction);
        let mut frame = Frame::new(self.solver.bundle, &command, self.solver.lengthening());
        if frame.count() != n {
            return None;
        }
        frame.load = self.family.factor(fraction);
        frame.rates = Some(self.family.rates());
        let walk = Walk { posed: true, ..frame.walk(self.solver.tolerance) };
        Tangent::new(&frame, &place.point.as_slice()[..n], &walk, &mut place.steps).ok()
    }

    /// Newton's method across a direction. How many corrections it took.
    fn correct(&self, place: &mut Place, across: &DVector<f64>) -> Option<usize> {
        let n = place.point.len() - 1;
        place.steps.adapt = true;
        for turn in 1..=CORRECTIONS {
            let tangent = self.evaluate(place)?;
            let right = (-&tangent.residual).push(0.0);
            let (last, _) = solve(bordered(&tangent.matrix, &pose(&tangent), across), &right)?;
            let command = self.family.in_full(place.point[n]);
            let frame = Frame::new(self.solver.bundle, &command, self.solver.lengthening());
            let (change, between) = place.steps.at_plate(last.as_slice(), &frame.walk(self.solver.tolerance));
            let change = DVector::from_vec(change);
            let size = change.amax() / (1.0 + place.point.amax());
            if !(size.is_finite() && between.is_finite()) {
                return None;
            }
            place.steps.adapt = size.max(between) > ROUGH;
            place.steps.advance(last.as_slice(), 1.0, 1.0);
            place.point += change;
            if size <= SETTLED && between <= BETWEEN * SETTLED {
                return Some(turn);
            }
        }
        None
    }

    /// What is known at an equilibrium; its tangent goes the way of a direction.
    fn node(&self, mut place: Place, along: &DVector<f64>) -> Option<Node> {
        place.steps.adapt = false;
        let found = self.evaluate(&mut place)?;
        let n = place.point.len() - 1;
        let mut unit = DVector::zeros(n + 1);
        unit[n] = 1.0;
        let pose = pose(&found);
        // A direction in which nothing holds the bundle, as that of a round column that has buckled, is left out: of both ways the one that turns less.
        let matrix = bordered(&found.matrix, &pose, along);
        let straightest = [matrix.clone().lu().solve(&unit), shortest(matrix, &unit)]
            .into_iter()
            .flatten()
            .map(|t| {
                let size = (&pose * &t).norm();
                t / size
            })
            .max_by(|a, b| along.dot(&(&pose * a)).total_cmp(&along.dot(&(&pose * b))));
        let tangent = straightest?;
        let crossing = found.determinant * sign_of(bordered(&found.matrix, &pose, &(&pose * &tangent)));
        let command = self.family.at(place.point[n]);
        let frame = Frame::new(self.solver.bundle, &command, self.solver.lengthening());
        let mut steps = place.steps.clone();
        steps.settle();
        let unknowns = place.point.as_slice()[..n].to_vec();
        let own = Found { unknowns, steps, determinant: f64::NAN, iterations: 0 };
        let mut equilibrium = self.solver.conclude(&frame, &command, own, f64::NAN);
        equilibrium.stable = equilibrium.inertia == Some(0);
        let whole = equilibrium.converged && tangent.iter().all(|t| t.is_finite());
        whole.then_some(Node { place, tangent, pose, slopes: found.matrix, crossing, equilibrium })
    }

    /// The node of the first equilibrium.
    fn begin(&self, start: &BundleEquilibrium) -> Option<Node> {
        if !start.converged {
            return None;
        }
        let command = self.family.in_full(0.0);
        let frame = Frame::new(self.solver.bundle, &command, self.solver.lengthening());
        let point = DVector::from_vec(frame.scaled(&start.unknowns)).push(0.0);
        let across = fraction_alone();
        let mut place = Place { point, steps: start.between.clone() };
        self.correct(&mut place, &across)?;
        // Where the equilibrium is singular the corrections may have left the beginning.
        let begins = place.point[place.point.len() - 1].abs() <= SETTLED;
        begins.then(|| self.node(place, &across)).flatten()
    }

    fn predicted(node: &Node, direction: &DVector<f64>, distance: f64) -> Place {
        let mut place = node.place.clone();
        let moved = place.steps.advance(direction.as_slice(), 0.0, distance);
        place.point += DVector::from_vec(moved);
        place
    }

    /// The node at a distance along the tangent of another one, and how many corrections that took.
    fn at(&self, here: &Node, distance: f64) -> Option<(Node, usize)> {
        let across = here.direction();
        let mut place = Self::predicted(here, &here.tangent, distance);
        let turns = self.correct(&mut place, &across)?;
        let next = self.node(place, &across)?;
        (across.dot(&next.direction()) >= STRAIGHT).then_some((next, turns))
    }

    /// The node at the end of the path, which lies before `next` at a distance.
    fn at_end(&self, here: &Node, next: &Node, distance: f64) -> Option<Node> {
        let end = next.fraction().clamp(0.0, 1.0);
        let share = (end - here.fraction()) / (next.fraction() - here.fraction());
        let mut place = Self::predicted(here, &here.tangent, share * distance);
        let n = place.point.len() - 1;
        place.point[n] = end;
        self.correct(&mut place, &fraction_alone())?;
        self.node(place, &here.direction())
    }

    /// The node at a distance, or at the end of the path where that is nearer; how many corrections it took, and whether the path ends there.
    fn next(&self, here: &Node, distance: f64) -> Option<(Node, usize, bool)> {
        let (next, turns) = self.at(here, distance)?;
        if (0.0..=1.0).contains(&next.fraction()) {
            return Some((next, turns, false));
        }
        Some((self.at_end(here, &next, distance)?, turns, true))
    }

    /// Follows a branch to its end; what is found on the way goes into `points` and `crossings`. `number` and depth are those of the branch.
    fn follow(
        &mut self,
        first: Node,
        points: &mut Vec<PathPoint<BundleEquilibrium>>,
        [number, depth]: [usize; 2],
        crossings: &mut Vec<Crossing>,
    ) -> End {
        let (longest, shortest) = (self.tracing.step, self.tracing.shortest);
        let mut step = 0.25 * longest;
        let mut here = first;
        loop {
            if points.len() >= self.tracing.points || self.left == 0 {
                return End::Points;
            }
            if self.stop.load(Ordering::Relaxed) {
                return End::Stopped;
            }
            self.left -= 1;
            let Some((next, turns, ended)) = self.next(&here, step) else {
                step *= 0.5;
                if step < shortest {
                    return End::Step;
                }
                continue;
            };
            self.between(&here, &next, step, points, [number, depth], crossings);
            points.push(self.point(&next, PointKind::Regular));
            if ended {
                return if next.fraction() > 0.5 { End::Last } else { End::First };
            }
            step = longest.min(step * if turns <= 4 { 1.5 } else { 1.0 });
            here = next;
        }
    }

    /// Places of the events between two neighbours.
    fn between(
        &self,
        here: &Node,
        next: &Node,
        step: f64,
        points: &mut Vec<PathPoint<BundleEquilibrium>>,
        [number, depth]: [usize; 2],
        crossings: &mut Vec<Crossing>,
    ) {
        let (folds, crosses) = (here.folds(next), here.crosses(next));
        let counts = here.equilibrium.inertia.zip(next.equilibrium.inertia);
        let changed = counts.map_or(0, |(a, b)| a.abs_diff(b));
        if folds && let Some(node) = self.locate(here, step, Node::advance) {
            points.push(self.point(&node, PointKind::Fold));
        }
        // Of a single eigenvalue the determinant knows, where it is known.
        let unknown = here.crossing.is_nan() || next.crossing.is_nan();
        let several = !folds && !crosses && changed > usize::from(!unknown);
        if !(crosses || several) {
            return;
        }
        let before = here.equilibrium.inertia;
        let place = if crosses {
            self.locate(here, step, |node| node.crossing)
        } else {
            self.locate(here, step, |node| if node.equilibrium.inertia == before { 1.0 } else { -1.0 })
        };
        let Some(node) = place else { return };
        let multiplicity = (changed - usize::from(folds && changed > 0)).max(1);
        let directions = Self::directions(&node, multiplicity);
        points.push(self.point(&node, PointKind::BranchPoint { multiplicity }));
        let known = crossings.iter().any(|old| {
            let (a, b) = (&old.node.place.point, &node.place.point);
            a.len() == b.len() && (a - b).amax() <= SAME * (1.0 + a.amax())
        });
        if !known {
            crossings.push(Crossing { branch: number, point: points.len() - 1, depth, node, directions });
        }
    }

    /// Where a number changes its sign within a step (Illinois's secant method).
    fn locate(&self, here: &Node, step: f64, test: impl Fn(&Node) -> f64) -> Option<Node> {
        let (mut a, mut b) = (0.0, step);
        let (mut at_a, mut at_b) = (test(here), test(&self.at(here, step)?.0));
        let mut found = None;
        for _ in 0..SEARCH {
            if (b - a).abs() <= self.tracing.tolerance.max(1e-7) {
                break;
            }
            // At a branch point itself the bordered matrix is singular: then nearby.
            let secant = (a * at_b - b * at_a) / (at_b - at_a);
            let places = [secant, 0.5 * (a + b), 0.9 * secant + 0.1 * a, 0.9 * secant + 0.1 * b];
            let Some((middle, node)) = places.into_iter().find_map(|at| Some((at, self.at(here, at)?.0)))
            else {
                break;
            };
            let value = test(&node);
            if value * at_b < 0.0 {
                (a, at_a) = (b, at_b);
            } else {
                at_a *= 0.5;
            }
            (b, at_b) = (middle, value);
            found = Some(node);
            if value.abs() <= 0.0 || value.is_nan() {
                break;
            }
        }
        found
    }

    /// Directions in which other branches leave: where the bordered matrix gives way.
    fn directions(node: &Node, multiplicity: usize) -> Vec<DVector<f64>> {
        let svd = bordered(&node.slopes, &node.pose, &node.direction()).svd(false, true);
        let Some(right) = svd.v_t else { return Vec::new() };
        let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
        order.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
        let direction = |&i: &usize| {
            let own = right.row(i).transpose();
            let size = (&node.pose * &own).norm();
            own / size
        };
        order.iter().take(multiplicity).map(direction).filter(|d| d.iter().all(|x| x.is_finite())).collect()
    }

    /// The first node on another branch.
    fn leave(&self, node: &Node, direction: &DVector<f64>, along: bool) -> Option<Node> {
        let direction = if along { direction.clone() } else { -direction };
        let across = &node.pose * &direction;
        let mut distance = ASIDE * self.tracing.step;
        for _ in 0..8 {
            let mut place = Self::predicted(node, &direction, distance);
            if self.correct(&mut place, &across).is_some()
                && let Some(next) = self.node(place, &across)
            {
                return Some(next);
            }
            distance *= 0.5;
        }
        None
    }
}
