#!/usr/bin/env bash
# Text size of the slave core on a Cortex-M4, against tests/budget/size.  usage: size.sh
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
root=$(dirname "$here")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
while read -r name limit files; do
  case "$name" in '' | '#'*) continue ;; esac
  mkdir "$work/$name"
  for file in $(eval echo "$files"); do
    for source in "$root"/src/$file; do
      arm-none-eabi-gcc -std=c11 -mcpu=cortex-m4 -mthumb -Os -DNDEBUG -ffunction-sections -fdata-sections \
        -Wall -Wextra -Werror -I"$root/src" -c "$source" -o "$work/$name/$(echo "$source" | tr / _).o"
    done
  done
  read -r text data bss < <(arm-none-eabi-size -t "$work/$name"/*.o | awk 'END {print $1, $2, $3}')
  verdict=ok
  { [ "$text" -gt "$limit" ] || [ "$data" -ne 0 ] || [ "$bss" -ne 0 ]; } && verdict=OVER && status=1
  printf 'Cortex-M4 -Os %-11s text %6d (limit %d) data %d bss %d %s\n' "$name" "$text" "$limit" "$data" "$bss" "$verdict"
done <"$here/budget/size"
exit $status
