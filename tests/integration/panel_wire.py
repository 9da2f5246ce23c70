#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The wire on the page of `ectwin panel` in headless Chromium: process data, topology, working counters, waves, captures.

usage: panel_wire.py ECTWIN MASTER [FOLDER]      FOLDER: screenshots are written there. Exits with 77 without Chromium.
"""
import os
import pathlib
import socket
import struct
import subprocess
import sys
import time

from panel_page import ECTWIN, MASTER, accessible, becomes, bus, check, panel, reaches, run, until, value

OPEN = "const d = document.querySelector('.process-data'); d.open = true; d.scrollIntoView()"
ENTRY = "return document.querySelector('[data-entry=\"' + arguments[0] + '\"] ' + arguments[1])?.textContent"


def shows(browser, entry, value):
    """Waits for the value of an entry of the process data; returns the final content of the page."""
    browser.wait(f"const text = (() => {{ {ENTRY} }})(); return text === arguments[2]", entry, "output", value, seconds=120)
    return browser.run(ENTRY, entry, "output")


def process_data(browser, url):
    """Entries of PDOs by name, of a device of our own and of a twin from an ESI file."""
    terminal = pathlib.Path(__file__).resolve().parents[1] / "esi" / "digital.xml"
    with bus(f"camera=fzm1,inputs=esi:{terminal}#DI4", [MASTER, "{}"]):
        browser.open("about:blank")
        browser.open(url)
        check("the twins are in OP", True, reaches(browser, "OP,OP", seconds=120))
        browser.run(OPEN)
        check("FZM: an entry has the name of its object", "0.0", browser.wait(
            "return document.querySelector('.pdos tbody tr[data-entry] td') && '0.0'", seconds=120))
        names = "return [...document.querySelectorAll('.pdos th[scope=row]')].map((name) => name.textContent)"
        becomes(browser, "outputs and inputs have tables", 2, "return document.querySelectorAll('.pdos').length")
        check("FZM: a name is that of the manual", True, "Output area: Data 1" in browser.run(names))
        place = "return [...document.querySelectorAll('[data-entry=\"2300h:1\"] td')].map((cell) => cell.textContent)"
        check("its place, address and type", ["16", "2300h:1", "INTEGER32, 32"], [cell for i, cell in enumerate(browser.run(place)) if i != 2])
        subprocess.run([ECTWIN, "set", "camera.data1=-12.5", "camera.trigger=1"], check=True)
        check("a measurement is in the process data", "-12500", shows(browser, "2300h:1", "-12500"))
        browser.picture("pdos.png", "light", ".process-data")
        accessible(browser)
        browser.click("[data-select='2']")
        browser.wait("return document.querySelector('.process-data:not([open])') !== null")
        browser.run(OPEN)
        check("ESI: bits have byte and bit, behind a gap as well", ["0", "0.1", "0.3", "0.4"], browser.wait(
            "const cells = [...document.querySelectorAll('.pdos [data-entry] td:first-child')].map((cell) => cell.textContent); return cells.length === 4 && cells",
            seconds=120))
        contact = browser.run("return document.querySelector('.terminal [data-bit]').dataset.bit")
        subprocess.run([ECTWIN, "set", f"inputs.{contact}=1"], check=True)
        check("ESI: a contact is in the process data", True, browser.wait(
            "return document.querySelector('.pdos [data-entry] output').textContent === '1'", seconds=120))


def counters(browser, url):
    """Working counters of a master, whole and with a slave less."""
    with bus("gripper=fzm1,fzm1", [MASTER, "{}"]):
        browser.open("about:blank")
        browser.open(url)
        check("the slaves are in OP", True, reaches(browser, "OP,OP", seconds=120))
        counter = "return document.querySelector('[data-datagram=LRW] output')?.textContent"
        becomes(browser, "two slaves with outputs and inputs add 6 to LRW", "6", counter)
        browser.click('.plug[data-slave="2"][data-port="input"]')
        becomes(browser, "one that is cut off adds nothing", "3 of 6", counter)
        browser.picture("counters.png", "light", "section:has(> .counters-frame)")
        browser.click('.plug[data-slave="2"][data-port="input"]')
        becomes(browser, "and again when it is back", "6", counter)


def tree(browser, url):
    """A junction with two branches, one of which has a line of two."""
    with bus("hub=fzm1,left=fzm1,tip=fzm1,right=fzm1", [MASTER, "{}"], "--wire", "2:1.3", "--wire", "4:1.1"):
        browser.open("about:blank")
        browser.open(url)
        check("the tree is in OP", True, reaches(browser, "OP,OP,OP,OP", seconds=120))
        lines = ("return [...document.querySelectorAll('.trunk, .branch')].map((line) => [...line.querySelector(':scope > .rail').children]"
                 ".map((part) => part.querySelector('.title')?.textContent ?? (part.className === 'master' ? part.textContent : null)).filter(Boolean))")
        becomes(browser, "the line and its branch are drawn as they are wired", [["Master", "hub", "right"], ["1, port 3", "left", "tip"]], lines)
        cut = "return [...document.querySelectorAll('.cable.cut')].length"
        browser.picture("tree.png", "light", "section.wide", 1000)
        browser.click('.plug[data-slave="1"][data-port="port 3"]')
        becomes(browser, "a click on the plug of the junction cuts off the branch alone", "1: OP,OP",  # lost frames end OP for a while
                "const s = [...document.querySelectorAll('.module')].filter((m) => !['left', 'tip'].includes(m.querySelector('.title').textContent));"
                "return document.querySelectorAll('.cable.cut').length + ': ' + s.map((m) => m.dataset.state).join()")
        check("the lamp of that port is off", "link at the port 3: off", browser.wait(
            "const label = document.querySelector('.plug[data-slave=\"1\"][data-port=\"port 3\"] .lamp').ariaLabel; return label.endsWith('off') && label", seconds=120))
        browser.click('.plug[data-slave="1"][data-port="port 3"]')
        becomes(browser, "again, and no cable is cut", 0, cut)
        check("the branch returns to OP", True, reaches(browser, "OP,OP,OP,OP", seconds=120))


def ring(browser, url):
    """The second interface of the master is at the far end."""
    with bus("fzm1,fzm1", [MASTER, "{}"], "--iface", "ecat0,ecat1"):
        browser.open("about:blank")
        browser.open(url)
        browser.wait("return document.querySelectorAll('.module').length === 2", seconds=120)
        becomes(browser, "the ring is closed at the master", ["Master", "Master, second interface"],
                "return [...document.querySelectorAll('.master')].map((end) => end.textContent)")
        browser.click('.plug[data-slave="2"][data-port="output"]')
        check("its last cable can be cut", True, browser.wait(
            "return document.querySelector('.rail > .cable:nth-last-child(2)').classList.contains('cut')", seconds=120))
        browser.picture("ring.png", "light", "section.wide", 1000)


def waves(browser, url):
    """A signal follows a wave from the form until it is stopped."""
    with bus("ranger=optoncdt2300", ["sleep", "600"]):
        browser.open("about:blank")
        browser.open(url)
        browser.wait("return document.querySelector('.wave-form [name=signal]')?.options.length > 0", seconds=120)
        browser.run("const form = document.querySelector('.wave-form'); const all = form.signal;"
                    "all.value = [...all.options].find((one) => one.textContent === 'surface1.distance').value; all.dispatchEvent(new Event('change'));"
                    "form.shape.value = 'square'; form.low.value = 3; form.high.value = 9; form.period.value = 0.5;")
        browser.click(".wave-form .primary")
        check("the wave is in the list", "ranger: surface1.distance: square from 3 to 9, 0.5 s", browser.wait(
            "return document.querySelector('[data-wave]')?.firstChild.textContent", seconds=120))
        for number in ("9", "3", "9"):
            check(f"the signal reaches {number}", True, bool(until(lambda n=number: value("ranger.surface1.distance") == f"ranger.surface1.distance={n}", 120)))
        accessible(browser)
        browser.picture("waves.png", "light", "section:has(> .waves)")
        browser.click("[data-wave] button")
        check("it ends", "No wave runs.", browser.wait(
            "const text = document.querySelector('.waves > .label').textContent; return !document.querySelector('[data-wave]') && text", seconds=120))
        check("the twin has none", '{"ok":true}', ask('{"op":"waves"}'))
        browser.run("document.querySelector('.wave-form').high.value = 1e9")
        browser.click(".wave-form .primary")
        check("a value beyond the range is refused with its reason", True, browser.wait(
            "return document.querySelector('.waves > .label').textContent.includes('surface1.distance')", seconds=120))


def captured(browser, url):
    """Captures for 0.3 s. @return whether the file can be downloaded; None: the page has lost its connection, and with it the capture"""
    state = ("const button = document.querySelector('.capture'); const lost = !button?.marked;"
             "const link = document.querySelector('a.download[download=\"capture.pcapng\"]'); return ")
    browser.open("about:blank")
    browser.open(url)
    check("the slaves are in OP", True, reaches(browser, "OP,OP", seconds=120))
    browser.wait("const button = document.querySelector('.capture'); if (button) button.marked = true; return button !== null")
    browser.click(".capture")
    browser.wait(state + "lost || button.ariaPressed === 'true'", seconds=120)
    browser.wait("const t = performance.now(); window.since ??= t; const n = document.querySelector('[data-datagram=LRW] td:nth-child(3)');"
                 "return n && Number(n.textContent) > 0 && t - window.since > 300", seconds=120)
    browser.click(".capture")
    browser.wait(state + "lost || link.hidden === false", seconds=200)
    return browser.run(state + "lost ? null : link.hidden === false")


def capture(browser, url, folder):
    """A capture is downloaded as pcapng, and has requests and replies."""
    saved = pathlib.Path(folder, "capture.pcapng")
    browser.command("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder)
    with bus("fzm1,fzm1", [MASTER, "{}"]):
        results = (captured(browser, url) for _ in range(5))
        check("it can be downloaded", True, next((result for result in results if result is not None), None))
        browser.run("document.querySelector('a.download[download=\"capture.pcapng\"]').click()")
        check("the file is there", True, until(saved.exists, 120))
        blocks = pcapng(saved.read_bytes())
        check("a section and two interfaces", [0x0A0D0D0A, 1, 1], [kind for kind, _ in blocks[:3]])
        packets = [body for kind, body in blocks[3:] if kind == 6]
        check("nothing but packets follows", len(blocks) - 3, len(packets))
        types = {body[20 + 12:20 + 14] for body in packets}
        check("they are EtherCAT", {b"\x88\xa4"}, types)
        flags = {body[-8] for body in packets}
        check("in both directions", {1, 2}, flags)
        since = int.from_bytes(packets[0][4:8], "little") << 32 | int.from_bytes(packets[0][8:12], "little")
        check("their time is that of the browser", True, abs(since / 1e9 - time.time()) < 3600)


def pcapng(content):
    """The blocks of a file: type and body. Each block has its length at both ends."""
    blocks, at = [], 0
    while at < len(content):
        kind, length = struct.unpack_from("<II", content, at)
        if length < 12 or struct.unpack_from("<I", content, at + length - 4)[0] != length:
            return [*blocks, ("a block of a wrong length", at)]
        blocks.append((kind, content[at + 8:at + length - 4]))
        at += length
    return blocks


def ask(request):
    """The reply of the only bus to a request of the control protocol."""
    path = next(pathlib.Path(os.environ["XDG_RUNTIME_DIR"], "ectwin").glob("*.sock"))
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(path))
        client.sendall(request.encode() + b"\n")
        return client.recv(4096).decode().strip()


def view_only(browser):
    with panel("--view") as url, bus("fzm1", ["sleep", "600"]):
        browser.open(url)
        browser.wait("return document.querySelector('.waves') !== null", seconds=120)
        check("SEC: --view has neither waves to set nor captures", 0, browser.run("return document.querySelectorAll('.wave-form, .capture').length"))


def cases(browser, folder):
    with panel() as url:
        waves(browser, url)
        capture(browser, url, folder)
        process_data(browser, url)
        counters(browser, url)
        tree(browser, url)
        ring(browser, url)
    view_only(browser)


sys.exit(run(cases))
