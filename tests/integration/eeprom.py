#!/usr/bin/env python3
"""Words of slaves' EEPROMs, as a master reads and writes them.  usage: eeprom.py IFACE POSITION:WORD[=VALUE]...

Positions are counted from 1. Prints what is read, in hexadecimal, in one line."""
import select
import socket
import struct
import sys

ETHERTYPE, APRD, APWR, CONTROL, DATA, BUSY = 0x88A4, 1, 2, 0x0502, 0x0508, 0x8000


def exchange(wire, command, position, register, data):
    datagram = struct.pack("<BBHHHH", command, 0, (1 - position) & 0xFFFF, register, len(data), 0) + data + bytes(2)
    frame = b"\xff" * 6 + b"\x01" * 6 + struct.pack(">H", ETHERTYPE) + struct.pack("<H", 0x1000 | len(datagram)) + datagram
    for _ in range(50):
        wire.send(frame.ljust(60, b"\0"))
        while select.select([wire], [], [], 0.2)[0]:
            answer, address = wire.recvfrom(2000)
            if address[2] != socket.PACKET_OUTGOING and answer[20:22] == frame[20:22]:
                if struct.unpack_from("<H", answer, 26 + len(data))[0] == 1:
                    return answer[26:26 + len(data)]
    sys.exit("no answer")


def wait(wire, position):
    while struct.unpack("<H", exchange(wire, APRD, position, CONTROL, bytes(2)))[0] & BUSY:
        pass


def main():
    wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE))
    wire.bind((sys.argv[1], ETHERTYPE))
    read = []
    for argument in sys.argv[2:]:
        place, _, value = argument.partition("=")
        position, word = (int(part, 0) for part in place.split(":"))
        wait(wire, position)
        if value:
            exchange(wire, APWR, position, CONTROL, struct.pack("<HLH", 0x0201, word, int(value, 0)))
        else:
            exchange(wire, APWR, position, CONTROL, struct.pack("<HL", 0x0100, word))
        wait(wire, position)
        if not value:
            read.append("%04x" % struct.unpack("<H", exchange(wire, APRD, position, DATA, bytes(2)))[0])
    print(*read)


main()
