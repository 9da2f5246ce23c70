#!/usr/bin/env bash
# A SOEM that is found is taken when our programs compile with it, and not otherwise.  usage: soem.sh DIRECTORY-OF-A-SOEM-1.4
set -eu
good=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0

# taken DIRECTORY: the verdict of cmake/soem.cmake on the package there.
taken() {
  rm -rf "$work/build"
  cmake -G Ninja -S "$work" -B "$work/build" -Dsoem_DIR="$1" | sed -n 's/^-- found: //p'
}

expect() { # TITLE EXPECTED ACTUAL
  [ "$2" = "$3" ] && return 0
  printf 'FAILED %s: expected %s, got %s\n' "$1" "$2" "$3"
  status=1
}

cat >"$work/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.22)
project(taken LANGUAGES C)
include($root/cmake/soem.cmake)
message(STATUS "found: \${soem_FOUND}")
CMAKE
mkdir "$work/other" # as SOEM 2: its header is soem/soem.h
echo 'add_library(soem INTERFACE IMPORTED)' >"$work/other/soemConfig.cmake"

expect "a SOEM 1.4" 1 "$(taken "$good")"
expect "a SOEM with another interface" FALSE "$(taken "$work/other")"
exit $status
