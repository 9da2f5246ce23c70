#!/usr/bin/env python3
"""Flash, RAM and stack of the firmware for boards with a real ESC, against tests/budget/firmware; and the tables of docs/SIZES.md.

usage: firmware.py           builds the presets, checks the budgets, and where the compilers are those that they name, the tables
       firmware.py --write   the same, and rewrites the tables

The stack is a bound: main and what it calls, each call through a pointer counted as the deepest possible one (the device's
functions, the port's). It has to fit what firmware/CMakeLists.txt gives the device. Exits with 77 where there are no compilers.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import stack # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCUMENT = ROOT / "docs/SIZES.md"
BEGIN, END = "<!-- written by tests/check/firmware.py -->\n", "<!-- end -->\n"
PRESETS = {"cortex-m0plus": "arm-none-eabi", "cortex-m4": "arm-none-eabi", "cortex-m7": "arm-none-eabi",
           "riscv32": "riscv64-unknown-elf"}
SMALL = ["-DECT_SMALL"] # as firmware/boards/CMakeLists.txt has it
FRAMES_OF_MAIN = 64 # start-up, and what an interrupt without handler would take


def run(*command):
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}:\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def devices():
    """Name, header, description, bytes of memory, bytes of stack: the table of firmware/CMakeLists.txt."""
    text = (ROOT / "firmware/CMakeLists.txt").read_text()
    return [row.split() for row in re.findall(r'^  "(\S+ \S+ \S+ \d+ \d+)"', text, re.M)]


def sections(tools, image):
    rows = re.findall(r"^\.(\S+)\s+(\d+)\s+\d+$", run(f"{tools}-size", "-A", str(image)), re.M)
    size = {name: int(value) for name, value in rows}
    return {"text": size["vectors"] + size["text"], "data": size["data"], "bss": size["bss"] + size.get("kept", 0),
            "stack": size["stack"]}


def measure():
    """{preset: {device: sections}}"""
    sizes = {}
    for preset, tools in PRESETS.items():
        run("cmake", "--preset", preset)
        run("cmake", "--build", "--preset", preset)
        folder = ROOT / "build" / preset / "firmware"
        sizes[preset] = {name: sections(tools, folder / f"{name}.elf") for name, *_ in devices()}
    return sizes


def over_budget(sizes):
    failed = False
    for line in (ROOT / "tests/budget/firmware").read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        preset, device, flash_limit, ram_limit = line.split()
        size = sizes[preset][device]
        flash = size["text"] + size["data"]
        ram = size["data"] + size["bss"] + size["stack"]
        verdict = "ok" if flash <= int(flash_limit) and ram <= int(ram_limit) else "OVER"
        failed |= verdict != "ok"
        print(f"{preset:14} {device:15} flash {flash:5} (limit {flash_limit}) RAM {ram:5} (limit {ram_limit}) {verdict}")
    return failed


# --- stack ------------------------------------------------------------------------------------------------------------


def sources(header):
    folder = pathlib.Path(header).parent
    rooms = ["od", "slave", "soes", "ports/mmio", "ports/flash", "profiles/cia402", str(folder)]
    found = [path for room in rooms for path in sorted((ROOT / "src" / room).glob("*.c"))]
    unused = {"application.c", "describe.c", "esc_coe.c", "esc_eep.c", "esc_foe.c", # an object list's
              "signals.c", "modbus.c"} # the plant, and what it names
    return [path for path in found if path.name not in unused] + [ROOT / "firmware" / name for name in
                                                                  ("main.c", "on_ectwin/device.c", "plain.c", "no_network.c", "hal.c", "fault.c",
                                                                  "boards/mmio/board.c",
                                                                  "boards/mmio/no_storage.c")]


# Callers through pointers and the functions that they reach, as `file:function`. Calls that stay inside the stack are known to stack.py.
OUTSIDE = ((r"src/slave/(mailbox|pdo)\.c:", None),
           (r"src/slave/memory\.c:", r"firmware/on_ectwin/.*:take$"),
           (r"src/slave/services\.c:ect_services_diagnose", None),  # no device with a firmware names those messages
           (r"src/slave/services\.c:", r"src/slave/(sync|store|pdo_config)\.c:"),
           (r"src/slave/indicator\.c:", r"firmware/boards/"),
           (r"src/slave/", r"src/devices/|src/soes/ecat_slv\.c:.*(read|write|event|line)"),
           (r"src/soes/", r"src/ports/mmio/|firmware/boards/|firmware/hal\.c:"),
           (r"src/devices/", r"src/slave/host\.c:|src/ports/flash/"),
           (r"src/ports/flash/", r"firmware/boards/"),
           (r"firmware/", r"firmware/boards/|src/ports/mmio/"))


def bridge(calls, files):
    """Calls through a pointer as calls of all that it may lead to."""
    where = {function: f"{path.relative_to(ROOT)}:{function}" for function, path in files.items()}
    for function in [f for f in calls if "__indirect_call" in calls[f] and f in where]:
        leads = next((leads for caller, leads in OUTSIDE if re.match(caller, where[function])), None)
        if leads:
            calls[function].update(f for f in where if re.match(leads, where[f]))


def bound(entry, frames, calls):
    """Bytes of the deepest path. Functions that may call each other in a circle count all together, each as often as it may."""
    index, low, pending, circle_of, depth_of = {}, {}, [], {}, {}

    def visit(function):
        index[function] = low[function] = len(index)
        pending.append(function)
        for callee in calls.get(function, ()):
            if callee not in index:
                visit(callee)
            if callee not in circle_of:
                low[function] = min(low[function], low[callee])
        if low[function] == index[function]:
            circle = pending[pending.index(function):]
            del pending[-len(circle):]
            own = sum(frames.get(f, 0) * stack.AGAIN.get(f, 1) for f in circle)
            below = max((depth_of[circle_of[c]] for f in circle for c in calls.get(f, ()) if c in circle_of), default=0)
            circle_of.update({f: function for f in circle})
            depth_of[function] = own + below

    visit(entry)
    return depth_of[circle_of[entry]]


def firmware_stack(row):
    """Bound for a device on a Cortex-M4."""
    _, header, description, memory, _ = row
    mmio = [f"-DMMIO_{value}" for value in ("ESC=0x60000000", "ESC_WIDTH=2", "CLOCK_HZ=100000000", "LAMPS=0")]
    flags = [*SMALL, *mmio, f"-I{ROOT}/firmware", f"-I{ROOT}/firmware/on_ectwin", f"-I{ROOT}/firmware/cpu", f"-I{ROOT}/src/soes",
             f"-DFIRMWARE_DEVICE={description}", f'-DFIRMWARE_DEVICE_HEADER="{header}"', f"-DFIRMWARE_MEMORY={memory}"]
    with tempfile.TemporaryDirectory() as work:
        frames, calls, files = stack.call_graph(work, sources(header), flags)
    bridge(calls, files)
    return bound("main", frames, calls) + FRAMES_OF_MAIN


def over_stack(stacks):
    failed = False
    for name, *_, given in devices():
        verdict = "ok" if stacks[name] <= int(given) else "OVER"
        failed |= verdict != "ok"
        print(f"cortex-m4      {name:18} stack {stacks[name]:5} (given {given}) {verdict}")
    return failed


# --- the tables -------------------------------------------------------------------------------------------------------


def compilers():
    return ", ".join(f"{tools}-gcc {run(f'{tools}-gcc', '-dumpversion').strip()}" for tools in sorted(set(PRESETS.values())))


def services():
    """What size.sh and stack.py print, as rows; their verdict is theirs."""
    said = [subprocess.run([ROOT / "tests/check" / name], capture_output=True, text=True, check=False).stdout
            for name in ("size.sh", "stack.py")]
    return (re.findall(r"-Os (\S+)\s+text\s+(\d+) \(limit (\d+)\)", said[0]),
            re.findall(r"stack (\S+)\s+(\d+) bytes \(limit (\d+)\)", said[1]))


def tables(sizes, stacks):
    lines = [f"\nCompilers: {compilers()}.\n"]
    for preset, devices_of in sizes.items():
        lines.append(f"\n| {preset} | text | data | bss | stack | flash | RAM |\n|---|--:|--:|--:|--:|--:|--:|\n")
        for name, size in devices_of.items():
            flash, ram = size["text"] + size["data"], size["data"] + size["bss"] + size["stack"]
            lines.append(f"| {name} | {size['text']} | {size['data']} | {size['bss']} | {size['stack']} | {flash} | {ram} |\n")
    text, deep = services()
    lines.append("\n## The slave stack, and the cost of each service\n\n"
                 "The sizes are for a Cortex-M4. The stack has neither data nor bss, because the caller provides the memory.\n\n"
                 "| | text | limit |\n|---|--:|--:|\n")
    lines += [f"| {name} | {size} | {limit} |\n" for name, size, limit in text]
    lines.append("\n| stack, without the device's functions and the port's | bytes | limit |\n|---|--:|--:|\n")
    lines += [f"| `{name}` | {size} | {limit} |\n" for name, size, limit in deep]
    lines += [f"| the firmware of {name}, complete | {stacks[name]} | {given} |\n" for name, *_, given in devices()]
    return "".join(lines) + "\n"


def much_the_same(text, new):
    """Not each byte that a change of the core costs is a reason to rewrite the tables; two percent are."""
    pairs = list(zip(re.findall(r"\d+", text), re.findall(r"\d+", new)))
    return re.sub(r"\d+", "", text) == re.sub(r"\d+", "", new) and \
        all(abs(int(a) - int(b)) <= max(32, int(a) // 50) for a, b in pairs)


def document_differs(now, write):
    text = DOCUMENT.read_text()
    before, _, rest = text.partition(BEGIN)
    new = before + BEGIN + now + END + rest.partition(END)[2]
    if write:
        DOCUMENT.write_text(new)
    elif f"Compilers: {compilers()}." in text and not much_the_same(text, new):
        print(f"{DOCUMENT.name} is not what was measured: tests/check/firmware.py --write, and look at the difference")
        return True
    return False


def main():
    if any(not shutil.which(f"{tools}-gcc") for tools in PRESETS.values()):
        print("skipped: no compilers for boards here; tools/bootstrap.sh test installs them")
        return 77
    stacks = {row[0]: firmware_stack(row) for row in devices()}
    failed = over_stack(stacks)
    sizes = measure()
    failed |= over_budget(sizes)
    failed |= document_differs(tables(sizes, stacks), "--write" in sys.argv[1:])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
