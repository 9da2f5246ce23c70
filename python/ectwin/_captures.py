# SPDX-License-Identifier: MIT
"""The comments in a capture of --pcap: faults, plugs, state changes, requests (docs/COMMAND.md, Captures)."""

from __future__ import annotations

import struct
from typing import Iterator, List, Tuple

_PACKET = 6  # type of an Enhanced Packet Block
_COMMENT = 1  # code of its option


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


def events(path: str, most: int) -> List[str]:
    """The number of frames, and the last `most` lines of their comments, each with the number of its frame."""
    with open(path, "rb") as file:
        packets = [body for kind, body in _blocks(file.read()) if kind == _PACKET]
    lines = [
        f"  frame {number}: {line}"
        for number, packet in enumerate(packets, 1)
        for comment in _comments(packet)
        for line in comment.splitlines()
    ]
    return [f"capture: {path}, {len(packets)} frames", *lines[-most:]]
