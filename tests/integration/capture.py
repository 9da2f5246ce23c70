#!/usr/bin/env python3
"""Captures of twins: --pcap.  usage: capture.py ECTWIN PROBE FRAMES [NAME...]

PROBE is ectwin-probe, FRAMES tests/integration/frames.py. Wireshark's part is left out where tshark is not installed."""
import json
import pathlib
import shutil
import struct
import sys

from pcapng_cases import blocks, call, expect, run_cases

ECTWIN, PROBE, FRAMES = sys.argv[1:4]


def options(body, at):
    while at + 4 <= len(body):
        code, length = struct.unpack_from("<HH", body, at)
        if code == 0:
            return
        yield code, body[at + 4:at + 4 + length]
        at += 4 + (length + 3) // 4 * 4


def packets(path):
    """(interface, time in ns, inbound, frame, comment) of each packet."""
    for kind, body in blocks(path):
        if kind != 6:
            continue
        interface, high, low, captured, _ = struct.unpack_from("<IIIII", body)
        own = dict(options(body, 20 + (captured + 3) // 4 * 4))
        yield interface, high << 32 | low, own[2][0] == 1, body[20:20 + captured], own.get(1, b"").decode()


def comments(path):
    """Lines of all comments in their order."""
    lines = [line for packet in packets(path) for line in packet[4].split("\n") if line]
    for kind, body in blocks(path):
        if kind == 5:
            lines += [line for code, text in options(body, 12) if code == 1 for line in text.decode().split("\n")]
    return lines


def complaints(path):
    """Frames that Wireshark complains of."""
    if not shutil.which("tshark"):
        print("left out: tshark is not installed")
        return []
    filtered = "(_ws.malformed || _ws.expert.severity >= 0x400000 || not ecat)"
    return call("tshark", "-r", path, "-Y", filtered).stdout.splitlines()


def both_directions(file):
    """every frame in both directions, in order, as Wireshark reads it"""
    done = call(ECTWIN, "with", "--pcap", file, "fzm1,pmctendo-dd5", "--", PROBE, "-i", "{}")
    expect("exit", 0, done.returncode)
    all_packets = list(packets(file))
    inbound = [p for p in all_packets if p[2]]
    expect("as many replies as requests", len(all_packets), 2 * len(inbound))
    expect("more than a hundred", True, len(inbound) > 100)
    expect("times ascend", sorted(p[1] for p in all_packets), [p[1] for p in all_packets])
    expect("the mark of a returned frame", {2}, {p[3][6] & 2 for p in all_packets if not p[2]})
    expect("names of the interfaces", [b"ecat0", None], [dict(options(body, 8)).get(2) for kind, body in blocks(file) if kind == 1])
    expect("complaints", [], complaints(file))


def faults(file):
    """comments for faults: set, and on each frame that they concern"""
    done = call(ECTWIN, "with", "--in-process", "--virtual-time", "--fault", "drop frame 3", "--fault", "delay 200us frame 5", "--fault", "truncate 4 frame 6", "--fault",
                "duplicate frame 7", "--fault", "at frame 8 reset slave 1", "--pcap", file, "fzm1", "--", "python3", FRAMES, "{}", "10", "5", "1")
    expect("exit", 0, done.returncode)
    lines = comments(file)
    expect("the faults that are set", ["drop frame 3", "delay 200us frame 5", "truncate 4 frame 6", "duplicate frame 7"],
           [line[7:] for line in lines if line.startswith("fault: ") and " frame " in line])
    effects = {p[3][17]: p[4] for p in packets(file) if p[2] and p[3][17] > 0}
    expect("a lost frame", True, effects[2] in ("fault: the request is lost", "fault: the reply is lost"))
    expect("a late one", "fault: the reply leaves 200 us late", effects[4])
    expect("a changed one", "fault: the request is changed", effects[5])
    expect("a double one", "fault: the reply leaves twice", effects[6])
    expect("one without", "", effects[8])
    expect("a fault of a slave", 1, lines.count("fault: reset slave 1"))
    expect("requests as they came", {60}, {len(p[3]) for p in packets(file) if p[2]})
    expect("two replies", 2, sum(not p[2] and p[3][17] == 6 for p in packets(file)))


def requests(file):
    """comments for what users change"""
    script = f"{ECTWIN} set data1=1.5; {ECTWIN} set no=1; {ECTWIN} unplug 2; {ECTWIN} plug 2; {ECTWIN} get data1; python3 {FRAMES} {{}} 2 1"
    call(ECTWIN, "with", "--pcap", file, "fzm1*2", "--", "sh", "-c", script)
    lines = [line for line in comments(file) if line.startswith("request: ")]
    expect("requests", 4, len(lines))
    expect("the first one", 'request: {"op":"set","slave":1,"values":{"data1":"1.5"}}', lines[0])
    expect("a plug is pulled", True, "fault" in lines[2] or "set" in lines[2])


def counters(file):
    """stats counts what is captured"""
    done = call(ECTWIN, "with", "--pcap", file, "fzm1", "--", "sh", "-c", f"python3 {FRAMES} {{}} 20 1 && {ECTWIN} stats --json")
    stats = json.loads(done.stdout[done.stdout.index('{"frames"'):].splitlines()[0])
    expect("captured", stats["frames"] - stats["stale"] + stats["answered"], stats["captured"])
    expect("uncaptured", 0, stats["uncaptured"])


def in_process(file):
    """each process has a section; two at the same time have a file each; times are virtual"""
    probe = f"{PROBE} -i $ECTWIN_IFACE >/dev/null"
    done = call(ECTWIN, "with", "--in-process", "--virtual-time", "--pcap", file, "fzm1", "--", "sh", "-c", f"{probe} && {probe}")
    expect("exit", 0, done.returncode)
    expect("sections", 2, [kind for kind, _ in blocks(file)].count(0x0A0D0D0A))
    halves = list(packets(file))
    expect("both are equal", halves[:len(halves) // 2], halves[len(halves) // 2:])
    expect("complaints", [], complaints(file))
    first = file.read_bytes()
    call(ECTWIN, "with", "--in-process", "--virtual-time", "--pcap", file, "fzm1", "--", "sh", "-c", f"{probe} && {probe}")
    expect("a second run writes the same bytes", True, first == file.read_bytes())
    call(ECTWIN, "with", "--in-process", "--pcap", file, "fzm1", "--", "python3", FRAMES, "{}", "10", "1")
    expect("a real clock has the time of the day", True, all(p[1] > 10**18 for p in packets(file)))
    expect("ten frames", 20, len(list(packets(file))))
    twice = f"import subprocess, sys; frames = open('{FRAMES}').read(); sys.argv[2:] = ['3', '1']; exec(frames); " \
            f"subprocess.run([sys.executable, '{FRAMES}', sys.argv[1], '4', '1'])"
    call(ECTWIN, "with", "--in-process", "--pcap", file, "fzm1", "--", "python3", "-c", twice, "{}")
    expect("files of two buses at a time", [6, 8], [len(list(packets(path))) for path in sorted(file.parent.iterdir())])


def killed_master(file):
    """a master that is killed leaves whole blocks, to its last frame"""
    code = f"import os, sys; sys.argv = ['', os.environ['ECTWIN_IFACE'], '10', '1']; exec(open('{FRAMES}').read()); os.kill(os.getpid(), 9)"
    done = call(ECTWIN, "with", "--in-process", "--pcap", file, "fzm1", "--", "python3", "-c", code)
    expect("exit", 137, done.returncode)
    expect("frames", 20, len(list(packets(file))))


def size(file):
    """--pcap-size keeps the newest frames"""
    call(ECTWIN, "with", "--pcap-size", "70K", "--pcap", file, "fzm1,pmctendo-dd5", "--", PROBE, "-i", "{}")
    expect("size", True, 20000 < file.stat().st_size <= 70000)
    expect("the end says so", "older frames were removed: --pcap-size", comments(file)[-1])


def mistakes(file):
    """a mistake of the user gets one line"""
    for words, status, text in ((["--pcap", "/no/such/file"], 2, "ectwin with: --pcap: cannot write '/no/such/file': No such file or directory"),
                                (["--in-process", "--pcap", "/dev/null"], 2, "ectwin with: --pcap: cannot write '/dev/null': it is not a regular file"),
                                (["--pcap", file, "--pcap-size", "5"], 1, "--pcap-size takes a number of bytes from 65536, as 100M, or 0, not '5'"),
                                (["--pcap-size", "9X"], 1, "--pcap-size takes a number of bytes from 65536, as 100M, or 0, not '9X'")):
        done = call(ECTWIN, "with", *words, "fzm1", "--", "true")
        expect(f"{words}: exit", status, done.returncode)
        expect(f"{words}: text", True, text in done.stderr)


run_cases((both_directions, faults, requests, counters, in_process, killed_master, size, mistakes), sys.argv[4:])
