#!/usr/bin/env bash
# examples/fuzz-master without libFuzzer: a project against an installed ectwin, each seed, replays.
# usage: fuzz_master.sh BUILD    77: the sources of SOEM are not there
set -eu
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
sources=$HOME/.cache/ectwin/soem-1.4.0-source
[ -e "$sources/soem/ethercatmain.c" ] || { echo "no sources of SOEM in $sources: tools/bootstrap.sh test fetches them"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log"; echo "FAILED $*"; exit 1; }; }

quietly cmake --install "$build" --prefix "$work/prefix"
cp -r "$root/examples/fuzz-master" "$work/source" # nothing beside it
quietly cmake -G Ninja -S "$work/source" -B "$work/fuzz" -DCMAKE_PREFIX_PATH="$work/prefix" -DFUZZ_MAIN=ON
quietly cmake --build "$work/fuzz"
master=$work/fuzz/fuzz-master
export ASAN_OPTIONS=detect_leaks=0

for seed in "$root"/examples/fuzz-master/seeds/*; do
  quietly "$master" "$seed"
done
# An error of AddressSanitizer, or a loop, which SIGVTALRM ends after 0.4 s of a processor: each seed ends in a twentieth of the time.
bounded='import os, signal, sys; signal.setitimer(signal.ITIMER_VIRTUAL, 0.4); os.execv(sys.argv[1], sys.argv[1:])'
for input in "$root"/examples/fuzz-master/found/*; do
  ended=$(python3 -S -c "$bounded" "$master" "$input" >"$work/log" 2>&1; echo $?)
  check "$(basename "$input") ends SOEM 1.4" yes "$([ "$ended" -ge 128 ] || grep -q 'ERROR: AddressSanitizer' "$work/log" && echo yes)"
done
replay() { FUZZ_MASTER_VERBOSE=1 "$master" "$1" 2>&1; }
check "a start without changes" "1 slaves" "$(replay "$root/examples/fuzz-master/seeds/start" | sed 's/^[0-9]* frames, //')"
check "a record changes a mail" yes "$(replay "$root/examples/fuzz-master/seeds/mail_size" | grep -q '^frame .*, mail 1: mail option 2' && echo yes)"
check "two replays are equal" "$(replay "$root/examples/fuzz-master/seeds/state" | md5sum)" "$(replay "$root/examples/fuzz-master/seeds/state" | md5sum)"
check "standard input is an input too" "1 slaves" "$(FUZZ_MASTER_VERBOSE=1 "$master" <"$root/examples/fuzz-master/seeds/start" 2>&1 | sed 's/^[0-9]* frames, //')"
check "a file that is not there" 1 "$("$master" "$work/none" 2>/dev/null; echo $?)"
exit $failed
