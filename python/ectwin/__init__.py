# SPDX-License-Identifier: MIT
"""Running EtherCAT twins from Python: start one, get, set and watch its signals, send commands.

    import ectwin
    with ectwin.start("vr-bu-ect-map7", interface="eth1") as twin:
        twin.set({"ru1.on": 1, "ru1.armed": 1})
        print(twin.get("bu.state"))

Speaks the control protocol (docs/CONTROL.md). Chain is a bus of twins inside this process (docs/API.md). No dependencies;
Python 3.8 or newer, Linux.
"""

import json
import os
import select
import shutil
import signal
import socket
import stat
import struct
import subprocess
import time
from collections import namedtuple

from . import programs
from ._errors import Error, Refused
from .chain import Chain, Reply

__all__ = ["Chain", "Change", "Error", "Refused", "Reply", "Signal", "Twin", "connect", "start"]

PATIENCE = 5.0  # seconds for a twin to answer

Change = namedtuple("Change", "time slave name value")
Signal = namedtuple("Signal", "slave name value access range meaning")


# --- finding twins -----------------------------------------------------------------------------------------------------


def _folder():
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    return os.path.join(runtime, "ectwin") if runtime else f"/tmp/ectwin-{os.geteuid()}"


def _trusted(folder):
    """Whether the folder belongs to this user and no other user can write to it."""
    try:
        info = os.lstat(folder)
    except OSError:
        return False
    writable = info.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(info.st_mode) and info.st_uid == os.geteuid() and not writable


def _open(path):
    """A connection to a socket, whatever the length of its path; and the user and the process that listen there."""
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(PATIENCE)
    folder, name = os.path.split(path)
    descriptor = os.open(folder or ".", os.O_PATH | os.O_DIRECTORY)
    try:
        connection.connect(f"/proc/self/fd/{descriptor}/{name}")
        peer = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    except OSError:
        connection.close()
        raise
    finally:
        os.close(descriptor)
    process, owner, _ = struct.unpack("3i", peer)
    return connection, owner, process


def _open_named(path):
    try:
        connection, owner, _ = _open(path)
    except OSError as error:
        raise Error(f"no twin answers at '{path}': {error.strerror or error}") from error
    if owner not in (os.geteuid(), 0) and os.geteuid() != 0:
        connection.close()
        raise Error(f"'{path}' is served by user {owner}, not by you: not trusted")
    return connection


def _all():
    """Running twins of this user: (path, connection, process)."""
    folder = _folder()
    if os.path.lexists(folder) and not _trusted(folder):
        raise Error(f"'{folder}' belongs to somebody else, or others may write to it: no twin in it is trusted")
    for name in sorted(os.listdir(folder)) if os.path.lexists(folder) else []:
        path = os.path.join(folder, name)
        if not name.endswith(".sock"):
            continue
        try:
            connection, owner, process = _open(path)
        except OSError:
            continue
        if owner == os.geteuid():
            yield path, connection, process
        else:
            connection.close()


def _find(process=None):
    """The only twin of this user; or that of a process."""
    found = []
    for path, connection, server in _all():
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


# --- a connection ------------------------------------------------------------------------------------------------------


class _Connection:
    def __init__(self, connection):
        self.socket = connection
        self.received = b""

    def line(self, timeout):
        """The next line as an object, None when none has come in that time (None: for ever)."""
        end = None if timeout is None else time.monotonic() + timeout
        while b"\n" not in self.received:
            left = None if end is None else max(0.0, end - time.monotonic())
            if not select.select([self.socket], [], [], left)[0]:
                return None
            try:
                data = self.socket.recv(65536)
            except OSError as error:
                raise Error(f"the twin has closed this connection: {error.strerror}") from error
            if not data:
                raise Error("the twin has ended, or has closed this connection")
            self.received += data
        line, self.received = self.received.split(b"\n", 1)
        return json.loads(line)

    def ask(self, request):
        """Sends a request. Yields the lines of the reply but the last, the result."""
        try:
            self.socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError:
            pass  # the twin may have sent the reason before it closed the connection
        while True:
            line = self.line(PATIENCE)
            if line is None:
                raise Error("the twin does not answer: it is stopped, or very busy")
            if "ok" not in line:
                yield line
            elif line["ok"]:
                return
            else:
                raise Refused(line["message"])

    def close(self):
        self.socket.close()


class Watch:
    """Changes of signals, one after the other: an iterator. Its first values are in `values`, {(slave, name): value}.

    `next(timeout)` waits so many seconds (None: for ever) and gives None when nothing has changed.
    """

    def __init__(self, connection, request):
        self._connection = connection
        self.values = {(line["slave"], line["name"]): line["value"] for line in connection.ask(request)}

    def next(self, timeout=None):
        line = self._connection.line(timeout)
        if line is None:
            return None
        if "ok" in line:
            raise Error(line.get("message", "the twin has ended this watch"))
        return Change(line["time"], line["slave"], line["name"], line["value"])

    def __iter__(self):
        return self

    def __next__(self):
        return self.next()

    def close(self):
        self._connection.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Twin:
    """A chain of running twins. `slave` counts from 1; 0 where several may be meant: all of them.

    A value is an int, a float, or a str (texts, and bytes as hexadecimal digits).
    """

    def __init__(self, path=None, process=None):
        self._process = process
        if path is None and process is None:
            path = os.environ.get("ECTWIN_SOCKET")
        if path is None:
            self.path, connection = _find(process.pid if process else None)
        else:
            self.path, connection = path, _open_named(path)
        self._connection = _Connection(connection)

    def get(self, name, slave=1):
        """The value of one signal."""
        values = self.values(name, slave)
        if len(values) != 1:
            raise Error(f"'{name}' is not one signal, but {len(values)}: values() gives several")
        return next(iter(values.values()))

    def values(self, pattern="*", slave=1):
        """The signals that match: {name: value}, of all slaves {(slave, name): value}."""
        lines = self._connection.ask({"op": "get", "pattern": pattern, "slave": slave})
        return {(line["slave"], line["name"]) if slave == 0 else line["name"]: line["value"] for line in lines}

    def signals(self, pattern="*", slave=1):
        """The signals of a slave: a list of Signal."""
        lines = self._connection.ask({"op": "list", "pattern": pattern, "slave": slave})
        return [Signal(**{field: line[field] for field in Signal._fields}) for line in lines]

    def set(self, values, slave=1):
        """Sets {name: value}: all of them or none. A value that is bytes is sent as hexadecimal digits."""
        texts = {name: value.hex() if isinstance(value, (bytes, bytearray)) else value for name, value in values.items()}
        for _ in self._connection.ask({"op": "set", "values": texts, "slave": slave}):
            pass

    def command(self, remote, data, slave=1):
        """An operator's command of 16 bytes from a remote unit of a base unit: command("ru1", bytes(16))."""
        self.set({f"{remote}.command": bytes(data)}, slave)

    def watch(self, pattern="*", slave=1, every=False):
        """A Watch on what matches, on a connection of its own."""
        request = {"op": "watch", "pattern": pattern, "slave": slave, "every": every}
        return Watch(_Connection(_open_named(self.path)), request)

    def wait_for(self, name, value, timeout=10.0, slave=1):
        """Waits until a signal has that value. Error when it has not in that time."""
        end = time.monotonic() + timeout
        with self.watch(name, slave, every=True) as watch:
            current = watch.values.get((slave, name))
            while current != value:
                change = watch.next(max(0.0, end - time.monotonic()))
                if change is None:
                    raise Error(f"{name} is {current!r}, not {value!r}, after {timeout} s")
                current = change.value

    def close(self):
        """Closes the connection; a twin that was started here ends."""
        self._connection.close()
        if self._process and self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)
            try:
                self._process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if self._process:
            self._process.stdout.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


# --- beginnings --------------------------------------------------------------------------------------------------------


def connect(path=None):
    """The twin whose socket is named, or $ECTWIN_SOCKET, or the only one that this user runs."""
    return Twin(path)


def _ready(process):
    line = process.stdout.readline()
    if not line:
        process.wait()
        raise Error(f"ectwin has ended with status {process.returncode}; what it says is on standard error")
    return json.loads(line)


def start(devices, interface, options=(), program=None):
    """Starts `ectwin run` with these devices ("A,B" or a list) on an interface; it ends with the `with` block.

    `options` are those of the command, e.g. ["--set", "data1=5"]; `program` is the command, else $ECTWIN or PATH.
    """
    program = program or os.environ.get("ECTWIN") or programs.path("ectwin") or shutil.which("ectwin")
    if not program:
        raise Error("there is no 'ectwin' in PATH: name it by program=, or in $ECTWIN")
    if not isinstance(devices, str):
        devices = ",".join(devices)
    process = subprocess.Popen(
        [program, "run", "-i", interface, *options, devices], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    )
    try:
        _ready(process)
        return Twin(process=process)
    except BaseException:
        process.terminate()
        process.wait()
        process.stdout.close()
        raise
