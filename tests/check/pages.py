#!/usr/bin/env python3
"""Code on a page is the code of a file: a block that begins with ```LANGUAGE FILE stands in FILE, line by line.

usage: pages.py ROOT        A line of … in a block stands for any number of lines that are left out.
"""
import pathlib
import re
import sys


def pieces(block):
    """What stands between the lines that say that something is left out."""
    found, piece = [], []
    for line in block.splitlines():
        if line.strip() == "…":
            found.append(piece)
            piece = []
        else:
            piece.append(line)
    return [p for p in found + [piece] if p]


def missing(block, lines):
    """The first piece of a block that does not stand in the lines, in their order; None: all do."""
    at = 0
    for piece in pieces(block):
        while at + len(piece) <= len(lines) and lines[at:at + len(piece)] != piece:
            at += 1
        if lines[at:at + len(piece)] != piece:
            return piece
        at += len(piece)
    return None


def main():
    root = pathlib.Path(sys.argv[1])
    blocks, failed = 0, False
    for page in sorted([*root.glob("*.md"), *root.glob("docs/**/*.md")]):
        for name, block in re.findall(r"^```\w+ (\S+)\n(.*?)^```$", page.read_text(), re.M | re.S):
            blocks += 1
            piece = missing(block, (root / name).read_text().splitlines())
            if piece:
                failed = True
                print(f"FAILED {page.relative_to(root)}: this is not what stands in {name}:\n  " + "\n  ".join(piece))
    if blocks == 0:
        print("FAILED there is no page with code of a file")
    return failed or blocks == 0


sys.exit(main())
