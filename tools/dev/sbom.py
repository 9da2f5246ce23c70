#!/usr/bin/env python3
"""Writes the bill of materials of built packages as SPDX 2.3 JSON.  usage: sbom.py ROOT BUILD SOEM_LICENCE PACKAGE... >FILE

PACKAGE... are the files to describe, with their SHA-256. BUILD is the folder of the build, whose `ectwin` and `ectwin-conform`
determine the shared libraries of a Debian package, with dpkg's versions; a wheel contains the list of its libraries
(tools/dev/wheel.py), with their licences. The date is that of $SOURCE_DATE_EPOCH, or now; equal packages result in an equal file.
"""
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import zipfile

NONE = "NOASSERTION"
SYSTEM = {"libc6", "libgcc-s1", "libstdc++6"}  # part of every Debian, and not listed


def said_by(*words):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout


def owner(path):
    """The Debian package of an installed file, whose path dpkg knows with /usr or without; empty without one."""
    real = os.path.realpath(path)
    for place in (real, "/usr" + real, real.replace("/usr/", "/", 1)):
        name = said_by("dpkg-query", "-S", place).split(":")[0]
        if name:
            return name
    return ""


def version_of(package_name):
    return said_by("dpkg-query", "-W", "-f", "${Version}\n", package_name).split("\n")[0]


def libraries(build):
    """(package, version) of the shared libraries that the programs link themselves."""
    found = set()
    for program in ("ectwin", "ectwin-conform"):
        needed = re.findall(r"NEEDED +(\S+)", said_by("objdump", "-p", str(build / program)))
        paths = dict(re.findall(r"(\S+) => (\S+)", said_by("ldd", str(build / program))))
        for name in (owner(paths[name]) for name in needed if name in paths):
            if name and name not in SYSTEM:
                found.add((name, version_of(name)))
    return sorted(found)


def spdx_id(name):
    return re.sub(r"[^A-Za-z0-9.-]", "-", name)


def package(name, version, licence, **more):
    entry = {"SPDXID": "SPDXRef-" + spdx_id(name), "name": name, "versionInfo": version, "downloadLocation": NONE,
             "filesAnalyzed": False, "licenseConcluded": licence, "licenseDeclared": licence, "copyrightText": NONE}
    return {**entry, **more}


def relations(one, kind, others):
    return [{"spdxElementId": one["SPDXID"], "relationshipType": kind, "relatedSpdxElement": p["SPDXID"]} for p in others]


def soem_text(licence):
    return {"licenseId": "LicenseRef-SOEM", "name": "GPL-2.0-only with the exception of SOEM",
            "extractedText": licence.read_text() if licence.is_file() else "SOEM was not linked."}


def document(version, digest, packages, related, texts):
    when = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH") or time.time()), datetime.timezone.utc)
    described = [p for p in packages if p.get("packageFileName")] or packages[:1]
    related = relations({"SPDXID": "SPDXRef-DOCUMENT"}, "DESCRIBES", described) + related
    return {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"ectwin-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/ectwin-{version}-{digest}",
        "creationInfo": {"created": f"{when:%Y-%m-%dT%H:%M:%SZ}", "creators": ["Tool: ectwin-sbom.py"]},
        "packages": packages, "relationships": related, "hasExtractedLicensingInfos": texts}


def of_wheel(version, bundled, licences, soem_licence):
    """The bill inside a wheel. bundled: (member, Debian package, version, SHA-256); licences: {package: text}."""
    own, soem = package("ectwin", version, "MIT"), package("SOEM", "1.4.0", "LicenseRef-SOEM")
    carried = [package(pathlib.PurePath(member).name, number, "LicenseRef-" + spdx_id(name), supplier="Organization: Debian",
                       sourceInfo=f"file of the Debian package {name}, changed by patchelf",
                       checksums=[{"algorithm": "SHA256", "checksumValue": digest}])
               for member, name, number, digest in bundled]
    texts = [{"licenseId": "LicenseRef-" + spdx_id(name), "name": f"copyright file of the Debian package {name}", "extractedText": text}
             for name, text in sorted(licences.items())]
    digest = hashlib.sha256("".join(d for _, _, _, d in bundled).encode()).hexdigest()
    related = relations(own, "STATIC_LINK", [soem]) + relations(own, "CONTAINS", carried)
    return document(version, digest, [own, soem, *carried], related, [soem_text(soem_licence), *texts])


def carried_by(wheel):
    """(packages, texts) of the libraries in a wheel, by its own bill."""
    with zipfile.ZipFile(wheel) as archive:
        name = [name for name in archive.namelist() if name.endswith(".dist-info/sboms/ectwin.spdx.json")]
        bill = json.loads(archive.read(name[0])) if name else {"packages": [], "hasExtractedLicensingInfos": []}
    return ([p for p in bill["packages"] if p["name"] not in ("ectwin", "SOEM")],
            [t for t in bill["hasExtractedLicensingInfos"] if t["licenseId"] != "LicenseRef-SOEM"])


def of_packages(root, build, soem_licence, files):
    """The bill of materials of the packages."""
    version = re.search(r"project\(ectwin VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text())[1]
    linked = [package("ectwin", version, "MIT"), package("SOEM", "1.4.0", "LicenseRef-SOEM")]
    needed = [package(name, number, NONE, supplier="Organization: Debian") for name, number in libraries(build)]
    built, related, more, texts = [], [], [], [soem_text(soem_licence)]
    for path in files:
        programs = path.suffix == ".whl" or path.name.startswith("ectwin_")
        one = package(path.name, version, "MIT AND LicenseRef-SOEM" if programs else "MIT", packageFileName=path.name,
                      checksums=[{"algorithm": "SHA256", "checksumValue": hashlib.sha256(path.read_bytes()).hexdigest()}])
        built.append(one)
        related += relations(one, "CONTAINS", linked[:1]) + relations(one, "STATIC_LINK", linked[1:] if programs else [])
        if path.suffix == ".whl":
            carried, licences = carried_by(path)
            related += relations(one, "CONTAINS", carried)
            more, texts = more + carried, texts + licences
        elif path.suffix == ".deb":
            related += relations(one, "DYNAMIC_LINK", needed)
    digest = hashlib.sha256("".join(p["checksums"][0]["checksumValue"] for p in built).encode()).hexdigest()
    return document(version, digest, built + linked + needed + more, related, texts)


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    root, build, licence, *files = map(pathlib.Path, sys.argv[1:])
    json.dump(of_packages(root, build, licence, sorted(files)), sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
