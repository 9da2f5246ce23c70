#!/usr/bin/env bash
# Fuzzes every target for a given time.  usage: tools/dev/fuzz.sh [SECONDS-EACH [TARGET...]]   (default 60, all)
# New inputs are stored in build/clang/corpus; a crash ends the run, and its input is in build/clang. The target "master" is SOEM
# (examples/fuzz-master): its crashes are listed, and their inputs are left in build/fuzz-master.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
shift || true

fuzz_master() {
  tools/bootstrap.sh test
  local prefix=$PWD/build/fuzz-master/prefix found
  cmake --preset release >/dev/null
  cmake --build --preset release >build/release/log || { tail -20 build/release/log; exit 1; }
  cmake --install build/release --prefix "$prefix" >/dev/null
  cmake -G Ninja -S examples/fuzz-master -B build/fuzz-master -DCMAKE_C_COMPILER=clang -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
  cmake --build build/fuzz-master >/dev/null
  mkdir -p build/fuzz-master/corpus
  echo "fuzz-master: $seconds s"
  (cd build/fuzz-master && ./fuzz-master -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 -timeout=10 -max_len=512 \
    -max_total_time="$seconds" corpus ../../examples/fuzz-master/seeds >fuzz.log 2>&1) || true
  tail -n 1 build/fuzz-master/fuzz.log
  found=$(cd build/fuzz-master && for input in crash-*; do # the parent of the runs does not print their reports
    [ ! -e "$input" ] || ./fuzz-master "$input" 2>&1 | sed -n 's/^SUMMARY: //p'
  done | sort | uniq -c)
  echo "${found:-no crash of the master}"
}

wanted=" ${*:-all} "
case "$wanted" in *" all "* | *" master "*) fuzz_master ;; esac
[ "$wanted" != " master " ] || exit 0
tools/bootstrap.sh test
cmake --preset clang >/dev/null
cmake --build --preset clang >/dev/null
cd build/clang
for source in ../../tests/fuzz/fuzz_*.c; do
  target=$(basename "${source#*/fuzz_}" .c)
  case "$wanted" in *" all "* | *" $target "*) ;; *) continue ;; esac
  words=()
  [ -f ../../tests/fuzz/$target.dict ] && words=("-dict=../../tests/fuzz/$target.dict")
  mkdir -p "corpus/$target"
  echo "fuzz_$target: $seconds s"
  tests/fuzz/fuzz_$target -max_total_time="$seconds" -max_len=4096 "${words[@]}" -print_final_stats=1 "corpus/$target" \
    "../../tests/fuzz/seeds/$target" >"fuzz_$target.log" 2>&1 || { tail -40 "fuzz_$target.log"; exit 1; }
  grep -E 'stat::(number_of_executed_units|new_units_added)|cov:' "fuzz_$target.log" | tail -3
done
echo "no crash"
