#!/usr/bin/env python3
"""Prints the tests of each requirement on the devices, or the reason for none.  usage: tools/dev/matrix.py

The ids are those in the tests' titles. Exits with 1 if a requirement has neither a test nor a reason, or has both, or if it has
neither a test over the wire nor a reason for none.
"""
import pathlib
import re
import sys

WIRE = "integration"
TESTS = pathlib.Path(__file__).resolve().parents[2] / "tests"

# For each product: prefix of its ids, the last id, reasons for ids without a test, reasons for ids without a test over the wire.
PRODUCTS = [
    ("ECL", 74, {
        4: "a convention of the document (sizes are bytes)",
        5: "the web page on the TEST PORT is not part of an EtherCAT twin",
        17: "two connectors: each twin of a chain has an IN and an OUT, which every test of a chain uses",
        74: "asks for nothing: the unit runs freely, without distributed clocks",
    }, {63: "an order inside the updates of 125 ms: on the virtual clock, where each can be looked at"}),
    ("FZM", 77, {
        17: "100BASE-TX and two connectors: each twin of a chain has an IN and an OUT, which every test of a chain uses",
        25: "the serial PLC links are not part of an EtherCAT twin",
        74: "how the master lays several sensors out in its own memory",
        76: "how many sensors a certain master takes",
    }, {23: "how long each flash takes: on the virtual clock only"}),
    ("OPT", 14, {}, {}),
    ("PLZ", 31, {26: "advice on analogue outputs, which the twin does not have"}, {}),
]

# The statements on drives, DRV, and reasons for statements without a test; the number of tested statements may only increase.
DRIVE_RANGES = [(1, 7), (9, 16), (18, 18), (20, 20), (22, 27), (30, 30), (32, 32), (34, 42), (44, 44), (46, 49), (51, 51), (53, 53),
                (55, 58), (60, 60), (62, 62), (64, 68), (70, 76), (78, 84), (90, 113), (115, 180), (201, 207), (210, 224), (230, 241),
                (245, 248), (250, 252), (255, 263), (265, 295), (301, 309), (311, 312), (401, 431), (501, 507), (509, 519), (521, 521),
                (523, 524), (526, 530), (601, 605), (607, 624)]
DRIVE_TESTED = 321
DRIVE_NO_TEST = {
    53: "the twin does not have 6093h, 6096h and 6097h of older versions: those of a file are plain values",
    68: "the twin does not have time stamps of touch probes: those of a file, 60D1h to 60D4h, are plain values",
    81: "the twin does not have data of the motor: those of a file, 6402h to 6404h, are plain values",
    83: "the twin does not have 67FFh of its own: that of a file is a plain value",
    84: "the twin does not have vl, mode 2, and thus none of its objects",
    252: "the twin does not have vl, mode 2",
    622: "asks for nothing: the NC of this master finds home and the following error by itself",
}

# The statements on SoE: services, then commands, IDNs and process data, and reasons for statements without a test.
SOE_RANGES = [(1, 22), (30, 46)]
SOE_TESTED = 37
SOE_NO_TEST = {
    22: "asks for nothing: a mistake of SOEM 2.0, whose users are advised to take 1.4",
    42: "the twin does not have the masks of changes, S-0-0097 and S-0-0098: those of a file are plain values",
}


def ids(prefix, text):
    for first, last in re.findall(prefix + r"-(\d{3})(?:\.\.(\d{3}))?", text):
        yield from range(int(first), int(last or first) + 1)


def titles(path):
    """The titles of a C test, or the comments above the cases of a script."""
    text = path.read_text()
    if path.suffix in (".sh", ".py"):
        return re.findall(r"^ *# ([A-Z]{3}-.*)$", text, re.M)
    strings = re.findall(r'((?:"(?:[^"\\\n]|\\.)*"\s*)+)', text)
    joined = ["".join(re.findall(r'"((?:[^"\\]|\\.)*)"', s)) for s in strings]
    return [s for s in joined if re.match(r"[A-Z]+-\d{3}", s)]


def judge(prefix, last, no_test, not_on_the_wire, all_titles):
    """Prints the matrix of a product. @return the number of mistakes, and a summary"""
    found = {}
    for path, title in all_titles:
        for number in ids(prefix, title):
            found.setdefault(number, []).append((path, title))
    wrong = 0
    for number in range(1, last + 1):
        tests = found.get(number, [])
        for path, title in tests:
            print(f"{prefix}-{number:03}  {path}: {title}")
        if number in no_test:
            print(f"{prefix}-{number:03}  no test: {no_test[number]}")
        if bool(tests) == (number in no_test):
            print(f"{prefix}-{number:03}  WRONG: {'a test and a reason for none' if tests else 'neither a test nor a reason'}")
            wrong += 1
    on_wire = {number for number, tests in found.items() if any(path.parts[0] == WIRE for path, _ in tests)}
    for number in sorted(set(found) - on_wire - set(not_on_the_wire)):
        print(f"{prefix}-{number:03}  WRONG: no test drives it over the wire")
        wrong += 1
    for number, reason in not_on_the_wire.items():
        print(f"{prefix}-{number:03}  not on the wire: {reason}")
    return wrong, (f"{prefix}: {len(found)} of {last} requirements have tests, {len(on_wire)} of them also over the wire; "
                   f"{len(no_test)} have a reason for none")


def judge_statements(prefix, ranges, least, no_test, all_titles):
    """Prints the matrix of numbered statements. @return the number of mistakes, and a summary"""
    known = {number for first, last in ranges for number in range(first, last + 1)}
    found = {}
    wrong = 0
    for path, title in all_titles:
        for number in ids(prefix, title):
            found.setdefault(number, []).append((path, title))
    for number in sorted(known | set(found) | set(no_test)):
        for path, title in found.get(number, []):
            print(f"{prefix}-{number:03}  {path}: {title}")
        if number in no_test:
            print(f"{prefix}-{number:03}  no test: {no_test[number]}")
        if number not in known:
            print(f"{prefix}-{number:03}  WRONG: no such statement")
            wrong += 1
        elif (number in found) == (number in no_test):
            print(f"{prefix}-{number:03}  WRONG: {'a test and a reason for none' if number in found else 'neither a test nor a reason'}")
            wrong += 1
    tested_ids = known & set(found)
    return (wrong + (len(tested_ids) < least),
            f"{prefix}: {len(tested_ids)} of {len(known)} requirements have tests, at least {least} must; "
            f"{len(no_test)} have a reason for none")


tested = [(path.relative_to(TESTS), title) for path in sorted(TESTS.rglob("*")) if path.suffix in (".c", ".sh", ".py")
          for title in titles(path)]
results = [judge(*product, tested) for product in PRODUCTS] + [
    judge_statements("DRV", DRIVE_RANGES, DRIVE_TESTED, DRIVE_NO_TEST, tested),
    judge_statements("SOE", SOE_RANGES, SOE_TESTED, SOE_NO_TEST, tested)]
for _, summary in results:
    print(summary)
sys.exit(1 if any(wrong for wrong, _ in results) else 0)
