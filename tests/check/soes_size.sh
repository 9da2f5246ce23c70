#!/usr/bin/env bash
# Flash of a SOES application on SOES's stack and on ours: SOES's own demo, Cortex-M4 -Os, linked with newlib-nano, without start-up
# code. Not part of the test run, because SOES is not in this tree.  usage: soes_size.sh SOES     a checkout of SOES
set -eu
[ $# -eq 1 ] || { sed -n 's/^# //p' "$0"; exit 1; }
root=$(cd "$(dirname "$0")/../.." && pwd)
soes=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/app" "$work/soes" "$work/ours"
demo=$soes/applications/linux_lan9252demo
cp "$demo"/{ecat_options.h,slave_objectlist.c,utypes.h} "$work/app"
sed '/printf\|stdio/d' "$demo/main.c" >"$work/app/main.c" # no output on a board
cat >"$work/app/hal.c" <<'HAL'
#include "ecat_slv.h"
static volatile uint8_t *const window = (volatile uint8_t *)0x60000000;
void ESC_read(uint16_t address, void *buf, uint16_t len)
{
    for (uint8_t *to = buf; len > 0; len--)
        *to++ = window[address++];
}
void ESC_write(uint16_t address, void *buf, uint16_t len)
{
    for (const uint8_t *from = buf; len > 0; len--)
        window[address++] = *from++;
}
void ESC_init(const esc_cfg_t *cfg)
{
    (void)cfg;
}
HAL

cpu="-mcpu=cortex-m4 -mthumb"
# stack NAME INCLUDE... -- SOURCE...: compiled, linked, and the text of each object
stack() {
  local name=$1 include=()
  shift
  while [ "$1" != -- ]; do include+=("-I$1"); shift; done
  shift
  for source in "$work"/app/*.c "$@"; do
    # shellcheck disable=SC2086
    arm-none-eabi-gcc -std=gnu11 $cpu -Os -DNDEBUG -ffunction-sections -fdata-sections -w -I"$work/app" "${include[@]}" -c "$source" \
      -o "$work/$name/$(basename "$(dirname "$source")")_$(basename "$source" .c).o"
  done
  # shellcheck disable=SC2086
  arm-none-eabi-gcc $cpu --specs=nano.specs --specs=nosys.specs -nostartfiles -Wl,--gc-sections -Wl,-e,main -Wl,-Map="$work/$name.map" \
    "$work/$name"/*.o -o "$work/$name.elf"
  echo "== $name"
  awk '/^Linker script and memory map/ {on = 1} !on {next}
       /^ \.(text|rodata)/ {if (NF == 4) add($3, $4); else pending = 1; next}
       pending {if (NF == 3) add($2, $3); pending = 0}
       function add(size, file) {sub(/.*[\/(]/, "", file); sub(/\)$/, "", file); print file, size}' "$work/$name.map" |
    python3 -c 'import collections, sys
size = collections.Counter()
for name, number in (line.split() for line in sys.stdin):
    size[name] += int(number, 16)
print("\n".join(f"{number:6} {name}" for name, number in size.most_common() if number))'
  arm-none-eabi-size "$work/$name.elf"
}

stack soes "$soes/soes" "$soes/soes/include/sys/gcc" -- "$soes"/soes/{esc,esc_coe,esc_foe,esc_eep,ecat_slv}.c
stack ours "$root/src/soes" "$root/src" -- "$root"/src/{soes,slave,od}/*.c
