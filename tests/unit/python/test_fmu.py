#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""ectwin-fmu without FMPy and without a model: maps, values, periods.  usage: test_fmu.py"""

import argparse
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "python"))
from ectwin import Error, Plant, _fmu_map, fmu  # noqa: E402

MAP = """
# a comment
fmu.valve = 1.outputs.valve
fmu.T[1,2]=gripper.level,factor=-0.5, offset=1e3   # names may have commas
2.inputs.level=fmu.der('a=b, #1'),invert

fmu.mass=2.5
fmu.on=true
fmu.off=false
level=fmu.level
"""


class Maps(unittest.TestCase):
    def test_each_line_is_a_connection_or_a_number(self):
        found = _fmu_map.parse("m", MAP)
        self.assertEqual(
            found.inputs,
            [_fmu_map.Wire("m:3", "valve", (1, "outputs.valve")), _fmu_map.Wire("m:4", "T[1,2]", "gripper.level", -0.5, 1000.0)],
        )
        self.assertEqual(
            found.outputs,
            [_fmu_map.Wire("m:5", "der('a=b, #1')", (2, "inputs.level"), invert=True), _fmu_map.Wire("m:10", "level", "level")],
        )
        self.assertEqual([start[1:] for start in found.starts], [("mass", 2.5), ("on", 1.0), ("off", 0.0)])

    def test_a_wrong_line_is_refused_with_its_number_and_the_cure(self):
        good = "fmu.a=1.b\n"
        for text, reason in (
            ("", "m connects nothing: write lines as"),
            ("# nothing\n", "m connects nothing"),
            ("fmu.a=2\n", "m connects nothing"),
            (good + "fmu.c", "m:2: a line is TARGET=SOURCE, as in fmu.valve=1.outputs.valve, not 'fmu.c'"),
            ("fmu.a=", "m:1: a line is TARGET=SOURCE"),
            ("=fmu.a", "m:1: a line is TARGET=SOURCE"),
            ("1.a=2.b", "m:1: '1.a=2.b' names no variable of the model: they begin with fmu."),
            ("fmu.a=fmu.b", "m:1: 'fmu.a=fmu.b' connects the model with itself"),
            ("fmu.a=1.b,gain=2", "m:1: 'gain=2' is none of factor=NUMBER, offset=NUMBER, invert"),
            ("fmu.a=1.b,factor=x", "m:1: 'factor=x' is none of"),
            ("fmu.a=1.b,factor=nan", "m:1: 'factor=nan' is none of"),
            ("fmu.a=1.b,offset=1e999", "m:1: 'offset=1e999' is none of"),
            ("fmu.a=1.b,delay=1ms", "m:1: 'delay=1ms' is none of"),
            ("fmu.a=2,factor=2", "m:1: 'fmu.a=2,factor=2' sets a number: leave factor"),
            (good + "fmu.a=2.c", "m:2: fmu.a is set in line 1 already"),
            ("fmu.a=5\n" + good, "m:2: fmu.a is set in line 1 already"),
            ("1.b=fmu.x\n\n1.b=fmu.y", "m:3: 1.b is set in line 1 already"),
        ):
            with self.subTest(text), self.assertRaises(Error) as raised:
                _fmu_map.parse("m", text)
            self.assertTrue(str(raised.exception).startswith(reason), raised.exception)
            self.assertNotIn("\n", str(raised.exception))

    def test_a_file_that_cannot_be_read_is_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(Error, "cannot read '.*': No such file or directory"):
                _fmu_map.read(os.path.join(folder, "none"))
            path = os.path.join(folder, "binary.map")
            with open(path, "wb") as file:
                file.write(b"\xff\xfe")
            with self.assertRaisesRegex(Error, "^cannot read '.*binary.map': .*$"):
                _fmu_map.read(path)
            with open(path, "w", encoding="utf-8") as file:
                file.write("fmu.a")
            with self.assertRaisesRegex(Error, "^binary.map:1: "):
                _fmu_map.read(path)

    def test_a_value_gets_factor_and_offset_then_inversion(self):
        wire = _fmu_map.Wire("m:1", "a", "b", factor=2, offset=-6)
        self.assertEqual([wire.convert(value) for value in (0, 3, -1.5)], [-6, 0, -9])
        self.assertEqual([wire._replace(invert=True).convert(value) for value in (0, 3)], [0, 1])


class Values(unittest.TestCase):
    def test_a_value_is_limited_to_the_range_and_rounded_to_the_type(self):
        for kind, limits, value, wanted in (
            ("Real", (), 0.3, 0.3),
            ("Float64", ("0", "1e3"), 2e3, 1e3),
            ("Float32", ("-1", None), -2.5, -1),
            ("Integer", (), 2.5, 3),
            ("Integer", (), -2.5, -3),
            ("Integer", (), 0.49, 0),
            ("Integer", (), 1e300, 2**31 - 1),
            ("Integer", ("0", "3"), 7, 3),
            ("UInt8", (), -1, 0),
            ("UInt8", (), 256, 255),
            ("Int8", (), -200, -128),
            ("Int16", (), 40000, 32767),
            ("UInt64", (), 1e300, 2**64 - 1),
            ("Int64", (), -1e300, -(2**63)),
            ("Enumeration", ("1", "4"), 0, 1),
            ("Boolean", (), 0.4, False),
            ("Boolean", (), -3, False),
            ("Boolean", (), 17, True),
        ):
            with self.subTest(f"{value} for {kind} {limits}"):
                got = fmu.fitted(value, kind, *limits)
                self.assertEqual(got, wanted)
                self.assertEqual(type(got) is bool, kind == "Boolean")

    def test_times(self):
        self.assertEqual([fmu.seconds(text) for text in ("250us", "10ms", "1.5s")], [0.00025, 0.01, 1.5])
        for text in ("10", "ms", "-1ms", "1e3us", "1 s"):
            with self.assertRaisesRegex(argparse.ArgumentTypeError, "is no time: write a number with us, ms or s"):
                fmu.seconds(text)


class Periods(unittest.TestCase):
    def test_the_model_runs_from_the_first_step_on_and_catches_up_after_a_delay(self):
        schedule = fmu.Schedule(0.001)
        times = (7.5, 7.501, 7.502, 7.505, 7.506, 7.6, 7.601)
        self.assertEqual([schedule.due(now) for now in times], [0, 1, 1, 3, 1, fmu.CATCH_UP, 1])
        self.assertEqual(schedule.lost, 94 - fmu.CATCH_UP)

    def test_periods_are_exact_over_a_long_time(self):
        schedule = fmu.Schedule(0.0001)
        self.assertEqual(sum(schedule.due(round(100 + n * 0.0001, 6)) for n in range(50000)), 49999)
        self.assertEqual(schedule.lost, 0)


class Command(unittest.TestCase):
    def run_it(self, *words, **environment):
        variables = dict(os.environ, PYTHONPATH=os.path.join(ROOT, "python"), **environment)
        return subprocess.run([sys.executable, "-m", "ectwin.fmu", *words], env=variables, capture_output=True, text=True)

    def test_wrong_usage_is_one_line(self):
        for words, reason in (
            ((), "ectwin-fmu: the following arguments are required: MODEL.fmu ("),
            (("a.fmu", "--period", "5"), "ectwin-fmu: argument --period: '5' is no time"),
            (("a.fmu", "--map", "/no/such.map"), "ectwin-fmu: cannot read '/no/such.map': No such file or directory"),
        ):
            with self.subTest(words):
                done = self.run_it(*words)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
                self.assertTrue(done.stderr.startswith(reason), done.stderr)

    def test_without_fmpy_a_line_says_how_to_install_it(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "fmpy.py"), "w", encoding="utf-8") as file:
                file.write("raise ImportError('not here')\n")
            code = f"import sys; sys.path[:0] = [{folder!r}]; import ectwin.fmu; sys.exit(ectwin.fmu.main(['a.fmu']))"
            variables = dict(os.environ, PYTHONPATH=os.path.join(ROOT, "python"))
            done = subprocess.run([sys.executable, "-c", code], env=variables, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, "ectwin-fmu: FMPy is missing (not here): pip install 'ectwin[fmu]'\n"))

    def test_a_plant_asks_for_values_that_fit(self):
        for wanted in (True, False):
            plant = Plant(lambda now, values: None, ["a"], fit=wanted)
            self.assertIs(plant._rhythm()["fit"], wanted)


if __name__ == "__main__":
    unittest.main()
