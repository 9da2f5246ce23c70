#!/usr/bin/env bash
# Instructions of slave stack, device and port on a Cortex-M4 in QEMU, with the flags of the firmware, against those that twins like a
# board take (src/bus/chain/board.c): within 10 %. Prints DEVICE BOARD WORK COUNTED COMPUTED. Exits with 77 without compiler or QEMU.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
for program in arm-none-eabi-gcc qemu-system-arm; do
  command -v $program >/dev/null || { echo "skipped: no $program here; tools/bootstrap.sh test installs it"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
flags="-std=gnu11 -mcpu=cortex-m4 -mthumb -Os -DECT_SMALL -DNDEBUG -ffunction-sections -fdata-sections -Wall -Wextra -Werror -I$root/src -I$root/firmware
  -I$root/firmware/cpu"
for source in "$root"/src/{od,slave,esc,sii}/*.c "$root"/src/ports/{lan9252,mmio,virtual}/*.c "$root"/src/{devices,profiles}/*/*.c \
  "$root"/src/bus/chain/board.c "$root"/firmware/cpu/{cortex_m,memory,atomic}.c "$root/tests/check/cycles.c"; do
  case "$source" in */signals.c | */modbus.c) continue ;; esac # the plant: no firmware has it
  # shellcheck disable=SC2086
  arm-none-eabi-gcc $flags -c "$source" -o "$work/$(echo "$source" | tr / _).o"
done
printf 'MEMORY\n{\n  FLASH (rx) : ORIGIN = 0, LENGTH = 4M\n  RAM (rwx) : ORIGIN = 0x20000000, LENGTH = 4M\n}\nSTACK_SIZE = 64K;\n' >"$work/memory.ld"
arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb --specs=nano.specs --specs=nosys.specs -nostartfiles -Wl,--gc-sections -T "$root/firmware/cpu/flash.ld" \
  -L "$work" "$work"/*.o -o "$work/cycles.elf" 2>"$work/link" || { cat "$work/link"; exit 1; }
timeout 60 qemu-system-arm -M mps2-an386 -icount shift=10 -kernel "$work/cycles.elf" -display none -monitor none -serial none \
  -semihosting-config enable=on,target=native 2>"$work/out" </dev/null || true # a program that hangs prints nothing
awk '{
    verdict = NF == 5 && $4 * 0.9 <= $5 && $5 <= $4 * 1.1 ? "ok" : "WRONG"
    wrong += verdict == "WRONG"
    print $0, verdict
  }
  END {
    if (NR == 0 || NR % 21 != 0) { print NR, "lines: expected three for each of seven devices on each board"; wrong++ }
    if (wrong) print "the instructions of a board are in src/bus/chain/board.c"
    exit wrong > 0
  }' "$work/out"
