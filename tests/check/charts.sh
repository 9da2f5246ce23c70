#!/usr/bin/env bash
# The charts in docs show the behaviour of the twins: a new recording gives the same charts.
# usage: charts.sh FZM1_RECORD OPTONCDT_RECORD DRIVE_RECORD CIA402_RECORD [--write]
set -eu
fzm1=$1 optoncdt=$2 drive=$3 cia402=$4 write=${5:-}
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0

# picture FILE: the file of that name below $work equals that of docs.
picture() {
  if [ "$write" = --write ]; then
    mkdir -p "$root/docs/$(dirname "$1")"
    cp "$work/$1" "$root/docs/$1"
  elif ! cmp -s "$work/$1" "$root/docs/$1"; then
    echo "FAILED docs/$1 is not what the twin does; renew it: $0 $fzm1 $optoncdt $drive $cia402 --write"
    status=1
  fi
}

# chart RECORDER FOLDER NAME OPTION...
chart() {
  mkdir -p "$work/$2"
  "$1" "$3" >"$work/recording" 2>"$work/said" || { echo "FAILED the recording of $2/$3: $(cat "$work/said")"; status=1; }
  python3 "$root/tools/dev/chart.py" --svg "${@:4}" "$work/recording" >"$work/$2/$3.svg"
  picture "$2/$3.svg"
}

for name in step images command scene handshaking period; do
  chart "$fzm1" devices/fzm1 "$name"
done
chart "$optoncdt" devices/optoncdt2300 profile --curve 1e-6 --from 0 --to 54 --signals distance1
chart "$optoncdt" devices/optoncdt2300 vibration --curve 1e-6 --from 0 --to 58 --signals distance1,distance2

# A turn has 10 000 increments: turns, turns a second.
chart "$cia402" cia402 pp --curve 1e-4 --from 0 --to 2600 --signals "target,bit 4,bit 5,bit 12,bit 10,position,speed" --zero "zero"
chart "$cia402" cia402 hm --curve 1e-4 --from 0 --to 800 --signals "bit 4,switch,bit 12,bit 10,position,speed" --zero "zero"
chart "$cia402" cia402 quick_stop --curve 1e-4 --from 0 --to 2000 --signals "bit 2,enabled,stopping,speed" --zero "zero"

mkdir -p "$work/devices/pmctendo-dd5"
"$drive" >"$work/motion.csv" 2>"$work/said" || { echo "FAILED the recorded motion does not come to its end: $(cat "$work/said")"; status=1; }
python3 "$root/examples/motion/plot.py" "$work/motion.csv" >"$work/devices/pmctendo-dd5/motion.svg"
picture devices/pmctendo-dd5/motion.svg
exit $status
