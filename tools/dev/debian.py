#!/usr/bin/env python3
"""Writes the standard files of the Debian packages: copyright, changelogs.  usage: debian.py ROOT OUT MAINTAINER SOEM_LICENCE

    copyright             of packaging/debian/copyright.in, LICENSE and SOEM_LICENCE
    changelog.gz          CHANGELOG.md
    changelog.Debian.gz   an entry for its newest version
    dist-info/            METADATA and entry_points.txt of the Python module, for pytest to find its plugin

The entry's date is that of $SOURCE_DATE_EPOCH, or now.
"""
import email.utils
import gzip
import os
import pathlib
import re
import sys
import time


def field(text):
    """Text as the continuation lines of a field."""
    return "\n".join(" " + (line.rstrip() or ".") for line in text.strip().splitlines())


def changelog(changes, maintainer, when):
    version = re.search(r"^## (\d+\.\d+\.\d+)", changes, re.M)[1]
    return (f"ectwin ({version}-1) unstable; urgency=medium\n\n  * Version {version}; changelog.gz lists its changes.\n\n"
            f" -- {maintainer}  {email.utils.formatdate(when)}\n")


def distribution(project, version):
    """Metadata of the Python module, from pyproject.toml: {name of file: content}."""
    plugins = re.search(r"^\[project\.entry-points\.(\w+)\]\n((?:\w+ = .*\n)+)", project, re.M)
    points = f"[{plugins[1]}]\n" + plugins[2].replace('"', "") if plugins else ""
    return {"METADATA": f"Metadata-Version: 2.1\nName: ectwin\nVersion: {version}\n", "INSTALLER": "debian\n", "entry_points.txt": points}


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    root, out, maintainer = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    out.mkdir(parents=True, exist_ok=True)
    when = int(os.environ.get("SOURCE_DATE_EPOCH") or time.time())
    changes = (root / "CHANGELOG.md").read_text()
    expat = re.sub(r"\A.*?(?=Permission)", "", (root / "LICENSE").read_text(), flags=re.S)
    soem = pathlib.Path(sys.argv[4])
    text = (root / "packaging/debian/copyright.in").read_text().replace("@EXPAT@", field(expat))
    text = text.replace("@SOEM@", field(soem.read_text() if soem.is_file() else "SOEM was not linked."))
    (out / "copyright").write_text(text)
    info = out / "dist-info"
    info.mkdir(exist_ok=True)
    version = re.search(r"^## (\d+\.\d+\.\d+)", changes, re.M)[1]
    for name, content in distribution((root / "pyproject.toml").read_text(), version).items():
        (info / name).write_text(content)
    for name, content in (("changelog", changes), ("changelog.Debian", changelog(changes, maintainer, when))):
        (out / f"{name}.gz").write_bytes(gzip.compress(content.encode(), 9, mtime=0))


main()
