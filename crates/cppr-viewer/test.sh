#!/bin/sh
# The page in a real browser: the bundle matches its sources, and everything a person does with it works.
set -eu
cd "$(dirname "$0")/web"

missing() {
    echo "crates/cppr-viewer/test.sh: $1" >&2
    exit 1
}
command -v node >/dev/null && command -v npm >/dev/null || missing "needs Node.js 20 or newer with npm"
[ "$(node -p 'process.versions.node.split(".")[0]')" -ge 20 ] || missing "needs Node.js 20 or newer, this is $(node --version)"
find_browser() { command -v chromium || command -v chromium-browser || command -v google-chrome || true; }
if [ -z "$(find_browser)" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-noto-core >/dev/null
fi
CHROMIUM=$(find_browser)
[ -n "$CHROMIUM" ] || missing "needs the browser Chromium on the PATH (Debian: apt-get install chromium)"
export CHROMIUM

if grep -qE '"resolved"|://' package-lock.json; then
    missing "package-lock.json names a registry; make it again with npm install in this folder"
fi
npm ci --silent --no-audit --no-fund --ignore-scripts
node build.js --check

# The program as the tests of the workspace have built it: a build of it alone takes other features of what it needs, and minutes.
cargo test --release --quiet --workspace --test program --no-run
node --test --test-concurrency=1 --test-timeout=120000 --test-reporter=spec test/*.test.js
