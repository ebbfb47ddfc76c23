#!/bin/sh
# The whole test suite: format, lints, documentation, all tests. Installs by itself what the tests need.
set -eu
cd "$(dirname "$0")"

cargo fmt --all --check
cargo clippy --workspace --all-targets --release --quiet -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --release --quiet
cargo test --workspace --release "$@"
