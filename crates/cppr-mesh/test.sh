#!/bin/sh
# Exported files in readers of other projects: trimesh (STL, 3MF, OBJ, glTF), ezdxf (DXF), Khronos' glTF validator.
# Installs them by itself: Python packages in .venv of the root, the validator in target.
set -eu
cd "$(dirname "$0")/../.."
. ./python-env.sh
python_env crates/cppr-mesh/requirements.txt
if [ ! -d target/gltf-validator/node_modules/gltf-validator ]; then
    command -v npm >/dev/null || [ "$(id -u)" != 0 ] || apt-get install -y -q npm
    mkdir -p target/gltf-validator
    npm install --silent --prefix target/gltf-validator gltf-validator@2.0.0-dev.3.10
fi
files=$(mktemp -d)
trap 'rm -r "$files"' EXIT
# The program as the tests of the workspace have built it: a build of it alone takes other features of what it needs, and minutes.
cargo test --release --quiet --workspace --test program --no-run
cppr() { target/release/cppr export "$@" >/dev/null; }
for name in r1 r2 r3 r4 helicoid; do
    for tube in 1 2; do
        for format in stl 3mf glb dxf; do
            cppr robots/$name.toml --tube $tube --output "$files/$name-$tube.$format"
        done
    done
done
cppr robots/r3.toml --tube 2 --below 30mm --flange 8mm,2mm --tip-cap 1mm --output "$files/dressed.3mf"
cppr robots/r3.toml --tube 2 --kerf 20um --output "$files/kerf.dxf"
for format in stl dxf; do
    cppr robots/bundles/uncut_ends.toml --tube 1 --output "$files/uncut_ends-1.$format"
done
cppr robots/bundles/uncut_ends.toml --pull 1=-20mm --pull 2=-19mm --output "$files/advanced.glb"
cppr robots/bundles/hybrid.toml --pull 2=1mm --pull 3=-10mm --rotate 3=-60deg --output "$files/hybrid.glb"
for format in glb gltf obj stl 3mf; do
    cppr robots/r1.toml --pull 5mm --output "$files/bent.$format"
    cppr robots/helicoid.toml --pull 10mm --rotate 30deg --output "$files/wound.$format"
done
.venv/bin/python crates/cppr-mesh/tests/readers.py "$files"
NODE_PATH=target/gltf-validator/node_modules node crates/cppr-mesh/tests/validate-gltf.js "$files"/*.glb "$files"/*.gltf
