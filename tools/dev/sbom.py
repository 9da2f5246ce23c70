#!/usr/bin/env python3
"""Writes the bill of materials of built packages as SPDX 2.3 JSON.  usage: sbom.py ROOT BUILD SOEM_LICENCE PACKAGE... >FILE

PACKAGE... are the files to describe, with their SHA-256; BUILD is the folder of the build, whose `ectwin` and `ectwin-conform` give
the shared libraries. Versions of those are dpkg's. The date is that of $SOURCE_DATE_EPOCH, or now; equal packages give an equal file.
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

NONE = "NOASSERTION"
SYSTEM = {"libc6", "libgcc-s1", "libstdc++6"}  # of every Debian; not ours to list


def said_by(*words):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout


def libraries(build):
    """(package, version) of the shared libraries that the programs link themselves."""
    found = set()
    for program in ("ectwin", "ectwin-conform"):
        needed = re.findall(r"NEEDED +(\S+)", said_by("objdump", "-p", str(build / program)))
        paths = dict(re.findall(r"(\S+) => (\S+)", said_by("ldd", str(build / program))))
        for path in (paths[name] for name in needed if name in paths):
            owner = ""
            for place in (os.path.realpath(path), "/usr" + os.path.realpath(path), os.path.realpath(path).replace("/usr/", "/", 1)):
                owner = owner or said_by("dpkg-query", "-S", place).split(":")[0]
            if owner and owner not in SYSTEM:
                found.add((owner, said_by("dpkg-query", "-W", "-f", "${Version}", owner)))
    return sorted(found)


def package(name, version, licence, **more):
    entry = {"SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name), "name": name, "versionInfo": version, "downloadLocation": NONE,
             "filesAnalyzed": False, "licenseConcluded": licence, "licenseDeclared": licence, "copyrightText": NONE}
    return {**entry, **more}


def document(root, build, soem_licence, files):
    version = re.search(r"project\(ectwin VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text())[1]
    when = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH") or time.time()), datetime.timezone.utc)
    built = [package(path.name, version, "MIT AND LicenseRef-SOEM", packageFileName=path.name,
                     checksums=[{"algorithm": "SHA256", "checksumValue": hashlib.sha256(path.read_bytes()).hexdigest()}])
             for path in files]
    linked = [package("ectwin", version, "MIT"), package("SOEM", "1.4.0", "LicenseRef-SOEM")]
    needed = [package(name, number, NONE, supplier="Organization: Debian") for name, number in libraries(build)]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": p["SPDXID"]} for p in built]
    for one in built:
        for kind, others in (("CONTAINS", linked[:1]), ("STATIC_LINK", linked[1:]), ("DYNAMIC_LINK", needed)):
            relations += [{"spdxElementId": one["SPDXID"], "relationshipType": kind, "relatedSpdxElement": p["SPDXID"]} for p in others]
    digest = hashlib.sha256("".join(p["checksums"][0]["checksumValue"] for p in built).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"ectwin-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/ectwin-{version}-{digest}",
        "creationInfo": {"created": f"{when:%Y-%m-%dT%H:%M:%SZ}", "creators": ["Tool: ectwin-sbom.py"]},
        "packages": built + linked + needed, "relationships": relations,
        "hasExtractedLicensingInfos": [{
            "licenseId": "LicenseRef-SOEM", "name": "GPL-2.0-only with the exception of SOEM",
            "extractedText": soem_licence.read_text() if soem_licence.is_file() else "SOEM was not linked."}],
    }


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    root, build, licence, *files = map(pathlib.Path, sys.argv[1:])
    json.dump(document(root, build, licence, sorted(files)), sys.stdout, indent=1)
    print()


main()
