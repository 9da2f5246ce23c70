# shellcheck shell=bash
# Sourced by the tests in bash: a comparison, and the exit code of the test in $failed.
# shellcheck disable=SC2034
failed=0

on_failure() { :; } # a test replaces it to print more

check() { # TITLE EXPECTED ACTUAL
  [ "$2" = "$3" ] && return 0
  printf 'FAILED %s\n  expected: %s\n  got:      %s\n' "$1" "$2" "$3"
  on_failure
  failed=1
}

# map_of COMMAND...: the output of a COMMAND that runs SOEM's `slaveinfo IFACE -map`. It gives a frame 2 ms: until a busy machine lets one slave
# reach SAFEOP and both its sizes be read, it runs again, ten times at most.
map_of() {
  local map
  for _ in 1 2 3 4 5 6 7 8 9 10; do
    map=$("$@" 2>/dev/null)
    grep -q ' State: 4' <<<"$map" && ! grep -q 'put size: 0bits' <<<"$map" && break
  done
  echo "$map"
}

# run_cases CASE...: ends the script after these functions, or after the one that $only names: with 0, with 1 after a failure. Each runs in a
# process, a folder $work and a runtime folder of its own, $at_a_time (4) side by side, because most of them wait.
run_cases() {
  local all=$work count=0 case_name number
  chmod 711 "$all" # a case may open its folder to a second user
  for case_name in "$@"; do
    [ -z "${only:-}" ] || [ "$only" = "$case_name" ] || continue
    count=$((count + 1))
    work=$all/$count
    mkdir -m 700 "$work" && mkdir "$work/runtime"
    while [ "$(jobs -rp | wc -l)" -ge "${at_a_time:-4}" ]; do wait -n; done
    {
      export XDG_RUNTIME_DIR=$work/runtime
      "$case_name"
      echo $failed >"$work.failed"
    } >"$work.log" 2>&1 &
  done
  wait
  work=$all # the folder that the script removes
  for ((number = 1; number <= count; number++)); do
    cat "$all/$number.log"
    [ "$(cat "$all/$number.failed")" = 0 ] || failed=1
  done
  echo "$count cases"
  [ $count -gt 0 ] || failed=1
  exit $failed
}
