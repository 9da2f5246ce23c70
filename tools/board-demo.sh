#!/usr/bin/env bash
# An EtherCAT slave on a microcontroller with only an Ethernet controller: QEMU runs the firmware for ARM's MPS2, and SOEM takes the
# slave to OP and keeps it there.  usage: tools/board-demo.sh [SECONDS]     default 60
# Needs no hardware, and root only for the installation of missing packages.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
tools/bootstrap.sh board
for preset in release mps2-an385; do
  cmake --preset $preset >build.log 2>&1 || { cat build.log; exit 1; }
  cmake --build --preset $preset >build.log 2>&1 || { cat build.log; exit 1; }
done
rm -f build.log
firmware=build/mps2-an385/firmware/vr-bu-ect-map7.elf
arm-none-eabi-size $firmware
exec tools/with-board.py $firmware -- build/release/ectwin-demo-master '{}' "$seconds"
