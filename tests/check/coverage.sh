#!/usr/bin/env bash
# Branch coverage of the core by the unit tests; fails below the floors in tests/budget/coverage.
# usage: coverage.sh BUILD
set -eu
build=$1
here=$(cd "$(dirname "$0")/.." && pwd)
root=$(dirname "$here")
status=0
while read -r room floor; do
  case "$room" in '' | '#'*) continue ;; esac
  got=$(gcovr --root "$root" --object-directory "$build" --filter "$root/src/$room/" --exclude-throw-branches \
    --json-summary 2>/dev/null | python3 -c 'import json, sys; print(json.load(sys.stdin)["branch_percent"])')
  verdict=ok
  awk -v g="$got" -v f="$floor" 'BEGIN { exit !(g + 0 < f + 0) }' && verdict=BELOW && status=1
  printf 'branch coverage src/%-8s %5s %%  (floor %s %%) %s\n' "$room" "$got" "$floor" "$verdict"
done <"$here/budget/coverage"
exit $status
