#!/usr/bin/env bash
# Lays out all C files by .clang-format.  usage: tools/dev/format.sh [--check]
# --check changes no file, names the files and exits with 1. Needs clang-format 19, because each version has another layout; exits
# with 77 if it is not installed.
set -eu
cd "$(dirname "$0")/../.."
command -v clang-format-19 >/dev/null || { echo "clang-format-19 is not installed: the layout of the files is not checked"; exit 77; }
mapfile -t files < <(find src programs tools tests examples firmware cmake -name '*.[ch]' | sort)
if [ "${1:-}" = --check ]; then
  clang-format-19 --dry-run --Werror "${files[@]}" 2>&1 | sed -n 's/:.*error: code should be.*//p' | uniq | sed 's/$/ is not laid out by .clang-format: tools\/dev\/format.sh/'
  exit "${PIPESTATUS[0]}"
fi
clang-format-19 -i "${files[@]}"
