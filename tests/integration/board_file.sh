#!/usr/bin/env bash
# A file for a firmware update, FILE.short for the beginning of its image, and tools/firmware-file.py by itself.
# usage: board_file.sh ECTWIN DEVICE IMAGE.bin ADDRESS FILE
set -eu
tool=$(cd "$(dirname "$0")/../../tools" && pwd)/firmware-file.py
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1" sii "$2" -o "$work/eeprom"
"$tool" "$3" "$4" "$work/eeprom" "$5"
head -c 6000 "$3" >"$work/image"
"$tool" "$work/image" "$4" "$work/eeprom" "$5.short"

shown=$("$tool" "$5")
echo "$shown"
[[ $shown == "vendor 0x00000E57 product 0x"*", $(stat -c %s "$3") bytes for address 0x00004000" ]]
"$tool" "$3" "$4" "$work/eeprom" "$work/other" 0x12345678
[[ $("$tool" "$work/other") == *" version 0x12345678, "* ]]

refused() { # PATTERN ARGUMENT...
  local pattern=$1
  shift
  if "$tool" "$@" >"$work/out" 2>&1; then echo "not refused: $*"; exit 1; fi
  grep -q -- "$pattern" "$work/out" || { cat "$work/out"; exit 1; }
}
printf x >>"$work/other"
refused "damaged: length or CRC-32" "$work/other"
refused "is no firmware file" "$3"
refused "is no content of an EEPROM" "$3" "$4" /dev/null "$work/none"
refused "cannot read" "$work/nothing"
refused "usage:" "$3" "$4"
