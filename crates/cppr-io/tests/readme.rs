//! The Rust of the README is the example of this crate, which is compiled and run as a documentation test.

#![allow(clippy::unwrap_used)]

#[test]
fn the_readme_shows_what_is_run() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).unwrap();
    let block = readme.split_once("```rust\n").and_then(|(_, rest)| rest.split_once("```")).unwrap().0;
    let source = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/lib.rs")).unwrap();
    let lines = source.lines().filter_map(|line| line.strip_prefix("//!")).map(str::trim_start);
    let example: Vec<&str> =
        lines.skip_while(|line| *line != "```").skip(1).take_while(|line| *line != "```").collect();
    let shown: Vec<&str> = example.into_iter().filter(|line| !line.starts_with('#')).collect();
    let expected: Vec<&str> = block.lines().collect();
    assert!(expected.len() >= 6, "{block}");
    assert_eq!(shown, expected);
}
