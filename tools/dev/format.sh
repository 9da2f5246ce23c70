#!/usr/bin/env bash
# Lays out all C files as .clang-format says.  usage: tools/dev/format.sh [--check]
# --check changes nothing, names the files and exits with 1. Needs clang-format 19, for each version has its own idea; exits with 77
# where there is none.
set -eu
cd "$(dirname "$0")/../.."
command -v clang-format-19 >/dev/null || { echo "clang-format-19 is not installed: the layout of the files is not looked at"; exit 77; }
mapfile -t files < <(find src programs tools tests examples firmware cmake -name '*.[ch]' | sort)
if [ "${1:-}" = --check ]; then
  clang-format-19 --dry-run --Werror "${files[@]}" 2>&1 | sed -n 's/:.*error: code should be.*//p' | uniq | sed 's/$/ is not laid out as .clang-format says: tools\/dev\/format.sh/'
  exit "${PIPESTATUS[0]}"
fi
clang-format-19 -i "${files[@]}"
