#!/usr/bin/env python3
"""The parts of packages do not depend on umask, locale or time zone, and a wheel carries the licence of each library in it.
usage: packages.py BUILD        Exit 77: this machine has no dpkg."""
import base64
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools/dev"
PLACES = [{"umask": 0o022, "TZ": "UTC", "LC_ALL": "C.UTF-8"}, {"umask": 0o077, "TZ": "Asia/Kathmandu", "LC_ALL": "C"}]
FAILED = []


def check(title, wanted, got):
    if wanted != got:
        FAILED.append(title)
        print(f"FAILED {title}\n  expected: {wanted}\n  got:      {got}")


def run(place, *words, stdout=None):
    env = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000", "PYTHONDONTWRITEBYTECODE": "1"}
    env.update({name: value for name, value in place.items() if name != "umask"})
    return subprocess.run([str(word) for word in words], env=env, umask=place["umask"], stdout=stdout, stderr=subprocess.PIPE, text=True,
                          check=False)


def libraries_of(program, names):
    """The files of those libraries that the program loads."""
    listed = subprocess.run(["ldd", program], stdout=subprocess.PIPE, text=True, check=True).stdout
    return [pathlib.Path(path).resolve() for name in names for path in re.findall(rf"{name}\S* => (\S+)", listed)]


def carried_name(path):
    """As auditwheel names a library: the hash is before the first dot, in libelf-0.188.so before the version."""
    name, rest = path.name.split(".", 1)
    return f"ectwin.libs/{name}-{hashlib.sha256(path.read_bytes()).hexdigest()[:8]}.{rest}"


def raw_wheel(file, members):
    """A wheel as auditwheel leaves it: no order, no fixed date, files of any mode."""
    members = {"ectwin/bin/ectwin": "program", **members, "ectwin-1.2.3.dist-info/RECORD": "",
               "ectwin-1.2.3.dist-info/METADATA": "Metadata-Version: 2.4\nName: ectwin\n\nText\n"}
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            entry = zipfile.ZipInfo(name, (2020, 2, 2, 2, 2, 2))
            entry.external_attr = (0o100700 if "/bin/" in name else 0o100600) << 16
            archive.writestr(entry, content)


def completed(place, folder, program, libraries):
    folder.mkdir()
    wheel = folder / "ectwin-1.2.3-py3-none-any.whl"
    raw_wheel(wheel, {carried_name(path): "patched" for path in libraries})
    (folder / "SOEM").write_text("Licence of SOEM\n")
    done = run(place, TOOLS / "wheel.py", wheel, folder / "SOEM", program)
    check("wheel.py", (0, ""), (done.returncode, done.stderr))
    return wheel


def judge_wheel(wheel):
    with zipfile.ZipFile(wheel) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
        modes = {entry.filename: oct(entry.external_attr >> 16) for entry in archive.infolist()}
    info = "ectwin-1.2.3.dist-info/"
    check("members are sorted", sorted(content), list(content))
    check("modes are fixed", {"0o100755"}, {mode for name, mode in modes.items() if "/bin/" in name})
    check("modes are fixed", {"0o100644"}, {mode for name, mode in modes.items() if "/bin/" not in name})
    for package in ("libcjson1", "libxml2"):
        text = pathlib.Path(f"/usr/share/doc/{package}/copyright").read_bytes()
        check(f"the licence of {package}", text, content.get(f"{info}licenses/{package}/copyright"))
    named = re.findall(r"^License-File: (.*)$", content[info + "METADATA"].decode(), re.M)
    there = sorted(name[len(info + "licenses/"):] for name in content if name.startswith(info + "licenses/"))
    check("METADATA names each licence", there, sorted(named))
    for name, hashed, size in (line.rsplit(",", 2) for line in content[info + "RECORD"].decode().splitlines()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content[name]).digest()).rstrip(b"=").decode()
        wanted = ("", "") if name.endswith("/RECORD") else (f"sha256={digest}", str(len(content[name])))
        check(f"RECORD, {name}", wanted, (hashed, size))
    check("RECORD names each member", len(content), len(content[info + "RECORD"].splitlines()))
    bill = json.loads(content[info + "sboms/ectwin.spdx.json"])
    texts = {text["licenseId"]: text["extractedText"] for text in bill["hasExtractedLicensingInfos"]}
    for package in bill["packages"][2:]:
        check(f"the bill has the licence of {package['name']}", True, len(texts.get(package["licenseDeclared"], "")) > 100)
    return {package["name"] for package in bill["packages"]}


def main():
    build = pathlib.Path(sys.argv[1])
    if not shutil.which("dpkg-query"):
        print("left out: no dpkg here")
        return 77
    program = build / "ectwin"
    libraries = libraries_of(program, ("libcjson", "libxml2", "libelf"))
    results = []
    with tempfile.TemporaryDirectory() as work:
        for number, place in enumerate(PLACES):
            folder = pathlib.Path(work, str(number))
            wheel = completed(place, folder, program, libraries)
            check("debian.py", 0, run(place, TOOLS / "debian.py", ROOT, folder / "debian", "A <a@b>", folder / "SOEM").returncode)
            bill = run(place, TOOLS / "sbom.py", ROOT, build, folder / "SOEM", wheel, stdout=subprocess.PIPE).stdout
            files = [wheel, *sorted(path for path in (folder / "debian").rglob("*") if path.is_file())]
            results.append({path.name: path.read_bytes() for path in files} | {"bill": bill})
        for name, content in results[0].items():
            check(f"{name} has the same bytes with another umask, locale and time zone", True, content == results[1][name])
        carried = judge_wheel(wheel)
        check("the bill beside the packages names the libraries of the wheel", set(),
              carried - {package["name"] for package in json.loads(bill)["packages"]})
        raw_wheel(wheel, {"ectwin.libs/libother-00000000.so.1": ""})
        done = run(PLACES[0], TOOLS / "wheel.py", wheel, folder / "SOEM", program)
        check("a library without a licence is refused", (1, True), (done.returncode, "libother" in done.stderr))
    return 1 if FAILED else 0


sys.exit(main())
