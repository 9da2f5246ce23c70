#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Clones of random twins and of a SOES application (CLN-015): `verify` finds no difference, a clone of the clone is the same byte by byte.

usage: clones.py ECTWIN ESI-FOLDER | clones.py ECTWIN --external 'SOES-SLAVE ARG...'

ECTWIN_SEED=N chooses other twins (default 1), ECTWIN_TWINS=N their number (default 50). ECTWIN_ESI_FOLDER=DIR takes them from the ESI
files below DIR, such as those of vendors, in place of ESI-FOLDER and of random device files. A file or device that cannot be a twin is
left out, with a line.
"""
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

SEED = int(os.environ.get("ECTWIN_SEED", "1"))
TWINS = int(os.environ.get("ECTWIN_TWINS", "50"))
VENDORS = os.environ.get("ECTWIN_ESI_FOLDER")
A_BUS = 10  # twins
LONG = 900  # seconds; no assertion depends on them
TRIES = 20
TYPES = ["BOOL", "BIT3", "USINT", "UINT", "UDINT", "ULINT", "SINT", "INT", "DINT", "LINT", "REAL", "LREAL", "STRING(7)", "BYTES(5)"]
INTEGERS = {"USINT": 8, "UINT": 16, "UDINT": 32, "INT": 15, "DINT": 31}
MAPPED = ["USINT", "UINT", "UDINT", "INT", "DINT", "REAL", "BYTES(5)"]


def expect(what, wanted, got):
    if wanted != got:
        raise AssertionError(f"seed {SEED}: {what}: expected {wanted!r}, got {got!r}")


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, timeout=LONG, **options)


# --- random device files -------------------------------------------------------------------------------------------------------------

def entry(rng, kind):
    """Keys of a value of a type: limits, default, unit, access."""
    keys = [f"type: {kind}"]
    if kind in INTEGERS and rng.random() < 0.5:
        most = rng.randrange(3, 2 ** INTEGERS[kind])
        keys += [f"min: {rng.randrange(2)}", f"max: {most}", f"default: {rng.randrange(1, most)}"]
    elif kind == "STRING(7)":
        keys.append(f"default: {rng.choice(['abc', 'x', 'seven 7'])}")
    elif kind == "REAL":
        keys.append(f"default: {rng.randrange(100)}.5")
    if rng.random() < 0.3:
        keys.append(f"unit: {rng.choice(['um', 'mm/s', 'degC', 'kHz'])}")
    return keys


def objects(rng, first, indent):
    """A value, an array and a record; their lines."""
    lines = []
    for n in range(rng.randrange(1, 4)):
        index, kind = first + n, rng.choice(TYPES)
        access = f"access: {rng.choice(['ro', 'rw'])}"
        shape = rng.choice(["value", "array", "record"])
        if shape == "record":
            entries = ", ".join(f"{{name: E{k}, {', '.join(entry(rng, rng.choice(TYPES)))}, {access}}}" for k in range(rng.randrange(1, 5)))
            lines.append(f"{indent}0x{index:04X}: {{name: R{n}, entries: [{entries}]}}")
        else:
            more = [f"array: {rng.randrange(1, 9)}"] if shape == "array" else []
            lines.append(f"{indent}0x{index:04X}: {{name: V{n}, {', '.join([*entry(rng, kind), *more, access])}}}")
    return lines


def process_data(rng, first, indent):
    """Objects of process data, 16 bits or more each, and the list that maps them."""
    indices = range(first, first + rng.randrange(1, 4))
    return [f"{indent}0x{i:04X}: {{name: P{i:X}, type: {rng.choice(MAPPED)}}}" for i in indices], [f"0x{i:04X}" for i in indices]


def device_file(rng, number):
    """A device file of random content, and the modules that its slots accept."""
    inputs, mapped_in = process_data(rng, 0x6100, "  ")
    outputs, mapped_out = process_data(rng, 0x7100, "  ")
    size = rng.choice([64, 128, 256])
    lines = ["ectwin-device: 1", "vendor: {id: 0x00000E57, name: Example Works}", f"product: {0x7000 + number}", f"type: RANDOM-{number}",
             f"mailbox: {{size: {size}, complete-access: {rng.choice(['true', 'false'])}, repeat: {rng.choice(['true', 'false'])}}}",
             "objects:", *objects(rng, 0x2000, "  "), *inputs, *outputs,
             f"inputs: [{{pdo: 0x1AF0, entries: [{', '.join(mapped_in)}]}}]",
             f"outputs: [{{pdo: 0x16F0, entries: [{', '.join(mapped_out)}]}}]"]
    if rng.random() < 0.5:
        lines.append(f"dc: [{rng.choice(['free-run', 'free-run, sync0', 'sync01'])}]")
    if rng.random() < 0.5:
        return lines, []
    lines += ["slots:", "  - {name: Head, default: 0x101, modules: [0x101]}", "  - {name: IO, count: 2}", "modules:"]
    for ident in (0x101, 0x102):
        own, mapped = process_data(rng, 0x6000, "      ")
        lines += [f"  {ident}:", f"    name: M{ident:X}", "    objects:", *own, *objects(rng, 0x8000, "      "),
                  f"    inputs: [{', '.join(mapped)}]"]
    return lines, [0x101, 0x102]


def random_devices(ectwin, rng, folder, count):
    """Operands of twins from random device files, each by way of its ESI file."""
    made = []
    for number in range(count):
        lines, modules = device_file(rng, number)
        source, esi = folder / f"r{number}.yaml", folder / f"r{number}.xml"
        source.write_text("\n".join(lines) + "\n")
        done = run(ectwin, "esi", f"yaml:{source}", "-o", esi)
        expect(f"{source.read_text()}{done.stderr}: exit code", 0, done.returncode)
        made.append((f"esi:{esi}", modules))
    return made


# --- ESI files -----------------------------------------------------------------------------------------------------------------------

def devices_of(ectwin, folder):
    """Operands of all devices of the ESI files below a folder."""
    found = []
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() == ".xml"):
        listed = run(ectwin, "list", f"esi:{path}")
        if listed.returncode:
            print(f"left out: {listed.stderr.strip()}")
        found += [(f"esi:{path}#{number}", []) for number in re.findall(r"@0x\w+/0x\w+", listed.stdout)]
    return found


def draw(ectwin, rng, pool, count):
    """Twins of the pool that can run, drawn with replacement."""
    drawn, refused = [], set()
    while len(drawn) < count:
        expect("devices that can be twins", True, len(refused) < len(pool))
        number = rng.randrange(len(pool))
        checked = run(ectwin, "check", "--quiet", pool[number][0]) if number not in refused else None
        if checked and checked.returncode == 0:
            drawn.append(pool[number])
        elif checked:
            refused.add(number)
            print(f"left out: {checked.stderr.strip()}")
    return drawn


# --- clones --------------------------------------------------------------------------------------------------------------------------

def clone_and_verify(ectwin, bus, folder, work):
    """Clones a bus to a folder, and compares it with the folder. On the wall clock a machine that stands still lets a slave be late:
    a reading without an end is repeated."""
    script = work / "script.sh"
    script.write_text(f"rm -rf '{folder}'\n'{ectwin}' clone --preop -i \"$1\" -o '{folder}' || exit\n"
                      f"'{ectwin}' verify '{folder}' \"slave:$1\"\n")
    for _ in range(TRIES if "--external" in bus else 1):
        done = run(ectwin, "with", *bus, "--", "sh", script, "{}", env={**os.environ, "SOURCE_DATE_EPOCH": "0"})
        differences = [line for line in done.stdout.splitlines() if not re.match(r"\d+ .* EEPROM \d+ bytes", line)]
        if done.returncode == 0 or differences:
            break
    expect(f"{bus}: differences", [], differences)
    expect(f"{bus}: exit code, {done.stdout}{done.stderr}", 0, done.returncode)
    return sorted(path.name for path in folder.glob("*.xml"))


def same_files(first, second):
    for path in sorted(first.iterdir()):
        expect(f"{path}: bytes in the second clone", path.read_bytes(), (second / path.name).read_bytes())
    expect("files of the second clone", sorted(p.name for p in first.iterdir()), sorted(p.name for p in second.iterdir()))


def clones_of(ectwin, bus, count, work):
    """A clone of a bus, a clone of the clone, and both compared."""
    one, two = work / "one", work / "two"
    virtual = ["--in-process", "--virtual-time"]
    expect(f"{bus}: files of slaves", count, len(clone_and_verify(ectwin, bus, one, work)))
    clone_and_verify(ectwin, [*virtual, one / "bus.yaml"], two, work)
    same_files(one, two)


def random_twins(ectwin, files):
    rng = random.Random(SEED)
    with tempfile.TemporaryDirectory() as folder:
        pool = devices_of(ectwin, files)
        if not VENDORS:
            pool += random_devices(ectwin, rng, pathlib.Path(folder), TWINS // 2)
        twins = draw(ectwin, rng, pool, TWINS)
        for first in range(0, len(twins), A_BUS):
            some = twins[first:first + A_BUS]
            words = ["--in-process", "--virtual-time"]
            for n, (_, modules) in enumerate(some, 1):
                words += ["--serial", f"{n}:{rng.randrange(1, 2 ** 32)}", "--alias", f"{n}:{rng.randrange(1, 2 ** 16)}"]
                words += ["--module", f"{n}:{rng.randrange(2, 4)}={rng.choice(modules)}"] if modules else []
            with tempfile.TemporaryDirectory() as work:
                clones_of(ectwin, [*words, ",".join(name for name, _ in some)], len(some), pathlib.Path(work))


def soes_application(ectwin, command):
    """Its clone is a twin on the virtual clock."""
    with tempfile.TemporaryDirectory() as work:
        clones_of(ectwin, ["--external", command], 1, pathlib.Path(work))


if __name__ == "__main__":
    program = os.path.abspath(sys.argv[1])
    if sys.argv[2] == "--external":
        soes_application(program, sys.argv[3])
    else:
        random_twins(program, pathlib.Path(VENDORS or sys.argv[2]))
