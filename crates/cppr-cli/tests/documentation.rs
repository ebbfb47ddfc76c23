//! Every example of the program's help and every command of README and book, as a newcomer copies them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, root, text};
use std::io::BufRead;
use std::process::Command;

#[test]
fn every_example_of_the_help_works() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = 0;
    for task in [
        "solve",
        "limits",
        "continue",
        "reach",
        "match",
        "sense",
        "sweep",
        "view",
        "derivatives",
        "section",
        "check",
        "calibrate",
        "export",
        "paper",
        "",
    ] {
        let help = text(
            &cppr(&[task, "--help"].map(str::trim).into_iter().filter(|a| !a.is_empty()).collect::<Vec<_>>())
                .stdout,
        );
        for line in help.lines().map(str::trim).filter(|l| l.starts_with("cppr ")) {
            let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
            let output = cppr_in(folder.path(), &arguments);
            assert_eq!(output.status.code(), Some(0), "{line}: {}", text(&output.stderr));
            seen += 1;
        }
    }
    assert!(seen >= 19, "only {seen} examples found");
    let left: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.starts_with('.'))
        .collect();
    assert!(left.is_empty(), "temporary files left: {left:?}");
}

/// A command that serves until it is ended: it prints the address of its page.
fn serves_a_page(arguments: &[&str]) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cppr"))
        .args(arguments)
        .arg("--no-open")
        .current_dir(root())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    std::io::BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(line.starts_with("http://127.0.0.1:"), "{line}");
}

#[test]
fn every_command_of_the_documentation_works() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = 0;
    for page in [
        "README.md",
        "docs/src/tutorial.md",
        "docs/src/results.md",
        "docs/src/scenarios.md",
        "docs/src/viewer.md",
        "docs/src/limits.md",
        "docs/src/continuation.md",
        "docs/src/sweeps.md",
        "docs/src/export.md",
        "docs/src/inverse.md",
        "docs/src/theory/derivatives.md",
        "docs/src/calibration.md",
        "docs/src/paper.md",
    ] {
        let page = std::fs::read_to_string(root().join(page)).unwrap();
        for line in page.lines().filter_map(|l| l.strip_prefix("    cargo run --release -- ")) {
            let arguments: Vec<&str> = line.split_whitespace().filter(|a| *a != "robots/*.toml").collect();
            let robots = ["robots/r1.toml", "robots/helicoid.toml"];
            let all =
                if line.contains("robots/*.toml") { [&arguments[..], &robots].concat() } else { arguments };
            if line.starts_with("view ") && !line.contains("--save") {
                serves_a_page(&all);
            } else {
                let output = cppr_in(folder.path(), &all);
                assert_eq!(output.status.code(), Some(0), "{line}: {}", text(&output.stderr));
            }
            seen += 1;
        }
    }
    assert!(seen >= 17, "only {seen} commands found");
}
