#!/usr/bin/env bash
# The charts in docs/devices are what the twins do: recorded anew, they come out the same.
# usage: charts.sh FZM1_RECORD OPTONCDT_RECORD [--write]
set -eu
fzm1=$1 optoncdt=$2 write=${3:-}
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0

# chart RECORDER FOLDER NAME OPTION...
chart() {
  local drawn=$2/$3.svg
  mkdir -p "$work/$2"
  "$1" "$3" | python3 "$root/tools/chart.py" --svg "${@:4}" >"$work/$drawn"
  if [ "$write" = --write ]; then
    mkdir -p "$root/docs/devices/$2"
    cp "$work/$drawn" "$root/docs/devices/$drawn"
  elif ! cmp -s "$work/$drawn" "$root/docs/devices/$drawn"; then
    echo "FAILED docs/devices/$drawn is not what the twin does; renew it: $0 $fzm1 $optoncdt --write"
    status=1
  fi
}

for name in step images command scene handshaking period; do
  chart "$fzm1" fzm1 "$name"
done
chart "$optoncdt" optoncdt2300 profile --curve 1e-6 --from 0 --to 54 --signals distance1
chart "$optoncdt" optoncdt2300 vibration --curve 1e-6 --from 0 --to 58 --signals distance1,distance2
exit $status
