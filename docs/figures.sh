#!/bin/sh
# Makes the figures of README and book again.
set -eu
cd "$(dirname "$0")/.."
cppr() { cargo run --release --quiet -- "$@"; }
figures=docs/src/figures
cppr solve robots/r3.toml --pull 5mm --plot $figures/r3.svg
cppr solve robots/childs3.toml --pull 2=1mm --pull 3=-0.5mm --rotate 2=30deg --tip-force 0,0,-0.5N --plot $figures/childs3.svg
cppr section robots/r3.toml --plot $figures/sections.svg
cppr solve examples/mine.toml --pull 1mm --rotate 20deg --plot $figures/mine.svg
cppr solve robots/bundles/s_shape.toml --pull 5mm --contact --plot $figures/contact.svg
cppr solve robots/r1.toml --pull 6mm --clearance radii --plot $figures/gaps.svg
cppr solve robots/helicoid.toml --pull 8mm --clearance radii --plot $figures/winding.svg
cppr solve robots/bundles/s_shape.toml --pull 5mm --clearance 0.3mm --plot $figures/gaps_s.svg
cppr cycle robots/r1.toml --pull 0..7..-7..7mm --friction 0.2 --plot $figures/loop.svg
cppr limits robots/r4.toml --pull -4mm --plot $figures/limits.svg
for wrist in wrist150 wrist90; do
    cargo run --release --quiet -p cppr-cli --example wrists -- robots/wrists/$wrist.toml robots/wrists/$wrist.csv 0.2 $figures/$wrist.svg
done
cppr continue robots/r3.toml --along load --to 2.5 --pull -5mm --tip-force -1,0,0N --branches --plot $figures/continuation.svg
cppr match robots/r3.toml --points examples/shapes/r3.csv --plot $figures/match.svg
bundles=robots/bundles
cppr solve $bundles/s_shape.toml --pull 5mm --plot $figures/s_shape.svg
cppr solve $bundles/two_sections.toml --pull 2=3mm --pull 4=2mm --plot $figures/two_sections.svg
cppr solve $bundles/concentric3.toml --rotate 2=60deg --rotate 3=150deg --plot $figures/concentric3.svg
cppr solve $bundles/hybrid.toml --pull 2=1mm --pull 3=-10mm --rotate 3=-60deg --plot $figures/hybrid.svg
cppr solve $bundles/s_shape.toml --pull 1=-20mm --pull 2=-15mm --plot $figures/inserted.svg
cppr continue $bundles/two_curved.toml --along rotate=2 --to 360deg --plot $figures/snap_path.svg
cppr solve $bundles/two_curved.toml --rotate 2=235deg --plot $figures/before_snap.svg
cppr solve $bundles/two_curved.toml --rotate 2=-100deg --plot $figures/behind_snap.svg
report=$(mktemp -d)
cppr sweep robots/r1.toml --pull -7..7mm:41 --rotate -180..180deg:91 --output "$report/workspace.csv" --plot $figures/workspace.svg
cppr sweep examples/mine.toml --pull 1mm --vary 'tube1.notches.depth_mm=normal(1.40,0.01)' --vary 'tube2.notches.depth_mm=normal(1.15,0.01)' \
    --vary 'tube1.inner_diameter_mm=normal(1.80,0.005)' --vary 'tube2.inner_diameter_mm=normal(1.50,0.005)' \
    --vary 'length_mm=normal(60,0.1)' --samples 400 --limits --output "$report/tolerance.csv" --plot $figures/tolerance.svg
cppr paper --output "$report/report"
for name in figure14-r4-consistent figure14-r4-printed figure20-star figure25 differences-factors differences-stiffness; do
    cp "$report/report/$name.svg" $figures/
done
rm -r "$report"
[ -x .venv/bin/pip ] || python3 -m venv .venv
.venv/bin/pip install --quiet pyvista==0.49.1
files=$(mktemp -d)
cppr export robots/r1.toml --tube 1 --output "$files/1.stl"
cppr export robots/r1.toml --tube 2 --output "$files/2.stl"
cppr export robots/r1.toml --pull 5mm --output "$files/bent.glb"
.venv/bin/python crates/cppr-mesh/picture.py "$files/1.stl" "$files/2.stl" "$files/bent.glb" $figures/export.png
rm -r "$files"
# The loop at 1 kHz, with the Python package that crates/cppr-py/test.sh installs.
(cd "$(mktemp -d)" && ln -s "$OLDPWD/robots" . && "$OLDPWD/.venv/bin/python" "$OLDPWD/examples/python/control_loop.py" &&
    cp control_loop.png "$OLDPWD/$figures/control-loop.png")
# The live view in a browser, which crates/cppr-viewer/test.sh sets up.
node crates/cppr-viewer/web/picture.js $figures/viewer.png $figures/viewer-bundle.png
