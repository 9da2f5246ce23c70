#!/usr/bin/env python3
"""Measures the panel with a master at 1 kHz.  usage: panel.py MASTER [--build DIR] [--pages N] [--seconds S] [--turns T]

  MASTER        tests/integration/panel_master of a build with tests; it exchanges process data each millisecond
  --build DIR   where ectwin and ectwin-panel are (default build/release)
  --pages N     open pages that plot 20 signals each (default 10)
  --seconds S   of each turn (default 10)
  --turns T     pairs of turns, without and with pages (default 3)

Prints frames per second, replies later than 1 ms and late polls without and with pages, in turns, and the CPU time and memory of
the panel with one page and with all pages. Pages are WebSocket clients that read all messages, without a browser.
"""
import argparse
import base64
import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PLOTTED = 20


class Page:
    """A page with the first bus and plots of its signals; a thread reads its messages."""

    def __init__(self, url):
        base, token = url.split("/#")
        port = int(base.rsplit(":", 1)[1])
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: {base}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: ectwin-panel\r\n\r\n".encode())
        self.received = 0
        self.send({"token": token})
        time.sleep(2)
        self.send({"open": 1})
        time.sleep(2)
        self.send({"trace": list(range(PLOTTED))})
        threading.Thread(target=self.read, daemon=True).start()
        threading.Thread(target=self.ask, daemon=True).start()

    def send(self, message):
        content = json.dumps(message).encode()
        length = bytes([0x80 | len(content)]) if len(content) < 126 else bytes([0xFE]) + len(content).to_bytes(2, "big")
        self.socket.sendall(b"\x81" + length + b"\0\0\0\0" + content)

    def read(self):
        with contextlib.suppress(OSError):
            self.socket.settimeout(None)
            while piece := self.socket.recv(65536):
                self.received += len(piece)

    def ask(self):
        """The repeated requests of the page."""
        number = 0
        with contextlib.suppress(OSError):
            while True:
                for request in ({"op": "counters"}, {"op": "waves"}, {"op": "pdos", "slave": 1}):
                    number += 1
                    self.send({"id": number, "bus": 1, "request": request})
                time.sleep(1)

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


def ticks(process):
    fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def resident(process):
    lines = pathlib.Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


def counters(ectwin):
    lines = subprocess.run([ectwin, "stats", "--json"], capture_output=True, text=True, check=True).stdout.splitlines()
    return json.loads(lines[0]), json.loads(lines[1])


def late(answers, edge_us):
    return sum(count for count, edge in zip(answers["answers"], [*answers["edges_us"], float("inf")]) if edge > edge_us)


def turn(args, ectwin, panel, url, pages):
    """One turn; returns its figures."""
    opened = [Page(url) for _ in range(pages)]
    cpu, before = ticks(panel.pid), counters(ectwin)
    start = time.monotonic()
    time.sleep(args.seconds)
    after, took = counters(ectwin), time.monotonic() - start
    load = (ticks(panel.pid) - cpu) / os.sysconf("SC_CLK_TCK") / took
    frames = after[0]["frames"] - before[0]["frames"]
    figures = {"pages": pages, "frames_per_s": round(frames / took), "lost": frames - (after[0]["answered"] - before[0]["answered"]),
               "stale": after[0]["stale"] - before[0]["stale"], "later_than_1_ms": late(after[1], 1000) - late(before[1], 1000),
               "late_polls": after[0]["late_polls"] - before[0]["late_polls"], "panel_cpu_percent": round(100 * load, 1),
               "panel_memory_mb": round(resident(panel.pid), 1), "received_kb_per_s": round(sum(page.received for page in opened) / took / 1024)}
    for page in opened:
        page.close()
    time.sleep(2)
    return figures


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("master")
    parser.add_argument("--build", default=ROOT / "build" / "release")
    parser.add_argument("--pages", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--turns", type=int, default=3)
    args = parser.parse_args()
    ectwin = str(pathlib.Path(args.build, "ectwin").resolve())
    devices = str(ROOT / "examples" / "machine" / "machine.yaml")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        bus = subprocess.Popen([ectwin, "with", "--quiet", devices, "--", args.master, "{}", "65535", "1000"], stdout=subprocess.DEVNULL)
        panel = subprocess.Popen([ectwin, "panel"], stdout=subprocess.PIPE, text=True)
        url = json.loads(panel.stdout.readline())["url"]
        time.sleep(4)
        try:
            for pages in [0, 1, *[0, args.pages] * args.turns]:
                print(json.dumps(turn(args, ectwin, panel, url, pages)), flush=True)
        finally:
            panel.send_signal(signal.SIGTERM)
            bus.terminate()
            panel.wait(20)
            bus.wait(20)
    return 0


sys.exit(main())
