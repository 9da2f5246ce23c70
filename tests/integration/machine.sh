#!/usr/bin/env bash
# The example machine: its axis reaches the sensor, the camera and back.  usage: machine.sh FOLDER
set -u
folder=$1
examples=$(dirname "$0")/../../examples/machine
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

# played WORD...: the machine on the virtual clock, with the script $work/script
played() {
  "$folder/ectwin" with --in-process --virtual-time --scenario "$work/script" "$examples/machine.yaml" -- "$folder/ectwin-motion" '{}' >"$work/out" 2>&1
}

cat >"$work/script" <<'END'
at OP expect ranger:surface1.distance>59.9 within 3s
at OP expect camera:measurements=1 within 3s
at OP after 1.3s expect ranger:surface1.distance<60.1     # the axis has arrived and is not yet disabled
at OP after 1.3s expect camera:measurements=1
END
played
check "The axis moves to 60 mm below the sensor, with one measurement of the camera" "0 done" "$? $(tail -n 1 "$work/out" | cut -d, -f2)"
cat >"$work/script" <<'END'
at OP after 500ms expect axis:enable=1
at OP after 500ms set operator:ru1.on=0
at OP after 501ms expect axis:enable=0     # a connection follows when the devices run next
END
played
check "The switch of the remote unit disables the axis: its program fails, all expectations are met" "3 2 of 2" \
  "$? $(sed -n 's/.*: \(2 of 2\) expectations are met/\1/p' "$work/out")"

# In real time, on a busy machine, the master may leave an axis in motion without frames, which is a fault of the drive: the signals remain connected.
"$examples/machine.sh" "$folder" >"$work/out" 2>/dev/null
check "The script prints the signals of four connected twins" "connected" "$(awk -F= '
  $1 == "turns" { turns = $2 }
  $1 == "surface1.distance" { distance = $2 }
  $1 == "measurements" { measurements = $2 }
  $1 == "enable" && $2 == 0 { off = 1 }
  END {
    error = distance - 10 - 5 * turns
    if (error < 0) error = -error
    arrived = turns > 9.98
    print off && error < (arrived ? 0.1 : 5) && measurements == (turns > 5.5) ? "connected" : turns " " distance " " measurements " " off
  }' "$work/out")"
exit $failed
