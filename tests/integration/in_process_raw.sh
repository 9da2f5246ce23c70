#!/usr/bin/env bash
# `ectwin with --in-process` and system calls that CMD makes without the C library.  usage: in_process_raw.sh ECTWIN RAW_CALLS DISPATCH
set -u
. "$(dirname "$0")/../support/check.sh"
ectwin=$1
raw_calls=$2
dispatch=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export ASAN_OPTIONS=detect_leaks=0
with() { "$ectwin" with --in-process "$@"; }

# handles_sigsys COMMAND...: the signal of the dispatch has a handler in COMMAND, which prints its /proc/self/status
handles_sigsys() {
  with --virtual-time fzm1 -- "$@" 2>/dev/null | awk '/^SigCgt:/ { exit !(substr($2, length($2) - 7, 1) ~ /[4-7c-f]/) }'
}
not_dispatched() {
  ! handles_sigsys grep SigCgt /proc/self/status || return 1
  [ "${ECTWIN_NO_PYTHON:-}" ] || ! handles_sigsys python3 -c 'print(open("/proc/self/status").read())'
}
check "A program that makes its calls by the C library is not dispatched" yes "$(not_dispatched && echo yes)"

let_go() {
  with fzm1 -- "$dispatch" real alone 2>"$work/err" && [ "$(grep -c 'makes threads without the C library' "$work/err")" -eq 1 ] && return
  cat "$work/err"
  return 1
}
check "A thread that CMD makes by clone runs, and one line reports that" yes "$(let_go && echo yes)"

equal_raw_runs() {
  for run in 1 2 3; do
    with --virtual-time --pcap "$work/$run.pcapng" fzm1,fzm1 -- "$raw_calls" {} virtual "A *" >"$work/out" 2>&1 || { cat "$work/out"; return 1; }
    md5sum <"$work/$run.pcapng"
  done | sort | uniq -c >"$work/hashes"
  [ "$(wc -l <"$work/hashes")" -eq 1 ] || { cat "$work/hashes"; return 1; }
}
check "Three runs of a program that makes its calls itself have the same frames at the same times" yes "$(equal_raw_runs && echo yes)"

if [ ! "${ECTWIN_NO_PYTHON:-}" ]; then
  # The filter refuses prctl(59), the dispatch.
  no_dispatch() {
    with fzm1 -- python3 -c "
import ctypes, os, struct, sys
code = [(0x20, 0, 0, 0), (0x15, 0, 3, 157), (0x20, 0, 0, 16), (0x15, 0, 1, 59), (0x06, 0, 0, 0x50016), (0x06, 0, 0, 0x7FFF0000)]
filter = ctypes.create_string_buffer(b''.join(struct.pack('HBBI', *one) for one in code))
program = struct.pack('HxxxxxxP', len(code), ctypes.addressof(filter))
libc = ctypes.CDLL(None, use_errno=True)
assert libc.prctl(38, 1, 0, 0, 0) == 0 and libc.prctl(22, 2, program, 0, 0) == 0
sys.exit(7 if os.spawnv(os.P_WAIT, '$raw_calls', ['calls', os.environ['ECTWIN_IFACE'], 'real', 'sendmmsg*']) != 0 else 0)
" >"$work/out" 2>"$work/err"
    [ $? -eq 7 ] && grep -qF "system calls of its own that this kernel or C library does not report" "$work/err" && return
    cat "$work/err"
    return 1
  }
  check "Without the kernel's dispatch, a CMD that makes its calls itself is reported" yes "$(no_dispatch && echo yes)"

  cat >"$work/late.c" <<'END'
long late(long number, long a, const void *b, long c)
{
    long result;
    __asm__ volatile("syscall" : "=a"(result) : "a"(number), "D"(a), "S"(b), "d"(c) : "rcx", "r11", "memory");
    return result;
}
END
  late_library() {
    cc -shared -fPIC -o "$work/late.so" "$work/late.c" && with --virtual-time fzm1 -- python3 -c "
import ctypes, os, socket
late = ctypes.CDLL('$work/late.so').late
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0xA488)
s.bind((os.environ['ECTWIN_IFACE'], 0x88A4))
frame = (b'\\xff' * 6 + b'\\2\\0\\0\\0\\0\\1\\x88\\xa4\\x0e\\x10\\x07\\1\\0\\0\\0\\0\\2').ljust(60, b'\\0')
reply = ctypes.create_string_buffer(60)
assert late(1, s.fileno(), frame, 60) == 60
assert late(0, s.fileno(), reply, 60) == 60
assert reply.raw[28] == 1, reply.raw" 2>&1 | grep -v ready
    [ "${PIPESTATUS[0]}" -eq 0 ]
  }
  check "Calls of a library that is loaded before the socket is opened are seen" yes "$(late_library && echo yes)"
fi
exit $failed
