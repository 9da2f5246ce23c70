# SPDX-License-Identifier: MIT
"""The comments in a capture of --pcap: faults, plugs, state changes, requests (docs/COMMAND.md, Captures)."""

from __future__ import annotations

import os
import struct
import time
from typing import Iterator, List, Tuple

_PACKET = 6  # type of an Enhanced Packet Block
_COMMENT = 1  # code of its option
_WAITS_S = 5.0  # for frames that the twins have captured and not yet written
_WAITS_BYTES = 1 << 24  # a longer file is not read again


def _blocks(data: bytes) -> Iterator[Tuple[int, bytes]]:
    """(type, body) of each complete block; a file under construction may end anywhere."""
    at = 0
    while at + 12 <= len(data):
        kind, length = struct.unpack_from("<II", data, at)
        if length < 12 or at + length > len(data):
            return
        yield kind, data[at + 8 : at + length - 4]
        at += length


def _comments(packet: bytes) -> Iterator[str]:
    (captured,) = struct.unpack_from("<I", packet, 12)
    at = 20 + (captured + 3) // 4 * 4
    while at + 4 <= len(packet):
        code, length = struct.unpack_from("<HH", packet, at)
        if code == _COMMENT:
            yield packet[at + 4 : at + 4 + length].decode(errors="replace")
        at += 4 + (length + 3) // 4 * 4


def _packets(path: str) -> List[bytes]:
    with open(path, "rb") as file:
        return [body for kind, body in _blocks(file.read()) if kind == _PACKET]


def events(path: str, most: int, frames: int = 0) -> List[str]:
    """The number of frames, and the last `most` lines of their comments, each with the number of its frame.

    Waits until the file contains so many `frames`, because a thread of the twins writes it.
    """
    packets = _packets(path)
    end = time.monotonic() + _WAITS_S
    while len(packets) < frames and os.path.getsize(path) < _WAITS_BYTES and time.monotonic() < end:
        time.sleep(0.02)
        packets = _packets(path)
    lines = [
        f"  frame {number}: {line}"
        for number, packet in enumerate(packets, 1)
        for comment in _comments(packet)
        for line in comment.splitlines()
    ]
    return [f"capture: {path}, {len(packets)} frames", *lines[-most:]]
