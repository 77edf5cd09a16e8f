#!/usr/bin/env bash
# Installs into temporary folders, moves them, and builds and runs programs against them: through pkg-config and
# through CMake, shared and static, in C and in C++. Then uninstalls and looks for what was left behind.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
here=$PWD/tests/consumer

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "consumer: $*" >&2; exit 1; }
step() { echo "consumer: $*"; }
make_target() { # make_target install|uninstall STAGE LIBDIR
    make --no-print-directory "$1" DESTDIR="$2" PREFIX=/usr LIBDIR="$3" INCLUDEDIR=/usr/include >/dev/null
}
uninstall() { # uninstall STAGE LIBDIR
    make_target uninstall "$1" "$2"
    local left
    left=$(find "$1" \( -type f -o -type l \) -print)
    [[ -z $left ]] || fail "uninstall left: $left"
}
strict=(-Wall -Wextra -Werror -pedantic)

# --- pkg-config, with a library folder two levels below the prefix ------------------------------------------------

libdir=/usr/lib/some-arch
make_target install "$work/staged" "$libdir"
mv "$work/staged" "$work/moved"
stage=$work/moved

step "ABI number of the header and of the library"
abi=$(sed -n 's/^#define JOSTLE_ABI_VERSION \([0-9]*\).*/\1/p' "$stage/usr/include/jostle/jostle.h")
[[ -e $stage$libdir/libjostle.so.$abi ]] || fail "jostle.h says ABI '$abi', but there is no libjostle.so.$abi"

step "layouts for bindings"
for file in layout.json layout.txt; do
    cmp "bindings/layout/$file" "$stage/usr/share/jostle/$file" || fail "$file is not installed as it is"
done
version=$(sed -n 's/^#define JOSTLE_VERSION "\(.*\)".*/\1/p' "$stage/usr/include/jostle/jostle.h")
grep -q "\"version\": \"$version\"" "$stage/usr/share/jostle/layout.json" || fail "layout.json is not of version $version"

step "exported symbols and the header"
exported=$(nm -D --defined-only "$stage$libdir/libjostle.so" | awk '{ print $3 }')
[[ -n $exported ]] || fail "libjostle.so exports nothing"
for symbol in $exported; do
    grep -qw "$symbol" "$stage"/usr/include/jostle/jostle.h || fail "$symbol is exported, but not in jostle.h"
done

if command -v pkg-config >/dev/null; then
    # Without these, pkg-config leaves out /usr/include and /usr/lib, also where they lie below a staging folder.
    export PKG_CONFIG_ALLOW_SYSTEM_CFLAGS=1 PKG_CONFIG_ALLOW_SYSTEM_LIBS=1
    export PKG_CONFIG_PATH=$stage$libdir/pkgconfig
    read -ra cflags <<<"$(pkg-config --cflags jostle)"
    read -ra shared <<<"$(pkg-config --libs jostle)"
    read -ra static <<<"$(pkg-config --static --libs jostle)"
    static=("${static[@]/#-ljostle/-l:libjostle.a}")
    build_and_run() { # build_and_run LINK_OPTION...
        "${CC:-cc}" -std=c11 "${strict[@]}" "${cflags[@]}" "$here/use_c.c" -o "$work/use_c" "$@"
        "${CXX:-c++}" -std=c++17 "${strict[@]}" "${cflags[@]}" "$here/use_cpp.cpp" -o "$work/use_cpp" "$@"
        "$work/use_c"
        "$work/use_cpp"
    }
    step "pkg-config, shared"
    LD_LIBRARY_PATH=$stage$libdir build_and_run "${shared[@]}"
    if command -v valgrind >/dev/null; then
        step "pkg-config, shared, under valgrind"
        LD_LIBRARY_PATH=$stage$libdir valgrind -q --error-exitcode=1 --leak-check=full \
            --errors-for-leak-kinds=definite "$work/use_c"
    else
        step "SKIPPED valgrind: it is not installed"
    fi
    step "pkg-config, static"
    build_and_run "${static[@]}"
else
    step "SKIPPED pkg-config: it is not installed"
fi
uninstall "$stage" "$libdir"

# --- CMake, with a space in the folder's name ---------------------------------------------------------------------

if command -v cmake >/dev/null; then
    libdir=/usr/lib
    make_target install "$work/staged again" "$libdir"
    stage="$work/moved again"
    mv "$work/staged again" "$stage"
    version=$(sed -n 's/^version *= *"\(.*\)".*/\1/p' Cargo.toml | head -n 1)
    quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "failed: $*"; }; }
    configure() { # configure BUILD_FOLDER WANTED_VERSION
        cmake -S "$here" -B "$1" -DCMAKE_PREFIX_PATH="$stage/usr" -DWANTED_VERSION="$2"
    }
    step "CMake find_package, shared and static"
    quietly configure "$work/build" "${version%.*}"
    quietly cmake --build "$work/build"
    (cd "$work/build" && quietly ctest --output-on-failure)
    sed -n '/tests passed/p' "$work/log"
    step "CMake refuses a version that is not there"
    if configure "$work/other" 0.999 >/dev/null 2>&1; then fail "find_package took 0.999 for $version"; fi
    uninstall "$stage" "$libdir"
else
    step "SKIPPED CMake: it is not installed"
fi
step "all passed"
