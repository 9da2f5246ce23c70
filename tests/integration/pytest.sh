#!/usr/bin/env bash
# The pytest plugin, as an ordinary user: the tests of the plugin, and the README's example.
# usage: pytest.sh ECTWIN [README|PLUGIN]       Exit 77: pytest is not installed.
set -u
build=$(dirname "$1")
only=${2:-}
root=$(cd "$(dirname "$0")/../.." && pwd)
python3 -c 'import pytest' 2>/dev/null || { echo "left out: pytest is not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ECTWIN=$1 PYTHONPATH=$root/python PATH=$build:$PATH XDG_RUNTIME_DIR=$work/runtime PYTHONDONTWRITEBYTECODE=1
mkdir "$XDG_RUNTIME_DIR" "$work/readme"

# Root becomes a user without any right: its own files are still its own.
as_a_user() {
  if [ "$(id -u)" = 0 ]; then
    unshare --user --map-user=1000 --map-group=1000 "$@"
  else
    "$@"
  fi
}
as_a_user sh -c '[ "$(id -u)" != 0 ] && grep -q "CapEff:.*0000000000000000" /proc/self/status' || { echo "this is no ordinary user"; exit 1; }

failed=0
cd "$work" || exit 1
if [ "$only" != PLUGIN ]; then
  awk '/^# test_sensor.py$/ { on = 1 } on && /^```/ { exit } on' "$root/README.md" >"$work/readme/test_sensor.py"
  [ "$(grep -c '^def test_' "$work/readme/test_sensor.py")" = 3 ] || { echo "README.md has no three tests any more"; exit 1; }
  as_a_user python3 -m pytest -q -p ectwin.pytest_plugin -p no:cacheprovider "$work/readme" || failed=1
fi
if [ "$only" != README ]; then
  as_a_user python3 -m pytest -q -p pytester -p ectwin.pytest_plugin -p no:cacheprovider -c /dev/null --rootdir "$work" \
    --basetemp "$work/temp" "$root/tests/integration/test_plugin.py" || failed=1
fi
exit $failed
