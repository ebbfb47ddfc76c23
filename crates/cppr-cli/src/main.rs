//! The program `cppr`: statics of concentric push-pull robots from a shell.
//!
//! Exit codes: 0 solved, 2 wrong input, 3 no equilibrium found, 130 interrupted.

mod bundle;
mod bundle_continuation;
mod bundle_derivatives;
mod bundle_figure;
mod calibrate;
mod cell;
mod check;
mod checkpoint;
mod clearance;
mod cloud;
mod command;
mod continuation;
mod continuation_figure;
mod cycle;
mod cycle_figure;
mod derivatives;
mod errors;
mod exceeded;
mod export;
mod figure;
mod free;
mod hysteresis;
mod limits;
mod new;
mod output;
mod outputs;
mod paper;
mod quantity;
mod reach;
mod resolved;
mod rubbing;
mod scenario;
mod section;
mod sense;
mod shape_match;
mod shell;
mod solve;
mod study;
mod sweep;
mod table;
mod unstable;
mod view;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Statics of concentric push-pull robots: nested notched tubes, joined at the tip.
#[derive(Parser)]
#[command(name = "cppr", version, arg_required_else_help = true, term_width = 0, after_help = HELP)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

const HELP: &str = "\
First steps:
  cppr new my-arm.toml --defaults
  cppr check robots/r3.toml
  cppr solve robots/r3.toml --pull 5mm --plot r3.svg
  cppr section robots/r3.toml --plot sections.svg
  cppr sweep robots/r1.toml --pull -7..7mm:15 --rotate -180..180deg:13 --output workspace.csv
  cppr paper --output report

Exit codes: 0 solved, 2 wrong input, 3 no equilibrium found, 130 interrupted.";

#[derive(Subcommand)]
enum Task {
    /// A robot file from a few answers, commented.
    #[command(after_help = new::EXAMPLES)]
    New(new::Args),
    /// The equilibrium shape of a robot under actuation and loads.
    #[command(after_help = solve::EXAMPLES)]
    Solve(Box<solve::Args>),
    /// A path of equilibria past folds and onto other branches, with what snaps where.
    #[command(after_help = continuation::EXAMPLES)]
    Continue(Box<continuation::Args>),
    /// Motors driven to and fro with friction between the tubes: loops of force and tip, energy, lost motion.
    #[command(after_help = cycle::EXAMPLES)]
    Cycle(Box<cycle::Args>),
    /// How far each actuator may go, and what limits it: strain, closing notches, stability.
    #[command(after_help = limits::EXAMPLES)]
    Limits(Box<limits::Args>),
    /// Many poses in one table: grids and samples of actuators, loads and design.
    #[command(after_help = sweep::EXAMPLES)]
    Sweep(Box<sweep::Args>),
    /// Actuator values that bring the tip to a position, a direction, or both.
    #[command(after_help = reach::EXAMPLES)]
    Reach(Box<reach::Args>),
    /// Actuator values under which the robot passes through given points.
    #[command(after_help = shape_match::EXAMPLES)]
    Match(Box<shape_match::Args>),
    /// The force on the tip from measured efforts and the tip's pose.
    #[command(after_help = sense::EXAMPLES)]
    Sense(Box<sense::Args>),
    /// How tip and efforts answer to actuators, loads and any number of the robot file.
    #[command(after_help = derivatives::EXAMPLES)]
    Derivatives(Box<derivatives::Args>),
    /// Section properties along the tubes.
    #[command(after_help = section::EXAMPLES)]
    Section(section::Args),
    /// Stiffness of notches with their teeth by finite elements.
    #[command(after_help = cell::EXAMPLES)]
    Cell(cell::Args),
    /// Checks robot files and reports every problem.
    #[command(after_help = check::EXAMPLES)]
    Check(check::Args),
    /// Fits parameters of robots to measured shapes.
    #[command(after_help = calibrate::EXAMPLES)]
    Calibrate(calibrate::Args),
    /// Tubes as files for printing, cutting and display.
    #[command(after_help = export::EXAMPLES)]
    Export(Box<export::Args>),
    /// Everything that Tummers et al. 2024 compute, in both formulations, as one report.
    #[command(after_help = paper::EXAMPLES)]
    Paper(paper::Args),
    /// The robot in the browser: it bends as you drag.
    #[command(after_help = view::EXAMPLES)]
    View(view::Args),
    /// A script that completes commands in bash, zsh, fish and other shells.
    #[command(after_help = shell::COMPLETIONS)]
    Completions(shell::CompletionsArgs),
    /// Manual pages.
    #[command(after_help = shell::MAN)]
    Man(shell::ManArgs),
}

/// Why the program ends without having done its task.
enum Failure {
    /// Something given is wrong: a file, a value, a place to write to.
    Input(String),
    /// There is no equilibrium where one was asked for.
    NoEquilibrium(String),
    /// The user stopped it.
    Interrupted(String),
}

fn main() -> ExitCode {
    if let Some(message) = cppr_io::processor::lacking() {
        output::note(&format!("{message}\n"));
        return ExitCode::from(2);
    }
    run()
}

fn run() -> ExitCode {
    let result = match Cli::parse().task {
        Task::New(args) => new::run(&args),
        Task::Solve(args) => solve::run(&args),
        Task::Continue(args) => continuation::run(&args),
        Task::Cycle(args) => cycle::run(&args),
        Task::Limits(args) => limits::run(&args),
        Task::Sweep(args) => sweep::run(&args),
        Task::Reach(args) => reach::run(&args),
        Task::Match(args) => shape_match::run(&args),
        Task::Sense(args) => sense::run(&args),
        Task::Derivatives(args) => derivatives::run(&args),
        Task::Section(args) => section::run(&args),
        Task::Cell(args) => cell::run(&args),
        Task::Check(args) => check::run(&args),
        Task::Calibrate(args) => calibrate::run(&args),
        Task::Export(args) => export::run(&args),
        Task::Paper(args) => paper::run(&args),
        Task::View(args) => view::run(&args),
        Task::Completions(args) => shell::completions(&args),
        Task::Man(args) => shell::man(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(message)) => {
            output::note(&format!("{message}\n"));
            ExitCode::from(2)
        }
        Err(Failure::NoEquilibrium(message)) => {
            output::note(&format!("{message}\n"));
            ExitCode::from(3)
        }
        Err(Failure::Interrupted(message)) => {
            output::note(&format!("{message}\n"));
            ExitCode::from(130)
        }
    }
}
