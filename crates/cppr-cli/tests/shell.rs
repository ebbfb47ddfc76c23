//! `cppr new`, `cppr completions` and `cppr man` as a user meets them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, refused, text};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs with answers on standard input.
fn answering(folder: &Path, arguments: &[&str], answers: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cppr"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

fn takes(folder: &Path, file: &str, pull: &str) {
    for arguments in
        [vec!["check", file], vec!["solve", file, "--pull", pull], vec!["limits", file, "--pull", pull]]
    {
        let output = cppr_in(folder, &arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_new_robot_is_one_that_other_commands_take() {
    let folder = tempfile::tempdir().unwrap();
    for (k, (options, pull)) in [
        ("", "2=1mm"),
        ("--material nitinol --length 60mm --tube 1mm,0.8mm,1.6mm --tube 0.75mm,0.6mm,1.2mm", "2=0.2mm"),
        ("--material steel --tube 3mm,2.6mm,4mm,90deg --tube 2.4mm,2mm,3mm,210deg --tube 1.8mm,1.4mm,2mm,330deg", "3=0.2mm"),
    ]
    .into_iter()
    .enumerate()
    {
        let file = format!("robot{k}.toml");
        let mut arguments = vec!["new", &file, "--defaults"];
        arguments.extend(options.split_whitespace());
        let output = cppr_in(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        takes(folder.path(), &file, pull);
    }
}

#[test]
fn answers_are_what_the_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let answers = "Arm \"one\"\n120mm\nnitinol\n2\n\n2.1mm\n5mm\n\n1.6 mm\n1.1mm\n2.4mm\n90deg\n4mm\n\n";
    let output = answering(folder.path(), &["new", "arm.toml"], answers);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let asked = text(&output.stderr);
    assert!(asked.contains("Name of the robot [Robot]: "), "{asked}");
    assert!(asked.contains("Tube 2: outer radius [1.575mm]: "), "{asked}");
    let file = cppr_io::robot_file::read(folder.path().join("arm.toml")).unwrap();
    assert_eq!(file.design.name, "Arm \"one\"");
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(file.design.length, 0.12);
    near(file.tubes[0].outer_radius.unwrap(), 3e-3);
    near(file.tubes[0].inner_radius.unwrap(), 2.1e-3);
    near(file.tubes[1].outer_radius.unwrap(), 1.6e-3);
    let written = std::fs::read_to_string(folder.path().join("arm.toml")).unwrap();
    for line in
        ["opening_deg = 180 ", "opening_deg = 90 ", "depth_mm = 2.4 ", "length_mm = 4 ", "tooth_mm = 4 "]
    {
        assert!(written.contains(line), "{line}\n{written}");
    }
    // No line of the file leaves the reader alone with a bare number, radii aside.
    let bare =
        |l: &&str| l.contains(" = ") && !l.contains('#') && !l.contains("radius") && !l.contains("name");
    let bare: Vec<&str> = written.lines().filter(bare).collect();
    assert!(
        bare.iter().all(|l| ["youngs", "poissons", "density"].iter().any(|k| l.starts_with(k))),
        "{bare:?}"
    );
}

#[test]
fn wrong_answers_are_asked_again_and_missing_ones_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = answering(folder.path(), &["new", "arm.toml"], "Arm\n120\nlong\n-5mm\n0.12m\n");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.matches("Length of the tubes").count(), 4, "{said}");
    assert!(said.contains("write a length above 0"), "{said}");
    assert!(said.contains("add --defaults"), "{said}");
    assert!(!folder.path().join("arm.toml").exists());
}

#[test]
fn what_makes_no_robot_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    for (tubes, fragment) in [
        (["3mm,2mm,7mm", "1.5mm,0.5mm,2mm"], "deeper"),
        (["3mm,2mm,5mm", "2.5mm,0.5mm,2mm"], "bore"),
        (["2mm,3mm,4mm", "1.5mm,0.5mm,2mm"], "radius"),
    ] {
        let output = cppr_in(
            folder.path(),
            &["new", "arm.toml", "--defaults", "--tube", tubes[0], "--tube", tubes[1]],
        );
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("nothing is written") && said.contains(fragment), "{said}");
        assert!(!folder.path().join("arm.toml").exists());
    }
    refused(&["new", "robots/r1.toml", "--defaults"], "this file exists");
    refused(&["new", "nowhere/arm.toml", "--defaults"], "there is no folder");
    refused(&["new", "-", "--tube", "3mm,2mm"], "for instance 3mm,2mm,5mm");
}

#[test]
fn shells_take_the_completions() {
    for shell in ["bash", "zsh", "fish"] {
        let output = cppr(&["completions", shell]);
        assert_eq!(output.status.code(), Some(0));
        let script = text(&output.stdout);
        assert!(script.contains("continue") && script.contains("tip-force"), "{shell}");
        // Read by the shell itself where it is installed.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("script");
        std::fs::write(&file, &script).unwrap();
        match Command::new(shell).arg("-n").arg(&file).output() {
            Ok(read) => assert!(read.status.success(), "{shell}: {}", text(&read.stderr)),
            Err(_) => eprintln!("{shell} is not installed: its script is not read"),
        }
    }
    // What bash offers after `cppr so` and `cppr solve --tip`.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("script");
    std::fs::write(&file, cppr(&["completions", "bash"]).stdout).unwrap();
    let offers = |words: &[&str]| {
        let list = words.iter().map(|w| format!("'{w}'")).collect::<Vec<_>>().join(" ");
        let last = words.len() - 1;
        let script = format!(
            "source {}; COMP_WORDS=({list}); COMP_CWORD={last}; _cppr cppr '{}' '{}'; echo \"${{COMPREPLY[@]}}\"",
            file.display(),
            words[last],
            words[last - 1]
        );
        text(&Command::new("bash").args(["-c", &script]).output().unwrap().stdout)
    };
    assert_eq!(offers(&["cppr", "sol"]).trim(), "solve");
    assert_eq!(offers(&["cppr", "solve", "--tip-f"]).trim(), "--tip-force");
}

/// What a program prints, where it is installed.
fn printed(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    Some(text(&output.stdout))
}

#[test]
fn fish_completes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cppr.fish");
    std::fs::write(&file, cppr(&["completions", "fish"]).stdout).unwrap();
    let offers = |line: &str| {
        let home = format!("set -x HOME {}; ", folder.path().display());
        printed(
            "fish",
            &["--no-config", "-c", &format!("{home}source {}; complete -C '{line}'", file.display())],
        )
    };
    let Some(tasks) = offers("cppr so") else {
        eprintln!("fish is not installed: its completions were not tried");
        return;
    };
    let first =
        |list: &str| list.lines().map(|l| l.split('\t').next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(first(&tasks), ["solve"], "{tasks}");
    assert_eq!(first(&offers("cppr solve --tip-f").unwrap()), ["--tip-force"]);
    assert!(first(&offers("cppr solve robots/r3.toml --").unwrap()).contains(&"--pull".to_owned()));
}

/// A shell on a terminal of its own, in which Tab is pressed: what is run then says how the line was completed.
#[test]
fn zsh_completes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("_cppr"), cppr(&["completions", "zsh"]).stdout).unwrap();
    let script = folder.path().join("driver");
    let typed = |line: &str| {
        let text = format!(
            "zmodload zsh/zpty || exit 1\n\
             zpty shell zsh -f -i\n\
             zpty -w shell 'PS1=; fpath=({} $fpath); autoload -Uz compinit; compinit -D -u; cppr() {{ print \"ran:$*:\" }}; print rea\"\"dy'\n\
             zpty -r shell seen '*ready*'\n\
             zpty -w -n shell $'{line}\\t'\n\
             zpty -w -n shell $'\\n'\n\
             zpty -r shell seen '*ran:*:*'\n\
             print -r -- $seen\n",
            folder.path().display()
        );
        std::fs::write(&script, text).unwrap();
        printed("timeout", &["60", "zsh", "-f", script.to_str().unwrap()])
    };
    if Command::new("zsh").arg("--version").output().is_err() {
        eprintln!("zsh is not installed: its completions were not tried");
        return;
    }
    for (line, run) in [("cppr so", "ran:solve:"), ("cppr solve --tip-f", "ran:solve --tip-force:")] {
        let seen = typed(line).unwrap();
        assert!(seen.contains(run), "{line}: {seen}");
    }
}

#[test]
fn every_sub_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let output = cppr_in(folder.path(), &["man", "--output", "man"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let page = |name: &str| std::fs::read_to_string(folder.path().join("man").join(name)).unwrap();
    let all = page("cppr.1");
    let help = text(&cppr(&["--help"]).stdout);
    let list = help.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1).take_while(|l| !l.is_empty());
    for task in list.filter_map(|l| l.split_whitespace().next()).filter(|t| *t != "help") {
        let own = page(&format!("cppr-{task}.1"));
        assert!(
            own.starts_with(".ie") && own.contains(".SH SYNOPSIS") && own.contains(".SH EXAMPLES\n.nf\n"),
            "{task}"
        );
        assert!(own.contains("Examples:") && own.contains("\n.fi\n") && !own.contains("EXTRA"), "{task}");
        assert!(all.contains(&format!("cppr\\-{task}(1)")), "{task} is not in cppr.1");
    }
}
