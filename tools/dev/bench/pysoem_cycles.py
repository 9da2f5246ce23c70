#!/usr/bin/env python3
"""Cycles of pysoem with a sleep of 1 ms in each, after OP.  usage: pysoem_cycles.py IFACE CYCLES

Prints one line of JSON: slaves, cycles with another working counter than expected, seconds of the bus, seconds of processor time.
"""
import json
import sys
import time

import pysoem


def operate(master):
    if master.config_init() <= 0:
        sys.exit("pysoem_cycles.py: no slave replies")
    master.config_map()
    master.state_check(pysoem.SAFEOP_STATE, 500_000)
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(500):
        master.send_processdata()
        master.receive_processdata(2000)
        if master.state_check(pysoem.OP_STATE, 2000) == pysoem.OP_STATE:
            return
    sys.exit("pysoem_cycles.py: the slaves do not reach OP")


def main():
    master = pysoem.Master()
    master.open(sys.argv[1])
    operate(master)
    lost, start, used = 0, time.monotonic(), time.process_time()
    for _ in range(int(sys.argv[2])):
        master.send_processdata()
        lost += master.receive_processdata(2000) != master.expected_wkc
        time.sleep(0.001)
    result = {"slaves": len(master.slaves), "lost": lost, "bus_s": round(time.monotonic() - start, 3),
              "processor_s": round(time.process_time() - used, 3)}
    master.read_state()
    if any(slave.state != pysoem.OP_STATE for slave in master.slaves):
        sys.exit("pysoem_cycles.py: a slave has left OP")
    master.close()
    print(json.dumps(result))


main()
