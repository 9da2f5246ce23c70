#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The Python module over a running twin (docs/CONTROL.md).

test_python.py --beside                 with an FZM1 that runs: ectwin with fzm1 -- test_python.py --beside
test_python.py --start ECTWIN IFACE     starts twins itself on an interface
"""

import os
import sys
import tempfile
import unittest
import unittest.mock

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
import ectwin  # noqa: E402


class Beside(unittest.TestCase):
    def setUp(self):
        self.twin = ectwin.connect()
        self.addCleanup(self.twin.close)

    def test_values_have_their_types(self):
        self.twin.set({"data1": 2.5, "timeout": 30, "run": True, "comment1": 'a "quoted" text'})
        self.assertEqual(self.twin.get("timeout"), 30)
        self.assertEqual(self.twin.get("comment1"), 'a "quoted" text')
        self.assertEqual(self.twin.values("data[1-3]"), {"data1": 2.5, "data2": 0, "data3": 0})
        self.assertEqual(self.twin.values("timeout", slave=0), {(1, "timeout"): 30})

    def test_several_are_set_or_none(self):
        self.twin.set({"output_time": 300, "output_period": 400})
        with self.assertRaisesRegex(ectwin.Refused, "output_time: the output time must be shorter"):
            self.twin.set({"data4": 7, "output_time": 500})
        self.assertEqual(self.twin.get("data4"), 0)
        with self.assertRaisesRegex(ectwin.Refused, "has no signal 'nosuch'"):
            self.twin.set({"nosuch": 1})

    def test_signals(self):
        (signal,) = self.twin.signals("scene")
        self.assertEqual((signal.slave, signal.name, signal.access), (1, "scene", "rw"))
        self.assertGreater(len(self.twin.signals()), 100)

    def test_one_or_several(self):
        with self.assertRaisesRegex(ectwin.Error, "not one signal, but 2"):
            self.twin.get("data[12]")
        with self.assertRaisesRegex(ectwin.Refused, "no signal matches"):
            self.twin.get("nosuch*")

    def test_watch(self):
        self.twin.set({"image_input": 100, "processing": 100})
        with self.twin.watch("busy", every=True) as watch:
            self.assertEqual(watch.values, {(1, "busy"): 0})
            self.twin.set({"trigger": 1})
            on, off = next(watch), next(watch)
            self.assertEqual((on.slave, on.name, on.value, off.value), (1, "busy", 1, 0))
            self.assertGreaterEqual(off.time - on.time, 199e-6)  # in a late twin it is detected later
            self.assertIsNone(watch.next(0.05))

    def test_a_machine_that_stands_still_leaves_the_twin_its_time(self):
        select, calls = ectwin._control.select.select, []

        def first_is_over(*arguments):  # before the twin could run
            calls.append(arguments)
            return ([], [], []) if len(calls) == 1 else select(*arguments)

        with unittest.mock.patch.object(ectwin._control.select, "select", first_is_over):
            self.twin.set({"data5": 2.5})
        with unittest.mock.patch.object(ectwin._control.select, "select", lambda *_: calls.append(None) or ([], [], [])):
            with self.assertRaisesRegex(ectwin.Error, "does not answer"):
                self.twin.get("data5")
        self.assertEqual(calls.count(None), 50)

    def test_wait_for(self):
        self.twin.set({"image_input": 1000, "processing": 50000})
        self.twin.set({"trigger": 1})
        self.twin.wait_for("busy", 0)
        with self.assertRaisesRegex(ectwin.Error, "busy is 0, not 1, after 0.05 s"):
            self.twin.wait_for("busy", 1, timeout=0.05)

    def test_wait(self):
        self.twin.set({"image_input": 1000, "processing": 50000})
        self.twin.set({"trigger": 1})
        self.assertGreaterEqual(self.twin.wait("images", lambda count: count > 0, timeout=10), 1)
        with self.assertRaisesRegex(ectwin.Error, "images is [0-9]+, not what it is waited for, after 0.05 s"):
            self.twin.wait("images", lambda count: count < 0, timeout=0.05)
        with self.assertRaisesRegex(ectwin.Error, "not the name of one signal"):
            self.twin.wait("data*", 0)

    def test_faults_plugs_and_counters(self):
        self.twin.fault("duplicate every 3")
        self.assertEqual(self.twin.faults(), ["duplicate every 3"])
        self.twin.fault("off")
        self.assertEqual(self.twin.faults(), [])
        with self.assertRaisesRegex(ectwin.Refused, "there is no slave 7"):
            self.twin.fault("hang slave 7")
        plugs = "ecat.plug_*"
        self.twin.cut(1, 1)
        self.assertEqual(list(self.twin.values(plugs).values()), [1, 0, 1, 1])
        self.twin.mend(1, 1)
        self.twin.unplug(1)
        self.assertEqual(list(self.twin.values(plugs).values()), [0, 0, 0, 0])
        self.twin.plug(1)
        self.assertEqual(list(self.twin.values(plugs).values()), [1, 1, 1, 1])
        stats = self.twin.stats()
        self.assertEqual(len(stats["answers"]), len(stats["edges_us"]) + 1)
        self.assertEqual((self.twin.about()["devices"], self.twin.about()["slaves"]), ("fzm1", 1))

    def test_many_at_once(self):
        twins = [ectwin.connect() for _ in range(15)]
        for twin in twins:
            self.addCleanup(twin.close)
        with self.assertRaisesRegex(ectwin.Error, "serves 16 connections"):
            ectwin.connect().get("scene")
        for twin in twins:
            self.assertEqual(twin.get("busy"), 0)

    def test_no_such_socket(self):
        with self.assertRaisesRegex(ectwin.Error, "no twin answers at '/nowhere/at/all'"):
            ectwin.connect("/nowhere/at/all")


class Start(unittest.TestCase):
    program = interface = None

    def test_start_set_command_and_end(self):
        with ectwin.start("vr-bu-ect-map7", self.interface, program=self.program) as twin:
            path = twin.path
            twin.set({"ru1.on": 1})
            self.assertEqual(twin.get("ru1.on"), 1)
            with self.assertRaises(ectwin.Refused):
                twin.command("ru1", bytes(15))
            self.assertEqual(twin.get("bu.state"), twin.values("bu.*")["bu.state"])
        self.assertFalse(os.path.lexists(path))

    def test_names_of_twins(self):
        with ectwin.start("a=fzm1,b=fzm1", program=self.program) as twin:
            twin.set({"a.data1": 1, "b.data1": 2})
            twin.set({"data2": 3}, slave="b")
            self.assertEqual((twin.get("a.data1"), twin.get("b.data1"), twin.get("data2", slave="b")), (1, 2, 3))
            self.assertEqual(twin.values("b.data[12]"), {"data1": 2, "data2": 3})
            self.assertEqual(twin.wait("b.data1", 2), 2)
            (signal,) = twin.signals("b.data1")
            self.assertEqual((signal.slave, signal.name, signal.twin), (2, "data1", "b"))
            with twin.watch("b.data1", every=True) as watch:
                twin.set({"b.data1": 5})
                self.assertEqual(next(watch)[1:], (2, "data1", 5, "b"))
            twin.unplug("b")
            self.assertEqual(twin.get("b.ecat.plug_in"), 0)
            twin.cut("a", 0)
            twin.fault("drop 0% wire b")
            self.assertEqual(twin.faults(), ["drop 0% wire b"])
            with self.assertRaisesRegex(ectwin.Refused, "no such slave"):
                twin.get("data1", slave="c")

    def test_options_and_several_devices(self):
        options = ["--set", "2:data1=5"]
        with ectwin.start(["fzm1", "fzm1"], self.interface, options, self.program) as twin:
            self.assertEqual(twin.values("data1", slave=0), {(1, "data1"): 0, (2, "data1"): 5})

    def test_what_cannot_start(self):
        with self.assertRaisesRegex(ectwin.Error, "ended with status 2"):
            ectwin.start("fzm1", "nosuch0", program=self.program)
        with self.assertRaisesRegex(ectwin.Error, "ended with status 1"):
            ectwin.start("nosuch", self.interface, program=self.program)

    def test_no_control_socket(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, XDG_RUNTIME_DIR=folder):
            with open(os.path.join(folder, "ectwin"), "wb"):
                pass
            with self.assertRaisesRegex(ectwin.Error, f"no control socket in '{folder}/ectwin': it is not a folder"):
                ectwin.start("fzm1", program=self.program)

    def test_periodic_data(self):
        with ectwin.start("vr-bu-ect-map7", self.interface, program=self.program) as twin:
            self.assertEqual(twin.periodic(), b"")

    def test_a_name(self):
        with ectwin.start("fzm1", self.interface, program=self.program, name="named") as twin:
            self.assertEqual([about["name"] for about in ectwin.ps()], ["named"])
            with ectwin.connect("named") as other:
                self.assertEqual(other.path, twin.path)

    def test_none_runs(self):
        with self.assertRaisesRegex(ectwin.Error, "no twin of yours is running"):
            ectwin.connect()


if __name__ == "__main__":
    mode = sys.argv.pop(1)
    if mode == "--start":
        Start.program, Start.interface = sys.argv[1:3]
    loader = unittest.defaultTestLoader
    suite = loader.loadTestsFromTestCase(Start if mode == "--start" else Beside)
    sys.exit(not unittest.TextTestRunner().run(suite).wasSuccessful())
