# SPDX-License-Identifier: MIT
"""Plants: functions of this program that are called in each period with signals of twins, and set other signals
(docs/PLANTS.md)."""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

from ._control import PATIENCE, Connection, Value, find, open_named, path_of
from ._errors import Error, Refused

if TYPE_CHECKING:
    from ._twin import Twin

Number = Union[int, float, bool]
Name = Union[str, Tuple[int, str]]
Function = Callable[[float, Dict[Name, Number]], Optional[Mapping[Name, Number]]]

_RETRY = 0.05  # seconds between two attempts to find the twins
_WORDS_MOST = 3000  # characters of names in a request


def split(name: Name) -> Tuple[int, str]:
    """Slave and name of a signal: "level", "2:level", (2, "level")."""
    if not isinstance(name, str):
        return name
    number, colon, rest = name.partition(":")
    return (int(number), rest) if colon and number.isdigit() else (1, name)


def _batches(reads: Sequence[Name], writes: Sequence[Name]) -> Iterator[Dict[str, Any]]:
    """The signals as requests, in order: one for each run of the same slave, of bounded length."""
    for key, names in (("reads", reads), ("writes", writes)):
        batch: List[str] = []
        slave = length = 0
        for number, name in map(split, names):
            if batch and (number != slave or length > _WORDS_MOST):
                yield {"slave": slave, key: batch}
                batch, length = [], 0
            slave = number
            batch.append(name)
            length += len(name) + 4
        if batch:
            yield {"slave": slave, key: batch}


class Plant:
    """A machine around twins: `function(now, values)` is called once in each period of the bus.

        def tank(now, values):
            tank.level += 0.001 * values["valves.inlet"]
            return {"sensor.level": tank.level}
        ectwin.Plant(tank, reads=["valves.inlet"], writes=["sensor.level"], period=0.001).run("press")

    `now` is the time of the bus in seconds, `values` is {name: value} of `reads`, all of one time. The result is {name: value} of
    `writes`: all are set at once, or none; an omitted signal keeps its value, None sets no signal. A name is "level",
    "gripper.level", "2:level" or (2, "level"). `period` is in seconds; `name` is the plant's name in `ectwin stats`.

    With `on`, the name of a signal, the function is called at each change of this signal in place of each period. A result that comes more
    than `timeout` seconds later is dropped and counted.

    With `fit`, running twins round each value to the type of its signal and limit it to its range; else an unsuitable value is
    refused.

    The same plant works with a Chain (Chain.attach), where each call is made at its exact time.
    """

    def __init__(
        self,
        function: Function,
        reads: Iterable[Name] = (),
        writes: Iterable[Name] = (),
        *,
        period: float = 0.001,
        name: str = "plant",
        on: Optional[Name] = None,
        timeout: float = 0.005,
        fit: bool = False,
    ) -> None:
        self.function = function
        self.reads = list(reads)
        self.writes = list(writes)
        self.period = period
        self.name = name
        self.on = on
        self.timeout = timeout
        self.fit = fit
        #: Calls so far.
        self.steps = 0
        if not (self.reads or self.writes):
            raise Error("a plant reads or sets a signal: name some in reads= and writes=")
        for what, seconds in (("period", period), ("timeout", timeout)):
            if not 1e-4 <= seconds <= 2000:
                raise Error(f"the {what} of a plant is 0.0001 to 2000 s, not {seconds}")
        self._known = frozenset(self.writes)
        self._connection: Optional[Connection] = None
        self._thread: Optional[threading.Thread] = None
        self._stopped = False
        self._failure: Optional[BaseException] = None

    def step(self, now: float, values: Mapping[Name, Number]) -> Dict[Name, Number]:
        """Calls the function once. Returns the values to set; raises Error for a result that does not fit."""
        self.steps += 1
        result = self.function(now, dict(values)) or {}
        if not isinstance(result, Mapping):
            raise Error(f"plant '{self.name}': the result is {{name: value}}, not {type(result).__name__}")
        for name, value in result.items():
            if name not in self._known:
                raise Error(f"plant '{self.name}': '{name}' is not among its writes: {', '.join(map(str, self.writes)) or 'none'}")
            if not isinstance(value, (bool, int, float)) or not math.isfinite(value):
                raise Error(f"plant '{self.name}': {name} is {value!r}: a plant sets finite numbers")
        return dict(result)

    # --- beside running twins ------------------------------------------------------------------------------------------

    def attach(self, twin: Union[None, str, "Twin"] = None, *, wait: bool = False, timeout: float = 10.0) -> None:
        """Registers the plant with running twins: a Twin, the name or path of their socket; None: the only twins of this user.

        `wait` stops a virtual clock during each step (ectwin with --in-process --virtual-time --plant NAME): runs are then repeatable.
        Twins that have not started yet are awaited for `timeout` seconds. Raises Refused, in one line, for a signal that does not exist
        or does not fit.
        """
        if self._connection is not None:
            raise Error(f"plant '{self.name}' is attached already")
        path = getattr(twin, "path", twin)
        connection = self._reach(path, timeout)
        try:
            for request in _batches(self.reads, self.writes):
                connection.ask({"op": "plant", "name": self.name, **request})
            connection.ask({"op": "plant", "wait": wait, **self._rhythm()})
        except BaseException:
            connection.close()
            raise
        self._connection = connection
        self._stopped = False

    def _rhythm(self) -> Dict[str, Any]:
        """The members of a request that start the plant."""
        if self.on is None:
            return {"period_us": self.period * 1e6, "fit": self.fit}
        slave, name = split(self.on)
        return {"slave": slave, "on": name, "timeout_us": self.timeout * 1e6, "fit": self.fit}

    @staticmethod
    def _reach(path: Optional[str], timeout: float) -> Connection:
        waits = max(1, math.ceil(timeout / _RETRY))
        while True:
            try:
                return Connection(open_named(path_of(path)) if path else find()[1])
            except Error:
                waits -= 1
                if waits <= 0:
                    raise
            time.sleep(_RETRY)

    def serve(self) -> None:
        """Executes the steps of the twins until they end or `stop` is called. Raises exceptions of the function, and Refused."""
        connection = self._connection
        if connection is None:
            raise Error(f"plant '{self.name}' is not attached: call attach() first")
        try:
            while True:
                step = self._next_step(connection)
                if step is None:
                    return
                result = self.step(*step[1:])
                connection.send({"op": "step", "step": step[0], "values": [result.get(name) for name in self.writes]})
        finally:
            self._connection = None
            connection.close()

    def _next_step(self, connection: Connection) -> Optional[Tuple[int, float, Dict[Name, Number]]]:
        """Number, time and values of the next step; None: the twins have ended, or `stop` was called."""
        values: List[Number] = []
        number, now = 0, 0.0
        while True:
            try:
                line = connection.line(PATIENCE)
            except Error:
                return None
            if self._stopped:
                return None
            if line is None:
                continue
            if line.get("ok") is False:
                raise Refused(line["message"])
            if "step" in line:
                number, now, values = line["step"], line["time"], []
            values += line.get("values", [])
            if len(values) == len(self.reads):
                return number, now, dict(zip(self.reads, values))

    def run(self, twin: Union[None, str, "Twin"] = None, *, wait: bool = False, timeout: float = 10.0) -> None:
        """`attach`, then `serve`."""
        self.attach(twin, wait=wait, timeout=timeout)
        self.serve()

    def start(self, twin: Union[None, str, "Twin"] = None, *, wait: bool = False, timeout: float = 10.0) -> "Plant":
        """`attach`, then `serve` in a thread. End it with `stop`, or with the `with` block of the result."""
        self.attach(twin, wait=wait, timeout=timeout)
        self._thread = threading.Thread(target=self._serve_in_thread, name=f"ectwin plant {self.name}", daemon=True)
        self._thread.start()
        return self

    def _serve_in_thread(self) -> None:
        try:
            self.serve()
        except BaseException as failure:  # pylint: disable=broad-exception-caught
            self._failure = failure

    def stop(self) -> None:
        """Ends the plant. Its signals keep their last values. Raises an exception that the function has raised in the thread of
        `start`."""
        self._stopped = True
        connection = self._connection
        if connection is not None:
            connection.shut()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def __enter__(self) -> "Plant":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    # --- in a Chain ----------------------------------------------------------------------------------------------------

    def call(self, now: float, get: Callable[[int, str], Value]) -> Dict[int, Dict[str, Number]]:
        """One call with values from `get(slave, name)`. Returns {slave: {name: value}}: for a Chain."""
        values: Dict[Name, Number] = {}
        for name in self.reads:
            text = get(*split(name))
            try:
                number = float(text)
            except ValueError:
                raise Refused(f"{name} is a text: a plant reads and sets numbers") from None
            values[name] = int(number) if number.is_integer() else number
        result: Dict[int, Dict[str, Number]] = {}
        for name, value in self.step(now, values).items():
            slave, signal = split(name)
            result.setdefault(slave, {})[signal] = value
        return result


def camera(function: Callable[[float, int], Tuple[bool, Sequence[Number]]], slave: Union[int, str] = 1, *, timeout: float = 0.005, name: str = "camera") -> Plant:
    """A plant that determines the content of each image of an FZM1: `function(now, scene)` returns its judgement (True: OK) and its
    values D1, D2, …

    The function is called when an image input begins, by STEP or another start; the image has this judgement and these values if
    they arrive within the image input (signal `image_input`, 5 ms), else those of the previous image. `slave` is a number or the
    name of a twin.
    """

    def signal(of: str) -> Name:
        return f"{slave}.{of}" if isinstance(slave, str) else (slave, of)

    data = [signal(f"data{n}") for n in range(1, 9)]

    def judge(now: float, values: Dict[Name, Number]) -> Dict[Name, Number]:
        good, measured = function(now, int(values[signal("scene")]))
        return {signal("judgement"): 1 if good else -1, **dict(zip(data, measured))}

    return Plant(judge, [signal("scene")], [signal("judgement"), *data], name=name, on=signal("exposures"), timeout=timeout)
