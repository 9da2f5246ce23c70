#!/usr/bin/env python3
"""Each name of src/soes's public headers is used in a test, and none is listed in docs/SOES.md as missing.  usage: soes_names.py ROOT"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
API = [ROOT / "src/soes" / f"{name}.h" for name in ("cc", "ecat_slv", "esc", "esc_coe", "esc_eep", "esc_eoe", "esc_foe", "options")]
TESTS = [*ROOT.glob("tests/unit/soes/test_soes*.c"), *ROOT.glob("tests/soes/*.[ch]")]
UNUSED = {  # names without a meaning of their own, or members of a used structure
    "CC_PACKED_BEGIN", "CC_PACKED_END", "CC_PACKED", "CC_ALIGNED", "CC_DEPRECATED", "EC_LITTLE_ENDIAN", "EC_BIG_ENDIAN",
}


def declared(text):
    """Macros, types and functions that a header declares."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    names = set(re.findall(r"^\s*#define\s+(\w+)", text, re.M))
    names |= set(re.findall(r"^\s*\}\s*(\w+);", text, re.M))
    names |= set(re.findall(r"^[a-z][\w ]*[ *](\w+)\([^;{]*\);", text, re.M))
    names |= set(re.findall(r"^extern [\w ]+?(\w+)(?:\[\])?;", text, re.M))
    return {name for name in names if not name.startswith("ECT_")} - UNUSED


def main():
    here = set().union(*(declared(path.read_text()) for path in API))
    used = set(re.findall(r"\w+", "".join(path.read_text() for path in TESTS)))
    page = (ROOT / "docs/SOES.md").read_text()
    part = page.split("### Missing names")[1].split("###")[0]
    first_cells = " ".join(re.findall(r"^\|(.*?)\|", part, re.M))
    missing = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]+)`", first_cells))))
    status = 0
    if len(here) < 300:
        print(f"only {len(here)} names found in src/soes")
        status = 1
    for name in sorted(here - used):
        print(f"{name} is declared in src/soes, and no test uses it")
        status = 1
    for name in sorted(here & missing):
        print(f"{name} is declared in src/soes, and docs/SOES.md lists it as missing")
        status = 1
    return status


sys.exit(main())
