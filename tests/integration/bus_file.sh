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
check "options of the command line replace those of the file, before and behind it" "camera1.data1=2.5 camera2.data1=3.5" "$said"
"$ectwin" with --in-process --virtual-time "$work/bus.yaml" -- "$conform" -i {} --only CF-095 >"$work/out" 2>>"$work/err"
check "a bus in the master's process goes to OP (CF-095)" 1 "$(grep -c 'pass CF-095' "$work/out")"

check "check: a bus that can run" "4 twins: ranger=optoncdt2300,camera=fzm1*2,axis=esi:$work/drives/drives.xml#SERVO 0" \
  "$("$ectwin" check "$work/bus.yaml" 2>"$work/err" | tr '\n' ' '; echo "${PIPESTATUS[0]}")"
sed 's/temperature: 1/warmth: 1/' "$work/bus.yaml" >"$work/wrong.yaml"
rm -rf "$work/kept"
"$ectwin" check "$work/wrong.yaml" >"$work/out" 2>"$work/err"
check "check: no such signal: exit code" 1 $?
check "check: no such signal" "ectwin check: $work/wrong.yaml:7: --set: slave 1 has no signal 'warmth'" "$(grep -o "ectwin check.*'warmth'" "$work/err")"
check "check: opens no store" "" "$(ls -d "$work/kept" 2>/dev/null)"
printf 'ectwin: 1\ntwins:\n- device: fzm1\n  colour: red\n' >"$work/wrong.yaml"
"$ectwin" with "$work/wrong.yaml" -- true 2>"$work/err"
check "a wrong key: exit code" 2 $?
check "a wrong key" "ectwin with: $work/wrong.yaml:4: 'colour' is no key of a twin" "$(head -1 "$work/err" | cut -d: -f1-4 | sed 's/ of a twin.*/ of a twin/')"

# Mistakes behind the schema have their line too, and one line only: lines of the file | the line | begin of the message
printf 'drop 1%%\nhang slave 9\n' >"$work/nine.txt"
while IFS='|' read -r lines line message; do
  printf 'ectwin: 1\n%b\n' "$lines" >"$work/wrong.yaml"
  "$ectwin" check "$work/wrong.yaml" >"$work/out" 2>"$work/err"
  check "$lines: refused" 1 "$([ $? -ne 0 ] && wc -l <"$work/err")"
  check "$lines" "ectwin check: $work/wrong.yaml:$line: $message" "$(cut -c1-$((${#work} + ${#line} + ${#message} + 28)) "$work/err")"
done <<'END'
twins:\n- device: fzm1\n- device: nosuch|4|there is no device 'nosuch'
twins:\n- device: fzm1\n- device: esi:no.xml|4|
twins:\n- device: yaml:wrong.yaml|3|
twins:\n- device: wrong.yaml|3|'device: wrong.yaml' is a file
twins:\n- device: fzm1\n  name: scenario|3|the name 'scenario' hides
twins:\n- device: vr-bu-ect-map1\n- device: fzm1\n  name: ru1|4|the name 'ru1' of twin 2 hides
twins:\n- device: fzm1\n  set:\n    data1: 1\n    data2: warm|6|--set: data2 takes
twins:\n- device: fzm1\n  set:\n    data1: warm\n    data2: 1|5|--set: data1 takes
twins:\n- device: fzm1\n  set:\n    data1: 1\n    data99: 1\n    data2: 1|6|--set: slave 1 has no signal 'data99'
twins:\n- device: fzm1\n  set:\n    output_period: 30\n    output_time: 40\n    data1: 1|5|--set: output_period: the output time must be shorter
twins:\n- device: fzm1\n- device: fzm1\n  set:\n    data1: 1\n    output_time: 40\n    output_period: 30|8|--set: output_period: the output time must be shorter
twins:\n- device: fzm1\n  alias: 70000|4|--alias takes a number
seed: 1\nbehaviour: 3:none\ntwins:\n- {device: fzm1, count: 2}|3|--behaviour 3:
twins:\n- device: fzm1\n  esc: et9|4|there is no chip 'et9'
twins:\n- device: fzm1\n  play: no.csv|4|--play 1:
twins:\n- device: fzm1\n  eoe: tap0|4|--eoe 1:tap0: twin 1, fzm1, has no EoE
twins:\n- device: fzm1\n  behaviour: cia402|3|'fzm1' has its own behaviour
fault:\n- drop 1%\n- explode\ntwins:\n- device: fzm1|4|--fault: expected drop
fault:\n- drop 1%\n- hang slave 9\ntwins:\n- device: fzm1|4|a fault names slave 9
fault:\n- drop 1%\n- at 1s set data99=3\ntwins:\n- device: fzm1|4|'at 1s set data99=3': slave 1 has no signal
faults: nine.txt\ntwins:\n- device: fzm1|2|a fault names slave 9
seed: 1\nconnect:\n- 1.data1=2.data1\n- 1.data1=2.none\ntwins:\n- {device: fzm1, count: 2}|5|--connect 1.data1=2.none
connect: 2.data1=1.data1,every=2\ntwins:\n- {device: fzm1, count: 2}|2|--connect
wire: [2:1.3,\n3:2.9]\ntwins:\n- {device: fzm1, count: 3}|3|--wire takes N:M.PORT
wire: [2:1.3,\n3:1.3]\ntwins:\n- {device: fzm1, count: 3}|3|twin 3 cannot be connected to port 3 of twin 1
seed: many\ntwins:\n- device: fzm1|2|--seed takes a number
panel: '7'\ntwins:\n- device: fzm1|2|--panel: '7' is no twin
pcap: /x.pcapng\ntwins:\n- device: fzm1|2|'pcap: /x.pcapng' is written outside the folder
record: ../x\ntwins:\n- device: fzm1|2|'record: ../x' is written outside the folder
files: /\ntwins:\n- device: fzm1|2|'files: /' is written outside the folder
twins:\n- {device: fzm1, count: 65536}|3|'count' takes a number from 1 to 65535
END
"$ectwin" check --quiet --pcap /x.pcapng --store / "$work/bus.yaml" >"$work/out" 2>"$work/err"
check "the command line may write everywhere" "" "$(cat "$work/err")"
"$ectwin" check --alias 70000 "$work/bus.yaml" >"$work/out" 2>"$work/err"
check "a mistake of the command line has no line of the file" "ectwin check: --alias takes a number from 1 to 65535, not '70000'" "$(head -1 "$work/err")"
"$ectwin" with --in-process "$work/wrong.yaml" -- true 2>"$work/err"
check "... in the master's process" 1 "$(grep -c "wrong.yaml:3: 'count' takes" "$work/err")"
"$ectwin" check "fzm1,$work/bus.yaml" 2>"$work/err"
check "a bus file among devices" 1 "$(grep -c 'a bus file is the only operand of run, with or check' "$work/err")"
"$ectwin" verify "$work/bus.yaml" fzm1 2>"$work/err"
check "a bus file as a device of verify" 1 "$(grep -c 'a bus file is the only operand of run, with or check' "$work/err")"

"$ectwin" run -i nosuch0 "$work/nothing.yaml" 2>"$work/err"
check "no such file: exit code" 2 $?
check "no such file" "ectwin run: $work/nothing.yaml: No such file or directory" "$(cat "$work/err")"

# Names of twins, of a bus file or of the command line, in every command that takes a number.
cat >"$work/script" <<'END'
at 0s set camera2.data1=9
expect camera2.data1=9 within 1s
expect camera1:data1=1.5 within 1s
END
cat >"$work/ask" <<END
e='$ectwin'
"\$e" wait camera2.data1=9
"\$e" get camera2.data1
"\$e" get -n camera1 data1
"\$e" get -n 0 data1
"\$e" get -n 0 'camera?.data2'
"\$e" set camera1.data1=3 ranger.temperature=4
"\$e" set camera1.data1=5 ranger.temperature=warm
"\$e" get camera1.data1 ranger.temperature
"\$e" wait -t 5 'camera1.data1>2'; echo "wait \$?"
"\$e" wait -t 5 -n camera1 'data1>2'; echo "wait \$?"
"\$e" fault drop 0% wire ranger; "\$e" fault; "\$e" fault off
"\$e" fault hang slave camera2; "\$e" fault hang slave nobody
"\$e" get -n nobody data1
"\$e" unplug axis; "\$e" get axis.ecat.plug_in; "\$e" plug axis
"\$e" cut camera2.1; "\$e" get camera2.ecat.plug_out; "\$e" mend camera2.1
"\$e" list-signals camera1.data1 | tr -s ' '
printf 'camera1.data1,ranger.temperature\n7,8\n' | "\$e" set --csv -
"\$e" watch --until 'camera1.data1=7' --csv - camera1.data1 ranger.temperature
"\$e" watch --until 'camera1.data1=7' camera1.data1 | sed 's/,"time.*//'
END
cat >"$work/wanted" <<'END'
camera2.data1=9
data1=1.5
camera1.data1=1.5
camera2.data1=9
camera1.data2=0
camera2.data2=0
ectwin set: temperature takes -55..127 degC, not 'warm'
camera1.data1=3
ranger.temperature=4
wait 0
wait 0
drop 0% wire ranger
ectwin fault: expected the number or the name of a twin, not 'nobody'
ectwin get: there is no such slave in this chain
axis.ecat.plug_in=0
camera2.ecat.plug_out=0
data1 rw -999999999..999999999 measured value D1 of the scene
time,camera1.data1,ranger.temperature
0.000000,7,8
{"slave":2,"twin":"camera1","name":"data1","value":7
END
sed '/^connect/d' "$work/bus.yaml" >"$work/named.yaml"
said=$("$ectwin" with --quiet --scenario "$work/script" "$work/named.yaml" -- sh -c "sh '$work/ask' 2>&1" 2>"$work/err")
check "names of a bus file in every command" "" "$(diff "$work/wanted" - <<<"$said")"
check "names in a scenario" "ectwin with: 2 of 2 expectations are met" "$(tail -1 "$work/err")"
said=$("$ectwin" with --set b.data1=2 --set c2:data1=3 --connect b.data2=c2.data1 --alias b:17 --wire c1:b.2 --drift c2:5 --cable c1:7 \
  --esc b:et1100 fzm1,b=fzm1,c=fzm1*2 -- sh -c "'$ectwin' wait b.data2=3; '$ectwin' get b.data1 c2.data1 b.data2" 2>"$work/err" | xargs)
check "names of the command line in its options" "b.data1=2 c2.data1=3 b.data2=3" "$said"
said=$("$ectwin" with --in-process --virtual-time --fault 'expect b.data1=2' --set b:data1=2 b=fzm1 -- "$conform" -i {} --only CF-001 2>&1 >"$work/out")
check "names of twins in the master's process" 1 "$(grep -c '1 of 1 expectations are met' <<<"$said")"
printf 'time,b.data1,c.data1\n0,3,4\n' >"$work/table.csv"
"$ectwin" with --play "$work/table.csv" b=fzm1,c=fzm1 -- "$ectwin" wait -t 5 c.data1=4 2>"$work/err"
check "names in the columns of a table" 0 $?

mkdir "$work/waves"
printf 'time,data1\n0,3\n' >"$work/waves/three.csv"
printf 'time,data1\n0,4\n' >"$work/waves/four.csv"
printf "ectwin: 1\nplay: ['b:four.csv']\ntwins:\n- {device: fzm1, play: three.csv}\n- {device: fzm1, name: b}\n" >"$work/waves/bus.yaml"
said=$("$ectwin" with "$work/waves/bus.yaml" -- sh -c "'$ectwin' wait -t 5 b.data1=4; '$ectwin' get -n 0 data1" 2>"$work/err" | xargs)
check "play: relative to the file, of a twin and of the bus" "1:data1=3 b.data1=4" "$said"
for option in "--see 7" "--realtime 70"; do
  # shellcheck disable=SC2086
  "$ectwin" check $option "$work/waves/bus.yaml" >"$work/out" 2>"$work/err"
  check "a bus file behind $option, a value of its own word" "2 twins: fzm1,b=fzm1" "$(cat "$work/out" "$work/err")"
done
while IFS='|' read -r devices line; do
  "$ectwin" check "$devices" >"$work/out" 2>"$work/err"
  check "$devices: exit code" 1 $?
  check "$devices" "ectwin check: $line" "$(head -1 "$work/err")"
done <<'END'
a=fzm1,a=fzm1|two twins have the name 'a'
a=fzm1*2,a1=fzm1|two twins have the name 'a1'
2=fzm1|'2=fzm1': a name is a letter a to z, then letters, digits, _ and -, at most 31 characters, as in gripper=fzm1
Arm=fzm1|'Arm=fzm1': a name is a letter a to z, then letters, digits, _ and -, at most 31 characters, as in gripper=fzm1
abcdefghijklmnopqrstuvwxyz-0123=fzm1*2|the name 'abcdefghijklmnopqrstuvwxyz-01231' is longer than 31 characters
scenario=fzm1|the name 'scenario' hides the signals of a scenario: choose another name
ru1=vr-bu-ect-map1|the name 'ru1' of twin 1 hides the signal 'ru1.id' of twin 1: choose another name
END

{
  printf 'ectwin: 1\ntwins:\n'
  for n in {1..1000}; do printf -- '- {device: fzm1, name: camera%dx, alias: %d}\n' "$n" "$n"; done
} >"$work/many.yaml"
check "a thousand twins with names" '{"event":"ready","iface":"ecat0","slaves":1000}' "$("$ectwin" with "$work/many.yaml" -- true 2>&1)"
exit $failed
