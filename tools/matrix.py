#!/usr/bin/env python3
"""Which tests stand for which requirement on the base unit, or why none does.  usage: tools/matrix.py

The ids are those in the tests' titles. Exits with 1 when a requirement has neither a test nor a reason, or has both,
or when no test shows it over the wire and nothing says why.
"""
import pathlib
import re
import sys

LAST = 74
NO_TEST = {
    4: "a convention of the document (sizes are bytes)",
    5: "the web page on the TEST PORT is not part of an EtherCAT twin",
    17: "two connectors: each twin of a chain has an IN and an OUT, which every test of a chain uses",
    70: "Modbus TCP: another variant of the product",
    71: "Modbus TCP: another variant of the product",
    74: "asks for nothing: the unit runs freely, without distributed clocks",
}
NOT_ON_THE_WIRE = {
    14: "a lamp: no register shows it",
    15: "a lamp: no register shows it",
    16: "a lamp: no register shows it",
}
WIRE = "integration"
TESTS = pathlib.Path(__file__).resolve().parent.parent / "tests"


def ids(text):
    for first, last in re.findall(r"ECL-(\d{3})(?:\.\.(\d{3}))?", text):
        yield from range(int(first), int(last or first) + 1)


def titles(path):
    """The titles of a C test, or the comments above the cases of a shell script."""
    text = path.read_text()
    if path.suffix == ".sh":
        return re.findall(r"^# (ECL-.*)$", text, re.M)
    strings = re.findall(r'((?:"(?:[^"\\\n]|\\.)*"\s*)+)', text)
    joined = ["".join(re.findall(r'"((?:[^"\\]|\\.)*)"', s)) for s in strings]
    return [s for s in joined if re.match(r"[A-Z]+-\d{3}", s)]


found = {}
for path in sorted(TESTS.glob("*/*")):
    if path.suffix in (".c", ".sh"):
        for title in titles(path):
            for number in ids(title):
                found.setdefault(number, []).append((path.relative_to(TESTS), title))

wrong = 0
for number in range(1, LAST + 1):
    tests = found.get(number, [])
    for path, title in tests:
        print(f"ECL-{number:03}  {path}: {title}")
    if number in NO_TEST:
        print(f"ECL-{number:03}  no test: {NO_TEST[number]}")
    if bool(tests) == (number in NO_TEST):
        print(f"ECL-{number:03}  WRONG: {'a test and a reason for none' if tests else 'neither a test nor a reason'}")
        wrong += 1

on_wire = {number for number, tests in found.items() if any(path.parts[0] == WIRE for path, _ in tests)}
for number in sorted(set(found) - on_wire - set(NOT_ON_THE_WIRE)):
    print(f"ECL-{number:03}  WRONG: no test drives it over the wire")
    wrong += 1
for number, reason in NOT_ON_THE_WIRE.items():
    print(f"ECL-{number:03}  not on the wire: {reason}")
print(f"{len(found)} of {LAST} requirements have tests, {len(on_wire)} of them also over the wire; {len(NO_TEST)} have a reason for none")
sys.exit(1 if wrong else 0)
