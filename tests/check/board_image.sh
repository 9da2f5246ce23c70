#!/usr/bin/env bash
# The firmware for QEMU's mps2-an385, as its preset builds it, into build/mps2-an385.  Exits with 77 where there is no compiler or no
# QEMU: those of the tests that need it are skipped then.
set -eu
cd "$(dirname "$0")/../.."
for program in arm-none-eabi-gcc qemu-system-arm; do
  command -v $program >/dev/null || { echo "skipped: no $program here; tools/bootstrap.sh test installs it"; exit 77; }
done
cmake --preset mps2-an385
cmake --build --preset mps2-an385
