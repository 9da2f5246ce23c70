#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The reply to a tagged frame has its tag, the reply to a plain frame has none.  usage: ectwin with DEVICE -- vlan.py IFACE"""

import socket
import struct
import sys

ETHERCAT, VLAN, SOL_PACKET, AUXDATA, VALID = 0x88A4, 0x8100, 263, 8, 0x10

wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x0003))
wire.bind((sys.argv[1], 0))
wire.setsockopt(SOL_PACKET, AUXDATA, 1)
wire.setsockopt(SOL_PACKET, 23, 1)  # PACKET_IGNORE_OUTGOING
wire.settimeout(5)


def exchange(tag):
    """@return the tag of the answer, None without one, and its working counter"""
    header = b"\xff" * 6 + b"\x02\x00\x00\x00\x00\x01" + (struct.pack("!HH", VLAN, tag) if tag is not None else b"")
    datagram = struct.pack("<BBHHHH", 7, 1, 0, 0x0130, 2, 0) + bytes(2) + bytes(2)  # BRD of AL status
    frame = header + struct.pack("!H", ETHERCAT) + struct.pack("<H", 0x1000 | len(datagram)) + datagram
    wire.send(frame.ljust(64, b"\0"))
    while True:
        data, known, _, _ = wire.recvmsg(2048, 256)
        kind = struct.unpack("!H", data[12:14])[0]
        got, at = None, 14
        if kind == VLAN:
            got, kind = struct.unpack("!HH", data[14:18])
            at = 18
        for level, what, value in known:
            if (level, what) == (SOL_PACKET, AUXDATA):
                status, _, _, _, _, tci = struct.unpack("=IIIHHH", value[:18])
                got = tci if status & VALID else got
        if kind == ETHERCAT:
            return got, struct.unpack("<H", data[at + 14 : at + 16])[0]


failed = 0
for tag in (None, 0x0005, 0xE123, None):
    got = exchange(tag)
    if got != (tag, 1):
        print(f"FAILED VLAN tag\n  expected: {tag}, working counter 1\n  got:      {got}")
        failed = 1
sys.exit(failed)
