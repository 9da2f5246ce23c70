# SPDX-License-Identifier: MIT
"""Functions of this program in the private network of a twin."""

from __future__ import annotations

import ctypes
import os
import pickle
import sys
import traceback
import warnings
from typing import Any, Callable, Dict, Tuple, TypeVar

from ._errors import Error

Result = TypeVar("Result")

_SPACES = ("user", "net")


def _setns(descriptor: int) -> None:
    if hasattr(os, "setns"):  # Python 3.12
        os.setns(descriptor, 0)
        return
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.setns(descriptor, 0) < 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))


def enter(process: int) -> None:
    """Moves the calling thread into the user and network namespaces of a process. OSError: missing capabilities."""
    opened = []
    for space in _SPACES:
        theirs, own = f"/proc/{process}/ns/{space}", f"/proc/self/ns/{space}"
        if os.readlink(theirs) != os.readlink(own):
            opened.append(os.open(theirs, os.O_RDONLY | os.O_CLOEXEC))
    try:
        for descriptor in opened:
            _setns(descriptor)
    finally:
        for descriptor in opened:
            os.close(descriptor)


class Remote(Exception):
    """The traceback, as text, of an exception in the process that Twin.call has started."""


def _outcome(process: int, function: Callable[..., Any], args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> bytes:
    try:
        enter(process)
        outcome = (True, function(*args, **kwargs), "")
    except BaseException as error:  # pylint: disable=broad-except
        outcome = (False, error, traceback.format_exc())
    try:
        return pickle.dumps(outcome)
    except Exception as error:  # pylint: disable=broad-except
        reason = outcome[2] or f"the result cannot be sent back: {error}"
        return pickle.dumps((False, Error(reason.strip().splitlines()[-1]), reason))


def _child(process: int, pipe: int, function: Callable[..., Any], args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> None:
    status = 1
    try:
        with os.fdopen(pipe, "wb") as writer:
            writer.write(_outcome(process, function, args, kwargs))
        sys.stdout.flush()
        sys.stderr.flush()
        status = 0
    finally:
        os._exit(status)


def call(process: int, function: Callable[..., Result], args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> Result:
    """function(*args, **kwargs) in a child of this process, in the network of `process`."""
    reader, writer = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # about fork beside threads; the child starts none
        pid = os.fork()
    if pid == 0:
        os.close(reader)
        _child(process, writer, function, args, kwargs)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        data = pipe.read()
    _, status = os.waitpid(pid, 0)
    if not data:
        raise Error(f"the process in the twin's network has ended with wait status {status}")
    done, result, text = pickle.loads(data)
    if done:
        value: Result = result
        return value
    raise result from Remote("\n" + text)
