#!/usr/bin/env bash
# Slaves of one's own behind `ectwin with --external`: a SOES application by ectwin_soes_main, and one with its own loop.
# usage: external.sh ECTWIN TWIN OWN_LOOP SLAVEINFO [CASE]     SLAVEINFO: of SOEM, if installed
set -u
ectwin=$1
twin=$2
own_loop=$3
slaveinfo=$4
only=${5:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone:    external.sh ... $case_name"; }

with() { # PROGRAM CMD...: `with --external`; standard error in $work/err
  local program=$1
  shift
  timeout 300 "$ectwin" with --external "$program" -- "$@" 2>"$work/err"
}

a_master_finds_them() {
  local map
  [ -x "$slaveinfo" ] || return 0
  for program in "$twin" "$own_loop"; do
    map=$(map_of with "$program" "$slaveinfo" '{}' -map)
    check "$program: SAFEOP" 4 "$(sed -n 's/ State: //p' <<<"$map")"
    check "$program: name" "test device" "$(sed -n 's/^ Name://p' <<<"$map" | head -1)"
    check "$program: sizes" "24bits 24bits" "$(sed -n 's/ \(Output\|Input\) size: //p' <<<"$map" | xargs)"
    check "$program: identity, from its object list" "Man: 00001337 ID: 000004d2 Rev: 00000002" "$(sed -n 's/^ \(Man: .*\)$/\1/p' <<<"$map" | head -1)"
  done
}

slave_is_notified_when_twins_are_ready() {
  check "standard output is CMD's" hello "$(with "$twin" echo hello)"
  check "the ready line" '{"event":"ready","iface":"ectwin0","slaves":1}' "$(cat "$work/err")"
  check "an interface in ARG" ecat0 "$(with "$twin" echo '{}')"
  check "an interface in the environment" ecat0 "$(with "$twin" sh -c 'echo $ECTWIN_IFACE')"
}

ends_of_processes() {
  with "$twin" sh -c 'exit 7'
  check "CMD's status" 7 $?
  with "$twin" no-such-command
  check "a command that there is not" 127 $?
  with "$work/no-such-slave" sleep 30
  check "a slave that there is not" 3 $?
  with "$twin --sii $work/nothing" sleep 30
  check "a slave that cannot start" 3 $?
  check "... says why" 1 "$(grep -c "cannot open the EEPROM's content" "$work/err")"
  with "$twin $(printf '%5000s' '') --sii $work/nothing" sleep 30
  check "a long command line is run whole" "3 1" "$? $(grep -c "cannot open the EEPROM's content" "$work/err")"
  with "timeout -s KILL 1 $twin" sleep 30
  check "a slave that dies" 3 $?
  check "... is told of" 1 "$(grep -c "has ended with status 137" "$work/err")"
}

wrong_usage() {
  "$twin" >"$work/out" 2>&1
  check "no interface" "1 1" "$? $(grep -c 'the interface is missing: -i IFACE' "$work/out")"
  "$twin" --colour >"$work/out" 2>&1
  check "an option that there is not" "1 1" "$? $(grep -c '^usage: ' "$work/out")"
  "$twin" -i >"$work/out" 2>&1
  check "no value" 1 $?
  ECTWIN_SOES_IFACE=nosuch "$own_loop" >"$work/out" 2>&1
  check "an interface that there is not, from the environment" "2 1" "$? $(grep -c nosuch "$work/out")"
  "$ectwin" with fzm1 --external "$twin" -- true >"$work/out" 2>&1
  check "a device and --external" 1 $?
  "$ectwin" with --external "$twin" --iface a,b -- true >"$work/out" 2>&1
  check "two wires and --external" 1 $?
  for option in --set=a=1 '--fault=drop 5%' --drop=5 --store=x --files=x --break=CF-034 --vendor-id=1 --realtime --busy-poll --esc=et1100; do
    "$ectwin" with "$option" --external "$twin" -- true >"$work/out" 2>&1
    check "$option, which is for twins, and --external" "1 1" "$? $(grep -c 'the options of twins have no effect on it' "$work/out")"
  done
}

an_eeprom_of_ones_own() {
  head -c 2048 /dev/zero | tr '\0' '\377' >"$work/ff"
  with "$twin --sii $work/ff" sleep 30
  check "all FF, for which SOES would wait for ever" "3 1" "$? $(grep -c 'is not the content of an EEPROM' "$work/err")"
  "$ectwin" sii vr-bu-ect-map7 -o "$work/other"
  with "$own_loop --sii $work/other" true
  check "SyncManagers that are not those of ecat_options.h" "0 4" "$? $(grep -c 'ecat_options.h at' "$work/err")"
}

run_cases a_master_finds_them slave_is_notified_when_twins_are_ready ends_of_processes wrong_usage an_eeprom_of_ones_own
