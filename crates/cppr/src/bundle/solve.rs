//! Solver of any bundle: motors, loads, equilibria; from rest, from a neighbour, in steps.

use super::Bundle;
pub use super::command::{BundleCommand, TubeDrive};
use super::course::Course;
pub use super::equilibrium::{BundleEquilibrium, TubeEffort, load_behind_plate};
use super::frame::{Frame, Unknowns};
pub(crate) use super::load_path::PathEnd;
use super::load_path::{Guess, follow};
use super::newton::{Budget, Found, SETTLED, SETTLED_NEAR, Tangent, newton};
use super::prepared::{GIVE, Lengthening};
use super::sensitivity::section_frame;
use super::steps::Steps;
use super::walk::{Base, Outcome, Walk};
use crate::statics::Loads;
use nalgebra::{Matrix3, Vector3};

/// Solver of one bundle.
#[derive(Clone, Debug)]
pub struct BundleSolver<'a> {
    pub(super) bundle: &'a Bundle,
    /// Error allowed in one step of the integration, in scaled variables.
    pub(super) tolerance: f64,
    /// The same from one pose of a control loop to the next.
    loop_tolerance: f64,
    /// Are the tubes' centroid lines extensible?
    pub(super) stretch: bool,
    /// Do tubes give way at joints, see [`GIVE`]?
    gives: bool,
    rest: Option<BundleEquilibrium>,
    references: Vec<(Kinds, f64)>,
}

/// Error allowed in one step where nothing else is said.
const TOLERANCE: f64 = 1e-8;
/// Newton steps of a solve.
const ITERATIONS: usize = 40;
/// Part of the way below which a step may be shortened.
const SHORT: f64 = 1.0 / 64.0;
/// Newton steps towards an equilibrium that is near already.
const ITERATIONS_NEAR: usize = 25;
/// Newton steps of one load step while tubes come to curve.
const ITERATIONS_IN_STEPS: usize = 15;

/// Kinds of the drives of every tube, and whether there are loads: the conditions at rest have one determinant for each.
type Kinds = (Vec<[bool; 2]>, [bool; 2]);

fn kinds(command: &BundleCommand, frame: &Frame) -> Kinds {
    let drives = command.drives.iter().map(|d| [d.translation.is_motion(), d.rotation.is_motion()]);
    (drives.collect(), [frame.prepared.loaded, frame.prepared.seeks_force])
}

/// Have as many eigenvalues changed their signs since rest as makes an even number? Where conditions are singular nobody knows.
fn as_at_rest(found: &Found, reference: f64) -> bool {
    let share = found.determinant / reference;
    share.is_nan() || share > 0.0
}

impl<'a> BundleSolver<'a> {
    /// A solver with a tolerance of 1e-8 for one step.
    #[must_use]
    pub fn new(bundle: &'a Bundle) -> Self {
        Self {
            bundle,
            tolerance: TOLERANCE,
            loop_tolerance: TOLERANCE,
            stretch: false,
            gives: false,
            rest: None,
            references: Vec::new(),
        }
    }

    /// The same with another error allowed in one step, in units of the length, of EI/L² and of their product; 1e-8 is the default.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, loop_tolerance: tolerance, ..Self::new(self.bundle) }.with_stretch(self.stretch)
    }

    /// The same whose [control loops](Self::solve_into) allow another error in one step than solves from rest: 1e-6 takes up to half the time, and leaves the tip within
    /// 1e-5 of the length on random bundles, forces within 5e-5 and the tip's Jacobian within 1e-3 of themselves on the reference cases.
    #[must_use]
    pub fn with_loop_tolerance(self, loop_tolerance: f64) -> Self {
        Self { loop_tolerance, ..self }
    }

    /// The same with centroid lines that are extensible or not.
    #[must_use]
    pub fn with_stretch(self, stretch: bool) -> Self {
        let Self { bundle, tolerance, loop_tolerance, .. } = self;
        Self { tolerance, loop_tolerance, stretch, ..Self::new(bundle) }
    }

    /// One of another bundle, with the same settings.
    #[must_use]
    pub fn of_another<'b>(&self, bundle: &'b Bundle) -> BundleSolver<'b> {
        let own = BundleSolver::new(bundle).with_tolerance(self.tolerance).with_stretch(self.stretch);
        own.with_loop_tolerance(self.loop_tolerance)
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
            Some(rest) => self.sought_from(command, &rest),
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
        let at_once = newton(&frame, &walk, start, Steps::default(), Budget::far(ITERATIONS), SETTLED).ok();
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
            let (start, steps) = guess.at(&frame, share, self.tolerance);
            let budget = Budget::far(ITERATIONS_IN_STEPS);
            let found = newton(&frame, &frame.walk(self.tolerance), start, steps, budget, SETTLED).ok()?;
            let reference = *straight.get_or_insert(found.determinant);
            as_at_rest(&found, reference).then(|| (frame.unknowns(&found.unknowns), found))
        });
        path.ok().map(conclude).or(at_once)
    }

    pub(super) fn lengthening(&self) -> Lengthening {
        Lengthening { stretch: self.stretch, give: if self.gives { GIVE } else { 0.0 } }
    }

    /// The determinant of the conditions at rest, for the kinds of drives and loads of a command.
    pub(super) fn rest_determinant(&mut self, command: &BundleCommand) -> f64 {
        let Some(rest) = self.rest() else { return f64::NAN };
        let (start, between) = (rest.unknowns.clone(), rest.between.clone());
        let odd = rest.inertia.is_some_and(|negative| negative % 2 == 1);
        let still = command.between(&self.held(), 0.0);
        let frame = Frame::new(self.bundle, &still, self.lengthening());
        let kinds = kinds(command, &frame);
        if let Some((_, known)) = self.references.iter().find(|(own, _)| *own == kinds) {
            return *known;
        }
        let start = frame.scaled(&start);
        let budget = Budget::far(ITERATIONS);
        let found = newton(&frame, &frame.walk(self.tolerance), start, between, budget, SETTLED);
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
            lengthening: Lengthening::default(),
            unknowns: Unknowns::default(),
            between: Steps::default(),
            command: command.clone(),
            slopes: None,
        }
    }

    /// The same from a neighbour: where it is near, Newton's method leads from one stable equilibrium to the next.
    pub fn solve_from(&mut self, command: &BundleCommand, start: &BundleEquilibrium) -> BundleEquilibrium {
        if start.converged && start.stable && command.share_of_turn(&start.command) >= 1.0 {
            let frame = Frame::new(self.bundle, command, self.lengthening());
            let found = self.tracked(&frame, command, start, self.tolerance).filter(|found| found.stable);
            if let Some(mut found) = found {
                found.error = self.error_in(&frame, &found);
                return found;
            }
        }
        self.sought_from(command, start)
    }

    fn sought_from(&mut self, command: &BundleCommand, start: &BundleEquilibrium) -> BundleEquilibrium {
        let reference = self.rest_determinant(command);
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let walk = frame.walk(self.tolerance);
        let share = command.share_of_turn(&start.command);
        let within = |budget: Budget| {
            let begin = frame.scaled(&start.unknowns);
            newton(&frame, &walk, begin, start.between.coarsened(self.tolerance), budget, SETTLED).ok()
        };
        let at_once = if share >= 1.0 { within(Budget::DIRECT) } else { None };
        let (found, ended) = match at_once {
            Some(found) if as_at_rest(&found, reference) => (Some(found), None),
            _ => match self.in_steps(command, start, reference, share) {
                Ok(found) => (Some(found), None),
                Err(end) => (within(Budget::far(ITERATIONS)), Some(end)),
            },
        };
        let Some(found) = found else {
            return BundleEquilibrium { ended, ..Self::lost(command) };
        };
        let mut found = self.conclude(&frame, command, found, reference);
        found.error = self.error_in(&frame, &found);
        found.ended = ended;
        found
    }

    /// The equilibrium to which Newton's method leads from a neighbour, without steps on the way; its error is not estimated. `None` where it leads nowhere.
    #[must_use]
    pub fn continued(
        &mut self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
    ) -> Option<BundleEquilibrium> {
        let frame = Frame::new(self.bundle, command, self.lengthening());
        if let Some(found) = self.tracked(&frame, command, start, self.tolerance) {
            return Some(found);
        }
        let reference = self.rest_determinant(command);
        let (begin, steps) = (frame.scaled(&start.unknowns), start.between.coarsened(self.tolerance));
        let budget = Budget::far(ITERATIONS_IN_STEPS);
        let found = newton(&frame, &frame.walk(self.tolerance), begin, steps, budget, SETTLED).ok()?;
        Some(self.conclude(&frame, command, found, reference))
    }

    /// Solves from an equilibrium in its place, as a control loop does: on the tangent of the path, without an estimate of the error, and as [`Self::solve_from`]
    /// where that leads nowhere, from a stable equilibrium to none, or where a motor turns far.
    pub fn solve_into(&mut self, command: &BundleCommand, equilibrium: &mut BundleEquilibrium) {
        let near = command.share_of_turn(&equilibrium.command) >= 1.0 && equilibrium.converged;
        let frame = Frame::new(self.bundle, command, self.lengthening());
        let found = if near { self.tracked(&frame, command, equilibrium, self.loop_tolerance) } else { None };
        let as_stable = |found: &BundleEquilibrium| found.stable || !equilibrium.stable;
        let found = found.filter(as_stable).unwrap_or_else(|| self.sought_from(command, equilibrium));
        *equilibrium = found;
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
            let budget = Budget::far(ITERATIONS_NEAR);
            newton(&frame, walk, start.clone(), Steps::default(), budget, SETTLED_NEAR).ok()
        };
        let found = from(&walk).or_else(|| from(&Walk { course: None, ..walk }))?;
        let found = self.conclude(&frame, command, found, f64::NAN);
        found.converged.then_some(found)
    }

    /// Moves from a neighbour to the command in steps, none longer than `longest`, that halve where Newton's method does not arrive with whole steps at an
    /// equilibrium as stable as the last.
    fn in_steps(
        &self,
        command: &BundleCommand,
        start: &BundleEquilibrium,
        reference: f64,
        longest: f64,
    ) -> Result<Found, PathEnd> {
        follow(Guess::new(start.unknowns.clone(), start.between.clone()), longest, |share, guess| {
            let step = guess.way_to(share);
            let target = command.between(&start.command, share);
            let frame = Frame::new(self.bundle, &target, self.lengthening());
            let (start, steps) = guess.at(&frame, share, self.tolerance);
            let budget = if step <= SHORT { Budget::DIRECT } else { Budget::WHOLE };
            let found = newton(&frame, &frame.walk(self.tolerance), start, steps, budget, SETTLED).ok()?;
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
        let determinant = found.determinant;
        let Some(mut found) = self.posed(frame, command, found) else { return Self::lost(command) };
        self.judge(&mut found, determinant, reference);
        found
    }

    /// What was found with the pose of its tip; whether it is stable is not known yet.
    pub(super) fn posed(
        &self,
        frame: &Frame,
        command: &BundleCommand,
        mut found: Found,
    ) -> Option<BundleEquilibrium> {
        let walk = Walk { posed: true, ..frame.walk(self.tolerance) };
        let base = frame.base(&found.unknowns, &frame.drives());
        // The pose may ask for shorter steps than what the conditions needed.
        found.steps.adapt = true;
        let outcome = walk.run(&base, &mut found.steps, None).ok()?;
        let Found { unknowns, steps, iterations, .. } = found;
        Some(self.report(frame, command, &unknowns, steps, iterations, &outcome))
    }

    pub(super) fn report(
        &self,
        frame: &Frame,
        command: &BundleCommand,
        unknowns: &[f64],
        steps: Steps,
        iterations: usize,
        outcome: &Outcome<f64>,
    ) -> BundleEquilibrium {
        let base = frame.base(unknowns, &frame.drives());
        let efforts = base.tubes.iter().map(|t| TubeEffort {
            label: t.label,
            rotation: t.angle,
            force: t.tension,
            torque: -t.torque,
        });
        BundleEquilibrium {
            converged: true,
            efforts: efforts.collect(),
            tip: Vector3::from(outcome.centre),
            frame: section_frame(outcome),
            length: outcome.length,
            stable: false,
            inertia: None,
            ended: None,
            steps: steps.count(),
            iterations,
            error: [f64::NAN; 2],
            lengthening: self.lengthening(),
            unknowns: frame.unknowns(unknowns),
            between: steps,
            command: command.clone(),
            slopes: None,
        }
    }

    /// Says whether an equilibrium is stable: by the count of negative eigenvalues, and by the determinant, which changes its sign with every one, and exactly
    /// there; it is known but for that at rest.
    pub(super) fn judge(&self, found: &mut BundleEquilibrium, determinant: f64, reference: f64) {
        let even = determinant / reference;
        found.inertia = self.inertia(found);
        found.stable = match found.inertia {
            Some(0) => even.is_nan() || even > 0.0,
            Some(1) | None => even > 0.0,
            Some(_) => false,
        };
    }

    /// How far the tip (m) and the greatest of the forces (N) move when every step of the integration is halved: the error of an equilibrium that was
    /// found without one.
    #[must_use]
    pub fn error(&self, equilibrium: &BundleEquilibrium) -> [f64; 2] {
        self.error_in(&Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening), equilibrium)
    }

    fn error_in(&self, frame: &Frame, equilibrium: &BundleEquilibrium) -> [f64; 2] {
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
        let frame = Frame::new(self.bundle, &equilibrium.command, equilibrium.lengthening);
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
