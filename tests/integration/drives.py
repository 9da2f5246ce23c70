#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every CiA 402 drive of ESI files, as a twin, passes the cases CF-D01 to CF-D17 of the conformance runner.

usage: drives.py ECTWIN CONFORM PROBE [ESI-FOLDER DRIVES]

ESI-FOLDER has at least DRIVES drives. Without it the files are those below ECTWIN_ESI_FOLDER, such as files of vendors, at any depth; without both the
test is skipped. A file or device that cannot be a twin is left out, with a line; a device that is no drive is left out. The figures of --move come from the
objects of the drive.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ENVIRONMENT = os.environ | {"ASAN_OPTIONS": "detect_leaks=0"} # the library that is preloaded stays until the process ends
LONG = 600 # seconds; no assertion depends on them
RUNS = 2
SKIPPED = 77
DRIVE = re.compile(r"CiA 402: (axis .*)")
MODES = {"pp": "CF-D10", "pv": "CF-D11", "hm": "CF-D12", "csp": "CF-D13", "csv": "CF-D15", "tq": "CF-D16", "cst": "CF-D17"} # ip: 60C1h:1 in a PDO
TASK_SPEED, ENCODER, GEAR, FEED, MODES_OF_DRIVE = (0x6081, 0), 0x608F, 0x6091, 0x6092, 0x6502
RESOLUTION = 2 ** 20 # increments a turn of a twin without 608Fh


def run(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, timeout=LONG, env=ENVIRONMENT)


def in_process(ectwin, device, *command):
    return run(ectwin, "with", "--in-process", "--virtual-time", device, "--", *command)


# --- devices --------------------------------------------------------------------------------------------------------

def devices_of(ectwin, folder):
    """Operands of all devices of the ESI files below a folder."""
    found = []
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() == ".xml"):
        listed = run(ectwin, "list", f"esi:{path}")
        if listed.returncode:
            print(f"left out: {listed.stderr.strip()}")
        found += [f"esi:{path}#{number}" for number in re.findall(r"@0x\w+/0x\w+", listed.stdout)]
    return found


def values_of(ectwin, probe, device):
    """The values of a twin's dictionary by index and sub-index, and its axes with their modes: nothing when it is no drive."""
    with tempfile.TemporaryDirectory() as work:
        written = pathlib.Path(work) / "od.json"
        done = in_process(ectwin, device, probe, "-i", "{}", "--od", written, "--values")
        axes = DRIVE.search(done.stderr)
        if done.returncode or not written.exists():
            print(f"left out: {device}: {done.stderr.strip()}")
            return None, {}
        objects = json.loads(written.read_text())["objects"]
    return axes and axes.group(1).split(";"), {(o["index"], e["subindex"]): int.from_bytes(bytes.fromhex(e["value"]), "little")
                                               for o in objects for e in o["entries"] if e.get("value")}


def ratio(values, index, otherwise):
    above, below = values.get((index, 1), 0), values.get((index, 2), 0)
    return above / max(below, 1) if above > 0 else otherwise


def turn_of(values):
    """Position units of a turn of the motor, by 608Fh, 6091h and 6092h."""
    feed = ratio(values, FEED, 0)
    return feed / ratio(values, GEAR, 1) if feed > 0 else ratio(values, ENCODER, RESOLUTION)


def move(values):
    """A turn a second, or the profile velocity of the drive if that is slower; ramps of 100 ms."""
    speed = turn_of(values)
    if 0 < values.get(TASK_SPEED, 0) < speed:
        speed = values[TASK_SPEED]
    return f"{speed:.0f},{speed:.0f},{10 * speed:.0f}"


# --- verdicts -------------------------------------------------------------------------------------------------------

def judge(ectwin, conform, probe, device):
    """@return whether the device is a drive, and the lines of its failure"""
    axes, values = values_of(ectwin, probe, device)
    if not axes:
        return False, []
    arguments = ["--only", "CF-D*", "--move", move(values)]
    done = in_process(ectwin, device, conform, "-i", "{}", *arguments, "--format", "json")
    alone = f"  alone: {ectwin} with --in-process --virtual-time '{device}' -- {conform} -i {{}} {' '.join(arguments)}"
    try:
        cases = {case["id"]: case for case in json.loads(done.stdout)["cases"]}
    except json.JSONDecodeError:
        return True, [f"{device}: no report; exit code {done.returncode}", done.stderr.strip(), alone]
    verdicts = [case["verdict"] for case in cases.values()]
    wrong = [f"{device}: {id_} {case['verdict']}: {case['reason']}" for id_, case in cases.items() if case["verdict"] in ("fail", "interrupted")]
    print(f"{device}: {'; '.join(axes)}; --move {move(values)}: {verdicts.count('pass')} pass, {verdicts.count('warn')} warn, "
          f"{verdicts.count('skip')} skip, {len(wrong)} fail")
    for id_, case in cases.items():
        if case["verdict"] == "skip":
            print(f"  {id_} skip: {case['reason']}")
    return True, wrong + ([alone] if wrong else []) + missed(device, axes, values, cases)


def missed(device, axes, values, cases):
    """6502h has the modes that the twin names at its start; an axis of fewer modes than another one is judged in its own."""
    modes = set.intersection(*({word for word in axis.split(",")[0].split() if word in MODES} for axis in axes if axis.strip().startswith("axis")))
    return [f"{device}: {MODES[mode]} skipped: {cases[MODES[mode]]['reason']}" for mode in sorted(modes)
            if (MODES_OF_DRIVE, 0) in values and "has no mode" in cases[MODES[mode]]["reason"]]


def main():
    ectwin, conform, probe = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    folder = sys.argv[4] if len(sys.argv) > 4 else os.environ.get("ECTWIN_ESI_FOLDER")
    if not folder:
        print("skipped: ECTWIN_ESI_FOLDER names no folder")
        return SKIPPED
    devices = devices_of(ectwin, pathlib.Path(folder))
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        results = list(pool.map(lambda device: judge(ectwin, conform, probe, device), devices))
    drives = sum(is_drive for is_drive, _ in results)
    wrong = [line for _, lines in results for line in lines]
    print(*wrong, f"{drives} drives of {len(devices)} devices", sep="\n")
    least = int(sys.argv[5]) if len(sys.argv) > 5 else 1
    if drives < least:
        print(f"expected at least {least}")
    return bool(wrong) or drives < least


if __name__ == "__main__":
    sys.exit(main())
