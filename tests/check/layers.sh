#!/usr/bin/env bash
# Refuses an #include that docs/DESIGN.md's table of layers does not allow.  usage: layers.sh SRC
set -eu
src=$1
status=0

# check ROOM ALLOWED...: files below ROOM may include headers of their own room and of the ALLOWED ones.
check() {
  local room=$1 file header top ok
  shift
  while IFS=: read -r file header; do
    top=${header%%/*}
    ok=no
    case "$header" in "$room"/*) ok=yes ;; esac
    for allowed in "$@"; do
      [ "$top" = "$allowed" ] && ok=yes
    done
    if [ "$ok" = no ]; then
      echo "$file includes \"$header\": $room may include $room ${*:-and nothing else of ours}"
      status=1
    fi
  done < <(grep -rHoP '^\s*#\s*include\s+"\K[^"]+' "$src/$room" | sed "s|^$src/||")
}

check wire
check od wire
check esc wire
check seams wire od
check slave wire seams od
check sii wire seams od
check soes wire seams od slave
for device in "$src"/devices/*/; do
  check "devices/$(basename "$device")" wire seams od
done
check ports/virtual wire seams esc
check ports/soes_hal wire seams esc sii soes bus
for port in template lan9252 mmio flash linux; do
  check "ports/$port" wire seams
done
check check wire seams od esc sii
check esi wire seams od esc slave sii check
check facts wire seams od sii esi
check bus wire seams od esc slave sii devices ports
exit $status
