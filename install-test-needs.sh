#!/bin/sh
# Installs at once what the tests take from Debian, PyPI and npm, so that it goes on beside the compiler. Every test script
# installs what it lacks by itself too, and says what it cannot have: this only saves time, and never fails.
cd "$(dirname "$0")" || exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    wanted=
    # need PROGRAM PACKAGE...: the packages where the program is missing.
    need() {
        program=$1
        shift
        command -v "$program" >/dev/null || wanted="$wanted $*"
    }
    need valgrind valgrind
    need c++ g++
    need cmake cmake make
    need pkg-config pkg-config
    need mkoctfile octave octave-dev gnuplot-nox fonts-freefont-otf ghostscript
    need chromium chromium fonts-noto-core
    need zsh zsh
    need fish fish
    python3 -m ensurepip --version >/dev/null 2>&1 || wanted="$wanted python3-venv"
    if [ -n "$wanted" ]; then
        apt-get update -qq
        # shellcheck disable=SC2086
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $wanted
    fi
fi
. ./python-env.sh
for file in crates/*/requirements.txt; do python_env "$file"; done
(cd crates/cppr-viewer/web && npm ci --silent --no-audit --no-fund --ignore-scripts)
exit 0
