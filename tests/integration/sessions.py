#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Sessions with the command: commands, and what they print.

usage: sessions.py [--accept] ECTWIN [NAME...]     NAME: sessions/NAME.txt; without, all files

A line "$ COMMAND" is run by a shell; the lines below it are expected on its standard output and standard error, "[N]" on a line of its
own is its exit status other than 0; "Try `… --help'" is left out. A line with ; in front is a comment. The commands of a file share a
folder, in which esi, eni, examples, fuzz and support are those of this tree. VERSION is the version of ectwin, FOLDER that folder. --accept writes
the output into the files: read the difference before it is committed.
"""
import concurrent.futures
import difflib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

TESTS = pathlib.Path(__file__).resolve().parents[1]
FOLDERS = {"esi": TESTS / "esi", "eni": TESTS / "eni", "examples": TESTS.parent / "examples", "fuzz": TESTS / "fuzz/seeds",
           "support": TESTS / "support"}
LONGEST = 60  # s
HELP = re.compile(r"Try `[^']*' or `[^']*' for\s+more\s+information\.\n")  # follows each message on wrong usage
OTHERS = re.compile(r"^  (one of .* runs: -s|.* may have some, in) .*\n", re.M)  # twins of other tests, and of other users


def output_of(command, folder, environment, version):
    with subprocess.Popen(["sh", "-c", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, start_new_session=True) as process:
        try:
            text = process.communicate(timeout=LONGEST)[0].decode(errors="backslashreplace").replace(version, "VERSION").replace(folder, "FOLDER")
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return [f"no end after {LONGEST} s"]
    lines = OTHERS.sub("", HELP.sub("", text)).splitlines() + ([f"[{process.returncode}]"] if process.returncode != 0 else [])
    return [line.rstrip() for line in lines]


def play(ectwin, script):
    """The lines of a file, with the present output below each command."""
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for name, target in FOLDERS.items():
            os.symlink(target, f"{folder}/{name}")
        os.mkdir(f"{folder}/runtime", 0o700)
        environment = {**os.environ, "PATH": f"{ectwin.parent}:{os.environ['PATH']}", "XDG_RUNTIME_DIR": f"{folder}/runtime", "LC_ALL": "C"}
        version = subprocess.run([ectwin, "--version"], stdout=subprocess.PIPE, check=True, text=True).stdout.split()[1]
        for line in script.read_text().splitlines():
            if line.startswith("$ "):
                lines += [line, *output_of(line[2:], folder, environment, version)]
            elif line.startswith("; "):
                lines.append(line)
    return lines


def main():
    arguments = sys.argv[1:]
    accept = arguments[:1] == ["--accept"]
    ectwin = pathlib.Path(arguments[accept]).resolve()
    scripts = sorted((pathlib.Path(__file__).parent / "sessions").glob("*.txt"))
    scripts = [s for s in scripts if s.stem in arguments[accept + 1:] or not arguments[accept + 1:]]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        played = list(pool.map(lambda script: play(ectwin, script), scripts))
    failed = not scripts
    for script, now in zip(scripts, played):
        difference = list(difflib.unified_diff(script.read_text().splitlines(), now, f"{script.name}, expected", "got", lineterm=""))
        print(*difference, sep="\n", end="\n" if difference else "")
        failed |= bool(difference)
        if accept:
            script.write_text("\n".join(now) + "\n")
    print(f"{len(scripts)} sessions")
    return 1 if failed and not accept else 0


if __name__ == "__main__":
    sys.exit(main())
