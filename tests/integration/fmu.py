#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""ectwin-fmu (docs/PLANTS.md): models of FMI 2.0 and 3.0, built from examples/tank/tank_fmu.c, between the signals of twins.

usage: fmu.py ECTWIN ECTWIN-TANK-PLC          Exit code 77: there is no FMPy.
"""

import os
import platform
import signal
import subprocess
import sys
import tempfile
import traceback
import unittest
import zipfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
TANK = os.path.join(ROOT, "examples", "tank")
FMPY = os.path.expanduser("~/.cache/ectwin/fmpy-0.3.32")
sys.path[:0] = [os.path.join(ROOT, "python"), TANK, FMPY]
import ectwin  # noqa: E402
import ectwin.fmu  # noqa: E402
import tank_fmu  # noqa: E402

try:
    import fmpy  # noqa: E402, F401
except ImportError as missing:
    print(f"skipped: no FMPy here ({missing}); 'tools/bootstrap.sh test' fetches it where PyPI can be reached")
    sys.exit(77)

PLC = ""
PATIENCE = 300  # seconds, on a machine that stands still at times
FOLDER = tempfile.TemporaryDirectory()
FMI2, FMI3 = (os.path.join(FOLDER.name, f"fmi{version}", "tank.fmu") for version in (2, 3))
FAST = "fmu.fill=1e9\nfmu.height=500\nfmu.valves=1.data1\n"  # full after one period


def path_of(name):
    return os.path.join(FOLDER.name, name)


def written(name, text):
    with open(path_of(name), "w", encoding="utf-8") as file:
        file.write(text)
    return path_of(name)


def changed(name, changes=(), members=()):
    """tank.fmu with other texts in its description, and other names of its members."""
    with zipfile.ZipFile(FMI2) as source, zipfile.ZipFile(path_of(name), "w") as target:
        for member in source.namelist():
            data = source.read(member)
            for old, new in changes if member.endswith(".xml") else ():
                assert old.encode() in data
                data = data.replace(old.encode(), new.encode())
            target.writestr(dict(members).get(member, member), data)
    return path_of(name)


def command(*words):
    """A process of ectwin-fmu, whose files are below FOLDER."""
    variables = dict(os.environ, PYTHONPATH=os.pathsep.join([os.path.join(ROOT, "python"), FMPY]), TMPDIR=path_of("tmp"))
    return subprocess.Popen([sys.executable, "-m", "ectwin.fmu", *words], env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def refusal(*words):
    """The messages of a command that fails at its start. Its process is a copy of this one: the import of FMPy is most of the time of a start."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as messages:
        process = os.fork()
        if process == 0:
            os.environ["TMPDIR"], tempfile.tempdir = path_of("tmp"), None
            os.dup2(output.fileno(), 1)
            os.dup2(messages.fileno(), 2)
            status = 70
            try:
                status = ectwin.fmu.main(list(words))
            except BaseException:  # pylint: disable=broad-exception-caught
                traceback.print_exc()
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        output.seek(0)
        messages.seek(0)
        printed, text = output.read().decode(), messages.read().decode()
    assert status == 1 and printed == "", (status, printed, text)
    return text


class OnTheVirtualClock(unittest.TestCase):
    def regulated(self, model, name):
        process = command(model, "--map", os.path.join(TANK, "tank.map"), "--wait", name)
        words = [os.environ["ECTWIN"], "with", "--in-process", "--virtual-time", "--quiet", "--name", name, "--plant", "tank"]
        words += [os.path.join(TANK, "tank.yaml"), "--", PLC, "{}", "--seconds", "25"]
        run = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE)
        messages = process.communicate(timeout=PATIENCE)[1]
        self.assertEqual((run.returncode, process.returncode), (0, 0), run.stderr + messages)
        self.assertNotIn("plant", run.stderr)
        return run.stdout

    def test_models_of_both_versions_are_regulated_alike_and_each_run_is_the_same(self):
        runs = [self.regulated(FMI2, "two"), self.regulated(FMI2, "again"), self.regulated(FMI3, "three")]
        self.assertEqual(runs[0], runs[1])
        self.assertEqual(runs[0], runs[2])
        self.assertRegex(runs[0], r'"inlet closes","cycle":\d+,"level":601')
        self.assertRegex(runs[0], r'"end","switched":5,"least":399,"most":601')


class BesideRunningTwins(unittest.TestCase):
    def serve(self, model, lines, name):
        """Twins and the process of a model that fills its tank when data1 of the first twin is 1."""
        twin = self.entered(ectwin.start("fzm1,fzm1"))
        process = command(model, "--map", written(f"{name}.map", FAST + lines), "--name", name, twin.path)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return twin, process

    def entered(self, twin):
        self.addCleanup(twin.__exit__, None, None, None)
        return twin.__enter__()

    def follow(self, model):
        lines = "2.data1=fmu.level,factor=2,offset=1\n2.data2=fmu.level,invert\n2.judgement=fmu.level\n"
        twin, process = self.serve(model, lines, "follow")
        twin.wait("data1", 1, timeout=PATIENCE, slave=2)  # an empty tank: 0 x 2 + 1
        twin.wait("data2", 1, timeout=PATIENCE, slave=2)
        twin.set({"data1": 1.3})  # rounded to 1
        twin.wait("data1", 1001, timeout=PATIENCE, slave=2)
        twin.wait("data2", 0, timeout=PATIENCE, slave=2)
        twin.wait("judgement", 1, timeout=PATIENCE, slave=2)  # limited to its range, -1 to 1
        counters = twin.stats()["plants"]["follow"]
        self.assertTrue(counters["connected"])
        self.assertEqual(counters["refused"], 0)
        return twin, process

    def test_a_model_of_fmi_2_follows_and_sets_signals_and_its_death_leaves_their_values(self):
        twin, process = self.follow(FMI2)
        process.kill()
        while twin.stats()["plants"]["follow"]["connected"]:
            pass
        self.assertEqual(twin.get("data1", 2), 1001)
        self.assertEqual(twin.messages().count("plant 'follow' has ended: its signals keep their last values"), 1)

    def test_a_model_of_fmi_3_ends_by_sigterm_and_leaves_no_files(self):
        _, process = self.follow(FMI3)
        before = os.listdir(path_of("tmp"))
        process.send_signal(signal.SIGTERM)
        messages = process.communicate(timeout=PATIENCE)[1]
        self.assertEqual(process.returncode, 0, messages)
        self.assertEqual(len(before) - len(os.listdir(path_of("tmp"))), 1)
        self.assertIn("tank.fmu (FMI 3.0): signals read: 1, set: 3, period 1000 us", messages)

    def test_a_model_that_fails_is_one_line_and_its_signals_keep_their_values(self):
        for model, function in ((FMI2, "fmi2DoStep"), (FMI3, "fmi3DoStep")):
            with self.subTest(model):
                lines = "fmu.drain=1.data2\n2.data1=fmu.level,offset=3\n"
                twin = self.entered(ectwin.start("fzm1,fzm1"))
                process = command(model, "--map", written("fails.map", FAST.replace("500", "0") + lines), twin.path)
                messages = process.communicate(timeout=PATIENCE)[1].splitlines()
                self.assertEqual(process.returncode, 1)
                messages = [line for line in messages[1:] if "was too late for" not in line]  # which it may be on a busy machine
                self.assertEqual(len(messages), 1, messages)
                self.assertEqual(messages[0], f"ectwin-fmu: tank.fmu has failed at 0 s of its time: {function} failed with status 3 (error).")
                twin.wait("data1", 3, timeout=PATIENCE, slave=2)
                while twin.stats()["plants"]["tank"]["connected"]:
                    pass
                self.assertEqual(twin.messages().count("plant 'tank' has ended"), 1)

    def test_signals_that_do_not_fit_are_one_line_before_the_start(self):
        twin = self.entered(ectwin.start("fzm1"))
        for lines, reason in (
            ("fmu.valves=1.nosuch", "has no signal 'nosuch'"),
            ("1.busy=fmu.level", "busy is the twin's own"),
            ("fmu.valves=comment1", "comment1 is a text"),
            ("fmu.valves=2.data1", "no such slave"),
        ):
            with self.subTest(lines):
                messages = refusal(FMI2, "--map", written("signals.map", lines), twin.path)
                self.assertEqual(messages.count("\n"), 1, messages)
                self.assertIn(reason, messages)
        messages = refusal(FMI2, "--map", written("waits.map", FAST), "--wait", twin.path)
        self.assertIn("needs a virtual clock", messages)


class BeforeTheStart(unittest.TestCase):
    def test_an_fmu_that_does_not_fit_is_one_line(self):
        folder = "binaries/linux64/tank.so"
        late = "</ModelVariables>"
        text = '<ScalarVariable name="label" valueReference="9" causality="input"><String/></ScalarVariable>'
        other = changed("other.fmu", members=[(folder, "binaries/win64/tank.dll")])
        sources = changed("sources.fmu", members=[(folder, "sources/tank.c")])
        for model, line, reason in (
            (path_of("none.fmu"), FAST, "cannot open '.*none.fmu': No such file or directory"),
            (written("text.fmu", "text"), FAST, "'.*text.fmu' is no FMU: an FMU is a ZIP archive with modelDescription.xml"),
            (changed("xml.fmu", [("<CoSim", "<<")]), FAST, "'.*xml.fmu' cannot be read: "),
            (changed("one.fmu", [('fmiVersion="2.0"', 'fmiVersion="4.0"')]), FAST, "'.*one.fmu' cannot be read: Unsupported FMI version: 4.0"),
            (changed("me.fmu", [("<CoSimulation", "<ModelExchange")]), FAST, "me.fmu is FMI 2.0 without co-simulation: export it as FMI 2.0 or 3.0"),
            (other, FAST, "other.fmu has no binary for this platform, linux64, only for win64: export it for Linux"),
            (sources, FAST, "sources.fmu has no binary for this platform, linux64, only for none: .*: fmpy compile sources.fmu"),
            (FMI2, "fmu.valve=1.a", "a.map:1: tank.fmu has no variable 'valve': its inputs are valves, its outputs level"),
            (FMI2, "fmu.level=1.a", "a.map:1: fmu.level is an output, no input: inputs are valves"),
            (FMI2, "fmu.fill=1.a", "a.map:1: fmu.fill is a fixed parameter, no input"),
            (FMI2, "\nfmu.level=5\n1.a=fmu.level", "a.map:2: fmu.level is an output: a number is for parameters and inputs"),
            (changed("label.fmu", [(late, text + late)]), "fmu.label=1.a", "a.map:1: fmu.label is of type String: a signal is a number"),
        ):
            with self.subTest(f"{model} {line}"):
                messages = refusal(model, "--map", written("a.map", line), path_of("no.sock"))
                self.assertRegex(messages, f"^ectwin-fmu: {reason}")
                self.assertEqual(messages.count("\n"), 1, messages)

    def test_an_array_is_refused(self):
        with zipfile.ZipFile(FMI3) as source, zipfile.ZipFile(path_of("array.fmu"), "w") as target:
            for member in source.namelist():
                data = source.read(member)
                start = b'<Float64 name="level" valueReference="1" causality="output" unit="mm"'
                target.writestr(member, data.replace(start + b"/>", start + b'><Dimension start="3"/></Float64>'))
        self.assertRegex(refusal(path_of("array.fmu"), "--map", written("a.map", "1.a=fmu.level")), "fmu.level is an array: a signal is one number")

    def test_a_library_that_does_not_load_is_one_line(self):
        with zipfile.ZipFile(FMI2) as source, zipfile.ZipFile(path_of("elf.fmu"), "w") as target:
            for member in source.namelist():
                target.writestr(member, b"text" if member.endswith(".so") else source.read(member))
        messages = refusal(path_of("elf.fmu"), "--map", written("a.map", FAST))
        self.assertRegex(messages, "^ectwin-fmu: elf.fmu does not start: Failed to load shared library .*\n$")

    def test_without_a_map_the_variables_are_listed(self):
        for model, kinds in ((FMI2, ("Integer", "Real")), (FMI3, ("UInt8", "Float64"))):
            process = command(model)
            output, messages = process.communicate(timeout=PATIENCE)
            self.assertEqual((process.returncode, messages), (0, ""))
            rows = [line.split() for line in output.splitlines()]
            self.assertEqual(rows[:2], [["fmu.valves", "input", kinds[0]], ["fmu.level", "output", kinds[1], "mm"]])
            self.assertEqual([row[0] for row in rows[2:]], ["fmu.fill", "fmu.drain", "fmu.height"])

    def test_twins_that_are_missing_are_one_line(self):
        messages = refusal(FMI2, "--map", written("a.map", FAST), path_of("no.sock"))
        self.assertRegex(messages, "^ectwin-fmu: no twin answers at .*no.sock.*\n$")


if __name__ == "__main__":
    if platform.machine() != "x86_64":
        print("skipped: the paths of this test are those of x86_64")
        sys.exit(77)
    os.environ["ECTWIN"], PLC = map(os.path.abspath, sys.argv[1:3])
    os.environ["XDG_RUNTIME_DIR"] = path_of("run")
    for path in ("fmi2", "fmi3", "run", "tmp"):
        os.mkdir(path_of(path), 0o700)
    tank_fmu.build(FMI2, 2)
    tank_fmu.build(FMI3, 3)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
