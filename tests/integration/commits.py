#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The time at which the chip commits a write.  usage: ectwin with --in-process --virtual-time DEVICE -- commits.py IFACE WHEN

WHEN: at_once (the next datagram reads the new value), at_the_end (the next frame does), late (a frame after the next one)."""
import socket
import struct
import sys

ETHERCAT, APRD, APWR, GENERAL_OUTPUTS = 0x88A4, 1, 2, 0x0F10


def frame(*datagrams):
    """Datagrams of 2 bytes of data"""
    data = b""
    for number, (command, value) in enumerate(datagrams):
        more = 0x8000 if number + 1 < len(datagrams) else 0
        data += struct.pack("<BBHHHHHH", command, 0, 0, GENERAL_OUTPUTS, 2 | more, 0, value, 0)
    head = b"\xff" * 6 + b"\x02\0\0\0\0\1" + struct.pack(">H", ETHERCAT) + struct.pack("<H", 0x1000 | len(data))
    return (head + data).ljust(60, b"\0")


def value_of(reply, number):
    return struct.unpack_from("<H", reply, 16 + 14 * number + 10)[0]


def run(iface):
    """@return the values of the second datagram, of the next frame, and of a frame after two replies"""
    wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT))
    wire.bind((iface, ETHERCAT))
    wire.setsockopt(263, 23, 1)  # PACKET_IGNORE_OUTGOING
    wire.settimeout(1)
    wire.send(frame((APWR, 0x1111), (APRD, 0)))
    wire.send(frame((APRD, 0)))
    values = [value_of(wire.recv(2000), 1), value_of(wire.recv(2000), 0)]
    wire.send(frame((APRD, 0)))
    return [*values, value_of(wire.recv(2000), 0)]


WANTED = {"at_once": [0x1111, 0x1111, 0x1111], "at_the_end": [0, 0x1111, 0x1111], "late": [0, 0, 0x1111]}
got = run(sys.argv[1])
if got != WANTED[sys.argv[2]]:
    sys.exit(f"{sys.argv[2]}: expected {WANTED[sys.argv[2]]}, got {got}")
