#!/usr/bin/env python3
"""Code and links of the pages lead somewhere.  usage: pages.py ROOT

A block that begins with ```LANGUAGE FILE is the code of FILE, line by line; a line of … in it stands for any number of omitted
lines. A link to a file or to a heading of this tree has a target. Every page of docs/ is reached from README.md.
"""
import pathlib
import re
import sys


def pieces(block):
    """The runs of lines between the lines of …."""
    found, piece = [], []
    for line in block.splitlines():
        if line.strip() == "…":
            found.append(piece)
            piece = []
        else:
            piece.append(line)
    return [p for p in found + [piece] if p]


def missing(block, lines):
    """The first piece of a block that is not in the lines, in their order; None: all are."""
    at = 0
    for piece in pieces(block):
        while at + len(piece) <= len(lines) and lines[at:at + len(piece)] != piece:
            at += 1
        if lines[at:at + len(piece)] != piece:
            return piece
        at += len(piece)
    return None


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^ *```.*?^ *```$", "", text, flags=re.M | re.S))


def anchors(page):
    """The anchors of a page's headings, as the usual forges make them."""
    found = set()
    for heading in re.findall(r"^#+ (.*)$", re.sub(r"^ *```.*?^ *```$", "", page.read_text(), flags=re.M | re.S), re.M):
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
        name = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        number = 0
        while (name if number == 0 else f"{name}-{number}") in found:
            number += 1
        found.add(name if number == 0 else f"{name}-{number}")
    return found


def links(page):
    """(target, file that it means, anchor) of each link into this tree."""
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text())):
        if not re.match(r"[a-z]+:", target):
            name, _, anchor = target.partition("#")
            yield target, (page.parent / name).resolve() if name else page, anchor


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = sorted([*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("firmware/**/*.md"), *root.glob("tests/**/*.md")])
    wrong, blocks, reached, queue = [], 0, set(), [root / "README.md"]
    for page in pages:
        for name, block in re.findall(r"^```\w+ (\S+)\n(.*?)^```$", page.read_text(), re.M | re.S):
            blocks += 1
            piece = missing(block, (root / name).read_text().splitlines())
            if piece:
                wrong.append(f"{page.relative_to(root)}: {name} does not contain:\n  " + "\n  ".join(piece))
        for target, path, anchor in links(page):
            if not path.exists():
                wrong.append(f"{page.relative_to(root)}: the link {target} leads nowhere")
            elif anchor and path.suffix == ".md" and anchor not in anchors(path):
                wrong.append(f"{page.relative_to(root)}: {target}: no heading has this anchor")
    while queue:
        page = queue.pop()
        if page not in reached:
            reached.add(page)
            queue += [path for _, path, _ in links(page) if path.suffix == ".md" and path.exists()]
    wrong += [f"{page.relative_to(root)}: no page reached from README.md links it" for page in pages if page not in reached]
    if blocks == 0:
        wrong.append("no page has code of a file")
    print("\n".join(f"FAILED {line}" for line in wrong))
    return 1 if wrong else 0


sys.exit(main())
