#!/bin/sh
# Tests of the Python package: builds and installs it in .venv, runs pytest, mypy and stubtest.
set -eu
cd "$(dirname "$0")/../.."

. ./python-env.sh
python_env crates/cppr-py/requirements.txt
PATH="$PWD/.venv/bin:$PATH"
export PATH
# What a newcomer does, but with the build tools of the environment, and built of what the tests of the workspace have built.
MATURIN_PEP517_ARGS="--features as-tested" pip install --quiet --disable-pip-version-check --no-build-isolation --force-reinstall --no-deps .

python -m pytest --quiet --durations=8 "$@"
python -m mypy --no-error-summary crates/cppr-py/python/cppr
echo "mypy: no issues"
python -m mypy.stubtest --mypy-config-file pyproject.toml cppr
