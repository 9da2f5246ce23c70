#!/usr/bin/env bash
# Start-up code of the firmware on a Cortex-M7 in QEMU (mps2-an500): the MPU's region for an ESC, a fault. Exits with 77 without
# compiler or QEMU.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
for program in arm-none-eabi-gcc qemu-system-arm; do
  command -v $program >/dev/null || { echo "skipped: no $program here; tools/bootstrap.sh test installs it"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
arm-none-eabi-gcc -std=gnu11 -mcpu=cortex-m7 -mthumb -Os -Wall -Wextra -Werror -ffreestanding -nostdlib -I"$root/src" -I"$root/firmware" \
  -I"$root/firmware/cpu" -T "$root/firmware/cpu/flash.ld" -L "$root/firmware/boards/mps2-an385/loader" -Wl,--defsym=FIRMWARE_STACK=1024 \
  "$root"/tests/check/cpu.c "$root"/firmware/fault.c "$root"/firmware/cpu/{cortex_m,memory}.c -lgcc -o "$work/cpu.elf"
timeout 60 qemu-system-arm -M mps2-an500 -kernel "$work/cpu.elf" -display none -monitor none -serial none \
  -semihosting-config enable=on,target=native 2>"$work/out" </dev/null || true # a firmware that hangs prints nothing
cat "$work/out"
grep -q "a fault ended in board_fault" "$work/out"
