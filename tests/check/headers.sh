#!/usr/bin/env bash
# Each public header compiles alone, first in its file, in C and in C++; its declarations have the linkage of C.
# usage: headers.sh SRC      (public: all but internal.h, instance.h and bus/inprocess)
set -u
src=$1
for compiler in "${CC:-cc}" "${CXX:-clang++}"; do
  command -v "$compiler" >/dev/null || { echo "skipped: no $compiler here; tools/bootstrap.sh test installs clang"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
# In C++ a member that an initialiser omits is zero, as in C.
flags="-Wall -Wextra -Wno-missing-field-initializers -Werror -I$src -I$src/soes -fsyntax-only"

compiles() { # HEADER COMPILER ARGUMENT...
  local header=$1
  shift
  "$@" 2>"$work/log" && return 0
  echo "FAILED $header alone: $*"
  grep -m 3 'error' "$work/log"
  status=1
}

while read -r header; do
  printf '#include "%s"\ntypedef int not_empty;\n' "$header" >"$work/alone.c"
  cp "$work/alone.c" "$work/alone.cpp"
  # shellcheck disable=SC2086
  compiles "$header" "${CC:-cc}" -std=c11 -Wpedantic $flags "$work/alone.c"
  # shellcheck disable=SC2086
  compiles "$header" "${CXX:-clang++}" -std=c++17 $flags "$work/alone.cpp"
  if grep -v '^static' "$src/$header" | grep -qE '^(extern |[a-z][a-z0-9_ *]*\([^;{]*[;,]$)' && ! grep -q '^ECT_C_BEGIN$' "$src/$header"; then
    echo "FAILED $header: what it declares does not stand between ECT_C_BEGIN and ECT_C_END (wire/linkage.h)"
    status=1
  fi
done < <(cd "$src" && find . -name '*.h' ! -name internal.h ! -name instance.h ! -path './bus/inprocess/*' | sed 's|^\./||' | sort)
exit $status
