# SPDX-License-Identifier: MIT
"""The control protocol (docs/CONTROL.md): search for running twins, requests and replies, watched signals."""

from __future__ import annotations

import json
import math
import os
import select
import socket
import stat
import struct
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple, Union

from ._errors import Error, Refused

PATIENCE = 5.0  # seconds until a reply of a twin is due
_STEP = 0.1  # seconds of a wait

Value = Union[int, float, str]
Slave = Union[int, str]  # number, from 1, or name


class Change(NamedTuple):
    """A change of a watched signal; `time` is the twin's clock in seconds, `twin` the name of the slave, if it has one."""

    time: float
    slave: int
    name: str
    value: Value
    twin: Optional[str] = None


class Signal(NamedTuple):
    """A signal of a slave: `access` is "r" or "rw", `range` and `meaning` are texts."""

    slave: int
    name: str
    value: Value
    access: str
    range: str
    meaning: str
    twin: Optional[str] = None


# --- finding twins -----------------------------------------------------------------------------------------------------


def folder_of_sockets() -> str:
    """The folder of this user's sockets, which need not exist."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    return os.path.join(runtime, "ectwin") if runtime else f"/tmp/ectwin-{os.geteuid()}"


def path_of(name: str) -> str:
    """The socket of a twin named by its path, its name or its process id."""
    return name if "/" in name else os.path.join(folder_of_sockets(), name + ".sock")


def _trusted(folder: str) -> bool:
    """Whether the folder belongs to this user and no other user can write to it."""
    try:
        info = os.lstat(folder)
    except OSError:
        return False
    writable = info.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(info.st_mode) and info.st_uid == os.geteuid() and not writable


def _peer(connection: socket.socket) -> Tuple[int, int]:
    """Process and user of the listener."""
    process, owner, _ = struct.unpack("3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i")))
    return process, owner


def _open(path: str) -> Tuple[socket.socket, int, int]:
    """A connection to a socket, with a path of any length; and user and process of the listener."""
    folder, name = os.path.split(path)
    descriptor = os.open(folder or ".", os.O_PATH | os.O_DIRECTORY)
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(PATIENCE)
    try:
        connection.connect(f"/proc/self/fd/{descriptor}/{name}")
        process, owner = _peer(connection)
    except OSError:
        connection.close()
        raise
    finally:
        os.close(descriptor)
    return connection, owner, process


def open_named(path: str) -> socket.socket:
    """A connection to a socket named by the user. Error: no listener, or a listener of another user."""
    try:
        connection, owner, _ = _open(path)
    except OSError as error:
        raise Error(f"no twin answers at '{path}': {error.strerror or error}") from error
    if owner not in (os.geteuid(), 0) and os.geteuid() != 0:
        connection.close()
        raise Error(f"'{path}' is served by user {owner}, not by you: not trusted")
    return connection


def each() -> Iterator[Tuple[str, socket.socket, int]]:
    """Running twins of this user: path, connection, process. The caller closes the connections."""
    folder = folder_of_sockets()
    if os.path.lexists(folder) and not _trusted(folder):
        raise Error(f"'{folder}' belongs to another user, or others may write to it: no twin in it is trusted")
    for name in sorted(os.listdir(folder)) if os.path.lexists(folder) else []:
        path = os.path.join(folder, name)
        if name.startswith(".") or not name.endswith(".sock"):
            continue
        try:
            connection, owner, process = _open(path)
        except OSError:
            continue
        if owner == os.geteuid():
            yield path, connection, process
        else:
            connection.close()


def find(process: Optional[int] = None) -> Tuple[str, socket.socket]:
    """The only twin of this user, or that of a process."""
    found: List[Tuple[str, socket.socket]] = []
    for path, connection, server in each():
        if process in (None, server):
            found.append((path, connection))
        else:
            connection.close()
    if len(found) == 1:
        return found[0]
    for _, connection in found:
        connection.close()
    if not found:
        raise Error("no twin of yours is running: start one with 'ectwin run' or 'ectwin with'")
    raise Error("several twins are running: name one of " + ", ".join(path for path, _ in found))


def readable(file: Any, timeout: Optional[float]) -> bool:
    """Whether a file becomes readable within `timeout` seconds (None: no limit).

    The time is counted in short waits, so that a suspension of the machine, in which the other side cannot write, counts as one
    wait.
    """
    if timeout is None:
        return bool(select.select([file], [], [])[0])
    waits = max(1, math.ceil(timeout / _STEP))
    return any(select.select([file], [], [], timeout / waits)[0] for _ in range(waits))


# --- a connection ------------------------------------------------------------------------------------------------------


class Connection:
    """One connection to a control socket."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.received = b""

    @property
    def process(self) -> int:
        """The process that serves it."""
        return _peer(self.socket)[0]

    def line(self, timeout: Optional[float]) -> Optional[Dict[str, Any]]:
        """The next line as an object; None: no line within the timeout (None: no limit)."""
        while b"\n" not in self.received:
            if not readable(self.socket, timeout):
                return None
            try:
                data = self.socket.recv(65536)
            except OSError as error:
                raise Error(f"the twin has closed this connection: {error.strerror}") from error
            if not data:
                raise Error("the twin has ended, or has closed this connection")
            self.received += data
        line, self.received = self.received.split(b"\n", 1)
        parsed: Dict[str, Any] = json.loads(line)
        return parsed

    def send(self, request: Dict[str, Any]) -> None:
        """Sends a request, without waiting for a reply."""
        try:
            self.socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError:
            pass  # the twin may have sent the reason before it closed the connection

    def ask(self, request: Dict[str, Any]) -> List[Dict[str, Any]]:
        """Sends a request. Returns the lines of the reply, except the last one, which is the result."""
        lines: List[Dict[str, Any]] = []
        self.send(request)
        while True:
            line = self.line(PATIENCE)
            if line is None:
                raise Error("the twin does not answer: it is stopped, or very busy")
            if "ok" not in line:
                lines.append(line)
            elif line["ok"]:
                return lines
            else:
                raise Refused(line["message"])

    def shut(self) -> None:
        """Ends a wait for a line in another thread."""
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the process has already ended

    def close(self) -> None:
        self.socket.close()


class Watch:
    """An iterator of changes of signals. `values` has the initial values, {(slave, name): value}."""

    def __init__(self, connection: Connection, request: Dict[str, Any]) -> None:
        self._connection = connection
        self.values: Dict[Tuple[int, str], Value] = {
            (line["slave"], line["name"]): line["value"] for line in connection.ask(request)
        }

    def next(self, timeout: Optional[float] = None) -> Optional[Change]:
        """The next change. None: no change within `timeout` seconds (None: no limit)."""
        line = self._connection.line(timeout)
        if line is None:
            return None
        if "ok" in line:
            raise Error(line.get("message", "the twin has ended this watch"))
        return Change(line["time"], line["slave"], line["name"], line["value"], line.get("twin"))

    def __iter__(self) -> Iterator[Change]:
        return self

    def __next__(self) -> Change:
        change = self.next()
        assert change is not None  # without a limit of time there is always a change
        return change

    def close(self) -> None:
        """Ends the watch."""
        self._connection.close()

    def __enter__(self) -> "Watch":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
