#!/usr/bin/env bash
# A SOEM that is found is taken when our programs compile with it, and not otherwise.  usage: soem.sh DIRECTORY-OF-A-SOEM-1.4
set -eu
good=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# taken DIRECTORY: the verdict of cmake/soem.cmake on the package there.
taken() {
  rm -rf "$work/build"
  cmake -G Ninja -S "$work" -B "$work/build" -Dsoem_DIR="$1" | sed -n 's/^-- found: //p'
}

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

cat >"$work/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.22)
project(taken LANGUAGES C)
include($root/cmake/soem.cmake)
message(STATUS "found: \${soem_FOUND}")
CMAKE
mkdir "$work/other" # as SOEM 2: its header is soem/soem.h
echo 'add_library(soem INTERFACE IMPORTED)' >"$work/other/soemConfig.cmake"

check "a SOEM 1.4" 1 "$(taken "$good")"
check "a SOEM with another interface" FALSE "$(taken "$work/other")"
exit $failed
