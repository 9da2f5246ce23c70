# SPDX-License-Identifier: MIT
"""Twins in this process: frame in, frame out; time is an argument (ectwin.Chain). No network, no thread, no clock."""

import ctypes
import os
import shutil
from typing import Iterable, List, Mapping, NamedTuple, Optional, Tuple, Union

from . import programs
from ._errors import Error, Refused
from ._plant import Plant, split

NEVER = 2**64 - 1
FRAME_MAX = 2048
MESSAGE = 1280
SONAME = "libectwin.so.0"

Value = Union[int, float, str]


class Reply(NamedTuple):
    """A frame that has left the chain. `end` is 0 for the input of the first twin, 1 for the output of the last one."""

    end: int
    frame: bytes


def _candidates() -> Iterable[str]:
    """Places of the library: only $ECTWIN_LIBRARY; else next to the command of this wheel, of a build or an installation; else the
    linker's default."""
    named = os.environ.get("ECTWIN_LIBRARY")
    if named:
        yield named
        return
    program = os.environ.get("ECTWIN") or programs.path("ectwin") or shutil.which("ectwin")
    if program:
        folder = os.path.dirname(os.path.realpath(program))
        for place in ("", "../lib", f"../lib/{os.uname().machine}-linux-gnu", "../lib64"):
            path = os.path.join(folder, place, SONAME)
            if os.path.exists(path):
                yield path
    yield SONAME


def _declare(library: ctypes.CDLL) -> ctypes.CDLL:
    bus, size, time, text, flag = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64, ctypes.c_char_p, ctypes.c_int
    end = ctypes.c_uint
    for name, result, arguments in (
        ("version", text, []),
        ("bus_open", bus, [flag, ctypes.POINTER(text), time, text]),
        ("bus_close", None, [bus]),
        ("bus_power_cycle", None, [bus, time]),
        ("bus_slaves", size, [bus]),
        ("bus_link", None, [bus, end, flag, time]),
        ("bus_frame", None, [bus, end, text, size, time]),
        ("bus_reply", size, [bus, ctypes.POINTER(end), text, size]),
        ("bus_run", time, [bus, time]),
        ("bus_get", flag, [bus, size, text, text, size]),
        ("bus_set", flag, [bus, size, text, text, time, text, size]),
        ("bus_fault", flag, [bus, text, time, text, size]),
    ):
        function = getattr(library, "ectwin_" + name)
        function.restype, function.argtypes = result, arguments
    return library


def _load(path: Optional[str]) -> ctypes.CDLL:
    reason: Optional[Exception] = None
    for candidate in [path] if path else _candidates():
        try:
            return _declare(ctypes.CDLL(candidate))
        except (OSError, AttributeError) as error:
            reason = error
    raise Error(f"{SONAME} cannot be loaded: {reason}; install ectwin, or name the library by library= or in $ECTWIN_LIBRARY")


class Chain:
    """A chain of twins that is powered on at `now_ns`, with a cable at its input.

    `devices` are names ("fzm1,vr-bu-ect-map7" or a list); `options` are those of `ectwin with`; `faults` are lines of a fault
    script; `store` is the folder of the non-volatile memories. Times are nanoseconds of any clock that never decreases; a time
    before that of the last call, or no time, counts as the time of the last call. `library` is the path of the library, else
    $ECTWIN_LIBRARY, else the one of the `ectwin` in $ECTWIN or PATH. One thread at a time for each chain; chains are independent.
    Raises Refused for invalid words.

        with ectwin.Chain("fzm1", faults=["drop 5%"]) as chain:
            for reply in chain.frame(request, now_ns=1_000_000):
                print(reply.end, reply.frame.hex())
    """

    def __init__(
        self,
        devices: Union[str, Iterable[str]],
        options: Iterable[str] = (),
        *,
        faults: Iterable[str] = (),
        store: Optional[Union[str, "os.PathLike[str]"]] = None,
        now_ns: int = 0,
        library: Optional[str] = None,
    ) -> None:
        self._bus: Optional[int] = None
        self._plants: List[Tuple[int, int, Plant]] = []  # time of the next call, order of attachment
        self._triggered: List[Tuple[Plant, str]] = []  # plants with `on`, and the value at the last call
        self._start_ns = now_ns
        self._library = _load(library)
        words = list(options)
        for fault in faults:
            words += ["--fault", fault]
        if store is not None:
            words += ["--store", os.fspath(store)]
        words.append(devices if isinstance(devices, str) else ",".join(devices))
        texts = (ctypes.c_char_p * len(words))(*(os.fsencode(word) for word in words))
        message = ctypes.create_string_buffer(MESSAGE)
        self._bus = self._library.ectwin_bus_open(len(words), texts, now_ns, message)
        if not self._bus:
            raise Refused(message.value.decode())
        self._room = ctypes.create_string_buffer(FRAME_MAX)
        self._now_ns = now_ns
        self._next_ns: Optional[int] = now_ns

    @property
    def now_ns(self) -> int:
        """The latest time of the chain."""
        return self._now_ns

    @property
    def next_ns(self) -> Optional[int]:
        """The time at which `run` is due next without a frame; None: never. Valid directly after `frame` and `run`."""
        return self._next_ns

    @property
    def version(self) -> str:
        """Version of the library."""
        return str(self._library.ectwin_version().decode())

    def __len__(self) -> int:
        """Number of twins."""
        return int(self._library.ectwin_bus_slaves(self._open()))

    def frame(self, data: bytes, now_ns: Optional[int] = None, end: int = 0) -> List[Reply]:
        """Passes a frame (from the destination address on, without check sum) and runs the devices. Returns the frames that have
        left.

        Due calls of plants precede the frame.
        """
        self._run_plants(now_ns)
        self._library.ectwin_bus_frame(self._open(), end, data, len(data), self._advance(now_ns))
        return self.run()

    def run(self, now_ns: Optional[int] = None) -> List[Reply]:
        """Advances the time: runs due devices, late replies and plants. Returns the frames that have left."""
        self._run_plants(now_ns)
        next_ns = self._library.ectwin_bus_run(self._open(), self._advance(now_ns))
        self._call_triggered()
        if self._plants:
            next_ns = min(next_ns, self._plants[0][0])
        self._next_ns = None if next_ns == NEVER else next_ns
        return self._replies()

    def attach(self, plant: Plant) -> None:
        """Calls a plant once in each of its periods from now on, at exact times, the first time at once; or at each change of `on`.

        At each of these times the devices run, the plant reads, its values are set, and the devices run again. A frame of the same
        time passes afterwards. An exception of the function is raised by `frame` and `run`. Raises Refused for a signal that does
        not exist or does not fit.
        """
        for name in plant.writes:
            slave, signal = split(name)
            self.set({signal: self.get(signal, slave)}, slave)
        if plant.on is not None:
            self._triggered.append((plant, self._value_of_trigger(plant)))
            return
        due_ns = self._call(plant, self._now_ns)
        self._plants.append((due_ns, len(self._plants), plant))
        self._plants.sort(key=lambda entry: entry[:2])
        self.run()

    def _call(self, plant: Plant, now_ns: int) -> int:
        """Calls a plant at a time. Returns the time of its next call."""
        self._library.ectwin_bus_run(self._open(), self._advance(now_ns))
        for slave, values in plant.call((now_ns - self._start_ns) / 1e9, lambda slave, name: self.get(name, slave)).items():
            self.set(values, slave)
        return now_ns + round(plant.period * 1e9)

    def _value_of_trigger(self, plant: Plant) -> str:
        slave, name = split(plant.on or "")
        return self.get(name, slave)

    def _call_triggered(self) -> None:
        """Calls the plants whose signal `on` has changed."""
        for index, (plant, seen) in enumerate(self._triggered):
            value = self._value_of_trigger(plant)
            if value != seen:
                self._triggered[index] = (plant, value)
                self._call(plant, self._now_ns)

    def _run_plants(self, now_ns: Optional[int]) -> None:
        """Calls the plants due until a time, in the order of their times."""
        while self._plants and self._plants[0][0] <= max(self._now_ns, now_ns or 0):
            due_ns, order, plant = self._plants[0]
            self._plants[0] = (self._call(plant, due_ns), order, plant)
            self._call_triggered()
            self._plants.sort(key=lambda entry: entry[:2])

    def link(self, end: int, plugged: bool, now_ns: Optional[int] = None) -> None:
        """Plugs a cable in at an end, or pulls it."""
        self._library.ectwin_bus_link(self._open(), end, plugged, self._advance(now_ns))

    def get(self, name: str, slave: int = 1) -> str:
        """The value of a signal as text. Slaves count from 1."""
        if not self._library.ectwin_bus_get(self._open(), slave, name.encode(), self._room, FRAME_MAX) == 0:
            raise Refused(f"slave {slave} has no signal '{name}', or is not there")
        return self._room.value.decode()

    def set(self, values: Mapping[str, Union[Value, bytes]], slave: int = 1, now_ns: Optional[int] = None) -> None:
        """Sets {name: value} in succession, until one is refused. Bytes are sent as hexadecimal digits."""
        time = self._advance(now_ns)
        for name, value in values.items():
            text = value.hex() if isinstance(value, (bytes, bytearray)) else str(int(value) if isinstance(value, bool) else value)
            message = ctypes.create_string_buffer(MESSAGE)
            if self._library.ectwin_bus_set(self._open(), slave, name.encode(), text.encode(), time, message, MESSAGE) != 0:
                raise Refused(message.value.decode())

    def fault(self, fault: str, now_ns: Optional[int] = None) -> None:
        """Sets a fault ("drop 5%", "hang slave 1"), or ends all faults ("off")."""
        message = ctypes.create_string_buffer(MESSAGE)
        if self._library.ectwin_bus_fault(self._open(), fault.encode(), self._advance(now_ns), message, MESSAGE) != 0:
            raise Refused(message.value.decode())

    def power_cycle(self, now_ns: Optional[int] = None) -> None:
        """Switches all twins off and on; stored values, EEPROMs, cables, faults and the surroundings keep their state."""
        self._library.ectwin_bus_power_cycle(self._open(), self._advance(now_ns))

    def close(self) -> None:
        """Completes saves, and switches the twins off. No further call is possible."""
        bus, self._bus = self._bus, None
        if bus:
            self._library.ectwin_bus_close(bus)

    def _open(self) -> int:
        if not self._bus:
            raise Error("this chain is closed")
        return self._bus

    def _advance(self, now_ns: Optional[int]) -> int:
        if now_ns is not None:
            self._now_ns = max(self._now_ns, now_ns)
        return self._now_ns

    def _replies(self) -> List[Reply]:
        end = ctypes.c_uint()
        replies: List[Reply] = []
        while True:
            length = self._library.ectwin_bus_reply(self._open(), ctypes.byref(end), self._room, FRAME_MAX)
            if length == 0:
                return replies
            replies.append(Reply(end.value, self._room.raw[:length]))

    def __enter__(self) -> "Chain":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()
