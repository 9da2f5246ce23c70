#!/usr/bin/env python3
"""Refuses circles among the files of a room: each file knows only files below it.  usage: order.py BUILD [--graph]

A file knows another when its object uses a symbol that the other's defines, or when it includes the other's header. Read from
the objects of a build; --graph prints each room from the lowest file to the highest, with what each knows.
"""
import json
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOMS = [ROOT / top for top in ("src", "examples")]


def objects(build):
    """Source file, relative to the root -> object file."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        if any(room in source.parents for room in ROOMS):
            command = shlex.split(entry["command"])
            found[source.relative_to(ROOT)] = pathlib.Path(entry["directory"]) / command[command.index("-o") + 1]
    return found


def symbols(path):
    """What an object defines and what it uses of others."""
    defines, uses = set(), set()
    for line in subprocess.run(["nm", path], check=True, capture_output=True, text=True).stdout.splitlines():
        kind, name = line.split()[-2:]
        if kind == "U":
            uses.add(name)
        elif kind.isupper():
            defines.add(name)
    return defines, uses


def included(path, room):
    """Files of the room whose header a file includes."""
    prefix = f"(?:{room.removeprefix('src/')}/)?"  # files of a program name each other without a room
    return set(re.findall(rf'^\s*#\s*include\s+"{prefix}(\w+)\.h"', path.read_text(), re.MULTILINE))


def knows(room, files):
    """File (stem) -> {other file: a symbol or header that shows it}."""
    table = {source.stem: symbols(path) for source, path in files.items()}
    graph = {name: {} for name in table}
    for name, (_, uses) in table.items():
        for other, (defines, _) in table.items():
            common = uses & defines
            if other != name and common:
                graph[name][other] = sorted(common)[0]
        for file in (ROOT / room / f"{name}.c", ROOT / room / f"{name}.h"):
            for other in included(file, room) if file.exists() else ():
                if other != name and other in table:
                    graph[name].setdefault(other, f"{other}.h")
    return graph


def layers(graph):
    """Files from the lowest up; what is left over stands in circles or above them."""
    order, left = [], dict(graph)
    while True:
        ready = sorted(name for name in left if all(other in order for other in left[name]))
        if not ready:
            return order, left
        for name in ready:
            order.append(name)
            del left[name]


def circle(left):
    """One circle among files that wait for each other."""
    path, name = [], next(iter(left))
    while name not in path:
        path.append(name)
        name = next(other for other in left[name] if other in left)
    return path[path.index(name):] + [name]


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    rooms = {}
    for source, path in objects(build).items():
        rooms.setdefault(str(source.parent), {})[source] = path
    failed = len(rooms) < 5
    if failed:
        print(f"{build}: hardly any object of src/; build first")
    for room, files in sorted(rooms.items()):
        graph = knows(room, files)
        order, left = layers(graph)
        if "--graph" in sys.argv:
            print(f"{room}:")
            for name in order + sorted(left):
                print(f"  {name:14} {' '.join(sorted(graph[name]))}")
        if left:
            failed = True
            path = circle(left)
            steps = [f"{a}.c -> {b} ({graph[a][b]})" for a, b in zip(path, path[1:])]
            print(f"{room}: a circle: {', '.join(steps)}")
    return 1 if failed else 0


sys.exit(main())
