#!/usr/bin/env bash
# SOEM's own slaveinfo lists sizes, mapping and the whole dictionary of each device, and asks for nothing in vain: gaps in
# the sub-indices are described as nothing.
# usage: slaveinfo.sh ECTWIN SLAVEINFO
set -u
ectwin=$1
slaveinfo=$2
failed=0
export ASAN_OPTIONS=detect_leaks=0

with() { "$ectwin" with --in-process --virtual-time "$@"; }

expect() { # DEVICE WHAT EXPECTED ACTUAL
  [ "$3" = "$4" ] && return 0
  printf 'FAILED %s: %s: expected %s, got %s\n  alone: %s with --in-process --virtual-time %s -- %s {} -sdo\n' "$1" "$2" "$3" "$4" "$ectwin" "$1" "$slaveinfo"
  failed=1
}

while read -r device input output entries name; do
  map=$(with "$device" -- "$slaveinfo" {} -map 2>/dev/null)
  sdo=$(with "$device" -- "$slaveinfo" {} -sdo 2>/dev/null)
  expect "$device" "input size" "$((input * 8))bits" "$(sed -n 's/ Input size: //p' <<<"$map")"
  expect "$device" "output size" "$((output * 8))bits" "$(sed -n 's/ Output size: //p' <<<"$map")"
  expect "$device" "state" 4 "$(sed -n 's/ State: //p' <<<"$map")"
  expect "$device" "mapped entries" "$entries" "$(grep -c '^  \[0x' <<<"$map")"
  expect "$device" "errors" 0 "$(grep -v '"' <<<"$sdo" | grep -c -i 'abort\|error\|unknown object')"
  expect "$device" "last entry is listed" yes "$(grep -q 'End slaveinfo' <<<"$sdo" && grep -q "\"$name\"" <<<"$sdo" && echo yes)"
done <<'TABLE'
vr-bu-ect-map1     66  0   37  Input data
vr-bu-ect-map3     66  24  45  Input data
vr-bu-ect-map7     66  228 73  Input data
vr-bu-ect-multiarm 142 228 121 Input data
fzm1               48  20  17  Comment 8
TABLE
exit $failed
