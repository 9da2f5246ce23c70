#!/usr/bin/env bash
# A slave with a network address, a board or a program: it accepts an address, and replies to ARP and ping in frames of each length
# over EoE.
# usage: eoe_answers.sh CONFORM IFACE [OPTION...]
set -u
# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
pings=1
[[ " ${*:3} " != *" --skip CF-E09 "* ]] || pings=0
report=$("$1" -i "$2" "${@:3}" --only 'CF-085,CF-E01,CF-E02,CF-E05,CF-E06,CF-E09,CF-E11' 2>&1)
check "exit status" 0 $?
on_failure() { printf '%s\n' "$report"; }
check "all cases are judged" "$((6 + pings)) pass, 0 warn, 0 fail, 0 skip" "$(sed -n 's/^\([67]\) of \1 cases in [0-9.]* s: //p' <<<"$report")"
check "EOE-020 frames of each length return" 1 "$(grep -c 'lengths, there and back' <<<"$report")"
check "pings of 1472 bytes return, unless left out" $pings "$(grep -c '^ *70 pings of 1472 bytes' <<<"$report")"
exit $failed
