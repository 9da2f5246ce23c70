#!/usr/bin/env bash
# All tests: installs what is missing, builds, runs.  usage: tools/test.sh
#
#   asan      unit and integration tests under AddressSanitizer and UBSan
#   tidy      clang-tidy has nothing to say of the sources
#   coverage  unit tests again, for the branch coverage of the core; fails below the floor in tests/budget/coverage
#   clang     unit tests with the second compiler; each fuzz target over its committed seeds and 5 s beyond
set -eu
cd "$(dirname "$0")/.."
tools/bootstrap.sh test
export CTEST_OUTPUT_ON_FAILURE=1
jobs=$(nproc)

build() {
  mkdir -p build
  cmake --preset "$1" >"build/$1.log" 2>&1 || { cat "build/$1.log"; exit 1; }
  cmake --build --preset "$1" >"build/$1.log" 2>&1 || { cat "build/$1.log"; exit 1; }
  rm -f "build/$1.log"
}

build asan
ctest --test-dir build/asan -L unit -j "$jobs"
ctest --test-dir build/asan -L integration -j "$jobs"

tests/check/tidy.sh build/asan || [ $? -eq 77 ]

build coverage
ctest --test-dir build/coverage -L unit -j "$jobs" >/dev/null
tests/check/coverage.sh build/coverage

build clang
ctest --test-dir build/clang -L 'unit|fuzz' -j "$jobs"
for source in tests/fuzz/fuzz_*.c; do
  target=$(basename "${source#*/fuzz_}" .c)
  words=()
  [ -f tests/fuzz/$target.dict ] && words=("-dict=tests/fuzz/$target.dict")
  echo "fuzz_$target: 5 s"
  build/clang/tests/fuzz/fuzz_$target -max_total_time=5 -max_len=4096 "${words[@]}" -artifact_prefix=build/clang/ \
    >build/clang/fuzz_$target.log 2>&1 || { tail -40 build/clang/fuzz_$target.log; exit 1; }
done

tests/check/size.sh
tests/check/stack.py
tests/check/firmware.py || [ $? -eq 77 ]
for preset in aarch64-linux armhf-linux; do
  build $preset
done
tools/dev/matrix.py >build/matrix.txt || { grep WRONG build/matrix.txt; exit 1; }
grep 'requirements have' build/matrix.txt
echo "all tests passed"
