#!/usr/bin/env python3
"""Checks the records of tools/dev/soak.sh.  usage: soak_check.py FOLDER"""
import json
import pathlib
import sys
import zlib

folder = pathlib.Path(sys.argv[1])
controller = [json.loads(line) for line in (folder / "controller").read_text().splitlines()]
end = controller[-1] if controller else {}
if end.get("event") != "end":
    sys.exit(f"FAILED the controller did not come to its end; its last line was {end}")
failures = []


def check(what, condition):
    if not condition:
        failures.append(what)


def check_order(what, numbers, sent):
    """The numbers sent are 1, 2, ...; reports the first received number that differs."""
    wrong = next((i for i, n in enumerate(numbers) if n != i + 1), None)
    if wrong is not None:
        check(f"{what}: number {wrong + 1} expected, {numbers[wrong]} came", False)
    elif len(numbers) < sent:
        check(f"{what}: all in order, but the last {sent - len(numbers)} of {sent} had not come when the time was over", False)
    elif len(numbers) > sent:
        check(f"{what}: all in order, but {len(numbers)} came and {sent} were sent", False)


operator_sent = int((folder / "operator").read_text())
operator_got = [int(e["data"][16:], 16) for e in controller if e["event"] == "command"]
check_order("operator's commands", operator_got, operator_sent)

values = [json.loads(line)["value"] for line in (folder / "received").read_text().splitlines()]
numbers = [int(v[24:], 16) for v in values if v.startswith("636f6e74726f6c6c6572")]
count = int((folder / "count").read_text().split("=")[1])
check_order("controller's commands", numbers, len(numbers))
check("controller's commands: none lost", len(numbers) == count and end["commands_sent"] - count in (0, 1))

expected = zlib.crc32(bytes(i * 7 & 0xFF for i in range(4321)))
checks = [int(json.loads(line)["value"]) for line in (folder / "sets").read_text().splitlines()]
check("periodic data: every set whole", set(checks) <= {0, expected} and expected in checks)

print(f"operator's commands {operator_sent}, received {len(operator_got)}; controller's commands {end['commands_sent']}, "
      f"received {count}; sets sent {end['sets_sent']}; bus starts {end['starts']}, cycles lost {end['lost_cycles']}")
for failure in failures:
    print(f"FAILED {failure}")
print("failed" if failures else "all arrived exactly once and in order, every set was whole")
sys.exit(1 if failures else 0)
