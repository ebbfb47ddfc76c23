//! The examples that users copy run, and print what they promise.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::process::Command;

fn output(example: &str) -> String {
    let own = std::env::current_exe().unwrap();
    let program = own.parent().unwrap().parent().unwrap().join("examples").join(example);
    assert!(program.exists(), "{} is missing: 'cargo test' builds it", program.display());
    let output = Command::new(program).output().unwrap();
    assert!(output.status.success(), "{example}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn examples_run() {
    for (example, words) in [
        ("solve", &["converged, stable", "tube 2: pulled by 5.000 mm", "1 mm more pull"][..]),
        ("jacobian_loop", &["converged, stable", "0.000 mm across and 10.000 mm sideways"]),
        ("sweep", &["231 of 231 poses", "least margin"]),
        ("calibrate", &["offsets is 1.260"]),
        ("own_section", &["converged, stable", "the tip turns by"]),
    ] {
        let text = output(example);
        for word in words {
            assert!(text.contains(word), "{example} does not say '{word}': {text}");
        }
    }
}
