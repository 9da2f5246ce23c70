#!/usr/bin/env bash
# The API manual builds without a warning.  usage: doxygen.sh      Exits with 77 without doxygen.
set -eu
cd "$(dirname "$0")/../.."
command -v doxygen >/dev/null || { echo "doxygen is not installed (apt-get install doxygen)"; exit 77; }
mkdir -p build/doxygen
doxygen docs/Doxyfile >build/doxygen/log 2>&1 || { cat build/doxygen/log; exit 1; }
grep -v '^$' build/doxygen/log || exit 0
echo "doxygen: $(grep -c warning build/doxygen/log) warnings"
exit 1
