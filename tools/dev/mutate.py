#!/usr/bin/env python3
"""Makes small changes in the core, one at a time, and checks that the unit tests fail.

usage: tools/dev/mutate.py [OPTION...] [--near | --tests NAME,...] [ROOM...]   (600 s, seed 1, rooms od esc slave sii)
       tools/dev/mutate.py [OPTION...] conform                                 the judgements of ectwin-conform
       tools/dev/mutate.py [OPTION...] bus/inprocess                           the libraries of `ectwin with --in-process`
       tools/dev/mutate.py [OPTION...] text                                    headers, judged by the tests that include them
       tools/dev/mutate.py [OPTION...] programs/ectwin                         a program, judged by the tests that run it
       tools/dev/mutate.py --help                                              all options and rooms

A mutant is one change in one function: a comparison, an operator, a constant, a negated condition, an omitted statement. The
changed file is compiled alone, and the unit tests that reach the changed line are run, the fastest first, until one fails. A mutant
without a failed test is printed with its file and line. Mutants are selected at random until the time or the count ends; a seed and
a count determine the same sample on every machine. Mutants without any visible effect are listed, each with the reason, in
tests/budget/equivalent and do not count.

The tests of a program are those of CTest named in PROGRAMS: unit tests of its library, and scripts that run it. reached.c shows which
of them reach the changed line; only those are run. A script notices a mutant when it fails with the mutant, passes without it, and fails
with it again: on a busy machine, a script that is late notices nothing.

Needs the packages of tools/test.sh. Works below build/mutate, build/mutate-in-process and build/mutate-programs; the tree is unchanged.
"""
import argparse
import concurrent.futures
import contextlib
import fnmatch
import functools
import json
import os
import pathlib
import platform
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/mutate"
EQUIVALENT = ROOT / "tests/budget/equivalent"
LEAKS = "-fsanitize=leak"  # where AddressSanitizer does not fit: a block that is not freed is detected
CONFORM = ROOT / "programs/ectwin-conform"
LONGEST = 300  # seconds; limit of a test
MARKS = 1 << 24  # bytes of a file of reached.c
JUDGEMENTS = ["runner.c", "sha256.c", "report/decode.c", "report/words.c", "steps/expect.c", "steps/record.c", "steps/support.c",
              "steps/undo.c", "steps/verdict.c"]

# The tests of each program, by name in CTest: scripts that take seconds, and write to no fixed folder.
PROGRAMS = {
    "programs/ectwin": ["test_clone_notes", "test_command_*", "test_defects", "test_in_process_env",
                        "test_library", "test_replay_*", "test_facts*", "test_verify*",
                        "test_eni_*", "bus_file", "bus_options", "clone", "command", "completion", "control", "controller", "eni",
                        "eoe", "esi_files", "external", "in_process_command", "modbus_command", "new_device", "replay",
                        "save_bus", "scenarios", "session", "session_*", "verify"],
    "programs/ectwin-board": ["test_board", "lan9252", "session_board"],
    "programs/ectwin-conform": ["test_conform_*", "conformance", "conform_others", "conform_whole", "conform_command"],
    "programs/ectwin-panel": ["test_panel_*", "panel"],
    "programs/ectwin-probe": ["capture", "replay", "session_probe", "verify"],
}

WITH_APPLICATION = [ROOT / "src/soes"]  # compiled with each application
NOT_ALONE = ["ports/soes_hal"]  # the same, in integration tests alone

SWAPS = {
    " == ": " != ", " != ": " == ", " < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " && ": " || ",
    " || ": " && ", " + ": " - ", " - ": " + ", " & ": " | ", " | ": " & ", " << ": " >> ", " >> ": " << ",
    " ^ ": " | ", "++": "--", "--": "++", " += ": " -= ", " -= ": " += ", " |= ": " &= ", " &= ": " |= ",
    "true": "false", "false": "true",
}
SWAP = re.compile("|".join(rf"\b{k}\b" if k.isalpha() else re.escape(k) for k in sorted(SWAPS, key=len, reverse=True)))
NUMBER = re.compile(r"(?<![\w.])(?:0[xX][0-9a-fA-F]+|\d+)(?=[uUlL]*(?![\w.]))")
CONDITION = re.compile(r"\b(?:if|while) \((.*)\)(?: \{)?$")
STATEMENT = re.compile(r"^\s+(?:\(void\))?\*?[a-z]\w*(?:(?:->|\.)\w+|\[[^\]]*\])*(?:\(.*\)|(?: [|&^+-]?= .*)|\+\+|--);$")
KEPT = ("return", "break", "continue", "goto", "assert", "va_end(")  # va_end() has no effect with the compilers for Linux
FUNCTION = re.compile(r"^[a-z][\w *]*?(\w+)\(")
ROOM = re.compile(r"^\s+(?:\w+ )+(?:\*?\w+(?:\[[^\]]*\])?, )*\w+\[(?:\w+ \+ )?$|alloc\([^;]*$")  # of memory: more has no effect
ELEMENT = re.compile(r"sizeof [\w.>-]+\[$")  # all of an array have one size
# Numbers of flags: glibc reads ARGP_PARSE_ARGV0 only together with ARGP_NO_ERRS, and no flags of a child parser.
NO_FLAGS = re.compile(r"argp_parse\(&\w+, argc, argv, $|\{&\w+(?:\[\d\])?, $")
HIDDEN = re.compile(r'/\*[\s\S]*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#(?:\\\n|[^\n])*', re.M)


# --- mutants ------------------------------------------------------------------------------------------------------------


def function_lines(text):
    """The lines (from 0) in the body of a function -> the function's name. The layout is that of clang-format."""
    inside, name, lines = False, "", {}
    before = ""
    for number, line in enumerate(text.split("\n")):
        if line == "{" and before.rstrip().endswith(")"):
            inside = True
        elif line == "}":
            inside = False
        elif inside:
            lines[number] = name
        elif FUNCTION.match(line):
            name = FUNCTION.match(line)[1]
        before = line
    return lines


def number_and_format(text):
    """The value of a number of C, and the format of a changed one: octal numbers remain octal."""
    octal = len(text) > 1 and text.isdigit() and text[0] == "0"
    return (int(text, 8), "0{:o}") if octal else (int(text, 0), "{}")


def changes(line, hidden):
    """Each way to change one line: (begin, end, replacement). `hidden` has comments and literals blanked."""
    for match in SWAP.finditer(hidden):
        yield match.start(), match.end(), SWAPS[match[0]]
    for match in NUMBER.finditer(hidden):
        value, layout = number_and_format(match[0])
        if ELEMENT.search(hidden[:match.start()]) or NO_FLAGS.search(hidden[:match.start()]):
            continue
        if not ROOM.search(hidden[:match.start()]):
            yield match.start(), match.end(), layout.format(value + 1)
        if value > 1:
            yield match.start(), match.end(), layout.format(value - 1)
    match = CONDITION.search(hidden)
    if match:
        yield match.start(1), match.end(1), f"!({line[match.start(1):match.end(1)]})"
    if STATEMENT.match(hidden) and not hidden.lstrip().startswith(KEPT):
        indent = len(line) - len(line.lstrip())
        yield indent, len(line), ";"


def mutants(source):
    text = source.read_text()
    hidden = HIDDEN.sub(lambda m: re.sub(r"[^\n]", "~", m[0]), text).split("\n")
    lines = text.split("\n")
    functions = function_lines("\n".join(hidden))
    for number in sorted(functions):
        if "ECT_ASSERT(" in hidden[number]:  # true in every correct program, so no test can detect the change
            continue
        for begin, end, replacement in changes(lines[number], hidden[number]):
            changed = lines[number][:begin] + replacement + lines[number][end:]
            yield {"source": source, "line": number, "function": functions[number], "from": lines[number].strip(), "to": changed.strip(), "text": changed}


# --- builds shared by all mutants -----------------------------------------------------------------------------------------


def run(*command, **options):
    return subprocess.run(command, check=True, stdout=subprocess.DEVNULL, **options)


class Compiled:
    """A source with its compilation by CMake for one target."""

    def __init__(self, entry):
        command = shlex.split(entry["command"])
        if pathlib.Path(command[0]).name == "ccache":
            command = command[1:]
        at = command.index("-o") + 1
        self.source = pathlib.Path(entry["file"])
        self.object = pathlib.Path(entry["directory"]) / command[at]
        self.target = re.search(r"CMakeFiles/([^/]+)\.dir/", command[at])[1]
        self.command = command[:at - 1] + command[at + 1:]

    def compile(self, changed, out, before=()):
        """Compiles the changed source in place of this one, with further leading options. Returns whether the compilation has
        succeeded."""
        command = [a if a != str(self.source) else str(changed) for a in self.command if a != "--coverage"]
        command[1:1] = before
        command += ["-Werror=implicit-function-declaration", f"-I{self.source.parent}", "-o", str(out)]
        return subprocess.run(command, cwd=BUILD, capture_output=True, check=False).returncode == 0


class Program:
    """The unit tests, each linked with one shared library that holds all of src/, so that a mutant costs one object.

    Sources that a test's target compiles for itself, as a device with ECT_SMALL, precede those of the library. A test that wraps
    calls (-Wl,--wrap) is linked as CMake links it, because a shared library would call past the wrappers."""

    SANITIZERS = "address,undefined"  # as in tools/test.sh: a mutant that reads past the end of an array fails
    FLAGS = "-fPIC -O0 -w --coverage"
    VISIBILITY = "default"  # a test is linked with the library that has the mutant
    PATIENCE = (2, 10)  # a test ends in so many seconds, and times what it takes without a mutant

    def configure(self):
        run("cmake", "--preset", "dev", "-B", str(BUILD), f"-DECTWIN_SANITIZE={self.SANITIZERS}", f"-DCMAKE_C_FLAGS={self.FLAGS}",
            "-DCMAKE_C_FLAGS_DEBUG=", f"-DCMAKE_C_VISIBILITY_PRESET={self.VISIBILITY}", cwd=ROOT)

    def build(self, *targets):
        """Builds targets, or all. Returns target -> source -> Compiled."""
        self.configure()
        run("cmake", "--build", str(BUILD), *(["--target", *targets] if targets else []))
        found = {}
        for entry in json.loads((BUILD / "compile_commands.json").read_text()):
            compiled = Compiled(entry)
            found.setdefault(compiled.target, {})[compiled.source] = compiled
        return found

    def __init__(self, tests):
        targets = self.build(*tests)
        # Compiled with each application, for its own variables; calls of the host replace those of libc.
        apart = [ROOT / "src/soes", ROOT / "src/ports/soes_hal", ROOT / "src/bus/inprocess"]
        self.library = {s: c for sources in targets.values() for s, c in sources.items()
                        if BUILD / "src" in c.object.parents and s.parent not in apart and c.object.exists()}
        modules = ["libcjson", "libnl-route-3.0", "libxml-2.0", "yaml-0.1", "cmocka"]
        modules += [optional for optional in ("libseccomp", "libmodbus", "libbpf")
                    if subprocess.run(["pkg-config", "--exists", optional], check=False).returncode == 0]
        self.libraries = run_for_text("pkg-config", "--libs", *modules).split() + ["-lm"]
        self.link(BUILD / "libcore.so", {})
        self.support, self.options = targets["test_support"], targets["ectwin_sanitize"]
        unit = ROOT / "tests/unit"
        self.own = {name: sources for name, sources in sorted(targets.items())
                    if any(unit in s.parents for s in sources) and (not tests or name in tests)}
        self.core = self.library | {s: c for sources in self.own.values() for s, c in sources.items()
                                    if s.parent in WITH_APPLICATION and c.object.exists()}
        self.tests, self.as_built = {}, set()
        for name in self.own:
            if any("--wrap=" in word for word in link_command(name)) or self.link_test(name, BUILD / name, {}).returncode != 0:
                self.as_built.add(name)
            self.tests[name] = BUILD / "tests" / name if name in self.as_built else BUILD / name

    def link(self, library, instead):
        if instead and self.as_built >= self.own.keys():
            return  # no test has the shared library
        if instead and not instead.keys() & self.library.keys():
            library.symlink_to(BUILD / library.name)
            return
        objects = [str(instead.get(s, c.object)) for s, c in sorted(self.library.items())]
        run("cc", *self.link_flags(), "-shared", "-o", str(library), *objects, *self.libraries)

    def link_flags(self):
        return ["--coverage", f"-fsanitize={self.SANITIZERS}"]

    def link_test(self, name, program, instead):
        sources = {**self.support, **self.options, **self.own[name]}
        objects = [str(instead.get(s, c.object)) for s, c in sources.items()]
        return subprocess.run(["cc", *self.link_flags(), "-o", str(program), *objects, f"-L{BUILD}", "-lcore",
                               "-Wl,--allow-shlib-undefined", *self.libraries], capture_output=True, check=False)

    def with_mutant(self, name, source, changed, work):
        """The test to run for a source: another one, if that test compiles the source itself."""
        own = self.own[name].get(source)
        if name in self.as_built:
            instead = work / ("own.o" if own else "mutant.o")
            if own and not own.compile(changed, instead):
                raise RuntimeError(f"{source} as {name} has it")
            return self.link_wrapped(name, work / name, instead, own)
        if not own:
            return self.tests[name]
        program = work / name
        if not own.compile(changed, work / "own.o") or self.link_test(name, program, {source: work / "own.o"}).returncode != 0:
            raise RuntimeError(f"{source} as {name} has it")
        return program

    def link_wrapped(self, name, program, instead, own):
        try:
            return link_as_built(f"tests/{name}", program, instead, own)
        except subprocess.CalledProcessError:  # its libraries have no part of this source
            return self.tests[name]

    def command(self, name, program, folder):
        """The command of a test: words and environment. `folder` has the library with the mutant."""
        return [program], environment(folder)

    def notices(self, name, words, variables, seconds):
        return not passes(words, variables, seconds)

    def tests_beside(self, source):
        """The tests of a source's own room, because a process started by a test may have executed a line without coverage."""
        folder = ROOT / "tests/unit" / source.relative_to(ROOT).parent.relative_to("src")
        return [name for name in sorted(self.seconds, key=self.seconds.get)
                if any(s.parent == folder for s in self.own[name])]

    def measure(self, sources):
        """Runs each test once, for its duration and the source lines that it reaches.

        A line without code (a table, a constant) is reached with the next line with code."""
        self.seconds, reached, with_code = {}, {}, {}
        for name, program in self.tests.items():
            for data in BUILD.rglob("*.gcda"):
                data.unlink()
            begin = time.monotonic()
            words, variables = self.command(name, program, BUILD)
            if not passes(words, variables, LONGEST):
                print(f"{name} fails, is skipped or takes more than {LONGEST} s without a mutant: left out", file=sys.stderr)
                continue
            self.seconds[name] = time.monotonic() - begin
            for source in sources:
                built = self.own[name].get(source, self.core[source]).object
                for line, count in lines_with_code(built, source):
                    with_code.setdefault(source, set()).add(line)
                    if count > 0:
                        reached.setdefault((source, line), []).append(name)
        for names in reached.values():
            names.sort(key=self.seconds.get)
        for source in sources:
            last, lines = [], len(source.read_text().split("\n"))
            for line in range(lines, -1, -1):
                if line in with_code.get(source, set()):
                    last = reached.get((source, line), [])
                else:
                    reached[source, line] = last
        return reached


class Conform(Program):
    """The unit tests of ectwin-conform, linked as CMake does it: the object of a mutant goes before the runner's library."""

    def __init__(self):
        names = [path.stem for path in sorted((ROOT / "tests/unit/programs/conform").glob("test_*.c"))]
        targets = self.build(*names)
        self.core = targets["ectwin_conform"]
        self.own = {name: targets[name] for name in names}
        self.tests = {name: BUILD / "tests" / name for name in names}

    def link(self, library, instead):
        """Each test is linked with the mutant directly before its run."""

    def tests_beside(self, source):
        return []

    def with_mutant(self, name, source, changed, work):
        return link_as_built(f"tests/{name}", work / name, work / "mutant.o", None)


class Headers(Program):
    """A room of headers only: each unit test that includes one is compiled with the changed header, which precedes src/."""

    def __init__(self):
        names = [t.stem for t in sorted((ROOT / "tests/unit").rglob("test_*.c")) if '#include "text/' in t.read_text()]
        targets = self.build(*names)
        self.own = {name: {s: c for s, c in targets[name].items() if s.stem == name} for name in names}
        self.core = dict.fromkeys(sources_of("text"), self)
        self.tests = {name: BUILD / "tests" / name for name in names}

    def compile(self, changed, out):
        """A header is compiled with each test directly before its run."""
        return True

    def link(self, library, instead):
        """The same."""

    def tests_beside(self, source):
        return sorted(self.seconds, key=self.seconds.get)

    def with_mutant(self, name, source, changed, work):
        header = work / source.relative_to(ROOT / "src")
        header.parent.mkdir(exist_ok=True)
        header.write_text(changed.read_text())
        (test, own), = self.own[name].items()
        if not own.compile(test, work / "own.o", [f"-I{work}"]):
            raise RuntimeError(f"{source} as {name} has it")
        return link_as_built(f"tests/{name}", work / name, work / "own.o", own)

    def measure(self, sources):
        self.seconds = {}
        for name, program in self.tests.items():
            begin = time.monotonic()
            if not passes(*self.command(name, program, BUILD), LONGEST):
                print(f"{name} fails, is skipped or takes more than {LONGEST} s without a mutant: left out", file=sys.stderr)
                continue
            self.seconds[name] = time.monotonic() - begin
        return {}


class InProcess(Program):
    """The libraries between a master and its sockets, judged by the unit tests of their sources and by the masters of the
    integration tests on both clocks: masters that call the C library, and, if the processor supports them, masters that make direct
    system calls."""

    SANITIZERS = "undefined"  # that library also replaces functions of threads; its unit tests do not
    PARTS = ["calls", "sockets", "waits", "addresses"]  # lists needs a folder of `ectwin with`
    MASTERS = [f"inprocess_{part}" for part in PARTS]
    if platform.machine() == "x86_64":
        MASTERS += [f"inprocess_raw_{part}" for part in PARTS] + ["inprocess_dispatch"]
    RUNS = {f"{master}_{clock}": (master, clock) for master in MASTERS for clock in ("real", "virtual")}
    UNITS = [path.stem for path in sorted((ROOT / "tests/unit/bus/inprocess").glob("test_*.c"))
             if (platform.machine() == "x86_64" or not re.fullmatch("test_raw_(calls|clock|dispatch)", path.stem))
             and (platform.machine() in ("x86_64", "aarch64") or path.stem != "test_user")]

    def __init__(self):
        global BUILD
        BUILD = ROOT / "build/mutate-in-process"
        modules = {name: f"ectwin_inprocess_{clock}" for name, (_, clock) in self.RUNS.items()}
        targets = self.build(*self.MASTERS, *self.UNITS, "ectwin_chain", *sorted(set(modules.values())))
        self.own = {name: targets[module] for name, module in modules.items()}
        self.core = {source: compiled for sources in self.own.values() for source, compiled in sources.items()}
        self.tests = {name: BUILD / f"libectwin-{clock}.so" for name, (_, clock) in self.RUNS.items()}
        self.own.update({name: targets[name] for name in self.UNITS})
        self.tests.update({name: BUILD / "tests" / name for name in self.UNITS})

    def link(self, library, instead):
        """Each library is linked with the mutant directly before its run."""

    def tests_beside(self, source):
        return [name for name in self.own if name in self.seconds and source in self.own[name]]

    def with_mutant(self, name, source, changed, work):
        if name in self.UNITS:
            own = self.own[name][source]
            if not own.compile(changed, work / "own.o"):
                raise RuntimeError(f"{source} as {name} has it")
            return link_as_built(f"tests/{name}", work / name, work / "own.o", own, LEAKS)
        library = self.tests[name].name
        for twins in BUILD.glob("libectwin.so*"):  # searched next to the library
            if not (work / twins.name).exists():
                (work / twins.name).symlink_to(twins)
        return link_as_built(library, work / library, work / "mutant.o", self.own[name][source])

    def command(self, name, program, folder):
        if name in self.UNITS:
            return super().command(name, program, folder)
        master, clock = self.RUNS[name]
        alone = master == "inprocess_dispatch"
        words = [BUILD / "tests/integration" / master, *([] if alone else ["ectwin0"]), clock]
        bus = "fzm1" if alone else "fzm1,fzm1"
        return words, environment(folder, LD_PRELOAD=str(program), ECTWIN_IFACE="ectwin0", ECTWIN_INPROCESS=bus,
                                  ECTWIN_INPROCESS_MARK="/dev/null", ECTWIN_INPROCESS_CWD="/")


class Installed(Program):
    """A program, with the tests of CTest that run it. A mutant is linked into a folder that also has the other programs and
    libraries of the build, because programs search for each other there; the folder replaces the build in the command of a test."""

    SANITIZERS = "undefined"  # --in-process also replaces functions of threads; see with_mutant
    VISIBILITY = "hidden"
    FLAGS = "-fPIC -O0 -w"  # gcov loses what a process in a sandbox, or one that a signal ends, has reached: see measure
    PATIENCE = (10, 3)
    SANDBOX = ROOT / "src/bus/net/sandbox.c"

    def __init__(self, room):
        global BUILD
        BUILD = ROOT / "build/mutate-programs"
        self.configure()
        self.ctest = {name: test for name, test in ctest().items() if any(fnmatch.fnmatch(name, known) for known in PROGRAMS[room])}
        outputs = {line.split(":")[0] for line in run_for_text("ninja", "-C", str(BUILD), "-t", "targets", "all").splitlines()}
        words = {w.removeprefix(f"{BUILD}/") for command, _ in self.ctest.values() for w in command}
        beside = {o for o in outputs if re.fullmatch(r"ectwin(-board|-panel|-probe)?|libectwin(-real|-virtual)?\.so(\.[\d.]+)?", o)}
        self.beside, self.linked = beside, sorted((words | beside | {pathlib.Path(room).name}) & outputs)
        targets = self.build(*self.linked)
        folder = ROOT / room
        self.core = {s: c for sources in targets.values() for s, c in sources.items() if folder in s.parents and c.object.exists()}
        self.own = {name: {} for name in self.ctest}
        self.tests = {name: None for name in self.ctest}
        self.links = {name: link_command(name) for name in self.linked if not (BUILD / name).is_symlink()}
        self.sandbox = BUILD / "sandbox_with_leaks.o"
        if not targets["ectwin_net"][self.SANDBOX].compile(self.SANDBOX, self.sandbox, ["-D__SANITIZE_ADDRESS__"]):
            raise RuntimeError(self.SANDBOX)

    def link(self, library, instead):
        """Links every program and library that contains the source, and adds the others of the build to the folder."""
        (source, mutant), = instead.items()
        work, own = library.parent, self.core[source]
        add_programs(self.beside, BUILD, work)
        for name, command in self.links.items():
            is_own = any((BUILD / word) == own.object for word in command)
            if is_own or self.archive(source) in command:
                (work / name).unlink(missing_ok=True)
                (work / name).parent.mkdir(parents=True, exist_ok=True)
                leaks = [LEAKS] if name.startswith("tests/test_") else []
                link_as_built(name, work / name, mutant, own if is_own else None, *leaks)

    def with_mutant(self, name, source, changed, work):
        """A folder with other programs for a session, and for the panel's test: they check for leaks, in a sandbox that permits the
        check, as with asan."""
        new = {n for n in self.beside & {"ectwin", "ectwin-panel"} if not (work / n).samefile(BUILD / n)}
        if not new or not (name.startswith("session_") or name == "panel"):
            return None
        folder, own = work / "leaks", self.core[source]
        if not folder.exists():
            folder.mkdir()
            add_programs(self.beside - new, work, folder)
            for program in new:
                is_own = any((BUILD / word) == own.object for word in self.links[program])
                link_as_built(program, folder / program, work / "mutant.o", own if is_own else None, LEAKS, str(self.sandbox))
        return folder

    def tests_beside(self, source):
        return []

    def notices(self, name, words, variables, seconds):
        """Scripts start processes and wait for them: a failure counts when the test passes without the mutant, and then fails again."""
        for _ in range(3):
            if passes(words, variables, seconds):
                return False
            if passes(*self.command(name, None, BUILD), seconds):
                return not passes(words, variables, seconds)
        print(f"{name} fails without a mutant, too: the machine is too busy", file=sys.stderr)
        return False

    def measure(self, sources):
        """The same with the marks of reached.c in the place of gcov's counters."""
        self.seconds, reached = {}, {}
        with tempfile.TemporaryDirectory(dir=BUILD) as folder:
            work = pathlib.Path(folder)
            marks = self.link_marked(sources, work)
            blocks = {name: blocks_of(work / name, sources) for name in marks}
            for name in self.tests:
                for file in marks.values():
                    file.unlink(missing_ok=True)
                    file.touch()
                    os.truncate(file, MARKS)
                begin = time.monotonic()
                if not passes(*self.command(name, None, work), LONGEST):
                    print(f"{name} fails, is skipped or takes more than {LONGEST} s without a mutant: left out", file=sys.stderr)
                    continue
                self.seconds[name] = time.monotonic() - begin
                for program, file in marks.items():
                    for mark in re.finditer(b"\1", file.read_bytes()):
                        for place in blocks[program].get(mark.start(), ()):
                            reached.setdefault(place, set()).add(name)
        with_code = {place for found in blocks.values() for places in found.values() for place in places}
        return self.with_lines_between(sources, reached, with_code)

    def with_lines_between(self, sources, reached, with_code):
        """A line without code of its own is reached with the next one that has some."""
        for source in sources:
            last = []
            for line in range(len(source.read_text().split("\n")), -1, -1):
                if (source, line) in with_code:
                    last = sorted(reached.get((source, line), ()), key=self.seconds.get)
                reached[source, line] = last
        return reached

    def link_marked(self, sources, work):
        """Links all that has one of the sources, which are compiled with marks, into a folder. Returns name -> file of its marks."""
        objects, marks = {}, {}
        for number, source in enumerate(sources):
            objects[source] = work / f"{number}" / self.core[source].object.name
            objects[source].parent.mkdir()
            if not self.core[source].compile(source, objects[source], ["-g", "-fsanitize-coverage=trace-pc"]):
                raise RuntimeError(f"{source} with marks")
        add_programs(self.beside, BUILD, work)
        for name, command in self.links.items():
            new = [str(next((objects[s] for s in sources if self.core[s].object == BUILD / word), word)) for word in command]
            for archive in {self.archive(s) for s in sources} & set(command):
                copy = work / "marked" / archive
                members = [str(objects[s]) for s in sources if self.archive(s) == archive]
                if not copy.exists():
                    copy.parent.mkdir(parents=True, exist_ok=True)  # two libraries of one folder
                    shutil.copy(BUILD / archive, copy)
                    run("ar", "r", str(copy), *members, stderr=subprocess.DEVNULL)
                new = [str(copy) if word == archive else word for word in new]
            if new == command:
                continue
            (work / name).unlink(missing_ok=True)
            (work / name).parent.mkdir(parents=True, exist_ok=True)
            marks[name] = work / f"marks{len(marks)}"
            mark = work / f"mark{len(marks)}.o"
            run("cc", "-c", "-O2", "-fPIC", f'-DREACHED="{marks[name]}"', "-o", str(mark), str(ROOT / "tools/dev/reached.c"))
            new[new.index("-o") + 1] = str(work / name)
            new.insert(new.index("-o") + 2, str(mark))
            run(*new, cwd=BUILD)
        return marks

    def archive(self, source):
        """The library that has a source's object, as commands of the linker name it."""
        own = self.core[source]
        return str(own.object.relative_to(BUILD)).split("/CMakeFiles/")[0] + f"/lib{own.target}.a"

    def command(self, name, program, folder):
        command, given = self.ctest[name]
        folder = program or folder
        words = [str(folder / w.removeprefix(f"{BUILD}/")) if (folder / w.removeprefix(f"{BUILD}/")).is_file() else w
                 for w in command]
        return words, environment(folder, **dict(g.split("=", 1) for g in given.split(";") if g))


def add_programs(names, folder, other):
    """Adds programs and libraries of a folder to another one. A symbolic link would be resolved by a program that searches beside
    itself."""
    for name in names:
        if (folder / name).is_symlink():
            (other / name).symlink_to(os.readlink(folder / name))
        else:
            os.link(folder / name, other / name)


def ctest():
    """name -> (command, environment) of each test. CTest lists no command of a program that is not yet built."""
    found = {}
    for path in BUILD.rglob("CTestTestfile.cmake"):
        for name, command in re.findall(r"^add_test\(\[=\[(.*?)\]=\] (.*)\)$", path.read_text(), re.M):
            found[name] = (shlex.split(command.replace("\\$", "$")), "")
        for name, value in re.findall(r'^set_tests_properties\(\[=\[(.*?)\]=\] PROPERTIES .*?\bENVIRONMENT "(.*?)"', path.read_text(), re.M):
            found[name] = (found[name][0], value)
    return found


APART = {"conform": Conform, "bus/inprocess": InProcess, "text": Headers,  # rooms with their own tests
         **{room: functools.partial(Installed, room) for room in PROGRAMS}}


def blocks_of(program, sources):
    """The places in a program, as reached.c marks them -> (source, line from 0) of each line in the block that begins there."""
    wanted = {str(source): source for source in sources}
    blocks, block, place, called = {}, None, None, False
    for text in run_for_text("objdump", "-d", "-l", "--no-show-raw-insn", str(program)).split("\n"):
        if text.startswith("/"):
            file, _, line = text.split(" ")[0].rpartition(":")
            place = (wanted[file], int(line) - 1) if file in wanted and line.isdigit() else None
        elif text.startswith(" "):
            if called:
                block = blocks.setdefault(int(text.split(":")[0], 16), set())
            called = "<__sanitizer_cov_trace_pc>" in text
            if block is not None and place and not called:
                block.add(place)
        elif text.endswith(">:"):
            block, place, called = None, None, False
    return blocks


@functools.cache
def link_words(target):
    lines = run_for_text("ninja", "-C", str(BUILD), "-t", "commands", "-s", target).strip().split("\n")
    return tuple(word for word in shlex.split(lines[-1]) if word not in (":", "&&"))


def link_command(target):
    """CMake's link command of a target, as words."""
    return list(link_words(target))


def link_as_built(target, program, instead, own, *flags):
    """Links a target with a changed object: in place of its own, else before the libraries, whose member is then not used. `flags`
    are options, and further objects in place of members."""
    command = link_command(target)
    command[command.index("-o") + 1] = str(program)
    at = next((i for i, word in enumerate(command) if word.endswith(".a")), len(command))
    command[at:at] = flags
    if own:
        command = [str(instead) if (BUILD / word) == own.object else word for word in command]
    else:
        command.insert(at, str(instead))
    subprocess.run(command, cwd=BUILD, check=True, capture_output=True)
    return program


def run_for_text(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def sources_of(room):
    if room == "conform":
        return [CONFORM / name for name in JUDGEMENTS]
    if room in PROGRAMS:
        return sorted((ROOT / room).rglob("*.c"))
    if room == "text":
        return sorted((ROOT / "src/text").glob("*.h"))
    return sorted((ROOT / "src" / room).rglob("*.c") if room == "profiles" else (ROOT / "src" / room).glob("*.c"))


def all_rooms():
    folders = {str(p.parent.relative_to(ROOT / "src")) for p in (ROOT / "src").rglob("*.c")}
    return [*sorted(folders - set(NOT_ALONE)), "text", "profiles", "conform", *PROGRAMS]


def tests_near(rooms):
    """The unit tests in the same part of the tree as the rooms, and all that include a header of one."""
    unit = ROOT / "tests/unit"
    return [t.stem for t in sorted(unit.rglob("test_*.c"))
            if any(unit / room.split("/")[0] in t.parents or f'#include "{room}/' in t.read_text() for room in rooms)]


def environment(library_folder, **more):
    return {**os.environ, "LD_LIBRARY_PATH": str(library_folder), **more}


def lines_with_code(built, source):
    """(line from 0, number of executions by gcov)"""
    data = built.with_suffix(".gcda")
    if not data.exists():
        return []
    out = subprocess.run(["gcov", "--stdout", "--json-format", str(data)], cwd=BUILD, check=True, capture_output=True).stdout
    files = json.loads(out)["files"]
    return [(line["line_number"] - 1, line["count"]) for f in files if (BUILD / f["file"]).resolve() == source
            for line in f["lines"]]


# --- one mutant -------------------------------------------------------------------------------------------------------------


def verdict(program, reached, mutant):
    """The name of the failed test; None: no test fails; "": the mutant does not compile."""
    source = mutant["source"]
    with tempfile.TemporaryDirectory(dir=BUILD) as folder:
        work = pathlib.Path(folder)
        lines = source.read_text().split("\n")
        lines[mutant["line"]] = mutant["text"]
        changed = work / source.name
        changed.write_text("\n".join(lines))
        if not program.core[source].compile(changed, work / "mutant.o"):
            return ""
        program.link(work / "libcore.so", {source: work / "mutant.o"})
        for name in dict.fromkeys([*reached.get((source, mutant["line"]), []), *program.tests_beside(source)]):
            words, variables = program.command(name, program.with_mutant(name, source, changed, work), work)
            variables = {**variables, "GCOV_PREFIX": folder}
            seconds = program.PATIENCE[0] + program.PATIENCE[1] * program.seconds[name]
            if program.notices(name, words, variables, seconds):
                return name
    return None


def default_signals():
    """A shell ignores signals for a command in the background, and its children inherit that; scripts send them."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT):
        signal.signal(number, signal.SIG_DFL)


def passes(words, variables, seconds):
    """Runs a test, and ends all processes that it has started."""
    test = subprocess.Popen(words, cwd=ROOT, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, start_new_session=True, preexec_fn=default_signals)
    try:
        return test.wait(seconds) == 0
    except subprocess.TimeoutExpired:
        return False
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(test.pid, signal.SIGKILL)
        test.wait()


def equivalents():
    """The mutants known to have no effect: (file, function or "", line before, line after)."""
    known, name, function = set(), None, ""
    for line in EQUIVALENT.read_text().splitlines() if EQUIVALENT.exists() else []:
        if line.startswith(("src/", "programs/")):
            name, _, function = line.strip().partition(" ")
        elif line.startswith("  - "):
            before = line[4:]
        elif line.startswith("  + "):
            known.add((name, function, before, line[4:]))
    return known


def is_known(known, mutant):
    name = str(mutant["source"].relative_to(ROOT))
    return any((name, function, mutant["from"], mutant["to"]) in known for function in ("", mutant["function"]))


def judge(arguments):
    room_of = {source: room for room in arguments.rooms for source in sources_of(room)}
    tests = tests_near(arguments.rooms) if arguments.near else arguments.tests
    alone = APART.get(arguments.rooms[0])
    program = alone() if alone else Program(tests)
    sources = [source for source in room_of if source in program.core]
    for source in sorted(room_of.keys() - program.core.keys()):
        print(f"{source.relative_to(ROOT)} is not compiled in this build: left out", file=sys.stderr)
    reached = program.measure(sources)
    known = equivalents()
    todo = [m for s in sources for m in mutants(s) if not is_known(known, m)]
    random.Random(arguments.seed).shuffle(todo)
    end = time.monotonic() + arguments.seconds
    counts = {room: [0, 0] for room in arguments.rooms}

    survivors, tried = 0, 0

    def enough(mutant):
        return tried >= arguments.count or counts[room_of[mutant["source"]]][0] >= arguments.each

    def one(mutant):
        return (mutant, verdict(program, reached, mutant)) if time.monotonic() < end and not enough(mutant) else (mutant, "")

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for mutant, noticed in pool.map(one, todo):
            if noticed == "" or enough(mutant):
                continue
            tried += 1
            room = room_of[mutant["source"]]
            counts[room][0] += 1
            counts[room][1] += noticed is not None
            if noticed is None:
                survivors += 1
                print(f"{mutant['source'].relative_to(ROOT)}:{mutant['line'] + 1}\n  - {mutant['from']}\n  + {mutant['to']}", flush=True)
    return counts, survivors, len(todo)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog=f"Rooms: {' '.join(all_rooms())}.")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--count", type=int, default=sys.maxsize, help="end after this many mutants")
    parser.add_argument("--each", type=int, default=sys.maxsize, help="try at most this many mutants of a room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--near", action="store_true",
                        help="build and run only the unit tests of the rooms and those that include their headers: minutes less, but a "
                        "mutant that only others notice survives")
    parser.add_argument("--tests", type=lambda names: names.split(","), default=[], metavar="NAME,...",
                        help="build and run only these unit tests; a mutant that only others notice survives")
    parser.add_argument("rooms", nargs="*", metavar="ROOM", default=["od", "esc", "slave", "sii"],
                        help="folders below src; alone: conform, the judgements of ectwin-conform; or a program")
    arguments = parser.parse_args()
    unknown = [room for room in arguments.rooms if room not in all_rooms()]
    if unknown:
        parser.error(f"there is no room {unknown[0]}; name some of: {' '.join(all_rooms())}")
    for room in APART:
        if room in arguments.rooms and arguments.rooms != [room]:
            parser.error(f"{room} has tests of its own: name it alone")
    counts, survivors, possible = judge(arguments)
    tried = sum(c[0] for c in counts.values())
    for room, (made, noticed) in counts.items():
        print(f"{room:16} {noticed} of {made} noticed" + (f", {100 * noticed / made:.1f} %" if made else ""))
    print(f"in all {tried} of {possible} possible mutants tried, {survivors} survived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
