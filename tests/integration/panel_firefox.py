#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The page of `ectwin panel` in headless Firefox, over its remote protocol Marionette: lamps, plugs, signals, chart, a dragged joystick.

usage: panel_firefox.py ECTWIN MASTER [FOLDER]      FOLDER: a screenshot is written there. Exits with 77 without Firefox.
"""
import base64
import contextlib
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from panel_page import BEYOND, SHOTS, accessible, becomes, bus, check, failures, panel, reaches, until, value

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element in WebDriver
PREFERENCES = {"marionette.port": 0, "app.update.auto": False, "app.normandy.enabled": False, "browser.shell.checkDefaultBrowser": False,
               "browser.startup.homepage_override.mstone": "ignore", "datareporting.policy.dataSubmissionEnabled": False, "network.proxy.type": 0,
               "network.captive-portal-service.enabled": False, "network.connectivity-service.enabled": False, "dom.ipc.processCount": 1,
               "extensions.systemAddon.update.enabled": False, "toolkit.telemetry.enabled": False, "services.settings.server": "http://127.0.0.1:1"}


class Firefox:
    """A session of Marionette: each message is its length, a colon and a JSON list."""

    def __init__(self, profile):
        profile.mkdir()
        profile.joinpath("user.js").write_text("".join(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in PREFERENCES.items()))
        command = [shutil.which("firefox-esr") or shutil.which("firefox"), "--headless", "--marionette", "--no-remote", "--width", "1400", "--height", "1000",
                   "--profile", profile, "about:blank"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = profile / "MarionetteActivePort"
        number = until(lambda: self.process.poll() is None and port.exists() and port.read_text())
        self.stream = socket.create_connection(("127.0.0.1", int(number)), timeout=300).makefile("rwb")
        self.receive()
        self.number = 0
        self.call("WebDriver:NewSession", capabilities={"alwaysMatch": {}})

    def receive(self):
        length = b""
        while (byte := self.stream.read(1)) != b":":
            length += byte
        return json.loads(self.stream.read(int(length)))

    def call(self, name, **parameters):
        self.number += 1
        message = json.dumps([0, self.number, name, parameters]).encode()
        self.stream.write(b"%d:%s" % (len(message), message))
        self.stream.flush()
        _, _, error, result = self.receive()
        if error:
            raise RuntimeError(f"{name}: {error['message']}")
        return result.get("value") if isinstance(result, dict) else result

    def open(self, url):
        self.call("WebDriver:Navigate", url=url)

    def run(self, script, *arguments):
        return self.call("WebDriver:ExecuteScript", script=script, args=list(arguments))

    def wait(self, script, *arguments, seconds=120):
        return until(lambda: self.run(script, *arguments), seconds)

    def element(self, selector):
        self.wait("return document.querySelector(arguments[0]) !== null", selector)
        return self.call("WebDriver:FindElement", using="css selector", value=selector)[ELEMENT]

    def click(self, selector):
        self.call("WebDriver:ElementClick", id=self.element(selector))

    def type(self, selector, text):
        element = self.element(selector)
        self.call("WebDriver:ElementClear", id=element)
        self.call("WebDriver:ElementSendKeys", id=element, text=text)

    def pointer(self, *actions):
        self.call("WebDriver:PerformActions", actions=[{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": list(actions)}])

    def picture(self, name):
        if SHOTS:
            pathlib.Path(SHOTS, name).write_bytes(base64.b64decode(self.call("WebDriver:TakeScreenshot", full=False)))

    def close(self):
        with contextlib.suppress(OSError, ValueError, RuntimeError):
            self.call("Marionette:Quit", flags=["eForceQuit"])
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(60)
        self.process.kill()
        self.process.wait()


def vision_sensor(browser, url, master):
    with bus("gripper=fzm1,fzm1", [master, "{}"]):
        browser.open(url)
        check("the slaves are in OP", True, reaches(browser, "OP,OP"))
        check("the lamp RUN is on", "on", browser.wait("const p = document.querySelector('.lamps .lamp.green').dataset.pattern; return p === 'on' && p"))
        browser.click('.plug[data-slave="2"][data-port="input"]')
        check("a click on a plug cuts the cable", True, browser.wait("return document.querySelectorAll('.cable.cut').length === 1"))
        browser.click('.plug[data-slave="2"][data-port="input"]')
        check("again, and the slave returns to OP", True, reaches(browser, "OP,OP"))
        browser.type('[data-signal="data1"] input.number', "12.5\ue007")
        check("a signal is set", True, until(lambda: value("gripper.data1") == "gripper.data1=12.5"))
        browser.click(".presets button")
        becomes(browser, "a preset plots its signals", 8, "return document.querySelectorAll('.side .lane').length")
        check("the chart draws", True, browser.wait("const c = document.querySelector('.side canvas'); return c.width > 100 && "
                                                    "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v !== 0)"))
        check("nothing is cut off", True, browser.run("return document.documentElement.scrollWidth <= innerWidth") or browser.run(BEYOND))
        accessible(browser)
        browser.run("scrollTo(0, 0)")
        browser.picture("firefox.png")


def joystick(browser, url):
    with bus("vr-bu-ect-map1", ["sleep", "600"]):
        browser.open("about:blank")
        browser.open(url)
        browser.click('[data-remote="1"] [data-toggle="ru1.on"]')
        stick = '[data-remote="1"] [data-stick="ru1.joystick1"]'
        browser.element(stick)
        x, y = browser.run("const e = document.querySelector(arguments[0]); e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
                           "return [Math.round(b.x + b.width / 2), Math.round(b.y + b.height / 2)]", stick)
        browser.pointer({"type": "pointerMove", "x": x, "y": y}, {"type": "pointerDown", "button": 0},
                        {"type": "pointerMove", "duration": 100, "x": x + 200, "y": y})
        check("a joystick is dragged", True, until(lambda: value("ru1.joystick1") == "ru1.joystick1=1000"))
        browser.pointer({"type": "pointerUp", "button": 0})
        check("released, it returns to its centre", True, until(lambda: value("ru1.joystick1") == "ru1.joystick1=0"))


def main():
    if not shutil.which("firefox-esr") and not shutil.which("firefox"):
        print("skipped: no Firefox here; apt install firefox-esr")
        return 77
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        os.environ["XDG_RUNTIME_DIR"] = os.environ["HOME"] = folder
        browser = Firefox(pathlib.Path(folder, "profile"))
        try:
            with panel() as url:
                vision_sensor(browser, url, sys.argv[2])
                joystick(browser, url)
        finally:
            browser.close()
    return 1 if failures else 0


sys.exit(main())
