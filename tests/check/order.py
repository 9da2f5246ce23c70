#!/usr/bin/env python3
"""Refuses loops among the files of a room, and among the folders of a program.  usage: order.py BUILD [--graph]

A file refers to another file if its object uses a symbol of the other's object, or if it includes the other's header. References
between the folders of a program follow from their files; its own folder, which holds the main function, is one of them. The folders
of src have a table of their own (layers.py). Read from the objects of a build; --graph prints each room, and each program, from the
lowest to the highest, with the references of each.

The comment of a room's internal.h lists all files of the room from the lowest to the highest: a file refers only to files before it.
"""
import json
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("programs", "examples")
ROOMS = [ROOT / top for top in ("src", *PROGRAMS)]


def objects(build):
    """Source file, relative to the root -> object file."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        if any(room in source.parents for room in ROOMS):
            command = shlex.split(entry["command"])
            made = command[command.index("-o") + 1]
            if source.relative_to(ROOT) not in found or not made.startswith("tests/"):  # a test may give functions other names
                found[source.relative_to(ROOT)] = pathlib.Path(entry["directory"]) / made
    return found


def symbols(path):
    """The symbols that an object defines, and those that it uses of others."""
    defines, uses = set(), set()
    for line in subprocess.run(["nm", path], check=True, capture_output=True, text=True).stdout.splitlines():
        kind, name = line.split()[-2:]
        if kind == "U":
            uses.add(name)
        elif kind.isupper():
            defines.add(name)
    return defines, uses


def program_of(room):
    """programs/ectwin-conform of programs/ectwin-conform/cases; None for a room of src."""
    parts = pathlib.Path(room).parts
    return "/".join(parts[:2]) if parts[0] in PROGRAMS else None


def headers(path):
    return re.findall(r'^\s*#\s*include\s+"([\w/-]+)\.h"', path.read_text(), re.MULTILINE)


def included(path, room):
    """Files of the room whose header a file includes."""
    program = program_of(room)  # a program's folder is on its include path
    prefix = str(pathlib.Path(room).relative_to(program or "src")) + "/"
    return {name.removeprefix(prefix) for name in headers(path) if "/" not in name.removeprefix(prefix)}


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


def folders_know(program, rooms):
    """Folder -> {other folder: a symbol or header that shows it}, for the folders of one program."""
    folders = sorted(str(path.relative_to(ROOT)) for path in [ROOT / program, *(ROOT / program).rglob("*")] if path.is_dir())
    tables = {folder: [symbols(path) for path in rooms.get(folder, {}).values()] for folder in folders}
    graph = {folder: {} for folder in folders}
    for folder, other in ((a, b) for a in folders for b in folders if a != b):
        uses = {name for _, used in tables[folder] for name in used}
        common = uses & {name for defined, _ in tables[other] for name in defined}
        if common:
            graph[folder][other] = sorted(common)[0]
        for path in sorted((ROOT / folder).glob("*.[ch]")):
            for name in headers(path):
                named = (ROOT / program / f"{name}.h") if not (path.parent / f"{name}.h").exists() else path
                if named.exists() and named.parent == ROOT / other:
                    graph[folder].setdefault(other, f"{path.name} includes {name}.h")
    return graph


def layers(graph):
    """Files from the lowest up; the rest is in loops or above them."""
    order, left = [], dict(graph)
    while True:
        ready = sorted(name for name in left if all(other in order for other in left[name]))
        if not ready:
            return order, left
        for name in ready:
            order.append(name)
            del left[name]


def loop(left):
    """One loop among files that wait for each other."""
    path, name = [], next(iter(left))
    while name not in path:
        path.append(name)
        name = next(other for other in left[name] if other in left)
    return path[path.index(name):] + [name]


def listed(header):
    """The files (stems) that the first comment of an internal.h lists; None: no list."""
    comment = header.read_text().partition("@file")[2].partition("*/")[0]
    before, _, names = comment.partition("rom the lowest to the highest")
    return re.findall(r"\b(\w+)\.c\b", names) if before != comment else None


def mistakes_of_list(names, graph):
    """Differences between the list of an internal.h and the files of its room."""
    if names is None:
        return ["no list of the files from the lowest to the highest"]
    found = [f"{name}.c is not in the list" for name in sorted(graph.keys() - set(names))]
    found += [f"{name}.c is not in the room" for name in sorted(set(names) - graph.keys())]
    found += [f"{name}.c is in the list twice" for name in sorted(set(names)) if names.count(name) > 1]
    place = {name: number for number, name in enumerate(names)}
    for name, others in sorted(graph.items()):
        found += [f"{name}.c uses {other}.c ({shown}), which the list has behind it" for other, shown in sorted(others.items())
                  if place.get(other, -1) > place.get(name, len(names))]
    return found


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    rooms = {}
    for source, path in objects(build).items():
        rooms.setdefault(str(source.parent), {})[source] = path
    failed = len(rooms) < 5
    if failed:
        print(f"{build}: hardly any object of src/; build first")
    graphs = {room: knows(room, files) for room, files in rooms.items()}
    for program in {program_of(room) for room in rooms} - {None}:
        graphs[f"the folders of {program}"] = folders_know(program, rooms)
    for room, graph in sorted(graphs.items()):
        order, left = layers(graph)
        if "--graph" in sys.argv:
            print(f"{room}:")
            for name in order + sorted(left):
                print(f"  {name:14} {' '.join(sorted(graph[name]))}")
        if left:
            failed = True
            path = loop(left)
            steps = [f"{a} -> {b} ({graph[a][b]})" for a, b in zip(path, path[1:])]
            print(f"{room}: a loop: {', '.join(steps)}")
        header = ROOT / room / "internal.h"
        for mistake in mistakes_of_list(listed(header), graph) if header.exists() else ():
            failed = True
            print(f"{room}/internal.h: {mistake}")
    return 1 if failed else 0


sys.exit(main())
