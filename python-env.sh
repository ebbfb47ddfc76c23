# For the test scripts, which source it in the root: Python packages in .venv, installed by itself and once.

# python_env [FILE]: makes .venv where it is missing, and installs the packages that a file of requirements names unless that was done.
python_env() {
    if [ ! -x .venv/bin/pip ]; then
        # Debian keeps venv in a package of its own.
        python3 -m ensurepip --version >/dev/null 2>&1 || [ "$(id -u)" != 0 ] || apt-get install -y -q python3-venv
        python3 -m venv .venv
    fi
    [ -n "${1:-}" ] || return 0
    installed=".venv/$(echo "$1" | tr / -)"
    if ! cmp -s "$1" "$installed"; then
        .venv/bin/pip install --quiet --disable-pip-version-check -r "$1"
        cp "$1" "$installed"
    fi
}
