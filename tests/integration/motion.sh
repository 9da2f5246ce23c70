#!/usr/bin/env bash
# The command line of the motion program: anything but a number in the range of its option is refused.  usage: motion.sh MOTION
set -u
motion=$1
failed=0

# refuses PATTERN ARGUMENT...
refuses() {
  local pattern=$1 said status
  shift
  said=$("$motion" "$@" 2>&1 >/dev/null)
  status=$?
  if [ $status = 1 ] && grep -q -- "$pattern" <<<"$said"; then return 0; fi
  printf "FAILED '%s'\n  expected: exit 1 with '%s'\n  got:      %d with '%s'\n  alone: %s %s\n" "$*" "$pattern" $status "$said" "$motion" "$*"
  failed=1
}

refuses "--way takes a number up to 2147483647, not 'abc'" --way abc nosuch
refuses "--way takes a number" --way nan nosuch
refuses "--way takes a number" --way 1e10 nosuch
refuses "--way takes a number" --way= nosuch
refuses "--speed takes a number" --speed 10turns nosuch
refuses "--speed and --acceleration take numbers above 0" --speed=-1 nosuch
refuses "--acceleration takes a number up to 4294967295" --acceleration inf nosuch
refuses "--method takes a number up to 127, not '291'" --method 291 nosuch
refuses "--method takes a number" --method=-1 nosuch
refuses "--method takes a number" --method 3x nosuch
refuses "--cycle-us takes 250, 500" --cycle-us 300 nosuch
refuses "--cycle-us takes a number up to 2500" --cycle-us 18446744073709551616 nosuch
refuses "name the interface" --way 1000
exit $failed
