//! `cppr check`: is a robot file right?

use crate::Failure;
use crate::command::{build, unsound};
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::table::{counted, doubts, millimetres};
use cppr::bundle::Bundle;
use cppr_io::Problem;
use cppr_io::bundle_file::{self, Described};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr check robots/r3.toml
  cppr check robots/r1.toml robots/childs3.toml
  cppr check robots/bundles/two_sections.toml
  cppr check robots/r1.toml --json -

The JSON has an entry for each file, with line and column of every problem.";

/// Arguments of `cppr check`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot files (TOML)
    #[arg(required = true, value_name = "ROBOT")]
    robots: Vec<PathBuf>,
    /// Write what was found, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Reports every file; fails where one is wrong.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs { json: args.json.as_deref(), csv: None, plot: None };
    args.robots.iter().try_for_each(|robot| outputs.spare(robot))?;
    let (mut sound, mut problems, mut files) = (String::new(), Vec::new(), Vec::new());
    for path in &args.robots {
        match describe(path) {
            Ok((text, found)) => {
                let _ = writeln!(sound, "{}: {text}", path.display());
                for warning in found["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str) {
                    let _ = writeln!(sound, "  but {warning}");
                }
                files.push(json!({ "file": path.display().to_string(), "sound": true, "robot": found, "problems": [] }));
            }
            Err(
                Failure::Input(message) | Failure::NoEquilibrium(message) | Failure::Interrupted(message),
            ) => {
                files.push(json!({ "file": path.display().to_string(), "sound": false, "robot": null,
                    "problems": listed(path, &message) }));
                problems.push(message);
            }
        }
    }
    if let Some(path) = outputs.json {
        let whole = json!({ "schema": "cppr/check", "schema_version": 1, "files": files });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    outputs.report(&sound)?;
    if problems.is_empty() { Ok(()) } else { Err(Failure::Input(problems.join("\n"))) }
}

/// The problems of the file with their places; of a robot that the file describes soundly, but that cannot be, what was said.
fn listed(path: &Path, said: &str) -> Vec<Value> {
    let place = |at: usize| Some(at).filter(|at| *at > 0);
    let one = |p: &Problem| json!({ "line": place(p.line), "column": place(p.column), "key": p.key, "message": p.message, "help": p.help });
    match bundle_file::read(path) {
        Err(problems) => problems.list.iter().map(one).collect(),
        Ok(_) => vec![json!({ "line": null, "column": null, "key": "", "message": said, "help": "" })],
    }
}

/// What a sound file describes, in words and as data.
fn describe(path: &Path) -> Result<(String, Value), Failure> {
    match bundle_file::read(path).map_err(|p| Failure::Input(p.to_string()))? {
        Described::Robot(file) => {
            let robot = build(&file, path)?;
            let (count, length) = (robot.tube_count(), robot.length());
            let plane = if robot.is_planar() { "planar" } else { "in space" };
            let text = format!("{}, {} mm long, {plane}: fine", counted(count, "tube"), millimetres(length));
            let found = json!({ "name": robot.design().name, "length_m": length, "tubes": count,
                "planar": robot.is_planar(), "warnings": doubts(&robot) });
            Ok((text, found))
        }
        Described::Bundle { design, .. } => {
            let bundle = Bundle::new(&design).map_err(|problems| unsound(path, &problems))?;
            let (tubes, joints, length) = (design.tubes.len(), design.joints.len(), bundle.length());
            let text = format!(
                "{}, {}, {} mm long: fine",
                counted(tubes, "tube"),
                counted(joints, "joint"),
                millimetres(length)
            );
            let found = json!({ "name": design.name, "length_m": length, "tubes": tubes, "joints": joints, "warnings": [] });
            Ok((text, found))
        }
    }
}
