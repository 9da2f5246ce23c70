#!/usr/bin/env python3
"""Worst-case stack of the slave core's entry points on a Cortex-M4, against tests/budget/stack.  usage: stack.py

The compiler writes frames and calls (-fcallgraph-info=su); the deepest path from an entry point is the bound. Calls through
pointers leave the core (PDI, device, services) or are one of the few callbacks inside it, which are listed here.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

TESTS = pathlib.Path(__file__).resolve().parent.parent
SRC = TESTS.parent / "src"
INSIDE = {"for_each": ["add_pdo", "add_mapping"], "ect_mailbox_poll": ["ect_coe_request"]}


def call_graph(work):
    frames, calls = {}, {}
    sources = sorted(SRC.glob("od/*.c")) + sorted(SRC.glob("slave/*.c"))
    for source in sources:
        subprocess.run(
            ["arm-none-eabi-gcc", "-std=c11", "-mcpu=cortex-m4", "-mthumb", "-Os", "-DNDEBUG", f"-I{SRC}",
             "-fcallgraph-info=su", "-c", str(source), "-o", f"{work}/{source.stem}.o"], check=True)
        text = pathlib.Path(f"{work}/{source.stem}.ci").read_text()
        for name, size in re.findall(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes', text):
            frames[name.split(":")[-1]] = int(size)
        for caller, callee in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls.setdefault(caller.split(":")[-1], set()).add(callee.split(":")[-1])
    for caller, callees in INSIDE.items():
        if caller in frames:
            calls.setdefault(caller, set()).update(callees)
    return frames, calls


def depth(name, frames, calls, path=()):
    if path.count(name) > (1 if name in INSIDE or name in ("add_pdo",) else 0):
        return 0
    below = [depth(callee, frames, calls, path + (name,)) for callee in calls.get(name, ())]
    return frames.get(name, 0) + max(below, default=0)


def main():
    with tempfile.TemporaryDirectory() as work:
        frames, calls = call_graph(work)
    failed = False
    for line in (TESTS / "budget/stack").read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        entry, limit = line.split()
        got = depth(entry, frames, calls)
        verdict = "ok" if 0 < got <= int(limit) else "OVER"
        failed |= verdict != "ok"
        print(f"Cortex-M4 -Os stack {entry:16} {got:4} bytes (limit {limit}) {verdict}")
    return 1 if failed else 0


sys.exit(main())
