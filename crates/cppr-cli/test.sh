#!/bin/sh
# Outputs of the program against their published JSON schemas, by the validator of another project. Installs it in .venv of the root.
set -eu
cd "$(dirname "$0")/../.."
. ./python-env.sh
python_env crates/cppr-cli/requirements.txt
# The program as the tests of the workspace have built it: a build of it alone takes other features of what it needs, and minutes.
cargo test --release --quiet --workspace --test program --no-run
.venv/bin/python -m pytest --quiet crates/cppr-cli/tests/test_schemas.py
