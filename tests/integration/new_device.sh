#!/usr/bin/env bash
# A device file: its ESI file, its EEPROM image and its twin agree, and a master brings the twin to OP.
# usage: new_device.sh ECTWIN ECTWIN-CONFORM ROOT
set -u
ectwin=$1
conform=$2
root=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0

with() { "$ectwin" with --in-process --virtual-time "$@"; }

# shellcheck source=tests/support/check.sh
. "$root/tests/support/check.sh"

for file in examples/new/gauge.yaml tests/fuzz/seeds/devfile/syncmanagers; do
  device=yaml:$root/$file
  "$ectwin" esi "$device" -o "$work/d.xml" && "$ectwin" sii "$device" -o "$work/d.bin"
  check "$file: ESI, EEPROM and device agree" "0 " "$("$ectwin" verify "$work/d.xml" "$work/d.bin" "$device" 2>&1 >"$work/out"; echo $? "$(cat "$work/out")")"
  check "$file: so do ESI and twin" "0 " "$(with "$device" -- "$ectwin" verify "$work/d.xml" slave:{} 2>"$work/err" >"$work/out"; echo $? "$(cat "$work/out")")"
  with "$device" -- "$conform" -i {} --only CF-095 >"$work/out" 2>"$work/err"
  check "$file: a master brings it to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"
done

cp "$root/examples/new/gauge.yaml" "$work/gauge.yaml"
check "the file's name without its prefix is refused with the cure" \
  "ectwin sii: 'gauge.yaml' is the name of a file: write yaml:gauge.yaml for a device of it" \
  "$(cd "$work" && "$ectwin" sii gauge.yaml 2>&1)"
check "a device file in place of a bus file is refused with the cure" "gauge.yaml:1: a device, not a bus: write yaml:gauge.yaml" \
  "$(cd "$work" && "$ectwin" with gauge.yaml -- true 2>&1 | sed 's/^[^:]*: //')"
printf 'ectwin: 1\ntwins:\n  - device: yaml:gauge.yaml\n    set: {inputs.distance: 7}\n' >"$work/bus.yaml"
check "a bus file names it, relative to itself" "inputs.distance=7" \
  "$("$ectwin" with "$work/bus.yaml" -- "$ectwin" get inputs.distance 2>"$work/err")"
check "the running bus is saved with it" "yaml:gauge.yaml" \
  "$("$ectwin" with "$work/bus.yaml" -- "$ectwin" save-bus -o "$work/now.yaml" 2>"$work/err"; sed -n 's/.*device: //p' "$work/now.yaml" | tr -d "'\"")"
exit $failed
