# SPDX-License-Identifier: MIT
"""The pytest plugin: the fixture `ectwin` starts twins for a test, and ends them with it (docs/PYTHON.md).

    def test_op(ectwin):
        twin = ectwin("fzm1")
        assert twin.run([sys.executable, "master.py", twin.interface]).returncode == 0
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import textwrap
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import pytest

from . import _captures, _twin
from ._errors import Error
from ._twin import Devices, Twin

_NAME = "ECTWIN_PYTEST_NAME"  # of the twins inside this process, in the new process of one test
_CAPTURES = "ECTWIN_PYTEST_CAPTURES"  # their folder, in the new process of one test
_MARK_OPTIONS = {"matrix"}  # of the marker, not of a start
_EVENTS = 40  # lines of a capture in the report of a failing test


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the plugin."""
    group = parser.getgroup("ectwin", "EtherCAT device twins")
    group.addoption("--ectwin-program", metavar="PATH", help="the command (default: $ECTWIN, or ectwin in PATH)")
    group.addoption(
        "--ectwin-faults",
        action="append",
        default=[],
        metavar="FAULT[;FAULT...]",
        help="run each test that uses twins once without faults, and once more with these faults, as 'drop 2%%' or "
        "'at slave 1 OP corrupt 1%%', or a file of faults; may be repeated",
    )
    group.addoption(
        "--ectwin-capture-size",
        default="16M",
        metavar="BYTES[K|M|G]",
        help="most bytes of the capture of a test's twins, which is kept when the test fails (default 16M; 0: no capture)",
    )
    group.addoption("--ectwin-report", metavar="FILE", help="write the reports to FILE; for the new process of one test")


def pytest_configure(config: pytest.Config) -> None:
    """The marker."""
    config.addinivalue_line(
        "markers",
        "ectwin(devices, **options): twins that ectwin() without arguments starts, with the options of ectwin.start(); "
        "in_process=True runs the test in a new process with these twins inside; matrix=False leaves the test out of "
        "--ectwin-faults",
    )


# --- the fixture -------------------------------------------------------------------------------------------------------


def _mark(item: pytest.Item) -> Tuple[Optional[Devices], Dict[str, Any]]:
    """Devices and options of the marker; the nearest one applies."""
    mark = item.get_closest_marker("ectwin")
    if mark is None:
        return None, {}
    options = {key: value for key, value in mark.kwargs.items() if key not in _MARK_OPTIONS}
    devices = mark.args[0] if mark.args else options.pop("devices", None)
    return devices, options


def _split(faults: str) -> Union[str, List[str]]:
    return faults if os.path.exists(faults) else [fault.strip() for fault in faults.split(";") if fault.strip()]


def _with_faults(options: Dict[str, Any], faults: Optional[str]) -> Dict[str, Any]:
    """Options with the faults of the matrix, in addition to those of the test."""
    if faults is None:
        return options
    more, own = _split(faults), options.get("faults", ())
    words = list(options.get("options", ()))
    for some in (own, more):
        for fault in [] if isinstance(some, str) else some:
            words += ["--fault", fault]
        words += ["--faults", some] if isinstance(some, str) else []
    return {**options, "faults": (), "options": words}


def _capture(config: pytest.Config, folder: str, number: int, options: Sequence[str]) -> List[str]:
    """The options of a command, with a capture in the folder unless they already have one."""
    size = config.getoption("--ectwin-capture-size")
    if size == "0" or any(option.startswith("--pcap") for option in options):
        return list(options)
    return [*options, "--pcap", os.path.join(folder, f"{number}.pcapng"), "--pcap-size", size]


class Factory:
    """The fixture `ectwin`: called with the arguments of ectwin.start(), it starts twins that end with the test."""

    def __init__(self, item: pytest.Item, faults: Optional[str]) -> None:
        self.twins: List[Twin] = []
        self.failed = False
        self.folder = os.environ.get(_CAPTURES) or tempfile.mkdtemp(prefix="ectwin-")
        self._item = item
        self._faults = faults

    def __call__(self, devices: Optional[Devices] = None, *args: Any, **options: Any) -> Twin:
        marked, more = _mark(self._item)
        if _NAME in os.environ and devices in (None, marked):
            return self._own()
        named = marked if devices is None else devices
        if named is None:
            raise Error('ectwin() needs a device: ectwin("fzm1"), or @pytest.mark.ectwin("fzm1")')
        chosen = {**more, **options}
        config = self._item.config
        chosen.setdefault("program", config.getoption("--ectwin-program"))
        chosen = _with_faults(chosen, self._faults)
        if len(args) < 2:  # the options are not among them
            chosen["options"] = _capture(config, self.folder, len(self.twins) + 1, chosen.get("options", ()))
        twin = _twin.start(named, *args, **chosen)
        self.twins.append(twin)
        return twin

    def _own(self) -> Twin:
        """The twins inside this process, which are powered on when the interface is opened."""
        program = self._item.config.getoption("--ectwin-program")
        twin = _twin.OwnTwin(os.environ[_NAME], _twin._find_program(program))
        with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4)) as opened:
            opened.bind((twin.interface, 0x88A4))
        self.twins.append(twin)
        return twin

    def close(self) -> None:
        """Ends all twins, the newest first."""
        while self.twins:
            self.twins.pop().close()
        if _CAPTURES not in os.environ:
            _remove_captures(self.folder, self.failed)


def _remove_captures(folder: str, failed: bool) -> None:
    """Keeps the captures of a test that has failed."""
    if not failed or not os.listdir(folder):
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def ectwin_fault(request: pytest.FixtureRequest) -> Optional[str]:
    """The faults of --ectwin-faults that this run of a test has; None: none."""
    fault: Optional[str] = getattr(request, "param", None)
    return fault


@pytest.fixture
def ectwin(request: pytest.FixtureRequest, ectwin_fault: Optional[str]) -> Iterator[Factory]:  # pylint: disable=redefined-outer-name
    """Starts twins: ectwin("fzm1"), with the arguments of ectwin.start(). They end with the test."""
    factory = Factory(request.node, ectwin_fault)
    yield factory
    factory.close()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """The matrix of --ectwin-faults."""
    faults = metafunc.config.getoption("--ectwin-faults")
    mark = metafunc.definition.get_closest_marker("ectwin")
    if not faults or "ectwin_fault" not in metafunc.fixturenames or (mark and not mark.kwargs.get("matrix", True)):
        return
    metafunc.parametrize("ectwin_fault", [None, *faults], indirect=True, ids=["no fault", *faults])


# --- a failing test ----------------------------------------------------------------------------------------------------


def _describe(twin: Twin) -> Tuple[str, int]:
    """The present signals, faults and counters of the twins; the number of frames in their capture."""
    lines = []
    captured = 0
    try:
        shown = [f"{slave}:{name}={value}" for (slave, name), value in twin._values("*", 0).items() if value not in (0, "")]
        lines += textwrap.wrap("  ".join(shown), 110, break_long_words=False, break_on_hyphens=False)
        lines.append("(all other signals are 0 or empty)")
        lines += [f"fault: {fault}" for fault in twin.faults()]
        counters = twin.stats()
        numbers = {name: value for name, value in counters.items() if not isinstance(value, (list, dict))}
        lines.append(", ".join(f"{name} {value}" for name, value in numbers.items()))
        captured = int(counters.get("captured", 0))
    except Error as error:
        lines.append(str(error))
    messages = twin.messages()
    return "\n".join(lines + ([messages.rstrip()] if messages else [])), captured


def _describe_captures(folder: str, number: int, frames: int) -> List[str]:
    """The captures of the twins with this number: one, of so many frames, or with in_process one for each program."""
    names = sorted(name for name in os.listdir(folder) if name.startswith(f"{number}.pcapng"))
    lines = []
    for name in names:
        lines += _captures.events(os.path.join(folder, name), _EVENTS, frames if len(names) == 1 else 0)
    return lines


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """Attaches signals, faults, counters and capture of each twin to the report of a test that fails."""
    outcome: Any = yield
    report = outcome.get_result()
    factory = getattr(item, "funcargs", {}).get("ectwin")
    if report.failed and isinstance(factory, Factory):
        for number, twin in enumerate(factory.twins, 1):
            present, frames = _describe(twin)
            text = "\n".join([present, *_describe_captures(factory.folder, number, frames)])
            report.sections.append((f"ectwin: twins {number} at '{twin.path}'", text))
        factory.failed = True


# --- a test in a new process, with the twins inside --------------------------------------------------------------------


def _child_command(
    item: pytest.Item, devices: Devices, options: Dict[str, Any], report: str, folder: str
) -> List[str]:
    config = item.config
    options["options"] = _capture(config, folder, 1, options.get("options", ()))
    program = options.pop("program", None) or config.getoption("--ectwin-program")
    options.pop("in_process")
    words = ["--virtual-time"] if options.pop("virtual_time", False) else []
    words += _twin._words(
        options.pop("options", ()), options.pop("set", None), options.pop("faults", ()), f"pytest{os.getpid()}"
    )
    if options:
        raise Error(f"the marker has options that a start does not know: {', '.join(options)}")
    node = str(item.path) + item.nodeid[item.nodeid.index("::") :]
    command = [_twin._find_program(program), "with", "--in-process", *words]
    command += [devices if isinstance(devices, str) else ",".join(devices), "--", sys.executable, "-m", "pytest", node]
    command += ["-q", "--rootdir", str(config.rootpath), "--ectwin-report", report, "-p", "no:cacheprovider"]
    command += ["-c", str(config.inipath)] if config.inipath else []
    command += [] if config.pluginmanager.hasplugin("ectwin") else ["-p", "ectwin.pytest_plugin"]
    command += ["-p", "no:xdist"] if config.pluginmanager.hasplugin("xdist") else []
    for fault in config.getoption("--ectwin-faults"):
        command += ["--ectwin-faults", fault]
    return command


def _run_in_process(item: pytest.Item, devices: Devices, options: Dict[str, Any]) -> List[pytest.TestReport]:
    parameters = getattr(getattr(item, "callspec", None), "params", {})
    options = _with_faults(options, parameters.get("ectwin_fault"))
    folder = tempfile.mkdtemp(prefix="ectwin-")
    with tempfile.NamedTemporaryFile("r", prefix="ectwin-", suffix=".jsonl") as file:
        command = _child_command(item, devices, options, file.name, folder)
        environment = {**os.environ, _NAME: f"pytest{os.getpid()}", _CAPTURES: folder}
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment, check=False
        )
        lines = [json.loads(line) for line in file]
    reports = [item.config.hook.pytest_report_from_serializable(config=item.config, data=line) for line in lines]
    ended = bool(reports) and reports[-1].when == "teardown"
    _remove_captures(folder, not ended or any(report.failed for report in reports))
    if ended:
        return reports
    text = done.stdout.decode(errors="replace")
    text += f"\nthe process of this test has ended with status {done.returncode}, before the test was over"
    return [*reports, _failure(item, text)]


def _failure(item: pytest.Item, text: str) -> pytest.TestReport:
    return pytest.TestReport(item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "failed", text, "call")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Optional[bool]:
    """A test whose marker has in_process=True runs in a new process under `ectwin with --in-process`."""
    devices, options = _mark(item)
    if _NAME in os.environ or not options.get("in_process") or devices is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    try:
        reports: Sequence[pytest.TestReport] = _run_in_process(item, devices, options)
    except Error as error:
        reports = [_failure(item, str(error))]
    for report in reports:
        report.nodeid = item.nodeid
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


class _Reporter:
    """Writes each report as a line of JSON."""

    def __init__(self, config: pytest.Config, path: str) -> None:
        self._config = config
        self._path = path

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """One report."""
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(json.dumps(data) + "\n")


def pytest_sessionstart(session: pytest.Session) -> None:
    """In the process of one test: writes its reports to the file that the first process reads."""
    path = session.config.getoption("--ectwin-report")
    if path:
        session.config.pluginmanager.register(_Reporter(session.config, path), "ectwin-reporter")
