#!/usr/bin/env bash
# The memory that firmware/CMakeLists.txt gives each device against the bytes that its slave takes on a Cortex-M: enough, and at most 256
# more. Exits with 77 without compiler or QEMU.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
for program in arm-none-eabi-gcc qemu-system-arm; do
  command -v $program >/dev/null || { echo "skipped: no $program here; tools/bootstrap.sh test installs it"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
flags="-std=gnu11 -mcpu=cortex-m3 -mthumb -O1 -DECT_SMALL -DNDEBUG -ffunction-sections -fdata-sections -I$root/src -I$root/firmware -I$root/firmware/cpu"
for source in "$root"/src/{od,slave}/*.c "$root"/src/{devices,profiles}/*/*.c "$root"/firmware/cpu/{cortex_m,memory,atomic}.c "$root/tests/check/memory.c"; do
  case "$source" in */signals.c | */modbus.c) continue ;; esac # the plant: no firmware has it
  # shellcheck disable=SC2086
  arm-none-eabi-gcc $flags -c "$source" -o "$work/$(echo "$source" | tr / _).o"
done
printf 'MEMORY\n{\n  FLASH (rx) : ORIGIN = 0, LENGTH = 4M\n  RAM (rwx) : ORIGIN = 0x20000000, LENGTH = 4M\n}\nSTACK_SIZE = 16K;\n' >"$work/memory.ld"
arm-none-eabi-gcc -mcpu=cortex-m3 -mthumb --specs=nosys.specs -nostartfiles -Wl,--gc-sections -T "$root/firmware/cpu/flash.ld" -L "$work" "$work"/*.o \
  -o "$work/memory.elf" 2>"$work/link" || { cat "$work/link"; exit 1; }
timeout 60 qemu-system-arm -M mps2-an385 -kernel "$work/memory.elf" -display none -monitor none -serial none \
  -semihosting-config enable=on,target=native 2>"$work/out" </dev/null || true # a program that hangs prints nothing

status=0
given=$(sed -n 's/^  "\([a-z0-9-]*\) [^ ]* [^ ]* \([0-9]*\) [0-9]*".*/\1 \2/p' "$root/firmware/CMakeLists.txt")
while read -r name memory; do
  needed=$(awk -v name="$name" '$1 == name {print $2}' "$work/out")
  verdict=ok
  { [ -z "$needed" ] || [ "$needed" -gt "$memory" ] || [ $((needed + 256)) -lt "$memory" ]; } && verdict=WRONG && status=1
  printf '%-18s takes %s, has %s: %s\n' "$name" "${needed:-nothing}" "$memory" "$verdict"
done <<<"$given"
[ $status -eq 0 ] || echo "the memory of a firmware is the fourth word of its line in firmware/CMakeLists.txt: the bytes taken, and some 32 to spare"
exit $status
