#!/usr/bin/env bash
# The timing charts in docs/devices/fzm1 are what the twin does: recorded anew, they come out the same.
# usage: charts.sh RECORDER [--write]
set -eu
recorder=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
for name in step images command scene handshaking period; do
  "$recorder" "$name" | python3 "$root/tools/chart.py" --svg >"$work/$name.svg"
  if [ "${2:-}" = --write ]; then
    cp "$work/$name.svg" "$root/docs/devices/fzm1/"
  elif ! cmp -s "$work/$name.svg" "$root/docs/devices/fzm1/$name.svg"; then
    echo "FAILED docs/devices/fzm1/$name.svg is not what the twin does; renew it: $0 $recorder --write"
    status=1
  fi
done
exit $status
