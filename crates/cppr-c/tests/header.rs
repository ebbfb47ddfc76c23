//! The header in the repository is the one that the sources make. `CPPR_WRITE_HEADER=1` writes it instead.
#![allow(clippy::unwrap_used)]

use std::path::Path;

#[test]
fn the_header_matches_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut made = Vec::new();
    cbindgen::generate(folder).unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    // Notes for those who write Rust.
    let mut lines = made.lines().peekable();
    let mut header = String::new();
    while let Some(line) = lines.next() {
        if line == "//" && lines.next_if_eq(&"// # Safety").is_some() {
            while lines.next_if(|next| next.starts_with("//")).is_some() {}
            continue;
        }
        header += line;
        header.push('\n');
    }
    assert!(!header.contains("# Safety"));
    let path = folder.join("include/cppr.h");
    if std::env::var_os("CPPR_WRITE_HEADER").is_some() {
        std::fs::write(&path, &header).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == header,
        "include/cppr.h is not what the sources make: run the test with CPPR_WRITE_HEADER=1"
    );
}
