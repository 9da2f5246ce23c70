#!/bin/sh
# A tank controlled by a PLC: twins of two valves and a level sensor, the water as a Python plant, the PLC as the master.
# usage: tank.sh [--virtual] [FOLDER of ectwin and ectwin-tank-plc] [option of ectwin-tank-plc...]
# --virtual runs on a virtual clock: identical lines in each run, faster than real time.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
virtual=
if [ "${1:-}" = --virtual ]; then virtual=yes; shift; fi
bin=${1:-$here/../../build/release}
[ $# -eq 0 ] || shift
name=tank$$

# The plant is a separate program, which waits for the twins and ends with them.
"$here/tank.py" ${virtual:+--wait} "$name" &
plant=$!
trap 'kill "$plant" 2>/dev/null || true' EXIT
"$bin/ectwin" with --quiet --name "$name" ${virtual:+--in-process --virtual-time --plant tank} "$here/tank.yaml" -- "$bin/ectwin-tank-plc" {} "$@"
wait "$plant"
