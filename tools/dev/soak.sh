#!/usr/bin/env bash
# The base unit on a bad wire: 5 % of the frames lost and 5 % late, the controller restarted at random. Every command must arrive
# exactly once and in order, in both directions, and every set of periodic data completely.  usage: tools/dev/soak.sh [SECONDS [SEED]]
# (default 600 seconds, seed 1; more than 60: in the last 30 s the operator sends no commands)
#
# The delay is 1 ms, because SOEM waits 2 ms. SOEM regards a later reply as the reply to another frame with the same index; at its
# start a slave can therefore get the address 0, and SOEM then reads an EEPROM that does not respond, word by word, for hours.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-600}
seed=${2:-1}
[ "$seconds" -gt 60 ] || { echo "soak.sh: more than 60 seconds, please" >&2; exit 1; }
build=${ECTWIN_BUILD:-build/release}
if [ "$build" = build/release ]; then
  tools/bootstrap.sh run
  cmake --preset release >/dev/null
  cmake --build --preset release >/dev/null
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export work seconds seed build

operator() { # UNTIL: a numbered command from remote unit 1, every 0.3 s on average; repeated if the queue is full
  n=0
  while [ $SECONDS -lt "$1" ]; do
    if "$build/ectwin" command ru1 "$(printf '6f70657261746f72%016x' $((n + 1)))" 2>>"$work/refused"; then n=$((n + 1)); fi
    sleep "0.$((RANDOM % 6 + 1))"
  done
  echo $n >"$work/operator"
}

session() {
  "$build/ectwin" set ru1.on=1
  "$build/ectwin" watch 'ru1.received' >"$work/received" &
  watch=$!
  "$build/ectwin" watch 'bu.periodic_check' >"$work/sets" &
  sets=$!
  timeout -s KILL $((seconds + 60)) "$build/ectwin-controller" "$ECTWIN_IFACE" --seconds "$seconds" --restart-every 15 --commands 1000000 --periodic 4321 \
    --seed "$seed" >"$work/controller" &
  controller=$!
  quiet=$((SECONDS + seconds - 30)) # queued commands are still sent, although the bus may restart once more
  until "$build/ectwin" set ru1.armed=1 2>/dev/null; do sleep 0.1; done # not while the unit is Initial
  operator $quiet
  wait $controller || echo "the controller ended with $?" >&2
  sleep 1
  "$build/ectwin" get 'ru1.received_count' >"$work/count"
  kill $watch $sets
}
export -f operator session

"$build/ectwin" with --drop 5 --delay 5 --delay-us 1000 --seed "$seed" vr-bu-ect-map7 -- bash -c session 2>"$work/log" || { cat "$work/log"; exit 1; }
if ! python3 tools/dev/soak_check.py "$work"; then
  tail -n 40 "$work/log"
  exit 1
fi
