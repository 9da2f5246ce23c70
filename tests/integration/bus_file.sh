#!/usr/bin/env bash
# Bus files through the command: a bus that comes up as the file has it, options of the command line, mistakes, many twins.
# usage: bus_file.sh ECTWIN ECTWIN-CONFORM ESI-FOLDER
set -u
ectwin=$1
conform=$2
esi=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

mkdir "$work/drives"
cp "$esi/drives.xml" "$work/drives"
cat >"$work/bus.yaml" <<'END'
ectwin: 1
store: kept
connect: [camera2.judgement=ranger.temperature]
twins:
  - device: optoncdt2300
    name: ranger
    set: {temperature: 1}
  - device: fzm1
    name: camera
    count: 2
    set: {data1: 1.5}
  - device: esi:drives/drives.xml#SERVO
    name: axis
END

cd / || exit 1 # paths are relative to the file
cat >"$work/ask" <<END
"$ectwin" get -n 1 temperature
"$ectwin" get -n 2 data1
"$ectwin" get -n 3 judgement
"$ectwin" get -n 4 axis1.enable
END
said=$("$ectwin" with "$work/bus.yaml" -- sh "$work/ask" 2>"$work/err")
check "the ready line" '{"event":"ready","iface":"ecat0","slaves":4}' "$(grep ready "$work/err")"
check "signals, connections and the drive of the file" "temperature=1 data1=1.5 judgement=1 axis1.enable=1" "$(xargs <<<"$said")"
check "the store lies beside the file" 1 "$([ -d "$work/kept" ] && echo 1)"
said=$("$ectwin" with --set 2:data1=2.5 "$work/bus.yaml" --set 3:data1=3.5 -- "$ectwin" get -n 0 data1 2>>"$work/err" | xargs)
check "options of the command line replace those of the file, before and behind it" "2:data1=2.5 3:data1=3.5" "$said"
"$ectwin" with --in-process --virtual-time "$work/bus.yaml" -- "$conform" -i {} --only CF-095 >"$work/out" 2>>"$work/err"
check "a bus in the master's process goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"

check "check: a bus that can run" "4 twins: optoncdt2300,fzm1*2,esi:$work/drives/drives.xml#SERVO 0" \
  "$("$ectwin" check "$work/bus.yaml" 2>"$work/err" | tr '\n' ' '; echo "${PIPESTATUS[0]}")"
sed 's/temperature: 1/warmth: 1/' "$work/bus.yaml" >"$work/wrong.yaml"
rm -rf "$work/kept"
"$ectwin" check "$work/wrong.yaml" >"$work/out" 2>"$work/err"
check "check: no such signal: exit code" 1 $?
check "check: no such signal" "ectwin check: --set: slave 1 has no signal 'warmth'" "$(grep -o "ectwin check.*'warmth'" "$work/err")"
check "check: opens no store" "" "$(ls -d "$work/kept" 2>/dev/null)"
printf 'ectwin: 1\ntwins:\n- device: fzm1\n  colour: red\n' >"$work/wrong.yaml"
"$ectwin" with "$work/wrong.yaml" -- true 2>"$work/err"
check "a wrong key: exit code" 2 $?
check "a wrong key" "ectwin with: $work/wrong.yaml:4: 'colour' is no key of a twin" "$(head -1 "$work/err" | cut -d: -f1-4 | sed 's/ of a twin.*/ of a twin/')"
"$ectwin" run -i nosuch0 "$work/nothing.yaml" 2>"$work/err"
check "no such file: exit code" 2 $?
check "no such file" "ectwin run: $work/nothing.yaml: No such file or directory" "$(cat "$work/err")"

{
  printf 'ectwin: 1\ntwins:\n'
  for n in {1..1000}; do printf -- '- {device: fzm1, name: camera%dx, alias: %d}\n' "$n" "$n"; done
} >"$work/many.yaml"
check "a thousand twins with names" '{"event":"ready","iface":"ecat0","slaves":1000}' "$("$ectwin" with "$work/many.yaml" -- true 2>&1)"
exit $failed
