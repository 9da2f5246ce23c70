#!/usr/bin/env bash
# lies: ectwin-probe, ectwin verify and ectwin clone read slaves whose CoE lies, on the virtual clock. All end in time, with a line and an
# exit code, and the file of the probe is JSON.
# usage: lies.sh ECTWIN-OF-TESTS ECTWIN ECTWIN-PROBE
set -u
tests=$1
ectwin=$2
probe=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { touch "$work/failed"; } # the cases run in processes of their own

with_slave() { # DEVICE COMMAND...
  timeout 300 "$tests" with --in-process --virtual-time "$1" -- "${@:2}"
}

read_slave() { # DEVICE EXIT LINE
  with_slave "$1" "$probe" -i {} --limit 15 --sii "$work/$1.bin" --od "$work/$1.json" 2>"$work/$1.err" >/dev/null
  check "$1: exit code of the probe" "$2" $?
  check "$1: line of the probe" "$3" "$(sed -n "s/^ectwin-probe: slave 1 on 'ecat0': //p" "$work/$1.err")"
  check "$1: JSON" "$([ "$2" = 0 ] && echo True || echo False)" \
    "$(python3 -c "import json; print(json.load(open('$work/$1.json'))['complete'])" 2>&1)"
}

verify() { # DEVICE EXIT
  with_slave "$1" "$ectwin" verify "$work/$1.bin" slave:{} >"$work/$1.out" 2>"$work/$1.err"
  check "$1: exit code of verify" "$2" $?
}

read_slave liar-upload-4g 3 "1000:00: longer than the buffer" &
read_slave liar-no-uploads 3 "no reply within 2000 ms" &
read_slave liar-no-replies 3 "no reply within 2000 ms" &
read_slave liar-other-index 3 "no mail within 2000 ms is the reply to the request" &
read_slave liar-toggle 3 "1000:00: a segment with the wrong toggle bit" &
read_slave liar-endless-list 3 "SDO information in endless fragments" &
read_slave liar-endless-mails 3 "no mail within 2000 ms is the reply to the request" &
wait
for device in liar-upload-4g liar-no-uploads liar-no-replies liar-endless-mails; do
  verify $device 2 &
done
wait

clone() { # DEVICE EXIT: what could be read is a bus that runs
  with_slave "$1" "$ectwin" clone --preop -i {} --limit 15 -o "$work/$1.clone" >"$work/$1.out" 2>"$work/$1.err"
  check "$1: exit code of the clone" "$2" $?
  check "$1: a line of the clone" 1 "$(grep -c '^ectwin clone: slave 1: dictionary, read in part: ' "$work/$1.err")"
  timeout 300 "$ectwin" check "$work/$1.clone/bus.yaml" >/dev/null 2>"$work/$1.err"
  check "$1: the clone can run" 0 $?
}
for device in liar-upload-4g liar-no-uploads liar-no-replies liar-other-index liar-toggle liar-endless-list liar-endless-mails; do
  clone $device 3 &
done
wait
[ ! -e "$work/failed" ]
