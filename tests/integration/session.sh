#!/usr/bin/env bash
# How twins start, run and end: awkward beginnings, faults of the wire, rights, the private network.
# usage: session.sh ECTWIN [CASE]
# Runs everything inside namespaces of its own; needs no root where user namespaces are allowed.
set -u
ectwin=$1
only=${2:-}
here=$(cd "$(dirname "$0")" && pwd)

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone: $0 $ectwin $case_name"; }

says() { # TITLE PATTERN: what the last command wrote to its standard error
  grep -q -- "$2" "$work/err" || check "$1: it says so" "$2" "$(cat "$work/err")"
}

wait_for() { # FILE: until there is something in it, 10 s at most
  for _ in $(seq 1200); do [ -s "$1" ] && return; sleep 0.1; done
}

# in_network SCRIPT: with a veth pair tw0, tw1; $ectwin, $work and $here are there.
in_network() {
  ectwin=$ectwin work=$work here=$here master=${master:-} unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up || exit 9
    wait_for() { for _ in $(seq 1200); do [ -s "$1" ] && return; sleep 0.1; done; }
    rm -f "$work/a" "$work/b" # what another case has left there is nothing to go by
    '"$1"
}

its_version() {
  check "--version" yes "$("$ectwin" --version | grep -Eq '^ectwin [0-9]+\.[0-9]+\.[0-9]+$' && echo yes)"
}

# A descriptor that is closed at the start must not become the wire's or a file's, with what is printed going there.
closed_streams() {
  in_network '
    "$ectwin" run -i tw0 fzm1 <&- >&- 2>&- & pid=$!
    for _ in $(seq 100); do [ -n "$(python3 "$here/frames.py" tw1 1 1 0.2)" ] && break; [ -e /proc/$pid ] || break; done
    python3 "$here/frames.py" tw1 3 200 | cut -d" " -f1,2
    kill $pid; wait $pid; echo $?' >"$work/out"
  check "run: without standard streams it answers, and sends nothing of its own" "0 1 1 1 2 1 0" "$(xargs <"$work/out")"
  check "with: the command has them closed, or at nothing" 5 "$("$ectwin" with fzm1 -- sh -c 'exit 5' <&- 2>&-; echo $?)"
  "$ectwin" list >&-
  check "list: without standard output" 0 $?
}

# glibc prints the margin of a text before an option that is too long for its column, when its buffer is almost full.
help_has_short_options() {
  local commands
  commands=$("$ectwin" --help | grep -o 'ectwin  *[a-z-]*' | awk '$2 ~ /^[a-z]/ {print $2}' | sort -u)
  check "--help lists the commands" yes "$([ "$(echo "$commands" | wc -l)" -gt 20 ] && echo yes)"
  for command in $commands; do
    check "$command --help: each option leaves room for its text (24 characters)" "" \
      "$("$ectwin" "$command" --help | grep -E '^ +(-[^ ]+,? ?)+$')"
  done
}

memory_of_many_twins() {
  local pid
  [ -e /sys/kernel/mm/transparent_hugepage/enabled ] || { echo "no huge pages here: not tried"; return; }
  "$ectwin" run --quiet --udp 127.0.0.1:0 'fzm1*1000' >"$work/out" 2>"$work/err" & pid=$!
  wait_for "$work/out"
  check "run: many twins are in memory for huge pages" yes "$(grep -q '^VmFlags:.* hg' /proc/$pid/smaps && echo yes)"
  kill $pid
  wait $pid
}

output_that_cannot_be_written() {
  for arguments in "list" "--help" "run --help" "sii fzm1"; do
    # shellcheck disable=SC2086
    "$ectwin" $arguments >/dev/full 2>"$work/err"
    check "$arguments: standard output on a full disk" 2 $?
    says "$arguments" "No space left on device"
  done
  in_network 'timeout 300 "$ectwin" run -i tw0 fzm1 >/dev/full 2>"$work/err"; echo $?' >"$work/out"
  check "run: a ready line that cannot be written" 2 "$(cat "$work/out")"
  says "run" "No space left on device"
  check "list: a reader that stops is none of its business" "" "$("$ectwin" list 2>&1 >/dev/null | head -c0; "$ectwin" list 2>&1 | true)"
}

# As a shell starts what it runs in the background.
ignored_interrupt() {
  in_network '
    trap "" INT
    "$ectwin" run -i tw0 fzm1 >"$work/ready" & pid=$!
    wait_for "$work/ready"
    kill -INT $pid; wait $pid; echo $?' >"$work/out"
  check "run: SIGINT ends it though it was inherited as ignored" 0 "$(cat "$work/out")"
  in_network '
    nohup "$ectwin" run -i tw0 fzm1 >"$work/ready2" 2>/dev/null & pid=$!
    wait_for "$work/ready2"
    kill -HUP $pid; sleep 0.3; [ -e /proc/$pid ] && echo lives
    kill $pid; wait $pid; echo $?' >"$work/out"
  check "run: under nohup SIGHUP does not end it" "lives 0" "$(xargs <"$work/out")"
}

wrong_options() {
  while read -r arguments; do
    # shellcheck disable=SC2086
    "$ectwin" $arguments >/dev/null 2>"$work/err"
    check "'$arguments'" 1 $?
    check "'$arguments': says why, in a line" yes "$(head -1 "$work/err" | grep -q '^ectwin [a-z]*: .\{20\}' && echo yes)"
  done <<'END'
run -i a -i b fzm1
run -i a -o b -o c fzm1
run -i a -o a fzm1
run -o a fzm1
run -i a --delay 5 --delay-us 0 fzm1
run -i a --drop 101 fzm1
run -i a --realtime=0 fzm1
run -i a --realtime=100 fzm1
with --iface lo fzm1 -- true
with --iface a/b fzm1 -- true
with --iface 1234567890123456 fzm1 -- true
with --iface a,a fzm1 -- true
with --iface a,b,c fzm1 -- true
with --iface ectwin1 fzm1 -- true
with --serial 3:5 fzm1,fzm1 -- true
with --serial 0:5 fzm1 -- true
with --alias 65535 fzm1,fzm1 -- true
with --alias 1:0 fzm1 -- true
END
}

# late_answers PERCENT COUNT: what comes back of so many, 20 ms apart, and what the twin counted; answers are 100 ms late.
# Prints whether all came back in order but for those that a busy machine found too old, and how many were in time.
late_answers() {
  # shellcheck disable=SC2016
  "$ectwin" with --delay "$1" --delay-us 100000 --seed 5 fzm1 -- sh -c 'python3 "$2/frames.py" {} "$3" 20; "$1" stats --json' \
    sh "$ectwin" "$here" "$2" 2>/dev/null | python3 -c '
import json
import sys

lines = sys.stdin.read().splitlines()
stale = json.loads(lines[-2])["stale"]
back = [[int(field) for field in line.split()] for line in lines[:-2]]
numbers = [number for number, counter, ms in back]
whole = numbers == sorted(set(numbers)) and len(numbers) + stale == int(sys.argv[1])
print("whole" if whole else numbers, sum(ms < 100 for number, counter, ms in back))' "$2"
}

delayed_replies() {
  check "--delay: all come back, in order, none in time" "whole 0" "$(late_answers 100 12)"
  check "--delay: none is lost between late ones" whole "$(late_answers 30 40 | cut -d' ' -f1)"
}

# expect_of_fault FAULT EXPECTED: compares the replies to twelve frames over three slaves, 5 ms apart, as "number counter". Python reports
# no leaks at its end, which would take 0.2 s for each fault.
expect_of_fault() {
  check "--fault $1" "$2" "$(ASAN_OPTIONS=detect_leaks=0 "$ectwin" with --in-process --virtual-time --fault "$1" fzm1,fzm1,fzm1 -- python3 "$here/frames.py" {} 12 5 6 2>/dev/null |
    cut -d" " -f1,2 | xargs)"
}

faults_on_wires() {
  expect_of_fault "duplicate every 5 wire 2" "0 3 1 3 2 3 3 3 4 3 4 3 5 3 6 3 7 3 8 3 9 3 9 3"
  expect_of_fault "reorder every 5 wire 2 back" "0 3 1 3 2 3 3 3 5 3 4 3 6 3 7 3 8 3 10 3 9 3 11 3"
  expect_of_fault "reorder frame 12 wire 2 back" "0 3 1 3 2 3 3 3 4 3 5 3 6 3 7 3 8 3 9 3 10 3 11 3"
  expect_of_fault "counter -1 every 4 wire 3" "0 3 1 3 2 3 3 2 4 3 5 3 6 3 7 2 8 3 9 3 10 3 11 2"
  expect_of_fault "drop every 2 wire 2" "0 3 2 3 4 3 6 3 8 3 10 3"
  expect_of_fault "delay 50000us frame 3 wire 1 back" "0 3 1 3 2 3 3 3 4 3 5 3 6 3 7 3 8 3 9 3 10 3 11 3"
}

# Each twin replies to the replies of the other: the frame is destroyed, and does not circulate for ever.
two_ends_that_answer() {
  in_network '
    ticks() { cut -d" " -f14,15 /proc/$1/stat | tr " " +; }
    "$ectwin" run -i tw0 fzm1 >"$work/a" 2>"$work/err" & a=$!
    "$ectwin" run -i tw1 fzm1 >"$work/b" 2>"$work/err2" & b=$!
    wait_for "$work/a"; wait_for "$work/b"
    python3 "$here/frames.py" tw0 1 1 2
    sleep 1
    before=$(($(ticks $a) + $(ticks $b))); sleep 1; after=$(($(ticks $a) + $(ticks $b)))
    echo $((after - before)) >"$work/out"
    kill $a $b; wait' >/dev/null
  cat "$work/err2" >>"$work/err"
  says "run: two on one wire" "a program at the other end of 'tw[01]' replies to EtherCAT frames too"
  check "run: the frame is destroyed, both are idle again" yes "$([ "$(cat "$work/out")" -le 2 ] && echo yes)"
}

names_of_the_private_network() {
  check "with: --iface" "eth7 eth7 eth7" "$("$ectwin" with --iface eth7 fzm1 -- sh -c 'echo {} $ECTWIN_IFACE; ls /sys/class/net | grep eth' \
    2>/dev/null | xargs)"
  check "with: --iface with two names" "a b b{2} a b" "$("$ectwin" with --iface a,b fzm1 -- sh -c \
    'echo {} {2} $ECTWIN_IFACE2"{""2}" $ECTWIN_IFACE $ECTWIN_IFACE2' 2>/dev/null)"
  check "with: two wires in the ready line" '{"event":"ready","iface":"a","iface2":"b","slaves":1}' \
    "$("$ectwin" with --iface a,b fzm1 -- true 2>&1)"
  "$ectwin" with fzm1 -- ls /sys/class/net >"$work/out" 2>"$work/err"
  if grep -q "cannot be mounted" "$work/err"; then
    echo "SKIPPED /sys of the private network: no sysfs may be mounted here"
  else
    check "with: /sys/class/net shows the private network" "ecat0 ectwin0 lo" "$(xargs <"$work/out")"
  fi
}

runs() { # COMMAND LINE: whether a process has exactly this one; "no" after 3 s at most
  for _ in $(seq 1200); do pgrep -xf "$1" >/dev/null || { echo no; return; }; sleep 0.1; done
  echo yes
}

# Seconds of sleep that no other run of this script uses: NUMBER in 1..9.
unique() {
  echo "$((1000000 + $$))$1"
}

# Processes that a command leaves in the background when it ends.
processes_of_the_command() {
  # shellcheck disable=SC2016
  "$ectwin" with fzm1 -- sh -c 'sleep $1 & (sh -c "trap : TERM; sleep $2; sleep $3" &); setsid sleep $4 & exit 6' \
    sh "$(unique 1)" "$(unique 2)" "$(unique 3)" "$(unique 4)" 2>/dev/null
  check "with: status of a command that leaves children" 6 $?
  for child in 1 2 3 4; do
    check "with: the child has ended too" no "$(runs "sleep $(unique $child)")"
  done
  "$ectwin" with --leave-children fzm1 -- sh -c 'sleep 300 >/dev/null 2>&1 & echo $! >"$1"' sh "$work/pids" 2>/dev/null
  check "with: --leave-children" yes "$(kill "$(cat "$work/pids")" && echo yes)"
}

# SIGKILL leaves no children, and the next twin removes the dead socket.
killed_at_once() {
  local pid slave
  mkdir -p "$work/killed"
  for slave in fzm1 "--external=sh -c 'sleep $(unique 5); :'"; do
    XDG_RUNTIME_DIR=$work/killed "$ectwin" with "$slave" -- sh -c 'setsid sleep $1 & sleep $2; :' sh "$(unique 6)" "$(unique 7)" 2>"$work/ready" &
    pid=$!
    for _ in $(seq 1200); do pgrep -xf "sleep $(unique 6)" >/dev/null && break; sleep 0.1; done
    check "with $slave: its child runs" yes "$(pgrep -xf "sleep $(unique 6)" >/dev/null && echo yes)"
    kill -9 $pid
    wait $pid 2>/dev/null
    check "with $slave: killed, its children have ended" "no no no" "$(runs "sleep $(unique 6)") $(runs "sleep $(unique 7)") $(runs "sleep $(unique 5)")"
  done
  check "with: killed, it leaves its socket" 1 "$(find "$work/killed/ectwin" -type s | wc -l)"
  XDG_RUNTIME_DIR=$work/killed "$ectwin" with fzm1 -- true 2>/dev/null
  check "with: the next one removes it" 0 "$(find "$work/killed/ectwin" -type s | wc -l)"
}

# A signal to ectwin reaches the command, which decides.
signals_reach_the_command() {
  rm -f "$work/out"
  "$ectwin" with fzm1 -- sh -c 'trap "exit 9" TERM; echo $$ $PPID; while :; do sleep 0.1; done' >"$work/out" 2>/dev/null &
  local pid=$!
  wait_for "$work/out"
  kill -TERM $pid; wait $pid
  check "with: SIGTERM reaches the command, process 2 of its namespace" "9 2 1" "$? $(cat "$work/out")"
}

# Words 4 alias, 8 vendor, 0xA product code, 0xC revision, 0xE serial number.
identities() {
  check "identity: for all, then for one" "0005 0e57 0007 000a | 0100 1234 0009 004d | 0007 0e57 0007 000c" \
    "$("$ectwin" with --vendor-id 2:0x1234 --revision 7 --revision 2:9 --serial 010 --serial 2:77 --alias 5 --alias 2:0x100 \
      fzm1,fzm1,fzm1 -- python3 "$here/eeprom.py" {} 1:4 1:8 1:0xC 1:0xE 2:4 2:8 2:0xC 2:0xE 3:4 3:8 3:0xC 3:0xE 2>/dev/null |
      sed 's/ /&| /8; s/ /&| /4')"
}

eeprom_writes() {
  local store="$work/eeprom"
  "$ectwin" with --store "$store" fzm1,fzm1 -- python3 "$here/eeprom.py" {} 2:4=0x1234 2:0x3F0=0xBEEF 2>/dev/null
  check "--store: the EEPROM is as the master left it" "0000 1234 beef" \
    "$("$ectwin" with --store "$store" fzm1,fzm1 -- python3 "$here/eeprom.py" {} 1:4 2:4 2:0x3F0 2>/dev/null)"
  check "--store: an option that is new is the newer wish" "0042 beef" \
    "$("$ectwin" with --store "$store" --alias 2:0x42 fzm1,fzm1 -- python3 "$here/eeprom.py" {} 2:4 2:0x3F0 2>/dev/null)"
  check "--store: without it the EEPROM is as made" 0000 \
    "$("$ectwin" with fzm1,fzm1 -- python3 "$here/eeprom.py" {} 2:4 2>/dev/null)"
  echo nonsense >"$store/fzm1-1.sii"
  "$ectwin" with --store "$store" fzm1 -- true 2>"$work/err"
  check "--store: a file that is no EEPROM content" 2 $?
  says "--store" "no EEPROM content"
}

counters() {
  # shellcheck disable=SC2016
  "$ectwin" with --drop 50 --seed 3 fzm1 -- sh -c 'python3 "$2/frames.py" {} 40 20 2 | wc -l; "$1" stats --json; "$1" stats' \
    sh "$ectwin" "$here" >"$work/out" 2>/dev/null
  check "stats: what came, what went back, what was dropped" yes "$(python3 - "$work/out" <<'END'
import json
import sys

back, counters, histogram = [json.loads(line) for line in open(sys.argv[1]).readlines()[:3]]
whole = counters["frames"] == 40 and counters["answered"] == back == sum(histogram["answers"])
rest = counters["dropped"] + counters["stale"] == 40 - back and 0 < back < 40
print("yes" if whole and rest and len(histogram["edges_us"]) + 1 == len(histogram["answers"]) else (back, counters, histogram))
END
)"
  check "stats: for people" "40 frames" "$(grep -o '40  frames' "$work/out" | xargs)"
  "$ectwin" stats -s /no/such/socket 2>"$work/err"
  check "stats: without a twin" 2 $?
}

# The example masters: a device of another kind, an interface that does not exist, a wire without slaves.
example_masters_at_the_wrong_place() {
  local masters
  masters=$(dirname "$ectwin")
  [ -x "$masters/ectwin-plc" ] || { echo "SKIPPED example masters: not built"; return; }
  "$ectwin" with --in-process --virtual-time fzm1 -- "$masters/ectwin-controller" {} >/dev/null 2>"$work/err"
  check "controller: a sensor" 3 $?
  says "controller" "no base unit"
  "$ectwin" with --in-process --virtual-time vr-bu-ect-map7 -- "$masters/ectwin-plc" {} >/dev/null 2>"$work/err"
  check "plc: a base unit" 3 $?
  says "plc" "is no FZM1"
  for option in "ectwin-controller --seconds 1s" "ectwin-controller --periodic 51201" "ectwin-plc --scene 0x1" \
    "ectwin-plc --measurements -1"; do
    # shellcheck disable=SC2086
    "$masters"/$option lo 2>"$work/err"
    check "$option: no number" 1 $?
    says "$option" "takes a number up to"
  done
  for master in "ectwin-controller --seconds 1" ectwin-plc; do
    # shellcheck disable=SC2086
    "$masters"/$master nosuch 2>"$work/err"
    check "$master: an interface that is not there" 2 $?
    says "$master" "no network interface 'nosuch'"
    unshare -U "$masters"/$master lo 2>"$work/err"
    check "$master: without the right" 2 $?
    says "$master" "CAP_NET_RAW"
    master="$masters/$master" in_network '$master tw0 >/dev/null 2>"$work/err"; echo $?' >"$work/out"
    check "$master: nobody answers" 3 "$(cat "$work/out")"
    says "$master" "no slave answers on 'tw0'"
  done
}

# Rights of a running twin: none, or to take its interface down.
rights_of_a_running_twin() {
  in_network '
    ip link set tw0 down
    for iface in tw0 tw1; do
      rm -f "$work/ready"
      "$ectwin" run -i $iface fzm1 >"$work/ready" & pid=$!
      wait_for "$work/ready"
      sed -n "s/^\(CapPrm\|CapEff\|CapInh\|CapBnd\|CapAmb\|NoNewPrivs\):\s*0*\([0-9a-f]\)/\1 \2/p" /proc/$pid/status
      kill $pid; wait $pid; echo $?
    done' | xargs >"$work/out"
  check "run: CAP_NET_ADMIN to take its interface down, then nothing at all" \
    "CapInh 0 CapPrm 1000 CapEff 1000 CapBnd 0 CapAmb 0 NoNewPrivs 1 0 CapInh 0 CapPrm 0 CapEff 0 CapBnd 0 CapAmb 0 NoNewPrivs 1 0" \
    "$(cat "$work/out")"
  "$ectwin" with fzm1 -- sh -c 'sed -n "s/^CapEff:\s*0*//p" /proc/self/status; ip link set lo down && echo yes; exec sleep 2' >"$work/out" 2>/dev/null &
  local pid=$!
  for _ in $(seq 1200); do grep -q "NoNewPrivs:.1" /proc/$pid/status && break; sleep 0.1; done
  check "with: nothing for the twins" "0 1" \
    "$(sed -n 's/^CapEff:\s*0*\([0-9a-f]\)/\1/p; s/NoNewPrivs:\s*//p' /proc/$pid/status | xargs)"
  if strings "$ectwin" 2>/dev/null | grep -q seccomp_load; then
    check "with: system calls are filtered" 2 "$(sed -n 's/Seccomp:\s*//p' /proc/$pid/status)"
  fi
  wait $pid
  check "with: all rights for the command" "yes yes" "$([ "$(head -1 "$work/out")" != 0 ] && echo yes) $(tail -1 "$work/out")"
}

# As root the private network has a user namespace, too: nothing in there is root on this machine.
root_is_contained() {
  if [ "$(id -u)" -ne 0 ]; then
    echo "SKIPPED root in the private network: not root"
    return
  fi
  "$ectwin" with fzm1 -- readlink /proc/self/ns/user >"$work/out" 2>"$work/err"
  if grep -q "CMD is root on the whole machine" "$work/err"; then
    echo "SKIPPED root in the private network: no user namespace may be made here, and it says so"
    return
  fi
  check "with: as root, in a user namespace of its own" differ \
    "$([ "$(cat "$work/out")" = "$(readlink /proc/self/ns/user)" ] && echo same || echo differ)"
  echo text >"$work/file" && chown 1234 "$work/file" && chmod 600 "$work/file"
  check "with: files are as they were for root" "text 1234" \
    "$("$ectwin" with fzm1 -- sh -c 'cat "$1"; stat -c %u "$1"' sh "$work/file" 2>/dev/null | xargs)"
}

realtime_priority() {
  unshare -U bash -c 'ulimit -r 0; exec "$@"' bash "$ectwin" with --realtime fzm1 -- true 2>"$work/err"
  check "--realtime without the right" 2 $?
  says "--realtime without the right" "CAP_SYS_NICE"
  if ! python3 -c 'import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(7))' 2>/dev/null; then
    echo "SKIPPED --realtime: no real-time priority may be had here"
    return
  fi
  local pid option policy
  policy='import os, sys
pid = int(sys.argv[1])
print(os.sched_getscheduler(pid) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(pid).sched_priority)'
  for option in "--realtime 7" "--realtime=7"; do
    rm -f "$work/out"
    # shellcheck disable=SC2086
    "$ectwin" with $option fzm1 -- sh -c "python3 -c '$policy' 0; exec sleep 60" >"$work/out" 2>"$work/err" &
    pid=$!
    wait_for "$work/out"
    check "$option: the twins, not the command" "1 7 0 0" "$(python3 -c "$policy" $pid) $(cat "$work/out")"
    kill $pid
    wait $pid
  done
}

# Frames lie in memory that the kernel shares, which has room for 256 of them.
busy_poll() {
  # Runs of 60: a socket keeps some 150 frames for a twin that stands still.
  # shellcheck disable=SC2016
  "$ectwin" with --busy-poll fzm1 -- sh -c 'python3 "$2/frames.py" {} 60 1 5 10; "$1" stats --json' \
    sh "$ectwin" "$here" >"$work/out" 2>/dev/null
  check "--busy-poll: all come back, in order, but those that were stale" "True, 600 of 600" "$(python3 - "$work/out" <<'END'
import json
import sys

lines = open(sys.argv[1]).read().splitlines()
stats = json.loads(lines[-2])
runs = [[[int(field) for field in line.split()[:2]] for line in run.splitlines()] for run in "\n".join(lines[:-2]).split("run")[1:]]
runs = [[reply for reply in run if reply] for run in runs]
back = [reply for run in runs for reply in run]
in_order = all(after[0] > before[0] for run in runs for before, after in zip(run, run[1:]))
print(f"{in_order and all(counter == 1 for number, counter in back)}, {len(back) + stats['stale']} of {stats['frames']}")
END
)"
  "$ectwin" with --busy-poll fzm1 -- python3 "$here/vlan.py" {} >"$work/out" 2>/dev/null
  check "--busy-poll: a tagged frame is answered with its tag" 0 "$?"
  rm -f "$work/a"
  in_network '
    timeout 300 "$ectwin" run --busy-poll -i tw0 fzm1 >"$work/a" 2>/dev/null & pid=$!
    wait_for "$work/a"
    ip link delete tw0
    wait $pid; echo $?' >"$work/out"
  check "--busy-poll: the interface is gone" 3 "$(cat "$work/out")"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run_cases its_version help_has_short_options closed_streams memory_of_many_twins output_that_cannot_be_written ignored_interrupt wrong_options delayed_replies \
  faults_on_wires two_ends_that_answer names_of_the_private_network identities eeprom_writes counters example_masters_at_the_wrong_place processes_of_the_command killed_at_once signals_reach_the_command rights_of_a_running_twin root_is_contained realtime_priority busy_poll
