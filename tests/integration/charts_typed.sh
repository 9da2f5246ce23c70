#!/usr/bin/env bash
# The commands of the manual's chapter "Timing charts" are typed as printed there, and give their charts: each signal of each chart
# is both on and off.  usage: charts_typed.sh ECTWIN
# A machine that is busy at that moment may stretch a record beyond a chart's end: ten records are tried.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$(dirname "$1")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
ln -s "$root/tools" tools
export PATH=$build:$PATH

sed -n '/^## Timing charts/,/^## How/s/^\$ //p' "$root/docs/devices/fzm1.md" >commands
charts=$(grep -c '^tools/dev/chart.py' commands || true)
if [ "$charts" -lt 3 ]; then
  echo "FAILED the manual has $charts charts to type; expected 3 or more"
  exit 1
fi

# Signals of the charts that are not both on and off, one a line.
missing() {
  while read -r command; do
    signals=$(sed -n 's/.*--signals \([^ ]*\).*/\1/p' <<<"$command")
    bash -c "$command" >chart 2>&1 || cat chart
    for signal in ${signals//,/ }; do
      grep "^${signal^^} " chart | grep '▔' | grep -q '▁' || echo "$signal in: $command"
    done
  done < <(grep '^tools/dev/chart.py' commands)
}

for attempt in 1 2 3 4 5 6 7 8 9 10; do
  bash -c "$(grep -v '^tools/dev/chart.py' commands)" >/dev/null 2>&1 || true
  missing >missed
  if [ ! -s missed ]; then exit 0; fi
done
echo "FAILED these signals do not go on and off in their charts:"
cat missed
exit 1
