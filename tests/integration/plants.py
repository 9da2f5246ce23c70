#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants outside the twins' process (docs/PLANTS.md): the tank of examples/tank on the virtual clock, plants of running twins.

usage: plants.py ECTWIN ECTWIN-TANK-PLC
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path[:0] = [os.path.join(ROOT, "python"), os.path.join(ROOT, "examples", "tank")]
import ectwin  # noqa: E402
import tank  # noqa: E402

PLC = ""
PATIENCE = 300  # seconds, on a machine that stands still at times


def regulated(plant, name, seconds, *options):
    """The PLC on a virtual clock with a plant. Returns exit code, output and messages."""
    command = [os.environ["ECTWIN"], "with", "--in-process", "--virtual-time", "--quiet", "--name", name, "--plant", "tank", *options]
    command += [os.path.join(ROOT, "examples", "tank", "tank.yaml"), "--", PLC, "{}", "--seconds", str(seconds)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        plant.run(name, wait=True, timeout=PATIENCE)
    except ZeroDivisionError:
        pass
    output, messages = process.communicate(timeout=PATIENCE)
    return process.returncode, output, messages


class OnTheVirtualClock(unittest.TestCase):
    def test_the_tank_is_regulated_and_each_run_is_the_same(self):
        script = os.path.join(ROOT, "examples", "tank", "tank.sh")
        runs = [subprocess.run([script, "--virtual", os.path.dirname(PLC), "--seconds", "25"], capture_output=True, text=True) for _ in range(2)]
        for run in runs:
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertNotIn("plant", run.stderr)
        self.assertEqual(runs[0].stdout, runs[1].stdout)
        self.assertRegex(runs[0].stdout, r'"inlet closes","cycle":\d+,"level":601')
        self.assertRegex(runs[0].stdout, r'"end","switched":5,"least":399,"most":601')

    def test_a_step_has_its_exact_time_and_the_values_of_one_moment(self):
        water, times = tank.Tank(500), []
        plant = water.plant()
        step = plant.function
        plant.function = lambda now, values: times.append(now) or step(now, values)
        code, output, messages = regulated(plant, "exact", 1)
        self.assertEqual(code, 3, messages)  # never filled in a second
        self.assertGreater(len(times), 1000)
        self.assertEqual(times, [round(n * 0.001, 6) for n in range(len(times))])
        self.assertNotIn("plant", messages.replace("start its plant", ""))

    def test_a_record_of_a_run_with_a_plant_replays_alike(self):
        with tempfile.TemporaryDirectory() as folder:
            record = os.path.join(folder, "run.ectwin")
            regulated(tank.Tank(590).plant(), "record", 2, "--record", record)
            replay = subprocess.run([os.environ["ECTWIN"], "replay", record], capture_output=True, text=True)
        self.assertEqual(replay.returncode, 0, replay.stdout + replay.stderr)

    def test_a_plant_that_dies_is_reported_once_and_the_bus_goes_on(self):
        water = tank.Tank(500)
        plant = water.plant()
        step = plant.function
        plant.function = lambda now, values: step(now, values) if now < 0.5 else 1 // 0
        code, output, messages = regulated(plant, "dies", 3)
        self.assertEqual(messages.count("plant 'tank' has ended: its signals keep their last values"), 1, messages)
        self.assertIn('"event":"end"', output)
        self.assertEqual(code, 3)


    def test_a_camera_decides_each_image_of_an_fzm1(self):
        plc = os.path.join(os.path.dirname(PLC), "ectwin-plc")
        command = [os.environ["ECTWIN"], "with", "--in-process", "--virtual-time", "--name", "camera", "--plant", "camera", "fzm1"]
        images = []

        def look(now, scene):
            images.append((now, scene))
            return len(images) % 2 == 0, [len(images), scene + 0.5]

        process = subprocess.Popen([*command, "--", plc, "--scene", "3", "-m", "4", "{}"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        ectwin.camera(look).run("camera", wait=True, timeout=PATIENCE)
        output, messages = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, messages)
        data = re.findall(r'"event":"data","data":\[([\d.]+),([\d.]+),', output)
        self.assertEqual(data, [(f"{n}.000", "3.500") for n in range(1, 5)])
        self.assertEqual([scene for _, scene in images], [3] * 4)


class BesideRunningTwins(unittest.TestCase):
    def test_signals_follow_and_counters_tell(self):
        with ectwin.start("fzm1,fzm1") as twin:
            half = ectwin.Plant(lambda now, values: {(2, "data1"): values["data1"] / 2}, ["data1"], [(2, "data1")], name="half")
            with half.start(twin):
                twin.set({"data1": 5})
                self.assertEqual(twin.wait("data1", 2.5, timeout=PATIENCE, slave=2), 2.5)
                counters = twin.stats()["plants"]["half"]
                self.assertTrue(counters["connected"])
                self.assertGreater(counters["steps"], 0)
                shown = subprocess.run([os.environ["ECTWIN"], "stats", "-s", twin.path], capture_output=True, text=True).stdout
                self.assertRegex(shown, r"plant 'half', every 1000 us: \d+ steps, \d+ periods late, 0 replies refused")
            with self.subTest("its values remain"):
                self.assertEqual(twin.get("data1", 2), 2.5)
            while twin.stats()["plants"]["half"]["connected"]:
                pass
            self.assertEqual(twin.messages().count("plant 'half' has ended"), 1)

    def test_mistakes_are_refused_in_one_line_before_the_start(self):
        with ectwin.start("fzm1") as twin:
            for reads, writes, reason in (
                (["nosuch"], [], "has no signal 'nosuch'"),
                ([], ["busy"], "busy is the twin's own"),
                (["comment1"], [], "comment1 is a text"),
                ([(2, "data1")], [], "no such slave"),
            ):
                with self.assertRaisesRegex(ectwin.Refused, reason):
                    ectwin.Plant(lambda now, values: None, reads, writes).attach(twin)
            with self.assertRaisesRegex(ectwin.Refused, "needs a virtual clock"):
                ectwin.Plant(lambda now, values: None, ["data1"]).attach(twin, wait=True)
            too_high = ectwin.Plant(lambda now, values: {"data1": 1e12}, [], ["data1"])
            with self.assertRaisesRegex(ectwin.Refused, "data1 takes"):
                too_high.run(twin)

    def test_many_signals_need_several_requests(self):
        with ectwin.start(",".join(["fzm1"] * 8)) as twin:
            reads = [(n % 8 + 1, f"data{n // 8 + 1}") for n in range(64)]
            got = threading.Event()
            plant = ectwin.Plant(lambda now, values: got.set() if len(values) == 64 else None, reads, name="many")
            with plant.start(twin):
                self.assertTrue(got.wait(PATIENCE))

    def test_twins_that_are_missing_are_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(ectwin.Error, "no twin answers at"):
                ectwin.Plant(lambda now, values: None, ["data1"]).attach(os.path.join(folder, "no.sock"), timeout=0)
        result = subprocess.run([sys.executable, tank.__file__, "/no/such.sock"], capture_output=True, text=True)
        self.assertTrue(re.fullmatch(r"tank.py: no twin answers at .*\n", result.stderr), result.stderr)


if __name__ == "__main__":
    os.environ["ECTWIN"], PLC = map(os.path.abspath, sys.argv[1:3])
    runtime = tempfile.TemporaryDirectory()
    os.environ["XDG_RUNTIME_DIR"] = runtime.name
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
