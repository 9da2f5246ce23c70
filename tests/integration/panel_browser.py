#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The page of `ectwin panel` in headless Chromium: plugs, signals, faults, hostile names, with a running master.

usage: panel_browser.py ECTWIN MASTER [FOLDER]      FOLDER: screenshots are written there. Exits with 77 without Chromium.
"""
import pathlib
import subprocess
import sys
import time

from panel_page import BEYOND, ECTWIN, MASTER, SHOTS, accessible, becomes, bus, check, panel, reaches, run, until, value

def with_a_master(browser, url):
    browser.open(url)
    check("the slaves are in OP", True, reaches(browser, "OP,OP,OP"))
    becomes(browser, "their names are shown", "gripper", "return document.querySelector('[data-module=\"1\"] .title').textContent")
    browser.click('.plug[data-slave="3"][data-port="input"]')
    check("a click on a plug: the master loses the slave", "off the bus",
          browser.wait("return document.querySelector('[data-module=\"3\"]').dataset.state === 'OP' ? '' : 'off the bus'"))
    check("the twin knows it", True, browser.wait("return document.querySelectorAll('.cable.cut').length === 1"))
    browser.picture("cut.png", "light", "section.wide", 1000)
    browser.click('.plug[data-slave="3"][data-port="input"]')
    check("again, and the slave returns to OP", True, reaches(browser, "OP,OP,OP"))
    browser.type('[data-signal="data1"] input.number', "12.5\n")
    deadline = time.monotonic() + 120
    while value("gripper.data1") != "gripper.data1=12.5" and time.monotonic() < deadline:
        time.sleep(0.05)
    check("a signal is set", "gripper.data1=12.5", value("gripper.data1"))
    subprocess.run([ECTWIN, "set", "gripper.data1=3"], check=True)
    check("a change from elsewhere is shown", True,
          browser.wait("return document.querySelector('[data-signal=\"data1\"] input.number').value === '3'"))
    browser.click('[data-signal="err"] .switch')
    check("a switch is on when the twin is", True, browser.wait("return document.querySelector('[data-signal=\"err\"] .switch').ariaChecked === 'true'"))
    browser.click('[data-signal="err"] .switch')
    browser.type('[data-signal="scene"] input.number', "999\n")
    check("a refusal is shown with the twin's reason", True, browser.wait("return document.querySelector('#messages').textContent.includes('scene')"))
    check("the control shows the twin's value again", "0", browser.wait("return document.querySelector('[data-signal=\"scene\"] input.number').value.replace('999', '')"))


def blinking_lamps(browser):
    lamp = "const lamp = document.querySelector('.lamp[data-pattern=flickering]'); return lamp && getComputedStyle(lamp).animationName"
    for motion, animation in (("no-preference", "lamp"), ("reduce", "none")):
        browser.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": motion}])
        becomes(browser, f"a lamp that flickers, with prefers-reduced-motion: {motion}", animation, lamp)


def events(browser):
    """The list of events has the way to OP, and an emergency."""
    check("the way to OP is in the list of events", True, browser.wait(
        "return [...document.querySelectorAll('.event')].some((e) => e.textContent.includes('axis') && e.querySelector('.text').textContent === 'OP')"))
    subprocess.run([ECTWIN, "fault", "emergency 0x4210 slave gripper"], check=True)
    check("an emergency is in the list, with its words", True, browser.wait(
        "return [...document.querySelectorAll('.event.bad .text')].some((e) => e.textContent.startsWith('emergency 0x4210: device temperature'))"))
    browser.picture("events.png", "light", "section:has(.events)")


def objects(browser):
    """The dictionary of a twin: list, read, write, and the words of an abort."""
    browser.click('[data-select="2"]')
    browser.wait("return document.querySelector('.dictionary') !== null")
    browser.run("document.querySelector('.dictionary').open = true")
    check("the dictionary is listed to its end", True, browser.wait(
        "return /^[0-9]+ entries$/.test(document.querySelector('.dictionary [role=status]').textContent)", seconds=120))
    value = "return document.querySelector('[data-object=\"' + arguments[0] + '\"] output').textContent"
    write = ("const row = document.querySelector('[data-object=\"' + arguments[0] + '\"]'); row.querySelector('input').value = arguments[1];"
             "row.querySelector('[aria-label^=Write]').click()")
    browser.run("document.querySelector('[data-object=\"1018h:1\"] button').click()")
    check("an entry is read", True, browser.wait(f"const text = (() => {{ {value} }})(); return Number(text) > 0", "1018h:1"))
    browser.run(write, "6081h:0", "1234")
    check("an entry is written", "1234", browser.wait(f"const text = (() => {{ {value} }})(); return text === '1234' && text", "6081h:0"))
    browser.run(write, "6081h:0", "fast")
    check("a refusal has its reason", True, browser.wait(f"return (() => {{ {value} }})().includes('no value of type UNSIGNED32')", "6081h:0"))
    if SHOTS:
        browser.run("for (const read of [...document.querySelectorAll('.object button[aria-label^=Read]')].slice(0, 40)) read.click()")
        time.sleep(2)
    browser.picture("objects.png", "light", ".dictionary")
    browser.click('[data-select="1"]')
    browser.wait("return document.querySelector('[data-signal=data1]') !== null")


def faults_and_plots(browser):
    browser.run("const kind = document.querySelector('[name=kind]'); kind.value = 0; kind.dispatchEvent(new Event('change'));"
                "const amount = document.querySelector('[name=amount]'); amount.value = 2; amount.dispatchEvent(new Event('input'));")
    becomes(browser, "the form shows its line", "drop 2%", "return document.querySelector('[name=line]').value")
    browser.click(".line-row .primary")
    check("the fault is in the list", True, browser.wait("return document.querySelector('.fault-list').textContent === 'drop 2%'"))
    check("the twin has it", "drop 2%", subprocess.run([ECTWIN, "fault"], capture_output=True, text=True).stdout.strip())
    browser.picture("faults.png", "light", "section:has(.fault-form)")
    browser.click(".faults > button")
    check("it is cleared", True, browser.wait("return document.querySelector('.fault-list .none') !== null"))
    browser.click(".presets button")
    check("a preset plots its signals", True, browser.wait("return document.querySelectorAll('.lane').length >= 5"))
    check("the chart draws", True, browser.wait("const c = document.querySelector('canvas'); return c.width > 100 && "
                                                "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v !== 0)"))
    if SHOTS:
        subprocess.run([ECTWIN, "fault", "counter -1 every 1000"], check=True)
        for n in range(40):
            subprocess.run([ECTWIN, "set", "gripper.trigger=1"], check=True)
            time.sleep(0.25 + 0.05 * (n % 3))
        browser.picture("plot.png", "light", "section:has(> .plot)")
        subprocess.run([ECTWIN, "set", "gripper.trigger=1"], check=True)
        browser.picture("camera.png", "light", ".front-of", 1200)
        browser.picture("response.png", "light", "section:has(.histogram)")
        browser.run("scrollTo(0, 0)")
        subprocess.run([ECTWIN, "set", "gripper.trigger=1"], check=True)
        browser.picture("dark.png", "dark")
        browser.picture("light.png", "light")
        browser.command("Emulation.setDeviceMetricsOverride", width=390, height=1600, deviceScaleFactor=1, mobile=True)
        browser.picture("phone.png", "light")
        browser.command("Emulation.clearDeviceMetricsOverride")


def recordings(browser, folder):
    """A recording is downloaded, and played by the page and by `ectwin set --csv`."""
    saved = pathlib.Path(folder, "recording.csv")
    browser.command("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder)
    browser.click('[data-signal="data1"] .trace')
    browser.click(".record")
    for number in (5, 6.25, 8):
        subprocess.run([ECTWIN, "set", f"gripper.data1={number}"], check=True)
        browser.wait("return document.querySelector('[data-signal=\"data1\"] input.number').value === arguments[0]", str(number))
    subprocess.run([ECTWIN, "set", "gripper.data1=-1"], check=True)
    browser.wait("return document.querySelector('[data-signal=\"data1\"] input.number').value === '-1'")
    browser.click(".record")
    browser.click("a.download")
    check("a recording is downloaded", True, until(saved.exists))
    lines = [line.split(",") for line in saved.read_text().splitlines()]
    column = lines[0].index("gripper.data1")
    values = [line[column] for line in lines[1:] if line[column]]
    check("it has every change", ["5", "6.25", "8", "-1"], values[-4:])
    replayed = "return document.querySelector('.recorder [role=status]').textContent"
    subprocess.run([ECTWIN, "set", "gripper.data1=77"], check=True)
    browser.upload(".recorder input[type=file]", saved)
    check("the page plays it", "gripper.data1=-1", until(lambda: value("gripper.data1") == "gripper.data1=-1") and value("gripper.data1"))
    check("it shows the end", True, browser.wait(f"const line = (() => {{ {replayed} }})(); return line.startsWith(arguments[0])",
                                                 f"{len(lines) - 1} of {len(lines) - 1} lines played"))
    browser.picture("recorder.png", "light", "section:has(> .recorder)")
    played = pathlib.Path(folder, "settable.csv")
    played.write_text("".join(f"{line[0]},{line[column]}\n" for line in lines if line[column]))
    subprocess.run([ECTWIN, "set", "gripper.data1=77"], check=True)
    subprocess.run([ECTWIN, "set", "--csv", played], check=True)
    check("ectwin set --csv plays it", "gripper.data1=-1", value("gripper.data1"))
    pathlib.Path(folder, "other.csv").write_text("a,b\n1,2\n")
    browser.upload(".recorder input[type=file]", pathlib.Path(folder, "other.csv"))
    check("another file is refused", True, browser.wait(f"const line = (() => {{ {replayed} }})(); return line.startsWith('This is no recording')"))
    browser.click('[data-signal="data1"] .trace')


def machine(browser, url):
    """A bus file with `panel:` opens as one page of fronts."""
    file = pathlib.Path(__file__).resolve().parents[2] / "examples" / "machine" / "machine.yaml"
    titles = "return [...document.querySelectorAll('.front-of h2')].map((title) => title.textContent)"
    with bus(file, [MASTER, "{}"]):
        browser.open("about:blank")
        browser.open(url)
        check("the machine is in OP", True, reaches(browser, "OP,OP,OP,OP"))
        becomes(browser, "its fronts are in the order of the file",
                ["1 axis Drive", "2 ranger Distance sensor", "3 camera Vision sensor", "4 operator Base unit", "4 operator Remote units"], titles)
        browser.wait("return document.querySelector('.distance output').textContent !== ''")
        browser.command("Emulation.setDeviceMetricsOverride", width=1400, height=2300, deviceScaleFactor=1, mobile=False)
        browser.picture("machine.png", "light")
        browser.command("Emulation.clearDeviceMetricsOverride")
        accessible(browser)
        browser.click("main header > button")
        check("one button leads to the selected twin", ["Drive"], browser.wait(f"const t = (() => {{ {titles} }})(); return t.length === 1 && t"))


def scenario(browser, url, folder):
    script = pathlib.Path(folder, "steps.txt")
    script.write_text("at 1ms drop 1%\nat 2ms off\nat 36000s off\n")
    with bus("fzm1", ["sleep", "600"], "--scenario", script):
        browser.open("about:blank")
        browser.open(url)
        check("a scenario shows its progress", True, browser.wait(
            "return [...document.querySelectorAll('.figure')].some((f) => f.textContent === 'Scenario2 of 3 steps')"))
        browser.picture("scenario.png", "light", ".overview")


def drives(browser):
    browser.click('[data-select="2"]')
    browser.wait("return document.querySelectorAll('.states .box').length === 8")
    expected = value("axis.state").removeprefix("axis.state=")
    lit = "return [...document.querySelectorAll('.states .lit text')].map((t) => t.textContent).join()"
    becomes(browser, "the present state of CiA 402 is lit", expected, lit)
    subprocess.run([ECTWIN, "set", "axis.provoke=5"], check=True)
    check("a fault of the drive is lit", "fault", browser.wait(f"const now = (() => {{ {lit} }})(); return now === 'fault' && now"))
    browser.picture("drive.png", "light", ".front-of", 800)
    browser.click('[data-select="1"]')
    browser.click('[data-action="trigger"]')
    check("a camera shows its measurement", True, browser.wait("return document.querySelector('.camera-picture')?.ariaLabel.includes('OK')"))
    becomes(browser, "its timing chart", 6, "return document.querySelectorAll('.camera .lane').length")
    check("another device has no drive", True, browser.wait("return document.querySelector('.states') === null"))


# The response times of a machine that stood still: a column for each upper edge, as wide as the widest label.
LATE = """const bars = document.querySelector('.bars'), edges = document.querySelector('.edges');
  for (const column of Array(19).keys()) { bars.append(document.createElement('span')); edges.append(document.createElement('span'));
    edges.lastChild.textContent = '1000 ms'; }
  const fits = document.documentElement.scrollWidth <= innerWidth;
  for (const row of [bars, edges]) for (const column of Array(19).keys()) row.lastChild.remove();
  return fits"""


def widths(browser):
    for width in (390, 800, 1400):
        browser.command("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        check(f"nothing is cut off at a width of {width}", True,
              browser.wait("return document.documentElement.scrollWidth <= innerWidth") or browser.run(BEYOND))
        check(f"replies as late as 1000 ms are not cut off at a width of {width}", True, browser.run(LATE))
    browser.command("Emulation.clearDeviceMetricsOverride")
    named = browser.run("return [...document.querySelectorAll('button, input, select')].filter((e) => !(e.getAttribute('aria-label') || "
                        "e.getAttribute('aria-labelledby') || e.closest('label') || e.textContent.trim())).map((e) => e.outerHTML)")
    check("every control has a name for screen readers", [], named)


# The points that a chart of 20 curves passes to the canvas for each frame of 16 ms in 5 s of the chart's time, at `changes` per
# millisecond. Then its picture, compared with a completely painted one.
CHART_WORK = """const changes = arguments[0];
return import('/plot.js').then(({ Plot }) => {
  const listeners = [];
  const plot = new Plot({ add: (signal, listener) => { listeners.push(listener); return () => {}; } });
  plot.running = true; // its frames are painted here
  plot.element.style.width = '900px';
  document.body.append(plot.element);
  plot.choose([...Array(20).keys()].map((i) => ({ name: `s${i}`, slave: 1, range: { low: -1000, high: 1000, unit: '' }, value: null, watchers: [] })));
  const pen = plot.canvas.getContext('2d', { willReadFrequently: true });
  let points = 0;
  for (const name of ['moveTo', 'lineTo', 'fillRect']) {
    const plain = pen[name];
    pen[name] = (...place) => { points++; return plain.apply(pen, place); };
  }
  const work = [];
  const value = (i, time) => (Math.floor(time) === 22000 ? 99 : 100 * Math.sin(time / (200 + 37 * i)));
  for (let now = 16; now <= 25000; now += 16) {
    for (let time = now - 16; time < now; time += 1 / changes) listeners.forEach((listener, i) => listener(time, value(i, time)));
    if (now < 20000) continue;
    points = 0;
    plot.paint(now);
    work.push(points);
  }
  const look = () => pen.getImageData(0, 0, plot.canvas.width, plot.canvas.height).data;
  const moved = look();
  points = 0;
  plot.key = '';
  plot.paint(24992);
  const complete = look();
  let other = 0;
  for (let i = 3; i < complete.length; i += 4) if (Math.abs(moved[i] - complete[i]) > 96) other++;
  plot.element.remove();
  return { steady: Math.max(...work.slice(1)), whole: points, columns: plot.canvas.width, other, drawn: complete.filter((v, i) => i % 4 === 3 && v > 0).length };
})"""


def chart_work(browser):
    """The work of the chart for a frame is bounded by its columns, not by the number of changes."""
    slow, fast = browser.run(CHART_WORK, 1), browser.run(CHART_WORK, 4)
    check("20 curves at 1 kHz: a frame paints at most 50 points a curve", True, slow["steady"] <= 20 * 50 or slow)
    check("at 4 kHz as well", True, fast["steady"] <= 20 * 50 or fast)
    check("a chart that is painted completely has at most 5 points a bucket of each curve", True, fast["whole"] <= 20 * 5 * 1700 or fast)
    check("the picture that is moved is the picture that is painted completely", True,
          (slow["other"] < slow["drawn"] / 1000 and slow["drawn"] > 20 * slow["columns"]) or slow)


def remotes(browser, url, folder):
    """The front of a base unit and of its remote units: operated controls reach the PLC."""
    lines = pathlib.Path(folder, "inputs")
    joystick = "vr-bu-ect-map1", [MASTER, "{}", "38"]  # byte 38: joystick 1 of the first armed remote unit
    seen = lambda: [int(line) for line in lines.read_text().split()]  # noqa: E731
    with lines.open("w") as output, bus(*joystick, output=output):
        browser.open("about:blank")
        browser.open(url)
        check("the base unit is in OP", True, reaches(browser, "OP"))
        browser.click('[data-remote="1"] [data-toggle="ru1.on"]')
        check("a remote unit that is on has a front", True, browser.wait("return document.querySelector('[data-remote=\"1\"] .stick')"
                                                                         " !== null"))
        browser.wait("return document.querySelector('.chips').dataset.lit === 'Disarmed'")
        browser.click('[data-remote="1"] [data-toggle="ru1.armed"]')
        check("armed, and enabled", True, browser.wait("return document.querySelector('[data-remote=\"1\"] .chip.lit')?.textContent === 'Enabled'"))
        check("the relays are closed", "ES-Link relays closed",
              browser.wait("const label = document.querySelector('.relays').ariaLabel; return label.includes('closed') && label"))
        stick = '[data-remote="1"] [data-stick="ru1.joystick1"]'
        x, y = browser.run("const e = document.querySelector(arguments[0]); e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
                           "return [b.x + b.width / 2, b.y + b.height / 2]", stick)
        browser.pointer([{"type": "pointerMove", "x": round(x), "y": round(y)}, {"type": "pointerDown", "button": 0},
                         {"type": "pointerMove", "duration": 100, "x": round(x) + 200, "y": round(y)}])
        check("a joystick is dragged and the PLC reads it", True, until(lambda: 1000 in seen()))
        browser.picture("base.png", "light", "section:has(.base)", 1200)
        browser.picture("remote.png", "light", "section:has(.remotes)", 1200)
        browser.pointer([{"type": "pointerUp", "button": 0}])
        check("released, it returns to its centre", 0, until(lambda: seen()[-1] == 0) and seen()[-1])
        browser.pointer([{"type": "pointerMove", "x": round(x), "y": round(y)}, {"type": "pointerDown", "button": 0},
                         {"type": "pointerMove", "duration": 100, "x": round(x) + 200, "y": round(y)}])
        check("a joystick is dragged again", True, until(lambda: seen()[-1] == 1000))
        browser.open("about:blank")
        check("SEC: without its page it returns to its centre", True, until(lambda: seen()[-1] == 0))
        browser.pointer([{"type": "pointerUp", "button": 0}])
        browser.open(url)
        browser.wait("return document.querySelector(arguments[0]) !== null", stick)
        browser.run("document.querySelector(arguments[0]).focus()", stick)
        browser.keys("keyDown", "\ue012")
        check("an arrow key moves it", True, until(lambda: -500 in seen()))
        browser.keys("keyUp", "\ue012")
        check("it returns when the key is released", True, until(lambda: seen()[-1] == 0))
        browser.run("window.axes = [0.25, 0, 0, 0]; navigator.getGamepads = () => [{connected: true, axes: window.axes}]")
        browser.click('[data-remote="1"] .gamepad')
        check("a gamepad moves it", True, until(lambda: 250 in seen()))
        browser.run("window.axes = [0, 0, 0, 0]")
        check("it returns with the gamepad", True, until(lambda: seen()[-1] == 0))
        browser.click('[data-remote="1"] [data-toggle="ru1.stop"]')
        check("its stop opens the relays", True, browser.wait("return document.querySelector('.relays').ariaLabel.includes('open')"))
        check("the message of the base unit", True, browser.wait("return document.querySelector('.chips').dataset.lit === 'Stopped'"))


def sensor(browser, url):
    """The fronts of a sensor and of a terminal from an ESI file."""
    terminal = pathlib.Path(__file__).resolve().parents[1] / "esi" / "digital.xml"
    with bus(f"ranger=optoncdt2300,inputs=esi:{terminal}#DI4", ["sleep", "600"]):
        browser.open("about:blank")
        browser.open(url)
        browser.wait("return document.querySelectorAll('.sensor').length === 1")
        browser.run("const t = document.querySelector('.target'); t.value = 12.5; t.dispatchEvent(new Event('input'));")
        check("the target is moved", "ranger.surface1.distance=12.5",
              until(lambda: value("ranger.surface1.distance") == "ranger.surface1.distance=12.5") and value("ranger.surface1.distance"))
        check("its distance is read", True, browser.wait("return document.querySelector('.distance output').textContent === '12.500 mm'"))
        browser.picture("sensor.png", "light", ".front-of", 800)
        subprocess.run([ECTWIN, "set", "ranger.laser=0"], check=True)
        check("a missing distance shows its reason", True, browser.wait("return document.querySelector('.distance output.bad')?.textContent.includes('aser')"))
        subprocess.run([ECTWIN, "set", "ranger.laser=1"], check=True)
        browser.click("[data-select='2']")
        check("a terminal has a lamp for each bit of its PDOs", 4, browser.wait("return document.querySelectorAll('.terminal .led').length"))
        browser.click(".terminal [data-toggle]")
        check("a contact lights its lamp", True, browser.wait("return document.querySelectorAll('.led.on').length === 1"))
        browser.picture("terminal.png", "light", ".front-of", 800)
        browser.click("main header > button")
        check("the fronts of all twins", [1, 4], browser.wait("const n = [...document.querySelectorAll('.terminal')].length;"
                                                               "return n === 4 && [document.querySelectorAll('.sensor').length, n]"))
        browser.picture("fronts.png", "light", "main")


HOSTILE = "<img src=x onerror=document.title='hit'>"


def hostile_names(browser, url, folder):
    """A description whose texts are markup: it is text on the page."""
    source = pathlib.Path(__file__).resolve().parents[1] / "esi" / "digital.xml"
    escaped = HOSTILE.replace("<", "&lt;").replace(">", "&gt;")
    text = source.read_text().replace("<Name>Input", f"<Name>{escaped}Input").replace("<Name>Channel", f"<Name>{escaped}Channel")
    path = pathlib.Path(folder, "<b>hostile.xml")
    path.write_text(text)
    with bus(f"esi:{path}#DI4", ["sleep", "600"]):
        browser.open("about:blank")
        browser.open(url)
        check("a bus with a hostile name is shown", True, browser.wait("return document.querySelectorAll('.signal').length > 0"))
        check("the name is text", True, browser.wait("return document.body.textContent.includes('<b>hostile.xml')"))
        check("SEC: no markup of a name is carried out", ["ectwin", 0, 0],
              browser.run("return [document.title, document.querySelectorAll('main img').length, document.querySelectorAll('b').length]"))


def view_only(browser):
    with panel("--view") as url, bus("fzm1", ["sleep", "600"]):
        browser.open(url)
        browser.wait("return document.querySelectorAll('.signal').length > 0")
        becomes(browser, "--view: nothing to set", [0, True], "return [document.querySelectorAll('.signal input, .signal select, .switch, .fault-form').length, "
                                                              "[...document.querySelectorAll('.plug')].every((p) => p.disabled)]")


def cases(browser, folder):
    with panel() as url:
        with bus("gripper=fzm1,axis=pmctendo-dd5,fzm1", [MASTER, "{}"]):
            with_a_master(browser, url)
            blinking_lamps(browser)
            events(browser)
            objects(browser)
            faults_and_plots(browser)
            recordings(browser, folder)
            drives(browser)
            chart_work(browser)
            widths(browser)
        remotes(browser, url, folder)
        sensor(browser, url)
        machine(browser, url)
        scenario(browser, url, folder)
        hostile_names(browser, url, folder)
    view_only(browser)


sys.exit(run(cases))
