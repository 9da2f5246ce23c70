#!/usr/bin/env bash
# An EtherCAT slave on a microcontroller with nothing but an Ethernet controller: the firmware for ARM's MPS2, in QEMU, and SOEM
# takes it to OP and holds it there.  usage: tools/board-demo.sh [SECONDS]     default 60
# Needs no hardware. Root only for installing packages that are missing.
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
