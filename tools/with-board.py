#!/usr/bin/env python3
"""Runs a command with a board, emulated by QEMU, at the other end of its wire, like `ectwin with` with twins.

usage: with-board.py [--serial FILE] [--tap|--no-tap] IMAGE.elf -- CMD ARG...

IMAGE is a firmware of firmware/boards/mps2-an385, in a folder with its loader.elf. CMD runs in a private user and network
namespace, where the interface ecat0 is connected to the board; each {} in ARG, and $ECTWIN_IFACE, is its name. Exits with CMD's
status; 77 if QEMU is not available, 3 if the board does not start. FILE gets the output of the board's serial line.

The wire is a tap device; without /dev/net/tun, or with --no-tap, a veth pair whose far end is relayed to QEMU.
"""
import argparse
import os
import pathlib
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

IFACE, FAR = "ecat0", "board0"
NOT_STARTED, SKIPPED = 3, 77
QEMU = "qemu-system-arm"
START_SECONDS = 20
INSIDE = "ECTWIN_WITH_BOARD"


def ip(*words):
    subprocess.run(["ip", *words], check=True)


def quiet_interface(name):
    """Disables addresses and their configuration, because the wire is for EtherCAT only."""
    ip("link", "set", "dev", name, "addrgenmode", "none")
    ip("link", "set", "dev", name, "mtu", "1500", "up")


def tap():
    """@return QEMU's name of a tap device"""
    ip("tuntap", "add", "dev", IFACE, "mode", "tap")
    quiet_interface(IFACE)
    return f"tap,ifname={IFACE},script=no,downscript=no"


def relay(wire, board, address):
    """Relays frames in both directions, endlessly. A frame before QEMU's start is lost, as on a wire without link."""
    while True:
        for ready in select.select([wire, board], [], [])[0]:
            frame = ready.recv(2048)
            try:
                if ready is wire:
                    board.sendto(frame, address)
                else:
                    wire.send(frame)
            except OSError:
                pass


def veth(folder):
    """@return QEMU's name of a veth pair and two sockets"""
    ip("link", "add", IFACE, "type", "veth", "peer", "name", FAR)
    for name in (IFACE, FAR):
        quiet_interface(name)
    wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
    wire.bind((FAR, 0))
    ours, theirs = f"{folder}/ours", f"{folder}/theirs"
    board = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    board.bind(ours)
    threading.Thread(target=relay, args=(wire, board, theirs), daemon=True).start()
    return f"dgram,local.type=unix,local.path={theirs},remote.type=unix,remote.path={ours}"


def before_others():
    """Real-time priority, if the system permits it (root), because a board that waits for a busy machine is defective for its
    master."""
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except PermissionError:
        pass


def wait_for_board(qemu, serial):
    """Waits until the board is ready: it has written its first line."""
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end and qemu.poll() is None:
        if "\n" in serial.read_text(errors="replace"):
            return True
        time.sleep(0.02)
    return False


def run(options, folder):
    serial = pathlib.Path(options.serial or f"{folder}/serial")
    serial.write_text("")
    loader = pathlib.Path(options.image).with_name("loader.elf")
    wire = tap() if options.tap else veth(folder)
    with open(f"{folder}/qemu", "w+b") as log, \
         subprocess.Popen([QEMU, "-M", "mps2-an385", "-kernel", str(loader), "-device", f"loader,file={options.image}", "-display", "none", "-monitor", "none",
                           "-serial", f"file:{serial}", "-netdev", f"{wire},id=wire", "-net", "nic,model=lan9118,netdev=wire"],
                          stdin=subprocess.DEVNULL, stderr=log) as qemu:
        try:
            if not wait_for_board(qemu, serial):
                log.seek(0)
                print(f"the board does not start: {serial.read_text(errors='replace')!r}, {QEMU}: {log.read().decode()!r}", file=sys.stderr)
                return NOT_STARTED
            command = [word.replace("{}", IFACE) for word in options.command]
            return subprocess.run(command, env={**os.environ, "ECTWIN_IFACE": IFACE}, check=False).returncode
        finally:
            qemu.terminate()


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--serial")
    parser.add_argument("--tap", action=argparse.BooleanOptionalAction, default=os.access("/dev/net/tun", os.R_OK | os.W_OK))
    parser.add_argument("image")
    parser.add_argument("command", nargs="+")
    options = parser.parse_args()
    if not shutil.which(QEMU):
        print(f"skipped: no {QEMU} here; tools/bootstrap.sh test installs it", file=sys.stderr)
        return SKIPPED
    if INSIDE not in os.environ:
        before_others()
        os.execvpe("unshare", ["unshare", "-Urn", sys.executable, *sys.argv], {**os.environ, INSIDE: "1"})
    with tempfile.TemporaryDirectory() as folder:
        return run(options, folder)


if __name__ == "__main__":
    sys.exit(main())
