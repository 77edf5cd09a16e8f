#!/usr/bin/env bash
# Installs what is missing to build jostle, and with --test what its tests need. Runs as often as you like: it looks
# first, and does and prints nothing when all is there.
#
#   scripts/setup.sh              C compiler, make
#   scripts/setup.sh --test       also C++ compiler, pkg-config, cmake, Bullet, ONNX Runtime (into third_party/, to run
#                                 networks); says which optional tools are missing
#   scripts/setup.sh --optional   also installs the optional tools: valgrind, abigail-tools, libclang
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

with_tests=no
with_optional=no
for argument in "$@"; do
    case $argument in
        --test) with_tests=yes ;;
        --optional) with_tests=yes with_optional=yes ;;
        -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) echo "setup: unknown option $argument; see --help" >&2; exit 2 ;;
    esac
done

has() { command -v "$1" >/dev/null 2>&1; }
# bindgen loads libclang at run time.
has_clang() { PATH=$PATH:/sbin ldconfig -p 2>/dev/null | grep -q 'libclang\(-[0-9.]*\)\?\.so'; }
clang_packages() {
    if apt-cache show libclang1-14 >/dev/null 2>&1; then echo libclang1-14 libclang-common-14-dev; else echo libclang-dev; fi
}
say() { echo "setup: $*" >&2; }

# --- system tools -----------------------------------------------------------------------------------------------

packages=()
need() { # need COMMAND PACKAGE
    has "$1" || packages+=("$2")
}
need cc gcc
need make make
if [[ $with_tests == yes ]]; then
    need c++ g++
    need pkg-config pkg-config
    need cmake cmake
    # Both precisions come in one package; the engine takes the double one.
    has pkg-config && pkg-config --exists bullet-float64 || packages+=(libbullet-dev)
fi
if [[ $with_optional == yes ]]; then
    need valgrind valgrind
    need abidiff abigail-tools
    # To make the binding of Bullet anew (tests/bullet_bindings.rs).
    # shellcheck disable=SC2207  # names of packages hold no blanks
    has_clang || packages+=($(clang_packages))
fi
# A compiler without the C library's headers cannot build anything; Debian's packages allow that.
if has cc && has dpkg && [[ ! -e /usr/include/stdio.h ]]; then
    packages+=(libc6-dev)
fi

if ((${#packages[@]} > 0)); then
    if has apt-get; then
        root=()
        if ((EUID != 0)); then
            if ! has sudo; then
                say "missing: ${packages[*]}. Neither root nor sudo here; as root run: apt-get install ${packages[*]}"
                exit 1
            fi
            root=(sudo)
        fi
        say "installing ${packages[*]}"
        install=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends)
        # The package lists may be absent or old; fetch them only if the first try fails.
        if ! "${install[@]}" "${packages[@]}" </dev/null >/dev/null 2>&1; then
            "${root[@]}" apt-get update -q </dev/null >/dev/null
            "${install[@]}" "${packages[@]}" </dev/null >&2
        fi
    else
        say "missing: ${packages[*]} (Debian's names). Install them with your system's package manager, then run again."
        # Without a compiler nothing can be built; without the rest some tests are skipped.
        has cc && has make || exit 1
    fi
fi

if [[ $with_tests == yes && $with_optional == no ]]; then
    missing=()
    has valgrind || missing+=(valgrind)
    has abidiff || missing+=(abigail-tools)
    has_clang || missing+=(libclang)
    if ((${#missing[@]} > 0)); then
        say "optional, missing: ${missing[*]}; the checks that need them are skipped (scripts/setup.sh --optional)"
    fi
fi

# --- ONNX Runtime ---------------------------------------------------------------------------------------------------

# The library alone, out of the Python package: no Python is needed to use it. Any other ONNX Runtime from 1.24 on does as
# well (docs/networks.md).
ONNXRUNTIME=1.32.0
fetch_onnxruntime() {
    local folder=third_party/onnxruntime/lib work
    has python3 && python3 -m pip --version >/dev/null 2>&1 || return 1
    work=$(mktemp -d)
    if python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary=:all: --python-version 3.11 \
        --dest "$work" "onnxruntime==$ONNXRUNTIME" </dev/null >/dev/null 2>&1 &&
        python3 -m zipfile -e "$work"/onnxruntime-*.whl "$work/wheel" 2>/dev/null; then
        mkdir -p "$folder"
        cp "$work"/wheel/onnxruntime/LICENSE "$folder/.." 2>/dev/null || true
        cp "$work/wheel/onnxruntime/capi/libonnxruntime.so.$ONNXRUNTIME" "$folder"
        ln -sf "libonnxruntime.so.$ONNXRUNTIME" "$folder/libonnxruntime.so.1"
    fi
    rm -rf "$work"
    [[ -e $folder/libonnxruntime.so.1 ]]
}
has_onnxruntime() {
    [[ -n ${ORT_DYLIB_PATH:-} || -e third_party/onnxruntime/lib/libonnxruntime.so.1 ]] ||
        PATH=$PATH:/sbin ldconfig -p 2>/dev/null | grep -q 'libonnxruntime\.so\.1'
}
if [[ $with_tests == yes ]] && ! has_onnxruntime; then
    say "fetching ONNX Runtime $ONNXRUNTIME"
    fetch_onnxruntime || say "ONNX Runtime could not be fetched (it needs python3 with pip, and the network); the tests that \
run networks are skipped. docs/networks.md says how to get it otherwise."
fi

# --- Rust -------------------------------------------------------------------------------------------------------

wanted=$(sed -n 's/^rust-version *= *"\(.*\)".*/\1/p' Cargo.toml)
if ! has cargo && [[ -x ${CARGO_HOME:-$HOME/.cargo}/bin/cargo ]]; then
    PATH=${CARGO_HOME:-$HOME/.cargo}/bin:$PATH
fi
if ! has cargo || ! has rustc; then
    say "no Rust toolchain found. Install Rust $wanted or newer (rustup, or your system's packages), then run again."
    exit 1
fi
# `rustc 1.95.0 (...)`, `rustc 1.96.0-nightly (...)`
version=$(rustc --version)
found=${version#rustc }
found=${found%%[ -]*}
older() { # older A B: whether version A lies before B
    local -a a b
    IFS=. read -ra a <<<"$1"
    IFS=. read -ra b <<<"$2"
    local i
    for i in 0 1 2; do
        ((10#${a[i]:-0} == 10#${b[i]:-0})) || { ((10#${a[i]:-0} < 10#${b[i]:-0})); return; }
    done
    return 1
}
if older "$found" "$wanted"; then
    say "Rust $found is too old; jostle needs $wanted or newer. With rustup: rustup update stable"
    exit 1
fi
