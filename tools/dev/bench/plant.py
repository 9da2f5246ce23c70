#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Latency of a plant in Python with a bus at 1 kHz: prints the counters of `ectwin stats` as a table.

usage: plant.py FOLDER [SECONDS]      FOLDER of ectwin and ectwin-plc, as build/release; 20 s for each row by default
"""

import os
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "python"))
import ectwin  # noqa: E402

TWINS, SIGNALS = 8, 100


def measure(folder, count, seconds):
    """A row: `count` signals read and set, while the PLC of an FZM1 runs with a cycle of 1 ms."""
    names = [(n % TWINS + 1, f"data{n // TWINS + 1}") for n in range(count // 2)]
    plant = ectwin.Plant(lambda now, values: values, names, names, name="bench")
    with ectwin.start(["fzm1"] * TWINS, program=os.path.join(folder, "ectwin")) as twin:
        master = twin.popen([os.path.join(folder, "ectwin-plc"), "--cycle-us", "1000", "-m", "1000000", "{}"], stdout=-3, stderr=-3)
        twin.wait("ecat.state", 8, timeout=60)
        stop = threading.Event()
        with plant.start(twin):
            stop.wait(seconds)
            stats = twin.stats()
        master.terminate()
        return stats["plants"]["bench"], stats


def main():
    folder, seconds = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 20
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores, {time.strftime('%Y-%m-%d')}")
    print("| signals | steps | late | half within | 99 % within | longest | replies to frames: 99 % within |")
    print("|--:|--:|--:|--:|--:|--:|--:|")
    for count in (2, 20, SIGNALS):
        plant, bus = measure(folder, count, seconds)
        print(f"| {count} | {plant['steps']} | {plant['late']} | {plant['p50_us']} µs | {plant['p99_us']} µs | {plant['longest_us']} µs | {bus['p99_us']} µs |")


if __name__ == "__main__":
    main()
