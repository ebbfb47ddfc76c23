//! `cppr sweep` as a user meets it: interrupted, killed, resumed, refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{root, text};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn sweep(extra: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cppr"));
    command.args(["sweep", "robots/r1.toml"]).args(extra).current_dir(root());
    command
}

/// Some seconds of work.
const LONG: [&str; 6] = ["--pull", "-7..7mm:101", "--rotate", "-180..180deg:241", "--modes", "paper"];

fn long(output: &Path, extra: &[&str]) -> Command {
    let mut command = sweep(&LONG);
    command.args(["--output", output.to_str().unwrap()]).args(extra);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Waits until some chunks are solved.
fn underway(child: &mut Child, output: &Path) {
    let rows = cppr_sweep::parts_of(output).join("rows.bin");
    let start = Instant::now();
    while std::fs::metadata(&rows).map_or(0, |m| m.len()) < 300_000 {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn whole(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    output
}

#[test]
fn a_killed_sweep_is_resumed_to_the_same_bytes() {
    for ending in ["csv", "parquet"] {
        killed_and_resumed(ending);
    }
}

fn killed_and_resumed(ending: &str) {
    let folder = tempfile::tempdir().unwrap();
    let [reference, output] = ["reference", "w"].map(|name| folder.path().join(name).with_extension(ending));
    whole(long(&reference, &["--threads", "3"]));
    let mut child = long(&output, &[]).spawn().unwrap();
    underway(&mut child, &output);
    // SIGKILL.
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!output.exists());
    // Without --resume nothing of it is lost by accident.
    let refused = long(&output, &[]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("add --resume"), "{}", text(&refused.stderr));
    let other = long(&output, &["--resume", "--margin"]).output().unwrap();
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("another task (columns differ)"), "{}", text(&other.stderr));
    let done = text(&whole(long(&output, &["--resume", "--threads", "1"])).stdout);
    let solved: u64 = done.split("; ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(solved < 101 * 241, "everything was solved again: {done}");
    assert!(std::fs::read(&output).unwrap() == std::fs::read(&reference).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "parts are left");
}

/// The table has 65 MB of numbers.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_table() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["csv", "npz", "parquet"] {
        let output = folder.path().join("w").with_extension(ending);
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -d 40000 && exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_cppr"), "sweep"]);
        command.args(["robots/r1.toml", "--planar", "--pull", "0..7mm:600000", "--threads", "2", "--output"]);
        command.arg(&output).current_dir(root());
        whole(command);
    }
}

#[test]
fn an_interrupt_says_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("w.csv");
    let mut child = long(&output, &[]).spawn().unwrap();
    underway(&mut child, &output);
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let stopped = child.wait_with_output().unwrap();
    assert_eq!(stopped.status.code(), Some(130));
    let message = text(&stopped.stderr);
    assert!(message.contains("stopped after") && message.contains("--resume goes on"), "{message}");
    assert!(!output.exists());
    whole(long(&output, &["--resume"]));
    assert!(text(&std::fs::read(&output).unwrap()).lines().count() == 2 + 101 * 241);
}

#[test]
fn two_at_once_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("w.csv");
    let mut child = long(&output, &[]).spawn().unwrap();
    underway(&mut child, &output);
    let second = long(&output, &["--resume"]).output().unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("another process"), "{}", text(&second.stderr));
}

#[test]
fn wrong_sweeps_are_refused_with_what_to_write() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("w.csv");
    let refused = |arguments: &[&str], fragment: &str| {
        let all = [arguments, &["--output", file.to_str().unwrap()]].concat();
        let output = sweep(&all).output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(fragment) && !message.contains("panicked"), "{arguments:?}: {message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{arguments:?} leaves files");
    };
    refused(&["--pull", "-7..7:141"], "7 has no unit: write for instance 7mm");
    refused(&["--pull", "-7..7mm:0"], "a count of 0");
    refused(&["--pull", "7..-7mm:3"], "the smaller value first");
    refused(&["--pull", "nan..7mm:3"], "not a finite number");
    refused(&["--pull", "-7..7mm"], "say how many values");
    refused(&["--pull", "7mm"], "nothing varies");
    refused(&["--pull", "3=-7..7mm:3"], "there is no tube 3");
    refused(&["--pull", "0..1mm:2", "--tension", "0..1N:2"], "given twice");
    refused(&["--pull", "0..1mm:1000000", "--rotate", "0..1deg:1000000"], "1.0e12 poses, 136000.0 GB");
    refused(&["--pull", "0..1mm:3", "--samples", "5"], "has no count");
    refused(&["--pull", "0..1mm", "--samples", "0"], "no pose");
    refused(&["--pull", "0..1mm:3", "--seed", "5"], "--samples");
    refused(&["--tip-force", "0,0..1N:3"], "2 components");
    refused(&["--vary", "length_mm=normal(150,1)"], "add --samples");
    refused(&["--vary", "length_mm=normal(150,-1)", "--samples", "3"], "must be positive");
    refused(&["--vary", "length=140..160:3"], "the robot file has no length; there are");
    refused(&["--vary", "name=1..2:3"], "a text");
    refused(&["--vary", "length_mm=150"], "one value");
    refused(&["--pull", "0..1mm:3", "--planar", "--rotate", "0..5deg:3"], "planar");
    refused(&["--planar", "--tip-force", "0,0,0..1N:3"], "out of the plane");
    let refused_at = |path: &str, fragment: &str| {
        let output = sweep(&["--pull", "0..1mm:3", "--output", path]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(fragment), "{}", text(&output.stderr));
    };
    refused_at("w.xlsx", ".csv, .npz or .parquet");
    refused_at("no/such/w.csv", "there is no folder");
}

#[test]
fn the_workspace_is_drawn_in_the_plane_and_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |name: &str, arguments: &[&str]| {
        let (table, figure) = (folder.path().join("w.csv"), folder.path().join(name));
        let files = ["--output", table.to_str().unwrap(), "--plot", figure.to_str().unwrap()];
        whole(sweep(&[arguments, &files].concat()));
        std::fs::read(figure).unwrap()
    };
    let plane = text(&draw("plane.svg", &["--pull", "-6..6mm:25", "--planar"]));
    let space =
        ["--pull", "-6..6mm:9", "--rotate", "-90..90deg:9", "--modes", "paper", "--margin", "--limits"];
    let grey = text(&draw("space.svg", &[&space[..], &["--colour", "margin"]].concat()));
    let panels = |svg: &str| svg.matches("class=\"panel\"").count();
    // The colour bar is one of them.
    assert_eq!((panels(&plane), panels(&grey)), (2, 5));
    assert!(plane.contains("tension of tube 2 (N)") && plane.contains("25 stable of 25 poses"));
    assert!(grey.contains("margin to instability") && grey.contains("class=\"dots\""));
    assert!(plane == text(&draw("plane.svg", &["--pull", "-6..6mm:25", "--planar", "--threads", "1"])));
    assert_eq!(&draw("space.png", &space)[1..4], b"PNG");
    let refused = |colour: &str, fragment: &str| {
        let arguments = ["--pull", "-6..6mm:3", "--output", "w.csv", "--plot", "w.svg", "--colour", colour];
        let output = sweep(&arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(fragment), "{}", text(&output.stderr));
    };
    refused("margin", "add --margin");
    refused("closure", "add --limits");
    refused("blue", "There are input_tube2_pull_m, status");
}

#[test]
fn where_no_pose_has_an_equilibrium_the_table_is_there_and_the_code_is_3() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.csv");
    let output = sweep(&["--tension", "1e6..2e6N:3", "--output", path.to_str().unwrap()]).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    let message = text(&output.stderr);
    assert!(message.contains("not_converged_path_ends") && message.contains("no pose"), "{message}");
    assert_eq!(text(&std::fs::read(&path).unwrap()).lines().count(), 5);
}
