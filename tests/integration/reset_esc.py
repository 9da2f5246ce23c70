#!/usr/bin/env python3
"""Resets the ESC of all slaves at an interface by the sequence in 0x0040.

usage: reset_esc.py IFACE
"""
import socket
import struct
import sys

BROADCAST_WRITE, RESET_ECAT, ETHERCAT = 8, 0x0040, 0x88A4


def frame(value):
    datagram = struct.pack("<BBHHHHBH", BROADCAST_WRITE, 0, 0, RESET_ECAT, 1, 0, value, 0)
    return (b"\xff" * 6 + b"\x02\0\0\0\0\1" + struct.pack(">H", ETHERCAT) + struct.pack("<H", 1 << 12 | len(datagram)) + datagram).ljust(60, b"\0")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip().splitlines()[-1])
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT)) as wire:
        wire.bind((sys.argv[1], 0))
        wire.settimeout(120)
        for value in b"RES":
            wire.send(frame(value))
            while wire.recvfrom(2048)[1][2] == socket.PACKET_OUTGOING:
                pass


if __name__ == "__main__":
    main()
