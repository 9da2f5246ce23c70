#!/usr/bin/env python3
"""Each entry of tests/budget/equivalent is of a line that the source still has.  usage: equivalent.py ROOT"""
import pathlib
import sys


def stale(root):
    """The entries without a line: (number, file, line)."""
    found, name, lines = [], None, set()
    for number, entry in enumerate((root / "tests/budget/equivalent").read_text().splitlines(), 1):
        if entry.startswith(("src/", "programs/")):
            name = entry.split()[0]
            source = root / name
            lines = {line.strip() for line in source.read_text().splitlines()} if source.exists() else set()
        elif entry.startswith("  - ") and entry[4:] not in lines:
            found.append((number, name, entry[4:]))
    return found


def main():
    found = stale(pathlib.Path(sys.argv[1]))
    for number, name, line in found:
        print(f"tests/budget/equivalent:{number}: {name} has no such line; remove the entry: {line}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
