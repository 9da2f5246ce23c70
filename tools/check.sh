#!/usr/bin/env bash
# The checks of a contributor, in addition to tools/test.sh. Installs missing packages first. A stage whose tool cannot be installed
# is skipped, with the reason.  usage: tools/check.sh [STAGE...]      every stage, or those named
#
#   tidy      clang-tidy finds nothing in the sources
#   coverage  branch coverage of the unit tests is not below the floors in tests/budget/coverage
#   release   unit tests built like the product, at -O3
#   clang     unit tests built by the second compiler; each fuzz target over its committed seeds and 5 s beyond
#   long      tests that take long: each deliberate defect fails its case of the whole catalogue, and no other; the catalogue on further
#             boards and chips, and with a million frames; a firmware update in mails of four bytes; examples/fuzz-master
#   sizes     text, RAM and stack of the core and of the firmware are within tests/budget
#   presets   the builds for other processors
#   docs      the API manual builds without a warning
#   matrix    every requirement has a test or a reason
set -eu
cd "$(dirname "$0")/.."
. tools/dev/stages.sh

tidy() {
  stage "tidy: build" preset asan
  stage tidy tests/check/tidy.sh build/asan
}

coverage() {
  stage "coverage: build" preset coverage
  stage "coverage: unit tests" ctest --test-dir build/coverage -L unit -j "$jobs"
  shown coverage tests/check/coverage.sh build/coverage
}

release() {
  stage "release: build" preset release-tests
  stage "release: unit tests" ctest --test-dir build/release-tests -L unit -j "$jobs"
}

clang() {
  stage "clang: build" preset clang
  stage "clang: unit tests and seeds" ctest --test-dir build/clang -L 'unit|fuzz' -j "$jobs"
  local source target words
  for source in tests/fuzz/fuzz_*.c; do
    target=$(basename "${source#*/fuzz_}" .c)
    words=()
    [ ! -f "tests/fuzz/$target.dict" ] || words=("-dict=tests/fuzz/$target.dict")
    stage "clang: fuzz_$target" "build/clang/tests/fuzz/fuzz_$target" -max_total_time=5 -max_len=4096 "${words[@]}" -artifact_prefix=build/clang/
  done
}

long() {
  stage "long: build" preset asan
  stage "long: boards" tests/check/board_image.sh
  stage long ctest --test-dir build/asan -L '^long$' -j "$jobs"
}

sizes() {
  shown "sizes: core" tests/check/size.sh
  shown "sizes: stack" tests/check/stack.py
  shown "sizes: firmware" tests/check/firmware.py
}

presets() {
  local name
  for name in aarch64-linux armhf-linux; do
    stage "presets: $name" preset $name
  done
}

docs() {
  stage docs tests/check/doxygen.sh
}

matrix() {
  mkdir -p build
  stage matrix tools/dev/matrix.py
  grep 'requirements have' build/logs/matrix.log
}

shown packages tools/bootstrap.sh test
for stage in "${@:-tidy coverage release clang long sizes presets docs matrix}"; do
  case " tidy coverage release clang long sizes presets docs matrix " in
    *" $stage "*) ;;
    *) [ $# -eq 0 ] || { echo "check.sh: no stage is named \"$stage\"; the stages are in the first lines of $0" >&2; exit 1; } ;;
  esac
  for name in $stage; do
    $name
  done
done
echo "all checks passed, $SECONDS s"
