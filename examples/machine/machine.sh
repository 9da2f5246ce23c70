#!/bin/sh
# A machine of four twins on one bus: an axis, a distance sensor above it, a camera triggered by the position of the axis, and a
# base unit whose first remote unit, when switched on, enables the axis. The motion program is the only master.
# usage: machine.sh [FOLDER of ectwin and ectwin-motion]
set -eu
bin=${1:-$(dirname "$0")/../../build/release}
export ECTWIN="$bin/ectwin" MOTION="$bin/ectwin-motion"

# Twin 1 axis, 2 sensor, 3 camera, 4 base unit. 5 mm per turn, 10 mm at the start; a picture after 5.5 turns.
exec "$ECTWIN" with \
  --set 4:ru1.on=1 \
  --connect 1.enable=4.ru1.on \
  --connect 2.surface1.distance=1.turns,factor=5,offset=10 \
  --connect 3.trigger=1.turns,offset=-5 \
  pmctendo-dd5,optoncdt2300,fzm1,vr-bu-ect-map7 -- sh -c '
    "$MOTION" "$1" | tail -n 1
    "$ECTWIN" get -n 1 turns
    "$ECTWIN" get -n 2 surface1.distance
    "$ECTWIN" get -n 3 measurements
    "$ECTWIN" set -n 4 ru1.on=0
    "$ECTWIN" get -n 1 enable' machine {}
