#!/bin/sh
# The toolbox in Octave: built by its one command, its tests, its examples. MATLAB itself is not at hand here.
set -eu
cd "$(dirname "$0")/.."
if ! command -v mkoctfile >/dev/null && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends octave octave-dev gnuplot-nox fonts-freefont-otf ghostscript >/dev/null || true
fi
if ! command -v octave-cli >/dev/null || ! command -v mkoctfile >/dev/null; then
    echo "skipped: the toolbox for MATLAB and Octave, which needs octave and mkoctfile (Debian: apt-get install octave octave-dev gnuplot-nox fonts-freefont-otf ghostscript)"
    exit 0
fi
# As the tests of the workspace have built it: builds of single crates take other features of what they need, and minutes.
cargo test --release --quiet --workspace --test header --test program --no-run
target=${CARGO_TARGET_DIR:-$PWD/target}/release
cd matlab
# Without history: where its folder is missing, Octave ends with a line that begins like an error of the tests.
run() {
    octave-cli --quiet --no-history --no-window-system --eval "$1"
}
run "build_cppr('$target/deps')"
run "addpath(pwd); addpath('tests'); graphics_toolkit('gnuplot'); run_tests('$target/cppr')"
# The examples run as from the folder matlab, but where their figures may stay.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/matlab"
ln -s "$PWD/../robots" "$PWD/../examples" "$work"
toolbox=$PWD
cd "$work/matlab"
for example in first_robot robot_workspace tip_tracking calibrate; do
    echo "-- $example"
    run "addpath('$toolbox', '$toolbox/examples'); graphics_toolkit('gnuplot'); set(0, 'DefaultFigureVisible', 'off'); $example"
done
# What the book shows, one piece after another.
awk '/^```matlab/ { inside = 1; next } /^```/ { inside = 0 } inside && !/^build_cppr/' "$toolbox/../docs/src/matlab.md" >page_of_the_book.m
grep -q solveMany page_of_the_book.m
run "addpath('$toolbox'); graphics_toolkit('gnuplot'); set(0, 'DefaultFigureVisible', 'off'); page_of_the_book" >/dev/null
for figure in first_robot first_robot_range robot_workspace tip_tracking calibrate; do
    [ -s "$figure.png" ] || { echo "matlab/test.sh: the examples left no $figure.png" >&2; exit 1; }
done
if [ -n "${CPPR_KEEP_FIGURES:-}" ]; then
    cp ./*.png "$CPPR_KEEP_FIGURES"
fi
