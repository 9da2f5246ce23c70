#!/usr/bin/env bash
# The charts in docs/devices show the behaviour of the twins: a new recording gives the same charts.
# usage: charts.sh FZM1_RECORD OPTONCDT_RECORD DRIVE_RECORD [--write]
set -eu
fzm1=$1 optoncdt=$2 drive=$3 write=${4:-}
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0

# picture FILE: the file of that name below $work equals the manual's.
picture() {
  if [ "$write" = --write ]; then
    mkdir -p "$root/docs/devices/$(dirname "$1")"
    cp "$work/$1" "$root/docs/devices/$1"
  elif ! cmp -s "$work/$1" "$root/docs/devices/$1"; then
    echo "FAILED docs/devices/$1 is not what the twin does; renew it: $0 $fzm1 $optoncdt $drive --write"
    status=1
  fi
}

# chart RECORDER FOLDER NAME OPTION...
chart() {
  mkdir -p "$work/$2"
  "$1" "$3" | python3 "$root/tools/dev/chart.py" --svg "${@:4}" >"$work/$2/$3.svg"
  picture "$2/$3.svg"
}

for name in step images command scene handshaking period; do
  chart "$fzm1" fzm1 "$name"
done
chart "$optoncdt" optoncdt2300 profile --curve 1e-6 --from 0 --to 54 --signals distance1
chart "$optoncdt" optoncdt2300 vibration --curve 1e-6 --from 0 --to 58 --signals distance1,distance2

mkdir -p "$work/pmctendo-dd5"
"$drive" >"$work/motion.csv" 2>"$work/said" || { echo "FAILED the recorded motion does not come to its end: $(cat "$work/said")"; status=1; }
python3 "$root/examples/motion/plot.py" "$work/motion.csv" >"$work/pmctendo-dd5/motion.svg"
picture pmctendo-dd5/motion.svg
exit $status
