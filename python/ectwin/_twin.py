# SPDX-License-Identifier: MIT
"""Twins: already running ones, and twins started by this program."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from typing import IO, Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, TypeVar, Union

from . import _network, programs
from ._control import PATIENCE, Connection, Signal, Slave, Value, Watch, each, find, open_named, path_of, readable
from ._errors import Error, Refused

Result = TypeVar("Result")
Devices = Union[str, Sequence[str]]
Settings = Mapping[Any, Union[Value, bool, bytes]]

_READY = 20.0  # seconds until a start is due, on a very busy machine
_PLUGS = ("ecat.plug_in", "ecat.plug_out", "ecat.plug_2", "ecat.plug_3")
# The command in a private network: reports its start, and ends with this program.
_HOLD = 'printf "%s\\n" "$ECTWIN_SOCKET" "$ECTWIN_IFACE" "$ECTWIN_IFACE2" "$ECTWIN_MODBUS" ""; exec cat >/dev/null'


def _text(value: Union[Value, bool, bytes]) -> Union[Value, bool]:
    return value.hex() if isinstance(value, (bytes, bytearray)) else value


def _option(value: Union[Value, bool, bytes]) -> str:
    plain = _text(value)
    return str(int(plain)) if isinstance(plain, bool) else str(plain)


class Twin:
    """A chain of running twins. `slave` counts from 1, or is the name of a twin; 0, if several are possible: all twins.
    The name of a signal may begin with that of its twin: get("gripper.data1").

    A value is an int, a float, or a str (texts, and bytes as hexadecimal digits). A Twin is a context manager: at the end of its
    block the connection is closed, and twins started by this program end.
    """

    def __init__(self, path: Optional[str] = None, process: Optional["subprocess.Popen[Any]"] = None) -> None:
        self._process = process
        self._children: List["subprocess.Popen[Any]"] = []
        self._log: Optional[IO[bytes]] = None
        self._connection: Optional[Connection] = None
        self._program: Optional[str] = None
        #: Name of the interface for a master, None: unknown until `about`.
        self.interface: str = os.environ.get("ECTWIN_IFACE", "")
        #: The second interface, "": none.
        self.interface2: str = os.environ.get("ECTWIN_IFACE2", "")
        #: Address of the Modbus server, "": none.
        self.modbus: str = ""
        if path is None and process is None:
            path = os.environ.get("ECTWIN_SOCKET")
        if path is None:
            #: Path of the control socket.
            self.path, connection = find(process.pid if process else None)
            self._connection = Connection(connection)
        else:
            self.path = path_of(path)
            self._connection = self._open()

    def _open(self) -> Connection:
        return Connection(open_named(self.path))

    def _ask(self, request: Dict[str, Any]) -> List[Dict[str, Any]]:
        if self._connection is None:
            self._connection = self._open()
        return self._connection.ask(request)

    # --- signals --------------------------------------------------------------------------------------------------

    def get(self, name: str, slave: Slave = 1) -> Value:
        """The value of one signal."""
        values = self._values(name, slave)
        if len(values) != 1:
            raise Error(f"'{name}' is not one signal, but {len(values)}: values() gives several")
        return next(iter(values.values()))

    def _values(self, pattern: str, slave: Slave) -> Dict[Tuple[int, str], Value]:
        lines = self._ask({"op": "get", "pattern": pattern, "slave": slave})
        return {(line["slave"], line["name"]): line["value"] for line in lines}

    def values(self, pattern: str = "*", slave: Slave = 1) -> Dict[Any, Value]:
        """The signals that match a shell pattern: {name: value}, of all slaves {(slave, name): value}."""
        values = self._values(pattern, slave)
        return dict(values) if slave == 0 else {name: value for (_, name), value in values.items()}

    def signals(self, pattern: str = "*", slave: Slave = 1) -> List[Signal]:
        """The signals of a slave, with range and meaning."""
        lines = self._ask({"op": "list", "pattern": pattern, "slave": slave})
        return [Signal(**{field: line[field] for field in Signal._fields if field in line}) for line in lines]

    def set(self, values: Settings, slave: Slave = 1) -> None:
        """Sets {name: value}: all or none. A value of type bytes is sent as hexadecimal digits."""
        self._ask({"op": "set", "values": {name: _text(value) for name, value in values.items()}, "slave": slave})

    def command(self, remote: str, data: Union[bytes, bytearray], slave: Slave = 1) -> None:
        """An operator's command of 16 bytes from a remote unit of a base unit: command("ru1", bytes(16))."""
        self.set({f"{remote}.command": bytes(data)}, slave)

    def watch(self, pattern: str = "*", slave: Slave = 1, every: bool = False) -> Watch:
        """A Watch on the matching signals, on a separate connection; `every`: every change, with its time."""
        return Watch(self._open(), {"op": "watch", "pattern": pattern, "slave": slave, "every": every})

    def wait(
        self, name: str, value: Union[Value, Callable[[Value], bool]], timeout: float = 10.0, slave: Slave = 1
    ) -> Value:
        """Waits until a signal has a value, or fulfils a condition: wait("temperature", lambda t: t > 40).

        Returns the value. Error: the condition was not fulfilled within `timeout` seconds.
        """
        end = time.monotonic() + timeout
        wanted = value if callable(value) else lambda current: bool(current == value)
        with self.watch(name, slave, every=True) as watch:
            if len(watch.values) != 1:
                raise Error(f"'{name}' is not the name of one signal")
            (current,) = watch.values.values()
            while not wanted(current):
                change = watch.next(max(0.0, end - time.monotonic()))
                if change is None:
                    text = "what it is waited for" if callable(value) else repr(value)
                    raise Error(f"{name} is {current!r}, not {text}, after {timeout} s")
                current = change.value
        return current

    def wait_for(self, name: str, value: Value, timeout: float = 10.0, slave: Slave = 1) -> None:
        """The former name of `wait`."""
        self.wait(name, value, timeout, slave)

    def periodic(self, slave: Slave = 1) -> bytes:
        """The last complete set of periodic data of a base unit; b"": none yet."""
        for _ in range(100):
            data, serial, size = b"", None, 1
            while len(data) < size:
                (line,) = self._ask({"op": "data", "slave": slave, "offset": len(data)})
                serial = line["serial"] if serial is None else serial
                size = line["size"] if line["serial"] == serial else -1
                data += bytes.fromhex(line["data"])
                if not line["data"]:
                    break
            if len(data) == size or size == 0:
                return data
        raise Error("the periodic data change faster than they can be read")

    # --- faults, plugs, counters -------------------------------------------------------------------------------------

    def fault(self, fault: str) -> None:
        """Sets or executes a fault (docs/FAULTS.md): fault("drop 5%"), fault("hang slave 2"), fault("off")."""
        self._ask({"op": "fault", "fault": fault})

    def faults(self) -> List[str]:
        """The present faults of frames."""
        return [line["fault"] for line in self._ask({"op": "fault"})]

    def _plug(self, slave: Slave, ports: Iterable[int], plugged: int) -> None:
        self.set({_PLUGS[port]: plugged for port in ports}, slave)

    def cut(self, slave: Slave, port: int) -> None:
        """Cuts the wire at a port of a slave: 0 input, 1 output, 2 and 3 ports of a junction."""
        self._plug(slave, [port], 0)

    def mend(self, slave: Slave, port: int) -> None:
        """Reconnects a wire that `cut` has cut."""
        self._plug(slave, [port], 1)

    def unplug(self, slave: Slave) -> None:
        """Pulls all plugs of a slave: it leaves the bus, with all slaves behind it."""
        self._plug(slave, range(len(_PLUGS)), 0)

    def plug(self, slave: Slave) -> None:
        """Inserts all plugs of a slave again."""
        self._plug(slave, range(len(_PLUGS)), 1)

    def stats(self) -> Dict[str, Any]:
        """The counters since the start (docs/CONTROL.md), the histogram in `answers` and `edges_us`, and in `plants` {name: counters}."""
        counters: Dict[str, Any] = {"plants": {}}
        for line in self._ask({"op": "stats"}):
            if "plant" in line:
                counters["plants"][line["plant"]] = line
            else:
                counters.update(line)
        return counters

    def about(self) -> Dict[str, Any]:
        """The data of `ectwin ps`: devices, interface, number of slaves, AL states."""
        (line,) = self._ask({"op": "about"})
        return line

    # --- programs in the twin's network --------------------------------------------------------------------------------

    @property
    def pid(self) -> int:
        """Process id of the twins."""
        if self._connection is None:
            self._connection = self._open()
        return self._connection.process

    @property
    def namespace(self) -> int:
        """Number of the network namespace of the twins."""
        return int(os.readlink(f"/proc/{self.pid}/ns/net").strip("net:[]"))

    def _prefix(self) -> List[str]:
        return [self._program or _find_program(None), "enter", "-s", self.path, "--"]

    def popen(self, args: Sequence[Any], **options: Any) -> "subprocess.Popen[Any]":
        """subprocess.Popen in the twin's network: $ECTWIN_IFACE is the interface, and so is {} in an argument.

        A process that still runs is ended when the Twin is closed.
        """
        options.setdefault("start_new_session", True)
        child = subprocess.Popen([*self._prefix(), *map(os.fspath, args)], **options)
        self._children.append(child)
        return child

    def run(self, args: Sequence[Any], **options: Any) -> "subprocess.CompletedProcess[Any]":
        """subprocess.run in the twin's network; see `popen`."""
        return subprocess.run([*self._prefix(), *map(os.fspath, args)], check=options.pop("check", False), **options)

    def call(self, function: Callable[..., Result], *args: Any, **kwargs: Any) -> Result:
        """function(*args, **kwargs) in a child of this process in the twin's network; returns its result.

        For masters that are modules of Python, such as pysoem. The function has no effect in this process, except its result or
        exception, which is pickled.
        """
        return _network.call(self.pid, function, args, kwargs)

    # --- end -----------------------------------------------------------------------------------------------------------

    def messages(self) -> str:
        """Standard error of twins started by this program in a private network."""
        return _messages(self._log) if self._log else ""

    def close(self) -> None:
        """Closes the connection; twins started by this program end, with all programs that run with them."""
        _end_all(self._children)
        if self._connection:
            self._connection.close()
        if self._process:
            _end(self._process)
        if self._log:
            self._log.close()
            self._log = None

    def __enter__(self) -> "Twin":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class InProcessTwin(Twin):
    """Twins inside each program that `run` and `popen` start (docs/IN-PROCESS.md): no network, no namespace.

    Each program has a bus of its own, from the moment at which it opens the interface: signals, faults and counters are
    those of the program that runs at the time.
    """

    def __init__(self, words: Sequence[str], name: str, program: str, interface: str) -> None:
        # pylint: disable=super-init-not-called
        self._process = None
        self._children = []
        self._log = None
        self._connection = None
        self._program = program
        self._words = [program, "with", "--in-process", "--name", name, *words, "--"]
        self.interface = interface
        self.interface2 = self.modbus = ""
        self.path = path_of(name)

    def _ask(self, request: Dict[str, Any]) -> List[Dict[str, Any]]:
        try:
            return super()._ask(request)
        except Refused:
            raise
        except Error:
            if self._connection is None:
                raise
            self._connection.close()  # of a program that has ended
            self._connection = None
        return super()._ask(request)

    def _prefix(self) -> List[str]:
        return self._words

    def call(self, function: Callable[..., Result], *args: Any, **kwargs: Any) -> Result:
        raise Error("twins with in_process=True have no network to enter: mark the test, or leave out in_process")


class OwnTwin(InProcessTwin):
    """The twins inside this process, which `ectwin with --in-process` has started."""

    def __init__(self, name: str, program: str) -> None:
        super().__init__((), name, program, os.environ["ECTWIN_IFACE"])

    def _prefix(self) -> List[str]:
        return []

    def call(self, function: Callable[..., Result], *args: Any, **kwargs: Any) -> Result:
        """Calls the function in this process, which contains the twins."""
        return function(*args, **kwargs)


# --- start -------------------------------------------------------------------------------------------------------------


def _end(process: "subprocess.Popen[Any]") -> None:
    if process.stdin:
        process.stdin.close()
    elif process.poll() is None:
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout:
        process.stdout.close()


def _signal_group(process: "subprocess.Popen[Any]", number: int) -> None:
    try:
        (os.killpg if os.getpgid(process.pid) == process.pid else os.kill)(process.pid, number)
    except ProcessLookupError:
        pass


def _end_all(children: List["subprocess.Popen[Any]"]) -> None:
    running = [child for child in children if child.poll() is None]
    for child in running:
        _signal_group(child, signal.SIGTERM)
    for child in running:
        try:
            child.wait(1)
        except subprocess.TimeoutExpired:
            _signal_group(child, signal.SIGKILL)
            child.wait()
    children.clear()


def connect(path: Optional[str] = None) -> Twin:
    """The twin with this name, process id or path of its socket; else $ECTWIN_SOCKET, or the only twin of this user."""
    return Twin(path)


def ps() -> List[Dict[str, Any]]:
    """The running twins of this user: `about` of each, with its `pid` and `socket`."""
    twins = []
    for path, opened, process in each():
        connection = Connection(opened)
        try:
            (line,) = connection.ask({"op": "about"})
            twins.append({**line, "pid": process, "socket": path})
        except Error:
            pass  # the twin has ended meanwhile
        finally:
            connection.close()
    return twins


def _find_program(program: Optional[str]) -> str:
    found = program or os.environ.get("ECTWIN") or programs.path("ectwin") or shutil.which("ectwin")
    if not found:
        raise Error("there is no 'ectwin' in PATH: name it by program=, or in $ECTWIN")
    return found


def _words(
    options: Sequence[str], settings: Optional[Settings], faults: Union[str, Sequence[str]], name: Optional[str]
) -> List[str]:
    words = list(options)
    for key, value in (settings or {}).items():
        signal_name = f"{key[0]}:{key[1]}" if isinstance(key, tuple) else str(key)
        words += ["--set", f"{signal_name}={_option(value)}"]
    if isinstance(faults, str):
        words += ["--faults", faults]
    else:
        for fault in faults:
            words += ["--fault", fault]
    return words + (["--name", name] if name else [])


def _first_lines(process: "subprocess.Popen[Any]", count: int) -> List[str]:
    """Lines of standard output; fewer when the process has ended."""
    assert process.stdout
    received = b""
    while received.count(b"\n") < count:
        if not readable(process.stdout, _READY):
            raise Error(f"ectwin is not ready after {_READY:.0f} s")
        piece = os.read(process.stdout.fileno(), 65536)
        if not piece:
            break
        received += piece
    return received.decode().split("\n")[: received.count(b"\n")]


def _messages(log: IO[bytes]) -> str:
    """Standard error without the ready line."""
    log.seek(0)
    lines = log.read().decode(errors="replace").splitlines(True)
    return "".join(line for line in lines if not line.startswith('{"event":"ready"'))


def _failed(process: "subprocess.Popen[Any]", log: Optional[IO[bytes]]) -> Error:
    status = process.wait()
    if log is None:
        return Error(f"ectwin has ended with status {status}; what it says is on standard error")
    return Error(f"ectwin has ended with status {status}: {_messages(log).strip()}")


def _start_on(interface: str, words: List[str], program: str) -> Twin:
    process = subprocess.Popen(
        [program, "run", "-i", interface, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE
    )
    try:
        lines = _first_lines(process, 1)
        if not lines:
            raise _failed(process, None)
        twin = Twin(process=process)
    except BaseException:
        process.terminate()
        _end(process)
        raise
    twin.interface, twin.interface2 = interface, ""
    twin.modbus = json.loads(lines[0]).get("modbus", "")
    return twin


def _start_private(words: List[str], program: str) -> Twin:
    log = tempfile.TemporaryFile()
    process = subprocess.Popen(
        [program, "with", *words, "--", "/bin/sh", "-c", _HOLD],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=log,
        start_new_session=True,
    )
    try:
        lines = _first_lines(process, 5)
        if len(lines) < 5:
            raise _failed(process, log)
        if not lines[0]:
            raise Error(f"the twin has no control socket: {_messages(log).strip()}")
        twin = Twin(lines[0], process)
    except BaseException:
        process.terminate()
        _end(process)
        log.close()
        raise
    twin._log = log
    twin.interface, twin.interface2, twin.modbus = lines[1:4]
    return twin


_count = 0


def start(
    devices: Devices,
    interface: Optional[str] = None,
    options: Sequence[str] = (),
    program: Optional[str] = None,
    *,
    set: Optional[Settings] = None,  # pylint: disable=redefined-builtin
    faults: Union[str, Sequence[str]] = (),
    name: Optional[str] = None,
    in_process: bool = False,
    virtual_time: bool = False,
) -> Twin:
    """Starts twins, which end with the `with` block.

    devices       "fzm1", "esi:FILE.xml#TYPE", "A,B" or a list of these
    interface     interface of the twins, as for `ectwin run`; None: in a private network, which needs no root
    options       further options of the command, e.g. ["--esc", "et1100"]
    program       the command; None: $ECTWIN, or `ectwin` in PATH
    set           signals before the start: {"data1": 1.5, (2, "data1"): 5}
    faults        a list of faults, also scripted ones ("at 2.5s hang slave 1"); a str: the path of a file of faults
    name          a name for `ectwin ps` and connect()
    in_process    inside each program that `run` and `popen` start: no network (docs/IN-PROCESS.md)
    virtual_time  on a virtual clock, with in_process
    """
    global _count  # pylint: disable=global-statement
    command = _find_program(program)
    listed = devices if isinstance(devices, str) else ",".join(devices)
    if virtual_time and not in_process:
        raise Error("virtual_time=True needs in_process=True: the clock of a network cannot be virtual")
    if in_process:
        _count += 1
        words = (["--virtual-time"] if virtual_time else []) + _words(options, set, faults, None)
        return InProcessTwin([*words, listed], name or f"python{os.getpid()}.{_count}", command, "ecat0")
    words = [*_words(options, set, faults, name), listed]
    twin = _start_on(interface, words, command) if interface else _start_private(words, command)
    twin._program = command
    return twin
