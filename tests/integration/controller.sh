#!/usr/bin/env bash
# The example controller and the operator's side, over the wire and in real time.  usage: controller.sh ECTWIN CONTROLLER [CASE]
# A case lasts until it has its result: a machine that stops for seconds prolongs the case, and interrupts the state of the unit for
# that time.
set -u
export ectwin=$1 controller=$2
only=${3:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export work

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone: $0 $ectwin $controller $case_name"; }

until_event() { # waits for an event of the controller
  for _ in $(seq 1200); do grep -q "\"$1\"" "$work/log" 2>/dev/null && return 0; sleep 0.05; done
  return 1
}
export -f until_event

until_lines() { # COUNT PATTERN COMMAND...: waits until a command prints so many lines with a pattern
  local count=$1 pattern=$2
  shift 2
  for _ in $(seq 1200); do [ "$("$@" 2>/dev/null | grep -c "$pattern")" -lt "$count" ] || return 0; sleep 0.05; done
  return 1
}
export -f until_lines

until_gets() { # VALUES NAME...: waits until signals have these values, in lines; prints the last ones
  local wanted=$1 got
  shift
  for _ in $(seq 1200); do
    got=$("$ectwin" get "$@")
    [ "$got" = "$wanted" ] && break
    sleep 0.05
  done
  echo "$got"
}
export -f until_gets

# ECL-023, ECL-024, ECL-050, ECL-051, ECL-060, ECL-062: commands in both directions, to an unarmed remote too
commands_go_both_ways() {
  "$ectwin" with vr-bu-ect-map7 -- bash -c '
    "$ectwin" set ru1.on=1 ru2.on=1
    "$controller" "$ECTWIN_IFACE" --seconds 600 --commands 3 >"$work/log" & pid=$!
    until_event enabled
    "$ectwin" set ru1.armed=1
    "$ectwin" command ru1 000102030405060708090a0b0c0d0e0f
    "$ectwin" command ru1 ffffffffffffffffffffffffffffffff
    until_lines 2 "\"command\"" cat "$work/log"
    until_lines 2 "received_count=3" "$ectwin" get "ru?.received_count"
    kill -INT $pid; wait $pid
    "$ectwin" get "ru?.received_count" >"$work/values"' 2>/dev/null
  check "the operator's commands, in order" "000102030405060708090a0b0c0d0e0f ffffffffffffffffffffffffffffffff" \
    "$(sed -n 's/.*"command","ru":1,"data":"\([0-9a-f]*\)".*/\1/p' "$work/log" | xargs)"
  check "the controller's commands: ru1, ru2, and ru3 that is off" "3 3 0" \
    "$(sed -n 's/^ru[123].received_count=//p' "$work/values" | xargs)"
}

# ECL-028, ECL-057, ECL-066, ECL-068: the messages and states, from nothing to armed and back
the_display_follows_the_controller() {
  "$ectwin" with vr-bu-ect-map7 -- bash -c '
    show() { # STATE ES_LINK MESSAGE
      until_gets "bu.state=$1
bu.es_link=$2
bu.message=$3" bu.state bu.es_link bu.message | paste -sd " "
    }
    "$ectwin" set ru1.on=1
    show 0 0 "EC: No Data" >"$work/values"
    "$controller" "$ECTWIN_IFACE" --seconds 600 >"$work/log" & pid=$!
    show 16 1 "" >>"$work/values"
    "$ectwin" set ru1.armed=1
    show 17 1 "" >>"$work/values"
    "$ectwin" set ru1.stop=1
    show 1 0 "" >>"$work/values"
    kill -INT $pid; wait $pid
    show 2 0 "EC: No Data" >>"$work/values"' 2>/dev/null
  check "state, ES-Link and message: before, enabled, armed, stopped, without the controller" "bu.state=0 bu.es_link=0 bu.message=EC: No Data
bu.state=16 bu.es_link=1 bu.message=
bu.state=17 bu.es_link=1 bu.message=
bu.state=1 bu.es_link=0 bu.message=
bu.state=2 bu.es_link=0 bu.message=EC: No Data" "$(cat "$work/values")"
}

# ECL-002, ECL-022: no slave replies: safe state after 500 ms without PCI, which ends with the next reply
the_controller_is_safe_without_a_unit() {
  printf '%s\n' 'at 2s set bu.enabled=0' 'at 4s set bu.enabled=1' >"$work/script"
  "$ectwin" with --in-process --virtual-time --scenario "$work/script" vr-bu-ect-map7 -- "$controller" '{}' --seconds 6 >"$work/log" 2>/dev/null
  check "safe at first, enabled, safe without the unit, enabled again" "safe enabled safe enabled" \
    "$(grep -o 'safe\|enabled' "$work/log" | xargs)"
}

# A unit that refuses OP: AL status and code are named. A watchdog between SAFEOP and OP, as by a late frame: OP is requested again
the_way_to_op() {
  check "exit code of a refusal" 3 "$("$ectwin" with --in-process --virtual-time --fault 'al refuse 0x001D slave 1 to OP' vr-bu-ect-map7 -- \
    "$controller" '{}' --seconds 5 >/dev/null 2>"$work/err"; echo $?)"
  check "its reason" "the base unit did not reach OP on 'ecat0': AL status 0x14, code 0x001d (Invalid output configuration)" \
    "$(grep 'did not reach OP' "$work/err")"
  printf '%s\n' 'al refuse 0x001B slave 1 to OP' 'at 1s off' 'expect ecat.state=8 within 1500ms' >"$work/script"
  check "a watchdog that is over" 0 "$("$ectwin" with --in-process --virtual-time --scenario "$work/script" vr-bu-ect-map7 -- \
    "$controller" '{}' --seconds 3 >/dev/null 2>"$work/err"; echo $?)"
}

stop_between_commands() { # PID: stops the controller when it has stored the counters of all commands that it has executed
  for _ in $(seq 1200); do
    kill -STOP "$1"
    [ "$(grep -c "\"command\"" "$work/log")" = "$(awk '{ print $2 }' "$work/counters")" ] && return 0
    kill -CONT "$1"
    sleep 0.05
  done
  return 1
}
export -f stop_between_commands

# ECL-023, ECL-050: the controller ends and restarts with its counters: no command is lost or repeated
killed_and_back() {
  "$ectwin" with vr-bu-ect-map7 -- bash -c '
    "$ectwin" set ru1.on=1
    : >"$work/log"
    for n in 1 2 3 4 5 6; do
      "$controller" "$ECTWIN_IFACE" --seconds 600 --counters "$work/counters" >>"$work/log" & pid=$!
      for _ in $(seq 1200); do [ "$(grep -c enabled "$work/log")" -ge $n ] && break; sleep 0.05; done
      "$ectwin" command ru1 "$(printf "%032x" $((2 * n - 1)))"
      "$ectwin" command ru1 "$(printf "%032x" $((2 * n)))"
      sleep "0.$((n * 7 % 4))"
      stop_between_commands $pid
      kill -KILL $pid; wait $pid
    done
    "$controller" "$ECTWIN_IFACE" --seconds 600 --counters "$work/counters" >>"$work/log" & pid=$!
    until_lines 12 "\"command\"" cat "$work/log"
    sleep 0.5
    kill -INT $pid; wait $pid' 2>/dev/null
  check "each command once and in order" "$(seq 12 | xargs)" "$(sed -n 's/.*"command","ru":1,"data":"\([0-9a-f]*\)".*/\1/p' "$work/log" |
    while read -r data; do echo $((16#$data)); done | xargs)"
}

# A watch reports every signal of a chain of any length
all_signals_are_reported() {
  map7=vr-bu-ect-map7
  "$ectwin" with $map7,$map7,$map7,$map7 -- bash -c '
    for n in $(seq 20); do "$ectwin" get -n 0 | wc -l; "$ectwin" list-signals -n 0 | wc -l; done | sort -u >"$work/values"' 2>/dev/null
  check "lines of get and list-signals, 20 times" "$((4 * $("$ectwin" with $map7 -- "$ectwin" get 2>/dev/null | wc -l)))" "$(xargs <"$work/values")"
}

# ECL-054, ECL-059: periodic data of 4321 bytes, in 22 blocks at the pace of PAI; 'ectwin periodic' reads them
sets_arrive_complete() {
  "$ectwin" with vr-bu-ect-map7 -- bash -c '
    "$controller" "$ECTWIN_IFACE" --seconds 600 --periodic 4321 >"$work/log" & pid=$!
    until_lines 1 "size=4321" "$ectwin" get "bu.periodic_size"
    kill -INT $pid; wait $pid
    "$ectwin" periodic -o "$work/set"
    "$ectwin" periodic | head -n 2 >"$work/dump"
    "$ectwin" get "bu.periodic_*" >"$work/values"' 2>/dev/null
  check "its size and CRC-32, and no errors" "$(python3 -c '
import zlib
print("4321", zlib.crc32(bytes(i * 7 & 255 for i in range(4321))), "0")')" \
    "$(for name in size check errors; do sed -n "s/^bu.periodic_$name=//p" "$work/values"; done | xargs)"
  check "its bytes" yes "$(python3 -c '
import sys
print("yes" if open(sys.argv[1], "rb").read() == bytes(i * 7 & 255 for i in range(4321)) else "no")' "$work/set")"
  check "the same to read" "00000 00 07 0e 15 1c 23 2a 31 38 3f 46 4d 54 5b 62 69 .....#*18?FMT[bi" "$(head -n 1 "$work/dump" | tr -s ' ')"
}

# A device without periodic data has none to read
no_set_to_read() {
  "$ectwin" with vr-bu-ect-map3 -- bash -c '"$ectwin" periodic 2>"$work/err"; echo $? >"$work/status"' 2>/dev/null
  check "exit code" 1 "$(cat "$work/status")"
  check "why" yes "$(grep -q "no data" "$work/err" && echo yes)"
  "$ectwin" with vr-bu-ect-map7 -- bash -c '"$ectwin" periodic -o "$work/set" 2>"$work/err"; echo $? >"$work/status"' 2>/dev/null
  check "exit code before the first set" 0 "$(cat "$work/status")"
  check "why it is empty" yes "$(grep -q "no set has come" "$work/err" && [ ! -s "$work/set" ] && echo yes)"
}

# Values out of range are refused with the range; the socket is its user's alone
values_are_checked() {
  "$ectwin" with vr-bu-ect-map1 -- bash -c '
    "$ectwin" set ru1.joystick1=1001 2>"$work/err"; echo $? >"$work/status"
    stat -c %a "$ECTWIN_SOCKET" >"$work/mode"' 2>/dev/null
  check "exit code" 1 "$(cat "$work/status")"
  check "the range is named" yes "$(grep -q -- '-1000.*1000' "$work/err" && echo yes)"
  check "mode of the socket" 600 "$(cat "$work/mode")"
}

run_cases all_signals_are_reported the_controller_is_safe_without_a_unit the_way_to_op killed_and_back commands_go_both_ways the_display_follows_the_controller sets_arrive_complete no_set_to_read values_are_checked
