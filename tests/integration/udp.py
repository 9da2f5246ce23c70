#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""--udp: a master over EtherCAT in UDP, in `with` in addition to the interface and in `run` without one.

usage: ectwin with --udp 0 fzm1 -- udp.py ECTWIN [CASE]
"""

import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time

ectwin = sys.argv[1]
failed = 0
APWR, FPRD, FPWR, BRD = 2, 4, 5, 7


def check(title, want, got):
    global failed
    if want != got:
        print(f"FAILED {title}\n  expected: {want}\n  got:      {got}")
        failed = 1


class Master:
    """Sends datagrams to ADDRESS:PORT and waits for each reply."""

    def __init__(self, where):
        host, port = where.rsplit(":", 1)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host, int(port)))
        self.socket.settimeout(20)
        self.index = self.counter = 0

    def exchange(self, command, adp, ado, data):
        """@return data and working counter of the reply"""
        self.index = (self.index + 1) % 256
        datagram = struct.pack("<BBHHHH", command, self.index, adp, ado, len(data), 0) + data + bytes(2)
        self.socket.send(struct.pack("<H", 0x1000 | len(datagram)) + datagram)
        while True:
            reply = self.socket.recv(2048)
            if reply[3] == self.index:
                return reply[12:-2], struct.unpack("<H", reply[-2:])[0]

    def write(self, ado, data):
        return self.exchange(FPWR, 0x1001, ado, data)[1]

    def read(self, ado, length):
        return self.exchange(FPRD, 0x1001, ado, bytes(length))[0]

    def to_preop(self):
        """Station address, the mailbox of the EEPROM's standard places, PREOP. @return AL status"""
        self.exchange(APWR, 0, 0x0010, struct.pack("<H", 0x1001))
        self.write(0x0120, struct.pack("<H", 0x0011))
        out, size_out, inn, size_in = self.mailbox = self.mailbox_of_eeprom()
        self.write(0x0800, struct.pack("<HHBBBB", out, size_out, 0x26, 0, 1, 0))
        self.write(0x0808, struct.pack("<HHBBBB", inn, size_in, 0x22, 0, 1, 0))
        self.write(0x0120, struct.pack("<H", 0x0002))
        return self.wait(lambda: self.read(0x0130, 1)[0] & 0x1F, 2)

    def mailbox_of_eeprom(self):
        words = b""
        for address in (0x18, 0x1A):
            self.write(0x0502, struct.pack("<HI", 0x0100, address))
            self.wait(lambda: self.read(0x0503, 1)[0] & 0x80, 0)
            words += self.read(0x0508, 4)
        return struct.unpack("<HHHH", words)

    def wait(self, read, want):
        for _ in range(2000):
            if (got := read()) == want:
                break
            time.sleep(0.001)
        return got

    def upload(self, index, subindex):
        """@return the value of an expedited or normal upload"""
        out, size_out, inn, size_in = self.mailbox
        self.counter = self.counter % 7 + 1
        sdo = struct.pack("<HBHBI", 0x2000, 0x40, index, subindex, 0)
        mail = struct.pack("<HHBB", len(sdo), 0, 0, 3 | self.counter << 4) + sdo
        self.write(out, mail.ljust(size_out, b"\0"))
        self.wait(lambda: self.read(0x080D, 1)[0] & 8, 8)
        answer = self.read(inn, size_in)[6:]
        command = answer[2]
        if command & 2:
            return answer[6 : 10 - (command >> 2 & 3)]
        return answer[10 : 10 + struct.unpack("<I", answer[6:10])[0]]


def start(*arguments):
    """@return a running `ectwin run` and its ready line"""
    twin = subprocess.Popen([ectwin, "run", *arguments], stdout=subprocess.PIPE, text=True)
    return twin, json.loads(twin.stdout.readline())


def output(*words):
    return subprocess.run([ectwin, *words], check=True, capture_output=True, text=True).stdout


def end(twin):
    twin.terminate()
    check("the end", 0, twin.wait(60))


def beside_the_interface():
    master = Master(os.environ["ECTWIN_UDP"])
    check("with: slaves that reply", 1, master.exchange(BRD, 0, 0x0130, bytes(2))[1])
    check("with: PREOP", 2, master.to_preop())
    check("with: 1018h:01", bytes.fromhex("570e0000"), master.upload(0x1018, 1))


def without_an_interface():
    with tempfile.TemporaryDirectory() as folder:
        capture, record = f"{folder}/run.pcapng", f"{folder}/run.rec"
        twin, ready = start("--udp", "0", "--pcap", capture, "--record", record, "fzm1*2")
        check("run: ready", ["event", "slaves", "udp"], sorted(ready))
        check("run: at loopback", "127.0.0.1", ready["udp"].rsplit(":", 1)[0])
        first, second = Master(ready["udp"]), Master(ready["udp"])
        for master in (first, second):
            check("run: slaves that reply", 2, master.exchange(BRD, 0, 0x0130, bytes(2))[1])
        check("run: PREOP", 2, first.to_preop())
        check("run: name of the device", b"FZM1", second_upload(first, second))
        for bad in (b"", b"\x0e\x10", b"\xff\x17" + bytes(20), bytes(1500)):
            first.socket.send(bad)
        check("run: behind bad datagrams", 2, first.exchange(BRD, 0, 0x0130, bytes(2))[1])
        stats = output("stats", "-s", str(twin.pid), "--json").splitlines()[0]
        check("run: datagrams of bad length", 4, json.loads(stats)["unanswered"])
        check("run: the address in 'ectwin ps'", True, ready["udp"] in output("ps"))
        end(twin)
        with open(capture, "rb") as file:
            port = struct.pack("!HH", first.socket.getsockname()[1], 0x88A4)
            check("run: datagrams in the capture", True, port in file.read())
        replay = subprocess.run([ectwin, "replay", record], capture_output=True, text=True)
        check("run: replayed", (0, ""), (replay.returncode, replay.stderr if replay.returncode else ""))


def second_upload(first, second):
    """The second master goes on where the first one was: they share a bus."""
    second.mailbox, second.counter = first.mailbox, first.counter
    return second.upload(0x1008, 0)[:4]


def faults():
    twin, ready = start("--udp", "0", "--fault", "drop frame 2", "--fault", "delay 2000us frame 3", "fzm1")
    master = Master(ready["udp"])
    check("faults: frame 1", 1, master.exchange(BRD, 0, 0x0130, bytes(2))[1])
    master.socket.settimeout(0.2)
    try:
        check("faults: frame 2", None, master.exchange(BRD, 0, 0x0130, bytes(2)))
    except socket.timeout:
        pass
    master.socket.settimeout(20)
    check("faults: frame 3", 1, master.exchange(BRD, 0, 0x0130, bytes(2))[1])
    end(twin)


def refusals():
    taken = os.environ["ECTWIN_UDP"]
    for words, status, part in (
        (["--udp", "here", "fzm1"], 1, "'here' is no [ADDRESS:]PORT: a numeric IPv4 address"),
        (["--udp", taken, "fzm1"], 2, "the port is in use: choose another port"),
        (["--udp", "192.0.2.1:34980", "fzm1"], 2, "this machine does not have the address"),
        (["-o", "lo", "fzm1"], 1, "no interface: name it with -i IFACE"),
    ):
        run = subprocess.run([ectwin, "run", *words], capture_output=True, text=True)
        check(f"run {' '.join(words)}", (status, True), (run.returncode, part in run.stderr))
    run = subprocess.run([ectwin, "with", "--in-process", "--udp", "0", "fzm1", "--", "true"], capture_output=True, text=True)
    check("with --in-process --udp", (1, True), (run.returncode, "need a process of the twins' own" in run.stderr))


CASES = [beside_the_interface, without_an_interface, faults, refusals]
for case in CASES:
    if len(sys.argv) < 3 or case.__name__ == sys.argv[2]:
        case()
sys.exit(failed)
