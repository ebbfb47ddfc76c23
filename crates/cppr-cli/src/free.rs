//! Actuators that the program may choose, and how answers about them are shown.

use crate::Failure;
use crate::bundle::Ready;
use crate::command::{CommandArgs, build};
use crate::quantity::{ForTube, Kind, bounds};
use crate::resolved::{AccuracyArgs, Resolved};
use crate::rubbing::FrictionArgs;
use crate::table::plain;
use cppr::analysis::inverse::{FreeInput, InverseProblem, Uncertainty, free_within};
use cppr::analysis::{BundleAnalysis, Governing, Teeth, absurd_demand, governing};
use cppr::bundle::Friction;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium};
use cppr::solve::{Command, Equilibrium, Freedom, Input, Quantity, Solver};
use cppr_io::bundle_file::Described;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Which actuators are free, and how far they may go.
#[derive(clap::Args)]
pub struct FreeArgs {
    /// Bounds of a free translation, for instance 2=-5..5mm; default: its safe range (cppr limits)
    #[arg(long, value_name = "[K=]LOW..HIGH", allow_hyphen_values = true, value_parser = |t: &str| bounds(t, Kind::Length))]
    pull_bounds: Vec<ForTube<[f64; 2]>>,
    /// Bounds of a free rotation, for instance 2=-90..90deg
    #[arg(long, value_name = "[K=]LOW..HIGH", allow_hyphen_values = true, value_parser = |t: &str| bounds(t, Kind::Angle))]
    rotate_bounds: Vec<ForTube<[f64; 2]>>,
}

impl FreeArgs {
    /// Builds the robot of a file, whichever kind it is of, reads the command, and searches for values of the free actuators.
    pub fn search(
        &self,
        robot: &Path,
        args: &CommandArgs,
        (accuracy, friction): (&AccuracyArgs, Option<FrictionArgs>),
        of_robot: impl FnOnce(&mut Solver, &Command, &[FreeInput]) -> Result<(), Failure>,
        of_bundle: impl FnOnce(
            &mut BundleAnalysis,
            &BundleCommand,
            &[FreeInput],
            Option<Friction>,
        ) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let keeps_modes = args.rest.needs_modes();
        let (described, friction) = match friction {
            Some(friction) => accuracy.rubbing(robot, keeps_modes, friction)?,
            None => (accuracy.described(robot, keeps_modes)?, None),
        };
        match described {
            Described::Robot(file) => {
                let built = build(&file, robot)?;
                let command = args.command(&built)?;
                let mut solver = args.solver(&built)?;
                let free = self.free(args, &mut solver, &command)?;
                of_robot(&mut solver, &command, &free)
            }
            Described::Bundle { design, .. } => {
                let ready = Ready::new(args, robot, &design)?;
                let mut analysis = ready.analysis(&design);
                let free = self.of_bundle(args, &mut analysis, &ready.command)?;
                of_bundle(&mut analysis, &ready.command, &free, friction)
            }
        }
    }

    /// Every actuator that the command line does not prescribe, within its bounds.
    fn free(
        &self,
        args: &CommandArgs,
        solver: &mut Solver,
        command: &Command,
    ) -> Result<Vec<FreeInput>, Failure> {
        let settings = args.settings();
        let moves = |input: Input| match input.freedom {
            Freedom::PushPull => settings.can_slide(solver.robot(), input.tube - 2),
            Freedom::Rotation => settings.resolution.angle > 0,
        };
        let inputs = command.inputs().map(|(input, _)| input).filter(|i| moves(*i)).collect();
        self.within(args, inputs, || {
            let ranges = solver.safe_ranges(command, Teeth::Rigid).map_err(|problem| {
                let absurd = absurd_demand(solver.robot(), command)
                    .map_or(String::new(), |demand| format!(". {demand}"));
                no_bounds(&format!("{problem}{absurd}"))
            })?;
            Ok(free_within(solver.robot(), &ranges))
        })
    }

    /// The same of a bundle. The outermost tube stays where it is unless it has bounds, or unless nothing is joined.
    fn of_bundle(
        &self,
        args: &CommandArgs,
        analysis: &mut BundleAnalysis,
        command: &BundleCommand,
    ) -> Result<Vec<FreeInput>, Failure> {
        let choosable = analysis.choosable(command);
        let moves = |input: &Input| choosable.contains(input) || self.bounds_of(*input).is_some();
        let inputs = command.inputs().into_iter().filter(moves).collect();
        self.within(args, inputs, || analysis.free(command).map_err(|problem| no_bounds(&problem)))
    }

    fn bounds_of(&self, input: Input) -> Option<[f64; 2]> {
        let list = if input.freedom == Freedom::PushPull { &self.pull_bounds } else { &self.rotate_bounds };
        list.iter().find(|b| b.tube == input.tube).map(|b| b.value)
    }

    /// Those of some inputs that the command line does not prescribe, within the bounds given or else within what is safe.
    fn within(
        &self,
        args: &CommandArgs,
        inputs: Vec<Input>,
        safe: impl FnOnce() -> Result<Vec<FreeInput>, Failure>,
    ) -> Result<Vec<FreeInput>, Failure> {
        let given = args.given();
        let is_given = |input: &Input| given.iter().any(|own: &Input| own.is_same_freedom(*input));
        let wanted: Vec<Input> = inputs.into_iter().filter(|input| !is_given(input)).collect();
        for (name, list, freedom) in [
            ("--pull-bounds", &self.pull_bounds, Freedom::PushPull),
            ("--rotate-bounds", &self.rotate_bounds, Freedom::Rotation),
        ] {
            if let Some(idle) =
                list.iter().find(|b| !wanted.iter().any(|i| i.tube == b.tube && i.freedom == freedom))
            {
                return Err(Failure::Input(format!(
                    "{name}: tube {} has no such actuator that is free; one that is given a value keeps it",
                    idle.tube
                )));
            }
        }
        let safe = if wanted.iter().all(|i| self.bounds_of(*i).is_some()) { Vec::new() } else { safe()? };
        let free = wanted.into_iter().filter_map(|input| match self.bounds_of(input) {
            Some(bounds) => Some(FreeInput { input, bounds }),
            None => safe.iter().find(|f| f.input == input).copied(),
        });
        Ok(free.collect())
    }
}

fn no_bounds(problem: &dyn std::fmt::Display) -> Failure {
    Failure::Input(format!(
        "no bounds follow from the limits, because the given command is no safe start: {problem}. Give --pull-bounds and \
         --rotate-bounds"
    ))
}

/// Turns a problem into the program's failure.
pub fn failure(problem: &InverseProblem) -> Failure {
    match problem {
        InverseProblem::NoEquilibrium => Failure::NoEquilibrium(problem.to_string()),
        _ => Failure::Input(problem.to_string()),
    }
}

/// `tube 2 pull`.
pub fn name(input: Input) -> String {
    format!("tube {} {}", input.tube, input.quantity().keyword)
}

/// One line of a table.
pub fn line(text: &mut String, head: &str, rest: &str) {
    let _ = writeln!(text, "  {head:<18}{rest}");
}

/// Values of free inputs with deviation and bounds.
pub fn inputs_table(
    text: &mut String,
    free: &[FreeInput],
    values: &[f64],
    at_bound: &[bool],
    uncertainty: Option<&Uncertainty>,
) {
    for (i, own) in free.iter().enumerate() {
        let Quantity { shown_size: size, shown_unit: unit, .. } = own.input.quantity();
        let [low, high] = own.bounds.map(|b| plain(b / size, 2));
        let spread =
            uncertainty.map_or(String::new(), |u| format!(" ± {:<7}", spread(u.deviations[i] / size)));
        let mark = if at_bound[i] { ", at its bound" } else { "" };
        let value = plain(values[i] / size, 3);
        line(text, &name(own.input), &format!("{value:>9}{spread} {unit:<4} within {low} to {high}{mark}"));
    }
}

/// Half of a 95 % interval of a normal distribution, in standard deviations.
pub const HALF: f64 = 1.959_963_984_540_054;

/// Half a 95 % interval from a standard deviation.
fn spread(deviation: f64) -> String {
    if deviation.is_finite() { plain(HALF * deviation, 3) } else { "unknown".into() }
}

/// Three numbers in a row.
pub fn three(values: [f64; 3], digits: usize) -> String {
    values.map(|v| format!("{:>9}", plain(v, digits))).join(" ")
}

/// What an answer's equilibrium is like: in words, and its actuators.
pub struct State {
    /// Lines of a table: efforts and the nearest limit.
    pub text: String,
    /// Motions and efforts as JSON.
    pub actuators: Value,
    /// Discretisation error as JSON; of a bundle its own.
    pub accuracy: Value,
}

impl State {
    /// Of a robot.
    pub fn of(solver: &mut Solver, resolved: &Resolved) -> Self {
        let found = &resolved.found;
        let margin = solver.stability(found).map(|s| s.margin);
        let sections = solver.section_limits(found, Teeth::Rigid);
        let mut state = Self::new(&efforts(found), governing(&sections, margin).as_ref(), resolved.json());
        for (head, value) in resolved.lines() {
            line(&mut state.text, head, &value);
        }
        state
    }

    /// Of a bundle.
    pub fn of_bundle(analysis: &BundleAnalysis, found: &BundleEquilibrium) -> Self {
        let efforts =
            (1..).zip(&found.efforts).map(|(tube, a)| (tube, [a.label, a.rotation, a.force, a.torque]));
        let sections = analysis.section_limits(found, Teeth::Rigid);
        Self::new(&efforts.collect::<Vec<_>>(), governing(&sections, None).as_ref(), Value::Null)
    }

    fn new(efforts: &[Effort], nearest: Option<&Governing>, accuracy: Value) -> Self {
        let mut text = String::new();
        state_table(&mut text, efforts, nearest);
        Self { text, actuators: actuators_json(efforts), accuracy }
    }
}

/// Tube, and its motion, rotation, tension and torque (SI).
type Effort = (usize, [f64; 4]);

fn efforts(found: &Equilibrium) -> Vec<Effort> {
    found.followers().map(|(tube, a)| (tube, [a.motion, a.rotation, a.tension, a.torque])).collect()
}

fn actuators_json(efforts: &[Effort]) -> Value {
    let one = |(tube, [pull, rotation, tension, torque]): &Effort| json!({ "tube": tube, "pull_m": pull, "rotation_rad": rotation, "tension_N": tension, "torque_Nm": torque });
    efforts.iter().map(one).collect()
}

/// Motions and efforts of an equilibrium as JSON.
pub fn efforts_json(found: &Equilibrium) -> Value {
    actuators_json(&efforts(found))
}

/// Efforts and the nearest limit.
fn state_table(text: &mut String, efforts: &[Effort], nearest: Option<&Governing>) {
    for (tube, [.., tension, torque]) in efforts {
        let head = format!("tube {tube} needs");
        let (force, torque) = (plain(*tension, 4), plain(torque * 1e3, 4));
        line(text, &head, &format!("{force:>9} N and {torque} N mm"));
    }
    if let Some(nearest) = nearest {
        let what = nearest.limit;
        let place = nearest.section.map_or(String::new(), |s| format!(" of {}", s.whereabouts()));
        let over = if nearest.utilisation > 1.0 { ": beyond it, do not go there" } else { "" };
        let used = plain(100.0 * nearest.utilisation, 1);
        line(text, "nearest limit", &format!("{used:>9} % used, {what}{place}{over}"));
    }
}

/// Free inputs with their values as JSON.
pub fn inputs_json(
    free: &[FreeInput],
    values: &[f64],
    at_bound: &[bool],
    deviations: Option<&[f64]>,
) -> Value {
    let one = |i: usize| {
        let own = &free[i];
        let Quantity { keyword: actuator, unit, .. } = own.input.quantity();
        // JSON has no infinity: an unknown deviation is null.
        json!({
            "tube": own.input.tube, "actuator": actuator, "unit": unit, "value": values[i], "at_bound": at_bound[i],
            "low": own.bounds[0], "high": own.bounds[1], "standard_deviation": deviations.map(|d| d[i]),
        })
    };
    (0..free.len()).map(one).collect()
}
