#!/usr/bin/env python3
"""Prints the shell lines of the container file, the GitHub action or the GitLab jobs.  usage: ci_lines.py FILE

Lines of a container file become commands for sudo: COPY as cp, RUN by sh. YAML files: the lines of `run: COMMAND`, the blocks of
`run: |` and the lists of `before_script:` and `script:` are printed in their order.
"""
import pathlib
import re
import shlex
import sys


def container(lines):
    for line in lines:
        word, _, rest = line.partition(" ")
        if word == "COPY":
            yield f"sudo cp {rest}"
        elif word == "RUN":
            yield f"sudo sh -ec {shlex.quote(rest)}"


def yaml(lines):
    """Blocks and lists end with their indentation."""
    inside, depth = None, 0
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if inside and line.strip() and indent <= depth:
            inside = None
        if match := re.match(r" *- run: ([^|].*)$", line):
            yield match[1]
        elif match := re.match(r"( *)(run: \||before_script:|script:)$", line):
            inside, depth = match[2], len(match[1])
        elif inside and line.strip():
            yield line.strip() if inside.startswith("run") else re.sub(r"^\s*- ", "", line)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path = pathlib.Path(sys.argv[1])
    lines = [line for line in path.read_text().splitlines() if not line.lstrip().startswith("#")]
    found = list((yaml if path.suffix == ".yml" else container)(lines))
    if not found:
        sys.exit(f"ci_lines.py: {path} has no lines to run")
    print("\n".join(found))


main()
