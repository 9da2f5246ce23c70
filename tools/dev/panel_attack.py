#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Attacks `ectwin panel` with hostile requests while a page is open, and reports the cost. Run it in a namespace:
unshare -Urn sh -c 'ip link set lo up; tools/dev/panel_attack.py build/release/ectwin'

usage: panel_attack.py ECTWIN [SECONDS [REQUESTS_A_SECOND]]     exit status 1: a bound is exceeded
"""
import contextlib
import os
import pathlib
import socket
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "integration"))
import panel as server  # noqa: E402

SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 60
RATE = float(sys.argv[3]) if len(sys.argv) > 3 else 200
MOST_MEMORY_MB, MOST_DESCRIPTORS = 60, 160

HEADERS = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: ectwin-panel\r\n"
FRAME = b"\x81\xfe\xff\xff\0\0\0\0" + b" " * 65535  # too long a message


def attacks(port):
    """The bytes of each kind of connection."""
    ours = f"Host: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\n"
    strange = f"Host: evil.example:{port}\r\nOrigin: http://evil.example\r\n"
    return [b"", b"\0" * 4096, b"GET /", b"GET /" + b"a" * 20000 + b" HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 3000,
            f"GET /../etc/passwd HTTP/1.1\r\n{ours}\r\n".encode(), f"GET / HTTP/1.1\r\n{strange}\r\n".encode(),
            f"GET / HTTP/1.1\r\n{strange}{HEADERS}\r\n".encode(), f"GET / HTTP/1.1\r\n{ours}{HEADERS}\r\n".encode() + FRAME,
            f"GET / HTTP/1.1\r\n{ours}{HEADERS}\r\n".encode() + b"\x81\x8d\0\0\0\0{\"token\":\"x\"}",
            f"POST / HTTP/1.1\r\n{ours}Content-Length: 999999999\r\n\r\n".encode(), f"GET /panel.css HTTP/1.1\r\n{ours}\r\n".encode()]


def attack(port, content, held):
    """Opens a connection; the last 30 stay open, and are not read."""
    one = socket.socket()
    one.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        one.connect(("127.0.0.1", port))
    time.sleep(0.0005)
    with contextlib.suppress(OSError):
        one.send(content)
    held.append(one)
    if len(held) > 30:
        held.pop(0).close()


def memory_mb(process):
    status = pathlib.Path(f"/proc/{process}/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def cpu_s(process):
    fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    held, sent, descriptors, longest_s, replies = [], 0, 0, 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        with server.twins("fzm1"), server.running() as panel:
            page = server.Page(panel, panel.token)
            bus, _ = page.open("fzm1")
            kinds = attacks(panel.port)
            before_s, begin = cpu_s(panel.process.pid), time.monotonic()
            while time.monotonic() - begin < SECONDS:
                attack(panel.port, kinds[sent % len(kinds)], held)
                sent += 1
                if sent % int(RATE) == 0:
                    asked = time.monotonic()
                    reply = page.request(bus, {"op": "set", "name": "data1", "value": sent % 100}, sent)
                    longest_s = max(longest_s, time.monotonic() - asked)
                    replies += reply == {"ok": True}
                    descriptors = max(descriptors, panel.descriptors())
                time.sleep(max(0.0, begin + sent / RATE - time.monotonic()))
            span = time.monotonic() - begin
            memory, used = memory_mb(panel.process.pid), cpu_s(panel.process.pid) - before_s
    good = replies == sent // int(RATE) and memory <= MOST_MEMORY_MB and descriptors <= MOST_DESCRIPTORS
    print(f"{sent} hostile connections in {span:.0f} s, {sent / span:.0f} a second: {replies} of {sent // int(RATE)} requests of a page were carried out, "
          f"the slowest in {1000 * longest_s:.0f} ms; at most {memory:.1f} MB and {descriptors} descriptors; {100 * used / span:.1f} % of a core")
    return 0 if good and not server.failed else 1


sys.exit(main())
