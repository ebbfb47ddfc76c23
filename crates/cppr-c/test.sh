#!/bin/sh
# The C interface as its users meet it: installed in a folder of its own, found by CMake and by pkg-config, examples and the C++ header run
# under address sanitizer where the compiler has it.
set -eu
cd "$(dirname "$0")/../.."

fail() {
    echo "crates/cppr-c/test.sh: $1" >&2
    exit 1
}
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    wanted=
    command -v c++ >/dev/null || wanted="$wanted g++"
    command -v cmake >/dev/null || wanted="$wanted cmake"
    command -v pkg-config >/dev/null || wanted="$wanted pkg-config"
    if [ -n "$wanted" ]; then
        apt-get update -qq
        # shellcheck disable=SC2086
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $wanted make >/dev/null
    fi
fi
for tool in c++ cc cmake pkg-config; do
    command -v $tool >/dev/null || fail "needs $tool on the PATH (Debian: apt-get install g++ cmake pkg-config)"
done

work=$PWD/target/cppr-c
rm -rf "$work"
mkdir -p "$work"
# The library as the tests of the workspace have built it: a build of this crate alone takes other features of what it needs, and minutes.
cargo test --release --quiet --workspace --test header --no-run
crates/cppr-c/install.sh --prefix="$work/installed" --built="${CARGO_TARGET_DIR:-target}/release/deps"
if crates/cppr-c/install.sh --prefx="$work" 2>/dev/null; then
    fail "install.sh takes an argument that it does not know"
fi

# Where the whole folder is moved, CMake and pkg-config find it still.
mv "$work/installed" "$work/moved"
sanitizer=
echo 'int main(void) { return 0; }' >"$work/empty.c"
if cc -fsanitize=address,undefined -fno-sanitize-recover=all "$work/empty.c" -o "$work/empty" 2>/dev/null && "$work/empty"; then
    sanitizer="-fsanitize=address,undefined -fno-sanitize-recover=all"
else
    echo "the C compiler has no address sanitizer: the examples run without"
fi
cmake -S crates/cppr-c/examples -B "$work/build" -DCMAKE_PREFIX_PATH="$work/moved" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_C_FLAGS="$sanitizer" -DCMAKE_CXX_FLAGS="$sanitizer" >"$work/cmake.log" || { cat "$work/cmake.log"; fail "CMake does not find cppr"; }
cmake --build "$work/build" --parallel 2 >"$work/make.log" || { cat "$work/make.log"; fail "the examples do not compile"; }
mkdir "$work/other"
cat >"$work/other/CMakeLists.txt" <<'EOF'
cmake_minimum_required(VERSION 3.16)
project(other CXX)
find_package(cppr 0.2 REQUIRED)
EOF
if cmake -S "$work/other" -B "$work/other/build" -DCMAKE_PREFIX_PATH="$work/moved" >/dev/null 2>&1; then
    fail "CMake takes this version for 0.2"
fi

"$work/build/first" robots/r3.toml | tee "$work/first.txt"
grep -q "^tip at 134.383 -54.908 0.000 mm, pulled with 1.5122 N$" "$work/first.txt" || fail "the first example gives other numbers"
# A second is long enough to see that it works, not to publish numbers.
"$work/build/loop_1khz" robots/childs3.toml 1
"$work/build/ros2_core" robots/childs3.toml

# The C++ header, found by pkg-config.
flags=$(PKG_CONFIG_PATH="$work/moved/lib/pkgconfig" pkg-config --cflags --libs cppr)
# shellcheck disable=SC2086
c++ -std=c++17 -Wall -Wextra -Wpedantic -Werror -pthread $sanitizer crates/cppr-c/tests/wrapper.cpp -o "$work/wrapper" $flags -Wl,-rpath,"$work/moved/lib"
"$work/wrapper" robots
# The first piece of C++ in the book.
awk '/^```cpp/ { n++; inside = n == 1; next } /^```/ { inside = 0 } inside' docs/src/c.md >"$work/page.txt"
{ grep '^#include' "$work/page.txt" && echo 'int main() {' && grep -v '^#include' "$work/page.txt" && echo '}'; } >"$work/page.cpp"
# shellcheck disable=SC2086
c++ -std=c++17 "$work/page.cpp" -o "$work/page" $flags -Wl,-rpath,"$work/moved/lib"
"$work/page"
# The header alone, as C99 and as C++17.
echo '#include "cppr.h"' >"$work/alone.c"
cc -std=c99 -pedantic-errors -Wall -Wextra -Werror -I"$work/moved/include" -fsyntax-only "$work/alone.c"
echo '#include "cppr.hpp"' >"$work/alone.cpp"
c++ -std=c++17 -pedantic-errors -Wall -Wextra -Wconversion -Werror -I"$work/moved/include" -fsyntax-only "$work/alone.cpp"
