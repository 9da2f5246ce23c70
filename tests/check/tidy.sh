#!/usr/bin/env bash
# What clang-tidy says of the project (.clang-tidy): nothing.  usage: tidy.sh BUILD
# A file that is as it was when it passed is not looked at again. One version, as for the layout; exits with 77 where there is none.
set -eu
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v clang-tidy-19 >/dev/null || { echo "clang-tidy-19 is not installed: nothing is looked at"; exit 77; }
mkdir -p "$build/tidy"
export root build

# look_at FILE [CHECKS]: what runs on a board with all checks, what runs on a host without two kinds
look_at() {
  local stamp
  stamp=$build/tidy/$( (cat "$root/.clang-tidy"; echo "${2-}"; cc -std=c11 -E -P -I"$root/src" -I"$root/src/soes" -I"$root/firmware" -I"$root/tools" \
    $(pkg-config --cflags libxml-2.0) "$1") | sha256sum | cut -d' ' -f1)
  [ ! -e "$stamp" ] || return 0
  clang-tidy-19 -p "$build" --quiet ${2:+"--checks=$2"} "$1" 2>/dev/null && touch "$stamp"
}
export -f look_at

printf '%s\0' "$root"/src/{od,esc,slave,sii}/*.c "$root"/src/{devices,ports}/*/*.c |
  xargs -0 -P "$(nproc)" -I{} bash -c 'look_at "$1"' look_at {}
printf '%s\0' "$root"/src/{bus,check,esi,facts}/*.c "$root"/tools/*/*.c |
  xargs -0 -P "$(nproc)" -I{} bash -c 'look_at "$1" "-clang-analyzer-*,-readability-non-const-parameter"' look_at {}
echo "clang-tidy has nothing to say"
