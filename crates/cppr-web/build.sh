#!/bin/sh
# Makes dist/: the kernel as a WebAssembly module with SIMD, and the JavaScript that loads it. `build.sh --check` says
# whether dist/ is of these sources instead, and fails where it is not although this machine could make it.
set -eu
cd "$(dirname "$0")/../.."
web=crates/cppr-web
dist=$web/dist
target=wasm32-unknown-unknown
bindgen=0.2.130

fail() {
    echo "$web/build.sh: $1" >&2
    exit 1
}

# Everything that goes into the module: the sources of its crates and the versions of what they depend on.
fingerprint() {
    {
        for crate in cppr cppr-io cppr-mesh cppr-viewer cppr-web; do
            find "crates/$crate/src" "crates/$crate/Cargo.toml" -type f
        done
        echo "$web/Cargo.lock"
    } | LC_ALL=C sort | xargs sha256sum | sha256sum | cut -d' ' -f1
}

# A toolchain with the target; or the compiler that Debian builds browsers with, which can build its own standard library.
if rustup target list --installed 2>/dev/null | grep -qx "$target"; then
    toolchain=rustup
elif [ -x /usr/bin/cargo ] && [ -e /usr/lib/rustlib/src/rust/library/Cargo.lock ] && command -v wasm-ld-19 >/dev/null; then
    toolchain=debian
else
    toolchain=none
fi
missing="no compiler for $target. Install one: 'rustup target add $target', or on Debian 12
'apt-get install rustc-web cargo-web rust-web-src lld-19'. The module in $dist is kept as it is."

if [ "${1-}" = --check ]; then
    if [ "$(fingerprint)" = "$(cat $dist/sources.sha256)" ]; then
        echo "$dist is of these sources"
    elif [ "$toolchain" = none ]; then
        echo "$dist is of other sources than these, and there is $missing"
    else
        fail "$dist is of other sources than these. Run: $web/build.sh"
    fi
    exit 0
fi
[ $# = 0 ] || fail "takes --check or nothing, not $*"

[ "$toolchain" != none ] || fail "$missing"
tools=$PWD/target/site-tools
if [ "$("$tools/bin/wasm-bindgen" --version 2>/dev/null)" != "wasm-bindgen $bindgen" ]; then
    cargo install --quiet --debug --no-default-features --root "$tools" --version "$bindgen" wasm-bindgen-cli ||
        fail "wasm-bindgen $bindgen cannot be installed: see above"
fi
# The versions are those of everything else.
cp Cargo.lock $web/Cargo.lock
cargo update --quiet --workspace --manifest-path $web/Cargo.toml
# Places in the sources, which the module holds for messages, without the folders of this machine.
export RUSTFLAGS="-C target-feature=+simd128 --remap-path-prefix=$PWD/="
for registry in "${CARGO_HOME:-$HOME/.cargo}"/registry/src/*; do RUSTFLAGS="$RUSTFLAGS --remap-path-prefix=$registry/="; done
out=$PWD/target/web
if [ "$toolchain" = rustup ]; then
    cargo build --locked --release --manifest-path $web/Cargo.toml --target "$target" --target-dir "$out"
else
    PATH=/usr/bin:/bin RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld-19 \
        /usr/bin/cargo build --locked --release --manifest-path $web/Cargo.toml --target "$target" --target-dir "$out" -Z build-std=std,panic_abort
fi
made=$(mktemp -d)
trap 'rm -r "$made"' EXIT
"$tools/bin/wasm-bindgen" --target no-modules --no-typescript --remove-producers-section --out-name kernel --out-dir "$made" \
    "$out/$target/release/cppr_web.wasm"
mkdir -p "$dist"
mv "$made/kernel.js" "$made/kernel_bg.wasm" "$dist/"
fingerprint >"$dist/sources.sha256"
ls -l "$dist"
