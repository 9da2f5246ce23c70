#!/usr/bin/env python3
"""Broadcast reads into a wire, and their replies.  usage: frames.py IFACE COUNT PAUSE_MS [SECONDS [RUNS]]

Sends COUNT frames, at least PAUSE_MS apart, each with its number as index, and listens until all are back or none comes
for SECONDS (default 5) after the last one. A machine that stands still for longer loses no frame: all are sent, and the
socket is read before the end. Prints a line for each reply: number, working counter, milliseconds since it
was sent. RUNS repeats this, with a line "run" before each time."""
import select
import socket
import struct
import sys
import time

ETHERTYPE = 0x88A4


def frame(number):
    datagram = struct.pack("<BBHHHH", 7, number, 0, 0, 1, 0) + bytes(3)
    return b"\xff" * 6 + b"\x01" * 6 + struct.pack(">H", ETHERTYPE) + struct.pack("<H", 0x1000 | len(datagram)) + datagram


def run(wire, count, pause, patience):
    sent, back = [], 0
    while back < count:
        if len(sent) < count and (not sent or time.monotonic() >= sent[-1] + pause):
            sent.append(time.monotonic())
            heard = sent[-1]
            wire.send(frame(len(sent) - 1).ljust(60, b"\0"))
        until = sent[-1] + pause if len(sent) < count else heard + patience
        if not select.select([wire], [], [], max(0, until - time.monotonic()))[0]:
            if len(sent) == count:
                break
            continue
        heard = time.monotonic()
        answer, address = wire.recvfrom(2000)
        if address[2] == socket.PACKET_OUTGOING:
            continue
        number, counter = answer[17], struct.unpack_from("<H", answer, 27)[0]
        print(number, counter, int(1000 * (time.monotonic() - sent[number])))
        back += 1


def main():
    iface, count, pause = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]) / 1000
    patience = float(sys.argv[4]) if len(sys.argv) > 4 else 5
    for _ in range(int(sys.argv[5]) if len(sys.argv) > 5 else 1):
        if len(sys.argv) > 5:
            print("run")
        with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE)) as wire:
            wire.bind((iface, ETHERTYPE))
            run(wire, count, pause, patience)


main()
