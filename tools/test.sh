#!/usr/bin/env bash
# The tests: unit and integration tests under AddressSanitizer and UBSan. Installs missing packages and builds first.
# usage: tools/test.sh [CTEST-OPTION...]      every test, or for example: tools/test.sh -R fzm1
#
# tools/check.sh has the further checks of a contributor.
set -eu
cd "$(dirname "$0")/.."
. tools/dev/stages.sh
shown packages tools/bootstrap.sh test
. tools/dev/test_environment.sh
stage build preset asan
if [ $# -gt 0 ]; then
  shown chosen ctest --test-dir build/asan -j "$jobs" "$@"
  exit
fi
stage boards tests/check/board_image.sh
shown unit ctest --test-dir build/asan -L unit -j "$jobs"
# Four slots for each core. PROCESSORS of a test is its share: one slot for a test that waits for real time, two for a test that computes
# (tests/integration/CMakeLists.txt). No test depends on the load of the others.
shown integration ctest --test-dir build/asan -L integration -j $((4 * jobs))
echo "all tests passed, $SECONDS s"
