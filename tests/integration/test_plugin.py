# SPDX-License-Identifier: MIT
"""The pytest plugin, tried by tests that it runs in a pytest of their own: pytest -p pytester -p ectwin.pytest_plugin."""

import os
import struct
import subprocess
import sys
import tempfile
import threading
import time

import ectwin as module
import pytest
from ectwin import _captures

# Masters without a library: the program builds its frames itself. A broadcast read of AL status counts the slaves.
BROADCAST = """
import os, socket, sys, time
def broadcast(interface):
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4)) as wire:
        wire.bind((interface, 0x88A4))
        wire.settimeout(120)
        wire.send(b"\\xff" * 6 + b"\\2" * 6 + b"\\x88\\xa4\\x0e\\x10" + bytes.fromhex("0701000030010200000000000000") + bytes(32))
        while True:
            reply = wire.recv(2000)
            if reply[6] & 2 and reply[16] == 7 and reply[28:30] != b"\\0\\0":
                return reply[28] + 256 * reply[29]
"""


@pytest.fixture
def run(pytester, monkeypatch, tmp_path):
    """Runs the text of a test file, with temporary files in a folder of this test; returns the result."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("PYTHONPATH", os.path.dirname(os.path.dirname(os.path.abspath(module.__file__))))

    def run_text(text, *args):
        pytester.makepyfile(test_it=BROADCAST + "import pytest\nimport subprocess\n" + text)
        return pytester.runpytest_inprocess("-p", "ectwin.pytest_plugin", "-p", "no:cacheprovider", *args)

    return run_text


def sockets():
    """Names of control sockets of this user."""
    folder = os.path.join(os.environ["XDG_RUNTIME_DIR"], "ectwin")
    return os.listdir(folder) if os.path.exists(folder) else []


def test_twins_and_programs_end_with_the_test(run, tmp_path):
    result = run(
        f"""
def test_it(ectwin):
    twin, other = ectwin("fzm1"), ectwin("fzm1,fzm1", set={{(2, "data1"): 5}})
    assert twin.namespace != other.namespace and twin.interface == "ecat0"
    assert (twin.get("data1"), other.get("data1", slave=2)) == (0, 5)
    child = twin.popen(["sh", "-c", "echo $$; exec sleep 100"], stdout=subprocess.PIPE)
    open("{tmp_path}/pid", "wb").write(child.stdout.readline())
"""
    )
    result.assert_outcomes(passed=1)
    assert sockets() == []
    assert not os.path.exists(f"/proc/{(tmp_path / 'pid').read_text().strip()}")


def test_programs_and_functions_run_in_the_network(run):
    run(
        """
def test_program(ectwin):
    twin = ectwin("fzm1,fzm1")
    code = open(__file__).read().split("import pytest")[0] + "print(broadcast(sys.argv[1]))"
    done = twin.run([sys.executable, "-c", code, twin.interface], stdout=subprocess.PIPE, text=True)
    assert (done.returncode, done.stdout) == (0, "2\\n")
    assert twin.run(["sh", "-c", "exit 7"]).returncode == 7

def test_function(ectwin):
    twins = [ectwin("fzm1"), ectwin("fzm1,fzm1,fzm1")]
    assert [twin.call(broadcast, twin.interface) for twin in twins] == [1, 3]
    with pytest.raises(OSError, match="No such device"):
        twins[0].call(broadcast, "nosuch0")

def test_function_beside_threads(ectwin):
    import threading
    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)
    thread.start()
    try:
        twin = ectwin("fzm1")
        assert twin.call(broadcast, twin.interface) == 1
    finally:
        stop.set()
        thread.join()
"""
    ).assert_outcomes(passed=3)


def test_a_failing_test_shows_its_twins(run):
    result = run(
        """
def test_it(ectwin):
    ectwin("fzm1,fzm1", set={(2, "data3"): 7.5}, faults=["delay 1us every 1000"])
    assert 0
"""
    )
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*ectwin: twins 1*", "*2:data3=7.5*", "fault: delay 1us every 1000", "frames 0, *"])


def captures():
    """The captures that tests have left, by path."""
    folders = [os.path.join(tempfile.gettempdir(), name) for name in os.listdir(tempfile.gettempdir()) if name.startswith("ectwin-")]
    return [os.path.join(folder, name) for folder in folders if os.path.isdir(folder) for name in os.listdir(folder)]


@pytest.mark.parametrize("mark", ["", "@pytest.mark.ectwin('fzm1', in_process=True)\n"], ids=["beside", "in process"])
def test_a_failing_test_keeps_its_capture_and_shows_the_events(run, mark):
    text = f"""
{mark}def test_it(ectwin):
    twin = ectwin("fzm1")
    assert twin.call(broadcast, twin.interface) == 1
    twin.set({{"data1": 4}})
    assert twin.call(broadcast, twin.interface) == WANTED
"""
    run(text.replace("WANTED", "1")).assert_outcomes(passed=1)
    assert captures() == []
    result = run(text.replace("WANTED", "2"))
    result.assert_outcomes(failed=1)
    (path,) = captures()
    assert f"capture: {path}" in result.stdout.str()
    with open(path, "rb") as file:
        kept = file.read()
    assert kept.startswith(b"\n\r\r\n") and b'"data1": 4' in kept
    result.stdout.fnmatch_lines(['*frame *: request: *"data1": 4*'])


def test_a_report_waits_for_the_frames_that_are_not_written_yet(tmp_path):
    path = tmp_path / "late.pcapng"
    block = struct.pack("<II20xI", 6, 32, 32)  # an Enhanced Packet Block without bytes
    path.write_bytes(block)

    def write():
        time.sleep(0.2)
        with path.open("ab") as file:
            file.write(block)

    writer = threading.Thread(target=write)
    writer.start()
    assert _captures.events(str(path), 9, 2) == [f"capture: {path}, 2 frames"]
    writer.join()
    assert _captures.events(str(path), 9) == [f"capture: {path}, 2 frames"]


def test_a_capture_can_be_left_out_or_be_the_own_one(run, tmp_path):
    failing = "\ndef test_it(ectwin):\n    ectwin('fzm1'%s)\n    assert 0\n"
    run(failing % "", "--ectwin-capture-size", "0").assert_outcomes(failed=1)
    run(failing % f", options=['--pcap', '{tmp_path}/own']").assert_outcomes(failed=1)
    assert captures() == [] and (tmp_path / "own").stat().st_size > 0


def test_what_cannot_start_fails_with_the_reason(run):
    result = run(
        """
def test_device(ectwin):
    ectwin("fzm2")

def test_none(ectwin):
    ectwin()
"""
    )
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines(["*there is no device 'fzm2'*", "*needs a device*"])


def test_the_marker_names_devices_and_options(run):
    run(
        """
@pytest.mark.ectwin("fzm1", set={"data1": 1, "data2": 2})
def test_it(ectwin):
    assert ectwin().values("data[12]") == {"data1": 1, "data2": 2}
    assert ectwin("fzm1,fzm1", set={"data1": 3}).values("data[12]") == {"data1": 3, "data2": 0}
""",
        "--strict-markers",
    ).assert_outcomes(passed=1)


def test_a_matrix_of_faults(run, tmp_path):
    (tmp_path / "faults").write_text("# two\nduplicate every 7\nduplicate every 8\n")
    result = run(
        """
def test_it(ectwin, ectwin_fault):
    twin = ectwin("fzm1", faults=["duplicate every 3"])
    print(ectwin_fault, twin.faults())

@pytest.mark.ectwin("fzm1", in_process=True, virtual_time=True)
def test_inside(ectwin):
    print("inside", ectwin().faults())

@pytest.mark.ectwin(matrix=False)
def test_out(ectwin):
    assert ectwin("fzm1").faults() == []

def test_without_twins():
    pass
""",
        *("--ectwin-faults", "duplicate every 4;  duplicate every 5", "--ectwin-faults", str(tmp_path / "faults"), "-rP"),
    )
    result.assert_outcomes(passed=8)
    for line in (
        "None ['duplicate every 3']",
        "5 ['duplicate every 3', 'duplicate every 4', 'duplicate every 5']",
        "faults ['duplicate every 3', 'duplicate every 7', 'duplicate every 8']",
        "inside []",
        "inside ['duplicate every 4', 'duplicate every 5']",
        "inside ['duplicate every 7', 'duplicate every 8']",
    ):
        assert line in result.stdout.str()


def test_a_test_with_the_twins_inside_its_process(run):
    result = run(
        """
@pytest.mark.ectwin("fzm1,fzm1", in_process=True, virtual_time=True, set={"data1": 2})
@pytest.mark.parametrize("number", [1, 2])
def test_virtual(ectwin, number):
    twin = ectwin()
    start = time.monotonic()
    time.sleep(3600)
    assert time.monotonic() - start >= 3600
    assert broadcast(twin.interface) == twin.call(broadcast, twin.interface) == 2
    twin.set({"data2": number})
    assert twin.values("data[12]") == {"data1": 2, "data2": number}

@pytest.mark.ectwin("fzm1", in_process=True)
def test_real(ectwin):
    assert broadcast(ectwin().interface) == 1

@pytest.mark.ectwin("fzm1", in_process=True)
def test_fails(ectwin):
    twin = ectwin()
    twin.set({"data5": 4.25})
    assert twin.get("data5") == 5

@pytest.mark.ectwin("fzm1", in_process=True)
def test_skips(ectwin):
    pytest.skip("not today")

@pytest.mark.ectwin("fzm1", in_process=True)
def test_crashes(ectwin):
    os.abort()

@pytest.mark.ectwin("nosuch", in_process=True)
def test_no_device(ectwin):
    pass
"""
    )
    result.assert_outcomes(passed=3, failed=3, skipped=1)
    result.stdout.fnmatch_lines(["*1:data5=4.25*"])
    result.stdout.fnmatch_lines(["*has ended with status 134, before the test was over"])
    result.stdout.fnmatch_lines(["*there is no device 'nosuch'*"])


def test_programs_with_the_twins_inside_them(run):
    run(
        """
def test_it(ectwin):
    twin = ectwin("fzm1", in_process=True, virtual_time=True, set={"data1": 6})
    code = open(__file__).read().split("import pytest")[0] + "time.sleep(100); print(broadcast(sys.argv[1]))"
    done = twin.run([sys.executable, "-c", code, "{}"], stdout=subprocess.PIPE, text=True)
    assert (done.returncode, done.stdout) == (0, "1\\n")
    with pytest.raises(Exception, match="no twin answers"):
        twin.get("data1")
    child = twin.popen([sys.executable, "-c", code + "; sys.stdout.flush(); sys.stdin.read()", "{}"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"1\\n"
    assert twin.get("data1") == 6
"""
    ).assert_outcomes(passed=1)


def test_in_parallel(run):
    pytest.importorskip("xdist", reason="pytest-xdist is not installed")
    text = """
@pytest.mark.parametrize("number", range(8))
def test_it(ectwin, number):
    twin = ectwin("fzm1", set={"data1": number})
    assert twin.get("data1") == number and twin.call(broadcast, twin.interface) == 1

@pytest.mark.ectwin("fzm1", in_process=True, virtual_time=True)
def test_inside(ectwin):
    assert broadcast(ectwin().interface) == 1
"""
    run(text, "-p", "xdist", "-n", "4").assert_outcomes(passed=9)


def test_the_types_are_strict():
    pytest.importorskip("mypy", reason="mypy is not installed")
    folder = os.path.dirname(os.path.dirname(os.path.abspath(module.__file__)))
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", os.devnull, "-p", "ectwin"],
        cwd=folder, stdout=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    assert done.stdout.startswith("Success"), done.stdout
