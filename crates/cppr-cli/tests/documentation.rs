//! Every example of the program's help and every command of README and book, as a newcomer copies them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, root, text};
use std::io::BufRead;
use std::process::Command;

/// All sub-commands, and none.
fn tasks() -> Vec<String> {
    let help = text(&cppr(&["--help"]).stdout);
    let list = help.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1).take_while(|l| !l.is_empty());
    let names = list.filter_map(|l| l.split_whitespace().next()).filter(|name| *name != "help");
    names.map(String::from).chain([String::new()]).collect()
}

/// README and all pages of the book.
fn pages() -> Vec<std::path::PathBuf> {
    let list =
        |folder: &str| std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let all = list("docs/src").chain(list("docs/src/theory"));
    all.filter(|p| p.extension().is_some_and(|e| e == "md")).chain([root().join("README.md")]).collect()
}

#[test]
fn every_example_of_the_help_works() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = 0;
    for task in tasks() {
        let arguments = [task.as_str(), "--help"];
        let help = text(&cppr(&arguments[usize::from(task.is_empty())..]).stdout);
        let examples = || help.lines().map(str::trim).filter(|l| l.starts_with("cppr "));
        assert!(examples().count() > 0, "cppr {task} --help shows no example");
        for line in examples() {
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
    let mut seen = 0;
    for path in pages() {
        // A page stands for itself.
        let folder = tempfile::tempdir().unwrap();
        let page = std::fs::read_to_string(&path).unwrap();
        for line in page.lines().filter_map(|l| l.strip_prefix("    cargo run --release -- ")) {
            let arguments: Vec<&str> = line.split_whitespace().filter(|a| *a != "robots/*.toml").collect();
            let robots = ["robots/r1.toml", "robots/helicoid.toml"];
            let all =
                if line.contains("robots/*.toml") { [&arguments[..], &robots].concat() } else { arguments };
            if line.starts_with("view ") && !line.contains("--save") {
                serves_a_page(&all);
            } else {
                let output = cppr_in(folder.path(), &all);
                let shown = path.display();
                assert_eq!(output.status.code(), Some(0), "{shown}: {line}: {}", text(&output.stderr));
            }
            seen += 1;
        }
    }
    assert!(seen >= 17, "only {seen} commands found");
}

/// What the README says that its first command prints, up to what depends on the machine.
#[test]
fn the_readme_shows_what_is_printed() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let mut lines = readme.lines();
    let command = lines.find_map(|line| line.strip_prefix("    cargo run --release -- ")).unwrap();
    let shown =
        lines.skip_while(|line| *line != "prints").skip(2).map_while(|line| line.strip_prefix("    "));
    let shown: Vec<&str> = shown.collect();
    let folder = tempfile::tempdir().unwrap();
    let output = cppr_in(folder.path(), &command.split_whitespace().collect::<Vec<_>>());
    let printed = text(&output.stdout);
    let (last, first) = shown.split_last().unwrap();
    assert!(last.trim() == "..." && first.len() > 9, "{shown:?}");
    assert_eq!(printed.lines().take(first.len()).collect::<Vec<_>>(), first);
    let rest: Vec<&str> = printed.lines().skip(first.len()).map(str::trim).collect();
    assert!(rest.len() == 1 && rest[0].starts_with("cost"), "{rest:?}");
}

#[test]
fn every_output_has_a_short_form() {
    let helps = tasks().into_iter().filter(|task| !task.is_empty()).map(|task| {
        let help = text(&cppr(&[task.as_str(), "--help"]).stdout);
        (task, help)
    });
    let writers: Vec<_> = helps.filter(|(_, help)| help.contains("--output")).collect();
    assert!(writers.len() >= 4, "{writers:?}");
    for (task, help) in writers {
        assert!(help.contains("-o, --output <"), "cppr {task} has no -o");
    }
}

/// Reference data, sources and tests cite pages of the book: `docs/src/….md`. All of them exist.
#[test]
fn cited_pages_exist() {
    let mut seen = 0;
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<_> = crates.flat_map(|own| [own.join("src"), own.join("tests")]).collect();
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for path in entries.map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let Ok(content) = std::fs::read_to_string(&path) else { continue };
            let pages = content.match_indices("docs/src/").filter_map(|(at, _)| {
                let end = |c: char| !(c.is_alphanumeric() || "/-_.".contains(c));
                content[at..]
                    .split(end)
                    .next()
                    .filter(|page| std::path::Path::new(page).extension().is_some_and(|e| e == "md"))
            });
            for page in pages {
                assert!(root().join(page).is_file(), "{} cites {page}", path.display());
                seen += 1;
            }
        }
    }
    assert!(seen >= 10, "only {seen} citations found");
}
