#!/usr/bin/env bash
# --in-kernel while the twins' process is stopped at random: test_stopped, and the counters behind it.
# usage: in_kernel_stopped.sh ECTWIN_OF_TESTS TEST_STOPPED CYCLES [SEED]
# Needs root with CAP_BPF; without these the test is skipped with its reason (77).
set -u
ectwin=$1 stopped=$2 cycles=$3 seed=${4:-1}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_RUNTIME_DIR=$work
# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

if ! "$ectwin" with --in-kernel tally -- true 2>"$work/err"; then
  echo "skipped: $(grep in-kernel "$work/err")"
  exit 77
fi

counted() { # NAME: a counter of the run
  sed -n "s/.*\"$1\":\([0-9]*\).*/\1/p" "$work/stats"
}

# Without a PID namespace of its own: the test finds the process to stop.
# shellcheck disable=SC2016
"$ectwin" with --in-kernel --leave-children tally -- sh -c '"$1" "$2" $PPID "$3" "$4" && "$0" stats --json >"$5/stats"' \
  "$ectwin" "$stopped" '{}' "$cycles" "$seed" "$work" >"$work/out" 2>&1
check "no image is torn, and none is lost" 0 "$?"
cat "$work/out"
[ $failed = 0 ] || exit 1
check "each frame gets its reply" "$(counted frames)" "$(counted answered)"
check "many of its cycles get their replies in the kernel" yes "$([ "$(counted in_kernel)" -ge 100 ] && echo yes)"
echo "$(counted in_kernel) replies in the kernel"
exit $failed
