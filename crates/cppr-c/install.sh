#!/bin/sh
# Builds the C library and lays it out under a folder: include, lib (shared, static, pkg-config) and share/cppr/cmake.
#   crates/cppr-c/install.sh --prefix=/usr/local [--destdir=DIR] [--built=DIR]
# --built takes the library from a folder where it has been built already. The whole may be moved: pkg-config and CMake look from where they find it.
set -eu
prefix=/usr/local
destdir=
built=
for argument in "$@"; do
    case $argument in
        --prefix=*) prefix=${argument#--prefix=} ;;
        --destdir=*) destdir=${argument#--destdir=} ;;
        --built=*) built=${argument#--built=} ;;
        *)
            echo "install.sh: '$argument' is not known; it takes --prefix=DIR, --destdir=DIR and --built=DIR" >&2
            exit 2
            ;;
    esac
done
case $prefix in
    /*) ;;
    *) prefix=$PWD/$prefix ;;
esac
cd "$(dirname "$0")/../.."

if [ -z "$built" ]; then
    cargo build --release --quiet -p cppr-c
    built=${CARGO_TARGET_DIR:-target}/release
fi
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
to=$destdir$prefix
mkdir -p "$to/include" "$to/lib/pkgconfig" "$to/share/cppr/cmake"
install -m 644 crates/cppr-c/include/cppr.h crates/cppr-c/include/cppr.hpp "$to/include"
install -m 644 crates/cppr-c/cmake/*.cmake "$to/share/cppr/cmake"
install -m 644 "$built/libcppr_c.a" "$to/lib/libcppr.a"
case $(uname) in
    Darwin)
        install -m 755 "$built/libcppr_c.dylib" "$to/lib/libcppr.1.dylib"
        install_name_tool -id "$prefix/lib/libcppr.1.dylib" "$to/lib/libcppr.1.dylib"
        ln -sf libcppr.1.dylib "$to/lib/libcppr.dylib"
        ;;
    *)
        install -m 755 "$built/libcppr_c.so" "$to/lib/libcppr.so.1.0.0"
        ln -sf libcppr.so.1.0.0 "$to/lib/libcppr.so.1"
        ln -sf libcppr.so.1 "$to/lib/libcppr.so"
        "${STRIP:-strip}" --strip-unneeded "$to/lib/libcppr.so.1.0.0"
        "${STRIP:-strip}" --strip-debug "$to/lib/libcppr.a"
        ;;
esac
cat >"$to/lib/pkgconfig/cppr.pc" <<EOF
prefix=\${pcfiledir}/../..
libdir=\${prefix}/lib
includedir=\${prefix}/include

Name: cppr
Description: Statics of concentric push-pull robots
Version: $version
Libs: -L\${libdir} -lcppr
Libs.private: -lpthread -ldl -lm
Cflags: -I\${includedir}
EOF
echo "cppr $version for C and C++ is in $to"
