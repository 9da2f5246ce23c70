#!/usr/bin/env bash
# Text that a firmware on a Cortex-M4 links of the slave stack, core and each service and port by itself, against tests/budget/size.
# usage: size.sh
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
root=$(dirname "$here")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
for source in "$root"/src/{od,slave}/*.c "$root"/src/ports/{lan9252,mmio,flash}/*.c; do
  arm-none-eabi-gcc -std=c11 -mcpu=cortex-m4 -mthumb -Os -DNDEBUG -ffunction-sections -fdata-sections -Wall -Wextra -Werror \
    -I"$root/src" -c "$source" -o "$work/$(basename "$(dirname "$source")")_$(basename "$source" .c).o"
done

# linked SYMBOL...: text, data and bss of what these need.
linked() {
  arm-none-eabi-ld -r --gc-sections -e "$1" $(printf -- '-u %s ' "$@") "$work"/*_*.o -o "$work/linked"
  arm-none-eabi-nm "$work/linked" | awk '{print $NF}' >"$work/symbols"
  for symbol in "$@"; do
    grep -qx "$symbol" "$work/symbols" || { echo "there is no $symbol" >&2; exit 1; }
  done
  arm-none-eabi-size "$work/linked" | awk 'END {print $1, $2, $3}'
}

core=
while read -r name limit symbols; do
  case "$name" in '' | '#'*) continue ;; esac
  # shellcheck disable=SC2086
  read -r text data bss <<<"$(linked $symbols $core)"
  if [ -z "$core" ]; then
    core=$symbols
    below=$text
  else
    text=$((text - below))
  fi
  verdict=ok
  { [ "$text" -le 0 ] || [ "$text" -gt "$limit" ] || [ "$data" -ne 0 ] || [ "$bss" -ne 0 ]; } && verdict=OVER && status=1
  printf 'Cortex-M4 -Os %-11s text %6d (limit %d) data %d bss %d %s\n' "$name" "$text" "$limit" "$data" "$bss" "$verdict"
done <"$here/budget/size"
exit $status
