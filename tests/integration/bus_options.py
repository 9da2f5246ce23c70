#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every option of `run` and `with` that belongs to a bus is a key of a bus file, with a value that `ectwin check` takes.

The options are those of --help. A new one fails here until it has a row in KEYS, or in NOT_OF_A_BUS with the reason.

usage: bus_options.py ECTWIN ESI-FOLDER
"""
import os
import re
import subprocess
import sys
import tempfile

FZM1, BASE, DRIVE, EOE = "fzm1", "vr-bu-ect-map7", "esi:ESI/drives.xml#SERVO", "esi:ESI/every.xml"
MODULAR, NETWORK = "esi:ESI/modular.xml", "eni:ESI/../eni/machine.xml"

# Option, value in the file, device; the paths of files that must be there are made below.
KEYS = [
    ("al-delay", "1..2", FZM1),
    ("alias", "5", FZM1),
    ("behaviour", "none", DRIVE),
    ("break", "CF-001", FZM1),
    ("busy-poll", "true", FZM1),
    ("in-kernel", "true", FZM1),
    ("panel", "1", FZM1),
    ("cable", "20", FZM1),
    ("connect", "1.data1=2.data2", FZM1 + "\n  - device: " + FZM1),
    ("dc-jitter", "5", FZM1),
    ("delay", "1", FZM1),
    ("delay-us", "10", FZM1),
    ("drift", "12", FZM1),
    ("drop", "1", FZM1),
    ("eeprom-times", "chip", FZM1),
    ("eoe", "unix:socket", EOE),
    ("esc", "lan9252", FZM1),
    ("esi-dir", ".", NETWORK),
    ("fault", "drop 5%", FZM1),
    ("faults", "faults.txt", FZM1),
    ("files", "folder", FZM1),
    ("files-password", "7", FZM1),
    ("jitter", "1", FZM1),
    ("keep-source-mac", "true", FZM1),
    ("like", "lan9252-spi", FZM1),
    ("mailbox-delay", "1", FZM1),
    ("modbus", "127.0.0.1:0", BASE),
    ("module", "1=0x120", MODULAR),
    ("name", "press", FZM1),
    ("pcap", "bus.pcapng", FZM1),
    ("pcap-size", "1M", FZM1),
    ("play", "wave.csv", FZM1),
    ("product-code", "7", FZM1),
    ("quiet", "true", FZM1),
    ("realtime", "50", FZM1),
    ("record", "bus.pcapng", FZM1),
    ("revision", "7", FZM1),
    ("scenario", "scenario.txt", FZM1),
    ("seed", "7", FZM1),
    ("serial", "7", FZM1),
    ("set", "data1=1", FZM1),
    ("store", "folder", FZM1),
    ("udp", "34980", FZM1),
    ("vendor-id", "7", FZM1),
    ("wire", "2:1.3", FZM1 + "\n  - device: " + FZM1),
]

NOT_OF_A_BUS = {
    "external": "a program in place of the twins",
    "help": "of the command",
    "iface": "the interface belongs to the machine, or to the command that is run",
    "in-process": "how CMD is run",
    "interface": "the interface belongs to the machine",
    "leave-children": "how CMD is run",
    "output": "the interface belongs to the machine",
    "plant": "how CMD is run",
    "require-private": "how CMD is run",
    "usage": "of the command",
    "virtual-time": "how CMD is run",
}

ectwin, esi = os.path.realpath(sys.argv[1]), os.path.realpath(sys.argv[2])
failed = False


def fail(line):
    global failed
    failed = True
    print("FAILED " + line)


def options(command):
    text = subprocess.run([ectwin, command, "--help"], capture_output=True, text=True, check=True).stdout
    heads = r"^(?:  -[\w?], | {6}| {35})--([a-z][a-z0-9-]*)"  # one that is too long for its column stands alone
    return set(re.findall(heads, text, re.MULTILINE))


def check(folder, key, value, device):
    path = os.path.join(folder, "bus.yaml")
    with open(path, "w", encoding="utf-8") as file:
        quoted = "'" + value + "'"
        file.write(f"ectwin: 1\n{key}: {value if value == 'true' else quoted}\ntwins:\n  - device: {device.replace('ESI', esi)}\n")
    return subprocess.run([ectwin, "check", "--quiet", path], capture_output=True, text=True, cwd="/", check=False)


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "folder"))
        for name, text in (("faults.txt", "drop 1%\n"), ("scenario.txt", "at 1s set data1=1\n"), ("wave.csv", "time,data1\n0,1\n")):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        for key, value, device in KEYS:
            ran = check(folder, key, value, device)
            if ran.returncode != 0:
                fail(f"'{key}: {value}' of a bus file: {ran.stderr.strip()}")
        for key, reason in NOT_OF_A_BUS.items():
            ran = check(folder, key, "true", FZM1)
            if f"'{key}' is no key of a bus" not in ran.stderr:
                fail(f"'{key}' is refused ({reason}): {ran.stderr.strip() or 'it is not'}")
    known = {key for key, _, _ in KEYS} | set(NOT_OF_A_BUS)
    given = options("run") | options("with")
    for name in sorted(given - known):
        fail(f"--{name} is neither a key of a bus file nor an exception: add it to KEYS or NOT_OF_A_BUS")
    for name in sorted(known - given):
        fail(f"--{name} is in this test, and neither 'run' nor 'with' has it")
    return 1 if failed else 0


sys.exit(main())
