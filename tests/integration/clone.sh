#!/usr/bin/env bash
# Clones of a bus: every slave becomes a file, the files become the same bus again, and a clone of that is the same, byte by byte.
# usage: clone.sh ECTWIN ECTWIN-CONFORM ESI-FOLDER
set -u
ectwin=$1
conform=$2
esi=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

on_virtual_time() { # BUS... -- COMMAND...: each command finds the bus as after power-on
  "$ectwin" with --in-process --virtual-time "$@"
}

# clone_of BUS...: clones the bus to $work/one, its clone to $work/two, and verifies the first one against both buses.
clone_of() {
  rm -rf "$work/one" "$work/two"
  printf '%s\n' "'$ectwin' clone -i \"\$1\" -o '$work/one' >'$work/said' 2>'$work/err' || exit" \
    "'$ectwin' verify '$work/one' slave:\$1 2>&1 | grep -v '^ectwin: ' >'$work/differences'; true" >"$work/first"
  printf '%s\n' "'$ectwin' clone -i \"\$1\" -o '$work/two' >/dev/null 2>>'$work/err' || exit" \
    "'$ectwin' verify '$work/one' slave:\$1 2>&1 | grep -v '^ectwin: ' >>'$work/differences'; true" >"$work/second"
  on_virtual_time "$@" -- sh "$work/first" {} >"$work/out" 2>&1
  check "$*: clone: exit code" 0 $?
  on_virtual_time "$work/one/bus.yaml" -- sh "$work/second" {} >"$work/out" 2>&1
  check "$*: clone of the clone: exit code" 0 $?
  check "$*: the clone and both buses (CLN-015)" "" "$(cat "$work/differences")"
  check "$*: clone and clone of the clone (CLN-015)" "" "$(diff -r "$work/one" "$work/two")"
}

devices=$("$ectwin" list | awk '{print $1}' | paste -sd,)
clone_of --serial 4711 --alias 17 "$devices"
check "a line a slave" 7 "$(wc -l <"$work/said")"
check "alias and serial number of the last slave" "alias=23 serial=4717" "$("$ectwin" sii "esi:$(ls "$work"/one/07-*.xml)" -o "$work/sii" 2>/dev/null
  python3 -c "b=open('$work/sii','rb').read(); print(f'alias={b[8]} serial={int.from_bytes(b[28:32],\"little\")}')")"
"$ectwin" with "$work/one/bus.yaml" -- "$conform" -i {} --slave 5 --only CF-095 >"$work/out" 2>&1
check "the cloned sensor goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"

clone_of --set data1=1.5 --esc lan9252 fzm1
check "the chip of the slave" "esc: lan9252" "$(grep -o 'esc: .*' "$work/one/bus.yaml")"

clone_of --wire 2:1.3 --wire 4:1.1 fzm1*4
check "the tree of the bus (CLN-014)" "wire: ['2:1.3', '4:1.1']" "$(grep wire "$work/one/bus.yaml" || echo "$(cat "$work/one/bus.yaml")")"

clone_of "esi:$esi/digital.xml#COUPLER,esi:$esi/digital.xml#DI4,esi:$esi/digital.xml#DO16,esi:$esi/analog.xml#AI2,esi:$esi/analog.xml#DRIVE,esi:$esi/modular.xml"

rm -rf "$work/one"
"$ectwin" with --fault 'eeprom nack slave 1' vr-bu-ect-map1,fzm1 -- "$ectwin" clone -i {} -o "$work/one" >"$work/said" 2>"$work/err"
check "a slave whose EEPROM cannot be read: exit code" 3 $?
check "a slave whose EEPROM cannot be read: its line" 1 "$(grep -c '^ectwin clone: slave 1: EEPROM: ' "$work/err")"
check "a slave whose EEPROM cannot be read: the others are cloned" "02-fzm1.xml bus.yaml" "$(ls "$work/one" | xargs)"
check "a slave whose EEPROM cannot be read: the bus file reports it" "# Without 1 of the 2 slaves of the bus, and without its wires." \
  "$(grep Without "$work/one/bus.yaml")"
check "a slave whose EEPROM cannot be read: the bus file can be run" 0 "$("$ectwin" check "$work/one/bus.yaml" >/dev/null 2>&1; echo $?)"

"$ectwin" with fzm1 -- "$ectwin" clone -i {} -o "$work/one" >"$work/out" 2>"$work/err"
check "a folder that is there: exit code" 2 $?
check "a folder that is there" "ectwin clone: '$work/one': File exists: name a folder that is not there yet" "$(grep clone: "$work/err")"
"$ectwin" clone -i nosuch0 -o "$work/three" 2>"$work/err"
check "no such interface: exit code" 2 $?
check "no such interface: no folder" 1 "$([ -e "$work/three" ]; echo $?)"
"$ectwin" verify "$work" slave:nosuch0 2>"$work/err"
check "a folder without a clone: exit code" 2 $?
check "a folder without a clone" "ectwin verify: '$work' has no files of 'ectwin clone'" "$(cat "$work/err")"
exit $failed
