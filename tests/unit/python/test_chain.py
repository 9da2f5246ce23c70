#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""ectwin.Chain: twins in this process.  usage: test_chain.py    ($ECTWIN_LIBRARY: the library of a build)"""

import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "python"))
import ectwin  # noqa: E402

MS = 1_000_000
AL_STATUS = 0x0130


def request(index=0):
    """A broadcast read of the AL status."""
    head = bytes.fromhex("ffffffffffff02000000000188a4") + bytes([14, 0x10])
    return head + bytes([7, index, 0, 0]) + AL_STATUS.to_bytes(2, "little") + bytes([2, 0, 0, 0, 0, 0, 0, 0]) + bytes(30)


def index_of(reply):
    return reply.frame[17]


class Frames(unittest.TestCase):
    def test_a_frame_returns_with_the_counter_of_all_twins(self):
        with ectwin.Chain(["fzm1", "vr-bu-ect-map7"]) as chain:
            self.assertEqual(len(chain), 2)
            (reply,) = chain.frame(request(7))
            self.assertEqual((reply.end, index_of(reply), reply.frame[26], reply.frame[28]), (0, 7, 1, 2))
            self.assertEqual(len(reply.frame), 60)

    def test_a_frame_that_is_no_frame_gets_no_reply(self):
        with ectwin.Chain("fzm1") as chain:
            for data in (b"", b"\x00", bytes(ectwin.chain.FRAME_MAX + 1)):
                self.assertEqual(chain.frame(data), [])

    def test_both_ends(self):
        with ectwin.Chain("fzm1") as chain:
            self.assertEqual(chain.frame(request(1), end=1), [])
            chain.link(1, True)
            self.assertEqual([(r.end, index_of(r)) for r in chain.frame(request(2))], [(1, 2)])
            self.assertEqual([(r.end, index_of(r)) for r in chain.frame(request(3), end=1)], [(0, 3)])
            chain.link(0, False)
            self.assertEqual(chain.frame(request(4)), [])

    def test_time_is_an_argument_and_never_goes_back(self):
        with ectwin.Chain("fzm1", faults=["delay 2000us"], now_ns=5 * MS) as chain:
            self.assertEqual(chain.run(), [])
            self.assertEqual(chain.frame(request(1), now_ns=10 * MS), [])
            self.assertEqual((chain.now_ns, chain.next_ns), (10 * MS, 12 * MS))
            self.assertEqual(chain.run(now_ns=1), [])
            self.assertEqual(chain.now_ns, 10 * MS)
            self.assertEqual([index_of(r) for r in chain.run(chain.next_ns)], [1])

    def test_chains_are_independent(self):
        with ectwin.Chain("fzm1") as one, ectwin.Chain("fzm1,fzm1") as other:
            one.set({"data1": 2.5})
            self.assertEqual((float(one.get("data1")), float(other.get("data1"))), (2.5, 0))
            self.assertEqual((len(one), len(other)), (1, 2))


class Surroundings(unittest.TestCase):
    def test_signals(self):
        with ectwin.Chain("fzm1,fzm1", ["--set", "data1=1.5"]) as chain:
            self.assertEqual((chain.get("data1"), chain.get("data1", slave=2)), ("1.5", "0"))
            chain.set({"data1": -2.25, "run": True, "comment1": "a text"}, slave=2)
            self.assertEqual([chain.get(name, 2) for name in ("data1", "run", "comment1")], ["-2.25", "1", "a text"])

    def test_refused_values(self):
        with ectwin.Chain("fzm1") as chain:
            for values, slave, reason in (({"nosuch": 1}, 1, "no signal"), ({"data1": "x"}, 1, "takes"), ({"data1": 1}, 2, "no such slave")):
                with self.assertRaisesRegex(ectwin.Refused, reason):
                    chain.set(values, slave)
            for name, slave in (("nosuch", 1), ("data1", 0), ("data1", 2)):
                with self.assertRaises(ectwin.Refused):
                    chain.get(name, slave)

    def test_faults(self):
        with ectwin.Chain("fzm1") as chain:
            chain.fault("drop every 2")
            self.assertEqual([len(chain.frame(request(n))) for n in range(4)], [1, 0, 1, 0])
            chain.fault("off")
            self.assertEqual([len(chain.frame(request(n))) for n in range(4)], [1, 1, 1, 1])
            for fault in ("explode", "hang slave 2"):
                with self.assertRaises(ectwin.Refused):
                    chain.fault(fault)

    def test_a_power_cycle_takes_the_state_and_leaves_the_rest(self):
        with ectwin.Chain("fzm1") as chain:
            address = bytes([8, 0, 0, 0, 0x10, 0x00, 2, 0, 0, 0, 0x34, 0x12, 0, 0])  # a broadcast write of the station address
            read = bytes([7, 0, 0, 0, 0x10, 0x00, 2, 0, 0, 0, 0, 0, 0, 0])
            head = request()[:14] + bytes([14, 0x10])
            chain.frame(head + address + bytes(30))
            self.assertEqual(chain.frame(head + read + bytes(30))[0].frame[26:28], b"\x34\x12")
            chain.power_cycle(now_ns=MS)
            self.assertEqual(chain.frame(head + read + bytes(30))[0].frame[26:28], b"\x00\x00")

    def test_a_store_outlasts_the_chain(self):
        with tempfile.TemporaryDirectory() as folder:
            with ectwin.Chain("fzm1", store=folder):
                pass
            self.assertIn("fzm1-1.sii", os.listdir(folder))


class Plants(unittest.TestCase):
    def test_a_plant_is_called_at_its_exact_times(self):
        times = []
        with ectwin.Chain("fzm1,fzm1", ["--set", "data1=4"], now_ns=7 * MS) as chain:
            def half(now, values):
                times.append((round(now * 1000, 6), chain.now_ns))
                return {"2:data1": values["data1"] / 2, "data2": values[(2, "data2")]}

            chain.attach(ectwin.Plant(half, ["data1", (2, "data2")], ["2:data1", "data2"], period=0.002))
            self.assertEqual((times, chain.get("data1", 2), chain.next_ns), ([(0, 7 * MS)], "2", 9 * MS))
            chain.set({"data1": 6}, now_ns=8 * MS)
            chain.run(9 * MS - 1)
            self.assertEqual(chain.get("data1", 2), "2")
            chain.frame(request(), now_ns=13 * MS)  # the calls that are due come before the frame
            self.assertEqual(times[1:], [(2, 9 * MS), (4, 11 * MS), (6, 13 * MS)])
            self.assertEqual(chain.get("data1", 2), "3")

    def test_a_camera_is_called_at_each_image_input(self):
        images = []
        with ectwin.Chain("fzm1,fzm1") as chain:
            chain.run(1000 * MS)
            chain.attach(ectwin.camera(lambda now, scene: (images.append(now) or len(images) > 1, [7.5, scene]), slave=2))
            for wanted in (("7.5", "1"), ("7.5", "0")):
                chain.set({"trigger": 1}, slave=2)
                chain.run(chain.now_ns + 1)
                chain.run(chain.now_ns + 100 * MS)
                self.assertEqual((chain.get("result1", 2), chain.get("or", 2)), wanted)
            self.assertEqual(len(images), 2)

    def test_plants_of_one_time_are_called_in_the_order_of_their_attachment(self):
        calls = []
        with ectwin.Chain("fzm1") as chain:
            for name, period in (("a", 0.002), ("b", 0.001)):
                chain.attach(ectwin.Plant(lambda now, values, name=name: calls.append(name), ["data1"], period=period))
            chain.run(2 * MS)
        self.assertEqual("".join(calls), "ab" + "b" + "ab")

    def test_what_does_not_fit_is_refused_in_one_line(self):
        with ectwin.Chain("fzm1") as chain:
            for reads, writes, result, reason in (
                (["nosuch"], [], None, "no signal 'nosuch'"),
                (["comment1"], [], None, "comment1 is a text"),
                ([], ["nosuch"], None, "no signal 'nosuch'"),
                ([], ["busy"], None, "the twin's own"),
                ([], ["data1"], {"data2": 1}, "'data2' is not among its writes: data1"),
                (["data1"], [], {"data2": 1}, "not among its writes: none"),
                ([], ["data1"], {"data1": "x"}, "finite numbers"),
                ([], ["data1"], {"data1": float("nan")}, "finite numbers"),
                ([], ["data1"], [1], "not list"),
                ([], ["data1"], {"data1": 1e12}, "data1 takes"),
            ):
                with self.assertRaisesRegex(ectwin.Error, reason):
                    chain.attach(ectwin.Plant(lambda now, values, result=result: result, reads, writes))
        for arguments, reason in (({}, "reads or sets"), ({"reads": ["data1"], "period": 0}, "0.0001 to 2000 s, not 0")):
            with self.assertRaisesRegex(ectwin.Error, reason):
                ectwin.Plant(lambda now, values: None, **arguments)
        with self.assertRaisesRegex(ectwin.Error, "call attach"):
            ectwin.Plant(lambda now, values: None, ["data1"]).serve()


class Errors(unittest.TestCase):
    def test_wrong_words_are_refused_with_the_reason(self):
        for devices, options, reason in (
            ("nosuch", [], "nosuch"),
            ("fzm1", ["--nosuch"], "'--nosuch' is no option"),
            ("fzm1", ["--drop", "101"], "--drop takes"),
            ("fzm1", ["--set", "nosuch=1"], "nosuch"),
        ):
            with self.assertRaisesRegex(ectwin.Refused, reason):
                ectwin.Chain(devices, options)

    def test_a_closed_chain_refuses_calls(self):
        chain = ectwin.Chain("fzm1")
        chain.close()
        chain.close()
        for call in (lambda: chain.frame(request()), chain.run, lambda: chain.get("data1"), lambda: len(chain)):
            with self.assertRaisesRegex(ectwin.Error, "closed"):
                call()

    def test_a_library_that_is_not_there_is_named(self):
        with self.assertRaisesRegex(ectwin.Error, "/nonexistent.so.*install ectwin"):
            ectwin.Chain("fzm1", library="/nonexistent.so")

    def test_the_library_is_found_beside_the_command(self):
        environment = {name: value for name, value in os.environ.items() if name != "ECTWIN_LIBRARY"}
        environment["ECTWIN"] = os.path.join(os.path.dirname(os.environ["ECTWIN_LIBRARY"]), "ectwin")
        code = "import ectwin; print(ectwin.Chain('fzm1').version)"
        result = subprocess.run([sys.executable, "-c", code], env=dict(environment, PYTHONPATH=os.path.join(ROOT, "python")), capture_output=True, text=True)
        self.assertRegex(result.stdout, r"^\d+\.\d+\.\d+$", result.stderr)


if __name__ == "__main__":
    unittest.main()
