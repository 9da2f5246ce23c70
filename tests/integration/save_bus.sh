#!/usr/bin/env bash
# `ectwin save-bus`: a bus that is saved, started from the file and saved again gives the same file.
# usage: save_bus.sh ECTWIN ESI-FOLDER
set -u
ectwin=$1
esi=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

mkdir "$work/machine" "$work/elsewhere"
cp "$esi/drives.xml" "$work/machine"
cd "$work/elsewhere" || exit 1
cat >"$work/machine/bus.yaml" <<'END_OF_BUS'
ectwin: 1
seed: 7
connect: [camera2.judgement=ranger.temperature]
fault: [drop 0%, at 100s hang slave camera2, at 0s counter 0 for 200s]
cable: 5
twins:
  - device: optoncdt2300
    name: ranger
    alias: 17
    set: {temperature: 1}
  - device: fzm1
    name: camera
    count: 2
    set: {data1: 1.5}
  - device: esi:drives.xml#SERVO
    name: axis
    drift: 12
END_OF_BUS

# saved, started from the file, saved again: $1 title, $2 changes of the running bus, then options and devices
again() {
  local title=$1 change=$2
  shift 2
  "$ectwin" with "$@" -- sh -c "$change; '$ectwin' save-bus -o '$work/machine/one.yaml'" >"$work/out" 2>"$work/err"
  check "$title: the status of the first" 0 $?
  "$ectwin" check "$work/machine/one.yaml" >"$work/out" 2>"$work/err"
  check "$title: ectwin check" 0 $?
  "$ectwin" with "$work/machine/one.yaml" -- "$ectwin" save-bus -o "$work/machine/two.yaml" >"$work/out" 2>"$work/err"
  check "$title: the status of the second" 0 $?
  check "$title: the same file" "" "$(diff "$work/machine/one.yaml" "$work/machine/two.yaml" 2>&1)"
}

again "a bus file" "'$ectwin' set camera1.data2=3.25 camera2.comment1='it: a \"#\" text'; '$ectwin' unplug axis
  '$ectwin' fault abort 0x1018 0x06040043 slave camera1; '$ectwin' fault eeprom ok slave camera2" "$work/machine/bus.yaml"
cat >"$work/wanted" <<'END_OF_BUS'
ectwin: 1
seed: 7
connect: camera2.judgement=ranger.temperature
cable: 5
alias: 1:17
drift: 4:12
fault:
  - 'drop 0%'
  - 'abort 0x1018 0x06040043 slave camera1'
  - 'at 100s hang slave camera2'
  - 'at 0s counter 0 for 200s'
set:
  - 2:data1=1.5
  - 2:data2=3.25
  - 3:judgement=1
  - 3:data1=1.5
  - '3:comment1=it: a "#" text'
twins:
  - device: optoncdt2300
    name: ranger
    set:
      temperature: 1
  - device: fzm1
    name: camera
    count: 2
  - device: esi:drives.xml#SERVO
    name: axis
    set:
      ecat.plug_in: 0
      ecat.plug_out: 0
      ecat.plug_2: 0
      ecat.plug_3: 0
END_OF_BUS
check "the file: names, counts, signals, plugs, faults, steps to come; a path below its folder" "" "$(diff "$work/wanted" "$work/machine/one.yaml")"

again "a command line" "'$ectwin' set -n 2 ru1.on=1; '$ectwin' fault off" --alias 5 --serial=2:77 --drop 3 --set 3:data1=2 --wire 3:1.3 --esc 1:et1100 \
  --name press --eeprom-times chip --keep-source-mac fzm1,vr-bu-ect-map7,fzm1
check "the topology, the identity and a flag" "keep-source-mac: true|serial: 2:77|wire: 3:1.3" \
  "$(grep -E '^(wire|serial|keep)' "$work/machine/one.yaml" | sort | paste -sd'|')"
check "a signal that was changed back is not there" "" "$(grep -E 'drop|ru1.ready' "$work/machine/one.yaml")"
cp "$esi/rack.xml" "$work/machine"
printf 'ectwin: 1\ntwins:\n  - device: esi:rack.xml\n    name: rack\n    count: 2\n  - device: esi:rack.xml\n    name: last\n' >"$work/machine/racks.yaml"
again "modules inserted and removed since the start" "'$ectwin' set rack2.slot3.module=0x110 last.slot1.module=0 last.slot4.module=0x110 &&
  '$ectwin' set rack2.in_2.b=7 last.in.a=-5" "$work/machine/racks.yaml"
check "modules inserted and removed since the start, with their signals" \
  "set:|  - 2:slot3.module=272|  - 2:in_2.b=7|      slot1.module: 0|      slot4.module: 272|      in.a: '-5'" \
  "$(grep -E 'module|in.*[ab]|^set' "$work/machine/one.yaml" | paste -sd'|')"
cp "$esi/../eni/machine.xml" "$work/machine"
printf 'ectwin: 1\nesi-dir: .\ntwins:\n  - device: fzm1\n  - device: eni:machine.xml\n    name: line\n' >"$work/machine/network.yaml"
again "a network file" "'$ectwin' set -n 1 data1=1.5; '$ectwin' unplug line; '$ectwin' unplug 4" --quiet "$work/machine/network.yaml"
check "a network file: its path, its name, signals of each of its slaves" \
  "esi-dir: '.'|  - 2:ecat.plug_in=0|  - 4:ecat.plug_in=0|  - device: fzm1|      data1: 1.5|  - device: eni:machine.xml|    name: line" \
  "$(grep -E 'device|name|plug_in|esi-dir|data1' "$work/machine/one.yaml" | paste -sd'|')"
cd "$work/machine" || exit 1
printf 'time,data1\n0,3\n9999,3\n' >wave.csv
again "tables" "'$ectwin' wait -t 5 b.data1=3" --play wave.csv,loop --play=2:wave.csv \
  --play b:"$work/machine/wave.csv" fzm1,fzm1,b=fzm1
check "a path of a twin, below the folder" "  - 'wave.csv,loop'|  - 2:wave.csv|  - b:wave.csv" "$(grep 'wave' "$work/machine/one.yaml" | paste -sd'|')"
cp "$esi/every.xml" .
mkdir sockets
again "sockets of EoE" "true" --quiet --eoe unix:"$PWD/sockets/one" --eoe b:unix:two "esi:every.xml,b=esi:every.xml"
check "the path of a socket, below the folder" "  - unix:sockets/one|  - b:unix:two" "$(grep 'unix' "$work/machine/one.yaml" | paste -sd'|')"
again "a number of 64 bits" "'$ectwin' set inputs.position_actual_value=1234567890123456789; '$ectwin' get >'$work/got' inputs.position_actual_value" \
  --behaviour none esi:drives.xml#WIDE
check "all its digits, in the file and of get" "inputs.position_actual_value: 1234567890123456789|inputs.position_actual_value=1234567890123456789" \
  "$(grep -ho 'inputs.position.*' "$work/machine/one.yaml" "$work/got" | paste -sd'|')"
cd "$work/elsewhere" || exit 1
said=$("$ectwin" with esi:"$work/machine/drives.xml"#SERVO -- "$ectwin" save-bus 2>"$work/err")
network=$("$ectwin" with --quiet eni:../machine/machine.xml -- "$ectwin" save-bus 2>"$work/err")
check "a network file on standard output" "  - device: eni:$work/elsewhere/../machine/machine.xml" "$(grep device <<<"$network")"
check "standard output has whole paths" "  - device: esi:$work/machine/drives.xml#SERVO" "$(grep device <<<"$said")"
"$ectwin" with vr-bu-ect-map7 -- sh -c "'$ectwin' set ru1.id=9 && '$ectwin' set ru2.id=1 && '$ectwin' set ru1.id=2 bu.vlaps=1
  '$ectwin' save-bus" >"$work/out" 2>"$work/err"
check "values that a twin refuses at its start: exit code" 3 $?
check "... a line for each" "ru1.id=2|ru2.id=1" "$(sed -n "s/^ectwin save-bus: slave 1: '\(.*\)' is left out, a bus refuses it at its start: .*/\1/p" "$work/err" | paste -sd'|')"
check "... and the file is without them" "bu.vlaps: 1" "$(grep -oE '(ru.\.id|bu\.vlaps).*' "$work/out")"
"$ectwin" with --quiet --store "$work/elsewhere/kept" --pcap "$work/machine/x.pcapng" fzm1 -- "$ectwin" save-bus -o "$work/machine/one.yaml" >"$work/out" 2>"$work/err"
check "what a run writes outside the folder of the file: exit code" 3 $?
check "... a line for each" "ectwin save-bus: '--store=$work/elsewhere/kept' is left out" "$(grep -v ready "$work/err" | cut -d, -f1)"
check "... and the file is without it" "pcap: x.pcapng" "$(grep -E 'store|pcap' "$work/machine/one.yaml")"
env -u ECTWIN_SOCKET XDG_RUNTIME_DIR="$work" "$ectwin" save-bus >"$work/out" 2>"$work/err"
check "no bus: exit code" 2 $?
check "no bus" "ectwin save-bus: no twin of yours is running: start one with 'ectwin run' or 'ectwin with'" "$(head -1 "$work/err")"
exit $failed
