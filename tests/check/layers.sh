#!/usr/bin/env bash
# Refuses an #include that docs/DESIGN.md's table of layers does not allow.  usage: layers.sh SRC
set -eu
src=$1
status=0
checked=()

# check ROOM ALLOWED...: files below ROOM may include headers of their own room and of the ALLOWED ones.
check() {
  local room=$1 file header top ok
  checked+=("$room")
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
for port in "$src"/ports/*/; do
  case "$(basename "$port")" in
    virtual | soes_hal) ;;
    *) check "ports/$(basename "$port")" wire seams ;;
  esac
done
check check wire seams od esc sii
check esi wire seams od esc slave sii check
check facts wire seams od sii esi
check bus wire seams od esc slave sii devices ports
for room in "$src"/*/; do
  room=$(basename "$room")
  case " ${checked[*]} devices ports " in
    *" $room "*) ;;
    *) echo "src/$room has no line in $0 and in docs/DESIGN.md"; status=1 ;;
  esac
done
exit $status
