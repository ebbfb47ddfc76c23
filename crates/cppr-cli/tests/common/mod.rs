//! The program under test, run from the root of the repository.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub fn cppr(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cppr")).args(arguments).current_dir(root()).output().unwrap()
}

/// Runs in a folder of its own, robots beside it.
pub fn cppr_in(folder: &Path, arguments: &[&str]) -> Output {
    for name in ["robots", "examples"] {
        if !folder.join(name).exists() {
            std::os::unix::fs::symlink(root().join(name), folder.join(name)).unwrap();
        }
    }
    Command::new(env!("CARGO_BIN_EXE_cppr")).args(arguments).current_dir(folder).output().unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[track_caller]
pub fn refused(arguments: &[&str], fragment: &str) {
    let output = cppr(arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(message.contains(fragment), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    assert!(output.stdout.is_empty());
}

pub fn json(arguments: &[&str]) -> Value {
    let output = cppr(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}
