#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""--in-kernel at the hook of a driver: a tap interface, whose driver has one and leaves VLAN tags in frames; and at the generic
hook of a veth pair, whose driver has one too.  usage: in_kernel_native.py ECTWIN

Needs root with CAP_BPF and /dev/net/tun; without these the test is skipped with its reason (77)."""
import fcntl
import json
import os
import select
import struct
import subprocess
import sys
import tempfile
import time

ECTWIN = sys.argv[1]
TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
LONGEST_S = 120  # for a machine as busy as it likes
INSIDE = "ECTWIN_TEST_NETWORK"
failed = 0


def check(title, want, got):
    global failed
    print(f"{'ok' if want == got else 'FAILED'} - {title}" + ("" if want == got else f": expected {want!r}, got {got!r}"))
    failed += want != got


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(77)


def frame(tag=b""):
    """A BRD of AL status, with any index."""
    datagram = struct.pack("<BBHHHH", 7, 0x55, 0, 0x0130, 2, 0) + bytes(4)
    head = b"\xff" * 6 + b"\x02\x00\x00\x00\x00\x01" + tag + b"\x88\xa4"
    return (head + struct.pack("<H", 0x1000 | len(datagram)) + datagram).ljust(60 + len(tag), b"\0")


def exchange(tap, request):
    """The reply, sent again while there is none: other frames of the interface, such as those of IPv6, are no replies."""
    end = time.monotonic() + LONGEST_S
    while time.monotonic() < end:
        os.write(tap, request)
        retry = time.monotonic() + 2
        while select.select([tap], [], [], max(0, retry - time.monotonic()))[0]:
            reply = os.read(tap, 2000)
            if b"\x88\xa4" in (reply[12:14], reply[16:18]):
                return reply
    sys.exit("FAILED - no reply")


def stats(runtime):
    out = subprocess.run([ECTWIN, "stats", "--json"], check=True, capture_output=True, text=True,
                         env=dict(os.environ, XDG_RUNTIME_DIR=runtime)).stdout
    merged = {}
    for line in out.splitlines():
        merged |= json.loads(line)
    return merged


def counter(reply, at):
    return struct.unpack_from("<H", reply, at)[0]


def start(runtime, iface):
    twin = subprocess.Popen([ECTWIN, "run", "-i", iface, "--in-kernel", "fzm1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            env=dict(os.environ, XDG_RUNTIME_DIR=runtime))
    if '"ready"' not in twin.stdout.readline():
        skip(twin.stderr.read().strip())
    return twin


def native(runtime):
    try:
        tap = os.open("/dev/net/tun", os.O_RDWR)
        fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH22x", b"tap7", IFF_TAP | IFF_NO_PI))
    except OSError as error:
        skip(f"/dev/net/tun: {error}")
    subprocess.run(["ip", "link", "set", "tap7", "up"], check=True)
    twin = start(runtime, "tap7")
    end = time.monotonic() + LONGEST_S
    replies = 0
    while stats(runtime)["in_kernel"] < 100 and time.monotonic() < end:
        for _ in range(50):
            replies += counter(exchange(tap, frame()), 28) == 1
            time.sleep(0.001)
    found = stats(runtime)
    check("the hook is the driver's", "native", found.get("hook"))
    check("frames get their replies there", True, found["in_kernel"] >= 100)
    check("each reply has the working counter of a twin", True, replies > 0 and replies % 50 == 0)
    check("their times are in the histogram", found["in_kernel"], sum(found["kernel_answers"]))
    check("one layout has a plan", 1, found["plans"])
    reply = exchange(tap, frame(b"\x81\x00\x60\x05"))
    check("a frame with a tag gets a reply with its tag", b"\x81\x00\x60\x05\x88\xa4", reply[12:18])
    check("of the twin", 1, counter(reply, 32))
    twin.terminate()
    check("it ends", 0, twin.wait())
    os.close(tap)


def generic(runtime):
    subprocess.run(["ip", "link", "add", "one", "type", "veth", "peer", "name", "two"], check=True)
    twin = start(runtime, "two")
    check("a veth has the generic hook", "generic", stats(runtime).get("hook"))
    twin.terminate()
    check("that one ends", 0, twin.wait())


def main():
    if os.geteuid() != 0:
        skip("it needs root")
    if INSIDE not in os.environ:
        os.environ[INSIDE] = "1"
        os.execvp("unshare", ["unshare", "-n", sys.executable, *sys.argv])
    with tempfile.TemporaryDirectory() as runtime:
        native(runtime)
        generic(runtime)
    sys.exit(1 if failed else 0)


main()
