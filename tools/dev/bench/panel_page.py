#!/usr/bin/env python3
"""Measures the page of `ectwin panel` in headless Chromium.  usage: panel_page.py MASTER [--build DIR] [--seconds S] [--sets N]

  MASTER        tests/integration/panel_master of a build with tests; it exchanges process data each millisecond
  --build DIR   where ectwin and ectwin-panel are (default build/release)
  --seconds S   of plotting (default 20)
  --sets N      changes whose delay to the page is measured (default 50)

Prints the time from the start of the navigation to the first picture and to the last signal, the time from the request that changes
a signal to the frame that shows it, and the intervals of frames and the CPU time of a frame, while 20 curves are plotted that
change 1000 times per second by a table of `--play`. Chromium runs as in the tests, without a GPU.
"""
import argparse
import json
import math
import os
import pathlib
import socket
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
CURVES = 20
TWINS = 3
# Time from the start of the navigation to the first paint, and to the frame after the last signal has a value.
FIRST = """return new Promise((done) => {
  const step = () => {
    const paint = performance.getEntriesByName('first-contentful-paint')[0];
    if (!window.shown && document.querySelector('.module[data-state=OP]')) requestAnimationFrame(() => { window.shown ??= performance.now(); });
    if (paint && window.shown) done([paint.startTime, window.shown]); else setTimeout(step, 1);
  };
  step();
})"""
# The time of day of the frame that shows a value of the plotted signal.
SHOWN = """window.seen = {};
const input = document.querySelector('[data-signal="timeout"] input.number');
const step = () => { window.seen[input.value] ??= performance.timeOrigin + performance.now(); requestAnimationFrame(step); };
step();"""
FRAMES = """const seconds = arguments[0];
return new Promise((done) => {
  const [stamps, tasks, begin] = [[], [], performance.now()];
  new PerformanceObserver((list) => { for (const task of list.getEntries()) tasks.push(task.duration); }).observe({ type: 'longtask' });
  const step = (now) => { stamps.push(now); if (performance.now() - begin < 1000 * seconds) requestAnimationFrame(step); else done([stamps, tasks]); };
  requestAnimationFrame(step);
})"""


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1].split("\n")[0])
    parser.add_argument("master")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--sets", type=int, default=50)
    return parser.parse_args()


def table(path, twin):
    """A table of 2 s whose seven signals change each millisecond."""
    names = [f"data{n}" for n in range(1, 8)]
    with path.open("w") as out:
        out.write(",".join(["time", *names]) + "\n")
        for ms in range(2000):
            cells = (f"{1000 * math.sin(2 * math.pi * ms / 2000 * (1 + n + twin)):.3f}" for n in range(len(names)))
            out.write(f"{ms / 1000:.3f}," + ",".join(cells) + "\n")


def delays(page, ectwin, browser, sets):
    """Times in ms from a request to the frame that shows the value."""
    path = next(pathlib.Path(os.environ["XDG_RUNTIME_DIR"], "ectwin").glob("*.sock"))
    browser.run(SHOWN)
    took = []
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(path))
        for number in range(100, 100 + sets):
            time.sleep(0.1 + 0.0137 * (number % 7))
            since = time.time()
            client.sendall(json.dumps({"op": "set", "slave": 1, "name": "timeout", "value": number}).encode() + b"\n")
            client.recv(4096)
            shown = browser.wait("return window.seen[arguments[0]]", str(number))
            took.append(shown - 1000 * since)
    return took


def measure(page, ectwin, args):
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = os.environ["HOME"] = folder
        options = []
        for twin in range(1, TWINS + 1):
            table(pathlib.Path(folder, f"{twin}.csv"), twin)
            options += ["--play", f"{twin}:{folder}/{twin}.csv,loop"]
        browser = page.Browser(folder + "/profile")
        try:
            with page.panel() as url:
                with page.bus("fzm1*3", [args.master, "{}", "9999", "1000"]):
                    time.sleep(3)
                    first = []
                    for _ in range(5):
                        browser.open("about:blank")
                        browser.open(url)
                        first.append(browser.run(FIRST))
                    took = delays(page, ectwin, browser, args.sets)
                with page.bus("fzm1*3", [args.master, "{}", "9999", "1000"], *options):
                    browser.open("about:blank")
                    browser.open(url)
                    page.reaches(browser, "OP,OP,OP")
                    report(first, took, *frames(browser, args.seconds))
        finally:
            browser.close()


def frames(browser, seconds):
    """Plots 20 curves. @return the stamps of the frames, the long tasks, the number of curves and of changes, CPU time in s"""
    curves = 0
    for twin in range(1, TWINS + 1):
        browser.click(f"[data-select='{twin}']")
        browser.wait(f"return document.querySelector('.signal[data-slave=\"{twin}\"]') !== null")
        curves = browser.run("for (const b of [...document.querySelectorAll('.signal')].filter((s) => /^data[1-7]$/.test(s.dataset.signal))) "
                             "b.querySelector('.trace').click(); return document.querySelectorAll('.side .lane').length")
    browser.run("document.querySelector('.record').click()")
    browser.run("document.querySelector('canvas').scrollIntoView()")
    time.sleep(5)
    browser.command("Performance.enable", timeDomain="threadTicks")
    cpu = lambda: {row["name"]: row["value"] for row in browser.command("Performance.getMetrics")["metrics"]}  # noqa: E731
    before = cpu()
    stamps, tasks = browser.run(FRAMES, seconds)
    after = cpu()
    busy = {name: 1000 * (after[name] - before[name]) / len(stamps) for name in ("TaskDuration", "ScriptDuration", "LayoutDuration")}
    browser.run("document.querySelector('.record').click()")
    changes = browser.run("return document.querySelector('.recorder [role=status]').textContent")
    return stamps, tasks, curves, int(changes.split()[0]), busy


def report(first, took, stamps, tasks, curves, changes, busy):
    intervals = [b - a for a, b in zip(stamps, stamps[1:])]
    mean = statistics.mean(intervals)
    print(f"first picture {max(row[0] for row in first):.0f} ms, all signals {max(row[1] for row in first):.0f} ms after the start of the navigation (longest of {len(first)})")
    print(f"signal change to frame: median {statistics.median(took):.0f} ms, longest {max(took):.0f} ms of {len(took)}")
    print(f"{curves} curves, {changes} changes recorded: {1000 / mean:.1f} frames a second, median interval {statistics.median(intervals):.1f} ms, "
          f"99 % {sorted(intervals)[int(0.99 * len(intervals))]:.1f} ms, longest {max(intervals):.1f} ms; {len(tasks)} tasks longer than 50 ms; "
          f"CPU time of the main thread {busy['TaskDuration']:.1f} ms a frame (scripts {busy['ScriptDuration']:.1f} ms, layout {busy['LayoutDuration']:.1f} ms)")
    print(f"load average {os.getloadavg()[0]:.1f}")


def main():
    args = arguments()
    ectwin = str(args.build.resolve() / "ectwin")
    args.master = str(pathlib.Path(args.master).resolve())
    sys.argv = [sys.argv[0], ectwin, args.master]
    sys.path.insert(0, str(ROOT / "tests" / "integration"))
    import panel_page as page
    measure(page, ectwin, args)


main()
