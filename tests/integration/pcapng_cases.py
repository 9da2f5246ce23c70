"""The frame of the tests of captures and records: comparisons, programs, blocks of a pcapng file, the loop over the cases."""
import pathlib
import struct
import subprocess
import sys
import tempfile

FAILED = []


def expect(what, wanted, got):
    if wanted != got:
        FAILED.append(what)
        print(f"{what}: expected {wanted!r}, got {got!r}")


def call(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=100, check=False)


def blocks(path):
    """(type, body) of each block of a file, which must be whole."""
    data, at = path.read_bytes(), 0
    while at < len(data):
        kind, total = struct.unpack_from("<II", data, at)
        assert total >= 12 and at + total <= len(data) and struct.unpack_from("<I", data, at + total - 4)[0] == total, f"block at {at}"
        yield kind, data[at + 8:at + total - 4]
        at += total


def run_cases(cases, names):
    """Runs the cases, or those that are named, each with a file of its own; ends the program with 0 or 1."""
    for case in cases:
        if names and case.__name__ not in names:
            continue
        before = len(FAILED)
        with tempfile.TemporaryDirectory() as folder:
            case(pathlib.Path(folder) / "run.pcapng")
        print("ok" if len(FAILED) == before else "FAILED", case.__name__, case.__doc__)
    sys.exit(1 if FAILED else 0)
