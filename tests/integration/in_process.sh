#!/usr/bin/env bash
# `ectwin with --in-process`: its contract, its errors, equal runs.  usage: in_process.sh ECTWIN SLAVEINFO CALLS
set -u
ectwin=$1
slaveinfo=$2
calls=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0
count=0

# check TITLE COMMAND...: COMMAND succeeds. It runs with a folder $work of its own, at most four side by side, because most of them wait.
check() {
  local title=$1
  shift
  count=$((count + 1))
  while [ "$(jobs -rp | wc -l)" -ge 4 ]; do wait -n; done
  {
    work=$work/$count
    mkdir "$work"
    if "$@" >"$work/log" 2>&1; then
      echo "ok      $title"
    else
      echo "FAILED  $title"
      sed 's/^/        /' "$work/log" | head -20
    fi
  } >"$work/$count.result" 2>&1 &
}

# exits STATUS COMMAND...
exits() {
  local wanted=$1 got=0
  shift
  "$@" >"$work/out" 2>"$work/err" || got=$?
  [ "$got" -eq "$wanted" ] || { echo "exit status $got, expected $wanted"; cat "$work/err"; return 1; }
}
# reports TEXT COMMAND...: a line on standard error contains TEXT
reports() {
  local text=$1
  shift
  "$@" >"$work/out" 2>"$work/err"
  grep -qF -- "$text" "$work/err" || { echo "no line contains: $text"; cat "$work/err"; return 1; }
}
with() { "$ectwin" with --in-process "$@"; }

ready_line() { reports '{"event":"ready","iface":"ecat7","slaves":2}' with --iface ecat7 fzm1,fzm1 -- true; }
check "The ready line names the interface and the number of twins" ready_line

status_of_command() { exits 23 with fzm1 -- sh -c 'exit 23'; }
check "The exit status is that of CMD" status_of_command
status_of_signal() { exits 137 with fzm1 -- sh -c 'kill -KILL $$'; }
check "A signal that ends CMD is 128 + its number" status_of_signal
status_of_missing() { exits 127 with fzm1 -- ./no-such-program; }
check "A CMD that is not there is 127" status_of_missing

wrong_device() { exits 1 with no-such-device -- true && reports "there is no device 'no-such-device'" with no-such-device -- true; }
check "An unknown device is wrong usage, before CMD runs" wrong_device
wrong_signal() { exits 1 with --set data1=x fzm1 -- true; }
check "A value that a signal refuses is wrong usage, before CMD runs" wrong_signal
virtual_alone() { exits 1 "$ectwin" with --virtual-time fzm1 -- true; }
check "--virtual-time without --in-process is wrong usage" virtual_alone
modbus() { exits 1 with --modbus 0 vr-bu-ect-map7 -- true; }
check "--modbus needs a process of the twins' own" modbus

not_opened() { reports "has not opened ecat0 through the C library" with fzm1 -- true; }
check "A CMD that never opens the interface is reported" not_opened

# The file of the device is gone when the master opens the interface.
opens='import socket, sys; socket.socket(socket.AF_PACKET, socket.SOCK_RAW).bind((sys.argv[1], 0x88A4))'
not_started() {
  "$ectwin" esi fzm1 >"$work/gone.xml" &&
    reports "gone.xml" with "esi:$work/gone.xml" -- sh -c 'rm "$1" && exec python3 -c "$2" {}' sh "$work/gone.xml" "$opens" &&
    ! grep -F "has not opened" "$work/err"
}
check "A bus that does not start gives its own reason alone" not_started

# CMD's own status, and the line that reports that no interface was opened
unreachable() { # PROGRAM
  exits 7 with fzm1 -- "$1" {} && grep -qF "has not opened ecat0 through the C library" "$work/err" && [ "$(wc -l <"$work/err")" -eq 2 ]
}
printf '#include <sys/socket.h>\nint main(void) { return socket(17, 3, 0) == -2 ? 0 : 7; }\n' >"$work/opens.c"
if cc -static -o "$work/static" "$work/opens.c" 2>/dev/null; then
  check "A static CMD is reported, beside the ready line alone" unreachable "$work/static"
else
  echo "skipped a static CMD: the C library has no static version here"
fi
if [ "$(id -u)" -eq 0 ] && cc -o "$work/setuid" "$work/opens.c" 2>/dev/null && chmod 755 "$work" && chown 65534 "$work/setuid" && chmod 4755 "$work/setuid" &&
  ! findmnt -nT "$work" -o OPTIONS | grep -q nosuid; then
  check "A setuid CMD is reported, beside the ready line alone" unreachable "$work/setuid"
else
  echo "skipped a setuid CMD: only root can make one of another user"
fi

# refused TEXT CMD: CMD does not run, one line names the reason
refused() {
  exits 2 with fzm1 -- "$2" {} && grep -qF -- "$1" "$work/err" && [ "$(wc -l <"$work/err")" -eq 1 ] && return
  cat "$work/err"
  return 1
}
cp "$(command -v env)" "$work/narrow"
printf '\1' | dd of="$work/narrow" bs=1 seek=4 conv=notrunc 2>/dev/null
check "A CMD of another word size is refused in one line" refused "another processor or word size" "$work/narrow"
sed 's/ld-linux/ld-other/' "$(command -v env)" >"$work/other"
chmod 755 "$work/other"
check "A CMD of another C library is refused in one line" refused "uses another C library (ld-other" "$work/other"

preload_kept() {
  local first
  first=$(ldd "$ectwin" | awk '/libasan/ { print $3 ":" }') # a program with AddressSanitizer wants it in front
  LD_PRELOAD=${first}libm.so.6 with fzm1 -- sh -c 'case $LD_PRELOAD in *libectwin-real.so*:libm.so.6) ;; *) echo "$LD_PRELOAD"; exit 1 ;; esac'
}
check "A preloaded library of the caller stays" preload_kept

# LeakSanitizer waits in pthread_create() for the new thread, which reads the clock.
leak=$work/leak
if ! ldd "$ectwin" | grep -q libasan && cc -fsanitize=leak -x c -o "$leak" - 2>/dev/null <<'END'; then
#include <arpa/inet.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <stdlib.h>
#include <sys/socket.h>
int main(void)
{
    struct sockaddr_ll to = {.sll_family = AF_PACKET, .sll_protocol = htons(0x88A4)};
    int fd = socket(AF_PACKET, SOCK_RAW, htons(0x88A4));
    to.sll_ifindex = (int)if_nametoindex(getenv("ECTWIN_IFACE"));
    return bind(fd, (struct sockaddr *)&to, sizeof to) == 0 ? 0 : 7;
}
END
  with_leak_sanitizer() { LSAN_OPTIONS=detect_leaks=0 exits 0 with --virtual-time fzm1 -- timeout -s KILL 20 "$leak"; }
  check "A CMD with LeakSanitizer opens the bus on the virtual clock" with_leak_sanitizer
else
  echo "skipped a CMD with LeakSanitizer: ectwin has AddressSanitizer, or the compiler has none"
fi

without_namespaces() {
  unshare -Ur sh -c "echo 0 >/proc/sys/user/max_user_namespaces && exec '$ectwin' with --in-process fzm1,fzm1 -- '$calls' {} real 'sendmmsg*'"
}
check "No user namespace is necessary" without_namespaces

removes_its_files() {
  with fzm1 -- sh -c 'sleep 300 & echo $!' >"$work/pid" 2>/dev/null
  ! kill -0 "$(cat "$work/pid")" 2>/dev/null
}
check "A process that CMD leaves behind ends with it" removes_its_files

relative_files() {
  mkdir -p "$work/store"
  (cd "$work" && "$ectwin" with --in-process --store store fzm1,fzm1 -- sh -c "cd / && '$calls' {} real 'sendmmsg*'") && [ -n "$(ls "$work/store")" ]
}
check "Relative paths start where ectwin was started" relative_files

if [ -n "$slaveinfo" ]; then
  foreign_master() { with --virtual-time vr-bu-ect-map7 -- "$slaveinfo" {} >"$work/out" && grep -q 'Name:VR-BU-ECT-Map7' "$work/out"; }
  check "SOEM's own slaveinfo finds the twin" foreign_master
  adapters() { with --iface ecat7 fzm1 -- "$slaveinfo" >"$work/out" 2>"$work/err"; grep -q ecat7 "$work/out" && return; cat "$work/out" "$work/err"; return 1; }
  check "SOEM lists the interface among its adapters" adapters
  equal_runs() {
    for _ in 1 2 3 4 5; do
      with --virtual-time --fault "drop 1%" fzm1,vr-bu-ect-map7 -- "$slaveinfo" {} -sdo 2>/dev/null | md5sum
    done | sort | uniq -c >"$work/hashes"
    cat "$work/hashes"
    [ "$(wc -l <"$work/hashes")" -eq 1 ]
  }
  check "Five runs on the virtual clock, with lost frames, are equal" equal_runs
fi

control() {
  with fzm1,fzm1 -- sh -c "'$calls' {} real 'Sleeps*' & sleep 0.2; wait" >/dev/null 2>&1
  with --set data1=2.5 fzm1,fzm1 -- python3 -c "
import os, socket, subprocess
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0xA488)
s.bind((os.environ['ECTWIN_IFACE'], 0x88A4))
out = subprocess.run(['$ectwin', 'get', '-n', '1', 'data1'], capture_output=True, text=True, timeout=20)
print(out.stdout, out.stderr)
assert '2.5' in out.stdout
"
}
[ "${ECTWIN_NO_PYTHON:-}" ] || check "The control socket of a bus in a process is that of any bus" control

listed() {
  with --iface ecat7,ecat8 fzm1,fzm1 -- python3 -c "
import os, socket
for name, index in (('ecat7', 1001), ('ecat8', 1002)):
    assert (index, name) in socket.if_nameindex()
    assert name in os.listdir('/sys/class/net')
    assert os.path.isdir('/sys/class/net/' + name)
    with open('/sys/class/net/%s/ifindex' % name) as file:
        assert file.read() == '%d\\n' % index
assert open('/sys/class/net/lo/mtu').read() != ''"
}
[ "${ECTWIN_NO_PYTHON:-}" ] || check "Python lists both interfaces, and reads their files" listed
gone() {
  mkdir -p "$work/tmp"
  TMPDIR=$work/tmp with fzm1 -- sh -c 'cat /sys/class/net/ecat0/operstate' >"$work/out" && [ "$(cat "$work/out")" = up ] && [ -z "$(ls -A "$work/tmp")" ]
}
check "The files of the interface are gone when CMD has ended" gone

# CMD starts the master and gives it a time, as timeout(1) and test runners do.
runner() {
  for _ in 1 2 3 4 5 6 7 8 9 10; do # the child may end at any moment of the wait
    with --virtual-time fzm1 -- timeout 300 "$calls" {} virtual "Sleeps*" >"$work/out" 2>"$work/err" || { cat "$work/out" "$work/err"; return 1; }
  done
  with --virtual-time fzm1 -- timeout 300 env -u LD_PRELOAD sleep 0.3 >/dev/null 2>&1 || return 1
  exits 124 with --virtual-time fzm1 -- timeout 1 env -u LD_PRELOAD sleep 30 >/dev/null 2>&1 || return 1
  [ "${ECTWIN_NO_PYTHON:-}" ] || with --virtual-time fzm1 -- python3 -c "
import subprocess
subprocess.run(['env', '-u', 'LD_PRELOAD', 'sleep', '0.3'], timeout=20, check=True)" >/dev/null 2>"$work/err"
}
check "A process without a bus waits for its children in real time" runner

# A master in Python: opens the interface, then runs a line of code.
python_master() { # CODE
  with --virtual-time fzm1 -- python3 -c "
import os, socket, subprocess, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0xA488)
s.bind((os.environ['ECTWIN_IFACE'], 0x88A4))
real = ['env', '-u', 'LD_PRELOAD']
$1" >"$work/out" 2>"$work/err"
}
# reported_once CALL CODE: one line names the call, and the master comes to its end
reported_once() {
  python_master "$2
print('end')" || { cat "$work/err"; return 1; }
  grep -q end "$work/out" && [ "$(grep -c 'real time' "$work/err")" -eq 1 ] && grep -qF -- "--virtual-time: $1 has waited" "$work/err" && return
  cat "$work/out" "$work/err"
  return 1
}
child_client() {
  python_master "
before = time.monotonic()
assert os.system('$ectwin set data1=2.5') == 0
assert subprocess.run(['$ectwin', 'get', '-n', '1', 'data1'], timeout=20).returncode == 0
assert os.popen('$ectwin get -n 1 data1').read() == 'data1=2.5\\n'
assert time.monotonic() - before < 0.01, time.monotonic() - before" && grep -q 2.5 "$work/out" && ! grep -q 'real time' "$work/err" && return
  cat "$work/out" "$work/err"
  return 1
}
# The master stands still, as on a machine that is suspended. That is no wait.
stopped_master() {
  python_master "
child = subprocess.Popen(real + ['sh', '-c', 'kill -STOP \$PPID; sleep 1.3; kill -CONT \$PPID'])
before = time.monotonic()
child.wait()
assert time.monotonic() - before < 0.01, time.monotonic() - before" && ! grep -q 'real time' "$work/err" && return
  cat "$work/out" "$work/err"
  return 1
}
# A child that ends when the line is there.
until_line() { echo "for i in \$(seq 1200); do grep -q \"real time\" $work/err && break; sleep 0.1; done"; }
long_child() { reported_once 'waitpid()' "
subprocess.Popen(real + ['sh', '-c', '''$(until_line)''']).wait()
subprocess.Popen(real + ['sleep', '1.3']).wait()"; }
long_pipe() { reported_once 'read()' "
os.environ['UNTIL'] = '''$(until_line)'''
pipe = os.popen('env -u LD_PRELOAD sh -c \"\$UNTIL\"; echo')
pipe.read()"; }
long_system() { reported_once 'wait4()' "
os.environ['UNTIL'] = '''$(until_line)'''
os.system('env -u LD_PRELOAD sh -c \"\$UNTIL\"')"; }
long_poll() {
  reported_once 'recv()' "
a, b = socket.socketpair()
child = subprocess.Popen(real + ['sh', '-c', '''$(until_line)''' + '; echo'], stdout=b)
b.close()
assert a.recv(1)"
}
set_at_a_time() {
  for _ in 1 2 3; do
    python_master "
import ctypes
getenv = ctypes.CDLL(None).getenv
getenv.restype = ctypes.c_char_p
time.sleep(0.01)
assert os.system('$ectwin set --at 0.5s data1=2.5') == 0
assert os.system('$ectwin set --at 0.001s data1=2.5') != 0
client = socket.socket(socket.AF_UNIX)
client.connect(getenv(b'ECTWIN_SOCKET'))
client.send(b'{\"op\":\"watch\",\"pattern\":\"data1\",\"every\":true}\\n')
client.recv(4096)
time.sleep(1)
print(client.recv(4096).decode())" || { cat "$work/err"; return 1; }
    grep 2.5 "$work/out" >>"$work/times"
  done
  cat "$work/times" "$work/err"
  [ "$(sort -u "$work/times" | wc -l)" -eq 1 ] && [ "$(wc -l <"$work/times")" -eq 3 ] && grep -q '"time":1000.5000' "$work/times" && grep -q '0.001 s is over' "$work/err"
}
if [ ! "${ECTWIN_NO_PYTHON:-}" ]; then
  check "A client sets a signal at exactly a time of the bus, in each run" set_at_a_time
  check "A child process may be a client of the bus; the virtual clock is stopped meanwhile" child_client
  check "A master that is stopped for more than a second has not waited" stopped_master
  check "A wait of more than a second for a child process is reported in one line" long_child
  check "A wait of more than a second in system is reported in one line" long_system
  check "A wait of more than a second for a pipe is reported in one line" long_pipe
  check "A wait of more than a second for a socket of another process is reported in one line" long_poll
fi
wait
failed=0
for ((number = 1; number <= count; number++)); do
  cat "$work/$number.result"
  grep -q '^ok' "$work/$number.result" || failed=1
done
exit $failed
