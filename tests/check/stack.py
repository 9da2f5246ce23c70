#!/usr/bin/env python3
"""Worst-case stack of entry points on a Cortex-M4, against tests/budget/stack.  usage: stack.py

The compiler writes frames and calls (-fcallgraph-info=su); the deepest path from an entry point is the bound. Calls through
pointers leave for PDI, device and object services, which are not counted, or are one of the few that stay inside: these are
listed here, and so is how often a function may be its own caller.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

TESTS = pathlib.Path(__file__).resolve().parent.parent
SRC = TESTS.parent / "src"
ROOMS = ("od", "slave", "esc")
INSIDE = {  # (file, function or None: any that calls through a pointer there): what is called
    ("pdo.c", "for_each"): ["pdo.c:add_pdo", "pdo.c:add_mapping"],
    ("mailbox.c", None): ["sdo.c:request", "sdo_info.c:request", "emergency.c:next", "sdo_info.c:next"],
    ("registers.c", None): [name if name.startswith("ect_") else f"registers.c:{name}" for name in sorted(set(re.findall(
        r"\b(?:ect_esc|write|read)_\w+", " ".join(re.findall(r"^    \{ECT_REG_.*\},$", (SRC / "esc/registers.c").read_text(),
                                                              re.M)))))],  # its table
}
AGAIN = {"pdo.c:for_each": 2}  # a PDO in an assignment


def key(title):
    """`function`, or `file.c:function` where it is private to a file."""
    path, _, name = title.rpartition(":")
    name = name.partition(".")[0]  # without .constprop and its like
    return f"{pathlib.Path(path).name}:{name}" if path else name


def call_graph(work, sources, flags=()):
    """Frames in bytes by function, the calls between functions, and their files."""
    frames, calls, files = {}, {}, {}
    for number, source in enumerate(sources):
        info = f"{work}/{number}"
        subprocess.run(
            ["arm-none-eabi-gcc", "-std=c11", "-mcpu=cortex-m4", "-mthumb", "-Os", "-DNDEBUG", f"-I{SRC}", *flags,
             "-fcallgraph-info=su", "-c", str(source), "-o", f"{info}.o"], check=True)
        text = pathlib.Path(f"{info}.ci").read_text()
        for title, size in re.findall(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes', text):
            frames[key(title)] = int(size)
            files[key(title)] = source
        for caller, callee in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls.setdefault(key(caller), set()).add(key(callee))
    here = {source.name for source in sources}
    for (file, function), callees in INSIDE.items():
        if file not in here:
            continue
        holders = [f for f in calls if "__indirect_call" in calls[f] and files[f].name == file and (function or f) in f]
        if not holders or any(f not in frames for f in callees):
            sys.exit(f"{file}: its calls through pointers are not those that {pathlib.Path(__file__).name} knows")
        for holder in holders:
            calls[holder].update(callees)
    return frames, calls, files


def depth(name, frames, calls, path=()):
    """Bytes of the deepest path from a function down, its own frame included."""
    if path.count(name) >= AGAIN.get(name, 1):
        return 0
    below = [depth(callee, frames, calls, path + (name,)) for callee in calls.get(name, ())]
    return frames.get(name, 0) + max(below, default=0)


def main():
    with tempfile.TemporaryDirectory() as work:
        frames, calls, _ = call_graph(work, [source for room in ROOMS for source in sorted(SRC.glob(f"{room}/*.c"))])
    failed = False
    for line in (TESTS / "budget/stack").read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        entry, limit = line.split()
        got = depth(entry, frames, calls)
        verdict = "ok" if 0 < got <= int(limit) else "OVER"
        failed |= verdict != "ok"
        print(f"Cortex-M4 -Os stack {entry:18} {got:4} bytes (limit {limit}) {verdict}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
