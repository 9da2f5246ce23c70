#!/usr/bin/env python3
"""Records of twins and their replay: --record, ectwin replay.  usage: replay.py ECTWIN PROBE FRAMES FOE [NAME...]

PROBE is ectwin-probe, FRAMES tests/integration/frames.py, FOE test_foe_wire."""
import json
import pathlib
import os
import re
import shutil
import struct
import sys
import time

from pcapng_cases import blocks, call, expect, run_cases

ECTWIN, PROBE, FRAMES, FOE = sys.argv[1:5]
LOCAL, PACKET = 0x80E7C001, 6
START, RUN, CLOCK, TOUCH, REQUEST, CONTENT, FLUSH, MODBUS = 1, 2, 3, 4, 5, 9, 10, 11


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


def change_local(file, wanted, old, new):
    """Replaces bytes in all local blocks of a kind."""
    out = b""
    for kind, body in blocks(file):
        ours = kind == LOCAL and struct.unpack_from("<I", body)[0] == wanted
        out += block(kind, body.replace(old, new) if ours else body)
    expect(f"{old} is in the record", True, out != file.read_bytes())
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
    members = json.loads(start[16:].rstrip(b"\0"))
    expect("members of a start", {"words", "version", "seed", "offset"}, set(members))
    wrong_ms = abs(int(members["offset"]) - (time.time_ns() - time.monotonic_ns())) // 1000000
    expect(f"the offset of the wall clock: {wrong_ms} ms", True, wrong_ms < 100)
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

    with_files = start(words=["--files", "/no/folder", "fzm1"])
    for content, line in ((b"", "no capture: the file is too short, at byte 0"),
                          (b"#!/bin/sh\n", "no capture: neither pcapng nor pcap, at byte 0"),
                          (whole[:-3], "the file ends within a block, at byte "),
                          (heads, "there are no frames in it"),
                          (heads + whole[-200:], "a block of "),
                          (heads + local(START, 0, 0, b"{"), "an invalid start"),
                          (start(words=[]), "an invalid start"),
                          (start(words=[1]), "an invalid start"),
                          (start(words=["no-such-device"]), "'no-such-device'"),
                          (start(words=["--no-such-option", "fzm1"]), "unrecognized option"),
                          (start(words=["--serial", "x", "fzm1"]), "--serial takes a number"),
                          (start(words=["--store", "/no/folder", "fzm1"]), "there are no frames in it"),
                          (start() + local(CONTENT), "an invalid part of a memory or a file"),
                          (start() + local(CONTENT, 2, 0, b"memory 1.0\n1"), "an invalid part of a memory or a file"),
                          (start() + local(CONTENT, 1, 1, b"memory 1.0\n1"), "the parts of a memory do not fit"),
                          (start() + local(CONTENT, 1, 0, b"file name\n1"), "it contains a file that no twin has"),
                          (with_files + local(CONTENT, 1, 0, b"file ../name\n1"), "it contains a file that no twin has"),
                          (with_files + local(CONTENT, 1, 0, b"file .name\n1"), "it contains a file that no twin has"),
                          (with_files + local(CONTENT, 1, 7, b"file name\n1"), "the parts of a file do not fit"),
                          (start() + local(MODBUS, 0, 0, b"00 00"), "an invalid Modbus request"),
                          (start(words=["--set", "none=1", "fzm1"]), "its twins cannot be powered on: --set: "),
                          (start() + local(CLOCK) + local(CLOCK), "a clock reading or a start in the wrong place"),
                          (start() + local(99), "a clock reading or a start in the wrong place"),
                          (start() + block(LOCAL, b"1234"), "a local block of 4 bytes"),
                          (start() + local(REQUEST, 0, 0, b'{"op":"get"}'), 'an invalid request: {"op":"get"}\n'),
                          (start() + block(PACKET, struct.pack("<IIIIII", 0, 0, 0, 4, 2000, 0)), "frame 1 is cut"),
                          (start() + block(PACKET, struct.pack("<IIIII", 0, 0, 0, 0, 0)), "frame 1 is not a frame of a record")):
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


def stores(file):
    """the saved data of twins, and the writes of a master to their EEPROMs, are in the record; a changed one differs"""
    store, values = file.parent / "store", file.parent / "values.json"
    save = f"{ECTWIN} set -n 2 comment1=saved output_period=777 && {ECTWIN} set -n 2 save=1 && {ECTWIN} wait -n 2 saves=1"
    expect("a run that saves", 0, call(ECTWIN, "with", "--store", store, "fzm1*2", "--", "sh", "-c", save).returncode)
    eeprom = store / "fzm1-1.sii"
    image = bytearray(eeprom.read_bytes())
    image[16 + (len(image) - 16) // 2 + 28] = 0x5A  # the serial number in the present image, as a master would write it
    eeprom.write_bytes(image)
    for words in (("--in-process", "--virtual-time"), ()):
        probe = f"{PROBE} -i $ECTWIN_IFACE -n 2 --values --od {values}; {PROBE} -i $ECTWIN_IFACE"
        script = probe if words else f"{probe}; {save.replace('777', '778')}; {probe}"
        done = call(ECTWIN, "with", *words, "--record", file, "--store", store, "fzm1*2", "--", "sh", "-c", script)
        expect(f"{words}: the master sees what was saved", (0, True), (done.returncode, b"saved".hex() in values.read_text()))
        expect(f"{words}: parts of the store", True, kinds(file).count(CONTENT) >= 6)
        expect(f"{words}: flushes", not words, kinds(file).count(FLUSH) > 0)
        elsewhere = store.rename(file.parent / "elsewhere")
        whole = file.read_bytes()
        equal(file)
        expect(f"{words}: the replay makes no store", False, store.exists())
        elsewhere.rename(store)
        change_local(file, CONTENT, b"saved", b"SAVED")
        replay(file, 1, r".*: the reply differs\n.*")
        file.write_bytes(whole)
    change_local(file, CONTENT, b"\x5A\0\0\0", b"\x5B\0\0\0")
    replay(file, 1, r".*: the reply differs\n.*SII.*")


def files(file):
    """files that a master reads and writes by FoE are in the record; a changed one differs"""
    folder = file.parent / "files"
    folder.mkdir()
    (folder / "other.bin").write_bytes(bytes(70000))
    (folder / "empty").write_bytes(b"")
    (folder / ".hidden").write_bytes(b"1")
    words = ("with", "--in-process", "--virtual-time", "--record", file, "--files", folder, "--files-password", "0x77", "vr-bu-ect-map7", "--", FOE, "{}", folder)
    temporary = file.parent / "temporary"
    temporary.mkdir()
    os.environ["TMPDIR"] = str(temporary)
    done = call(ECTWIN, *words)
    expect(f"files there and back: {done.stdout}", 0, done.returncode)
    expect("parts of files", 4, len([1 for kind, body in blocks(file) if kind == LOCAL and body[:4] == bytes([CONTENT, 0, 0, 0])]) // kinds(file).count(START))
    equal(file)
    (folder / "missing").write_bytes(b"here it is, " * 1500)
    call(ECTWIN, *words, "*refused*")
    shutil.rmtree(folder)
    equal(file)
    change_local(file, CONTENT, b"here", b"HERE")
    replay(file, 1, r".*: the reply differs\n.*FoE.*")
    expect("folders of the replay are removed", [], [name for name in os.listdir(temporary) if name.startswith("ectwin-replay-")])


ASK = """
import socket, sys
host, port = sys.argv[1].rsplit(":", 1)
with socket.create_connection((host, int(port)), 60) as connection:
    for request in sys.argv[2:]:
        connection.sendall(bytes.fromhex(request))
        print(connection.recv(260).hex())
"""


def modbus(file):
    """requests over Modbus TCP come again before the same frames, with the same replies; a changed one differs"""
    if "built without libmodbus" in call(ECTWIN, "run", "--modbus", "0", "--help", "x").stderr:
        return
    ask = file.parent / "ask.py"
    ask.write_text(ASK)
    read, write, wrong = "000100000006ff04000b0001", "00020000000bff1000000002040001ffff", "000300000006ff0400ffff01"
    script = f"python3 {ask} $ECTWIN_MODBUS {read} {write} {wrong} {read}; {PROBE} -i $ECTWIN_IFACE --values >/dev/null; python3 {ask} $ECTWIN_MODBUS {read} {wrong}"
    done = call(ECTWIN, "with", "--modbus", "0", "--record", file, "vr-bu-ect-map7", "--", "sh", "-c", script)
    if "built without libmodbus" in done.stderr:
        return
    expect(f"replies: {done.stderr}", (0, 6), (done.returncode, done.stdout.count("\n")))
    expect("requests", 6, kinds(file).count(MODBUS))
    equal(file)
    whole = file.read_bytes()
    change_local(file, MODBUS, read.upper().encode() + b" 0001", read.upper().encode() + b" 0009")
    replay(file, 1, r".*: frame \d+, .*: the reply to a Modbus request behind it differs\n  request  00 01 .*\n  expected 00 09 .*\n  got      00 01 .*")
    for old, new in ((b"0001", b"00G1"), (b" 0001", b"_0001")):
        file.write_bytes(whole)
        change_local(file, MODBUS, old, new)
        replay(file, 2, r".*: an invalid Modbus request")


def mistakes(file):
    """what cannot be recorded is refused"""
    done = call(ECTWIN, "run", "--modbus", "0", "--record", file, "vr-bu-ect-map7")
    expect("--modbus alone: exit", True, done.returncode == 1 or "built without libmodbus" in done.stderr)
    expect(f"--modbus alone: {done.stderr}", True, "--record needs frames, and there is no interface for them: add -i IFACE" in done.stderr
           or "built without libmodbus" in done.stderr)
    folder = file.parent / "files"
    folder.mkdir()
    with (folder / "long").open("wb") as long:
        long.truncate(64 * 1024 * 1024 + 1)
    done = call(ECTWIN, "with", "--record", file, "--files", folder, "vr-bu-ect-map7", "--", "true")
    expect("a long file: exit", 2, done.returncode)
    expect(f"a long file: {done.stderr}", True, "long' cannot be recorded: it is longer than 64 MiB" in done.stderr)


run_cases((networks, in_process, faults, requests, options, difference, wrong_files, buses, stores, files, modbus, mistakes), sys.argv[5:])
