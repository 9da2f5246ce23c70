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
  printf '%s\n' "'$ectwin' clone --preop -i \"\$1\" -o '$work/one' >'$work/said' 2>'$work/err' || exit" \
    "'$ectwin' verify '$work/one' slave:\$1 2>&1 | grep -v '^ectwin: ' >'$work/differences'; true" >"$work/first"
  printf '%s\n' "'$ectwin' clone --preop -i \"\$1\" -o '$work/two' >/dev/null 2>>'$work/err' || exit" \
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
check "alias of the last slave, and the serial number of any twin (CLN-013)" "alias=23 serial=1" "$("$ectwin" sii "esi:$(ls "$work"/one/07-*.xml)" -o "$work/sii" 2>/dev/null
  python3 -c "b=open('$work/sii','rb').read(); print(f'alias={b[8]} serial={int.from_bytes(b[28:32],\"little\")}')")"
on_virtual_time "$work/one/bus.yaml" -- "$conform" -i {} --slave 5 --only CF-095 >"$work/out" 2>&1
check "the cloned sensor goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"

clone_of --set data1=1.5 --esc lan9252 fzm1
check "the chip of the slave" "esc: lan9252" "$(grep -o 'esc: .*' "$work/one/bus.yaml")"

clone_of --wire 2:1.3 --wire 4:1.1 fzm1*4
check "the tree of the bus (CLN-014)" "wire: ['2:1.3', '4:1.1']" "$(grep wire "$work/one/bus.yaml" || echo "$(cat "$work/one/bus.yaml")")"

clone_of "esi:$esi/digital.xml#COUPLER,esi:$esi/digital.xml#DI4,esi:$esi/digital.xml#DO16,esi:$esi/analog.xml#AI2,esi:$esi/analog.xml#DRIVE,esi:$esi/modular.xml"

# A modular device: a module of the start is in EEPROM and dictionary, one inserted later in the dictionary alone.
clone_of --module 2=0x120 --set slot3.module=0x110 "esi:$esi/rack.xml"
on_virtual_time "$work/one/bus.yaml" -- "$conform" -i {} --only 'CF-M0[12]' >"$work/out" 2>&1
check "the clone of a modular device compares F030h with F050h (CF-M01, CF-M02)" 2 "$(grep -c 'pass CF-M0' "$work/out")"

rm -rf "$work/one"
on_virtual_time --fault 'eeprom nack slave 1' vr-bu-ect-map1,fzm1 -- "$ectwin" clone --preop -i {} -o "$work/one" >"$work/said" 2>"$work/err"
check "a slave whose EEPROM cannot be read: exit code" 3 $?
check "a slave whose EEPROM cannot be read: its line" 1 "$(grep -c '^ectwin clone: slave 1: EEPROM: ' "$work/err")"
check "a slave whose EEPROM cannot be read: the others are cloned" "02-fzm1.xml bus.yaml" "$(ls "$work/one" | xargs)"
check "a slave whose EEPROM cannot be read: the bus file reports it" "# Without 1 of the 2 slaves of the bus, and without its wires." \
  "$(grep Without "$work/one/bus.yaml")"
check "a slave whose EEPROM cannot be read: the bus file can be run" 0 "$("$ectwin" check "$work/one/bus.yaml" >/dev/null 2>&1; echo $?)"

on_virtual_time fzm1 -- "$ectwin" clone --preop -i {} -o "$work/one" >"$work/out" 2>"$work/err"
check "a folder that is there: exit code" 2 $?
check "a folder that is there" "ectwin clone: '$work/one': File exists: name a folder that is not there yet" "$(grep clone: "$work/err")"
# Consent, notes and blanks.
fzm1_clone() { # OPTION...: a clone of one device in INIT on the virtual clock, as $work/one, its file as $work/file
  rm -rf "$work/one"
  on_virtual_time --quiet --serial 4711 --alias 17 "${device:-fzm1}" -- "$ectwin" clone -i {} -o "$work/one" "$@" >"$work/said" 2>"$work/err"
  status=$?
  cat "$work"/one/01-*.xml >"$work/file" 2>/dev/null
}
head_of() { # LINES...: of the comment
  sed -n '3,/^-->/p' "$work/file" | sed '$d; s/^  //'
}
read_at="cloned by ectwin $("$ectwin" --version | awk '{print $2}'), read in"
fzm1_clone
check "no consent: exit code (CLN-007)" 3 $status
check "no consent: the cure (CLN-007)" \
  "ectwin clone: slave 1: without its dictionary: the slave is in INIT, without a mailbox: --preop takes it to PREOP and back" \
  "$(grep '^ectwin clone' "$work/err")"
check "no consent: what the EEPROM has (CLN-001)" "1 FZM1 @0x00F20001/0x00010000: EEPROM 2048 bytes, 0 objects, 3 PDOs" "$(cat "$work/said")"
check "no consent: the state of reading (CLN-012)" "read in INIT" "$(grep -o 'read in [A-Z]*' "$work/file")"
SOURCE_DATE_EPOCH=86400 fzm1_clone --preop
check "the comment: state, time, what is missing and what is blank (CLN-009, CLN-012, CLN-013, CLN-015)" \
  "Slave 1 on ecat0, $read_at PREOP at 1970-01-02 00:00:00 UTC.
Defaults are the values of that time, not those of the vendor.
The application of the slave is not cloned.
Blanked: serial.
2401:00: no value: access 0x0038, not readable" "$(head_of)"
check "the bus file: time and application (CLN-012, CLN-015)" "at 1970-01-02 00:00:00 UTC: values are those of that time, and the applications of the slaves are not cloned." \
  "$(head -2 "$work/one/bus.yaml" | tr -d '#' | xargs | grep -o 'at 1970.*')"
field() { # OFFSET BYTES: of the EEPROM in the file
  python3 -c "
import re, sys
image = bytes.fromhex(re.search('<Data>([0-9A-F]{256})', open('$work/file').read()).group(1))
print(int.from_bytes(image[$1:$1 + $2], 'little'))"
}
blanked() { # LIST ALIAS SERIAL NAME
  fzm1_clone --preop --blank "$1"
  check "--blank $1 (CLN-013)" "0 $2 $3 $4" "$status $(field 8 2) $(field 28 4) $(grep -o '<Type Prod.*' "$work/file" | sed 's/.*">\(.*\)<.*/\1/')"
  check "--blank $1: the bus can run (CLN-013)" 0 "$("$ectwin" check "$work/one/bus.yaml" >/dev/null 2>&1; echo $?)"
}
blanked none 17 4711 FZM1
blanked alias 0 4711 FZM1
blanked serial,names 17 0 xxxx
blanked serial,alias,names,texts 0 0 xxxx
"$ectwin" clone -i x -o y --blank serial,name 2>"$work/err"
check "--blank with another word (CLN-013)" "1 ectwin clone: --blank takes serial, alias, names, texts, separated by commas, or none, not 'serial,name'" \
  "$? $(head -1 "$work/err")"

# An EEPROM that has 2200:09 in its first PDO, and a dictionary that has 2200:01.
fzm1_clone --preop
sed 's/0022010A0720/0022090A0720/' "$work/file" >"$work/other.xml"
device=esi:$work/other.xml fzm1_clone --preop
differs="dictionary: PDO 1A00 entry 1: expected 2200:09, 32 bits (EEPROM), found 2200:01, 32 bits"
check "EEPROM and dictionary disagree: a line (CLN-016)" "ectwin clone: slave 1: EEPROM and $differs" "$(grep '^ectwin clone' "$work/err")"
check "EEPROM and dictionary disagree: the comment (CLN-016)" "$differs" "$(head_of | tail -1)"
check "EEPROM and dictionary disagree: both are kept (CLN-016)" "1 1" \
  "$(grep -c 0022090A0720 "$work/file") $(grep -c '<DefaultData>20010022</DefaultData>' "$work/file")"

# A slave without SDO information, with the ESI file that has its identity and without.
mkdir "$work/esi"
"$ectwin" esi fzm1 -o "$work/esi/fzm1.xml"
sed 's/ SdoInfo="true"//' "$work/esi/fzm1.xml" >"$work/silent.xml"
device=esi:$work/silent.xml
fzm1_clone --preop
check "without SDO information: what values name (CLN-010)" "0 8" "$status $(grep -o '[0-9]* objects' "$work/said" | cut -d' ' -f1)"
check "without SDO information: no object of its own" 0 "$(grep -c '<Index>#x2401</Index>' "$work/file")"
fzm1_clone --preop --esi-dir "$work/esi"
check "--esi-dir: its objects, with the values of the slave" "0 19 1" \
  "$status $(grep -o '[0-9]* objects' "$work/said" | cut -d' ' -f1) $(grep -c '<Index>#x2401</Index>' "$work/file")"
check "--esi-dir: a line" "ectwin clone: slave 1: no SDO information: names and objects from $work/esi/fzm1.xml#@0x00F20001/0x00010000" \
  "$(grep '^ectwin clone' "$work/err")"
check "--esi-dir: the comment" "No SDO information: names and objects are those of an ESI file." "$(head_of | sed -n 5p)"
grep -v -e '<Data>' -e '<CoE' -e 'No SDO information' "$work/file" >"$work/from_file"
device=esi:$work/esi/fzm1.xml fzm1_clone --preop
check "--esi-dir: the same as by SDO information" "" "$(grep -v -e '<Data>' -e '<CoE' "$work/file" | diff - "$work/from_file")"
# A slave that no longer replies, from an object of the ESI file alone on: gaps of the third request in a row, of a lost frame, of the limit.
while IFS='|' read -r action limit gaps unread reason; do
  rm -rf "$work/one"
  echo "at the 1st upload of 0x1C32 after 1us $action" >"$work/scenario"
  on_virtual_time --quiet --scenario "$work/scenario" "esi:$work/silent.xml" -- \
    "$ectwin" clone --preop -i {} -o "$work/one" --esi-dir "$work/esi" --limit "$limit" >"$work/said" 2>"$work/err"
  check "--esi-dir, $action: exit code, objects, entries without a value" "3 12 objects $unread without a value" \
    "$? $(sed 's/.*, \([0-9]* objects\), [0-9]* PDOs, /\1 /' "$work/said")"
  check "--esi-dir, $action: gaps" "$gaps" "$(sed -n 's/^  \(....:..\): no value: .*/\1/p' "$work"/one/01-*.xml | xargs)"
  check "--esi-dir, $action: the reason" "ectwin clone: slave 1: dictionary, read in part: $reason" "$(grep 'in part' "$work/err")"
done <<'END'
mail lost slave 1|600|1C32:01 1C32:02 1C32:04|3 entries|no reply within 2000 ms
hang slave 1|600|1C32:01 1C32:02 1C32:04|3 entries|the slave does not empty its mailbox within 2000 ms
drop|600|1C32:00|1 entry|no frame returns (0x080D)
mail late 1900ms slave 1|2|1C32:02|1 entry|not finished within 2000 ms
END
rm "$work/esi/fzm1.xml"
fzm1_clone --preop --esi-dir "$work/esi"
check "--esi-dir without the file" "0 8 ectwin clone: slave 1: no SDO information: no file has its vendor, product and revision" \
  "$status $(grep -o '[0-9]* objects' "$work/said" | cut -d' ' -f1) $(grep '^ectwin clone' "$work/err")"
unset device

# A busy machine may keep replies from the clone for so long that it gives a slave up (3): then it is made again.
# Another master, a frame each 10 ms, with a socket for all protocols: one for EtherCAT alone is refused when the interface is opened.
cat >"$work/master.py" <<'END'
import socket, sys, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
s.bind((sys.argv[1], 3))
while True:
    s.send(bytes.fromhex("ffffffffffff02000000000188a40e10070000003001020000000000").ljust(60, b"\0"))
    open(sys.argv[2], "w").close()
    time.sleep(0.01)
END
rm -rf "$work/one"
printf '%s\n' "python3 '$work/master.py' \"\$1\" '$work/sends' & master=\$!" "until [ -e '$work/sends' ] || ! kill -0 \$master; do sleep 0.01; done" \
  "'$ectwin' clone --preop -i \"\$1\" -o '$work/one' 2>'$work/err'; echo \$? \$(ls '$work/one' 2>/dev/null | wc -l) >'$work/refused'" \
  "for n in 1 2 3 4 5; do" "'$ectwin' clone --preop --beside-master -i \"\$1\" -o '$work/beside'\$n >/dev/null 2>&1" \
  "status=\$?; [ \$status = 3 ] || break" "done; echo \$status >'$work/beside'" \
  "kill \$master" >"$work/beside.sh"
"$ectwin" with fzm1 -- sh "$work/beside.sh" {} >"$work/out" 2>&1
check "a master at work: exit code, and no folder (CLN-003)" "2 0" "$(cat "$work/refused")"
check "a master at work: the cure (CLN-003)" \
  "ectwin clone: a master is active on 'ecat0', and each would fetch replies of the other: stop it first, or read with --beside-master" \
  "$(cat "$work/err")"
check "--beside-master (CLN-003)" 0 "$(cat "$work/beside")"

"$ectwin" clone -i nosuch0 -o "$work/three" 2>"$work/err"
check "no such interface: exit code" 2 $?
check "no such interface: no folder" 1 "$([ -e "$work/three" ]; echo $?)"
"$ectwin" verify "$work" slave:nosuch0 2>"$work/err"
check "a folder without a clone: exit code" 2 $?
check "a folder without a clone" "ectwin verify: '$work' has no files of 'ectwin clone'" "$(cat "$work/err")"
exit $failed
