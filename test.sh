#!/bin/sh
# The whole test suite: format, lints, documentation, all tests. Installs by itself what the tests need.
set -eu
cd "$(dirname "$0")"

fail() {
    echo "error: $1" >&2
    exit 1
}

# Without line numbers, which no test asks for, so that it compiles sooner.
export CARGO_PROFILE_RELEASE_DEBUG=false

./install-test-needs.sh >/dev/null 2>&1 </dev/null &
needs=$!

cargo fmt --all --check || fail "the sources are not formatted: run 'cargo fmt --all'"
cargo test --workspace --release --no-run "$@" || fail "the compiler objects: see above"
# Instructions are counted where valgrind is; elsewhere that test says so.
wait $needs
# Tests leave a core idle at times, which lints use. They begin later, so that the tests need not wait for their lock.
objections=$(mktemp)
trap 'rm -f "$objections"' EXIT
{
    sleep 20
    cargo clippy --workspace --all-targets --release --quiet -- -D warnings &&
        RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --release --quiet
} >"$objections" 2>&1 &
lints=$!
failed=0
cargo test --workspace --release "$@" || failed=1
wait $lints || {
    cat "$objections" >&2
    fail "lints or the documentation object: run 'cargo clippy --workspace --all-targets --release' and 'cargo doc', and mend what they name"
}
[ $failed = 0 ] || fail "tests failed: see above"
./deny.sh || fail "dependencies break a rule of deny.toml: see above"
crates/cppr-cli/test.sh || fail "outputs are not as their schemas say: see above"
crates/cppr-mesh/test.sh || fail "exported files do not pass other readers: see above"
crates/cppr-py/test.sh || fail "tests of the Python package failed: see above"
crates/cppr-c/test.sh || fail "tests of the C interface failed: see above"
matlab/test.sh || fail "tests of the toolbox for MATLAB and Octave failed: see above"
crates/cppr-viewer/test.sh || fail "tests of the live view failed: see above"
echo "all tests passed"
