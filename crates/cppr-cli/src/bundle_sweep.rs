//! `cppr sweep` for bundles: a grid or samples into a CSV table.

use crate::Failure;
use crate::bundle::check;
use crate::command::unsound;
use crate::output::{self, note, print};
use crate::sweep::{Args, axes, one_pose};
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{Bundle, BundleDesign};
use cppr_sweep::{BundleTask, Format, MOST_BUNDLE_POSES, Plan, Verdict};
use indicatif::ProgressBar;
use std::fmt::Write;
use std::time::Instant;

/// Solves and writes.
pub fn run(args: &Args, format: Format, design: &BundleDesign) -> Result<(), Failure> {
    let fail = |message: String| Err(Failure::Input(message));
    for (option, given) in [
        ("--vary", !args.vary.is_empty()),
        ("--margin", args.margin),
        ("--limits", args.limits),
        ("--plot", args.plot.is_some()),
        ("--resume", args.resume),
        ("--json", args.json.is_some()),
    ] {
        if given {
            return fail(format!("{option} is not yet for a robot with parts or joints; leave it away"));
        }
    }
    let shown = args.output.display();
    if format != Format::Csv {
        return fail(format!("{shown}: the table of a robot with parts or joints is written as .csv"));
    }
    let (base, stretch) = one_pose(args).bundle_command(design)?;
    let bundle = Bundle::new(design).map_err(|problems| unsound(&args.robot, &problems))?;
    // A joint that one pose would draw in behind the plate is that row's matter.
    let still =
        BundleCommand { drives: vec![TubeDrive::HELD; design.tubes.len()], loads: base.loads.clone() };
    check(design, &bundle, &still, stretch)?;
    let plan = match args.samples {
        Some(count) => Plan::Samples { count, seed: args.seed },
        None => Plan::Grid,
    };
    let task = BundleTask { bundle, name: design.name.clone(), base, stretch, axes: axes(args)?, plan };
    let rows = task.rows();
    if rows == 0 || rows > MOST_BUNDLE_POSES {
        return fail(format!(
            "these are {rows} poses; a sweep of a robot with parts or joints takes 1 to {MOST_BUNDLE_POSES}"
        ));
    }
    let bar = ProgressBar::new(rows);
    let start = Instant::now();
    let table = task.solve(args.threads.into(), |more| bar.inc(more));
    bar.finish_and_clear();
    let table = table.map_err(|error| Failure::Input(format!("no threads can be started: {error}")))?;
    let seconds = start.elapsed().as_secs_f64();
    let text = task.csv(&table).map_err(|error| Failure::Input(error.to_string()))?;
    output::write(&args.output, &text)?;
    let mut text = format!(
        "{}: {rows} poses in {shown}; solved in {seconds:.2} s, {:.0} per second\n",
        design.name,
        rows as f64 / seconds
    );
    let status = table.column(task.axes.len());
    let is = |verdict: Verdict| move |code: &&f64| Verdict::from_code(**code) == Some(verdict);
    for verdict in Verdict::ALL {
        let count = status.iter().filter(is(verdict)).count();
        if let Some(first) = status.iter().position(|code| is(verdict)(&code)) {
            let _ = writeln!(text, "  {:<26}{count:>10}   first in row {first}", verdict.text());
        }
    }
    if status.iter().any(|code| Verdict::from_code(*code).is_some_and(Verdict::is_equilibrium)) {
        print(&text)
    } else {
        note(&text);
        Err(Failure::NoEquilibrium(format!("{}: no pose has an equilibrium", design.name)))
    }
}
