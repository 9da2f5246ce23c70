#!/usr/bin/env bash
# Commands between a controller and a base unit on a bus that loses 10 % of the frames, in process, on the virtual clock: each
# command must arrive exactly once and in order, in both directions.  usage: tools/dev/commands.sh [COUNT [SECONDS]]
# (default a million commands each way, within 3600 s of real time; about two minutes of processor time)
set -eu
cd "$(dirname "$0")/../.."
count=${1:-1000000}
seconds=${2:-3600}
build=${ECTWIN_BUILD:-build/dev}
if [ "$build" = build/dev ]; then
  tools/bootstrap.sh test
  cmake --preset dev >/dev/null
  cmake --build --preset dev --target ectwin ectwin_chain ectwin_inprocess_virtual test_commands >/dev/null
fi
exec timeout "$seconds" "$build/ectwin" with --in-process --virtual-time --fault "at slave 1 OP drop 10%" vr-bu-ect-map7 -- \
  "$build/tests/integration/test_commands" {} "$count"
