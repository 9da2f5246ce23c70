#!/usr/bin/env bash
# Process data with --in-kernel while the twins' process is stopped at random (SIGSTOP), with eight busy loops: no image is torn,
# none is lost.  usage, as root: tools/dev/stopped.sh [CYCLES [SEED [SECONDS]]]
# (default 60000 cycles, seed 1, within 900 s of real time)
set -eu
cd "$(dirname "$0")/../.."
cycles=${1:-60000} seed=${2:-1} seconds=${3:-900}
build=${ECTWIN_BUILD:-build/dev}
if [ "$build" = build/dev ]; then
  tools/bootstrap.sh test
  cmake --preset dev >/dev/null
  cmake --build --preset dev --target ectwin_of_tests test_stopped >/dev/null
fi
loops=()
trap 'kill "${loops[@]}"' EXIT
for _ in 1 2 3 4 5 6 7 8; do
  (while :; do :; done) &
  loops+=($!)
done
timeout "$seconds" tests/integration/in_kernel_stopped.sh "$build/tests/integration/of_tests/ectwin_of_tests" \
  "$build/tests/integration/test_stopped" "$cycles" "$seed"
