//! Instructions of one solve, counted by valgrind: a guard against silent loss of speed. The bounds are generous; what is
//! measured stands in `docs/src/performance.md`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::process::Command;

/// Instructions of one solve of a case of the benchmark, or of one pose of a batch.
fn count(case: &str, batch: bool) -> Option<u64> {
    let own = std::env::current_exe().unwrap();
    let program = own.parent()?.parent()?.join("examples/solves");
    assert!(program.exists(), "{} is missing: 'cargo test' builds it", program.display());
    let solves = 64;
    let folder = tempfile::tempdir().unwrap();
    let (runner, calls, extra) =
        if batch { ("BatchRunner", solves / 4 + 2, "batch") } else { ("Runner", solves + 2, "one") };
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect=*cases::{runner}::once*"))
        .arg(format!("--callgrind-out-file={}", folder.path().join("out").display()))
        .arg(program)
        .args([case, &solves.to_string(), extra])
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&output.stderr);
    if text.contains("unhandled instruction bytes") {
        // Older versions stop at some vector instructions.
        return None;
    }
    assert!(output.status.success(), "{text}");
    let line = text.lines().find(|line| line.contains("Collected :")).expect("valgrind counts");
    let all: u64 = line.rsplit(':').next()?.trim().parse().unwrap();
    Some(all / if batch { calls * 4 } else { calls })
}

#[test]
fn one_solve_takes_no_more_instructions_than_it_should() {
    if cfg!(debug_assertions) {
        eprintln!("instructions are counted in release builds only");
        return;
    }
    for (case, batch, bound) in [
        ("planar_two_tubes_warm", false, 68_000),
        ("space_two_tubes_warm", false, 280_000),
        ("space_two_tubes_jacobian_warm", false, 300_000),
        ("space_two_tubes_cold", false, 800_000),
        ("three_tubes_warm", false, 360_000),
        ("space_two_tubes_warm", true, 82_000),
    ] {
        let Some(counted) = count(case, batch) else {
            eprintln!("{case} was not counted: valgrind is missing or too old for an instruction in it");
            continue;
        };
        println!("{case}{}: {counted}", if batch { ", side by side" } else { "" });
        assert!(counted > 10_000, "{case}: {counted} instructions cannot be a solve");
        assert!(counted < bound, "{case}: {counted} instructions, bound {bound}");
    }
}
