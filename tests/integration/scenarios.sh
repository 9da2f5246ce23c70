#!/usr/bin/env bash
# The scenarios of examples/scenarios under real masters, and the verdict in the exit status.
# usage: scenarios.sh ECTWIN CONTROLLER MOTION CONFORM [CASE]
set -u
ectwin=$1 controller=$2 motion=$3 conform=$4
only=${5:-}
folder=$(cd "$(dirname "$0")/../../examples/scenarios" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { sed 's/^/  /' "$work/err"; }

# play FILE [OPTION...]: under the master of its device, which the second line names. The status of the motion master is 3
# when it had to give the drive up.
play() {
  local file=$1 device
  shift
  device=$(sed -n '2s/^# \([^ ]*\) .*/\1/p' "$file")
  local master=("$controller" '{}' --seconds 5)
  if [ "$device" = pmctendo-dd5 ]; then master=("$motion" '{}'); fi
  "$ectwin" with --in-process --virtual-time "$@" --scenario "$file" "$device" -- "${master[@]}" >"$work/out" 2>"$work/err"
}

script() { # LINE...: a file of these
  printf '%s\n' "$@" >"$work/script.txt"
}

# story NAME [STATUS]: the scenario meets every expectation; STATUS (default 0) is that of its master.
story() {
  play "$folder/$1.txt"
  check "$1: exit status" "${2:-0}" $?
  local all
  all=$(grep -c expect "$folder/$1.txt")
  check "$1: verdict" "ectwin: '$(sed -n 's/^name //p' "$folder/$1.txt")': $all of $all expectations are met" "$(grep 'expectations are met' "$work/err")"
}

every_story_is_played() {
  local name
  for name in "$folder"/*.txt; do
    name=$(basename "$name" .txt)
    case $name in drive-drops-to-safeop) story "$name" 3 ;; *) story "$name" ;; esac
  done
}

# Twice the same story with a random fault: the same frames, at the same times, with the same seed alone.
same_seed_same_frames() {
  local run number=0
  script 'corrupt 2%' 'at 5ms delay 300us 20%' 'at PREOP abort 0x1018 0x08000020 30% slave 1' 'mail late 2ms 10% slave 1'
  for run in 7 7 8; do
    "$ectwin" with --in-process --virtual-time --seed $run --scenario "$work/script.txt" fzm1 -- \
      "$conform" -i '{}' --only CF-033 --pcap "$work/run$((++number)).pcapng" >/dev/null 2>"$work/err"
  done
  check "seed 7 twice" "$(md5sum <"$work/run1.pcapng")" "$(md5sum <"$work/run2.pcapng")"
  cmp -s "$work/run1.pcapng" "$work/run3.pcapng" && check "seed 8" "other frames" "the same"
  check "there are frames" yes "$([ "$(wc -c <"$work/run1.pcapng")" -gt 2000 ] && echo yes)"
}

# Takes the base unit to OP for a second. On a network a busy machine takes long, so a signal ends the controller.
# shellcheck disable=SC2016
a_second_of_op() {
  cat <<'END'
"$1" "$ECTWIN_IFACE" --seconds 600 & "$2" wait --timeout 300 ecat.state=8; sleep 1; kill $!; wait $!
END
}

# the_verdict_is_the_status OPTION...: of the run
the_verdict_is_the_status() {
  local way="$*"
  local run=("$controller" '{}' --seconds 1)
  [ -n "$way" ] || run=(sh -c "$(a_second_of_op)" sh "$controller" "$ectwin")
  # shellcheck disable=SC2086
  status() { "$ectwin" with $way --scenario "$work/script.txt" vr-bu-ect-map7 -- "$@" >"$work/out" 2>"$work/err"; echo $?; }
  script 'expect ecat.state=8 within 300s'
  check "met ($way)" 0 "$(status "${run[@]}")"
  check "the status of CMD stays ($way)" 7 "$(status sh -c '"$@"; exit 7' sh "${run[@]}")"
  script 'expect ecat.state=8 within 300s' 'expect ecat.state=4 at OP after 5 cycles'
  check "failed ($way)" 3 "$(status "${run[@]}")"
  check "failed: the line ($way)" "line 2: 'expect ecat.state=4 at OP after 5 cycles' has failed: ecat.state is 8" \
    "$(sed -n 's/^ectwin[^:]*: \(line 2.*\)/\1/p' "$work/err")"
  check "failed, and CMD too ($way)" 7 "$(status sh -c '"$@"; exit 7' sh "${run[@]}")"
  script 'at BOOT expect ecat.state=3'
  check "never reached ($way)" 3 "$(status "${run[@]}")"
}
the_verdict_over_the_network() { the_verdict_is_the_status; }
the_verdict_in_process() { the_verdict_is_the_status --in-process; }
the_verdict_on_the_virtual_clock() { the_verdict_is_the_status --in-process --virtual-time; }

its_progress_is_watched() {
  script '# two steps' 'at 3s set data1=5' 'at 4s expect data1=5'
  "$ectwin" with --in-process --virtual-time --scenario "$work/script.txt" fzm1 -- "$python" "$recorder" {} "$work/out" true \
    timeout 300 "$ectwin" watch --every --until scenario.verdict=met 'scenario.*' >"$work/out" 2>"$work/err"
  check "watch: until the verdict" 0 $?
  check "watch: line 2 has acted" yes "$(grep -q '"name":"scenario.line","value":2,' "$work/out" && echo yes)"
  check "watch: its text" yes "$(grep -q '"name":"scenario.step","value":"at 3s set data1=5",' "$work/out" && echo yes)"
  script 'expect data1=5'
  "$ectwin" with --scenario "$work/script.txt" fzm1 -- "$ectwin" wait scenario.verdict=failed 2>"$work/err"
  check "wait: failed, and the exit status" 3 $?
}

run_has_it_too() {
  script 'expect ecat.state=1'
  unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up || exit 9
    for script in "$2" "$3"; do
      "$1" run -i tw0 --scenario "$script" fzm1 >"$4/ready" 2>>"$4/err" & pid=$!
      for _ in $(seq 1200); do [ -s "$4/ready" ] && break; sleep 0.1; done
      sleep 0.3; kill $pid; wait $pid; echo $?
      : >"$4/ready"
    done' - "$ectwin" "$work/script.txt" <(echo 'expect ecat.state=2') "$work" >"$work/values" 2>/dev/null
  check "met, then failed" "0 3" "$(xargs <"$work/values")"
}

mistakes_are_found_before_the_run() {
  script '# a comment' 'at 5s set bogus=1'
  "$ectwin" with --in-process --scenario "$work/script.txt" fzm1 -- true 2>"$work/err"
  check "a signal that does not exist" 1 $?
  check "... by its name" yes "$(grep -q "'at 5s set bogus=1': slave 1 has no signal 'bogus'" "$work/err" && echo yes)"
  script 'drop 1%' 'expect'
  "$ectwin" with --in-process --scenario "$work/script.txt" fzm1 -- true 2>"$work/err"
  check "a line without sense" 1 $?
  check "... by its number" yes "$(grep -q "script.txt line 2: expected 'expect NAME=VALUE'" "$work/err" && echo yes)"
  mkdir "$work/a-folder-whose-name-takes-more-than-40-characters"
  cp "$work/script.txt" "$work/a-folder-whose-name-takes-more-than-40-characters"
  "$ectwin" with --in-process --scenario "$work/a-folder-whose-name-takes-more-than-40-characters/script.txt" fzm1 -- true 2>"$work/err"
  check "... by the end of a long path" yes "$(grep -q "40-characters/script.txt line 2: expected" "$work/err" && echo yes)"
  "$ectwin" with --in-process --scenario "$work/none.txt" fzm1 -- true 2>"$work/err"
  check "a non-existent file" 2 $?
}

# A master on the virtual clock: its time passes when the watch that it starts has begun, and before the commands behind it.
# usage: recorder.py IFACE OUTPUT COMMANDS WATCH ARG...
cat >"$work/recorder.py" <<'END_OF_MASTER'
import os, socket, subprocess, sys, time
iface, output, commands, *watch = sys.argv[1:]
bus = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
bus.bind((iface, 0))


def serve_until(done):  # in no time of the bus but that of its calls
    while not done():
        try:
            bus.recv(1500, socket.MSG_DONTWAIT)
        except BlockingIOError:
            pass


watching = subprocess.Popen(watch)
serve_until(lambda: watching.poll() is not None or os.path.exists(output) and os.path.getsize(output) > 0)
time.sleep(5)
serve_until(lambda: watching.poll() is not None)
following = subprocess.Popen(commands, shell=True)
serve_until(lambda: following.poll() is not None)
sys.exit(watching.returncode or following.returncode)
END_OF_MASTER
recorder=$work/recorder.py
python=$(python3 -c "import sys; print(sys.executable)") # not a script that starts it

# record RUN TABLE DEVICE COMMANDS CONDITION SIGNAL...: plays a table and records it, the same changes at the same times in each run
record() {
  local run=$1 table=$2 device=$3 commands=$4
  "$ectwin" with --in-process --virtual-time --play "$table" --name "recorded$run" "$device" -- "$python" "$recorder" {} "$work/record$run.csv" "$commands" \
    timeout 300 "$ectwin" watch --csv "$work/record$run.csv" --every --until "${@:5}" >"$work/out" 2>"$work/err"
  check "run $run: exit status" 0 $?
}

# its values, and the time of each change since the first
changes() {
  python3 -c "
import sys
rows = [line.strip().split(',', 1) for line in open(sys.argv[1])][2:]
for time, values in rows:
    print('%.3f' % (float(time) - float(rows[0][0])), values)" "$1"
}

# The twins play a table, which is recorded; the record is played, and recorded again.
recorded_and_played() {
  local run table=$work/first.csv
  { echo 'time,ru1.joystick1,ru1.rssi'; for n in $(seq 40); do echo "$((n / 100 + 3)).$(printf %02d $((n % 100))),$((n * 10)),$((n + 10))"; done; } >"$table"
  for run in 1 2; do
    record $run "$table" vr-bu-ect-map7 "'$ectwin' get ru1.joystick1" ru1.rssi=50 ru1.joystick1 ru1.rssi
    check "run $run: the last row" "ru1.joystick1=400" "$(cat "$work/out")"
    table=$work/record$run.csv
  done
  check "first line" "time,ru1.joystick1,ru1.rssi" "$(head -1 "$work/record1.csv")"
  check "all changes, one a line" 80 "$(($(wc -l <"$work/record1.csv") - 2))"
  check "the last one is 0.39 s after the first" "0.390 ,50" "$(changes "$work/record1.csv" | tail -1)"
  check "the same values in the same order, at the same times" "$(changes "$work/record1.csv")" "$(changes "$work/record2.csv")"
}

# A recording of values of two scenes gives each its own again, whatever the order of its columns.
recorded_scenes() {
  printf 'time,scene,data1\n3,,1.5\n3.3,4,\n3.31,,2.5\n3.6,0,\n3.9,4,\n4.2,0,\n4.21,,3.5\n' >"$work/first.csv"
  local run table=$work/first.csv
  for run in 1 2; do
    record $run "$table" fzm1 "'$ectwin' get scene data1; '$ectwin' set edit.scene=4; '$ectwin' get edit.data1" data1=3.5 data1 scene
    check "run $run: each scene has its value" "scene=0 data1=3.5 edit.data1=2.5" "$(xargs <"$work/out")"
    table=$work/record$run.csv
  done
  check "the same changes at the same times" "$(changes "$work/record1.csv")" "$(changes "$work/record2.csv")"
}

set_in_time() {
  printf 'data1,time\n1.5,0\n2.5,0.05\n,0.06\n3.5,0.1\n' >"$work/rows.csv"
  "$ectwin" with fzm1 -- sh -c "'$ectwin' set --csv '$work/rows.csv' && '$ectwin' get data1" >"$work/out" 2>"$work/err"
  check "set --csv: the last row" "data1=3.5" "$(cat "$work/out")"
  printf 'data1,time\n1.5,1\n2.5,0.5\n' >"$work/rows.csv"
  "$ectwin" with --play "$work/rows.csv" fzm1 -- true 2>"$work/err"
  check "--play: a time that goes back" 1 $?
  check "... in its line" yes "$(grep -q 'line 3: its time is before that of the line above' "$work/err" && echo yes)"
  printf 'data1\n1.5\n' >"$work/rows.csv"
  "$ectwin" with --play "$work/rows.csv" fzm1 -- true 2>"$work/err"
  check "--play: no time" 1 $?
  printf 'time,bogus\n0,1\n' >"$work/rows.csv"
  "$ectwin" with --play "$work/rows.csv" fzm1 -- true 2>"$work/err"
  check "--play: no such signal" 1 $?
  "$ectwin" with --play "$work/none.csv" fzm1 -- true 2>"$work/err"
  check "--play: no file" 2 $?
  printf 'time,data1\n0,1\n' >"$work/rows.csv"
  "$ectwin" with --play "$work/rows.csv,loop" fzm1 -- true 2>"$work/err"
  check "--play: a loop without a time" 1 $?
  check "... in words" yes "$(grep -q 'rows.csv line 3: a loop has the time of its last line, which must not be 0' "$work/err" && echo yes)"
  "$ectwin" with --play "$work/rows.csv,often" fzm1 -- true 2>"$work/err"
  check "--play: a word without sense" 1 $?
  check "... by its name" yes "$(grep -q "'often' is neither loop nor every=TIME" "$work/err" && echo yes)"
}

# A wave from a file, and tables of scenes from another; a file may have a comma in its name.
waves_and_scenes() {
  printf 'time,data1\n0,0.0\n1,8.0\n2,0.0\n' >"$work/wave,loop"
  "$ectwin" with --in-process --virtual-time --play "$work/wave,loop,loop,every=250ms" fzm1 -- "$python" "$recorder" {} "$work/wave.csv" true \
    timeout 300 "$ectwin" watch --csv "$work/wave.csv" --every --until data1=8 data1 2>"$work/err"
  check "a wave: steps on a line" yes "$(cut -d, -f2 "$work/wave.csv" | xargs | grep -Eq '2 4 6 8$' && echo yes)"
  "$ectwin" with --play "$work/wave,loop,loop" fzm1 -- sh -c "sleep 2.2; timeout 300 '$ectwin' wait data1=8" 2>"$work/err"
  check "a wave: it begins again" 0 $?
  printf 'time,row_scene,row1,row_add\n0,4,41,1\n0,4,42,1\n0,6,61,1\n' >"$work/scenes.csv"
  "$ectwin" with --play "$work/scenes.csv" --set source1=4 --set switch_time=0 fzm1 -- sh -c "
    for scene in 4 4 6 4; do '$ectwin' set scene=\$scene trigger=1; sleep 0.1; '$ectwin' get result1; done" >"$work/out" 2>"$work/err"
  check "tables of scenes" "result1=41 result1=42 result1=61 result1=41" "$(xargs <"$work/out")"
}

run_cases the_verdict_over_the_network the_verdict_in_process recorded_and_played recorded_scenes every_story_is_played waves_and_scenes \
  the_verdict_on_the_virtual_clock its_progress_is_watched run_has_it_too same_seed_same_frames mistakes_are_found_before_the_run set_in_time
