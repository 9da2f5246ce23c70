#!/usr/bin/env bash
# Network files (ENI) through the command: the bus that a master expects, with ESI files and without, in a bus file, mistakes.
# usage: eni.sh ECTWIN ECTWIN-CONFORM ENI-FOLDER
set -u
ectwin=$(realpath "$1")
conform=$2
eni=$(realpath "$3")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

alone="from the ENI alone, without a dictionary of its own"
"$ectwin" check "eni:$eni/machine.xml" >"$work/out" 2>"$work/err"
check "ENI-008, ENI-009: a line for each slave, in order; the hot-connect group is plugged in" \
  "ectwin: slave 1, Rack 1 (IO8): $alone
ectwin: slave 2, Drive 2 (AX1): $alone
ectwin: slave 3, Tool 3 (IO8): $alone; hot-connect group Tool, plugged in" "$(grep '^ectwin: slave' "$work/err")"
check "the bus can run" "3 twins: eni:$eni/machine.xml" "$(cat "$work/out")"
check "--quiet: no notes" "" "$("$ectwin" check --quiet "eni:$eni/machine.xml" 2>&1 >/dev/null)"
sed 's|<AutoIncAddr>65535<|<AutoIncAddr>65533<|' "$eni/machine.xml" >"$work/order.xml"
check "ENI-008: another place in AutoIncAddr" "its AutoIncAddr is 65533; its place in the file requires 2" \
  "$("$ectwin" check "eni:$work/order.xml" 2>&1 | grep -o 'its AutoIncAddr.*')"

sed '0,\|</Mailbox>|s||<EoE><InitCmd><Transition>IP</Transition></InitCmd></EoE><SoE><InitCmds><InitCmd/><InitCmd/></InitCmds></SoE></Mailbox>|' \
  "$eni/machine.xml" >"$work/protocols.xml"
check "ENI-025: commands of other protocols are counted at the start" "its 3 start-up commands of FoE, or without a mail, have no effect on the twin" \
  "$("$ectwin" check "eni:$work/protocols.xml" 2>&1 | grep -o 'its 3 .*')"
check "ENI-025: commands of other protocols are counted by verify, and are no difference" \
  "0 slave 2, Drive 2 (AX1): 3 start-up commands of FoE, or without a mail, are not sent" \
  "$("$ectwin" verify "eni:$work/protocols.xml" >"$work/out" 2>"$work/err"; echo "$? $(grep -o 'slave 2.*' "$work/err")")"

sed 's|02f30000 00000010|02f30000 00000020|' "$eni/mails.xml" >"$work/mails.xml"
check "ENI-025: mails of AoE and EoE are sent by verify" "0 19: slave 1, AoE: ADS error 0x0703" \
  "$("$ectwin" verify "eni:$eni/mails.xml" >"$work/out" 2>"$work/err"; echo "$? $("$ectwin" verify "eni:$work/mails.xml" 2>"$work/err" | grep -o '[0-9]*: slave 1, AoE.*')")"

sed 's|<Data>0b00<|<Data>0b0000<|' "$eni/soe.xml" >"$work/soe.xml"
check "ENI-025: commands of SoE are sent by verify" "0 17: slave 1, SoE drive 1, S-0-0032: SoE error 0x7003" \
  "$("$ectwin" verify "eni:$eni/soe.xml" >"$work/out" 2>"$work/err"; echo "$? $("$ectwin" verify "eni:$work/soe.xml" 2>"$work/err" | grep -o '[0-9]*: slave 1, SoE.*')")"

for name in mails soe; do
  "$ectwin" eni --quiet "eni:$eni/$name.xml" -o "$work/first.xml"
  "$ectwin" eni --quiet "eni:$work/first.xml" -o "$work/again.xml"
  mails_of() { # FILE: its start-up commands of AoE, EoE and SoE
    python3 - "$1" <<'END'
import sys, xml.etree.ElementTree as tree
for box in tree.parse(sys.argv[1]).iter("Mailbox"):
    for name in "AoE", "EoE", "SoE":
        for command in box.findall(f"{name}/InitCmds/InitCmd"):
            print(name, *(f"{part.tag}={''.join((part.text or '').split()).lower()}" for part in command if part.tag not in ("Timeout", "Attribute")))
END
  }
  check "ENI-025: ectwin eni of $name.xml: its start-up commands come back" "$(mails_of "$eni/$name.xml")" "$(mails_of "$work/first.xml")"
  check "ENI-025: ectwin eni of $name.xml: again the same" "$(mails_of "$work/first.xml")" "$(mails_of "$work/again.xml")"
  check "ENI-025: ectwin eni of $name.xml: verify" "0 " "$("$ectwin" verify "eni:$work/first.xml" 2>&1; echo "$? ")"
done

# Devices in place of ESI files.
"$ectwin" eni --quiet fzm1,vr-bu-ect-map3 -o "$work/own.xml"
check "ENI-015: verify with devices: no difference" "0 " "$("$ectwin" verify "eni:$work/own.xml" fzm1 vr-bu-ect-map3 2>&1 >"$work/out"; echo "$? $(cat "$work/out")")"
"$ectwin" verify "eni:$work/own.xml" vr-bu-ect-map3 >"$work/out" 2>"$work/err"
check "ENI-015: verify with one of two devices: the other one is missing" "1 1" "$? $(grep -c 'slave 1,.*no ESI file' "$work/out")"
"$ectwin" verify "eni:$work/own.xml" yaml:missing.yaml >"$work/out" 2>"$work/err"
check "ENI-015: verify with a device that cannot be read" "2 1" "$? $(grep -c 'missing.yaml' "$work/err")"

mkdir "$work/esi"
"$ectwin" esi --quiet "eni:$eni/machine.xml#1" -o "$work/esi/io.XML"
echo nonsense >"$work/esi/broken.xml"
"$ectwin" check --esi-dir "$work/esi" "eni:$eni/machine.xml" >"$work/out" 2>"$work/err"
check "ENI-009: --esi-dir: vendor, product and revision pick the ESI" \
  "slave 1, Rack 1 (IO8): $work/esi/io.XML#@0x00000108/0x00010000
slave 2, Drive 2 (AX1): $alone
slave 3, Tool 3 (IO8): $work/esi/io.XML#@0x00000108/0x00010000; hot-connect group Tool, plugged in" \
  "$(grep -o 'slave [123],.*' "$work/err")"
for element in VendorId:E57:E58 ProductCode:108:109 RevisionNo:10000:10001; do
  IFS=: read -r name old new <<<"$element"
  sed "s|\(<$name>#x0*\)$old<|\1$new<|" "$eni/machine.xml" >"$work/other.xml"
  check "ENI-009: another $name: not this ESI" "slave 1, Rack 1 (IO8): $alone" \
    "$("$ectwin" check --esi-dir "$work/esi" "eni:$work/other.xml" 2>&1 | grep -o 'slave 1,.*')"
done

# A clone reads a bus, and finds the same as a master.
"$ectwin" with --quiet --in-process --virtual-time "eni:$eni/machine.xml" -- "$ectwin" clone --preop -i {} -o "$work/clone" >"$work/out" 2>"$work/err"
check "ENI-009: identities in the order of the file" "@0x00000108/0x00010000 @0x000002A1/0x00000003 @0x00000108/0x00010000" \
  "$(grep -o '@0x[^:]*' "$work/out" | xargs)"
check "ENI-010: the place in the tree" "3:1.2" "$(grep -o '[0-9]:[0-9]\.[0-9]' "$work/clone/bus.yaml" | xargs)"
image() { # N OFFSET BYTES   a number of the EEPROM of slave N
  "$ectwin" with --quiet --in-process --virtual-time "${@:4}" "eni:$eni/machine.xml" -- \
    "$(dirname "$ectwin")/ectwin-probe" -i {} -n "$1" --sii "$work/sii" >/dev/null 2>>"$work/err"
  od -An -t "u$3" -j "$2" -N "$3" "$work/sii" | tr -d ' '
}
check "ENI-009: the serial number" 7 "$(image 2 28 4)"
check "ENI-021: the identification is the alias" 17 "$(image 3 8 2)"
check "an option of the command line replaces the value of the file" 9 "$(image 2 28 4 --serial 2:9)"
"$ectwin" with --quiet --in-process --virtual-time "eni:$eni/machine.xml" -- "$conform" -i {} --slave 2 --only CF-095 >"$work/out" 2>>"$work/err"
check "a twin of the ENI alone goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"

cp "$eni/machine.xml" "$work"
printf 'ectwin: 1\ntwins:\n- device: fzm1\n- device: eni:machine.xml\n' >"$work/bus.yaml"
check "in a bus file, relative to it, behind other twins" "4 twins: fzm1,eni:$work/machine.xml" \
  "$(cd / && "$ectwin" check --quiet "$work/bus.yaml" 2>&1)"
check "behind other twins the tree moves along" "4:2.2" "$("$ectwin" with --quiet --in-process --virtual-time "$work/bus.yaml" -- \
  "$ectwin" clone --preop -i {} -o "$work/clone2" >/dev/null 2>&1; grep -o '[0-9]:[0-9]\.[0-9]' "$work/clone2/bus.yaml" | xargs)"

# In the other direction: a written file is the same bus, and its verification with the ESI files of its devices finds nothing.
"$ectwin" eni --serial 1:5 --alias 2:17 --wire 3:1.2 fzm1*2,vr-bu-ect-map7 -o "$work/own.xml"
"$ectwin" check "eni:$work/own.xml" >"$work/out" 2>"$work/err"
check "ectwin eni: read back, the same slaves" "1, Slave 1 (FZM1): 2, Slave 2 (FZM1): 3, Slave 3 (VR-BU-ECT-Map7):" \
  "$(grep -o 'slave [123],.*: from' "$work/err" | sed 's/^slave //; s/ from$//' | xargs)"
"$ectwin" eni --quiet "eni:$work/own.xml" | grep -v -e '<Name>' -e '<Comment>' >"$work/second"
"$ectwin" eni --quiet "eni:$work/own.xml" --esi-dir "$work" | grep -v -e '<Name>' -e '<Comment>' >"$work/third"
check "CF-N01: identity, place and layout come back" \
  "$(grep -A12 '<Info>' "$work/own.xml" | grep -e Physics -e Vendor -e Product -e Revision -e Serial -e PhysAddr -e Identification | xargs)" \
  "$(grep -A12 '<Info>' "$work/second" | grep -e Physics -e Vendor -e Product -e Revision -e Serial -e PhysAddr -e Identification | xargs)"
check "CF-N01: ports come back" "$(grep -e '<Port>' "$work/own.xml" | xargs)" "$(grep -e '<Port>' "$work/second" | xargs)"
check "the same bus gives the same bytes" "$(cat "$work/second")" "$(cat "$work/third")"
check "--cycle" "<CycleTime>250</CycleTime>" "$("$ectwin" eni --cycle 250 fzm1 | grep -o '<CycleTime>.*')"

"$ectwin" eni --quiet "eni:$eni/machine.xml" -o "$work/again.xml"
check "ENI-021: the group of a network file" "<GroupName>Tool</GroupName>" "$(grep -o '<GroupName>.*' "$work/again.xml")"
"$ectwin" eni --quiet --dc --alias 2:17 --hot-connect '2:Tool*2' fzm1*3 -o "$work/groups.xml"
check "ENI-019, ENI-021: --dc and --hot-connect" "3 <GroupName>Tool</GroupName> <GroupMemberCnt>2</GroupMemberCnt>" \
  "$(grep -c '<DC>' "$work/groups.xml") $(grep -o '<Group.*' "$work/groups.xml" | xargs)"
check "ENI-020: mailbox states" "3 150994944 3" "$(grep -c StatusBitAddr "$work/groups.xml") $(grep -A2 '<MailboxStates>' "$work/groups.xml" | grep -oE '[0-9]+' | xargs)"
no_group() { # TITLE LINE ARGUMENT...
  "$ectwin" eni "${@:3}" >"$work/out" 2>"$work/err"
  check "$1" "1 ectwin eni: --hot-connect $2" "$? $(head -1 "$work/err")"
}
no_group "--hot-connect without an alias" "Tool: twin 2 has no alias, by which a master finds it: --alias 2:7" --hot-connect 2:Tool 'fzm1*2'
no_group "--hot-connect beyond the chain" "Tool: the chain has 2 twins" --alias 5 --hot-connect '2:Tool*2' 'fzm1*2'
no_group "--hot-connect beyond a chain of one" "Tool: the chain has 1 twin" --alias 5 --hot-connect 2:Tool fzm1
no_group "--hot-connect without a name" "takes the number of a twin and a name, as 2:Tool or 2:Tool*3, not '2'" --hot-connect 2 'fzm1*2'

verified() { # TITLE CODE LINES ARGUMENT...
  "$ectwin" verify "${@:4}" >"$work/out" 2>"$work/err"
  check "$1" "$2 $3" "$? $(cat "$work/out" "$work/err")"
}
"$ectwin" esi fzm1 -o "$work/fzm1.xml"
"$ectwin" esi vr-bu-ect-map7 -o "$work/map7.xml"
verified "CF-N02: verify: the file with the ESI files of its devices" 0 "" "eni:$work/own.xml" "$work/fzm1.xml" "$work/map7.xml"
verified "verify: a file alone" 0 "" "eni:$eni/machine.xml"
verified "ENI-009: verify: a slave of none of the ESI files" 1 \
  "$eni/machine.xml:$(grep -n -m2 '<Slave>' "$eni/machine.xml" | tail -1 | cut -d: -f1): slave 2, Drive 2 (AX1): no ESI file has vendor 0x00000E57, product 0x000002A1, revision 0x00000003" \
  "eni:$eni/machine.xml" "$work/esi/io.XML"
sed 's|<Cnt>9</Cnt>|<Cnt>8</Cnt>|; s|<BitStart>8</BitStart><BitLength>48|<BitStart>8</BitStart><BitLength>40|' "$eni/machine.xml" >"$work/wrong.xml"
"$ectwin" verify "eni:$work/wrong.xml" >"$work/out"
check "ENI-014, ENI-016: verify: sizes and counters" \
  "1 Send has 40 bits, its assigned PDOs 48; Send has 40 bits, its FMMUs 48; Recv has 40 bits, its assigned PDOs 48; Recv has 40 bits, its FMMUs 48; the working counter is 9, not 8" \
  "$? $(sed 's/.*: slave [0-9]: //; s/.*command: //' "$work/out" | paste -sd';' | sed 's/;/; /g')"
"$ectwin" with --quiet --in-process --virtual-time fzm1*2,vr-bu-ect-map7 -- "$ectwin" verify "eni:$work/own.xml" slave:{} >"$work/out" 2>"$work/err"
check "ENI-018: verify: the slaves of a bus: the serial number of the first differs" \
  "1 serial number 0x00000005, the slave has 0x00000001" "$? $(grep -o 'serial.*' "$work/out")"
"$ectwin" with --quiet --in-process --virtual-time --serial 1:5 --revision 2:9 fzm1*2 -- "$ectwin" verify "eni:$work/own.xml" slave:{} >"$work/out" 2>"$work/err"
check "ENI-018: verify: another revision, one slave less" \
  "1 revision 0x00010000, the slave has 0x00000009 3 slaves, the bus has 2" "$? $(grep -o -e 'revision.*' -e '[0-9] slaves.*' "$work/out" | xargs)"
verified "verify: slave:IFACE beside a file" 2 "ectwin verify: slave:IFACE is the only operand behind a network file" \
  "eni:$eni/machine.xml" "$work/fzm1.xml" slave:eth0
verified "verify: an ESI file that is none" 2 "ectwin verify: $work/none.xml: No such file or directory" "eni:$eni/machine.xml" "$work/none.xml"

refused() { # TITLE CODE MESSAGE ARGUMENT...
  "$ectwin" check "${@:4}" >"$work/out" 2>"$work/err"
  check "$1" "$2 ectwin check: $3" "$? $(grep -v '^ectwin: ' "$work/err" | head -1)"
}
refused "no such file" 2 "$work/none.xml: No such file or directory" "eni:$work/none.xml"
refused "no such slave" 1 "eni:$eni/machine.xml#N is one slave, N 1 to 3; 'run' and 'with' take the bus, eni:$eni/machine.xml" \
  "eni:$eni/machine.xml#4"
refused "a count of a bus" 1 "a count is for one device, and eni:$eni/machine.xml is a bus: write it once" "eni:$eni/machine.xml*2"
refused "a device behind a bus" 1 "no device follows behind eni:$eni/machine.xml, a bus of any length: put that last" "eni:$eni/machine.xml,fzm1"
refused "no such folder" 2 "--esi-dir $work/none: No such file or directory" --esi-dir "$work/none" "eni:$eni/machine.xml"
sed 's|<PhysAddr>1001</PhysAddr></PreviousPort>|<PhysAddr>9</PhysAddr></PreviousPort>|' "$eni/machine.xml" >"$work/tree.xml"
refused "ENI-010: a neighbour that is not there" 1 \
  "$work/tree.xml:$(grep -n '<PhysAddr>9<' "$work/tree.xml" | head -1 | cut -d: -f1): PreviousPort has the PhysAddr 9, which no previous slave has" \
  "eni:$work/tree.xml"
sed 's|<VendorId>[^<]*</VendorId>||' "$eni/machine.xml" >"$work/wrong.xml"
refused "ENI-001: a slave without VendorId" 2 \
  "$work/wrong.xml:$(grep -n -m1 '<Physics>' "$work/wrong.xml" | cut -d: -f1): Config/Slave/Info has no VendorId" "eni:$work/wrong.xml"
exit $failed
