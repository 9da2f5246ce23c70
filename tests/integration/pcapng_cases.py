"""The frame of the tests of captures and records: comparisons, programs, blocks of a pcapng file, the loop over the cases."""
import contextlib
import io
import multiprocessing
import pathlib
import struct
import subprocess
import sys
import tempfile

FAILED = []
AT_A_TIME = 4


def expect(what, wanted, got):
    if wanted != got:
        FAILED.append(what)
        print(f"{what}: expected {wanted!r}, got {got!r}")


def call(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=300, check=False)


def blocks(path):
    """(type, body) of each block of a file, which must be whole."""
    data, at = path.read_bytes(), 0
    while at < len(data):
        kind, total = struct.unpack_from("<II", data, at)
        assert total >= 12 and at + total <= len(data) and struct.unpack_from("<I", data, at + total - 4)[0] == total, f"block at {at}"
        yield kind, data[at + 8:at + total - 4]
        at += total


def run_case(case):
    """@return whether it has failed, and its output"""
    output = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(output):
        case(pathlib.Path(folder) / "run.pcapng")
    return bool(FAILED), output.getvalue()


def run_cases(cases, names):
    """Runs the cases, or those that are named, each in a process and with a file of its own; ends the program with 0 or 1. Several run side
    by side, because most of them wait."""
    chosen = [case for case in cases if not names or case.__name__ in names]
    with multiprocessing.get_context("fork").Pool(AT_A_TIME, maxtasksperchild=1) as pool:
        results = pool.map(run_case, chosen, chunksize=1)
    for case, (failed, output) in zip(chosen, results):
        print(f"{output}{'FAILED' if failed else 'ok'} {case.__name__} {case.__doc__}")
    sys.exit(1 if not chosen or any(failed for failed, _ in results) else 0)
