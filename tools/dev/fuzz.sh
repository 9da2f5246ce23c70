#!/usr/bin/env bash
# Fuzzes every target for a given time.  usage: tools/dev/fuzz.sh [SECONDS-EACH]   (default 60)
# New inputs go to build/clang/corpus; a crash stops it and leaves the input in build/clang.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
tools/bootstrap.sh test
cmake --preset clang >/dev/null
cmake --build --preset clang >/dev/null
cd build/clang
for source in ../../tests/fuzz/fuzz_*.c; do
  target=$(basename "${source#*/fuzz_}" .c)
  words=()
  [ -f ../../tests/fuzz/$target.dict ] && words=("-dict=../../tests/fuzz/$target.dict")
  mkdir -p "corpus/$target"
  echo "fuzz_$target: $seconds s"
  tests/fuzz/fuzz_$target -max_total_time="$seconds" -max_len=4096 "${words[@]}" -print_final_stats=1 "corpus/$target" \
    "../../tests/fuzz/seeds/$target" >"fuzz_$target.log" 2>&1 || { tail -40 "fuzz_$target.log"; exit 1; }
  grep -E 'stat::(number_of_executed_units|new_units_added)|cov:' "fuzz_$target.log" | tail -3
done
echo "no crash"
