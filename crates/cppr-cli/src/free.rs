//! Actuators that the program may choose, and how answers about them are shown.

use crate::Failure;
use crate::command::CommandArgs;
use crate::quantity::{ForTube, Kind, bounds};
use crate::table::plain;
use cppr::analysis::inverse::{FreeInput, InverseProblem, Uncertainty, free_within};
use cppr::analysis::{Teeth, absurd_demand, governing};
use cppr::solve::{Command, Equilibrium, Freedom, Input, Quantity, Solver};
use serde_json::{Value, json};
use std::fmt::Write;

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
    /// Every actuator that the command line does not prescribe, within its bounds.
    pub fn free(
        &self,
        args: &CommandArgs,
        solver: &mut Solver,
        command: &Command,
    ) -> Result<Vec<FreeInput>, Failure> {
        let settings = args.settings();
        let given = args.given();
        let is_given = |input: Input| given.iter().any(|own: &Input| own.is_same_freedom(input));
        let moves = |input: Input| match input.freedom {
            Freedom::PushPull => settings.can_slide(solver.robot(), input.tube - 2),
            Freedom::Rotation => settings.resolution.angle > 0,
        };
        let wanted: Vec<Input> =
            command.inputs().map(|(input, _)| input).filter(|i| !is_given(*i) && moves(*i)).collect();
        let bounds_of = |input: Input| {
            let list =
                if input.freedom == Freedom::PushPull { &self.pull_bounds } else { &self.rotate_bounds };
            list.iter().find(|b| b.tube == input.tube).map(|b| b.value)
        };
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
        let safe = if wanted.iter().all(|i| bounds_of(*i).is_some()) {
            Vec::new()
        } else {
            let ranges =
                solver.safe_ranges(command, Teeth::Rigid).map_err(|problem| {
                    let absurd = absurd_demand(solver.robot(), command).map_or(String::new(), |demand| format!(". {demand}"));
                    Failure::Input(format!(
                        "no bounds follow from the limits, because the given command is no safe start: {problem}{absurd}. \
                         Give --pull-bounds and --rotate-bounds"
                    ))
                })?;
            free_within(solver.robot(), &ranges)
        };
        let free = wanted.into_iter().filter_map(|input| match bounds_of(input) {
            Some(bounds) => Some(FreeInput { input, bounds }),
            None => safe.iter().find(|f| f.input == input).copied(),
        });
        Ok(free.collect())
    }
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

/// Efforts, margin and the nearest limit of an answer.
pub fn state_table(text: &mut String, solver: &mut Solver, found: &Equilibrium) {
    for (tube, actuator) in found.followers() {
        let head = format!("tube {tube} needs");
        let (force, torque) = (plain(actuator.tension, 4), plain(actuator.torque * 1e3, 4));
        line(text, &head, &format!("{force:>9} N and {torque} N mm"));
    }
    let margin = solver.stability(found).map(|s| s.margin);
    let sections = solver.section_limits(found, Teeth::Rigid);
    if let Some(nearest) = governing(&sections, margin) {
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

/// Efforts of an answer as JSON.
pub fn efforts_json(found: &Equilibrium) -> Value {
    let one = |(tube, a): (usize, &cppr::solve::ActuatorState)| json!({ "tube": tube, "pull_m": a.motion, "rotation_rad": a.rotation, "tension_N": a.tension, "torque_Nm": a.torque });
    found.followers().map(one).collect()
}
