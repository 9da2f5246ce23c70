#!/usr/bin/env bash
# The command's contract: names, exit codes, ready line, private network.  usage: command.sh ECTWIN [CASE]
# Runs everything inside namespaces of its own; needs no root where user namespaces are allowed.
set -u
ectwin=$1
only=${2:-}
root=$(cd "$(dirname "$0")/../.." && pwd)

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone: $0 $ectwin $case_name"; }

list_names_the_devices() {
  check "list: names in order" "vr-bu-ect-map1 vr-bu-ect-map3 vr-bu-ect-map7 vr-bu-ect-multiarm fzm1 optoncdt2300 pmctendo-dd5" \
    "$("$ectwin" list | awk '{print $1}' | xargs)"
  check "list: in/out bytes" "66/0 66/24 66/228 142/228 48/20 8/0 6/6" "$("$ectwin" list | awk '{print $2}' | xargs)"
}

list_names_the_modules() {
  local lines
  lines=$("$ectwin" list --modules "esi:$root/tests/esi/modular.xml#RACK")
  check "MDP-021 list --modules: ident, type, class, slots, name" \
    "0x00000110 IN IO slots 1*,2-4 Two inputs of 16 bits 0x00000120 OUT IO slots 1-4 An output of 32 bits" "$(echo "$lines" | xargs)"
  check "list --modules: a device without slots" "ectwin list: DI4 has no slots: it takes no modules"$'\n2' \
    "$("$ectwin" list --modules "esi:$root/tests/esi/digital.xml#DI4" 2>&1; echo $?)"
  check "list --modules: no such file" "2" "$("$ectwin" list --modules esi:/nosuch.xml >/dev/null 2>&1; echo $?)"
  check "list --modules: without a device" 1 "$("$ectwin" list --modules 2>&1 | grep -c 'ectwin list --modules esi:FILE.xml#TYPE')"
}

with_passes_status_and_interface() {
  check "with: status of the command" 42 "$("$ectwin" with vr-bu-ect-map1 -- sh -c 'exit 42' 2>/dev/null; echo $?)"
  check "with: {} and ECTWIN_IFACE" "ecat0-ecat0 ecat0" \
    "$("$ectwin" with vr-bu-ect-map1 -- sh -c 'echo {}-{} $ECTWIN_IFACE' 2>/dev/null)"
  check "with: the ready line is on standard error" '{"event":"ready","iface":"ecat0","slaves":2}' \
    "$("$ectwin" with vr-bu-ect-map1,vr-bu-ect-map3 -- true 2>&1 >/dev/null)"
  check "with: an unknown command" 127 "$("$ectwin" with vr-bu-ect-map1 -- /no/such/command 2>/dev/null; echo $?)"
  check "with: a command that is killed" 137 "$("$ectwin" with vr-bu-ect-map1 -- sh -c 'kill -KILL $$' 2>/dev/null; echo $?)"
}

# Texts that name the cure.
advice() {
  "$ectwin" with --set datta1=1 fzm1 -- true 2>"$work/err"
  check "--set: a wrong name, and the nearest one" yes "$(grep -q "no signal 'datta1'; did you mean 'data1'?" "$work/err" && echo yes)"
  "$ectwin" with --set nosuch=1 fzm1 -- true 2>"$work/err"
  check "--set: the command that lists the names works" yes \
    "$(grep -q "'ectwin list-signals DEVICE'" "$work/err" && "$ectwin" list-signals fzm1 | grep -q '^data1 ' && echo yes)"
  check "with: notes about the twin of a file; none with --quiet" "1 0" \
    "$("$ectwin" with "esi:$root/tests/esi/drives.xml#SERVO" -- true 2>&1 | grep -c 'CiA 402') $(
      "$ectwin" with "esi:$root/tests/esi/drives.xml#SERVO" --quiet -- true 2>&1 | grep -c 'CiA 402')"
  "$ectwin" sii device.xml 2>"$work/err"
  check "a file in place of a device" "1 yes" "$? $(grep -q "write esi:device.xml" "$work/err" && echo yes)"
  "$ectwin" with fzm1,fzm1 -- "$ectwin" get nosuch 2>"$work/err"
  check "get: of several slaves -n chooses one" yes "$(grep -q -- "-n chooses one of 2 slaves" "$work/err" && echo yes)"
  check "get: several patterns" "data1=0 data2=0 scene=0" "$("$ectwin" with fzm1 -- "$ectwin" get data1 'data[2]' scene 2>/dev/null | xargs)"
  check "list-signals: several patterns" "data1 scene" "$("$ectwin" list-signals fzm1 data1 scene | awk '{print $1}' | xargs)"
  python3 -c '
import os, pty, sys
status = pty.spawn([sys.argv[1], "sii", "fzm1"])
print(os.waitstatus_to_exitcode(status))' "$ectwin" >"$work/out" </dev/null
  check "sii: binary data are not written to a terminal" "1 yes" \
    "$(tail -1 "$work/out") $(grep -q 'not written to a terminal: name a file with -o FILE' "$work/out" && echo yes)"
}

# A link that is down and an address on the interface get a line each, and the twin runs.
advice_of_the_interface() {
  # shellcheck disable=SC2016
  ectwin=$ectwin work=$work unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip addr add 192.0.2.1/24 dev tw0 || exit 9
    rm -f "$work/ready"
    "$ectwin" run -i tw0 fzm1 >"$work/ready" 2>"$work/err" & pid=$!
    for _ in $(seq 1200); do [ -s "$work/ready" ] && break; sleep 0.1; done
    kill $pid; wait $pid'
  check "run: a link that is down" yes "$(grep -q "'tw0' has no link: " "$work/err" && echo yes)"
  check "run: an address" yes "$(grep -q "'tw0' has the address 192.0.2.1: " "$work/err" && echo yes)"
  check "run: it runs" yes "$(grep -q '"ready"' "$work/ready" && echo yes)"
}

what_cannot_be_opened_is_2() {
  unshare -Urn "$ectwin" run -i nosuch vr-bu-ect-map1 2>"$work/err"
  check "run: no such interface" 2 $?
  check "run: it says so" yes "$(grep -q "no network interface 'nosuch'" "$work/err" && echo yes)"
  unshare -U "$ectwin" run -i lo vr-bu-ect-map1 2>"$work/err"
  check "run: no right to open it" 2 $?
  check "run: it names the capability and the command" yes \
    "$(grep -q 'CAP_NET_RAW.*setcap' "$work/err" && echo yes)"
  "$ectwin" sii vr-bu-ect-map1 -o /no/such/dir/file 2>/dev/null
  check "sii: file that cannot be written" 2 $?
  "$ectwin" with --store /no/such/dir fzm1 -- true 2>/dev/null
  check "with: a folder for what is saved that cannot be made" 2 $?
}

# Signals set before the start have their values; saved parameters are restored at the next start.
start_values_and_memory() {
  mkdir -p "$work/store"
  check "with: --set" "node_address=3 data1=7.5" \
    "$("$ectwin" with --store "$work/store" --set node_address=3 --set data1=7.5 fzm1 -- sh -c \
      "'$ectwin' get node_address; '$ectwin' get data1; '$ectwin' set save=1" 2>/dev/null | xargs)"
  check "with: --store" "data1=7.5" "$("$ectwin" with --store "$work/store" fzm1 -- "$ectwin" get data1 2>/dev/null)"
  check "with: --set for the second twin" "1:data1=0 2:data1=7" "$("$ectwin" with --set 2:data1=7 fzm1,fzm1 -- \
    "$ectwin" get -n 0 data1 2>/dev/null | xargs)"
  check "with: --set presses a button once" "rows=1" "$("$ectwin" with --set row1=5 --set row_add=1 fzm1 -- \
    "$ectwin" get rows 2>/dev/null)"
  check "with: a store belongs to one twin" 2 "$("$ectwin" with --store "$work/store" fzm1 -- sh -c \
    "'$ectwin' with --store '$work/store' fzm1 -- true; echo \$?" 2>/dev/null)"
  check "with: --set in any order" "output_period=40 output_time=30" "$("$ectwin" with --set output_period=40 --set output_time=30 \
    fzm1 -- "$ectwin" get 'output_[pt]*' 2>/dev/null | xargs)"
}

signals_from_a_file() {
  printf 'row1,row_judgement,row_add\n1.5,0,1\n2.5,-1,1\n' >"$work/rows.csv"
  printf 'row1\n1.5\nx\n' >"$work/bad.csv"
  printf '\xef\xbb\xbfrow1, row_add\r\n1,1\r\n,1\r\n' >"$work/excel.csv"
  printf 'row1,row_add\n1\n' >"$work/short.csv"
  printf 'row1,row_add\n' >"$work/header.csv"
  check "set: --csv" "rows=2" "$("$ectwin" with fzm1 -- sh -c \
    "'$ectwin' set --csv '$work/rows.csv'; '$ectwin' get rows" 2>/dev/null)"
  check "set: --csv with a byte order mark, blanks, empty cells and CR LF" "rows=2" "$("$ectwin" with fzm1 -- sh -c \
    "'$ectwin' set --csv '$work/excel.csv'; '$ectwin' get rows" 2>/dev/null)"
  for bad in short header; do
    "$ectwin" with fzm1 -- "$ectwin" set --csv "$work/$bad.csv" 2>/dev/null
    check "set: --csv, $bad" 1 $?
  done
  "$ectwin" with fzm1 -- "$ectwin" set --csv "$work/bad.csv" 2>"$work/err"
  check "set: a value in the file is refused" 1 $?
  check "set: it names the line" yes "$(grep -q "line 3" "$work/err" && echo yes)"
  "$ectwin" with fzm1 -- "$ectwin" set --csv /no/such/file 2>/dev/null
  check "set: a file that cannot be read" 2 $?
}

every_change_is_reported() {
  check "watch: --every" "busy 1 busy 0" "$("$ectwin" with fzm1 -- bash -c "
    lines() { for i in {1..100}; do [ \$(wc -l <'$work/watch') -ge \$1 ] && break; sleep 0.1; done; }
    >'$work/watch'; '$ectwin' watch --every busy >'$work/watch' & pid=\$!
    lines 1; '$ectwin' set image_input=100 processing=100 trigger=1; lines 3; kill \$pid; wait \$pid" 2>/dev/null
    sed -n '2,$ s/.*"name":"\(.*\)","value":\(.\),"time".*/\1 \2/p' "$work/watch" | xargs)"
}

# In a namespace: run on one end that is down, end it by SIGTERM and SIGINT; the interface is down again.
run_leaves_the_interface_as_found() {
  for signal in TERM INT HUP; do
    rm -f "$work/ready"
    env --default-signal=HUP unshare -Urn sh -c '
      ip link add name tw0 type veth peer name tw1 && ip link set tw1 up || exit 9
      "$1" run -i tw0 vr-bu-ect-map7 >"$2" & pid=$!
      for _ in $(seq 1200); do [ -s "$2" ] && break; sleep 0.1; done
      ip -br link show tw0 | grep -q "UP" && echo up
      kill -'$signal' $pid; wait $pid; echo $?
      ip -br link show tw0 | grep -q "<.*UP.*>" || echo down' sh "$ectwin" "$work/ready" >"$work/out"
    check "run: SIG$signal ends it with 0, interface as before" "up 0 down" "$(xargs <"$work/out")"
    check "run: ready line on standard output" '{"event":"ready","iface":"tw0","slaves":1}' "$(cat "$work/ready")"
  done
}

one_twin_an_interface() {
  unshare -Urn sh -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw1 up || exit 9
    "$1" run -i tw0 vr-bu-ect-map7 >"$2" 2>/dev/null & pid=$!
    for _ in $(seq 1200); do [ -s "$2" ] && break; sleep 0.1; done
    "$1" run -i tw0 vr-bu-ect-map1 2>"$3"; echo $?
    ip -br link show tw0 | grep -q "<.*UP.*>" && echo up
    kill $pid; wait $pid' sh "$ectwin" "$work/ready2" "$work/err" >"$work/out"
  check "run: a second one on the interface is refused, the first goes on" "2 up" "$(xargs <"$work/out")"
  check "run: it says so" yes "$(grep -q "another program has 'tw0' open for EtherCAT" "$work/err" && echo yes)"
}

with_ends_where_SIGCHLD_was_ignored() {
  check "with: status of the command" 7 \
    "$(timeout 300 python3 -c 'import os, signal, sys
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
os.execv(sys.argv[1], [sys.argv[1], "with", "vr-bu-ect-map1", "--", "sh", "-c", "exit 7"])' "$ectwin" 2>/dev/null; echo $?)"
}

two_at_the_same_time() {
  "$ectwin" with vr-bu-ect-map7 -- sleep 1 2>/dev/null &
  local first=$!
  check "with: a second one beside it" 0 "$("$ectwin" with vr-bu-ect-map1 -- true 2>/dev/null; echo $?)"
  wait $first
  check "with: the first one is not disturbed" 0 $?
}

# One clock tick of processor time in two seconds is 0.5 %.
idle_uses_no_processor_time() {
  "$ectwin" with vr-bu-ect-map7 -- sleep 4 2>/dev/null &
  local pid=$! before after
  sleep 1
  before=$(awk '{print $14 + $15}' /proc/$pid/stat)
  sleep 2
  after=$(awk '{print $14 + $15}' /proc/$pid/stat)
  echo $((after - before)) >"$work/out"
  wait $pid
  check "idle: at most 1 % processor (2 ticks of 10 ms in 2 s)" yes "$([ "$(cat "$work/out")" -le 2 ] && echo yes)"
}

sii_writes_the_image() {
  "$ectwin" sii vr-bu-ect-map7 >"$work/a" && "$ectwin" sii vr-bu-ect-map7 -o "$work/b"
  check "sii: to standard output and to a file, the same 4096 bytes" "4096 same" \
    "$(wc -c <"$work/a") $(cmp -s "$work/a" "$work/b" && echo same)"
}

files_agree() {
  for device in $("$ectwin" list | awk '{print $1}'); do
    "$ectwin" esi "$device" -o "$work/esi.xml" && "$ectwin" sii "$device" -o "$work/bin" && "$ectwin" sii "$device" --format hex -o "$work/sii.hex"
    check "$device: description, ESI and SII say the same" 0 "$("$ectwin" verify "$device" "$work/esi.xml" "$work/sii.hex" >"$work/out" 2>&1; echo $?)"
    "$ectwin" sii "$device" --format c | grep -o '0x[0-9A-F]*,' | sed 's/0x\(..\),/\1/' | tr -d '\n' >"$work/c"
    check "$device: the array in C is the image" "$(od -An -v -tx1 "$work/bin" | tr -d ' \n' | tr a-f A-F)" "$(cat "$work/c")"
    "$ectwin" doc "$device" --html -o "$work/page.html"
    check "$device: the page of HTML is whole" "</body></html>" "$(tail -1 "$work/page.html")"
    grep -o ' id="[^"]*' "$work/page.html" | cut -d'"' -f2 | sort >"$work/ids"
    grep -o 'href="#[^"]*' "$work/page.html" | cut -d'#' -f2 | sort -u >"$work/links"
    check "$device: links of the page lead to one place each" "" "$(uniq -d "$work/ids" | cat - <(comm -13 "$work/ids" "$work/links"))"
    check "$device: contents, charts and totals are in the page" "1 1 1" \
      "$(grep -c '<nav>' "$work/page.html") $(grep -c 'id="timing"' "$work/page.html") $(grep -c 'id="totals"' "$work/page.html")"
    rm -rf "$work/soes"
    "$ectwin" objects "$device" --soes -o "$work/soes"
    check "$device: an object list and options for SOES" "1 1" \
      "$(grep -c '^const _objectlist SDOobjects' "$work/soes/slave_objectlist.c") $(grep -c 'define MBX0_sma ' "$work/soes/ecat_options.h")"
    check "$device: each object of the list for SOES ends at the position of its last entry" "" "$(awk '
      /^const _objd SDO/ {object = "0x" substr($3, 4, 4)}
      /^  \{0x/ && /SDO[0-9A-F]*\},$/ {split($0, part, /[{, ]+/); if (part[4] != rows[part[2]] - 1) print part[2]; next}
      /^  \{/ {rows[object]++}' "$work/soes/slave_objectlist.c")"
  done
  check "doc: named bits, in Markdown and HTML" "1 1" \
    "$("$ectwin" doc fzm1 | grep -c '^| 2 | READY |') $("$ectwin" doc fzm1 --html | grep -c '<td>READY</td>')"
  check "doc: states of the base unit" 1 "$("$ectwin" doc vr-bu-ect-map1 | grep -c '^| 0x10 | Disarmed |')"
  check "list-signals: entry and names of values" 1 "$("$ectwin" list-signals vr-bu-ect-map1 bu.state | grep -c '2001h:8: 0 Initial, .*17 Armed')"
  check "sii: a format that there is none" 1 "$("$ectwin" sii fzm1 --format elf >/dev/null 2>&1; echo $?)"
  "$ectwin" objects "esi:$root/tests/esi/digital.xml#DI4" --soes -o "$work" 2>"$work/err"
  check "objects: no slave for SOES, and why" "1 1" "$? $(grep -c 'di4 does not have the SyncManagers of a SOES slave' "$work/err")"
  check "objects: nobody is named" 1 "$("$ectwin" objects fzm1 >/dev/null 2>&1; echo $?)"
  for files in "objects fzm1 --soes" "esi --all"; do
    # shellcheck disable=SC2086
    "$ectwin" $files -o "$work/new-${files%% *}" && check "$files: the folder is made" yes "$([ -n "$(ls "$work/new-${files%% *}")" ] && echo yes)"
    # shellcheck disable=SC2086
    check "$files: a folder whose name is too long" "ectwin ${files%% *}: the folder's name is too long"$'\n2' \
      "$("$ectwin" $files -o "$(printf '%05000d' 0)" 2>&1; echo $?)"
  done
}

# Whoever sets another identity gets it in each file; --serial only where a file is of one unit.
identity_reaches_each_file() {
  local who="--vendor-id=0x11223344 --product-code=0x55667788 --revision=0x99aabbcc --serial=0x12345678"
  local source file
  for source in fzm1 vr-bu-ect-map3 "esi:$root/tests/esi/analog.xml#AI2"; do
    "$ectwin" sii "$source" $who -o "$work/who.bin" 2>/dev/null
    check "sii $source: identity" "44332211 88776655 ccbbaa99 78563412" "$(od -An -v -tx1 -j16 -N16 "$work/who.bin" | tr -d ' \n' | sed 's/......../& /g; s/ $//')"
    "$ectwin" esi "$source" $who -o "$work/who.xml" 2>/dev/null
    check "esi $source: identity" "#x11223344 #x55667788 #x99AABBCC #x12345678" \
      "$(xmllint --xpath 'concat(//Vendor/Id, " ", //Device/Type/@ProductCode, " ", //Device/Type/@RevisionNo, " ", //Device/Type/@SerialNo)' "$work/who.xml")"
    "$ectwin" doc "$source" $who -o "$work/who.md" 2>/dev/null
    check "doc $source: identity" "0x11223344 0x55667788 0x99AABBCC" \
      "$(sed -n 's/.*|.*\(Vendor\|Product code\|Revision\) |.*\(0x[0-9A-F]*\) |$/\2/p' "$work/who.md" | head -3 | xargs)"
    "$ectwin" objects "$source" --soes $who -o "$work" 2>/dev/null
    check "objects $source: identity" "0x11223344 0x55667788 0x99AABBCC" \
      "$(grep -o '0x11223344\|0x55667788\|0x99AABBCC' "$work/slave_objectlist.c" | head -3 | xargs)"
  done
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run_cases list_names_the_devices list_names_the_modules with_passes_status_and_interface advice advice_of_the_interface what_cannot_be_opened_is_2 start_values_and_memory signals_from_a_file every_change_is_reported \
  run_leaves_the_interface_as_found one_twin_an_interface with_ends_where_SIGCHLD_was_ignored two_at_the_same_time idle_uses_no_processor_time sii_writes_the_image files_agree identity_reaches_each_file
