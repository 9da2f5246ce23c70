#!/usr/bin/env bash
# The integration tests beside busy loops: no test may depend on how fast the machine is.
# usage: tools/dev/busy.sh [RUNS [LOOPS [CTEST-OPTION...]]]   (20 runs, 8 loops; a run takes 4 to 7 minutes on two cores)
#
# The output of a run with a failed test remains in build/logs/busy.RUN.log.
set -eu
cd "$(dirname "$0")/../.."
runs=${1:-20} loops=${2:-8}
shift $(($# < 2 ? $# : 2))
mkdir -p build/logs
tools/bootstrap.sh test >build/logs/busy.build.log
. tools/dev/test_environment.sh
cmake --preset asan >>build/logs/busy.build.log
cmake --build --preset asan >>build/logs/busy.build.log
tests/check/board_image.sh >>build/logs/busy.build.log
for ((n = 0; n < loops; n++)); do
  (while kill -0 $$ 2>/dev/null; do for ((turn = 0; turn < 100000; turn++)); do :; done; done) & # until this script ends
done
failed=0
for ((run = 1; run <= runs; run++)); do
  log=build/logs/busy.$run.log
  if ctest --test-dir build/asan -L integration -j $((4 * $(nproc))) --output-on-failure "$@" >"$log" 2>&1 </dev/null; then
    echo "run $run: passed, $(sed -n 's/^Total Test time (real) = *//p' "$log")"
    rm "$log"
  else
    failed=$((failed + 1))
    echo "run $run: FAILED, $(sed -n 's/^\t *[0-9]* - \(.*\) (\(Failed\|Timeout\)).*/\1/p' "$log" | xargs)"
  fi
done
echo "$((runs - failed)) of $runs runs passed beside $loops loops"
[ "$failed" -eq 0 ]
