#!/bin/sh
# Tests of the Python package: builds and installs it in .venv, runs pytest, mypy and stubtest.
set -eu
cd "$(dirname "$0")/../.."

venv=.venv
if [ ! -x "$venv/bin/pip" ]; then
    # Debian keeps venv in a package of its own.
    python3 -m ensurepip --version >/dev/null 2>&1 || [ "$(id -u)" != 0 ] || apt-get install -y -q python3-venv
    python3 -m venv "$venv"
fi
marker="$venv/cppr-requirements.txt"
if ! cmp -s crates/cppr-py/requirements.txt "$marker"; then
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r crates/cppr-py/requirements.txt
    cp crates/cppr-py/requirements.txt "$marker"
fi
PATH="$PWD/$venv/bin:$PATH"
export PATH
# What a newcomer does, but with the build tools of the environment, and built of what the tests of the workspace have built.
MATURIN_PEP517_ARGS="--features as-tested" pip install --quiet --disable-pip-version-check --no-build-isolation --force-reinstall --no-deps .

python -m pytest --quiet --durations=8 "$@"
python -m mypy --no-error-summary crates/cppr-py/python/cppr
echo "mypy: no issues"
python -m mypy.stubtest --mypy-config-file pyproject.toml cppr
