#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Slow twins under real masters, on the virtual clock.  usage: slow.py ECTWIN CONFORM CONTROLLER [TEST]"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOARD = ["--like", "lan9252-spi"]
PARALLEL = ["--like", "et1100-mmio"]
SLOW = [["--al-delay", "1..100"], ["--mailbox-delay", "1..50"], ["--jitter", "0..3000"], ["--dc-jitter", "40"], BOARD, PARALLEL,
        [*BOARD, "--al-delay", "1..100", "--mailbox-delay", "1..20", "--jitter", "0..500"]]
JUDGED = [["--al-delay", "1..20"], ["--mailbox-delay", "1..5"], ["--jitter", "0..300"], ["--dc-jitter", "40"], BOARD, PARALLEL]


def with_twins(ectwin, options, *command):
    return subprocess.run([ectwin, "with", "--in-process", "--virtual-time", *options, "--", *command], capture_output=True,
                          text=True, check=False)


def expect(what, wanted, got):
    if wanted != got:
        raise AssertionError(f"{what}: expected {wanted!r}, got {got!r}")


def for_each(function, several):
    """Runs on all processors: a run never waits"""
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        list(pool.map(function, several))


def controlled(ectwin, _, controller):
    """The example controller (SOEM) brings a slow base unit to OP, enables it and loses no cycle"""
    def run(options):
        done = with_twins(ectwin, [*options, "vr-bu-ect-map7"], controller, "{}", "--seconds", "3")
        events = [json.loads(line) for line in done.stdout.splitlines()]
        expect(f"{options}: exit code, {done.stderr}", 0, done.returncode)
        expect(f"{options}: enabled", True, any(event["event"] == "enabled" for event in events))
        expect(f"{options}: lost cycles", 0, events[-1]["lost_cycles"])
    for_each(run, SLOW)


def judged(ectwin, conform, _):
    """No conformance case fails in a slow twin. (CF-083 sends frames as fast as it can until 500 mails are answered.)"""
    def run(options):
        skipped = ["--skip", "CF-083"] if "--mailbox-delay" in options else []
        done = with_twins(ectwin, [*options, "fzm1"], conform, "-i", "{}", "--format", "json", *skipped)
        failed = [(c["id"], c["reason"]) for c in json.loads(done.stdout)["cases"] if c["verdict"] in ("fail", "interrupted")]
        expect(f"{options}: cases that fail", [], failed)
    for_each(run, JUDGED)


def captured(ectwin, conform, *options):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.pcapng"
        with_twins(ectwin, [*options, "fzm1"], conform, "-i", "{}", "--only", "CF-03*,CF-06*,CF-07*", "--pcap", str(path))
        return hashlib.sha256(path.read_bytes()).hexdigest()


def seeded(ectwin, conform, _):
    """The same seed gives the same frames at the same times, another one others"""
    def run(options):
        first, again, other = (captured(ectwin, conform, *options, "--seed", seed) for seed in ("5", "5", "6"))
        expect(f"{options}: two runs of a seed are equal", True, first == again)
        expect(f"{options}: runs of two seeds are equal", False, first == other)
    for_each(run, SLOW[:3])


def expect_refusal(ectwin, options, part):
    done = with_twins(ectwin, options, "true")
    expect(f"{options}: exit code", 1, done.returncode)
    expect(f"{options}: '{part}' in {done.stderr!r}", True, part in done.stderr)


def refused(ectwin, _, __):
    """A wrong value, a board that does not exist, a device that does not fit: one line, exit code 1"""
    for options, part in ((["--al-delay", "5..1", "fzm1"], "--al-delay takes MIN or MIN..MAX"),
                          (["--mailbox-delay", "60001", "fzm1"], "0 to 60000"), (["--jitter", "1..", "fzm1"], "0 to 1000000"),
                          (["--dc-jitter", "-1", "fzm1"], "--dc-jitter"), (["--like", "x", "fzm1"], "'--like help' lists"),
                          (["--like", "2:lan9252-spi", "fzm1"], "counted from 1 to 1")):
        expect_refusal(ectwin, options, part)
    with tempfile.TemporaryDirectory() as folder: # two mailboxes of 1024 bytes, and 1144 bytes of inputs
        path = pathlib.Path(folder) / "large.xml"
        text = (ROOT / "esi/ectwin-optoncdt2300.xml").read_text()
        for old, new in (('"256"', '"1024"'), ('"#x1100"', '"#x1400"'), ('"#x1400" ControlByte="#x20"', '"#x2000" ControlByte="#x20"')):
            text = "".join(line.replace(old, new) if "<Sm " in line else line for line in text.splitlines(keepends=True))
        path.write_text(text)
        expect_refusal(ectwin, [*BOARD, f"esi:{path}"], "does not fit into the ESC of lan9252-spi")
    listed = subprocess.run([ectwin, "run", "--like", "help"], capture_output=True, text=True, check=True)
    expect("boards", ["lan9252-spi", "et1100-mmio"], [line.split()[0] for line in listed.stdout.splitlines()])


failures = 0
for test in (controlled, judged, seeded, refused):
    if len(sys.argv) > 4 and sys.argv[4] != test.__name__:
        continue
    try:
        test(*sys.argv[1:4])
        print(f"ok      {test.__doc__}")
    except AssertionError as error:
        failures += 1
        print(f"FAILED  {test.__doc__}\n  {error}\n  alone: slow.py {' '.join(sys.argv[1:4])} {test.__name__}")
sys.exit(failures != 0)
