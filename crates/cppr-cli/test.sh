#!/bin/sh
# Outputs of the program against their published JSON schemas, by the validator of another project. Installs it in .venv of the root.
set -eu
cd "$(dirname "$0")/../.."
venv=.venv
if [ ! -x "$venv/bin/pip" ]; then
    # Debian keeps venv in a package of its own.
    python3 -m ensurepip --version >/dev/null 2>&1 || [ "$(id -u)" != 0 ] || apt-get install -y -q python3-venv
    python3 -m venv "$venv"
fi
marker="$venv/cppr-cli-requirements.txt"
if ! cmp -s crates/cppr-cli/requirements.txt "$marker"; then
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r crates/cppr-cli/requirements.txt
    cp crates/cppr-cli/requirements.txt "$marker"
fi
# The program as the tests of the workspace have built it: a build of it alone takes other features of what it needs, and minutes.
cargo test --release --quiet --workspace --test program --no-run
"$venv/bin/python" -m pytest --quiet crates/cppr-cli/tests/test_schemas.py
