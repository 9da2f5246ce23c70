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
