#!/usr/bin/env bash
# Refuses mutable objects at file scope: the core's libraries must have neither .data nor .bss.
# usage: no_mutable_static.sh LIBRARY...
set -eu
status=0
for library in "$@"; do
  # Constants that hold pointers stand in .data.rel.ro in position-independent code: that is not mutable.
  # Sanitizers and coverage add sections of their own, with names that do not match.
  found=$(objdump -t "$library" | awk '$4 ~ /^\.(data|bss)(\.[a-z_]|$)/ && $4 !~ /^\.data\.rel\.ro/ && $3 == "O" {print}' || true)
  found=$(printf '%s' "$found" | grep -v -E '__(gcov|asan|odr_asan|ubsan|sanitizer)|\*?\.L(ubsan|ASAN)|Lubsan_' || true)
  if [ -n "$found" ]; then
    echo "$(basename "$library") holds mutable static data:"
    printf '%s\n' "$found"
    status=1
  fi
done
exit $status
