#!/usr/bin/env bash
# verify: description, EEPROM image and running twin of each device agree, ours and those of ESI files; and an old image
# that is still in a chip is found (CF-054, CF-066).
# usage: verify.sh ECTWIN ECTWIN-PROBE ECTWIN-CONFORM ESI-FOLDER
set -u
ectwin=$1
probe=$2
conform=$3
esi=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0

# Nothing of the network is the subject here: twins in the process of the program that reads them, on the virtual clock.
with() { "$ectwin" with --in-process --virtual-time "$@"; }

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

for device in $("$ectwin" list | awk '{print $1}'); do
  "$ectwin" sii "$device" -o "$work/$device.bin"
  check "$device, its image and its twin" "" \
    "$(with "$device" -- "$ectwin" verify "$device" "$work/$device.bin" slave:{} 2>&1 >"$work/out" | grep verify; cat "$work/out")"
done

for one in analog.xml#AI2 analog.xml#DRIVE digital.xml#DI4 digital.xml#DO16 digital.xml#COUPLER modular.xml; do
  with "esi:$esi/$one" -- "$ectwin" verify "$esi/$one" slave:{} >"$work/out" 2>"$work/err"
  check "$one and its twin: exit code" 0 $?
  check "$one and its twin" "" "$(cat "$work/out")"
done

# A twin of nothing but the image: the same EEPROM, layout and PDOs; a master brings it to OP; options replace the items that they
# name.
for device in $("$ectwin" list | awk '{print $1}'); do
  with --behaviour none "sii:$work/$device.bin" -- "$ectwin" verify "$work/$device.bin" slave:{} >"$work/out" 2>"$work/err"
  check "the twin of $device's image: exit code" 0 $?
  check "the twin of $device's image" "" "$(cat "$work/out")"
  with "sii:$work/$device.bin" -- "$conform" -i {} --only CF-095 >"$work/out" 2>"$work/err"
  check "the twin of $device's image goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"
done
"$ectwin" sii fzm1 --alias 17 --serial 4711 --format hex -o "$work/own.hex"
"$ectwin" sii fzm1 --alias 17 --serial 4711 -o "$work/own.bin"
"$ectwin" sii "sii:$work/own.hex" -o "$work/again.bin"
check "alias and serial number of an image stay" 0 "$(cmp "$work/own.bin" "$work/again.bin" >&2; echo $?)"
"$ectwin" sii "sii:$work/own.bin" --serial 1 --alias 1 | cmp -s - "$work/own.bin"
check "options replace serial number and alias of an image" 1 $?
"$ectwin" sii "sii:$work/nothing.bin" 2>"$work/err"
check "no such image: exit code" 1 $?
check "no such image" "ectwin sii: $work/nothing.bin: No such file or directory" "$(head -1 "$work/err")"

declare -A named # a device by the type that its file names
for device in $("$ectwin" list | awk '{print $1}'); do
  named[$("$ectwin" esi "$device" | sed -n 's/.*<Type Product[^>]*>\(.*\)<\/Type>/\1/p')]=$device
done

# The files that are ours to give away, the EEPROM, and the twin.
for file in "$esi"/../../esi/*.xml; do
  [ -e "$file" ] || continue
  while IFS= read -r line; do
    type=${line%%  *}
    type=${type%% @0x*}
    device=${named[$type]}
    with "$device" -- "$ectwin" verify "$file#$type" "$work/$device.bin" "$device" slave:{} >"$work/out" 2>"$work/err"
    check "$file#$type, its image and its twin: exit code" 0 $?
    check "$file#$type, its image and its twin" "" "$(cat "$work/out")"
    with "esi:$file#$type" -- "$ectwin" verify "$device" slave:{} >"$work/out" 2>"$work/err"
    check "$device and the twin made from its ESI file: exit code" 0 $?
    check "$device and the twin made from its ESI file" "" "$(cat "$work/out")"
    with "esi:$file#$type" -- "$conform" -i {} --only CF-095 >"$work/out" 2>"$work/err"
    check "the twin made from $file#$type goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"
  done < <("$ectwin" list "esi:$file")
done

# The third of four slaves, and a chip with the image of another product.
with fzm1,fzm1,vr-bu-ect-map3,fzm1 -- "$ectwin" verify vr-bu-ect-map3 slave:{}:3 >"$work/out" 2>/dev/null
check "the third slave: exit code" 0 $?
check "the third slave" "" "$(cat "$work/out")"
with fzm1 -- "$ectwin" verify "$work/vr-bu-ect-map1.bin" slave:{} >"$work/out" 2>/dev/null
check "another product: exit code" 1 $?
check "another product: its type" \
  "slave:ecat0 EEPROM: device type: expected \"VR-BU-ECT-Map1\" ($work/vr-bu-ect-map1.bin), found \"FZM1\"" \
  "$(grep -i 'EEPROM: device type' "$work/out")"

# The probe alone, and its mistakes.
with fzm1 -- "$probe" -i {} --sii "$work/read.bin" --od "$work/read.json" 2>/dev/null >&2
check "probe: exit code" 0 $?
check "probe: the image" 0 "$(cmp "$work/read.bin" "$work/fzm1.bin" >&2; echo $?)"
check "probe: 1018h:1" 1 "$(python3 -c "import json,sys
objects = {o['index']: o for o in json.load(open('$work/read.json'))['objects']}
print(sum(e['subindex'] == 1 and e['bits'] == 32 for e in objects[0x1018]['entries']))")"
with fzm1 -- "$probe" -i {} -n 2 >/dev/null 2>"$work/err"
check "probe: no such slave: exit code" 3 $?
check "probe: no such slave" "ectwin-probe: slave 2 on 'ecat0': the segment has only 1 slave" "$(grep probe "$work/err")"
with fzm1 -- "$probe" -i {} --sii /dev/full >/dev/null 2>"$work/err"
check "probe: a full disk" "3 ectwin-probe: cannot write '/dev/full': No space left on device" "$? $(grep probe "$work/err")"
check "probe: no such interface" "ectwin-probe: there is no network interface 'nosuch': 'ip -br link' lists all interfaces 2" \
  "$("$probe" -i nosuch 2>&1 | tr '\n' ' '; echo "${PIPESTATUS[0]}")"
"$ectwin" verify slave:nowhere0 fzm1 >/dev/null 2>"$work/err"
check "no such interface: exit code" 2 $?
check "no such interface" "ectwin verify: slave:nowhere0: there is no network interface 'nowhere0': 'ip -br link' lists all interfaces" "$(grep verify "$work/err")"
"$ectwin" verify "$work/nothing.bin" fzm1 2>"$work/err"
check "no such file: exit code" 2 $?
check "no such file" "ectwin verify: $work/nothing.bin: No such file or directory" "$(cat "$work/err")"

# lint: our own files are without mistakes; a file with two, one of them of the vendor, which each device shares.
for file in "$esi"/../../esi/*.xml; do
  "$ectwin" lint --no-notes "$file" >"$work/out" 2>"$work/err"
  check "lint $file: exit code" 0 $?
  check "lint $file" "" "$(cat "$work/out" "$work/err")"
done
sed -e 's/<Id>#x00000E57/<Id>0x00000E57/' -e 's/<ByteSize>2048<\/ByteSize><ConfigData>050E0344640000/<ByteSize>2048<\/ByteSize><ConfigData>050E03/' \
  "$esi/analog.xml" >"$work/wrong.xml"
"$ectwin" lint --no-notes "$work/wrong.xml" >"$work/out" 2>"$work/err"
check "lint: mistakes: exit code" 3 $?
check "lint: each mistake once" "$(sort -u "$work/out" | wc -l)" "$(wc -l <"$work/out")"
check "lint: the number that only some tools read" 1 "$(grep -c "^$work/wrong.xml:5: .*0x" "$work/out")"
"$ectwin" lint "$work/wrong.xml#NONE" >/dev/null 2>"$work/err"
check "lint: no such device: exit code" 1 $?
"$ectwin" lint "$work/fzm1.bin" >/dev/null 2>"$work/err"
check "lint: no ESI file: exit code" 2 $?
"$ectwin" lint --schema "$work/fzm1.bin" "$esi/analog.xml" >/dev/null 2>"$work/err"
check "lint: no schema: exit code" 2 $?
"$ectwin" lint >/dev/null 2>"$work/err"
check "lint: no file: exit code" 1 $?
exit $failed
