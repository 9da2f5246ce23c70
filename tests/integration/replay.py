#!/usr/bin/env python3
"""Records of twins and their replay: --record, ectwin replay.  usage: replay.py ECTWIN PROBE FRAMES [NAME...]

PROBE is ectwin-probe, FRAMES tests/integration/frames.py."""
import json
import pathlib
import re
import struct
import sys

from pcapng_cases import blocks, call, expect, run_cases

ECTWIN, PROBE, FRAMES = sys.argv[1:4]
LOCAL, PACKET = 0x80E7C001, 6
START, RUN, CLOCK, TOUCH, REQUEST = 1, 2, 3, 4, 5


def record(file, *words):
    done = call(ECTWIN, "with", "--record", file, *words)
    expect(f"{words[:-3]}: the run", "", "\n".join(line for line in done.stderr.splitlines() if "ready" not in line))


def replay(file, status, pattern):
    done = call(ECTWIN, "replay", file)
    text = (done.stdout if status != 2 else done.stderr).strip()
    expect(f"{file.name}: exit; {done.stderr.strip()}", status, done.returncode)
    expect(f"{file.name}: '{text}'", True, re.fullmatch(pattern, text, re.S) is not None)
    return text


def equal(file):
    replay(file, 0, r".*: \d+ frames and \d+ replies in [\d.]+ s of the bus: all equal")


def block(kind, body):
    body += bytes(-len(body) % 4)
    return struct.pack("<II", kind, len(body) + 12) + body + struct.pack("<I", len(body) + 12)


def local(kind, value=0, time=0, text=b""):
    return block(LOCAL, struct.pack("<IIQ", kind, value, time) + text)


def kinds(file):
    return [struct.unpack_from("<I", body)[0] for kind, body in blocks(file) if kind == LOCAL]


def change(file, number, function):
    """Replaces the body of the packet with a number, from 1."""
    out, count = b"", 0
    for kind, body in blocks(file):
        count += kind == PACKET
        out += block(kind, function(body) if kind == PACKET and count == number else body)
    file.write_bytes(out)


def networks(file):
    """a run over a network replays byte for byte"""
    record(file, "fzm1,pmctendo-dd5", "--", PROBE, "-i", "{}")
    equal(file)
    record(file, "--iface", "ecat0,ecat1", "fzm1*2", "--", "python3", FRAMES, "{}", "30", "1")
    equal(file)


def in_process(file):
    """runs in processes, each from a power-on of its own"""
    words = ("--in-process", "--virtual-time", "vr-bu-ect-map7", "--", "sh", "-c", f"{PROBE} -i $ECTWIN_IFACE; {PROBE} -i $ECTWIN_IFACE")
    record(file, *words)
    equal(file)
    expect("starts", 2, kinds(file).count(START))
    late = f"import runpy, sys, time; time.sleep(5); sys.argv = ['', 'ecat0', '3', '0.5']; runpy.run_path('{FRAMES}', run_name='__main__')"
    record(file, "--in-process", "--virtual-time", "fzm1", "--", "sh", "-c", f'python3 -c "{late}"; {PROBE} -i ecat0')
    replay(file, 0, r".* in \d{1,3}\.\d+ s of the bus: all equal")
    record(file, "--in-process", "vr-bu-ect-map7", "--", PROBE, "-i", "{}")
    equal(file)


def faults(file):
    """faults by seed come again, at the same frames and times"""
    for fault in ("drop 10%", "delay 300us 5%", "corrupt 5%", "truncate 8 every 9", "duplicate every 9", "reorder every 7",
                  "counter -1 every 4", "delay 500us every 5 wire 2", "drop 10% wire 2 back", "damage 10% wire 2", "at frame 20 reset slave 2",
                  "at 0.02s hang slave 1", "clock 5000ns slave 2"):
        record(file, "--in-process", "--virtual-time", "--fault", fault, "--seed", "5", "fzm1*3", "--", "python3", FRAMES, "{}", "60", "0.5")
        equal(file)
    record(file, "--fault", "drop 10%", "--fault", "duplicate every 9", "fzm1*3", "--", "python3", FRAMES, "{}", "60", "0.5", "3")
    equal(file)


def requests(file):
    """requests of clients come again before the same frames"""
    probe = f"{PROBE} -i {{}} --values >/dev/null"
    script = f"{ECTWIN} set data1=1.5 trigger=1; {probe}; {ECTWIN} unplug 2; {probe}; {ECTWIN} plug 2; {ECTWIN} fault 'drop 2%'; {probe}"
    record(file, "--require-private", "fzm1*2", "--", "sh", "-c", script)
    expect("requests", 4, kinds(file).count(REQUEST))
    equal(file)


def options(file):
    """options of the run shape the twins of the replay"""
    record(file, "--set", "2:data1=3", "--serial", "77", "--esc", "lan9252", "--drift", "2:50", "--break", "CF-040", "--name", "cell",
           "fzm1*2", "--", PROBE, "-i", "{}", "--values")
    start = next(body for kind, body in blocks(file) if kind == LOCAL)
    expect("what a start holds", {"words", "version", "seed", "offset"}, set(json.loads(start[16:].rstrip(b"\0"))))
    equal(file)


def difference(file):
    """the first difference is named: frame, time, datagram, slave, register, both values"""
    record(file, "--in-process", "--virtual-time", "fzm1", "--", PROBE, "-i", "{}")
    packets = [body for kind, body in blocks(file) if kind == PACKET]
    number = next(n for n, body in enumerate(packets, 1) if n % 2 == 0 and body[36] in (1, 4) and body[40:42] == b"\x30\x01")
    whole = file.read_bytes()
    change(file, number, lambda body: body[:46] + b"\x08" + body[47:])
    replay(file, 1, rf".*: frame {number}, [\d.]+ s after the first: the reply differs\n"
                    r"  datagram 1 of 1, slave 1\n"
                    r"  request  [AF]PRD [0-9A-F]{4}:0130 AL status, \d+ bytes?\n"
                    r"  expected [AF]PRD [0-9A-F]{4}:0130 AL status, \d+ bytes?, WKC 1: 08 [ 0-9A-F]*\| OP[^\n]*\n"
                    r"  got      [AF]PRD [0-9A-F]{4}:0130 AL status, \d+ bytes?, WKC 1: 0[12] [ 0-9A-F]*\| (INIT|PREOP)[^\n]*")
    file.write_bytes(whole)
    change(file, 2, lambda body: body[:20] + b"\0" + body[21:])
    replay(file, 1, r".*: frame 2, .*: the reply differs\n  expected 60 bytes: .*\n  got 60 bytes: .*")
    packets = [n for n, (kind, _) in enumerate(blocks(file)) if kind == PACKET]
    parts = [block(kind, body) for kind, body in blocks(file)]
    file.write_bytes(b"".join(part for n, part in enumerate(parts) if n != packets[1]))
    replay(file, 1, r".*: frame 1, .*: a reply of the twins is not in the record\n  got .*")
    file.write_bytes(b"".join(parts[:packets[0]] + [parts[packets[1]]] + parts[packets[2]:]))
    replay(file, 1, r".*: frame 1, .*: the twins do not reply\n  expected .*")


def wrong_files(file):
    """a file that is no record gives one line and the exit code 2"""
    record(file, "--in-process", "--virtual-time", "fzm1", "--", PROBE, "-i", "{}")
    whole = file.read_bytes()
    heads = whole[:whole.index(struct.pack("<I", LOCAL))]
    first = json.loads(next(body for kind, body in blocks(file) if kind == LOCAL)[16:].rstrip(b"\0"))

    def start(**changes):
        return heads + local(START, 0, 0, json.dumps({**first, **changes}).encode())

    for content, line in ((b"", "no capture: the file is too short, at byte 0"),
                          (b"#!/bin/sh\n", "no capture: neither pcapng nor pcap, at byte 0"),
                          (whole[:-3], "the file ends within a block, at byte "),
                          (heads, "there are no frames in it"),
                          (heads + whole[-200:], "a block of "),
                          (heads + local(START, 0, 0, b"{"), "its start makes no sense"),
                          (start(words=[]), "its start makes no sense"),
                          (start(words=[1]), "its start makes no sense"),
                          (start(words=["no-such-device"]), "'no-such-device'"),
                          (start(words=["--no-such-option", "fzm1"]), "unrecognized option"),
                          (start(words=["--serial", "x", "fzm1"]), "--serial takes a number"),
                          (start(words=["--store", "/tmp", "fzm1"]), "the record asks for files or a server"),
                          (start(words=["--files", "/tmp", "fzm1"]), "the record asks for files or a server"),
                          (start(words=["--set", "none=1", "fzm1"]), "its twins cannot be powered on: --set: "),
                          (start() + local(CLOCK) + local(CLOCK), "a clock reading or a start in the wrong place"),
                          (start() + local(99), "a clock reading or a start in the wrong place"),
                          (start() + block(LOCAL, b"1234"), "a local block of 4 bytes"),
                          (start() + local(REQUEST, 0, 0, b'{"op":"get"}'), "a request makes no sense"),
                          (start() + block(PACKET, struct.pack("<IIIIII", 0, 0, 0, 4, 2000, 0)), "frame 1 is cut"),
                          (start() + block(PACKET, struct.pack("<IIIII", 0, 0, 0, 0, 0)), "frame 1 is none of ours")):
        file.write_bytes(content)
        done = call(ECTWIN, "replay", file)
        expect(f"{line}: exit", 2, done.returncode)
        expect(f"{line}: one line", 1, done.stderr.count("\n"))
        expect(f"{line}: '{done.stderr}'", True, line in done.stderr)
    done = call(ECTWIN, "with", "--pcap", file, "--in-process", "fzm1", "--", PROBE, "-i", "{}")
    replay(file, 2, r"ectwin replay: '.*': it was not written by --record; to compare .*")
    replay(pathlib.Path("/no/such/file"), 2, r"ectwin replay: '/no/such/file': No such file or directory")


def foreign(file, frames):
    """Writes a pcap file as a capture on a master's wire: no directions, the bit of the source address marks replies."""
    out = struct.pack("<IHHIIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 1)
    for nanoseconds, is_reply, frame in frames:
        frame = frame[:6] + bytes([2 if is_reply else 0]) + frame[7:]
        out += struct.pack("<IIII", *divmod(nanoseconds, 10**9), len(frame), len(frame)) + frame
    file.write_bytes(out)


def buses(file):
    """a capture of a bus against twins: counters, AL states, mails, and data by choice"""
    call(ECTWIN, "with", "--in-process", "--virtual-time", "--pcap", file, "fzm1", "--", PROBE, "-i", "{}")
    frames = []
    for kind, body in blocks(file):
        if kind == PACKET:
            _, high, low, length = struct.unpack_from("<IIII", body)
            frames.append((high << 32 | low, len(frames) % 2 == 1, body[20:20 + length]))
    done = call(ECTWIN, "replay", file, "fzm1")
    expect("a capture of ours", (0, f"{file}: {len(frames) // 2} frames"), (done.returncode, done.stdout.split(" and ")[0]))
    foreign(file, [(t - (n > len(frames) - 3) * 3 * 10**9, r, f) for n, (t, r, f) in enumerate(frames)])
    done = call(ECTWIN, "replay", file, "fzm1")
    expect("a clock that was set back", (0, True),
           (done.returncode, re.search(r"in \d{1,3}\.\d+ s of the bus: 0 differences", done.stdout) is not None))
    expect("a clock that was set back, and a device with timers", 1, call(ECTWIN, "replay", file, "vr-bu-ect-map7").returncode)
    foreign(file, frames)
    done = call(ECTWIN, "replay", file, "fzm1")
    expect("a foreign one", (0, True), (done.returncode, ": 0 differences" in done.stdout))
    done = call(ECTWIN, "replay", file, "optoncdt2300")
    expect("another device", (1, True), (done.returncode, "slave 1: byte " in done.stdout and "of the EEPROM data: bus " in done.stdout))

    def changed(number, offset, value):
        altered = [(t, r, f[:offset] + bytes([value]) + f[offset + 1:] if n == number else f) for n, (t, r, f) in enumerate(frames)]
        foreign(file, altered)
        done = call(ECTWIN, "replay", file, "fzm1")
        expect(f"packet {number + 1} changed: exit", 1, done.returncode)
        return done.stdout

    counter = 16 + 10 + (struct.unpack_from("<H", frames[1][2], 22)[0] & 0x7FF)
    expect("a working counter", True, "frame 2, BRD" in changed(1, counter, 9) and "all slaves: working counter: bus 9, twin 1" in changed(1, counter, 9))
    status = next(n for n, (_, r, f) in enumerate(frames) if r and f[16] in (1, 4) and f[20:22] == b"\x30\x01")
    expect("an AL state", True, f"frame {status + 1}, slave 1, AL state 1: bus SAFEOP, twin " in changed(status, 26, 4))
    lost = [frame for n, frame in enumerate(frames) if n != 1]
    foreign(file, lost)
    done = call(ECTWIN, "replay", file, "fzm1")
    expect("a reply that the capture lacks is no difference of the twin", (0, True), (done.returncode, ": 0 differences" in done.stdout))
    done = call(ECTWIN, "replay", "--data", file)
    expect("--data without a device", (1, True), (done.returncode, "options of twins without a DEVICE" in done.stderr))


def mistakes(file):
    """options whose effects are not in a record are refused"""
    for words, option in ((["--store", file.parent], "--store"), (["--files", file.parent], "--files")):
        done = call(ECTWIN, "with", "--record", file, *words, "fzm1", "--", "true")
        expect(f"{option}: exit", 1, done.returncode)
        expect(f"{option}: text", True, f"--record does not hold what {option} adds to a run: leave one of the two out" in done.stderr)


run_cases((networks, in_process, faults, requests, options, difference, wrong_files, buses, mistakes), sys.argv[4:])
