//! Solver of any bundle: motors, loads, equilibria; from rest, from a neighbour, in steps.

use super::Bundle;
use super::course::Course;
use super::frame::{Frame, Unknowns};
use super::newton::{Found, SETTLED, Tangent, newton};
use super::prepared::{GIVE, Lengthening};
use super::sensitivity::section_frame;
use super::steps::Steps;
use super::walk::{Base, Walk};
use crate::solve::{Drive, Freedom, Input, Reason, Status};
use crate::statics::{Loads, Station};
use nalgebra::{Matrix3, Vector3};

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
    /// What is prescribed: translation and rotation of tube 1, then of tube 2, …
    #[must_use]
    pub fn inputs(&self) -> Vec<Input> {
        let own = |(tube, drive): (usize, &TubeDrive)| {
            [(Freedom::PushPull, drive.translation), (Freedom::Rotation, drive.rotation)]
                .map(|(freedom, told)| Input { tube, freedom, is_motion: told.is_motion() })
        };
        (1..).zip(&self.drives).flat_map(own).collect()
    }

    /// The same command with one input at another value; an input that is not there changes nothing.
    #[must_use]
    pub fn with_input(&self, input: Input, value: f64) -> Self {
        let mut command = self.clone();
        if let Some(own) = input.tube.checked_sub(1).and_then(|tube| command.drives.get_mut(tube)) {
            *(match input.freedom {
                Freedom::PushPull => &mut own.translation,
                Freedom::Rotation => &mut own.rotation,
            }) = input.prescribed(value);
        }
        command
    }

    pub(crate) fn between(&self, start: &Self, share: f64) -> Self {
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

impl BundleCommand {
    /// Which part of the way from another command turns no motor by more than [`LONGEST_TURN`].
    fn share_of_turn(&self, start: &Self) -> f64 {
        let drives = self.drives.iter().zip(&start.drives);
        let turned = |(a, b): (&TubeDrive, &TubeDrive)| {
            let both = a.rotation.motion().zip(b.rotation.motion());
            both.map_or(0.0, |(to, from)| (to - from).abs())
        };
        LONGEST_TURN / drives.map(turned).fold(LONGEST_TURN, f64::max)
    }
}

/// Label (m) of a load that acts on what was drawn in behind the plate, if there is one.
#[must_use]
pub fn load_behind_plate(command: &BundleCommand, found: &BundleEquilibrium) -> Option<f64> {
    let plate = found.efforts.first()?.label;
    let wrenches = command.loads.wrenches.iter().filter_map(|w| match w.station {
        Station::Label(label) => Some(label),
        Station::Tip => None,
    });
    wrenches.chain(command.loads.distributed.iter().map(|d| d.from)).find(|label| *label < plate)
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
    /// Has the second variation no negative eigenvalue, see [`BundleSolver::inertia`]?
    pub stable: bool,
    /// What [`BundleSolver::inertia`] counted.
    pub(crate) inertia: Option<usize>,
    /// Where the path of stable equilibria from rest or a neighbour ended, if it did not arrive.
    pub(crate) ended: Option<PathEnd>,
    /// Steps of the integration, and Newton steps.
    pub steps: usize,
    /// Newton steps.
    pub iterations: usize,
    /// How far tip (m) and forces (N) move when every step is halved.
    pub error: [f64; 2],
    pub(super) unknowns: Unknowns,
    /// States at the ends of the steps.
    pub(super) between: Steps,
    pub(super) command: BundleCommand,
}

impl BundleEquilibrium {
    /// What became of the command, in a sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let end = match self.ended {
            None => "no equilibrium was found with all motors held and no load".into(),
            Some(PathEnd { share, .. }) if share <= 0.0 => {
                "no equilibrium was found for even the first small part of the command".into()
            }
            Some(PathEnd { share, turns: true }) => format!(
                "stable equilibria were followed to {:.1} % of the command, where they end in a fold or lose their stability: \
                 the robot snaps there",
                100.0 * share
            ),
            Some(PathEnd { share, turns: false }) => {
                format!("no equilibrium was found beyond {:.1} % of the command", 100.0 * share)
            }
        };
        match (self.converged, self.stable, self.ended) {
            (false, ..) => format!(
                "{end}; command less, or look whether tubes reach their joints with these pulls and whether tubes without lever are \
                 pulled against each other"
            ),
            (true, true, Some(_)) => format!("converged, stable, but {end}: another branch"),
            (true, false, Some(_)) => format!("converged, unstable; {end}"),
            (true, _, None) => self.status().to_string(),
        }
    }

    /// What it is the equilibrium under.
    #[must_use]
    pub fn command(&self) -> &BundleCommand {
        &self.command
    }

    /// Whether it was found, and is stable.
    #[must_use]
    pub fn status(&self) -> Status {
        match (self.converged, self.stable) {
            (true, true) => Status::Converged,
            (true, false) => Status::Unstable,
            (false, _) => {
                Status::NotConverged(Reason::PathEnds { fraction: self.ended.map_or(0.0, |end| end.share) })
            }
        }
    }
}

/// Solver of one bundle.
#[derive(Clone, Debug)]
pub struct BundleSolver<'a> {
    pub(super) bundle: &'a Bundle,
    /// Error allowed in one step of the integration, in scaled variables.
    pub(super) tolerance: f64,
    /// Are the tubes' centroid lines extensible?
    pub(super) stretch: bool,
    /// Do tubes give way at joints, see [`GIVE`]?
    gives: bool,
    rest: Option<BundleEquilibrium>,
    references: Vec<(Kinds, f64)>,
}

/// Longest turn of a motor (rad) in one step: further on, two eigenvalues may have changed their signs, and the determinant that of neither.
const LONGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;
/// Newton steps of a solve.
const ITERATIONS: usize = 40;
const SHORTEST_STEP: f64 = 1.0 / 4096.0;
/// Newton steps after which an equilibrium may be one of another branch than that from which it was sought.
const DIRECT: usize = 12;
/// Newton steps towards an equilibrium that is near already, and the scaled step with which they end: what is left is of its square.
const ITERATIONS_NEAR: usize = 25;
const SETTLED_NEAR: f64 = 1e-5;
/// Newton steps of one load step, and how many make it an easy one.
const ITERATIONS_IN_STEPS: usize = 15;
const EASY: usize = 6;
/// Load steps.
const MOST_STEPS: usize = 400;
/// By this factor at least the determinant falls from one of the shortest steps to the next where an eigenvalue vanishes.
const TURNING: f64 = 0.8;

/// Kinds of the drives of every tube, and whether there are loads: the conditions at rest have one determinant for each.
type Kinds = (Vec<[bool; 2]>, [bool; 2]);

/// Have as many eigenvalues changed their signs since rest as makes an even number? Where conditions are singular nobody knows.
fn as_at_rest(found: &Found, reference: f64) -> bool {
    let share = found.determinant / reference;
    share.is_nan() || share > 0.0
}

/// Where a path from a neighbour to a command ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathEnd {
    /// Share of the way on which equilibria as stable as the first were found.
    pub share: f64,
    /// Does an eigenvalue of theirs vanish there?
    pub turns: bool,
}

/// Where the next equilibrium of a path is sought: states at the last and the one before, each with its share of the way.
struct Guess {
    last: (f64, Unknowns, Steps),
    before: Option<(f64, Unknowns, Steps)>,
}

impl Guess {
    fn new(unknowns: Unknowns, steps: Steps) -> Self {
        Self { last: (0.0, unknowns, steps), before: None }
    }

    /// On the line through both.
    fn at(&self, frame: &Frame, share: f64) -> (Vec<f64>, Steps) {
        let (reached, unknowns, between) = &self.last;
        let (mut start, mut steps) = (frame.scaled(unknowns), between.coarsened());
        if let Some((from, unknowns, between)) = &self.before {
            let factor = (share - reached) / (reached - from);
            for (own, old) in start.iter_mut().zip(frame.scaled(unknowns)) {
                *own += factor * (*own - old);
            }
            steps.extrapolate(between, factor);
        }
        (start, steps)
    }
}

/// Goes along a path in steps, none longer than `longest`, to its end at 1. `attempt` finds the equilibrium at a share of the way; a step to where it finds
/// none is halved.
fn follow(
    mut guess: Guess,
    longest: f64,
    mut attempt: impl FnMut(f64, &Guess) -> Option<(Unknowns, Found)>,
) -> Result<Found, PathEnd> {
    let mut step = longest.min(0.25);
    // Determinants at the last three places.
    let mut determinants = [f64::NAN; 3];
    for _ in 0..MOST_STEPS {
        let reached = guess.last.0;
        let next = f64::min(1.0, reached + step);
        match attempt(next, &guess) {
            Some((_, found)) if next >= 1.0 => return Ok(found),
            Some((unknowns, found)) => {
                step = longest.min(step * if found.iterations <= EASY { 2.0 } else { 1.0 });
                determinants = [determinants[1], determinants[2], found.determinant.abs()];
                guess.before = Some(std::mem::replace(&mut guess.last, (next, unknowns, found.steps)));
            }
            None => step *= 0.5,
        }
        if step < SHORTEST_STEP {
            break;
        }
    }
    // The steps shrink towards a place where an eigenvalue vanishes, and the determinant with it.
    let [first, second, third] = determinants;
    Err(PathEnd { share: guess.last.0, turns: third < TURNING * second && second < first })
}

impl<'a> BundleSolver<'a> {
    /// A solver with a tolerance of 1e-8 for one step.
    #[must_use]
    pub fn new(bundle: &'a Bundle) -> Self {
        Self { bundle, tolerance: 1e-8, stretch: false, gives: false, rest: None, references: Vec::new() }
    }

    /// The same with another error allowed in one step, in units of the length, of EI/L² and of their product.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..Self::new(self.bundle) }.with_stretch(self.stretch)
    }

    /// The same with centroid lines that are extensible or not.
    #[must_use]
    pub fn with_stretch(self, stretch: bool) -> Self {
        Self { stretch, tolerance: self.tolerance, ..Self::new(self.bundle) }
    }

    /// What it solves.
    #[must_use]
    pub fn bundle(&self) -> &'a Bundle {
        self.bundle
    }

    /// All motors held, no load.
    #[must_use]
    pub fn held(&self) -> BundleCommand {
        BundleCommand { drives: vec![TubeDrive::HELD; self.bundle.tubes.len()], loads: Loads::none() }
    }

    /// Solves for the equilibrium under a command, from rest: in one go, and where that does not arrive at a stable one in steps.
    pub fn solve(&mut self, command: &BundleCommand) -> BundleEquilibrium {
        match self.rest().cloned() {
            Some(rest) => self.solve_from(command, &rest),
            None => Self::lost(command),
        }
    }

    /// The equilibrium with all motors held and no load, found once and kept: where tubes are curved when free that is a solve of its
    /// own. `None` where it was not found.
    pub fn rest(&mut self) -> Option<&BundleEquilibrium> {
        if self.rest.is_none() {
            let held = self.held();
            let (rest, determined) = self.unbent(&held)?;
            self.rest = Some(rest);
            if !determined && !self.gives {
                self.gives = true;
                self.rest = Some(self.unbent(&held)?.0);
            }
        }
        self.rest.as_ref()
    }

    /// Rest, from straight tubes: in one go, and where that does not arrive at a stable one with tubes that curve more and more. Also whether all forces
    /// are determined.
    fn unbent(&self, held: &BundleCommand) -> Option<(BundleEquilibrium, bool)> {
        let frame = Frame::new(self.bundle, held, self.lengthening());
        let start = frame.scaled(&Unknowns::default());
        let walk = frame.walk(self.tolerance);
        let at_once = newton(&frame, &walk, start, Steps::default(), ITERATIONS, SETTLED).ok();
        let conclude = |found: Found| {
            let determined = !found.determinant.is_nan();
            (self.conclude(&frame, held, found, f64::NAN), determined)
        };
        let at_once = at_once.map(conclude);
        if at_once.as_ref().is_some_and(|(found, determined)| found.stable || !determined) {
            return at_once;
        }
        let mut straight = None;
        let path = follow(Guess::new(Unknowns::default(), Steps::default()), 1.0, |share, guess| {
            let bundle = self.bundle.curved_by(share);
            let frame = Frame::new(&bundle, held, self.lengthening());
            let (start, steps) = guess.at(&frame, share);
            let found =
                newton(&frame, &frame.walk(self.tolerance), start, steps, ITERATIONS_IN_STEPS, SETTLED)
                    .ok()?;
            let reference = *straight.get_or_insert(found.determinant);
            as_at_rest(&found, reference).then(|| (frame.unknowns(&found.unknowns), found))
        });
        path.ok().map(conclude).or(at_once)
    }

    pub(super) fn lengthening(&self) -> Lengthening {
        Lengthening { stretch: self.stretch, give: if self.gives { GIVE } else { 0.0 } }
    }

    /// The determinant of the conditions at rest, for the kinds of drives and loads of a command.
    fn rest_determinant(&mut self, command: &BundleCommand) -> f64 {
        let Some(rest) = self.rest() else { return f64::NAN };
        let (start, between) = (rest.unknowns.clone(), rest.between.clone());
        let odd = rest.inertia.is_some_and(|negative| negative % 2 == 1);
        let still = command.between(&self.held(), 0.0);
        let frame = Frame::new(self.bundle, &still, self.lengthening());
        let drives = command.drives.iter().map(|d| [d.translation.is_motion(), d.rotation.is_motion()]);
        let kinds: Kinds = (drives.collect(), [frame.prepared.loaded, frame.prepared.seeks_force]);
        if let Some((_, known)) = self.references.iter().find(|(own, _)| *own == kinds) {
            return *known;
        }
        let start = frame.scaled(&start);
        let found = newton(&frame, &frame.walk(self.tolerance), start, between, ITERATIONS, SETTLED);
        let determinant = found.map_or(f64::NAN, |found| found.determinant);
        // As it were at a stable rest.
        let determinant = if odd { -determinant } else { determinant };
        self.references.push((kinds, determinant));
        determinant
    }

    fn lost(command: &BundleCommand) -> BundleEquilibrium {
        BundleEquilibrium {
            converged: false,
            efforts: Vec::new(),
            tip: Vector3::zeros(),
            frame: Matrix3::identity(),
            length: 0.0,
            stable: false,
            inertia: None,
            ended: None,
            steps: 0,
            iterations: 0,
            error: [f64::NAN; 2],
            unknowns: Unknowns::default(),
            between: Steps::default(),
            command: command.clone(),
        }
    }

    /// The same from a neighbour.
    pub fn solve_from(&mut self, command: &BundleCommand, start: &BundleEquilibrium) -> BundleEquilibrium {
        let reference = self.rest_determinant(command);
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let walk = frame.walk(self.tolerance);
        let share = command.share_of_turn(&start.command);
        let direct = || {
            let begin = frame.scaled(&start.unknowns);
            newton(&frame, &walk, begin, start.between.coarsened(), ITERATIONS, SETTLED).ok()
        };
        let at_once = if share >= 1.0 { direct() } else { None };
        let (found, ended) = match at_once {
            Some(found) if as_at_rest(&found, reference) && found.iterations <= DIRECT => (Some(found), None),
            other => match self.in_steps(command, start, reference, share) {
                Ok(found) => (Some(found), None),
                Err(end) => (other.or_else(direct), Some(end)),
            },
        };
        let Some(found) = found else {
            return BundleEquilibrium { ended, ..Self::lost(command) };
        };
        let mut found = self.conclude(&frame, command, found, reference);
        found.error = self.error(&frame, &found);
        found.ended = ended;
        found
    }

    /// The equilibrium to which Newton's method leads from a neighbour, without steps on the way; its error is not estimated.
    #[must_use]
    pub fn continued(
        &mut self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
    ) -> Option<BundleEquilibrium> {
        let reference = self.rest_determinant(command);
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let begin = frame.scaled(&start.unknowns);
        let walk = frame.walk(self.tolerance);
        let found =
            newton(&frame, &walk, begin, start.between.coarsened(), ITERATIONS_IN_STEPS, SETTLED).ok()?;
        Some(self.conclude(&frame, command, found, reference))
    }

    /// The equilibrium that Newton's method finds near given forces and a course of the tubes.
    pub(crate) fn near(
        &self,
        command: &BundleCommand,
        start: &Unknowns,
        course: &Course,
    ) -> Option<BundleEquilibrium> {
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let walk = Walk { course: Some(course), ..frame.walk(self.tolerance) };
        let mut start = start.clone();
        let base = frame.base(&frame.scaled(&start), &frame.drives());
        if let (Some(tension), Some(leader)) = (walk.leader_tension(&base), start.tubes.first_mut()) {
            leader[1] = tension;
        }
        let start = frame.scaled(&start);
        let from = |walk: &Walk| {
            newton(&frame, walk, start.clone(), Steps::default(), ITERATIONS_NEAR, SETTLED_NEAR).ok()
        };
        let found = from(&walk).or_else(|| from(&Walk { course: None, ..walk }))?;
        let found = self.conclude(&frame, command, found, f64::NAN);
        found.converged.then_some(found)
    }

    /// Moves from a neighbour to the command in steps, none longer than `longest`, that halve where Newton's method does not arrive at an
    /// equilibrium as stable as the last.
    fn in_steps(
        &self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
        reference: f64,
        longest: f64,
    ) -> Result<Found, PathEnd> {
        follow(Guess::new(start.unknowns.clone(), start.between.clone()), longest, |share, guess| {
            let target = command.between(&start.command, share);
            let frame = Frame::new(self.bundle, &target, self.lengthening());
            let (start, steps) = guess.at(&frame, share);
            let found =
                newton(&frame, &frame.walk(self.tolerance), start, steps, ITERATIONS_IN_STEPS, SETTLED)
                    .ok()?;
            as_at_rest(&found, reference).then(|| (frame.unknowns(&found.unknowns), found))
        })
    }

    pub(super) fn conclude(
        &self,
        frame: &Frame,
        command: &BundleCommand,
        found: Found,
        reference: f64,
    ) -> BundleEquilibrium {
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let base = frame.base(&found.unknowns, &frame.drives());
        let determinant = found.determinant;
        // The pose may ask for shorter steps than what the conditions needed.
        let mut steps = found.steps;
        steps.adapt = true;
        let Ok(outcome) = walk.run(&base, &mut steps, None) else {
            return Self::lost(command);
        };
        let efforts = base.tubes.iter().map(|t| TubeEffort {
            label: t.label,
            rotation: t.angle,
            force: t.tension,
            torque: -t.torque,
        });
        let mut found = BundleEquilibrium {
            converged: true,
            efforts: efforts.collect(),
            tip: Vector3::from(outcome.centre),
            frame: section_frame(&outcome),
            length: outcome.length,
            stable: false,
            inertia: None,
            ended: None,
            steps: steps.count(),
            iterations: found.iterations,
            error: [f64::NAN; 2],
            unknowns: frame.unknowns(&found.unknowns),
            between: steps,
            command: command.clone(),
        };
        // The determinant changes its sign with every eigenvalue, and exactly there; it is known but for that at rest.
        let even = determinant / reference;
        found.inertia = self.inertia(&found);
        found.stable = match found.inertia {
            Some(0) => even.is_nan() || even > 0.0,
            Some(1) | None => even > 0.0,
            Some(_) => false,
        };
        found
    }

    /// How far the tip (m) and the greatest of the forces (N) move when every step of the integration is halved.
    fn error(&self, frame: &Frame, equilibrium: &BundleEquilibrium) -> [f64; 2] {
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let unknowns = frame.scaled(&equilibrium.unknowns);
        let mut halved = equilibrium.between.halved();
        let finer = Tangent::new(frame, &unknowns, &walk, &mut halved).ok();
        let moved = finer.and_then(|finer| {
            let last = finer.matrix.lu().solve(&-finer.residual)?;
            let moved = finer.pose_slopes.rows(0, 3) * &last * self.bundle.length;
            let tip = (finer.tip + moved - equilibrium.tip).norm();
            let (change, _) = halved.at_plate(last.as_slice(), &walk);
            let moved: Vec<f64> = unknowns.iter().zip(change.iter()).map(|(u, c)| u + c).collect();
            Some((tip, frame.unknowns(&moved)))
        });
        let Some((tip, moved)) = moved else { return [f64::NAN; 2] };
        let pairs = moved.tubes.iter().zip(&equilibrium.unknowns.tubes);
        [tip, pairs.fold(0.0, |most: f64, (a, b)| most.max((a[1] - b[1]).abs()))]
    }

    /// Gives the walk and its start at an equilibrium.
    pub(super) fn with_walk<T>(
        &self,
        equilibrium: &BundleEquilibrium,
        look: impl FnOnce(Walk, &Base<f64>) -> T,
    ) -> T {
        let frame = Frame::new(self.bundle, &equilibrium.command, self.lengthening());
        let base = frame.base(&frame.scaled(&equilibrium.unknowns), &frame.drives());
        look(frame.walk(self.tolerance), &base)
    }
}

#[cfg(test)]
mod tests {
    use super::BundleSolver;
    use crate::bundle::{Bundle, BundleDesign, Part, TubeParts};
    use crate::design::StiffnessTube;
    use crate::solve::Drive;

    /// The rest of curved tubes is a solve, done once: later solves begin there and are judged by it, as marks in what is kept show.
    #[test]
    fn rest_of_curved_tubes_is_solved_once() {
        let tube = |length: f64, curvature: f64, direction: f64| TubeParts {
            parts: vec![Part {
                length,
                body: StiffnessTube::uniform(0.0, 0.0, [2e-3, 2e-3], 1.5e-3).into(),
                rest_curvature: curvature,
                rest_direction: direction,
            }],
            shaft: None,
        };
        let tubes = vec![tube(0.1, 5.0, 0.0), tube(0.12, 3.0, 1.0)];
        let bundle = Bundle::new(&BundleDesign { name: "curved".into(), tubes, joints: Vec::new() }).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let commands = [0.3, 0.5].map(|angle| {
            let mut command = solver.held();
            command.drives[1].rotation = Drive::Motion(angle);
            command
        });
        assert!(solver.rest.is_none());
        let first = solver.solve(&commands[0]);
        assert!(first.converged && first.stable);
        let rest = solver.rest.as_mut().unwrap();
        assert!(
            rest.converged && rest.iterations > 1 && rest.tip.x < 0.119,
            "rest is bent, and not known beforehand"
        );
        rest.iterations = 1000;
        assert_eq!(solver.references.len(), 1);
        solver.references[0].1 *= -1.0;
        let second = solver.solve(&commands[1]);
        assert_eq!((solver.rest().unwrap().iterations, solver.references.len()), (1000, 1));
        assert!(second.converged && !second.stable, "judged by the determinant that is kept");
        // What was found with other settings is no rest of these.
        assert!(solver.with_stretch(false).rest.is_none());
    }
}
