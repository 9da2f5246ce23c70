#!/usr/bin/env bash
# Branch coverage of the core by the unit tests; fails below the floors in tests/budget/coverage.
# usage: coverage.sh BUILD
set -eu
build=$1
here=$(cd "$(dirname "$0")/.." && pwd)
root=$(dirname "$here")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The search is limited to BUILD/src: CMake's own trial programs, elsewhere in BUILD, have coverage files without a source.
gcovr --root "$root" --filter "$root/src/" --exclude-throw-branches --json-summary "$work/summary" \
  "$build/src" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
python3 - "$work/summary" "$here/budget/coverage" <<'PYTHON'
import json
import sys

files = json.load(open(sys.argv[1]))["files"]
failed = False
for line in open(sys.argv[2]):
    if not line.strip() or line.startswith("#"):
        continue
    room, floor = line.split()
    mine = [f for f in files if f["filename"] == f"src/{room}" or f["filename"].startswith(f"src/{room}/")]
    total = sum(f["branch_total"] for f in mine)
    got = 100 * sum(f["branch_covered"] for f in mine) / total if total else 0
    below = got < float(floor)
    failed |= below
    print(f"branch coverage src/{room:10} {got:5.1f} %  (floor {floor} %) {'BELOW' if below else 'ok'}")
sys.exit(failed)
PYTHON
