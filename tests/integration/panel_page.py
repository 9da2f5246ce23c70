# SPDX-License-Identifier: MIT
"""Parts that the tests of the page of `ectwin panel` share: a browser, panels, buses. Their first arguments are ECTWIN MASTER [FOLDER]."""
import base64
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

ECTWIN, MASTER = sys.argv[1:3]
SHOTS = sys.argv[3] if len(sys.argv) > 3 else None
MISSED = ("element click intercepted", "element not interactable", "stale element reference")  # errors of a click that may succeed later
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element in WebDriver
# No services beside the page, few processes, and lamps that do not blink, except where a test asks for that.
LEAN = ["--disable-extensions", "--disable-component-update", "--disable-background-networking", "--disable-sync", "--no-first-run",
        "--disable-default-apps", "--force-prefers-reduced-motion", "--in-process-gpu", "--renderer-process-limit=1", "--disable-site-isolation-trials",
        "--disable-features=Translate,OptimizationHints,MediaRouter,AutofillServerCommunication"]
# A display of 12 frames a second: plots are half of the work of a page at 60.
DISPLAY = "const show = requestAnimationFrame; window.requestAnimationFrame = (draw) => setTimeout(() => show(draw), 66);"
failures = []


def check(title, expected, actual):
    if expected != actual:
        failures.append(title)
        print(f"FAILED {title}\n  expected: {expected!r}\n  got:      {actual!r}")


def becomes(browser, title, expected, script, *arguments):
    """Checks the value of a script when it is the expected one, at the latest after the limit of `Browser.wait`: a page follows its bus."""
    actual = None

    def as_expected():
        nonlocal actual
        actual = browser.run(script, *arguments)
        return actual == expected

    until(as_expected)
    check(title, expected, actual)


class Refused(Exception):
    """A command that the driver refuses: its error, as in WebDriver, and a message."""


class Browser:
    """A session of chromedriver."""

    def __init__(self, profile):
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.session = None
        for line in self.driver.stdout:
            if "successfully on port " in line:
                self.base = "http://127.0.0.1:" + line.rsplit("on port ", 1)[1].strip().rstrip(".")
                break
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=1400,1000",
                   "--force-device-scale-factor=1", "--no-proxy-server", f"--user-data-dir={profile}", *LEAN]
        wanted = {"browserName": "chrome", "goog:chromeOptions": {"args": options}, "goog:loggingPrefs": {"browser": "ALL"}}
        self.session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}}, bare=True)["sessionId"]

    def call(self, method, path, body=None, bare=False):
        url = self.base + ("" if bare else f"/session/{self.session}") + path
        data = json.dumps(body).encode() if body is not None else None
        request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=300) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as refusal:
            value = json.load(refusal)["value"]
            raise Refused(value["error"], value["message"]) from None

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, *arguments, seconds=120):
        """Waits until a script returns something true; returns it."""
        deadline = time.monotonic() + seconds
        while not (value := self.run(script, *arguments)) and time.monotonic() < deadline:
            time.sleep(0.05)
        return value

    def click(self, selector, seconds=120):
        """Clicks as a user does: waits for the element, and clicks again if it has moved or a message covers it."""
        self.wait("return document.querySelector(arguments[0])", selector)
        deadline = time.monotonic() + seconds
        while True:
            element = self.call("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]
            try:
                return self.call("POST", f"/element/{element}/click", {})
            except Refused as refusal:
                if refusal.args[0] not in MISSED or time.monotonic() > deadline:
                    raise
            time.sleep(0.05)

    def type(self, selector, text):
        element = self.call("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]
        self.call("POST", f"/element/{element}/clear", {})
        self.call("POST", f"/element/{element}/value", {"text": text})

    def pointer(self, actions):
        """Actions of the mouse; its position and buttons stay between calls."""
        self.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}]})

    def keys(self, action, key):
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": [{"type": action, "value": key}]}]})

    def upload(self, selector, path):
        element = self.call("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]
        self.call("POST", f"/element/{element}/value", {"text": str(path)})

    def picture(self, name, scheme=None, part=None, width=None):
        """A screenshot of the window, or of the element that the selector `part` finds, at most 900 pixels of its height; `width`: of the window."""
        if not SHOTS:
            return
        self.command("Emulation.setScrollbarsHidden", hidden=True)  # a picture of a part has none, and is as wide
        self.run("document.getElementById('messages').replaceChildren()")
        if width:
            self.command("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
            time.sleep(0.3)
        if scheme:
            self.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            time.sleep(0.3)
        if not part:
            pathlib.Path(SHOTS, name).write_bytes(base64.b64decode(self.call("GET", "/screenshot")))
            return
        clip = self.run("const b = document.querySelector(arguments[0]).getBoundingClientRect();"
                        "return { x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: Math.min(b.height, 900), scale: 1 }", part)
        shot = self.command("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        pathlib.Path(SHOTS, name).write_bytes(base64.b64decode(shot["data"]))
        if width:
            self.command("Emulation.clearDeviceMetricsOverride")

    def command(self, name, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": name, "params": parameters})

    def errors(self):
        return [line["message"] for line in self.call("POST", "/se/log", {"type": "browser"}) if line["level"] == "SEVERE"]

    def close(self):
        with contextlib.suppress(OSError, urllib.error.URLError):
            if self.session:
                self.call("DELETE", "")
        self.driver.terminate()
        self.driver.wait(120)


@contextlib.contextmanager
def panel(*options):
    process = subprocess.Popen([ECTWIN, "panel", *options], stdout=subprocess.PIPE, text=True)
    try:
        yield json.loads(process.stdout.readline())["url"]
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=120)


@contextlib.contextmanager
def bus(devices, master, *options, output=subprocess.DEVNULL):
    process = subprocess.Popen([ECTWIN, "with", "--quiet", *options, devices, "--", *master], stdout=output, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(120)


STATES = "return [...document.querySelectorAll('.module')].map((m) => m.dataset.state).join()"


def reaches(browser, states, seconds=300):
    return browser.wait(f"return {STATES.removeprefix('return ')} === arguments[0]", states, seconds=seconds) or browser.run(STATES)


def value(name):
    return subprocess.run([ECTWIN, "get", name], capture_output=True, text=True).stdout.strip()


def until(condition, seconds=120):
    """Waits until a function returns something true; returns it."""
    deadline = time.monotonic() + seconds
    while not (result := condition()) and time.monotonic() < deadline:
        time.sleep(0.05)
    return result


# Elements beyond the right edge that no ancestor scrolls or clips, each with its edge.
BEYOND = """return [...document.querySelectorAll('body *')].filter((e) => {
  if (e.getBoundingClientRect().right <= innerWidth) return false;
  for (let a = e.parentElement; a && a !== document.body; a = a.parentElement) if (getComputedStyle(a).overflowX !== 'visible') return false;
  return true;
}).map((e) => `${e.tagName}.${e.className} ${Math.round(e.getBoundingClientRect().right)}: ${e.textContent.slice(0, 80)}`)"""


# Rules of WCAG 2.1 and ARIA that a script can check, each with the elements that break it.
RULES = {
    "4.1.2 a control has a name": "[...document.querySelectorAll('button, input, select, a, [role=slider]')].filter((e) => !(e.getAttribute('aria-label') || "
                                  "e.getAttribute('aria-labelledby') || e.closest('label') || e.textContent.trim()))",
    "4.1.2 aria-labelledby refers to an element": "[...document.querySelectorAll('[aria-labelledby]')].filter((e) => !document.getElementById(e.getAttribute("
                                                  "'aria-labelledby'))?.textContent)",
    "4.1.1 ids are unique": "[...document.querySelectorAll('[id]')].filter((e, i, all) => all.findIndex((o) => o.id === e.id) !== i)",
    "1.1.1 a picture has a text": "[...document.querySelectorAll('[role=img], canvas')].filter((e) => !e.getAttribute('aria-label'))",
    "1.1.1 a picture has a role": "[...document.querySelectorAll('svg')].filter((e) => e.getAttribute('role') !== 'img')",
    "4.1.2 a slider has a value": "[...document.querySelectorAll('[role=slider]')].filter((e) => !e.getAttribute('aria-valuenow') || e.tabIndex < 0)",
    "1.3.1 levels of headings are not skipped": "[...document.querySelectorAll('h1, h2, h3')].filter((e, i, all) => i > 0 && e.tagName[1] - all[i - 1].tagName[1] > 1)",
    "3.1.1 the page has a language": "[document.documentElement].filter((e) => !e.lang)",
    "2.1.1 what can be clicked can be focused": "[...document.querySelectorAll('main button:not(:disabled), main a, main select')].filter((e) => e.tabIndex < 0)",
}


def accessible(browser):
    for title, broken in RULES.items():
        check(f"WCAG {title}", [], browser.run(f"return {broken}.map((e) => e.outerHTML.slice(0, 200))"))


def run(cases):
    """Runs `cases(browser, folder)` in Chromium. Returns the exit status of the test."""
    if not shutil.which("chromium") or not shutil.which("chromedriver"):
        print("skipped: no Chromium with chromedriver here; tools/bootstrap.sh test installs them")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        os.environ["HOME"] = folder
        browser = Browser(folder + "/profile")
        try:
            browser.command("Page.addScriptToEvaluateOnNewDocument", source=DISPLAY)
            cases(browser, folder)
            check("nothing is refused by the policy, and no script fails", [],
                  [line for line in browser.errors() if "WebSocket" not in line])
        finally:
            browser.close()
    return 1 if failures else 0
