#!/bin/sh
# Everything that is published, in release/: source packages, the program, Python wheels, the C library, what is in them (SBOM) and
# checksums. Each is then installed in an empty place and runs its first example without Rust.
#
#   ./release.sh              all of it: everything is compiled once for each processor and kind of library
#   ./release.sh sources sbom only these parts: sources, program, wheels, c, sbom
#   PROCESSORS=x86_64 ./release.sh wheels   for these processors alone
#
# Those for another processor run under qemu where that and Debian's packages for it can be had. What this machine cannot build or run is listed in release/NOT-HERE.txt; .github/workflows/release.yml builds for Windows and macOS.
set -eu
cd "$(dirname "$0")"
root=$PWD
out=$root/release
tools=$root/target/release-tools
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
parts=${*:-sources program wheels c sbom}
processors=${PROCESSORS:-x86_64 aarch64}

fail() {
    echo "release.sh: $1" >&2
    exit 1
}
leave_out() {
    echo "$1" | tee -a "$out/NOT-HERE.txt"
}

for part in $parts; do
    case $part in
    sources | program | wheels | c | sbom) ;;
    *) fail "there is no part $part; there are sources, program, wheels, c and sbom" ;;
    esac
done
git diff --quiet HEAD || fail "the work tree differs from the last commit: commit first, so that a release is of something"
if [ ! -x "$tools/bin/pip" ]; then
    # Debian keeps venv in a package of its own.
    python3 -m ensurepip --version >/dev/null 2>&1 || [ "$(id -u)" != 0 ] || apt-get install -y -q python3-venv
    python3 -m venv "$tools"
fi
"$tools/bin/pip" install --quiet --disable-pip-version-check maturin==1.16.0 ziglang==0.15.2 cargo-zigbuild==0.24.1
PATH="$tools/bin:$PATH"
rm -rf "$out"
mkdir -p "$out"
# Debug information is for those who build from source.
export CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_STRIP=symbols CARGO_INCREMENTAL=0

# Messages of a panic name a file. Where the sources of dependencies lie on this machine is nobody's concern: crates/serde-1.0.0/src/lib.rs is
# enough. The variable of a target joins what .cargo/config.toml says for it; RUSTFLAGS would replace it.
cargo fetch --locked --quiet
sources_of=${CARGO_HOME:-$HOME/.cargo}/registry/src
hidden="--remap-path-prefix=$root=."
hidden_in_c=
for folder in "$sources_of"/*; do
    hidden="$hidden --remap-path-prefix=$folder=crates"
    hidden_in_c="$hidden_in_c -ffile-prefix-map=$folder=crates"
done

# for_target TRIPLE COMMAND...: with a compiler that has the target: rustup's; else the one that Debian builds browsers with, which can
# build its own standard library. Zig links, so that the C library of the system that builds does not matter.
for_target() {
    triple=$1
    shift
    export "CARGO_TARGET_$(echo "$triple" | tr 'a-z-' 'A-Z_')_RUSTFLAGS=$hidden"
    export "CFLAGS_$(echo "$triple" | tr - _)=$hidden_in_c"
    if rustup target list --installed 2>/dev/null | grep -qx "$triple"; then
        CARGO_TARGET_DIR="$root/target/published" "$@"
    elif [ -x /usr/bin/cargo ] && [ -e /usr/lib/rustlib/src/rust/library/Cargo.lock ]; then
        PATH="$tools/bin:/usr/bin:/bin" RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=std,panic_unwind \
            CARGO_TARGET_DIR="$root/target/published-debian" "$@"
    else
        return 3
    fi
}
# make WHAT TRIPLE COMMAND...: for_target, false where there is no compiler for the target; all else that goes wrong ends the release.
make() {
    what=$1
    shift
    status=0
    for_target "$@" || status=$?
    if [ $status = 3 ]; then
        leave_out "not built: $what for $1 (rustup target add $1, or on Debian 12: apt-get install rustc-web cargo-web rust-web-src)"
        return 1
    fi
    [ $status = 0 ] || fail "$what for $1 cannot be built: see above"
}
# built TRIPLE: where for_target put it.
built() {
    for folder in published published-debian; do
        if [ -d "target/$folder/$1/release" ]; then echo "target/$folder/$1/release"; fi
    done
}
# What to put before a program to run it here; fails where it cannot be run.
runner() {
    case $1 in
    "$(uname -m)"-*) ;;
    *) command -v "qemu-${1%%-*}-static" ;;
    esac
}

# root_of PROCESSOR: a folder with Debian's Python and C library for another processor, against which qemu runs what is linked. Nothing of the system
# changes: lists and packages stay in that folder. False where it cannot be had.
root_of() {
    folder=$tools/$1
    command -v "qemu-$1-static" >/dev/null && command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null || return 1
    case $1 in
    aarch64) debian=arm64 ;;
    x86_64) debian=amd64 ;;
    *) return 1 ;;
    esac
    if [ ! -e "$folder/made" ]; then
        rm -rf "$folder"
        mkdir -p "$folder/state/lists/partial" "$folder/cache/archives/partial" "$folder/root"
        : >"$folder/state/status"
        for step in update "install --download-only --no-install-recommends python3 libstdc++6"; do
            # shellcheck disable=SC2086
            apt-get -y -q -o APT::Architecture=$debian -o APT::Architectures=$debian -o Dir::State="$folder/state" -o Dir::State::status="$folder/state/status" \
                -o Dir::Cache="$folder/cache" -o APT::Sandbox::User=root -o Debug::NoLocking=1 $step >"$folder/apt.log" 2>&1 || return 1
        done
        for package in "$folder"/cache/archives/*.deb; do dpkg-deb -x "$package" "$folder/root"; done
        rm -rf "$folder/cache"
        touch "$folder/made"
    fi
    echo "$folder/root"
}

# old_processor PROCESSOR COMMAND...: where AVX2 is missing, it should say so.
old_processor() {
    [ "$1" = x86_64 ] || return 0
    shift
    if command -v qemu-x86_64-static >/dev/null; then
        said=$(qemu-x86_64-static -cpu Nehalem "$@" 2>&1) && fail "$1 runs on a processor without AVX2"
        # A standard library that was compiled here with the rest uses them before the program begins.
        echo "$said" | grep -q "AVX2" || leave_out "without AVX2 this ends without a word: $1"
    else
        leave_out "not run: $1 on a processor without AVX2 (needs qemu-user-static)"
    fi
}

sources() {
    git archive --prefix="cppr-$version/" --output "$out/cppr-$version-source.tar.gz" HEAD
    maturin sdist --out "$out"
    # As crates.io gets them; whether they build from the index can be seen only once their dependencies are there.
    cargo package --workspace --exclude cppr-py --no-verify --quiet
    mkdir "$out/crates"
    cp target/package/*-"$version".crate "$out/crates/"
}

# first_command README: the first line of its first indented block.
first_command() {
    sed -n '/^    /{s/^ *//p;q;}' "$1"
}

# readme_of_program PROCESSOR: the README of a clone begins with the compiler, which nobody needs here.
readme_of_program() {
    cat <<EOF
# cppr $version for Linux ($1)

Statics of concentric push-pull robots. The program is one file that needs nothing else installed. In this folder,

    ./cppr solve robots/r3.toml --pull 5mm --plot r3.svg

prints the equilibrium of a robot of two tubes, one pulled by 5 mm, and draws it. A robot of your own, the live view in the browser, and what else there is:

    ./cppr new arm.toml --defaults
    ./cppr view robots/r1.toml
    ./cppr --help

Each sub-command's \`--help\` ends with examples. The rest of this folder:

| | |
|---|---|
| \`robots\` | robot files, to begin with |
| \`man\` | manual pages: \`man -l man/cppr.1\`, or copy them to \`~/.local/share/man/man1\` |
| \`completions/cppr.bash\` | \`source\` it in \`~/.bashrc\` |
| \`completions/cppr.zsh\` | copy it as \`_cppr\` into a folder of \`fpath\` |
| \`completions/cppr.fish\` | copy it to \`~/.config/fish/completions/\` |

EOF
    if [ "$1" = x86_64 ]; then
        echo "The processor must have the vector instructions of 2015 (AVX2); for an older one build the program from source with \`RUSTFLAGS=\"\"\`."
    fi
    echo "License: MIT or Apache 2.0, at your option."
}

program() {
    for processor in $processors; do
        triple=$processor-unknown-linux-musl
        # What a program begins with comes from zig: Debian's compiler has no such objects.
        make "the program" "$triple" cargo-zigbuild rustc --locked --release -p cppr-cli --bin cppr --target "$triple" \
            -- -C link-self-contained=no || continue
        binary=$(built "$triple")/cppr
        folder=$(mktemp -d)/cppr-$version-$processor-linux
        mkdir -p "$folder/completions"
        cp "$binary" LICENSE-MIT LICENSE-APACHE "$folder/"
        readme_of_program "$processor" >"$folder/README.md"
        if before=$(runner "$triple"); then
            $before "$binary" man --output "$folder/man" >/dev/null
            for shell in bash zsh fish; do $before "$binary" completions $shell >"$folder/completions/cppr.$shell"; done
        else
            leave_out "not run: the program for $triple, and so without manual pages and completions (needs qemu-$processor-static)"
        fi
        cp -r robots "$folder/"
        tar -C "${folder%/*}" -czf "$out/${folder##*/}.tar.gz" "${folder##*/}"
        rm -r "${folder%/*}"
        if before=$(runner "$triple"); then
            # In an empty place, with nothing of this environment: the first command of its README.
            place=$(mktemp -d)
            tar -C "$place" -xzf "$out/cppr-$version-$processor-linux.tar.gz"
            # shellcheck disable=SC2046,SC2086
            (cd "$place"/* && env -i $before $(first_command README.md) && [ -s r3.svg ]) | grep "134.383" ||
                fail "the program for $triple does not solve the first example"
            rm -r "$place"
        fi
        old_processor "$processor" "$binary" --version
    done
}

first_in_python="
import cppr
eq = cppr.Robot.from_toml('r3.toml').solve(pull=5 * cppr.mm)
assert abs(eq.tip_position[0] - 0.134383) < 1e-6, eq
print(eq)"

# hide_folder WHEEL: maturin lists what is in a wheel, with the folder it was built in; RECORD has the list's checksum.
hide_folder() {
    python3 - "$1" "$root/" <<'EOF'
import base64, hashlib, os, sys, zipfile

wheel, folder = sys.argv[1], sys.argv[2].encode()
with zipfile.ZipFile(wheel) as old:
    files = [(info, old.read(info)) for info in old.infolist()]
changed = {}
for i, (info, data) in enumerate(files):
    if "/sboms/" in info.filename and folder in data:
        data = data.replace(folder, b"")
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        changed[info.filename] = f"{info.filename},sha256={digest},{len(data)}"
        files[i] = info, data
with zipfile.ZipFile(wheel + ".new", "w", zipfile.ZIP_DEFLATED) as new:
    for info, data in files:
        if info.filename.endswith(".dist-info/RECORD"):
            lines = data.decode().splitlines()
            data = "".join(changed.get(line.split(",")[0], line) + "\n" for line in lines).encode()
        new.writestr(info, data, zipfile.ZIP_DEFLATED, 9)
os.replace(wheel + ".new", wheel)
EOF
}

# wheel_elsewhere PROCESSOR: installs and runs the wheel for another processor; false where nothing here runs it.
wheel_elsewhere() {
    other=$(root_of "$1") || return 1
    python=$(ls "$other"/usr/bin/python3.*[0-9] | head -1)
    place=$(mktemp -d)
    "$tools/bin/pip" install --quiet --disable-pip-version-check --target "$place/site" --only-binary=:all: --python-version "${python##*/python}" \
        --platform "manylinux_2_28_$1" --platform "manylinux_2_27_$1" --platform "manylinux2014_$1" "$out"/cppr-*"$1".whl
    cp robots/r3.toml "$place/"
    (cd "$place" && env -i "qemu-$1-static" -L "$other" -E PYTHONHOME="$other/usr" -E PYTHONPATH="$place/site" "$python" -c "$first_in_python") ||
        fail "the wheel for $1 does not solve the first example"
    rm -r "$place"
}

wheels() {
    # glibc 2.17 and newer, Python 3.10 and newer, by one wheel for each processor.
    for processor in $processors; do
        triple=$processor-unknown-linux-gnu
        make "the wheel" "$triple" maturin build --locked --release --zig --compatibility manylinux2014 --target "$triple" --out "$out" || continue
        hide_folder "$(echo "$out"/cppr-*"$processor".whl)"
        if [ "$processor" != "$(uname -m)" ]; then
            wheel_elsewhere "$processor" || leave_out "not run: the wheel for $triple (needs qemu-$processor-static, and Debian's Python for it)"
            continue
        fi
        place=$(mktemp -d)
        python3 -m venv "$place/venv"
        "$place/venv/bin/pip" install --quiet --disable-pip-version-check "$out"/cppr-*"$processor".whl
        cp robots/r3.toml "$place/"
        (cd "$place" && env -i ./venv/bin/python -c "$first_in_python") || fail "the wheel for $triple does not solve the first example"
        old_processor "$processor" "$(readlink -f "$(command -v python3)")" -c "import sys; sys.path[:0] = ['$(echo "$place"/venv/lib/*/site-packages)']; import cppr"
        rm -r "$place"
    done
}

# c_elsewhere PROCESSOR: compiles the first example against both libraries for another processor and runs it; false where nothing here runs it.
c_elsewhere() {
    other=$(root_of "$1") || return 1
    place=$(mktemp -d)
    tar -C "$place" -xzf "$out/cppr-c-$version-$1-linux-gnu.tar.gz"
    (
        cd "$place"/*
        cc="python3 -m ziglang cc -target $1-linux-gnu.2.17 -std=c99 -Iinclude examples/first.c"
        $cc -o shared -Llib -lcppr
        $cc -o static lib/libcppr.a -lunwind -lpthread -ldl -lm
        for program in shared static; do
            env -i "qemu-$1-static" -L "$other" -E LD_LIBRARY_PATH="$PWD/lib" ./$program robots/r3.toml | grep "134.383" || exit 1
        done
    ) || fail "the C library for $1 does not solve the first example"
    rm -r "$place"
}

c() {
    for processor in $processors; do
        triple=$processor-unknown-linux-gnu
        make "the C library" "$triple" cargo zigbuild --locked --release -p cppr-c --target "$triple.2.17" || continue
        place=$(mktemp -d)
        folder=$place/cppr-c-$version-$processor-linux-gnu
        # The linker has stripped the shared library; the tool of this machine knows its own processor only.
        strip="strip"
        [ "$processor" = "$(uname -m)" ] || strip=true
        STRIP=$strip crates/cppr-c/install.sh --prefix="$folder" --built="$(built "$triple")"
        cp LICENSE-MIT LICENSE-APACHE "$folder/"
        # The page as it is read: the book puts the first example where it is named.
        tail -n +2 crates/cppr-c/examples/first.c >"$place/first.c"
        sed -e "/^{{#include .*first\.c:2:}}/{r $place/first.c" -e 'd;}' docs/src/c.md >"$folder/c.md"
        ! grep -q "{{#" "$folder/c.md" || fail "c.md names a file that is not put in"
        mkdir "$folder/examples"
        cp crates/cppr-c/examples/* "$folder/examples/"
        cp -r robots "$folder/"
        # The toolbox for MATLAB and Octave, which is compiled against this library.
        cp -r matlab docs/src/matlab.md "$folder/"
        rm -f "$folder/matlab/test.sh" "$folder"/matlab/*.mex*
        tar -C "$place" -czf "$out/${folder##*/}.tar.gz" "${folder##*/}"
        rm -r "$place"
        if [ "$processor" != "$(uname -m)" ]; then
            c_elsewhere "$processor" || leave_out "not run: the C library for $triple (needs qemu-$processor-static, and Debian's C library for it)"
            continue
        fi
        # Unpacked elsewhere, found by CMake, its first example compiled and run.
        place=$(mktemp -d)
        tar -C "$place" -xzf "$out/cppr-c-$version-$processor-linux-gnu.tar.gz"
        (
            cd "$place"/*/examples
            env -i PATH=/usr/bin:/bin cmake -S . -B "$place/build" -DCMAKE_PREFIX_PATH="${PWD%/*}" -DCMAKE_BUILD_TYPE=Release >/dev/null
            env -i PATH=/usr/bin:/bin cmake --build "$place/build" --target first >/dev/null
            env -i "$place/build/first" ../robots/r3.toml
        ) | grep "134.383" || fail "the C library for $triple does not solve the first example"
        if command -v mkoctfile >/dev/null; then
            (
                cd "$place"/*/matlab
                env -i PATH=/usr/bin:/bin octave-cli --quiet --no-history --no-window-system --eval "build_cppr, robot = cppr.Robot('../robots/r3.toml'); \
                    eq = robot.solve('pull', 5e-3); printf('Octave: %.3f mm\n', 1e3 * eq.tip_position(1))" 2>&1
            ) | grep "134.383" || fail "the toolbox does not solve the first example in Octave"
        else
            leave_out "not run: the toolbox in Octave (needs the package octave-dev)"
        fi
        rm -r "$place"
    done
}

sbom() {
    [ -x "$tools/bin/cargo-cyclonedx" ] || cargo install --quiet --locked --debug --root "$tools" cargo-cyclonedx ||
        fail "cargo-cyclonedx cannot be installed: see above"
    # A file beside the manifest of every member of the workspace.
    cargo cyclonedx --quiet --format json --spec-version 1.5 --override-filename sbom.cdx
    # The folder of this machine is nobody's concern.
    for crate in cppr-cli cppr-py cppr-c; do sed "s|$root/||g" "crates/$crate/sbom.cdx.json" >"$out/$crate.cdx.json"; done
    rm -f crates/*/sbom.cdx.json
}

# names_no_folder: nothing that is published tells where it was compiled.
names_no_folder() {
    find "$out" -name '*.tar.gz' -o -name '*.crate' -o -name '*.whl' | while read -r archive; do
        place=$(mktemp -d)
        case $archive in
        *.whl) python3 -m zipfile -e "$archive" "$place" ;;
        *) tar -C "$place" -xzf "$archive" ;;
        esac
        ! grep -rlF -e "$root/" -e "$sources_of" "$place" || fail "these files in $archive name a folder of this machine"
        rm -r "$place"
    done
    ! grep -lF -e "$root/" -e "$sources_of" "$out"/*.json 2>/dev/null || fail "a list of contents names a folder of this machine"
}

for part in $parts; do $part; done
names_no_folder
(cd "$out" && find . -type f ! -name SHA256SUMS | sed 's|^\./||' | LC_ALL=C sort | xargs sha256sum >SHA256SUMS && sha256sum --quiet --check SHA256SUMS)
ls -l "$out"
