#!/usr/bin/env bash
# A device file: its ESI file, its EEPROM image and its twin agree, and a master brings the twin to OP.
# So does a SOES application with the source that is written.
# usage: new_device.sh ECTWIN ECTWIN-CONFORM ROOT SOES-SLAVE FILES     FILES: the folder of `ectwin new` with which the slave is built
set -u
ectwin=$1
conform=$2
root=$3
slave=$4
files=$5
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0

with() { "$ectwin" with --in-process --virtual-time "$@"; }

# shellcheck source=tests/support/check.sh
. "$root/tests/support/check.sh"

for file in examples/new/gauge.yaml examples/new/pump.yaml examples/new/rack.yaml tests/fuzz/seeds/devfile/{syncmanagers,project}; do
  device=yaml:$root/$file
  "$ectwin" esi "$device" -o "$work/d.xml" && "$ectwin" sii "$device" -o "$work/d.bin"
  check "$file: ESI, EEPROM and device agree" "0 " "$("$ectwin" verify "$work/d.xml" "$work/d.bin" "$device" 2>&1 >"$work/out"; echo $? "$(cat "$work/out")")"
  check "$file: so do ESI and twin" "0 " "$(with "$device" -- "$ectwin" verify "$work/d.xml" slave:{} 2>"$work/err" >"$work/out"; echo $? "$(cat "$work/out")")"
  with "$device" -- "$conform" -i {} --only CF-095 >"$work/out" 2>"$work/err"
  check "$file: a master brings it to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"
done

cp "$root/examples/new/gauge.yaml" "$work/gauge.yaml"
check "the file's name without its prefix is refused with the cure" \
  "ectwin sii: 'gauge.yaml' is the name of a file: write yaml:gauge.yaml for a device of it; a bus file is the only operand of run, with or check" \
  "$(cd "$work" && "$ectwin" sii gauge.yaml 2>&1)"
check "a device file in place of a bus file is refused with the cure" "gauge.yaml:1: a device, not a bus: write yaml:gauge.yaml" \
  "$(cd "$work" && "$ectwin" with gauge.yaml -- true 2>&1 | sed 's/^[^:]*: //')"
printf 'ectwin: 1\ntwins:\n  - device: yaml:gauge.yaml\n    set: {inputs.distance: 7}\n' >"$work/bus.yaml"
check "a bus file names it, relative to itself" "inputs.distance=7" \
  "$("$ectwin" with "$work/bus.yaml" -- "$ectwin" get inputs.distance 2>"$work/err")"
check "the running bus is saved with it" "yaml:gauge.yaml" \
  "$("$ectwin" with "$work/bus.yaml" -- "$ectwin" save-bus -o "$work/now.yaml" 2>"$work/err"; sed -n 's/.*device: //p' "$work/now.yaml" | tr -d "'\"")"

mkdir "$work/new"
check "new: the files" "gauge-1.bin gauge-1.hex gauge-1.html gauge-1.md gauge-1.xml soes " \
  "$(cd "$work" && "$ectwin" new gauge.yaml -o new/d >"$work/out" && ls new/d | tr '\n' ' ')"
check "new: each file is listed, and the way to run it" "$(printf '%s\n' new/d/gauge-1.{xml,bin,hex,md,html} new/d/soes Run)" \
  "$(awk '{print $1}' "$work/out")"
check "new: all agree" "0 " "$(cd "$work/new/d" && "$ectwin" verify gauge-1.xml gauge-1.bin gauge-1.hex soes/eeprom.bin yaml:../../gauge.yaml >"$work/out" 2>&1; echo $? "$(cat "$work/out")")"
check "new: without -o the folder has the device's name" gauge-1.xml "$(cd "$work" && "$ectwin" new yaml:gauge.yaml >"$work/out" && ls gauge-1 | grep xml)"
check "new: a mistake is one line with its place" "ectwin new: wrong.yaml:2: no YAML: did not find expected node content, 1" \
  "$(cd "$work" && echo '{' >wrong.yaml; "$ectwin" new wrong.yaml 2>"$work/err"; status=$?; echo "$(cat "$work/err"), $status")"
check "new: a folder that cannot be made" 2 "$(cd "$work" && "$ectwin" new gauge.yaml -o no/where >"$work/out" 2>"$work/err"; echo $?)"
printf 'mailbox: none\n' | cat "$work/gauge.yaml" - >"$work/simple.yaml"
check "new: a device without a mailbox has no source for SOES" "1 5" \
  "$(cd "$work" && "$ectwin" new simple.yaml -o simple 2>&1 >"$work/out" | grep -c 'gauge-1 does not have the SyncManagers of a SOES slave') $(ls "$work/simple" | wc -l)"
for wrong in "" "a.yaml b.yaml"; do
  # shellcheck disable=SC2086
  check "new '$wrong': wrong usage" 1 "$("$ectwin" new $wrong >"$work/out" 2>&1; echo $?)"
done

external() { timeout 300 "$ectwin" with --external "$slave --sii $files/soes/eeprom.bin" -- "$@" 2>"$work/err"; }
check "the SOES application goes to OP (CF-095)" 1 "$(external "$conform" -i {} --only CF-095 | grep -c 'pass CF-095')"
check "the SOES application has the EEPROM of the file" "0 " "$(external "$ectwin" verify "$files/gauge-1.bin" slave:{} >"$work/out"; echo $? "$(grep EEPROM "$work/out")")"
exit $failed
