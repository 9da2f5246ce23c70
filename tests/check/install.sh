#!/usr/bin/env bash
# An installed ectwin at another place than it was installed to: examples/chain by CMake and by pkg-config, the Python module, and
# `ectwin with --in-process`.  usage: install.sh BUILD CALLS [FLAGS]    CALLS: a master; FLAGS: what BUILD was compiled with
set -eu
build=$1
calls=$2
flags="-Wall -Wextra -Wconversion -Wshadow -Werror ${3:-}"
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0
unset ECTWIN ECTWIN_LIBRARY

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log"; echo "FAILED $*"; exit 1; }; }

quietly cmake --install "$build" --prefix "$work/elsewhere"
mv "$work/elsewhere" "$work/prefix"
prefix=$work/prefix
library=$(dirname "$(find "$prefix" -name libectwin.so)")

frames="2 of 2 slaves reply, AL status 1
ecat.state = 1
refused: slave 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists those of a device; -n chooses the slave
of 10 frames 5 are lost"
cp -r "$root/examples/chain" "$work/chain" # nothing beside it
quietly cmake -G Ninja -S "$work/chain" -B "$work/by-cmake" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_FLAGS="$flags"
quietly cmake --build "$work/by-cmake"
check "find_package(ectwin COMPONENTS chain): frames through two twins" "$frames" "$("$work/by-cmake/chain" fzm1,vr-bu-ect-map7 | head -n 4)"
check "a wrong device ends the example with a line" "1 chain: there is no device 'nosuch'" \
  "$("$work/by-cmake/chain" nosuch >"$work/out" 2>&1; echo $? "$(sed "s/'nosuch'.*/'nosuch'/" "$work/out")")"
export PKG_CONFIG_PATH=$library/pkgconfig
# shellcheck disable=SC2046,SC2086
quietly ${CC:-cc} -std=c11 $flags "$work/chain/chain.c" $(pkg-config --cflags --libs ectwin-chain) -o "$work/by-pkg-config"
check "pkg-config ectwin-chain" "$frames" "$(LD_LIBRARY_PATH=$library "$work/by-pkg-config" fzm1,vr-bu-ect-map7 | head -n 4)"

# A program that uses the library needs two components of ectwin and no other part.
quietly cmake --install "$build" --prefix "$work/alone" --component library
quietly cmake --install "$build" --prefix "$work/alone" --component chain
check "the two components have the library, its header and nothing of the others" "libectwin.so libectwin.so.0 library.h linkage.h" \
  "$(find "$work/alone" \( -name 'lib*' -o -name '*.h' \) ! -type d ! -name '*.so.*.*.*' -printf '%f\n' | sort | xargs)"

asan=$(ldd "$prefix/bin/ectwin" | awk '/libasan/ { print $3 }')
version=$(LD_PRELOAD=$asan PATH="$prefix/bin:$PATH" PYTHONPATH="$root/python" python3 -c 'import ectwin; print(len(ectwin.Chain("fzm1,fzm1")))' 2>&1)
check "ectwin.Chain finds the library of the command in PATH" 2 "$version"

for clock in real virtual; do
  option=()
  [ "$clock" = real ] || option=(--virtual-time)
  "$prefix/bin/ectwin" with --in-process "${option[@]}" fzm1,fzm1 -- "$calls" '{}' "$clock" 'sendmmsg*' >"$work/out" 2>&1 && got=0 || got=$?
  check "with --in-process, $clock clock" "0 yes" "$got $(grep -q '"event":"ready"' "$work/out" && echo yes)"
done
mv "$library"/libectwin.so.0 "$work"
"$prefix/bin/ectwin" with --in-process fzm1 -- "$calls" '{}' real 'sendmmsg*' >"$work/out" 2>&1 || true
check "without the library of the bus a line gives the cure" yes "$(grep -q 'ectwin: .*libectwin.so.0.*install ectwin again' "$work/out" && echo yes)"
mv "$library"/ectwin "$work"
check "without the library of the sockets a line gives the cure" \
  "ectwin with: libectwin-real.so is not where ectwin is installed: install ectwin again" \
  "$("$prefix/bin/ectwin" with --in-process fzm1 -- true 2>&1)"
exit $failed
