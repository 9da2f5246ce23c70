#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The server of `ectwin panel`: pages, token, Origin and Host, requests, hostile clients.

usage: panel.py ECTWIN [CASE]
"""
import base64
import contextlib
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

ECTWIN = sys.argv[1]
failed = False


def check(title, expected, actual):
    global failed
    if expected != actual:
        failed = True
        print(f"FAILED {title}\n  expected: {expected!r}\n  got:      {actual!r}")


class Panel:
    """The program while it runs."""

    def __init__(self, *options, command=None):
        self.process = subprocess.Popen(command or [ECTWIN, "panel", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.url = json.loads(self.process.stdout.readline())["url"]
        self.base, self.token = self.url.split("/#")
        self.port = int(self.base.rsplit(":", 1)[1])

    def get(self, path, method="GET", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        connection.request(method, path, headers=headers)
        reply = connection.getresponse()
        reply.text = reply.read()
        connection.close()
        return reply

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def wait_for_descriptors(self, number):
        """Waits until the program has so many, or two minutes. Returns their number."""
        deadline = time.monotonic() + 120
        while self.descriptors() != number and time.monotonic() < deadline:
            time.sleep(0.05)
        return self.descriptors()

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        text = self.process.communicate(timeout=120)[1]
        return self.process.returncode, text


class Page:
    """A WebSocket connection; `token` None: none is sent."""

    def __init__(self, panel, token=None, **headers):
        self.panel = panel
        self.socket = socket.create_connection(("127.0.0.1", panel.port), timeout=120)
        key = base64.b64encode(os.urandom(16)).decode()
        lines = {"Host": f"127.0.0.1:{panel.port}", "Origin": panel.base, "Upgrade": "websocket", "Connection": "Upgrade",
                 "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": "13", "Sec-WebSocket-Protocol": "ectwin-panel", **headers}
        self.socket.sendall(("GET / HTTP/1.1\r\n" + "".join(f"{n}: {v}\r\n" for n, v in lines.items() if v) + "\r\n").encode())
        self.received = b""
        self.replies, self.pings = True, 0
        self.ping_contents = set()
        self.kept = []
        self.status = self._head()
        if token is not None and self.status == 101:
            self.send({"token": token})

    def _more(self):
        try:
            piece = self.socket.recv(65536)
        except ConnectionError:
            piece = b""
        self.received += piece
        return piece != b""

    def _head(self):
        while b"\r\n\r\n" not in self.received:
            if not self._more():
                return 0
        head, self.received = self.received.split(b"\r\n\r\n", 1)
        return int(head.split()[1])

    def frame(self, opcode, content, last=True):
        size = struct.pack("!B", 0x80 | len(content)) if len(content) < 126 else struct.pack("!BH", 0x80 | 126, len(content))
        mask = os.urandom(4)
        self.socket.sendall(bytes([0x80 * last | opcode]) + size + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(content)))

    def send(self, message):
        self.frame(1, (message if isinstance(message, str) else json.dumps(message)).encode())

    def next(self):
        """The next message; None: the connection has ended."""
        while True:
            data = self.received
            if len(data) >= 2:
                length, at = data[1] & 127, 2
                if length == 126 and len(data) >= 4:
                    length, at = struct.unpack("!H", data[2:4])[0], 4
                elif length == 126:
                    length = 1 << 20
                if len(data) >= at + length:
                    self.received = data[at + length:]
                    if data[0] & 15 == 1:
                        return json.loads(data[at:at + length])
                    if data[0] & 15 == 8:
                        return None
                    if data[0] & 15 == 9:
                        self.pings += 1
                        self.ping_contents.add(data[at:at + length])
                        if self.replies:
                            self.frame(10, data[at:at + length])
                    continue
            if not self._more():
                return None

    def wait(self, event, fits=lambda message: True):
        """The next message of a kind."""
        while True:
            message = self.next()
            if message is None or (message["event"] == event and fits(message)):
                return message

    def open(self, devices):
        """Opens the bus with these devices. Returns its number, and its signals by slave and name."""
        buses = self.wait("buses", lambda m: any(b["about"].get("devices") == devices for b in m["buses"]))["buses"]
        bus = next(b["bus"] for b in buses if b["about"].get("devices") == devices)
        return bus, self.open_bus(bus)

    def open_bus(self, bus):
        """Opens a bus. Returns its signals by slave and name."""
        self.send({"open": bus})
        signals = []
        while True:
            message = self.wait("signals")
            signals += message["signals"]
            if len(signals) == message["of"]:
                return {(s["slave"], s["name"]): i for i, s in enumerate(signals)}

    def request(self, bus, request, number=1, **more):
        self.send({"id": number, "bus": bus, "request": request, **more})
        return self.wait("reply", lambda m: m["id"] == number)["reply"]

    def value(self, index, value):
        """Waits until a signal has a value."""
        return self.wait("values", lambda m: [index, value] in m["values"]) is not None


@contextlib.contextmanager
def twins(devices, *options):
    process = subprocess.Popen([ECTWIN, "with", *options, devices, "--", "sh", "-c", "echo; exec sleep 600"], stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL)
    process.stdout.readline()
    yield
    process.terminate()
    process.wait(120)


@contextlib.contextmanager
def running(*options, command=None):
    panel = Panel("--port", "0", *options, command=command)
    try:
        yield panel
    finally:
        status, panel.errors = panel.stop()
        check("the panel ends with status 0 at SIGTERM", 0, status)


def pages():
    with running() as panel:
        page = panel.get("/")
        check("the page is served", (200, True), (page.status, b"<title>" in page.text))
        check("pages may load and run nothing else", "default-src 'none'; script-src 'self'; style-src 'self'",
              page.headers["content-security-policy"][:55])
        folder = pathlib.Path(__file__).resolve().parents[2] / "programs/ectwin-panel/page"
        check("each file of the page is served whole", [],
              [file.name for file in folder.iterdir()
               if panel.get("/" if file.name == "index.html" else f"/{file.name}").text != file.read_bytes()])
        connection = http.client.HTTPConnection("127.0.0.1", panel.port, timeout=120)
        replies = []
        for name in ("panel.css", "nothing", "main.js", "icon.svg"):
            connection.request("GET", f"/{name}")
            reply = connection.getresponse()
            replies.append((reply.status, len(reply.read())))
        connection.close()
        check("a connection takes several requests", [(200, (folder / "panel.css").stat().st_size), (404, 0),
                                                      (200, (folder / "main.js").stat().st_size), (200, (folder / "icon.svg").stat().st_size)], replies)
        check("no script and no style is inline", False, b"style=" in page.text or b"<style" in page.text or b"<script>" in page.text)
        check("types are not guessed", "nosniff", page.headers["x-content-type-options"])
        check("nothing is kept", "no-store", page.headers["cache-control"])
        check("no file of the machine is served", [404] * 3, [panel.get(p).status for p in ("/../etc/passwd", "/%2e%2e/etc", "/panel")])
        check("GET alone", [405] * 2, [panel.get("/", m).status for m in ("POST", "PUT")])
        check("the page needs no token, and has none", False, panel.token.encode() in page.text)
        check("SEC: a name that leads to this machine is refused (DNS rebinding)", [403, 403, 403],
              [panel.get("/", Host=h).status for h in (f"evil.example:{panel.port}", "127.0.0.1", f"127.0.0.1.evil.example:{panel.port}")])
        check("localhost is this machine", 200, panel.get("/", Host=f"localhost:{panel.port}").status)
    first = Panel()
    again = subprocess.run([ECTWIN, "panel", "--port", str(first.port)], capture_output=True, text=True)
    check("a port that is taken: status 2 and a line", (2, True), (again.returncode, "cannot listen at 127.0.0.1" in again.stderr))
    first.stop()
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    reader, writer = os.pipe()
    os.close(reader)
    unread = subprocess.Popen([ECTWIN, "panel", "--port", str(port)], stdout=writer, stderr=subprocess.DEVNULL)
    os.close(writer)
    served, deadline = None, time.monotonic() + 120
    while served is None and unread.poll() is None and time.monotonic() < deadline:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=120) as one:
            one.sendall(f"GET /icon.svg HTTP/1.0\r\nHost: localhost:{port}\r\n\r\n".encode())
            served = one.recv(15)
    check("a reader of its line that has ended does not end the panel", b"HTTP/1.0 200 OK", served)
    unread.terminate()
    check("its status at SIGTERM is 0 all the same", 0, unread.wait(120))
    wrong = subprocess.run([ECTWIN, "panel", "--bind", "example.org"], capture_output=True, text=True)
    check("a name is no address", 1, wrong.returncode)
    with tempfile.TemporaryDirectory() as folder:
        alone = shutil.copy(ECTWIN, folder)
        lacking = subprocess.run([alone, "panel"], capture_output=True, text=True, env={"PATH": folder})
        check("without ectwin-panel: status 2 and the cure", (2, True), (lacking.returncode, "install libwebsockets-dev" in lacking.stderr))
        check("its help is there all the same", 0, subprocess.run([alone, "panel", "--help"], stdout=subprocess.DEVNULL, env={"PATH": folder}).returncode)
    refused = subprocess.run([ECTWIN, "panel", "x"], capture_output=True, text=True)
    check("an argument: status 1 and a line", (1, "ectwin panel: it takes no argument"), (refused.returncode, refused.stderr.split("\n")[0]))
    version = subprocess.run([ECTWIN, "panel", "--version"], capture_output=True, text=True).stdout
    check("its version is that of ectwin", subprocess.run([ECTWIN, "--version"], capture_output=True, text=True).stdout.split()[1:],
          version.split()[1:])
    with running("--open", "--view", "--bind", "127.0.0.2") as panel:
        check("each option is read, whatever follows it", "http://127.0.0.2", panel.base.rsplit(":", 1)[0])
    with running("--bind", "127.0.0.1", "--view") as panel:
        check("an address, then --view: no change", True, Page(panel, panel.token).wait("hello")["view"])
    with contextlib.suppress(OSError), socket.create_server(("::1", 0), family=socket.AF_INET6):  # a machine with IPv6
        with running("--bind", "::1") as panel:
            check("an address of IPv6 is in brackets", "http://[::1]", panel.base.rsplit(":", 1)[0])
    with running("--bind", "0.0.0.0") as panel:
        pass
    check("another address than this machine's: a warning", True, "everybody on the network path" in panel.errors)


def browsers():
    """--open: the URL is in a file that others cannot read, not in the arguments of the browser."""
    folder = pathlib.Path(os.environ["XDG_RUNTIME_DIR"])
    folder.joinpath("xdg-open").write_text(f"#!/bin/sh\nstat -c %a \"$1\" >{folder}/mode\ncat \"$1\" >{folder}/content\n"
                                           f"echo \"$@\" >{folder}/arguments\n")
    folder.joinpath("xdg-open").chmod(0o755)
    os.environ["PATH"] = f"{folder}:{os.environ['PATH']}"
    with twins("fzm1"), running("--open") as panel:
        arguments = folder / "arguments"
        deadline = time.monotonic() + 120
        while not (arguments.exists() and arguments.read_text()) and time.monotonic() < deadline:
            time.sleep(0.05)
        page = arguments.read_text().strip()
        check("--open: the browser gets a file with the URL", True, panel.url in (folder / "content").read_text())
        check("SEC: other users cannot read it", "600", (folder / "mode").read_text().strip())
        check("SEC: the token is not among the arguments", False, panel.token in page)
        children = pathlib.Path(f"/proc/{panel.process.pid}/task/{panel.process.pid}/children")
        while children.exists() and children.read_text() and time.monotonic() < deadline:
            time.sleep(0.05)
        check("the process of a browser that has ended is collected", True, not children.exists() or children.read_text() == "")
    check("the file is removed at the end", False, os.path.exists(page))
    path, os.environ["PATH"] = os.environ["PATH"], str(folder / "nosuch")
    with twins("fzm1"), running("--open") as panel:
        pass
    check("--open without xdg-open: a line with the cure",
          "ectwin panel: cannot run xdg-open (No such file or directory): open the URL yourself\n", panel.errors)
    os.environ["PATH"] = path
    shutil.rmtree(folder / "ectwin")
    needs_folder = "ectwin panel: --open needs the folder of a running twin: start one, or open the URL yourself\n"
    with running("--open") as panel:
        pass
    check("--open without a folder of twins: a line with the cure", needs_folder, panel.errors)
    (folder / "ectwin").mkdir()
    for mode in (0o770, 0o707):
        (folder / "ectwin").chmod(mode)
        with running("--open") as panel:
            check(f"SEC: --open writes no file to a folder of mode {mode:o}", [], list((folder / "ectwin").iterdir()))
        check(f"--open with a folder of mode {mode:o}: a line with the cure", needs_folder, panel.errors)
    (folder / "ectwin").chmod(0o700)
    (folder / "target").touch()
    (folder / "xdg-open").write_text("#!/bin/sh\n")
    for title, earlier, errors in (("a longer one of the same name", f"echo {'x' * 4096} >", ""), ("a link", f"ln -s {folder}/target ", needs_folder)):
        line = f'{earlier}"$XDG_RUNTIME_DIR/ectwin/panel-$$.html" && exec "$0" panel --open'
        with running(command=["sh", "-c", line, ECTWIN]) as panel:
            written = (folder / "ectwin" / f"panel-{panel.process.pid}.html").read_text()
            check(f"SEC: the file of --open in place of {title}", "" if errors else f"0;url={panel.url}\"><title>ectwin</title>\n",
                  written[-len(panel.url) - 30:])
        check(f"--open in place of {title}: errors", errors, panel.errors)


def tokens():
    with running() as panel, twins("fzm1"):
        check("the token opens", "hello", Page(panel, panel.token).next()["event"])
        for title, token in (("wrong", "0" * 32), ("empty", ""), ("longer", panel.token + "0"), ("no", 7)):
            check(f"SEC: a {title} token closes the connection", None, Page(panel, token).next())
        page = Page(panel)
        page.send({"open": 1})
        check("SEC: another message before the token closes the connection", None, page.next())
        for origin in ("http://evil.example", f"https://127.0.0.1:{panel.port}", "null", "", f"http://localhost:{panel.port}"):
            page = Page(panel, panel.token, Origin=origin)
            check(f"SEC: a page of {origin or 'no origin'} is refused", False, page.status == 101)
        page = Page(panel, panel.token, Host=f"evil.example:{panel.port}", Origin=f"http://evil.example:{panel.port}")
        check("SEC: a page under another name of this machine is refused", False, page.status == 101)


def confined():
    """The rights and system calls of the server."""
    with running() as panel:
        lines = pathlib.Path(f"/proc/{panel.process.pid}/status").read_text().splitlines()
        status = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
        check("SEC: no capability, and no program can give one", ("0000000000000000", "1"), (status["CapEff"], status["NoNewPrivs"]))
        libraries = subprocess.run(["ldd", f"/proc/{panel.process.pid}/exe"], capture_output=True, text=True).stdout
        if "libseccomp" in libraries:
            check("SEC: system calls are filtered", "2", status["Seccomp"])


def signals():
    with running() as panel, twins("gripper=fzm1,pmctendo-dd5"):
        page = Page(panel, panel.token)
        hello = page.next()
        check("the panel says whether it may change anything", ("hello", False), (hello["event"], hello["view"]))
        bus, index = page.open("gripper=fzm1,pmctendo-dd5")
        check("values come", True, page.value(index[2, "friction"], 0.05))
        check("a signal is set", {"ok": True}, page.request(bus, {"op": "set", "slave": 1, "name": "data1", "value": 7}))
        check("its change comes", True, page.value(index[1, "data1"], 7))
        check("a wrong value is refused with the twin's reason", (False, True),
              (lambda r: (r["ok"], "scene" in r["message"]))(page.request(bus, {"op": "set", "slave": 1, "name": "scene", "value": 999})))
        identity = page.request(bus, {"op": "read", "slave": 1, "index": 0x1018, "sub": 1})
        check("an object below PREOP is refused in words", (False, True), (identity["ok"], "not in this AL state" in identity["message"]))
        check("the dictionary is listed", [[0x1018, 1], [0x1018, 2]],
              [[o["index"], o["sub"]] for o in page.request(bus, {"op": "objects", "slave": 1, "index": 0x1018, "sub": 1})["lines"][:2]])
        check("SEC: a page may not send other requests", False, page.request(bus, {"op": "data", "offset": 0})["ok"])
        check("an emergency", {"ok": True}, page.request(bus, {"op": "fault", "fault": "emergency 0x5530 slave 1"}))
        event = page.wait("events")["events"][-1]
        check("is in the list of events, with its words", (1, "gripper", "emergency 0x5530: device hardware"),
              (event["slave"], event["twin"], event["text"]))
        check("a bus that is not there", False, page.request(99, {"op": "fault", "fault": "off"})["ok"])
        check("a fault is set", {"ok": True}, page.request(bus, {"op": "fault", "fault": "drop 5%"}))
        check("it is in the list", ["drop 5%"], page.wait("faults", lambda m: m["faults"])["faults"])
        stats = page.wait("stats")
        check("counters come", True, stats["counters"]["frames"] >= 0 and len(stats["answers"]["answers"]) > 0)
        ready = index[1, "ready"]
        page.send({"trace": [ready]})
        page.wait("changes", lambda m: any(change[0] == ready for change in m["changes"]))
        page.request(bus, {"op": "set", "slave": 1, "name": "trigger", "value": 1})
        found = []
        while len(found) < 2:
            found += page.wait("changes")["changes"]
        check("a pulse of 5 ms arrives whole", [[ready, 0], [ready, 1]], [[signal, value] for signal, _, value in found])
        check("with the times of the twin", True, found[0][1] < found[1][1])
        page.send({"trace": []})
        other = Page(panel, panel.token)
        other.open("gripper=fzm1,pmctendo-dd5")
        check("a second page gets all values", True, other.value(index[1, "data1"], 7))
    with running("--view") as panel, twins("fzm1"):
        page = Page(panel, panel.token)
        bus, index = page.open("fzm1")
        check("--view: nothing is set", False, page.request(bus, {"op": "set", "name": "data1", "value": 1})["ok"])
        check("--view: no object is written", False, page.request(bus, {"op": "write", "index": 0x1000, "value": 1})["ok"])
        check("--view: no fault is set", False, page.request(bus, {"op": "fault", "fault": "drop"})["ok"])


def buses():
    with running() as panel:
        page = Page(panel, panel.token)
        check("without a twin the list is empty", [], page.wait("buses")["buses"])
        idle = panel.descriptors()
        with twins("fzm1", "--name", "press"):
            found = page.wait("buses", lambda m: m["buses"])["buses"][0]
            check("a twin that starts is in the list", ("press", 1), (found["about"]["name"], found["about"]["slaves"]))
            ready = page.open_bus(found["bus"])[1, "ready"]
            one = panel.descriptors()
            for signals, connections in (([ready], 1), ([], 0), ([ready], 1)):
                page.send({"trace": signals})
                check(f"a page that plots {len(signals)} signals: connections for changes", one + connections,
                      panel.wait_for_descriptors(one + connections))
            check("a camera is triggered", {"ok": True}, page.request(found["bus"], {"op": "set", "slave": 1, "name": "trigger", "value": 1}))
            check("a signal that is plotted again has its changes", True,
                  page.wait("changes", lambda m: any(change[::2] == [ready, 1] for change in m["changes"])) is not None)
        check("a twin that ends leaves it", [], page.wait("buses", lambda m: not m["buses"])["buses"])
        def names(message):
            return sorted(bus["about"].get("name", "") for bus in message["buses"])

        with twins("fzm1", "--name", "left"):
            page.wait("buses", lambda m: names(m) == ["left"])
            with twins("fzm1", "--name", "right"), twins("fzm1", "--name", "top"):
                found = page.wait("buses", lambda m: {"right", "top"} <= set(names(m)))
                check("each twin is in the list once", ["left", "right", "top"], names(found))
        check("twins that end leave it", [], page.wait("buses", lambda m: not m["buses"])["buses"])
        check("all connections to twins are closed", idle, panel.wait_for_descriptors(idle))


def hostile():
    with running() as panel, twins("fzm1"):
        good = Page(panel, panel.token)
        bus, index = good.open("fzm1")
        for title, message in (("no JSON", "{"), ("an array", "[]"), ("no id", {"request": {}}), ("a long one", " " * 5000),
                               ("no list of signals", {"trace": 1}), ("too many signals", {"trace": list(range(200))})):
            page = Page(panel, panel.token)
            page.wait("hello")
            page.send(message)
            check(f"SEC: {title} closes the connection", None, page.wait("never"))
        page = Page(panel, panel.token)
        page.wait("hello")
        page.frame(2, b"\0\1")
        check("SEC: a binary message closes the connection", None, page.wait("never"))
        page = Page(panel, panel.token)
        request = json.dumps({"id": 1, "bus": bus, "request": {"op": "set", "name": "data1", "value": 2}}).encode()
        page.frame(1, request[:7], last=False)
        page.frame(0, request[7:20], last=False)
        page.frame(0, request[20:])
        check("a message in parts is taken whole", {"ok": True}, page.wait("reply")["reply"])
        page.frame(1, b" " * 2000, last=False)
        page.frame(0, b" " * 2096, last=False)
        page.frame(0, b" ")
        check("SEC: a long one in parts closes the connection", None, page.wait("never"))
        page = Page(panel, panel.token)
        page.wait("hello")
        with contextlib.suppress(OSError):
            for n in range(5000):
                page.send({"id": n, "bus": bus, "request": {"op": "set", "name": "data1", "value": n}})
        check("SEC: requests without end close the connection", None, page.wait("never"))
        held = []
        for _ in range(300):
            held.append(socket.create_connection(("127.0.0.1", panel.port), timeout=120))
        check("SEC: 300 idle connections do not stop a page", {"ok": True},
              good.request(bus, {"op": "set", "name": "data1", "value": 3}, 5))
        check("SEC: connections are bounded", True, panel.descriptors() < 64 + 32)
        for one in held:
            one.close()
        for garbage in (b"\0" * 10000, b"GET " + b"/" * 20000, b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000, b"\r\n\r\n" * 100):
            one = socket.create_connection(("127.0.0.1", panel.port), timeout=120)
            with contextlib.suppress(OSError):
                one.sendall(garbage)
            one.close()
        check("SEC: garbage does no harm", {"ok": True}, good.request(bus, {"op": "set", "name": "data1", "value": 4}, 6))
        deadline = time.monotonic() + 120  # connections that were closed are counted out
        while time.monotonic() < deadline:
            with contextlib.suppress(OSError, http.client.HTTPException):
                if panel.get("/").status == 200:
                    break
        check("SEC: pages are served afterwards", 200, panel.get("/").status)


def patience():
    """Pages that send nothing, or receive nothing."""
    with running() as panel, twins("fzm1"):
        good = Page(panel, panel.token)
        bus, _ = good.open("fzm1")
        silent, deaf, idle = Page(panel), Page(panel, panel.token), socket.create_connection(("127.0.0.1", panel.port), timeout=120)
        deaf.wait("buses", lambda m: m["buses"])
        with contextlib.suppress(ConnectionError):  # on a busy machine its patience ends before that
            for _ in range(400):  # all signals again and again, 20 MB
                deaf.send({"open": bus})
                time.sleep(0.002)
        check("SEC: a page that does not read delays no other one", {"ok": True},
              good.request(bus, {"op": "set", "name": "data1", "value": 3}, 5))
        check("SEC: a page without a token is closed", None, silent.next())
        check("SEC: a connection without a request is closed", b"", idle.recv(1))
        time.sleep(1.5)
        with contextlib.suppress(ConnectionError):
            check("SEC: a page that does not read is closed", None, deaf.wait("never"))
        check("the others stay", {"ok": True}, good.request(bus, {"op": "set", "name": "data1", "value": 4}, 6))


def held():
    """A signal that a page holds returns to its rest without the page."""
    with running() as panel, twins("fzm1"):
        watcher = Page(panel, panel.token)
        bus, index = watcher.open("fzm1")
        data = index[1, "data1"]
        deflect = {"op": "set", "slave": 1, "name": "data1", "value": 7}

        def holder(value=7):
            page = Page(panel, panel.token)
            page.open("fzm1")
            check("SEC: a page holds a signal", {"ok": True}, page.request(bus, {**deflect, "value": value}, rest=0))
            check("SEC: the held signal has its value", True, watcher.value(data, value))
            return page

        def reads(page, pings):
            for _ in range(30):  # one of each a second
                page.wait("stats")
                if page.pings >= pings:
                    break
            return subprocess.run([ECTWIN, "get", "data1"], capture_output=True, text=True).stdout.strip()

        def returns(title):
            check(f"SEC: {title}: a held signal returns to its rest", True, watcher.value(data, 0))

        page = holder()
        page.socket.close()
        returns("the connection breaks")
        page = holder()
        page.send({"open": 0})
        returns("the page shows another bus")
        mute = holder()
        mute.replies = False
        returns("the page does not reply to pings")
        check("its connection remains", {"ok": True}, mute.request(bus, deflect, 2))
        check("a signal without rest keeps its value", True, watcher.value(data, 7))
        mute.socket.close()
        for attempt in range(10):  # on a busy machine its reply may be too late
            steady = holder(10 + attempt)
            kept = reads(steady, 5) == f"data1={10 + attempt}"
            if kept:
                break
            steady.socket.close()
        check("a page that replies to pings holds its signal", True, kept)
        check("a ping has one byte", {b"\0"}, steady.ping_contents)
        check("before the panel ends", {"ok": True}, steady.request(bus, deflect, 3, rest=0))
        panel.process.send_signal(signal.SIGTERM)
        panel.process.wait(120)
        value = subprocess.run([ECTWIN, "get", "data1"], capture_output=True, text=True).stdout.strip()
        check("SEC: the panel ends: a held signal returns to its rest", "data1=0", value)


CASES = (pages, browsers, tokens, confined, signals, buses, hostile, patience, held)


def main():
    if len(sys.argv) < 3:  # side by side: they wait most of the time
        started = [subprocess.Popen([sys.executable, __file__, ECTWIN, case.__name__]) for case in CASES]
        return max(process.wait() for process in started)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        next(case for case in CASES if case.__name__ == sys.argv[2])()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
