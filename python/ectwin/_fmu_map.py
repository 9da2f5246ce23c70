# SPDX-License-Identifier: MIT
"""Maps of ectwin-fmu: the connections between signals of a bus and variables of a model (docs/PLANTS.md)."""

from __future__ import annotations

import math
import os
import re
from typing import Dict, Iterator, List, NamedTuple, Optional, Tuple, Union

from ._errors import Error

MODEL = "fmu."  # prefix of the names of the model's variables

Name = Union[str, Tuple[int, str]]


class Wire(NamedTuple):
    """A connection, with the direction of its list."""

    place: str  # "FILE:LINE", for messages
    variable: str
    signal: Name
    factor: float = 1.0
    offset: float = 0.0
    invert: bool = False

    def convert(self, value: float) -> float:
        """A value of the source for the target, before rounding and limits."""
        result = value * self.factor + self.offset
        return float(result == 0) if self.invert else result


class Start(NamedTuple):
    """A variable with a start value."""

    place: str
    variable: str
    value: float


class Map(NamedTuple):
    """The lines of a map: `inputs` of the model are set by signals, `outputs` set signals, `starts` are set once."""

    inputs: List[Wire]
    outputs: List[Wire]
    starts: List[Start]


def pieces(text: str, separator: str) -> List[str]:
    """Splits at a separator outside brackets and quotes, which occur in names of variables: T[1,2], der(x), 'a=b'."""
    found, piece, depth, quoted, escaped = [], "", 0, False, False
    for char in text:
        if quoted:
            quoted, escaped = escaped or char != "'", char == "\\" and not escaped
        elif char == separator and depth <= 0:
            found.append(piece.strip())
            piece = ""
            continue
        elif char == "'":
            quoted = True
        else:
            depth += (char in "([") - (char in ")]")
        piece += char
    return [*found, piece.strip()]


def _content(line: str) -> str:
    """A line without its comment."""
    return pieces(line, "#")[0]


def _number(text: str) -> float:
    """A finite number; ValueError."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError
    return value


def _constant(text: str) -> Optional[float]:
    """The value of a source that is a number, true or false; None: a name."""
    if text in ("true", "false"):
        return float(text == "true")
    try:
        return _number(text)
    except ValueError:
        return None


def _properties(place: str, words: List[str]) -> Dict[str, Union[float, bool]]:
    found: Dict[str, Union[float, bool]] = {}
    for word in words:
        key, equals, number = (part.strip() for part in word.partition("="))
        try:
            if word == "invert":
                found["invert"] = True
            elif key in ("factor", "offset"):
                found[key] = _number(number)
            else:
                raise ValueError
        except ValueError:
            raise Error(f"{place}: '{word}' is none of factor=NUMBER, offset=NUMBER, invert") from None
    return found


def _signal(text: str) -> Name:
    """A signal in the form of --connect: 2.level, gripper.level; level is a signal of the first twin."""
    numbered = re.fullmatch(r"(\d+)[.:](.+)", text)
    return (int(numbered[1]), numbered[2]) if numbered else text


def _read_line(place: str, text: str, result: Map) -> None:
    target, *rest = pieces(text, "=")
    source, *words = pieces("=".join(rest), ",")
    if not target or not source:
        raise Error(f"{place}: a line is TARGET=SOURCE, as in fmu.valve=1.outputs.valve, not '{text}'")
    properties = _properties(place, words)
    ours, theirs = target.startswith(MODEL), source.startswith(MODEL)
    if ours and theirs:
        raise Error(f"{place}: '{text}' connects the model with itself: one side is a signal of the bus")
    if ours:
        value = _constant(source)
        if value is None:
            result.inputs.append(Wire(place, target[len(MODEL) :], _signal(source), **properties))  # type: ignore[arg-type]
        elif words:
            raise Error(f"{place}: '{text}' sets a number: leave factor, offset and invert out")
        else:
            result.starts.append(Start(place, target[len(MODEL) :], value))
    elif theirs:
        result.outputs.append(Wire(place, source[len(MODEL) :], _signal(target), **properties))  # type: ignore[arg-type]
    else:
        raise Error(f"{place}: '{text}' names no variable of the model: they begin with fmu., as in fmu.valve=1.outputs.valve")


def _targets(found: Map) -> Iterator[Tuple[str, str]]:
    """Place and name of each target."""
    for entry in (*found.starts, *found.inputs):
        yield entry.place, MODEL + entry.variable
    for wire in found.outputs:
        yield wire.place, wire.signal if isinstance(wire.signal, str) else f"{wire.signal[0]}.{wire.signal[1]}"


def parse(name: str, text: str) -> Map:
    """The map of a file's text. Error: an invalid line, or no connection."""
    result = Map([], [], [])
    for number, line in enumerate(text.splitlines(), 1):
        content = _content(line)
        if content:
            _read_line(f"{name}:{number}", content, result)
    if not result.inputs and not result.outputs:
        raise Error(f"{name} connects nothing: write lines as fmu.valve=1.outputs.valve and 2.inputs.level=fmu.level")
    seen: Dict[str, str] = {}
    for place, target in sorted(_targets(result), key=lambda entry: int(entry[0].rpartition(":")[2])):
        if target in seen:
            raise Error(f"{place}: {target} is set in line {seen[target].rpartition(':')[2]} already")
        seen[target] = place
    return result


def read(path: str) -> Map:
    """The map of a file."""
    try:
        with open(path, encoding="utf-8") as file:
            return parse(os.path.basename(path), file.read())
    except (OSError, UnicodeDecodeError) as error:
        raise Error(f"cannot read '{path}': {getattr(error, 'strerror', None) or error}") from None
