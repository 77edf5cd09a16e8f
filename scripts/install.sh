#!/usr/bin/env bash
# Installs the built library, or removes it again. Called by the Makefile, which sets the variables:
#   scripts/install.sh install|uninstall
#   DESTDIR (staging folder), PREFIX, LIBDIR, INCLUDEDIR (absolute), BUILD (folder of the build products)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

what=${1:?install or uninstall}
: "${DESTDIR:=}" "${PREFIX:=/usr/local}" "${BUILD:=target/release}"
: "${LIBDIR:=$PREFIX/lib}" "${INCLUDEDIR:=$PREFIX/include}"
fail() { echo "install: $*" >&2; exit 1; }
for folder in "$PREFIX" "$LIBDIR" "$INCLUDEDIR"; do
    [[ $folder == /* ]] || fail "$folder is not an absolute path; give PREFIX, LIBDIR and INCLUDEDIR as absolute paths"
done

field() { sed -n "s/^$1 *= *\"\(.*\)\".*/\1/p" Cargo.toml | head -n 1; }
version=$(field version)
IFS=. read -r major minor _ <<<"${version%%[-+]*}"

bindir=$PREFIX/bin
pcdir=$LIBDIR/pkgconfig
cmakedir=$LIBDIR/cmake/jostle
docdir=$PREFIX/share/doc/jostle
datadir=$PREFIX/share/jostle

# The library states its own ABI; nothing here repeats the number.
soname_of() { LC_ALL=C readelf -d "$1" | sed -n 's/.*(SONAME).*\[\(.*\)\].*/\1/p'; }

if [[ $what == uninstall ]]; then
    rm -f "$DESTDIR$LIBDIR"/libjostle.so{,.*} "$DESTDIR$LIBDIR/libjostle.a" "$DESTDIR$pcdir/jostle.pc" \
        "$DESTDIR$bindir/jostle"
    rm -rf "${DESTDIR}${cmakedir:?}" "${DESTDIR}${docdir:?}" "${DESTDIR}${datadir:?}" "${DESTDIR}${INCLUDEDIR:?}/jostle"
    rmdir --ignore-fail-on-non-empty "$DESTDIR$pcdir" "$DESTDIR$LIBDIR/cmake" 2>/dev/null || true
    exit 0
fi
[[ $what == install ]] || fail "install or uninstall, not $what"

for file in libjostle.so libjostle.a jostle; do
    [[ -e $BUILD/$file ]] || fail "$BUILD/$file is missing; run \`make build\` first"
done
soname=$(soname_of "$BUILD/libjostle.so")
[[ $soname == libjostle.so.* ]] || fail "$BUILD/libjostle.so has the SONAME '$soname'; expected libjostle.so.N"
shared=libjostle.so.$version

# relative FROM TO: TO as seen from FROM, both absolute.
relative() {
    local from=$1/ to=$2/ up=
    while [[ $to != "$from"* ]]; do
        from=${from%/}
        from=${from%/*}/
        up=../$up
    done
    to=$up${to#"$from"}
    to=${to%/}
    echo "${to:-.}"
}
# A folder below the prefix is written relative to it; any other as it is.
below_prefix() {
    if [[ $1/ == "$PREFIX"/* ]]; then echo "\${prefix}${1#"$PREFIX"}"; else echo "$1"; fi
}

# What a static link needs besides: `rustc --print native-static-libs`.
native='gcc_s util rt pthread m dl c'
# With the feature `bullet` it needs that library too, which is there as a shared one only.
if LC_ALL=C readelf -d "$BUILD/libjostle.so" | grep -q 'NEEDED.*libBulletDynamics-float64'; then
    native="BulletDynamics-float64 BulletCollision-float64 LinearMath-float64 stdc++ $native"
fi
fill() { # fill TEMPLATE TARGET NATIVE_LIBS
    sed -e "s|@VERSION@|$version|g" -e "s|@VERSION_MAJOR@|$major|g" -e "s|@VERSION_MINOR@|$minor|g" \
        -e "s|@DESCRIPTION@|$(field description)|g" -e "s|@SONAME@|$soname|g" -e "s|@SHARED_FILE@|$shared|g" \
        -e "s|@NATIVE_LIBS@|$3|g" -e "s|@POINTER_BYTES@|$pointer_bytes|g" \
        -e "s|@PREFIX_FROM_PC@|$(relative "$pcdir" "$PREFIX")|g" \
        -e "s|@PC_LIBDIR@|$(below_prefix "$LIBDIR")|g" -e "s|@PC_INCLUDEDIR@|$(below_prefix "$INCLUDEDIR")|g" \
        -e "s|@LIBDIR_FROM_CMAKE@|$(relative "$cmakedir" "$LIBDIR")|g" \
        -e "s|@INCLUDEDIR_FROM_CMAKE@|$(relative "$cmakedir" "$INCLUDEDIR")|g" "$1" >"$2"
    chmod 644 "$2"
}
case $(LC_ALL=C readelf -h "$BUILD/libjostle.so") in *ELF64*) pointer_bytes=8 ;; *) pointer_bytes=4 ;; esac

install -d "$DESTDIR$bindir" "$DESTDIR$LIBDIR" "$DESTDIR$pcdir" "$DESTDIR$cmakedir" "$DESTDIR$INCLUDEDIR/jostle" \
    "$DESTDIR$docdir" "$DESTDIR$datadir"
install -m 755 "$BUILD/jostle" "$DESTDIR$bindir/jostle"
install -m 755 "$BUILD/libjostle.so" "$DESTDIR$LIBDIR/$shared"
ln -sf "$shared" "$DESTDIR$LIBDIR/$soname"
ln -sf "$soname" "$DESTDIR$LIBDIR/libjostle.so"
install -m 644 "$BUILD/libjostle.a" "$DESTDIR$LIBDIR/libjostle.a"
install -m 644 include/jostle/*.h include/jostle/*.hpp "$DESTDIR$INCLUDEDIR/jostle/"
install -m 644 LICENSE LICENSE-MIT LICENSE-APACHE README.md CHANGELOG.md "$DESTDIR$docdir/"
# For bindings to other languages.
install -m 644 bindings/layout/layout.json bindings/layout/layout.txt "$DESTDIR$datadir/"
fill bindings/pkgconfig/jostle.pc.in "$DESTDIR$pcdir/jostle.pc" "-l${native// / -l}"
fill bindings/cmake/jostle-config.cmake.in "$DESTDIR$cmakedir/jostle-config.cmake" "${native// /;}"
fill bindings/cmake/jostle-config-version.cmake.in "$DESTDIR$cmakedir/jostle-config-version.cmake" ''
