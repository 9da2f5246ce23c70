#!/usr/bin/env bash
# The example machine: its axis reaches the sensor, the camera and back.  usage: machine.sh FOLDER
# The master works in real time: a machine that leaves it no time for an axis in motion gets a fault from the drive, so up to five runs are tried.
set -u
for _ in 1 2 3 4 5; do
  said=$("$(dirname "$0")/../../examples/machine/machine.sh" "$1" 2>/dev/null)
  distance=$(sed -n 's/^surface1.distance=//p' <<<"$said")
  if awk -v d="${distance:-0}" 'BEGIN { exit !(d > 59.9 && d < 60.1) }' && grep -qx measurements=1 <<<"$said" &&
     grep -qx enable=0 <<<"$said"; then exit 0; fi
done
printf 'FAILED\n  expected: 60 mm, one measurement, no enable\n  got: %s\n' "$said"
exit 1
