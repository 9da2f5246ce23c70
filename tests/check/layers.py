#!/usr/bin/env python3
"""Refuses an #include that the table "Permitted includes" of docs/DESIGN.md does not allow.  usage: layers.py ROOT

A row of the table names rooms and the rooms whose headers each may include beside its own. `X` in a row stands for any one
folder: a file of devices/fzm1 falls under devices/X and may not include devices/eclink. A room covers the folders below it
unless a longer row names them. Every room of src/, programs/ and examples/ needs a row, and every row a room. The listing at the
head of the page names every room, except one of X, and no folder that does not exist.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
EVERYTHING = "every room of src"
FOREIGN = {"ethercat.h"}  # SOEM's, by its own convention in quotes


def read_table(page):
    """Room -> the rooms it may include."""
    section = page.read_text().split("## Permitted includes", 1)[1]
    table = {}
    for left, right in re.findall(r"^\| ([^|]+?) \| ([^|]+?) \|$", section, re.M):
        if left == "room" or set(left) <= set("-"):
            continue
        allowed = [] if right == "nothing of this tree" else [word.strip() for word in re.split(r"[,;]", right)]
        for room in left.split(","):
            table[room.strip()] = allowed
    return table


def row_of(folder, table):
    """The longest row that covers a folder, or None."""
    parts = folder.split("/")
    for length in range(len(parts), 0, -1):
        name = "/".join(parts[:length])
        if name in table:
            return name
        pattern = "/".join(parts[:length - 1] + ["X"])
        if length > 1 and pattern in table:
            return pattern
    return None


def room_name(path, root):
    """The room of a file: without src/ for the library, with its first folder elsewhere."""
    folder = str(path.parent.relative_to(root))
    return folder.removeprefix("src/") if folder != "src" else ""


def find(header, includer, root):
    """The file of an #include: in a room of src, in the folder of the including file, or in its program."""
    program = [p for p in includer.parents if p.parent.name in ("programs", "examples", "src") or p.name == "firmware"]
    places = [includer.parent, root / "src", root / "src/soes", *program, root / "examples/master", root / "firmware"]
    return next((place / header for place in places if (place / header).is_file()), None)


def own_room(folder, row):
    """The folder that counts as a file's own room: X replaced by the folder's own part."""
    return "/".join(folder.split("/")[:len(row.split("/"))])


def may_include(folder, row, target, allowed):
    if folder == target or (own_room(folder, row) == own_room(target, row) and row.count("/") == own_room(target, row).count("/")
                            and row not in ("bus",)):
        return True
    if EVERYTHING in allowed and not target.startswith(("programs/", "examples/", "firmware")):
        return True
    return any(target == a or target.startswith(a + "/") for a in allowed)


def listed(page):
    """The folders that the listing names, below the root; folders that a comment names count for the folder of their line."""
    found, above = {}, []
    for line in page.read_text().split("```")[1].strip().splitlines():
        match = re.match(r"( *)([\w-]+)/ ", line + " ")
        if match:
            above = above[:len(match[1]) // 2] + [match[2]]
        found["/".join(above)] = found.get("/".join(above), "") + line
    return found


def unlisted(root, rooms, table):
    """A line for each folder that the listing lacks or wrongly names."""
    names = listed(root / "docs/DESIGN.md")
    wrong = [f"docs/DESIGN.md: the listing names {name}, which is no folder" for name in names if not (root / name).is_dir()]
    for folder in sorted(rooms):
        above, _, name = folder.rpartition("/")
        is_one_of_x = (row_of(folder.removeprefix("src/"), table) or "").endswith("/X") and above == "src/devices"
        if folder not in names and not is_one_of_x and not re.search(rf"\b{name}\b", names.get(above, "")):
            wrong.append(f"docs/DESIGN.md: the listing does not name {folder}")
    return wrong


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    table = read_table(root / "docs/DESIGN.md")
    folders = {str(p.parent.relative_to(root)) for p in (root / "src").rglob("*.[ch]")}
    folders |= {str(p.relative_to(root)) for top in ("programs", "examples") for p in (root / top).iterdir() if p.is_dir()}
    wrong, seen = unlisted(root, folders, table), 0
    wrong += [f"docs/DESIGN.md: the row {row} is of no room" for row in table
              if not any((root / top / row.removesuffix("/X")).is_dir() for top in ("", "src"))]
    files = [p for top in ("src", "programs", "examples", "firmware") for p in sorted((root / top).rglob("*.[ch]"))]
    for path in files:
        folder = room_name(path, root)
        row = row_of(folder, table)
        if row is None:
            wrong.append(f"{path.relative_to(root)}: the room {folder} has no row in docs/DESIGN.md")
            continue
        for header in INCLUDE.findall(path.read_text()):
            found = find(header, path, root)
            if found is None:
                if header not in FOREIGN and not folder.startswith(("examples/", "firmware", "soes", "ports/soes_hal")):  # headers of the application
                    wrong.append(f"{path.relative_to(root)}: \"{header}\" is a header of no room")
                continue
            seen += 1
            target = room_name(found, root)
            if not may_include(folder, row, target, table[row]):
                wrong.append(f"{path.relative_to(root)} includes \"{header}\": {row} may include {', '.join(table[row]) or 'nothing of this tree'}")
    if seen < 500:
        wrong.append(f"only {seen} includes were found: the check does not see the sources")
    print("\n".join(wrong))
    return 1 if wrong else 0


sys.exit(main())
