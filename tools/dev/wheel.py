#!/usr/bin/env python3
"""Completes a wheel that auditwheel has repaired.  usage: wheel.py WHEEL SOEM_LICENCE PROGRAM...

PROGRAM... are the programs of the build, before the repair, whose libraries the wheel contains. The licence of a library is that of
its Debian package:

    DIST-INFO/licenses/PACKAGE/copyright       and licenses/common/NAME, each referenced text of /usr/share/common-licenses
    DIST-INFO/sboms/ectwin.spdx.json           the libraries with package, version, SHA-256 and licence (SPDX 2.3)

Equal contents result in equal bytes: members are sorted, of the date $SOURCE_DATE_EPOCH (or now), modes 644 and 755.
"""
import base64
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import zipfile

import sbom

COMMON = pathlib.Path("/usr/share/common-licenses")
DOCUMENTS = pathlib.Path("/usr/share/doc")


def needed(programs):
    """The files of all libraries that the programs load."""
    found = set()
    for program in programs:
        listed = subprocess.run(["ldd", program], stdout=subprocess.PIPE, text=True, check=True).stdout
        found |= {pathlib.Path(path).resolve() for path in re.findall(r"=> (/\S+)", listed)}
    return sorted(found)


def origin(member, content_of):
    """The library that auditwheel has copied to MEMBER: NAME-HASH.REST, REST from the first dot on, HASH of the original file."""
    name, digest, rest = re.fullmatch(r"(.+)-([0-9a-f]{8})(\..+)", pathlib.PurePath(member).name).groups()
    for path, content in content_of.items():
        if path.name == name + rest and hashlib.sha256(content).hexdigest().startswith(digest):
            return path
    raise SystemExit(f"wheel.py: {member} is none of the libraries that the programs load: name the programs of the same build")


def owner(path):
    """(package, version) of an installed file."""
    name = sbom.owner(path)
    if not name:
        raise SystemExit(f"wheel.py: no Debian package has {path}: build on Debian or Ubuntu, with the libraries of their packages")
    return name, sbom.version_of(name)


def texts_of(package):
    """{name in the archive: text} of a package's licence."""
    licence = (DOCUMENTS / package / "copyright").read_bytes()
    texts = {f"{package}/copyright": licence}
    for name in set(re.findall(rb"/usr/share/common-licenses/([A-Za-z]+(?:-[0-9.]*[0-9])?)", licence)):
        texts[f"common/{name.decode()}"] = (COMMON / name.decode()).read_bytes()
    return texts


def record(name, members):
    """RECORD, with the hash of each other member."""
    lines = []
    for member, (content, _) in sorted(members.items()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        lines.append(f"{member},sha256={digest},{len(content)}\n")
    return "".join([*lines, f"{name},,\n"]).encode()


def write(path, members, when):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, (content, executable) in sorted(members.items()):
            entry = zipfile.ZipInfo(name, time.gmtime(max(when, 315532800))[:6])  # not before 1980
            entry.create_system = 3
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if executable else 0o100644) << 16
            archive.writestr(entry, content)


def complete(members, soem_licence, programs):
    """Adds licences and bill of materials to {name: (content, executable)}."""
    info = next(name for name in members if name.endswith(".dist-info/METADATA"))[: -len("/METADATA")]
    for name in [name for name in members if name.startswith(f"{info}/sboms/")]:
        del members[name]  # that of auditwheel, which lacks libraries outside /usr
    content_of = {path: path.read_bytes() for path in needed(programs)}
    texts, libraries = {}, []
    for member in sorted(name for name in members if re.match(r"\w+\.libs/.+", name)):
        package, version = owner(origin(member, content_of))
        texts.update(texts_of(package))
        libraries.append((member, package, version, hashlib.sha256(members[member][0]).hexdigest()))
    licences = {package: texts[f"{package}/copyright"].decode() for _, package, _, _ in libraries}
    bill = sbom.of_wheel(info.split("-")[1].split(".dist")[0], libraries, licences, soem_licence)
    members[f"{info}/sboms/ectwin.spdx.json"] = ((json.dumps(bill, indent=1) + "\n").encode(), False)
    head, separator, body = members[f"{info}/METADATA"][0].partition(b"\n\n")
    for name, text in sorted(texts.items()):
        members[f"{info}/licenses/{name}"] = (text, False)
        head += f"\nLicense-File: {name}".encode()
    members[f"{info}/METADATA"] = (head + separator + body, False)
    members.pop(f"{info}/RECORD", None)
    members[f"{info}/RECORD"] = (record(f"{info}/RECORD", members), False)


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    wheel, soem_licence = map(pathlib.Path, sys.argv[1:3])
    with zipfile.ZipFile(wheel) as archive:
        members = {entry.filename: (archive.read(entry), bool(entry.external_attr >> 16 & 0o111))
                   for entry in archive.infolist() if not entry.is_dir()}
    complete(members, soem_licence, sys.argv[3:])
    write(wheel, members, int(os.environ.get("SOURCE_DATE_EPOCH") or time.time()))


if __name__ == "__main__":
    main()
