#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the page of `ectwin panel` with axe-core; run manually.  usage: panel_axe.py ECTWIN MASTER AXE

  ECTWIN   ectwin of a build
  MASTER   tests/integration/panel_master of the build
  AXE      axe.min.js of the npm package axe-core: npm pack axe-core@4.14.1 and tar xf; this script does not download it

Opens buses with all kinds of fronts in headless Chromium, light and dark, with the width of a desktop and of a phone, with all
lists open, and prints each rule violated by an element. Exits with 1 after a violation. Start it with
`unshare -Urn sh -c 'ip link set lo up; …'`.
"""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "integration"))
from panel_page import MASTER, bus, check, panel, run  # noqa: E402

AXE = pathlib.Path(sys.argv[3]).read_text()
TERMINAL = ROOT / "tests" / "esi" / "digital.xml"
BUSES = (("machine", [ROOT / "examples" / "machine" / "machine.yaml"]), ("terminal", [f"esi:{TERMINAL}#DI4,fzm1"]),
         ("tree", ["--wire", "2:1.3", "--wire", "3:1.1", "fzm1,fzm1,fzm1"]), ("base unit", ["--set", "ru1.on=1", "vr-bu-ect-map1"]))
RUN = """const done = arguments[arguments.length - 1];
axe.run(document, {resultTypes: ['violations']}).then((result) => done(result.violations.map((one) => [one.id, one.impact, one.help,
  one.nodes.slice(0, 12).map((node) => node.html.slice(0, 160) + ' | ' + (node.failureSummary ?? '').replace(/\\s+/g, ' ').slice(0, 220))])))"""


def look(browser, title):
    browser.run("for (const one of document.querySelectorAll('details')) one.open = true")
    browser.wait("return document.querySelectorAll('.object').length > 0 && document.querySelectorAll('.pdos').length > 0", seconds=10)
    for scheme in ("light", "dark"):
        for width in (1400, 390):
            browser.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            browser.command("Emulation.setDeviceMetricsOverride", width=width, height=1000, deviceScaleFactor=1, mobile=False)
            browser.run(AXE)
            for rule, impact, text, nodes in browser.call("POST", "/execute/async", {"script": RUN, "args": []}):
                check(f"axe, {title}, {scheme}, {width} px: {rule} ({impact}): {text}", [], nodes)


def cases(browser, folder):
    with panel() as url:
        for title, words in BUSES:
            with bus(words[-1], [MASTER, "{}"], *words[:-1]):
                browser.open("about:blank")
                browser.open(url)
                browser.wait("return document.querySelectorAll('.module').length > 0 && document.querySelectorAll('[data-datagram]').length > 0", seconds=120)
                look(browser, title)


sys.exit(run(cases))
