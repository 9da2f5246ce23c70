#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A base unit over Modbus TCP, with pymodbus, a client independent of ectwin (TS-0007 chapter 5.2).

usage: ectwin with --modbus 0 DEVICE -- test_modbus.py DEVICE INTERFACE [CASE...]

Nothing in here has to happen within a time: what takes a while is waited for. Exit code 77: there is no pymodbus.
"""

import glob
import os
import socket
import struct
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
import ectwin  # noqa: E402

sys.path[:0] = glob.glob(os.path.expanduser("~/.cache/ectwin/pymodbus-*.whl"))
try:
    from pymodbus.client import ModbusTcpClient
except ImportError:
    print("skipped: no pymodbus here; 'tools/bootstrap.sh test' fetches it where PyPI can be reached")
    sys.exit(77)

PATIENCE = 120  # seconds for what comes by itself
HOST, PORT = os.environ["ECTWIN_MODBUS"].rsplit(":", 1)
SIZES = {"vr-bu-ect-map1": (66, 0), "vr-bu-ect-map3": (66, 24), "vr-bu-ect-map7": (66, 228), "vr-bu-ect-multiarm": (142, 228)}
DEVICE = sys.argv[1]
INTERFACE = sys.argv[2]
INPUTS, OUTPUTS = SIZES[DEVICE]
NO_FUNCTION, NO_ADDRESS, BAD_VALUE, BUSY = 1, 2, 3, 6
DISARMED, ARMED, LINK_ERROR = 0x10, 0x11, 0x02
REMOTE, STRIDE, MIRROR = 28, 38, 2048


def is_number(byte):
    """Whether two bytes of the input data are a field of 16 bits (chapter 8)."""
    of_remote = (byte - REMOTE) % STRIDE
    return byte == 4 if byte < REMOTE else of_remote == 0 or 10 <= of_remote < 34 or of_remote == 36


def as_registers(data):
    """Input data as chapter 5.2 puts them into registers."""
    return [struct.unpack_from(">H" if is_number(at) else "<H", data, at)[0] for at in range(0, len(data), 2)]


def as_bytes(registers):
    """Bytes that came two in a register, the first one in the lower half."""
    return struct.pack(f"<{len(registers)}H", *registers)


class Raw:
    """A connection on which anything can be sent."""

    def __init__(self):
        self.socket = socket.create_connection((HOST, int(PORT)), PATIENCE)

    def send(self, hexadecimal):
        self.socket.sendall(bytes.fromhex(hexadecimal))

    def receive(self):
        """The next answer as hexadecimal digits; "" when the connection is over."""
        try:
            header = self._exactly(6)
            return (header + self._exactly(int.from_bytes(header[4:], "big"))).hex(" ")
        except (EOFError, ConnectionResetError, BrokenPipeError):
            return ""

    def _exactly(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise EOFError
            data += more
        return data

    def close(self):
        self.socket.close()


class Master:
    """The part of an EtherCAT master that brings one slave to OP. It does not mind being slow."""

    MANAGERS = ((0x4000, 276, 0x26), (0x4800, 276, 0x22), (0x1000, OUTPUTS, 0x64), (0x2800, INPUTS, 0x20))

    def __init__(self):
        self.wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
        self.wire.bind((INTERFACE, 0x88A4))
        self.wire.settimeout(PATIENCE)
        self.index = 0

    def datagram(self, command, register, data):
        """The data as they come back."""
        self.index = (self.index + 1) % 256
        body = struct.pack("<BBHHHH", command, self.index, 0, register, len(data), 0) + data + bytes(2)
        frame = b"\xff" * 6 + b"\x02\x00\x00\x00\x00\x01\x88\xa4" + struct.pack("<H", 0x1000 | len(body)) + body
        self.wire.send(frame.ljust(60, b"\0"))
        while True:
            answer = self.wire.recv(2048)
            if answer[17] == self.index and answer[6] & 2 and answer[16] == command:
                return answer[26 : 26 + len(data)]

    def write(self, register, data):
        self.datagram(2, register, data)  # APWR

    def read(self, register, size):
        return self.datagram(1, register, bytes(size))  # APRD

    def state(self, wanted):
        """Asks for an AL state. @return AL status and its code"""
        self.write(0x0120, struct.pack("<H", wanted))
        for _ in range(1000):
            status, _, code = struct.unpack("<HHH", self.read(0x0130, 6))
            if status & 0x10 or status == wanted & 0x0F:
                return status, code
            time.sleep(0.01)
        raise AssertionError(f"the slave stays at AL status 0x{status:02X}")

    def to_safeop(self):
        self.state(0x11)
        self.write(0x0420, bytes(2))  # no watchdog: this master is slow
        for number, (start, length, control) in enumerate(self.MANAGERS):
            self.write(0x0800 + 8 * number, struct.pack("<HHBBBB", start, length, control, 0, length > 0, 0))
        for wanted in (2, 4):
            assert self.state(wanted) == (wanted, 0)

    def outputs(self, data):
        self.write(0x1000, data)

    def close(self):
        self.wire.close()


class Case(unittest.TestCase):
    """A client that acts as the controller of the mode, and the operator."""

    def setUp(self):
        self.twin = ectwin.connect()
        self.addCleanup(self.twin.close)
        self.twin.set({"bu.restart": 1})
        self.twin.set({f"ru{n}.{name}": 0 for n in range(1, 9) for name in ("on", "stop", "disabled")})
        self.twin.set({f"ru{n}.id": n for n in range(1, 9)})
        self.client = self.connect()
        self.pco = self.cco = self.cao = 0

    def connect(self):
        client = ModbusTcpClient(HOST, port=int(PORT), timeout=PATIENCE, retries=0)
        self.until(client.connect, "a connection: those of the case before are over")
        self.addCleanup(client.close)
        return client

    def until(self, done, what):
        """Waits for something that comes by itself."""
        end = time.monotonic() + PATIENCE
        while not (result := done()):
            self.assertLess(time.monotonic(), end, f"this did not come: {what}")
            time.sleep(0.02)
        return result

    def good(self, response):
        self.assertFalse(response.isError(), response)
        return response

    def refused(self, response, code):
        self.assertTrue(response.isError(), f"expected exception {code}, got {response}")
        self.assertEqual(response.exception_code, code, response)

    def inputs(self):
        return self.good(self.client.read_input_registers(0, count=INPUTS // 2)).registers

    def step(self):
        """A controller's cycle. @return the input registers"""
        self.pco = (self.pco + 1) % 256
        if OUTPUTS > 0:
            self.good(self.client.write_registers(0, [self.cco << 8 | self.pco, self.cao << 8]))
        return self.inputs()

    def work_until(self, done, what):
        def cycle():
            registers = self.step()
            return registers if done(registers) else None

        return self.until(cycle, what)

    def in_order(self):
        return self.work_until(lambda r: r[11] & 0xFF in (DISARMED, ARMED), "BU state Disarmed or Armed")


class Tables(Case):
    def remote(self, number):
        """The data that chapter 8 defines for an armed remote, from its signals."""
        value = {name.split(".")[1]: v for name, v in self.twin.values(f"ru{number}.*").items()}
        numbers = [value[f"joystick{i}"] for i in range(1, 5)] + [value[f"switch{i}"] for i in range(1, 9)]
        names = ("state", "battery", "rssi", "cable", "docked", "disabled", "c_link", "g_link")
        return (
            struct.pack(">H8B", value["id"], *(value[name] for name in names))
            + struct.pack(">12h", *numbers)
            + bytes([value["encoder"], value["encoder_switch"], 0, 0])
        )

    def expected(self, command, armed):
        """The input data that chapter 8 defines, from the signals. The signals know the counter of the command only."""
        bu = {name.split(".")[1]: v for name, v in self.twin.values("bu.*").items()}
        head = bytes([bu[name] for name in ("pci", "cci", "pai", "cai")]) + command
        head += bytes([bu[name] for name in ("state", "vlaps", "unarmed", "eg_link", "ec_link")]) + bytes(1)
        return as_registers((head + b"".join(self.remote(n) for n in armed)).ljust(INPUTS, b"\0"))

    # ECL-070 ECL-071 EC-C3 EC-C17: every input register, its mirror and every discrete input agree with the signals
    def test_every_input_against_the_signals(self):
        armed = (1, 2, 3) if DEVICE == "vr-bu-ect-multiarm" else (1,)
        self.in_order()
        for n in armed:
            self.twin.set({f"ru{n}.id": 0x1230 + n, f"ru{n}.on": 1})
            self.until(lambda n=n: self.step() and self.arm(n), f"ru{n} is armed")
            self.twin.set({f"ru{n}.battery": 40 + n, f"ru{n}.rssi": 50 + n, f"ru{n}.docked": 1, f"ru{n}.encoder": 250 + n})
            self.twin.set({f"ru{n}.encoder_switch": 1, f"ru{n}.joystick1": -1000, f"ru{n}.joystick2": 258 + n})
            self.twin.set({f"ru{n}.fitted3": 3, f"ru{n}.switch3": -1, f"ru{n}.fitted8": 4, f"ru{n}.switch8": 513})
        command = bytes(18)
        if OUTPUTS > 0:
            self.twin.command("ru1", bytes(range(0xA0, 0xB0)))
            command = struct.pack(">H", 0x1231) + bytes(range(0xA0, 0xB0))
            self.cao = self.work_until(lambda r: r[2] != 0, "a command")[0] >> 8
        got = wanted = None
        for _ in range(500):
            self.step()
            got = self.until(self.of_this_step, "an update")
            mirror = self.good(self.client.read_holding_registers(MIRROR, count=INPUTS // 2)).registers
            wanted = self.expected(command, armed)
            bits = self.good(self.client.read_discrete_inputs(0, count=INPUTS * 8)).bits[: INPUTS * 8]
            again = self.inputs()
            if got == mirror == wanted == again:  # no update came in between
                break
        self.assertEqual([hex(r) for r in got], [hex(r) for r in wanted])
        self.assertEqual(mirror, wanted)
        data = b"".join(struct.pack(">H" if is_number(2 * i) else "<H", r) for i, r in enumerate(got))
        self.assertEqual(bits, [bool(data[i // 8] >> i % 8 & 1) for i in range(INPUTS * 8)])

    def of_this_step(self):
        registers = self.inputs()
        return registers if OUTPUTS == 0 or registers[1] & 0xFF == self.pco else None

    def arm(self, n):
        try:
            self.twin.set({f"ru{n}.armed": 1})
        except ectwin.Refused:
            return False
        return True

    # ECL-070 ECL-071 EC-C2 EC-C20: where the tables end, and what cannot be written
    def test_limits(self):
        read = {
            "coils": (self.client.read_coils, OUTPUTS * 8, 0),
            "discrete inputs": (self.client.read_discrete_inputs, INPUTS * 8, 0),
            "input registers": (self.client.read_input_registers, INPUTS // 2, 0),
            "outputs": (self.client.read_holding_registers, OUTPUTS // 2, 0),
            "inputs, mirrored": (self.client.read_holding_registers, INPUTS // 2, MIRROR),
        }
        for name, (function, count, first) in read.items():
            with self.subTest(name):
                if count > 0:
                    self.good(function(first, count=min(count, 2000)))
                    self.good(function(first + count - 1, count=1))
                self.refused(function(first + count, count=1), NO_ADDRESS)
        self.refused(self.client.read_holding_registers(MIRROR - 1, count=2), NO_ADDRESS)
        self.refused(self.client.write_register(MIRROR, 1), NO_ADDRESS)
        self.refused(self.client.write_register(OUTPUTS // 2, 1), NO_ADDRESS)
        self.refused(self.client.write_coil(OUTPUTS * 8, True), NO_ADDRESS)
        self.refused(self.client.mask_write_register(address=0), NO_FUNCTION)
        self.refused(self.client.read_device_information(), NO_FUNCTION)


class Outputs(Case):
    # ECL-070 ECL-071 EC-C17: written values can be read, as registers and as coils
    def test_written_and_read_back(self):
        values = [0, 0] + [(0x1F0D * i + 7) & 0xFFFF for i in range(2, OUTPUTS // 2)]
        self.good(self.client.write_registers(0, values))
        self.assertEqual(self.good(self.client.read_holding_registers(0, count=OUTPUTS // 2)).registers, values)
        numbers = (2, 11, 12)  # Command RU ID, spare, periodic data size
        data = b"".join(struct.pack(">H" if i in numbers else "<H", r) for i, r in enumerate(values))
        coils = self.good(self.client.read_coils(0, count=OUTPUTS * 8)).bits[: OUTPUTS * 8]
        self.assertEqual(coils, [bool(data[i // 8] >> i % 8 & 1) for i in range(OUTPUTS * 8)])
        self.good(self.client.write_coils(48, [True, False] * 8))
        self.assertEqual(self.good(self.client.read_holding_registers(3, count=1)).registers, [0x5555])
        self.good(self.client.write_coil(49, True))
        self.good(self.client.write_register(4, 0xABCD))
        both = self.client.readwrite_registers(read_address=3, read_count=3, write_address=5, values=[0x1234])
        self.assertEqual(self.good(both).registers, [0x5557, 0xABCD, 0x1234])

    # ECL-023 ECL-024 ECL-026 ECL-050 ECL-051 EC-C8: commands both ways, by CCO and CAI, by CCI and CAO
    def test_commands_both_ways(self):
        data = bytes(range(1, 17))
        self.in_order()
        self.twin.set({"ru2.on": 1, "ru3.on": 1})
        self.good(self.client.write_registers(2, [2] + [r[0] for r in struct.iter_unpack("<H", data)]))
        self.cco = 1
        self.work_until(lambda r: r[1] >> 8 == 1, "CAI")
        self.until(lambda: self.step() and self.twin.get("ru2.received_count") == 1, "the command at ru2")
        self.assertEqual(self.twin.get("ru2.received"), data.hex())
        self.assertEqual(self.twin.get("ru3.received_count"), 0)
        for number in range(1, 4):
            self.twin.command("ru3", bytes([number] * 16))
        for number in range(1, 4):
            registers = self.work_until(lambda r, n=number: r[0] >> 8 == n, f"CCI {number}")
            self.assertEqual(registers[2], 3)
            self.assertEqual(as_bytes(registers[3:11]), bytes([number] * 16))
            self.cao = number

    # ECL-054 ECL-059: periodic data in two blocks
    def test_periodic_data(self):
        if OUTPUTS < 228:
            self.skipTest("this mode has no periodic data")
        self.in_order()
        data = os.urandom(400)
        for block in range(2):
            self.pco = (self.pco + 1) % 256
            registers = [self.pco] + [0] * 11 + [399, block]
            registers += [r[0] for r in struct.iter_unpack("<H", data[200 * block : 200 * block + 200])]
            self.good(self.client.write_registers(0, registers))
        self.assertEqual(self.twin.get("bu.periodic_sets"), 1)
        self.assertEqual(self.twin.get("bu.periodic_size"), 399)


class Supervision(Case):
    # ECL-018 ECL-019 ECL-066: No Data until the controller does its duty; when it dies the relays open
    def test_from_nothing_to_order_and_back(self):
        self.assertEqual(self.twin.get("bu.message"), "EC: No Data")
        self.assertEqual(self.twin.get("bu.es_link"), 0)
        self.in_order()
        self.until(lambda: self.step() and self.twin.get("bu.es_link") == 1, "closed relays")
        self.client.close()
        self.twin.wait_for("bu.modbus", 0, timeout=PATIENCE)
        self.assertEqual(self.twin.get("bu.state"), LINK_ERROR)
        self.assertEqual(self.twin.get("bu.es_link"), 0)
        self.client = self.connect()
        self.in_order()

    # ECL-057 ECL-067: the controller works on, but PCO stands still
    def test_pco_stands_still(self):
        if OUTPUTS < 228:
            self.skipTest("this mode has no PCO")
        self.in_order()

        def bad():
            self.good(self.client.write_register(0, self.pco))
            return self.twin.get("bu.message") == "EC: Bad data"

        self.until(bad, "Bad data")
        self.in_order()

    # ECL-002: in mode Disabled there is no reply
    def test_disabled(self):
        raw = Raw()
        self.addCleanup(raw.close)
        raw.send("00 00 00 00 00 06 01 04 00 00 00 01")
        self.assertNotEqual(raw.receive(), "")
        self.twin.set({"bu.enabled": 0})
        self.addCleanup(self.twin.set, {"bu.enabled": 1})
        raw.send("00 01 00 00 00 06 01 04 00 00 00 01")
        raw.socket.settimeout(0.3)
        with self.assertRaises(TimeoutError):
            raw.receive()
        self.twin.set({"bu.enabled": 1})
        raw.socket.settimeout(PATIENCE)
        raw.send("00 02 00 00 00 06 01 04 00 00 00 01")
        self.assertTrue(raw.receive().startswith("00 02 00 00 00 05 01 04 02"))


class Attacks(Case):
    READ = "12 34 00 00 00 06 01 04 00 0d 00 01"

    def raw(self):
        raw = Raw()
        self.addCleanup(raw.close)
        return raw

    def answers(self, raw):
        raw.send(self.READ)
        return raw.receive().startswith("12 34 00 00 00 05 01 04 02 0")

    # ECL-070: every function code, lengths, unit identifiers
    def test_requests_that_are_wrong(self):
        raw = self.raw()
        for code in set(range(0x80)) - {1, 2, 3, 4, 5, 6, 15, 16, 23}:
            raw.send(f"00 {code:02x} 00 00 00 02 01 {code:02x}")
            self.assertEqual(raw.receive(), f"00 {code:02x} 00 00 00 03 01 {code | 0x80:02x} 01")
        for code, wrong in {1: "00 00", 3: "00 00 00 00", 4: "00 00 00 7e", 5: "00 00 12 34", 16: "00 00 00 01 03 00 00 00"}.items():
            data = bytes.fromhex(wrong)
            raw.send(f"00 00 00 00 00 {2 + len(data):02x} 01 {code:02x} {wrong}")
            self.assertEqual(raw.receive(), f"00 00 00 00 00 03 01 {code | 0x80:02x} 03")
        for unit in (0, 1, 17, 247, 255):
            raw.send(f"00 07 00 00 00 06 {unit:02x} 04 00 0d 00 01")
            self.assertTrue(raw.receive().startswith(f"00 07 00 00 00 05 {unit:02x} 04 02"))

    # ECL-070: half a request is kept until its rest arrives; what is none ends that connection alone
    def test_halves_and_rubbish(self):
        half, rubbish = self.raw(), self.raw()
        request = bytes.fromhex(self.READ)
        for cut in range(1, len(request)):
            half.socket.sendall(request[:cut])
            self.inputs()
            half.socket.sendall(request[cut:])
            self.assertTrue(half.receive().startswith("12 34 00 00 00 05 01 04 02"))
        rubbish.socket.sendall(b"GET / HTTP/1.1\r\n\r\n")
        self.assertEqual(rubbish.receive(), "")
        self.inputs()

    # ECL-070: of 100 connections four are served, the others end
    def test_a_hundred_connections(self):
        self.client.close()
        raws = []

        def four_at_once():
            for raw in raws:
                raw.close()
            raws[:] = [Raw() for _ in range(4)]
            return all(map(self.answers, raws))

        self.until(four_at_once, "four connections are served")
        for _ in range(96):
            late = Raw()
            self.assertEqual(late.receive(), "")
            late.close()
        self.assertTrue(all(map(self.answers, raws)))
        for raw in raws:
            raw.close()

    # A client that floods and does not read does not block other clients
    def test_flood(self):
        flood = self.raw()
        flood.socket.setblocking(False)
        sent = 0
        try:
            while sent < 4 << 20:
                sent += flood.socket.send(bytes.fromhex(self.READ) * 100)
        except BlockingIOError:
            pass
        self.in_order() if OUTPUTS > 0 else self.inputs()
        flood.close()


class BothSides(Case):
    def setUp(self):
        super().setUp()
        self.master = Master()
        self.addCleanup(self.master.close)
        self.master.to_safeop()

    # The owner keeps the unit: EtherCAT in OP
    def test_ethercat_has_it(self):
        self.master.outputs(bytes(OUTPUTS))
        self.assertEqual(self.master.state(8), (8, 0))
        self.refused(self.client.write_register(0, 1), BUSY)
        self.refused(self.client.write_coil(0, True), BUSY)
        self.master.outputs(bytes([5, 0, 0, 0]).ljust(OUTPUTS, b"\0"))
        written = lambda: self.good(self.client.read_holding_registers(0, count=1)).registers == [5]  # noqa: E731
        self.until(written, "what EtherCAT has written")
        left = time.monotonic()
        self.assertEqual(self.master.state(4), (4, 0))
        self.refused(self.client.write_register(0, 1), BUSY)
        taken = lambda: not self.client.write_register(0, 1).isError()  # noqa: E731
        self.until(taken, "the end of the 2000 ms that the EtherCAT master keeps the unit")
        self.assertGreater(time.monotonic() - left, 1.9)
        self.in_order()

    # The owner keeps the unit: a Modbus controller that writes
    def test_modbus_has_it(self):
        for _ in range(100):
            self.in_order()
            begin = time.monotonic()
            self.step()
            self.master.outputs(bytes(OUTPUTS))
            got = self.master.state(8)
            if time.monotonic() - begin < 1.5:  # else Modbus had stopped by then
                break
            self.master.state(0x14)
        self.assertEqual(got, (0x14, 1))
        self.assertEqual(self.master.state(0x14), (4, 0))
        self.twin.wait_for("bu.modbus", 0, timeout=PATIENCE)
        self.master.outputs(bytes(OUTPUTS))
        self.assertEqual(self.master.state(8), (8, 0))
        self.assertEqual(self.master.state(1), (1, 0))


if __name__ == "__main__":
    cases = [Tables, Supervision, Attacks] + ([Outputs, BothSides] if OUTPUTS > 0 else [])
    loader = unittest.TestLoader()
    loader.testNamePatterns = [f"*{name}*" for name in sys.argv[3:]] or None
    suite = unittest.TestSuite(map(loader.loadTestsFromTestCase, cases))
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful())
