# SPDX-License-Identifier: MIT
"""ectwin-fmu: a model as FMU (FMI 2.0 or 3.0 co-simulation) is the plant of running twins. docs/PLANTS.md is the manual.

Needs FMPy (`pip install ectwin[fmu]`). Without the command's entry point: python3 -m ectwin.fmu.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import re
import signal
import sys
import tempfile
import zipfile
from typing import Any, Dict, List, Mapping, NoReturn, Optional, Tuple

from ._errors import Error
from ._fmu_map import MODEL, Map, Name, Wire, read
from ._plant import Number, Plant

__all__ = ["Model", "main"]

CATCH_UP = 10  # limit of periods of the model in one step
PERIOD = 0.001  # s, of a model that names none
NAME_MOST = 31  # characters of a plant's name
NAMED = 8  # variables in a message

_BITS = {f"{sign}Int{bits}": (0 if sign else -(2 ** (bits - 1)), 2 ** (bits if sign else bits - 1) - 1) for sign in ("", "U") for bits in (8, 16, 32, 64)}
_LIMITS: Dict[str, Tuple[float, float]] = {
    **_BITS,
    "Integer": _BITS["Int32"],
    "Enumeration": _BITS["Int32"],
    "Boolean": (0, 1),
    "Real": (-math.inf, math.inf),
    "Float32": (-math.inf, math.inf),
    "Float64": (-math.inf, math.inf),
}
_REALS = ("Real", "Float32", "Float64")
_CALLS = {("2", "Enumeration"): "Integer", ("3", "Enumeration"): "Int64"}  # other types have functions with their own names


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _fmpy() -> Any:
    """The package fmpy."""
    try:
        import fmpy.fmi2  # pylint: disable=import-outside-toplevel
        import fmpy.fmi3  # pylint: disable=import-outside-toplevel
        import fmpy.logging  # pylint: disable=import-outside-toplevel
    except ImportError as error:
        raise Error(f"FMPy is missing ({_one_line(error)}): pip install 'ectwin[fmu]'") from None
    return fmpy


def fitted(value: float, kind: str, lowest: Optional[str] = None, highest: Optional[str] = None) -> Number:
    """A number for a variable of a type: limited to the range of type and variable, rounded for an integer."""
    least, most = _LIMITS[kind]
    value = min(max(value, least, float(lowest or -math.inf)), most, float(highest or math.inf))
    if kind in _REALS:
        return value
    whole = value if isinstance(value, int) else math.floor(abs(value) + 0.5) * (1 if value >= 0 else -1)
    return bool(whole) if kind == "Boolean" else int(whole)


def _binary(version: str) -> str:
    """The folder of this machine's binaries in an FMU."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    if version == "3":
        return f"{machine}-linux"
    return "linux64" if sys.maxsize > 2**32 else "linux32"


class Schedule:
    """The periods that a model runs: after a delay the model catches up, within the limit of one step."""

    def __init__(self, period: float) -> None:
        self.period = period
        self._begun: Optional[float] = None  # time of the bus at the first step
        self._passed = 0  # periods since then
        #: Periods skipped by the model, because steps were too late.
        self.lost = 0

    def due(self, now: float) -> int:
        """The periods that the model runs in the step at this time: 0 in the first one."""
        if self._begun is None:
            self._begun = now
        passed = round((now - self._begun) / self.period)
        periods = min(passed - self._passed, CATCH_UP)
        self.lost += passed - self._passed - periods
        self._passed = passed
        return periods


class Model:
    """An FMU with a map. All mistakes of both are reported here, in one line, before the model is loaded."""

    def __init__(self, path: str, wires: Optional[Map] = None) -> None:
        self.path = path
        self.file = os.path.basename(path)
        self.wires = wires or Map([], [], [])
        self._fmpy = _fmpy()
        self.description = self._read()
        self.version = str(self.description.fmiVersion)[0]
        self._check_kind()
        self._check_platform()
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self._check_map()
        self.period = self._own_period()
        self._folder: Optional[tempfile.TemporaryDirectory[str]] = None
        self._fmu: Any = None
        self._fatal = False
        self.schedule = Schedule(self.period)
        self._run = 0  # periods run by the model

    # --- properties ----------------------------------------------------------------------------------------------------

    def _read(self) -> Any:
        try:
            with zipfile.ZipFile(self.path) as archive:
                archive.getinfo("modelDescription.xml")
            return self._fmpy.read_model_description(self.path, validate=False)
        except OSError as error:
            raise Error(f"cannot open '{self.path}': {error.strerror or error}") from None
        except (zipfile.BadZipFile, KeyError):
            raise Error(f"'{self.path}' is no FMU: an FMU is a ZIP archive with modelDescription.xml") from None
        except Exception as error:  # pylint: disable=broad-exception-caught
            raise Error(f"'{self.path}' cannot be read: {_one_line(error)}") from None

    def _check_kind(self) -> None:
        if self.version not in "23" or self.description.coSimulation is None:
            kind = f"FMI {self.description.fmiVersion}" + ("" if self.description.coSimulation else " without co-simulation")
            raise Error(f"{self.file} is {kind}: export it as FMI 2.0 or 3.0 for co-simulation")

    def _check_platform(self) -> None:
        wanted = _binary(self.version)
        with zipfile.ZipFile(self.path) as archive:
            names = archive.namelist()
        if f"binaries/{wanted}/{self.description.coSimulation.modelIdentifier}.so" in names:
            return
        others = sorted({name.split("/")[1] for name in names if re.fullmatch(r"binaries/[^/]+/[^/]+\.(so|dll|dylib)", name)})
        cure = "export it for Linux"
        if any(re.fullmatch(r"sources/.*\.c", name) for name in names):
            cure += f", or compile its sources: fmpy compile {self.file}"
        raise Error(f"{self.file} has no binary for this platform, {wanted}, only for {', '.join(others) or 'none'}: {cure}")

    def _own_period(self) -> float:
        """The period preferred by the model, in seconds."""
        simulation, experiment = self.description.coSimulation, self.description.defaultExperiment
        for text in (getattr(simulation, "fixedInternalStepSize", None), experiment.stepSize if experiment else None):
            if text:
                return float(text)
        return PERIOD

    # --- the map -------------------------------------------------------------------------------------------------------

    def names(self, *causalities: str) -> str:
        """Some variables of these causalities, for messages."""
        found = [variable.name for variable in self.description.modelVariables if variable.causality in causalities]
        return ", ".join(found[:NAMED]) + (", …" if len(found) > NAMED else "") if found else "none"

    def _number(self, place: str, name: str) -> Any:
        """A variable, which is a number."""
        variable = self.variables.get(name)
        if variable is None:
            known = f"its inputs are {self.names('input')}, its outputs {self.names('output')}"
            raise Error(f"{place}: {self.file} has no variable '{name}': {known}")
        if variable.type not in _LIMITS:
            raise Error(f"{place}: {MODEL}{name} is of type {variable.type}: a signal is a number")
        if variable.dimensions:
            raise Error(f"{place}: {MODEL}{name} is an array: a signal is one number")
        if getattr(variable, "clocks", None):
            raise Error(f"{place}: {MODEL}{name} belongs to a clock, which ectwin-fmu does not support")
        return variable

    def _check_map(self) -> None:
        for start in self.wires.starts:
            variable = self._number(start.place, start.variable)
            if variable.causality not in ("parameter", "input") or variable.variability == "constant":
                raise Error(f"{start.place}: {MODEL}{start.variable} is {self._kind(variable)}: a number is for parameters and inputs")
        for wire in self.wires.inputs:
            variable = self._number(wire.place, wire.variable)
            if variable.causality != "input" and (variable.causality, variable.variability) != ("parameter", "tunable"):
                raise Error(f"{wire.place}: {MODEL}{wire.variable} is {self._kind(variable)}, no input: inputs are {self.names('input')}")
        for wire in self.wires.outputs:
            self._number(wire.place, wire.variable)

    @staticmethod
    def _kind(variable: Any) -> str:
        """The causality, with its article."""
        if variable.causality == "parameter":
            return f"a {variable.variability} parameter"
        return {"output": "an output", "independent": "the time"}.get(variable.causality, f"a {variable.causality} variable")

    def table(self) -> str:
        """The variables that a map can name: name, causality, type."""
        rows = [
            (MODEL + variable.name, variable.causality, variable.type, str(variable.unit or ""))
            for causality in ("input", "output", "parameter")
            for variable in self.description.modelVariables
            if variable.causality == causality and variable.type in _LIMITS and not variable.dimensions
        ]
        width = max((len(name) for name, *_ in rows), default=0)
        return "".join(f"{name:{width}}  {causality:9}  {kind} {unit}".rstrip() + "\n" for name, causality, kind, unit in rows)

    # --- the run -------------------------------------------------------------------------------------------------------

    def plant(self, name: str, period: float) -> Plant:
        """The plant of this model. Call `load` before it is attached."""
        self.period = period
        self.schedule = Schedule(period)
        reads = list(dict.fromkeys(wire.signal for wire in self.wires.inputs))
        return Plant(self.step, reads, [wire.signal for wire in self.wires.outputs], period=period, name=name, fit=True)

    def _say(self, status: int, message: bytes) -> None:
        if status > 0:
            print(f"ectwin-fmu: {self.file}: {_one_line(Exception(message.decode(errors='replace')))}", file=sys.stderr)

    def load(self) -> None:
        """Unpacks, loads and initialises the model."""
        description = self.description
        try:
            self._folder = tempfile.TemporaryDirectory(prefix="ectwin-fmu-")
            self._fmpy.extract(self.path, self._folder.name)
            parts = {
                "guid": description.guid,
                "modelIdentifier": description.coSimulation.modelIdentifier,
                "unzipDirectory": self._folder.name,
                "instanceName": description.modelName or self.file,
            }
            fmu = (self._fmpy.fmi2.FMU2Slave if self.version == "2" else self._fmpy.fmi3.FMU3Slave)(**parts)
            if self.version == "2":
                fmu.instantiate(callbacks=self._callbacks())
            else:
                fmu.instantiate(logMessage=lambda environment, status, category, message: self._say(status, message))
            self._fmu = fmu
            self._set([(self.variables[start.variable], start.value) for start in self.wires.starts])
            if self.version == "2":
                fmu.setupExperiment(startTime=0.0)
                fmu.enterInitializationMode()
            else:
                fmu.enterInitializationMode(startTime=0.0)
            fmu.exitInitializationMode()
        except Exception as error:
            self._fatal = True
            self.close()
            raise Error(f"{self.file} does not start: {_one_line(error)}") from None

    def _callbacks(self) -> Any:
        """The callback functions for an FMU of FMI 2.0."""
        fmi2 = self._fmpy.fmi2
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda environment, name, status, category, message: self._say(status, message))
        callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
        callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory
        self._fmpy.logging.addLoggerProxy(self._fmpy.fmi2.byref(callbacks))
        return callbacks

    def _call(self, way: str, kind: str) -> Any:
        return getattr(self._fmu, way + _CALLS.get((self.version, kind), kind))

    def _set(self, values: List[Tuple[Any, float]]) -> None:
        """Sets variables: one call for each type."""
        for kind in dict.fromkeys(variable.type for variable, _ in values):
            chosen = [(variable, value) for variable, value in values if variable.type == kind]
            numbers = [fitted(value, kind, variable.min, variable.max) for variable, value in chosen]
            self._call("set", kind)([variable.valueReference for variable, _ in chosen], numbers)

    def _get(self, wires: List[Wire]) -> Dict[Name, Number]:
        """The outputs for signals: one call for each type."""
        result: Dict[Name, Number] = {}
        for kind in dict.fromkeys(self.variables[wire.variable].type for wire in wires):
            chosen = [wire for wire in wires if self.variables[wire.variable].type == kind]
            numbers = self._call("get", kind)([self.variables[wire.variable].valueReference for wire in chosen])
            result.update((wire.signal, wire.convert(float(number))) for wire, number in zip(chosen, numbers))
        return result

    def step(self, now: float, values: Mapping[Name, Number]) -> Dict[Name, Number]:
        """Runs the model to `now` with the inputs of the previous step, returns its outputs, and sets the inputs of this step."""
        time = self._run * self.period
        try:
            for _ in range(self.schedule.due(now)):
                time = self._run * self.period
                ended = self._fmu.doStep(currentCommunicationPoint=time, communicationStepSize=self.period)
                self._run += 1
                if ended is not None and ended[1]:
                    raise Error("it ends the simulation")
            result = self._get(self.wires.outputs)
            self._set([(self.variables[wire.variable], wire.convert(values[wire.signal])) for wire in self.wires.inputs])
        except Exception as error:
            self._fatal = True
            raise Error(f"{self.file} has failed at {time:.6g} s of its time: {_one_line(error)}") from None
        return result

    def close(self) -> None:
        """Ends the model and removes its files. A model that has failed is not called again."""
        fmu, self._fmu = self._fmu, None
        try:
            if fmu is not None and not self._fatal:
                fmu.terminate()
                fmu.freeInstance()
        except Exception as error:  # pylint: disable=broad-exception-caught
            print(f"ectwin-fmu: {self.file}: {_one_line(error)}", file=sys.stderr)
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None


# --- the command -------------------------------------------------------------------------------------------------------


def seconds(text: str) -> float:
    """A time in the form of the command ectwin: 10ms."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)(us|ms|s)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}' is no time: write a number with us, ms or s, as in 10ms")
    return float(found[1]) * {"us": 1e-6, "ms": 1e-3, "s": 1.0}[found[2]]


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise Error(f"{message} ('ectwin-fmu --help' shows the usage)")


def _parser() -> _Parser:
    parser = _Parser(prog="ectwin-fmu", description="Steps an FMU (FMI 2.0 or 3.0 co-simulation) between the signals of running twins, until they end.")
    parser.add_argument("model", metavar="MODEL.fmu", help="the FMU, which runs as a part of this program; without --map its variables are listed")
    parser.add_argument("twins", metavar="TWINS", nargs="?", help="name, socket or process of the twins (default: the only ones of this user)")
    parser.add_argument("--map", metavar="FILE", help="connections: a line TARGET=SOURCE for each, as fmu.valve=1.outputs.valve,factor=2")
    parser.add_argument("--period", metavar="TIME", type=seconds, help="from step to step, as 10ms (default: of the model, else 1ms)")
    parser.add_argument("--name", metavar="NAME", help="name of the plant, for 'ectwin stats' and --plant (default: the file's, without .fmu)")
    parser.add_argument("--wait", action="store_true", help="stop a virtual clock during each step: runs are repeatable")
    return parser


def _serve(arguments: argparse.Namespace) -> None:
    model = Model(arguments.model, read(arguments.map) if arguments.map else None)
    if not arguments.map:
        sys.stdout.write(model.table())
        return
    name = arguments.name or os.path.splitext(model.file)[0][:NAME_MOST]
    plant = model.plant(name, arguments.period or model.period)
    try:
        model.load()
        plant.attach(arguments.twins, wait=arguments.wait)
        text = f"signals read: {len(plant.reads)}, set: {len(plant.writes)}, period {round(plant.period * 1e6)} us"
        print(f"ectwin-fmu: {model.file} (FMI {model.description.fmiVersion}): {text}", file=sys.stderr, flush=True)
        plant.serve()
    finally:
        model.close()
        if model.schedule.lost:
            print(f"ectwin-fmu: {model.file} was too late for {model.schedule.lost} periods and has not run in them", file=sys.stderr)


def _end(*_: object) -> NoReturn:
    raise KeyboardInterrupt


def main(words: Optional[List[str]] = None) -> int:
    """The command. Returns its exit code: 0 the twins have ended, 1 refused or failed, with the reason in one line on standard error."""
    signal.signal(signal.SIGTERM, _end)
    try:
        _serve(_parser().parse_intermixed_args(words))
    except Error as error:
        print(f"ectwin-fmu: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
