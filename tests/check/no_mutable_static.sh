#!/usr/bin/env bash
# Refuses mutable objects at file scope: compiled plainly, the core has neither .data nor .bss. SOES's names are variables: what gives
# or takes them may have some (src/soes, ports/soes_hal).
# usage: no_mutable_static.sh SRC
set -eu
src=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
for source in "$src"/{od,esc,slave,sii}/*.c "$src"/{profiles,devices,ports}/*/*.c; do
  case "$source" in */ports/soes_hal/*) continue ;; esac
  # Not position-independent, so that constants that hold addresses are in .rodata.
  ${CC:-cc} -std=c11 -O1 -fno-pic -DNDEBUG -I"$src" -c "$source" -o "$work/object.o"
  found=$(objdump -t "$work/object.o" | awk '/ O / && $0 ~ / \.(data|bss)/')
  if [ -n "$found" ]; then
    echo "${source#"$src"/} holds mutable static data:"
    printf '%s\n' "$found"
    status=1
  fi
done
exit $status
