#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Networks behind twins with EoE: a TAP, a socket and the responder, through the bridging master of examples/eoe.

usage: eoe.py ECTWIN BRIDGE GATEWAY.xml [CASE] [BYTES|SECONDSs]

CASE: refusals, tap, echo, unix (default: these), iperf3, tshark. BYTES: of the download from the server behind the twin
(default 10000000) and of that to it; a fifth goes each way by iperf3. SECONDS, as in 10s: iperf3 runs so long each way.
Exits with 77 where a case lacks its program.
"""
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request

ADDRESS, OURS, NET = "192.168.10.20", "192.168.10.1", "192.168.10.0/24"
SKIPPED = 77
TYPE = 0x88B5  # for local experiments
WINDOW = 65536  # bytes, of the sockets of iperf3
failed = False


def check(title, expected, actual):
    global failed
    if expected != actual:
        failed = True
        print(f"FAILED {title}\n  expected: {expected!r}\n  got:      {actual!r}")


# --- inside the private network ----------------------------------------------------------------------------------------


def run(*words):
    subprocess.run(words, check=True)


class Bridge:
    """The master of examples/eoe while it runs; then `end` is its last line."""

    def __init__(self, program, *options):
        self.process = subprocess.Popen([program, *options, os.environ["ECTWIN_IFACE"]], stdout=subprocess.PIPE, text=True)
        assert json.loads(self.process.stdout.readline())["event"] == "ready"

    def stop(self):
        self.process.terminate()
        self.end = json.loads(self.process.communicate()[0])
        return self.end


def narrow(tap, words=run):
    """Half a queue of the twin is the most that a TCP sender has under way: a master that the machine stops for seconds loses nothing."""
    words("ip", "route", "change", NET, "dev", tap, "window", "40000")


def patient(tap, words=run):
    """ARP asks for five minutes, not three seconds: a machine that stops the master for so long loses no datagram."""
    words("ip", "ntable", "change", "name", "arp_cache", "dev", tap, "mcast_probes", "300", "ucast_probes", "300")


def dropped(words=()):
    """@return frames that the TAPs of a network have dropped"""
    text = subprocess.run([*words, "ip", "-s", "-j", "link"], stdout=subprocess.PIPE, check=True, text=True).stdout
    return sum(link["stats64"][way]["dropped"] for link in json.loads(text) for way in ("rx", "tx") if link["ifname"] in ("eoe0", "tap0"))


def open_network():
    run("ip", "addr", "add", OURS + "/24", "dev", "eoe0")
    patient("eoe0")


class Inner:
    """A network of its own behind the twin's TAP, with the address."""

    def __init__(self):
        self.process = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo; exec sleep 600"], stdout=subprocess.PIPE)
        self.process.stdout.readline()
        run("ip", "link", "set", "tap0", "netns", str(self.process.pid))
        for words in (["link", "set", "lo", "up"], ["addr", "add", ADDRESS + "/24", "dev", "tap0"], ["link", "set", "tap0", "up"]):
            self.run("ip", *words)
        narrow("tap0", self.run)
        patient("tap0", self.run)

    def words(self, *words):
        return ["nsenter", "-n", "-t", str(self.process.pid), *words]

    def run(self, *words):
        run(*self.words(*words))

    def stop(self):
        self.process.kill()
        self.process.wait()


def checksum(data):
    total = sum(struct.unpack(f">{len(data) // 2}H", data))
    total = (total & 0xFFFF) + (total >> 16)
    return ~(total + (total >> 16)) & 0xFFFF


def ping(count, size):
    """@return the number of pings with a correct reply, compared byte by byte"""
    answered = 0
    with socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_ICMP) as wire:
        wire.settimeout(120)
        for n in range(count):
            rest = struct.pack(">HH", 77, n) + bytes(i & 0xFF for i in range(size))
            wire.sendto(struct.pack(">BBH", 8, 0, checksum(b"\x08\x00" + rest)) + rest, (ADDRESS, 0))
            reply = wire.recv(2000)
            while reply[20] == 8:
                reply = wire.recv(2000)
            answered += reply[20] == 0 and reply[24:] == rest
    return answered


def serve(words, folder, address):
    """A web server with a folder, at port 8000; @return its process, when it listens"""
    server = subprocess.Popen([*words, sys.executable, "-m", "http.server", "-b", address, "-d", folder, "8000"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    server.stdout.readline()
    return server


def downloads(inner, size):
    """A file in both directions; @return whether it is whole, each time, and the rates in MB/s"""
    content = os.urandom(size)
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/file", "wb") as file:
            file.write(content)
        behind = serve(inner.words(), folder, ADDRESS)
        started = time.monotonic()
        with urllib.request.urlopen(f"http://{ADDRESS}:8000/file", timeout=300) as reply:
            from_twin = reply.read() == content
        between = time.monotonic()
        here = serve([], folder, OURS)
        fetch = f"import urllib.request as u, sys; sys.stdout.buffer.write(u.urlopen('http://{OURS}:8000/file', timeout=300).read())"
        to_twin = subprocess.run(inner.words(sys.executable, "-c", fetch), stdout=subprocess.PIPE, check=True).stdout == content
        ended = time.monotonic()
        for server in (behind, here):
            server.kill()
            server.wait()
    return from_twin, to_twin, size / (between - started) / 1e6, size / (ended - between) / 1e6


DATAGRAMS = """
import socket, sys
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind(("", 9000))
s.settimeout(120)
print("ready", flush=True)
while True:
    data, sender = s.recvfrom(2000)
    s.sendto(data, sender)
"""


def datagrams(inner, count, size):
    """Datagrams to the twin and back, eight under way; @return how many have come back in their order"""
    echo = subprocess.Popen(inner.words(sys.executable, "-c", DATAGRAMS), stdout=subprocess.PIPE)
    echo.stdout.readline()
    good = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.settimeout(120)
        for n in range(count + 8):
            if n < count:
                wire.sendto(n.to_bytes(4, "big") + bytes(size - 4), (ADDRESS, 9000))
            if n >= 8:
                reply = wire.recv(2000)
                good += len(reply) == size and int.from_bytes(reply[:4], "big") == n - 8
    echo.kill()
    echo.wait()
    return good


def signals(ectwin):
    text = subprocess.run([ectwin, "get", "eoe.*"], stdout=subprocess.PIPE, check=True, text=True).stdout
    return {name: int(value) for name, value in re.findall(r"eoe\.(\w+)=(\d+)", text)}


def both(program, *options):
    """Both networks, with the bridge between them"""
    inner = Inner()
    bridge = Bridge(program, *options)
    open_network()
    narrow("eoe0")
    return inner, bridge


def inside_tap(ectwin, program, size):
    inner, bridge = both(program, "--sdo")
    lost, before = signals(ectwin)["dropped"], dropped() + dropped(inner.words())  # before the twin was in PREOP
    check("EOE-013 ping of 1400 bytes, 20 times", 20, ping(20, 1400))
    check("datagrams of 1400 bytes, there and back", 500, datagrams(inner, 500, 1400))
    from_twin, to_twin, rate_from, rate_to = downloads(inner, size)
    check("a file of the server behind the twin", True, from_twin)
    check("a file of the server before the twin", True, to_twin)
    now = signals(ectwin)
    check("no frame is lost in the TAPs", before, dropped() + dropped(inner.words()))
    end = bridge.stop()
    check("no frame is lost in the twin", lost, now["dropped"])
    check("no frame is broken in the master", 0, end["broken"])
    check("EOE-052 an SDO is answered within four mails", True, end["sdos"] > 10 and end["most_mails"] <= 4)
    print(f"{rate_from:.2f} MB/s from the twin, {rate_to:.2f} MB/s to it; {end}", file=sys.stderr)
    inner.stop()


def inside_lossy(ectwin, program, _):
    """Half of the lost frames reach the twin: the master repeats a request that was executed, and has the reply repeated."""
    inner, bridge = both(program, "--sdo")
    lost = signals(ectwin)["dropped"]
    check("EOE-015 a frame of ten is lost: 300 datagrams there and back, each once, in their order", 300, datagrams(inner, 300, 1400))
    check("EOE-015 no frame is lost in the twin", lost, signals(ectwin)["dropped"])
    end = bridge.stop()
    check("EOE-015 no frame is broken in the master", 0, end["broken"])
    check("SDOs are answered", True, end["sdos"] > 0)
    inner.stop()


def iperf3_client(*options):
    """@return the report's end: sent and received bytes, retransmitted segments"""
    done = subprocess.run(["iperf3", "-J", "-c", ADDRESS, "-w", str(WINDOW), *options], stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(done.stdout)["end"]


def inside_iperf3(ectwin, program, size):
    inner, bridge = both(program)
    server = subprocess.Popen(inner.words("iperf3", "-s", "--forceflush"), stdout=subprocess.PIPE, text=True)
    while "listening" not in server.stdout.readline():
        pass
    lost, before = signals(ectwin)["dropped"], dropped() + dropped(inner.words())
    amount, least = (["-t", str(seconds)], 40000) if seconds else (["-n", str(size // 5)], size // 5)
    for title, options in (("to the twin", []), ("from the twin", ["-R"])):
        end = iperf3_client(*amount, *options)
        sent, received = end["sum_sent"], end["sum_received"]
        # The receiver counts until the sender's end. Linux doubles WINDOW for the buffer at each side.
        check(f"iperf3 {title}: all bytes are sent, and all have arrived but those in the two buffers", (True, True),
              (sent["bytes"] >= least, received["bytes"] + 4 * WINDOW >= sent["bytes"]))
        check(f"iperf3 {title}: at most one segment of ten is sent again, which a stopped machine may cause", True,
              sent["retransmits"] * 1448 * 10 <= sent["bytes"] + 10 * 40000)
        print(f"iperf3 {title}: {sent['bytes']} bytes, {received['bits_per_second'] / 8e6:.2f} MB/s, {sent['retransmits']} sent again",
              file=sys.stderr)
    check("iperf3: no frame is lost in the twin", lost, signals(ectwin)["dropped"])
    check("iperf3: no frame is lost in the TAPs", before, dropped() + dropped(inner.words()))
    check("iperf3: no frame is broken in the master", 0, bridge.stop()["broken"])
    server.kill()
    server.wait()
    inner.stop()


def inside_ping(_, program, __):
    bridge = Bridge(program, "--address", ADDRESS)
    open_network()
    for size in (900, 1400):
        check(f"ping of {size} bytes, 5 times", 5, ping(5, size))
    bridge.stop()


def inside_echo(ectwin, program, _):
    bridge = Bridge(program, "--address", ADDRESS)
    open_network()
    check("ping of 1400 bytes, 20 times", 20, ping(20, 1400))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.settimeout(120)
        wire.sendto(b"echo", (ADDRESS, 7))
        check("echo of UDP", b"echo", wire.recv(100))
    run(ectwin, "set", "eoe.link=0")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        lost = signals(ectwin)["dropped"]
        wire.sendto(b"echo", (ADDRESS, 7))
        for _ in range(100):
            if signals(ectwin)["dropped"] > lost:
                break
            time.sleep(0.1)
        check("a frame over a pulled cable is dropped", True, signals(ectwin)["dropped"] > lost)
    bridge.stop()


def inside_unix(ectwin, program, _):
    bridge = Bridge(program)
    host = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    host.connect(os.environ["EOE_SOCKET"])
    host.settimeout(120)
    wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(TYPE))
    wire.bind(("eoe0", TYPE))
    wire.settimeout(120)
    for size in (60, 118, 119, 1014, 1015, 1514):
        frame = b"\xff" * 6 + b"\x02\0\0\0\0\x01" + TYPE.to_bytes(2, "big") + bytes(i & 0xFF for i in range(size - 14))
        host.send(frame)
        check(f"{size} bytes of the host", frame, wire.recv(2000))
        wire.send(frame)
        reply = host.recv(2000)
        while reply[12:14] != frame[12:14]:  # the kernel's own
            reply = host.recv(2000)
        check(f"{size} bytes for the host", frame, reply)
    bridge.stop()
    run(ectwin, "get", "eoe.link")


# --- outside -----------------------------------------------------------------------------------------------------------


def inside(case, options, env=None):
    words = [ectwin, "with", *options, "esi:" + gateway, "--", sys.argv[0], "--inside", case, *sys.argv[1:4], str(size), str(seconds)]
    done = subprocess.run(words, env={**os.environ, "XDG_RUNTIME_DIR": work, **(env or {})}, timeout=350 + 2 * seconds)
    check(case + ": exit status", 0, done.returncode)


def tap():
    inside("tap", ["--eoe", "tap0"])


def lossy():
    inside("lossy", ["--drop", "10", "--eoe", "tap0"])


def echo():
    inside("echo", ["--eoe", "1:echo"])


def unix():
    inside("unix", ["--eoe", f"unix:{work}/port"], {"EOE_SOCKET": f"{work}/port"})
    check("the socket is removed", False, os.path.exists(work + "/port"))


def iperf3():
    inside("iperf3", ["--eoe", "tap0"])


def lines_of(path, select, *options):
    done = subprocess.run(["tshark", "-r", path, "-Y", select, *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, text=True)
    return done.stdout.splitlines()


def tshark():
    """Wireshark as an independent judge. It does not assemble frames, so it can judge the content of whole ones only; and it
    accepts only one of the two layouts of set IP; the bridge's SOEM writes the other one."""
    path = f"{work}/run.pcapng"
    inside("ping", ["--eoe", "echo", "--pcap", path])
    fragment, whole = "ecat_mailbox.eoe.type == 0", "ecat_mailbox.eoe.fragno == 0 && ecat_mailbox.eoe.last == 1"
    check("EOE-022 fragments: each to the slave occurs twice, each of the slave once", True,
          len(lines_of(path, fragment)) >= 5 * 3 + 5 * 2 * 3)
    check("whole frames with a ping and its echo", True, len(lines_of(path, f"{whole} && icmp")) >= 5 * 3)
    check("nothing is wrong with whole frames", [], lines_of(path, f"{whole} && (_ws.malformed || _ws.expert.severity == error)"))
    check("nothing is wrong with EoE", [], lines_of(path, 'ecat_mailbox.eoe.type != 2 && _ws.expert.message contains "EoE"'))
    check("the packed set IP is: Wireshark judges", True, len(lines_of(path, '_ws.expert.message contains "EoE"')) > 0)


def refusals():
    device = "esi:" + gateway
    rows = [
        (["--eoe", "eth0", device], 1, "--eoe takes tap, tapNAME, unix:PATH or echo, or one of them for a twin, as 2:tap0, not 'eth0'"),
        (["--eoe", "0:tap0", device], 1, "--eoe takes tap, tapNAME, unix:PATH or echo, or one of them for a twin, as 2:tap0, not '0:tap0'"),
        (["--eoe", "tap0", "fzm1"], 1, "--eoe tap0: no twin has EoE: take a device whose ESI file has Mailbox/EoE"),
        (["--eoe", "1:echo", "fzm1"], 1, "--eoe 1:echo: twin 1, fzm1, has no EoE: take a device whose ESI file has Mailbox/EoE"),
        (["--eoe", "3:echo", device + "*2"], 1, "--eoe 3:echo: the chain has 2 twins"),
        (["--eoe", "axis:echo", "gate=" + device], 1,
         "--eoe axis:echo: no twin is named 'axis': name it in the list, as axis=DEVICE"),
        (["--eoe", "last:unix:" + work, f"first={device},last={device}"], 2, f"--eoe last:unix:{work}: '{work}' exists already"),
        (["--eoe", "gate:echo", "--eoe", "1:tap0", "gate=" + device], 1, "--eoe 1:tap0: twin 1 has a network already"),
        (["--eoe", "echo", "--eoe", "1:tap0", device], 1, "--eoe 1:tap0: twin 1 has a network already: leave one of the two out"),
        (["--in-process", "--eoe", "tap0", device], 1,
         "--eoe tap0 needs a process of the twins' own: 'ectwin run', or 'ectwin with' without --in-process"),
        (["--record", work + "/r.pcapng", "--eoe", "tap0", device], 1,
         "--record does not hold the frames of --eoe tap0: leave one of the two out"),
        (["--eoe", "unix:" + work, device], 2, f"--eoe unix:{work}: '{work}' exists already: remove it, or choose another path"),
        (["--eoe", "taplo", "--eoe", "2:taplo", device + "*2"], 2,
         "--eoe 2:taplo: another program has 'taplo' open: end it, or choose another name"),
    ]
    for options, status, line in rows:
        done = subprocess.run([ectwin, "with", "--quiet", *options, "--", "true"], capture_output=True, text=True, timeout=300,
                              env={**os.environ, "XDG_RUNTIME_DIR": work})
        lines = [one for one in done.stderr.splitlines() if line in one]
        check(f"{options}: status and line", (status, True), (done.returncode, len(lines) == 1 or done.stderr))
    done = subprocess.run([ectwin, "with", "--in-process", "--eoe", "echo", device, "--", "true"], capture_output=True, text=True,
                          timeout=300)
    check("echo needs no process of its own", True, "--eoe" not in done.stderr or done.stderr)


seconds = 0
if sys.argv[1] == "--inside":
    seconds = int(sys.argv[7])
    globals()["inside_" + sys.argv[2]](sys.argv[3], sys.argv[4], int(sys.argv[6]))
    sys.exit(failed)
if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
    print("/dev/net/tun is missing or not open to this user: no TAP can be made")
    sys.exit(SKIPPED)
ectwin, bridge_program, gateway = sys.argv[1:4]
only = sys.argv[4] if len(sys.argv) > 4 else ""
amount = sys.argv[5] if len(sys.argv) > 5 else "10000000"
size, seconds = (10000000, int(amount[:-1])) if amount.endswith("s") else (int(amount), 0)
if only in ("iperf3", "tshark") and not shutil.which(only):
    print(f"skipped: there is no {only} here: apt install {only}")
    sys.exit(SKIPPED)
with tempfile.TemporaryDirectory() as work:
    for case in (refusals, tap, lossy, echo, unix, iperf3, tshark):
        if only == case.__name__ or (not only and case not in (iperf3, tshark)):
            case()
sys.exit(failed)
