#!/usr/bin/env python3
"""Measures twins and writes the results.  usage: run.py [--build DIR] [--quick] [--only PART,...] [--write] [-o FILE]

  --build DIR   where ectwin and ectwin-bench are (default build/release)
  --quick       a tenth of the rounds
  --only        some of: instructions, sockets, round, spin, kernel, busy, inprocess, rates, cycle, start (default: all)
  --write       the tables of docs/PERFORMANCE.md, and the pictures docs/performance.svg and docs/busy.svg, from the results
  -o FILE       the results as JSON (default: build/bench.json)

Needs the packages of tools/bootstrap.sh bench: ip (iproute2), unshare and taskset (util-linux), and valgrind for the instructions;
no root if unprivileged user namespaces are permitted. inprocess also measures pysoem, if installed for the Python of this file (pip
install pysoem). Takes about three minutes. All processes share one core, so a round trip is the sum of all work; round trips of a
twin and of a bare echo alternate in one run; the run with the median ratio of three runs counts; the cycles of a thousand twins are
also measured three times.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PARTS = ["instructions", "sockets", "round", "spin", "kernel", "busy", "inprocess", "rates", "cycle", "start"]
UNIT = "vr-bu-ect-map1"
STANDARD = "vr-bu-ect-map7"
SMALLEST = 66  # bytes of process data of one UNIT
BUSY_LOOPS = 8
SLICES = 5


def run(*command):
    """Standard output of a program; a program that fails ends this one."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"run.py: {' '.join(str(word) for word in command[:4])} ...: {done.stderr.strip()[-300:]}")
    return done.stdout


def on_core(args, *command):
    return ["taskset", "-c", str(args.core), *[str(word) for word in command]]


class Running:
    """A process that runs for a while: a chain of twins, or an echo."""

    def __init__(self, command, ready):
        self.errors = tempfile.TemporaryFile()
        start = time.monotonic()
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.errors, text=True)
        if ready and '"ready"' not in self.process.stdout.readline():
            self.errors.seek(0)
            sys.exit(f"run.py: the twins do not start: {self.errors.read().decode().strip()}")
        self.took = time.monotonic() - start

    def ticks(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return int(fields[11]) + int(fields[12])

    def kilobytes(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", status)[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.errors.close()


def twins(args, device, count, *options):
    return Running(on_core(args, args.build / "ectwin", "run", "-i", "twin1", *options, f"{device}*{count}"), True)


def bench(args, *words):
    return json.loads(run(*on_core(args, args.build / "ectwin-bench", *words)))


# --- the measurements --------------------------------------------------------------------------------------------------


COUNTED = ["ect_chain_pass", "ect_chain_poll"]


def collected(args, present, command, frames):
    """Instructions in each function of COUNTED for a number of frames, preparations included."""
    with tempfile.NamedTemporaryFile() as out:
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}", "--collect-atstart=no",
                               *[f"--toggle-collect={name}" for name in COUNTED], str(args.build / "ectwin-bench"), "frames",
                               UNIT, str(present), str(min(present, 10)), command, str(frames)], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"run.py: valgrind: {done.stderr.strip()[-300:]}")
        table = run("callgrind_annotate", "--inclusive=yes", out.name)
    return {name: int(re.search(rf"^ *([0-9,]+) .*:{name} ", table, re.M)[1].replace(",", "")) for name in COUNTED}


def instructions(args):
    if not shutil.which("valgrind"):
        print("run.py: valgrind is not installed, no instructions are counted: tools/bootstrap.sh bench", file=sys.stderr)
        return None
    result = {name: {} for name in COUNTED}
    for command in ["LRW", "BRD", "FPRD", "FRMW"]:
        for present in [1, 10, 100, 1000]:
            few, many = (collected(args, present, command, n) for n in (10, 110))
            for name in COUNTED:
                result[name].setdefault(command, {})[str(present)] = (many[name] - few[name]) // 100
    return result


def middle(runs, key):
    """The median run, because a single run may share the core with another program."""
    return sorted(runs, key=key)[len(runs) // 2]


def against_echo(args, options, echo, counts):
    """The run with the median ratio, for each length of chain."""
    runs = {present: [] for present in counts}
    for _ in range(args.runs):
        for present in counts:
            with twins(args, UNIT, present, *options), \
                 Running(on_core(args, args.build / "ectwin-bench", echo, "echo1"), False):
                time.sleep(0.3)
                runs[present].append(bench(args, "round", "twin0", "echo0", UNIT, present, min(present, 10), args.rounds))
    return [middle(rows, lambda row: row["ratio"]) for rows in runs.values()]


def sockets(args):
    """An echo with the sockets and the filter of a twin: the run with the median ratio."""
    runs = []
    for _ in range(args.runs):
        with Running(on_core(args, args.build / "ectwin-bench", "port", "twin1"), False), \
             Running(on_core(args, args.build / "ectwin-bench", "echo", "echo1"), False):
            time.sleep(0.3)
            runs.append(bench(args, "echoes", "twin0", "echo0", SMALLEST, args.rounds))
    return middle(runs, lambda row: row["ratio"])


class BusyLoops:
    """Programs without waits, on all cores."""

    def __init__(self, count):
        self.processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes:
            process.kill()
            process.wait()


def kernel(args):
    """Replies in the kernel, in turns with an echo, without and with busy loops; None: not as root."""
    if not is_root():
        print("run.py: replies in the kernel are measured as root only", file=sys.stderr)
        return None
    rows, load = [], os.getloadavg()[0]
    for options, busy in [([], 0), (["--in-kernel"], 0), ([], BUSY_LOOPS), (["--in-kernel"], BUSY_LOOPS)]:
        runs = []
        for _ in range(args.runs):
            with Running(on_core(args, args.build / "ectwin", "run", "-i", "twin1", *options, STANDARD), True), \
                 Running(on_core(args, args.build / "ectwin-bench", "echo", "echo1"), False), BusyLoops(busy):
                time.sleep(0.3)
                runs.append(bench(args, "round", "twin0", "echo0", STANDARD, 1, 1, args.rounds))
        rows.append(middle(runs, lambda row: row["ratio"]) | {"in_kernel": bool(options), "busy_loops": busy})
    return {"load": load, "round": rows}


def busy(args):
    """Cycles of 250 us of a real-time master with busy loops, all programs on any core, both variants in turns, so that both have
    the same load; None: not as root."""
    if not is_root():
        print("run.py: cycles beside busy loops are measured as root only", file=sys.stderr)
        return None
    ways, load = [[], ["--in-kernel"]], os.getloadavg()[0]
    slices, ticks = [[], []], [0, 0]
    for _ in range(SLICES):
        for way, options in enumerate(ways):
            command = [args.build / "ectwin", "run", "-i", "twin1", *options, STANDARD]
            with Running([str(word) for word in command], True) as twin, BusyLoops(BUSY_LOOPS):
                before, cycles = twin.ticks(), 4000 * args.busy_seconds // SLICES
                slices[way].append(json.loads(run("chrt", "-f", 50, args.build / "ectwin-bench", "cycle", "twin0", STANDARD, 1, 1,
                                                  cycles, 250)))
                ticks[way] += twin.ticks() - before
    return {"load": load, "cycles": [whole(slices[way]) | {"in_kernel": bool(options), "cpu_percent": percent(ticks[way],
                                                                                                        args.busy_seconds)}
                                     for way, options in enumerate(ways)]}


def step_ns(step):
    """Upper edge of a step of the bench's cycles."""
    return 1000 * 10 ** (step / 20)


def whole(slices):
    """The sum of runs; median and p99 are upper edges of steps, 12 % apart."""
    steps = [sum(counts) for counts in zip(*(row["steps"] for row in slices))]
    total = {key: sum(row[key] for row in slices) for key in ("cycles", "frames_lost", "cycles_too_long")}

    def quantile(share):
        return step_ns(next(n for n in range(len(steps)) if sum(steps[:n + 1]) >= share * sum(steps)))

    return total | {"steps": steps, "longest_ns": max(row["longest_ns"] for row in slices),
                    "exchange": {"median_ns": quantile(0.5), "p99_ns": quantile(0.99)}}


def in_process(args, devices, *words, options=(), core=()):
    """Standard output of a master with twins in its process, and the seconds of the whole command."""
    start = time.monotonic()
    out = run(*core, args.build / "ectwin", "with", "--in-process", *options, devices, "--", *words)
    return out, time.monotonic() - start


def round_in_process(args, busy):
    """Master and twins in one process, in turns with an echo over a veth: the run with the median ratio."""
    rows = []
    for _ in range(args.runs):
        with Running(on_core(args, args.build / "ectwin-bench", "echo", "echo1"), False), BusyLoops(busy):
            out, _ = in_process(args, STANDARD, args.build / "ectwin-bench", "round", "{}", "echo0", STANDARD, 1, 1, args.rounds,
                                core=on_core(args))
            rows.append(json.loads(out) | {"busy_loops": busy})
    return middle(rows, lambda row: row["ratio"])


def pysoem(args, devices):
    """The median of runs on the virtual clock; None: pysoem is not installed."""
    if subprocess.run([sys.executable, "-c", "import pysoem"], capture_output=True, check=False).returncode != 0:
        print("run.py: pysoem is not installed, its cycles are not measured: pip install pysoem", file=sys.stderr)
        return None
    rows = []
    for _ in range(args.runs):
        out, seconds = in_process(args, devices, sys.executable, pathlib.Path(__file__).with_name("pysoem_cycles.py"), "{}",
                                  args.cycles, options=["--virtual-time"])
        rows.append(json.loads(out) | {"seconds": seconds})
    return middle(rows, lambda row: row["processor_s"])


def seconds(*command):
    """Elapsed time of a program; None: failed, which may happen to a run on a wire on a busy machine."""
    start = time.monotonic()
    done = subprocess.run([str(word) for word in command], capture_output=True, check=False)
    return time.monotonic() - start if done.returncode == 0 else None


def whole_catalogue(args, device):
    conform = args.build / "ectwin-conform"
    times = [seconds(conform, "--in-process", device) for _ in range(args.runs)]
    if None in times:
        sys.exit(f"run.py: ectwin-conform --in-process {device} fails")
    return {"device": device, "seconds": middle(times, lambda one: one),
            "wire_seconds": seconds(args.build / "ectwin", "with", device, "--", conform, "-i", "{}")}


def inprocess(args):
    starts = [in_process(args, STANDARD, args.build / "ectwin-bench", "first", "{}")[1] for _ in range(7 * args.runs)]
    return {"load": os.getloadavg()[0], "round": [round_in_process(args, busy) for busy in (0, BUSY_LOOPS)],
            "start_ms": 1000 * middle(starts, lambda one: one),
            "pysoem": [row for row in (pysoem(args, STANDARD), pysoem(args, ",".join(["vr-bu-ect-map3"] * 20))) if row],
            "conform": [whole_catalogue(args, device) for device in ("fzm1", STANDARD)]}


def rates(args):
    with twins(args, "vr-bu-ect-map7", 1) as one:
        result = {"sdo": bench(args, "sdo", "twin0", "vr-bu-ect-map7", args.rounds)}
    with twins(args, "vr-bu-ect-map7", 1) as one:
        before = one.ticks()
        result["cycle"] = bench(args, "cycle", "twin0", "vr-bu-ect-map7", 1, 1, args.milliseconds)
        result["cpu_percent_at_1_khz"] = percent(one.ticks() - before, args.milliseconds / 1000)
    return result


def percent(ticks, seconds):
    return round(100 * ticks / os.sysconf("SC_CLK_TCK") / seconds, 1)


def is_root():
    """In the user namespace in which this file was started."""
    return os.geteuid() == 0 and os.readlink("/proc/self/ns/user") == os.environ.get("ECTWIN_BENCH_USERS")


class Hook:
    """The time that programs in the kernel take, which the kernel counts only on request."""

    COUNT = pathlib.Path("/proc/sys/kernel/bpf_stats_enabled")

    def __init__(self, used):
        self.used = used

    def __enter__(self):
        if self.used:
            self.before = self.COUNT.read_text()
            self.COUNT.write_text("1")
        return self

    def __exit__(self, *_):
        if self.used:
            self.COUNT.write_text(self.before)

    def seconds(self):
        if not self.used:
            return 0
        shown = json.loads(run("bpftool", "-j", "prog", "show", "name", "answer"))  # a single program is not in a list
        return sum(program.get("run_time_ns", 0) for program in (shown if isinstance(shown, list) else [shown])) / 1e9


def cycles_of(args, chain, hook, present, touched):
    """The median run, by lost frames and cycles that are too long."""
    runs, duration = [], args.milliseconds / 1000
    before = chain.ticks()
    bench(args, "cycle", "twin0", UNIT, present, touched, 1)
    preparation = chain.ticks() - before  # the way to OP, a part of each run
    for _ in range(args.runs):
        before, in_hook = chain.ticks(), hook.seconds()
        row = bench(args, "cycle", "twin0", UNIT, present, touched, args.milliseconds)
        runs.append(row | {"cpu_percent": percent(chain.ticks() - before - preparation, duration),
                           "hook_percent": round(100 * (hook.seconds() - in_hook) / duration, 1)})
    return middle(runs, lambda one: (one["frames_lost"], one["cycles_too_long"]))


def cycle(args):
    rows = []
    ways = [([], 10), ([], 100), ([], 1000)] + ([(["--in-kernel"], 1000)] if is_root() else [])
    for options, touched in ways:
        with twins(args, UNIT, 1000, *options) as chain, Hook(bool(options)) as hook:
            row = cycles_of(args, chain, hook, 1000, touched) | {"in_kernel": bool(options)}
            if touched == 1000:
                before = chain.ticks()
                time.sleep(args.idle)
                row["cpu_percent_idle"] = percent(chain.ticks() - before, args.idle)
            rows.append(row)
    return rows


def start(args):
    rows = []
    for device in [UNIT, "vr-bu-ect-map7"]:
        with twins(args, device, 1) as one:
            alone = one.kilobytes()
        with twins(args, device, 1000) as many:
            rows.append({"device": device, "twins": 1000, "seconds": round(many.took, 3),
                         "kilobytes_each": round((many.kilobytes() - alone) / 999, 1)})
    return rows


def inside(args):
    """All measurements, in a network namespace: two wires, one with twins, one with an echo."""
    for name in ["twin", "echo"]:
        run("ip", "link", "add", f"{name}0", "type", "veth", "peer", "name", f"{name}1")
        for end in "01":
            run("ip", "link", "set", name + end, "up")
    result = {"machine": machine(), "core": args.core}
    measures = {
        "instructions": instructions,
        "sockets": sockets,
        "round": lambda a: against_echo(a, [], "echo", [1, 8, 64, 199]),
        "spin": lambda a: against_echo(a, ["--busy-poll"], "spin", [1]),
        "kernel": kernel,
        "busy": busy,
        "inprocess": inprocess,
        "rates": rates,
        "cycle": cycle,
        "start": start,
    }
    for part in args.only:
        print(f"run.py: {part}, load {os.getloadavg()[0]:.1f}", file=sys.stderr, flush=True)
        result[part] = measures[part](args)
    args.output.parent.mkdir(parents=True, exist_ok=True)
    args.output.write_text(json.dumps(result, indent=1) + "\n")


def machine():
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return {"cpu": cpu[1] if cpu else "unknown", "kernel": os.uname().release, "load": os.getloadavg()[0]}


# --- the output --------------------------------------------------------------------------------------------------------


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "--:|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def us(times):
    return f"{times['median_ns'] / 1000:.1f}"


def round_table(rows):
    return table(["twins", "bytes", "twin, µs", "echo, µs", "ratio of medians", "p99 of the twin, µs"],
                 [[r["present"], r["bytes"], us(r["twin"]), us(r["echo"]), f"{r['ratio']:.2f}",
                   f"{r['twin']['p99_ns'] / 1000:.1f}"] for r in rows])


def kernel_table(result):
    load = f"Load of the machine at the start: {result['load']:.1f}.\n\n"
    return load + table(["replies", "beside it", "twin, µs", "p99, µs", "echo, µs", "p99 of the echo, µs", "ratio of medians"],
                 [["in the kernel" if r["in_kernel"] else "by the twin", f"{r['busy_loops']} busy loops" if r["busy_loops"] else "nothing",
                   us(r["twin"]), f"{r['twin']['p99_ns'] / 1000:.1f}", us(r["echo"]), f"{r['echo']['p99_ns'] / 1000:.1f}",
                   f"{r['ratio']:.2f}"] for r in result["round"]])


def busy_table(result):
    load = f"Load of the machine at the start: {result['load']:.1f}.\n\n"
    return load + table(["replies", "frames lost", "median, µs", "p99, µs", "longest, µs", "cycles too long", "processor"],
                        [["in the kernel" if r["in_kernel"] else "by the twin", f"{r['frames_lost']} in {r['cycles']} cycles",
                          us(r["exchange"]), f"{r['exchange']['p99_ns'] / 1000:.1f}", f"{r['longest_ns'] / 1000:.0f}",
                          r["cycles_too_long"], f"{r['cpu_percent']} %"] for r in result["cycles"]])


def in_process_tables(result):
    rounds = table(["beside it", "bytes", "in process, µs", "p99, µs", "p99 : median", "echo, µs", "ratio of medians"],
                   [[f"{r['busy_loops']} busy loops" if r["busy_loops"] else "nothing", r["bytes"], us(r["twin"]),
                     f"{r['twin']['p99_ns'] / 1000:.1f}", f"{r['twin']['p99_ns'] / r['twin']['median_ns']:.1f}", us(r["echo"]),
                     f"{r['ratio']:.2f}"] for r in result["round"]])
    runs = [["start of one twin, the whole command", "", f"{result['start_ms'] / 1000:.3f}", "", ""]]
    for r in result["pysoem"]:
        runs.append([f"pysoem, {r['slaves']} twin{'s' if r['slaves'] > 1 else ''}, a cycle each ms, {r['lost']} lost", f"{r['bus_s']:.1f}",
                     f"{r['seconds']:.2f}", f"{r['processor_s']:.2f}", f"{r['bus_s'] / r['processor_s']:.0f}"])
    for r in result["conform"]:
        wire = f"; over a veth {r['wire_seconds']:.1f} s" if r["wire_seconds"] else ""
        runs.append([f"`ectwin-conform`, whole catalogue, {r['device']}{wire}", "",
                     f"{r['seconds']:.2f}", "", ""])
    return {"inprocess": f"Load of the machine at the start: {result['load']:.1f}.\n\n{rounds}", "virtual": table(["run", "bus, s", "elapsed, s", "processor of the cycles, s", "bus : processor"], runs)}


def tables(result):
    """Name of a table in docs/PERFORMANCE.md -> its text."""
    found = {}
    if "round" in result:
        found["machine"] = "{cpu}, Linux {kernel}; load {load:.1f} at the start".format(**result["machine"])
    if result.get("instructions"):
        counts = ["1", "10", "100", "1000"]
        for place, function in [("instructions", "ect_chain_pass"), ("afterwards", "ect_chain_poll")]:
            found[place] = table(["datagram"] + counts + ["1000 : 10"], [
                [name] + [row[n] for n in counts] + [f"{row['1000'] / row['10']:.2f}"]
                for name, row in result["instructions"][function].items()])
    for part in ["round", "spin"]:
        if part in result:
            found[part] = round_table(result[part])
    if "sockets" in result:
        r = result["sockets"]
        found["sockets"] = table(["bytes", "echo as a twin, µs", "echo, µs", "ratio of medians"],
                                 [[r["bytes"], us(r["twin"]), us(r["echo"]), f"{r['ratio']:.2f}"]])
    if "inprocess" in result:
        found |= in_process_tables(result["inprocess"])
    if "rates" in result:
        r = result["rates"]
        found["rates"] = table(["SDO uploads a second", "processor at 1 kHz", "frames lost"], [
            [r["sdo"]["per_second"], f"{r['cpu_percent_at_1_khz']} %", r["cycle"]["frames_lost"]]])
    if "cycle" in result:
        found["cycle"] = table(["replies", "twins", "exchanged each ms", "bytes", "frames lost", "cycles over 1 ms", "processor", "at the hook",
                                "idle"], [
            ["in the kernel" if r["in_kernel"] else "by the twins", r["present"], r["touched"], r["bytes"],
             f"{r['frames_lost']} in {r['cycles']} cycles", r["cycles_too_long"], f"{r['cpu_percent']} %",
             f"{r['hook_percent']} %" if r["in_kernel"] else "",
             f"{r['cpu_percent_idle']} %" if "cpu_percent_idle" in r else ""] for r in result["cycle"]])
    if result.get("kernel"):
        found["kernel"] = kernel_table(result["kernel"])
    if result.get("busy"):
        found["busy"] = busy_table(result["busy"])
    if "start" in result:
        found["start"] = table(["device", "twins", "seconds to ready", "KB each"], [
            [r["device"], r["twins"], r["seconds"], r["kilobytes_each"]] for r in result["start"]])
    return found


def write_tables(result):
    page = ROOT / "docs" / "PERFORMANCE.md"
    text = page.read_text()
    for name, new in tables(result).items():
        text, count = re.subn(rf"(<!-- {name} -->\n).*?(\n<!-- end -->)", lambda m, new=new: m[1] + new + m[2], text,
                              flags=re.S)
        if count != 1:
            sys.exit(f"run.py: docs/PERFORMANCE.md has no place for '{name}'")
    page.write_text(text)


def picture(result):
    """Bars: medians of twin and echo, a pair for each length of chain."""
    rows = result["round"]
    top = max(r["twin"]["median_ns"] for r in rows)
    width, height, parts = 120 * len(rows) + 60, 260, []
    for n, r in enumerate(rows):
        for k, (name, color) in enumerate([("echo", "#9aa5b1"), ("twin", "#2f6fb0")]):
            tall = 180 * r[name]["median_ns"] / top
            x = 60 + 120 * n + 40 * k
            parts.append(f'<rect x="{x}" y="{210 - tall:.1f}" width="36" height="{tall:.1f}" fill="{color}"/>')
            parts.append(f'<text x="{x + 18}" y="{204 - tall:.1f}" text-anchor="middle">{us(r[name])}</text>')
        parts.append(f'<text x="{98 + 120 * n}" y="228" text-anchor="middle">{r["present"]} twins, x {r["ratio"]:.2f}</text>')
    (ROOT / "docs" / "performance.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">'
        f'<text x="10" y="16">Round trip of an LRW, median in microseconds: bare echo (grey), twins (blue)</text>'
        + "".join(parts) + "</svg>\n")


def curve(steps, color, x_of, y_of):
    """A histogram as an area of stairs."""
    shown = [n for n, count in enumerate(steps) if count]
    points = [f"{x_of(step_ns(shown[0] - 1)):.1f},{y_of(0):.1f}"]
    for n in range(shown[0], shown[-1] + 1):
        points += [f"{x_of(step_ns(n - 1)):.1f},{y_of(steps[n]):.1f}", f"{x_of(step_ns(n)):.1f},{y_of(steps[n]):.1f}"]
    points.append(f"{x_of(step_ns(shown[-1])):.1f},{y_of(0):.1f}")
    return f'<polygon points="{" ".join(points)}" fill="{color}" fill-opacity="0.45" stroke="{color}"/>'


def busy_picture(result):
    """Both histograms of the cycles with busy loops, one above the other; both axes are logarithmic."""
    rows = sorted(result["cycles"], key=lambda row: row["in_kernel"])
    most = max(max(row["steps"]) for row in rows)
    left, right, bottom, tall = 70, 700, 300, 230

    def x_of(ns):
        return left + (right - left) * min(max(math.log10(ns / 1000), 0), 6) / 6

    def y_of(count):
        return bottom - tall * (math.log10(count) + 0.3) / (math.log10(most) + 0.3) if count else bottom

    parts = [f'<text x="10" y="18">From the sending of a frame to its reply, {rows[0]["cycles"]} cycles of 250 µs each way, '
             f'beside {BUSY_LOOPS} busy loops</text>']
    for power, name in enumerate(["1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s"]):
        x = x_of(1000 * 10 ** power)
        parts.append(f'<line x1="{x:.1f}" y1="{bottom - tall}" x2="{x:.1f}" y2="{bottom}" stroke="#d5dae0"/>'
                     f'<text x="{x:.1f}" y="{bottom + 18}" text-anchor="middle">{name}</text>')
    for power in range(int(math.log10(most)) + 1):
        y = y_of(10 ** power)
        parts.append(f'<text x="{left - 8}" y="{y + 4:.1f}" text-anchor="end">{10 ** power}</text>')
    for n, (row, color, name) in enumerate(zip(rows, ["#d98032", "#2f6fb0"], ["by the twins' process", "in the kernel"])):
        parts.append(curve(row["steps"], color, x_of, y_of))
        parts.append(f'<text x="{left + 130}" y="{42 + 17 * n}" fill="{color}">{name}: half within {us(row["exchange"])} µs, 99 % within '
                     f'{row["exchange"]["p99_ns"] / 1000:.0f} µs, {row["frames_lost"]} frames lost</text>')
    (ROOT / "docs" / "busy.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{right + 40}" height="{bottom + 30}" font-family="sans-serif" font-size="12">'
        '<rect width="100%" height="100%" fill="#ffffff"/>' + "".join(parts) + "</svg>\n")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1].split("\n\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default=",".join(PARTS))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)))
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "build" / "bench.json")
    args = parser.parse_args()
    args.build, args.output = args.build.resolve(), args.output.resolve()
    args.only = args.only.split(",")
    if not set(args.only) <= set(PARTS):
        parser.error("--only takes some of " + ", ".join(PARTS))
    args.rounds, args.runs, args.milliseconds, args.idle = (2000, 1, 1000, 2) if args.quick else (10000, 3, 5000, 5)
    args.cycles = 6000 if args.quick else 60000
    args.busy_seconds = 6 if args.quick else 60
    if args.inside:
        inside(args)
        return
    missing = [tool for tool in ["ip", "unshare", "taskset"] if not shutil.which(tool)]
    if missing:
        sys.exit(f"run.py: {' and '.join(missing)} not installed: tools/bootstrap.sh bench")
    if not (args.build / "ectwin-bench").exists():
        sys.exit(f"run.py: there is no {args.build}/ectwin-bench: cmake --preset release && cmake --build --preset release")
    root = os.geteuid() == 0
    os.environ["ECTWIN_BENCH_USERS"] = os.readlink("/proc/self/ns/user") if root else ""
    command = ["unshare", "-n" if root else "-Urn", sys.executable, __file__, "--inside", *sys.argv[1:]]
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit(1)
    if args.write:
        result = json.loads(args.output.read_text())
        write_tables(result)
        if "round" in result:
            picture(result)
        if result.get("busy"):
            busy_picture(result["busy"])
    else:
        print(json.dumps(tables(json.loads(args.output.read_text())), indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
