#!/usr/bin/env python3
"""The conformance runner over all devices, and the table that docs/conformance.md shows.

usage: conform.py devices ECTWIN CONFORM [--write]   every device passes the cases that apply, as in the table
       conform.py command ECTWIN CONFORM [TEST]      the runner's own command line; the test `million` is run only by name
       conform.py others ECTWIN_OF_TESTS CONFORM     devices that are made for tests, for what no product has
       conform.py defects ECTWIN CONFORM [CF-nnn]    each twin with a defect fails the case that is for it, and no other of its section
                                                     and of a sample of the other cases
       conform.py whole ECTWIN CONFORM [CF-nnn]      each twin with a defect fails the case that is for it, and no other case at all
       conform.py everywhere ECTWIN CONFORM [CF-nnn] each defect in each device is found by its case alone, with every seed

ECTWIN_SEED=N chooses another sample (default 1).
"""
import concurrent.futures
import contextlib
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import xml.dom.minidom

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "docs/conformance.md"
RUNS = len(os.sched_getaffinity(0)) # at a time: a run never waits
BEGIN, END = "<!-- written by tests/integration/conform.py -->\n", "<!-- end -->\n"
CHAIN, FILES = "in a chain", "fzm1 with files"
CHAIN_ARGUMENTS = (["--alias", "7", "vr-bu-ect-map7,fzm1,vr-bu-ect-map3"], ["--slave", "2"]) # and without an ESI file


def words(ectwin, conform, twins, arguments):
    """The command of a run: the twins in the runner's process, on the virtual clock. A command of --plug or --power is a process with
    a clock of its own, so such a run is over the network."""
    where = [] if "--plug" in arguments or "--power" in arguments else ["--in-process", "--virtual-time"]
    return [ectwin, "with", *where, *twins, "--", conform, "-i", "{}", *arguments]


# The library that is preloaded stays until the process ends.
IN_PROCESS = os.environ | {"ASAN_OPTIONS": "detect_leaks=0"}


def call(ectwin, conform, twins, arguments):
    return subprocess.run(words(ectwin, conform, twins, arguments), capture_output=True, text=True, timeout=300, check=False,
                          env=IN_PROCESS)


def call_over_network(ectwin, conform, twins, arguments):
    return subprocess.run([ectwin, "with", *twins, "--", conform, "-i", "{}", *arguments], capture_output=True, text=True,
                          timeout=300, check=False)


def esi_of(device):
    """ESI options for a device of this project: the file of its family, and the schema when there is one."""
    files = [path for path in sorted((ROOT / "esi").glob("*.xml")) if device.startswith(path.stem.removeprefix("ectwin-"))]
    if len(files) != 1:
        sys.exit(f"{device}: expected one file of its family in esi/, got {[path.name for path in files]}")
    schema = os.environ.get("ECTWIN_ESI_SCHEMA")
    return ["--esi", str(files[0]), *(["--schema", schema] if schema else [])]


# --- devices --------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def folder_with_a_file():
    """Options of a twin that offers it, and of a runner that knows it."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "data").write_bytes(bytes(range(256)) * 3)
        yield ["--files", folder, "--files-password", "7", "fzm1"], ["--file", "data", "--password", "7", "--destructive"]


def report(ectwin, conform, name):
    """One run. @return its JSON, and how to run it alone"""
    if name == FILES:
        with folder_with_a_file() as (twins, arguments):
            return run_report(ectwin, conform, name, twins, arguments)
    return run_report(ectwin, conform, name, *(CHAIN_ARGUMENTS if name == CHAIN else ([name], esi_of(name))))


def run_report(ectwin, conform, name, twins, arguments):
    done = call(ectwin, conform, twins, [*arguments, "--format", "json"])
    alone = " ".join(words(ectwin, conform, twins, arguments))
    try:
        return json.loads(done.stdout), alone
    except json.JSONDecodeError:
        sys.exit(f"{name}: no report; exit code {done.returncode}\n{done.stderr}alone: {alone}")


def table(names, reports):
    """The section of the document. Reasons for skips are numbered in the order in which they come."""
    reasons = {}
    lines = [BEGIN, "\n| id | requirement | " + " | ".join(names) + " |\n", "|---|---|" + "---|" * len(names) + "\n"]
    for row in zip(*(r["cases"] for r in reports)):
        cells = []
        for case in row:
            if case["verdict"] == "skip":
                cells.append(f"– {reasons.setdefault(case['reason'], len(reasons) + 1)}")
            else:
                cells.append(case["verdict"])
        lines.append(f"| {row[0]['id']} | {row[0]['title']} | " + " | ".join(cells) + " |\n")
    lines.append("\nSkipped, and why:\n\n")
    lines += [f"{number}. {reason}\n" for reason, number in reasons.items()]
    return "".join(lines) + END


def print_failures(name, result, alone):
    for case in result["cases"]:
        if case["verdict"] in ("fail", "interrupted"):
            print(f"{name}: {case['id']} {case['title']}: {case['reason']}\n  alone: {alone} --only {case['id']}")


def devices(ectwin, conform, write):
    listed = subprocess.run([ectwin, "list"], capture_output=True, text=True, check=True).stdout
    names = [line.split()[0] for line in listed.splitlines()] + [CHAIN, FILES]
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        results = list(pool.map(lambda name: report(ectwin, conform, name), names))
    failed = 0
    for name, (result, alone) in zip(names, results):
        print_failures(name, result, alone)
        failed += result["summary"]["fail"] + result["summary"]["interrupted"]
    text = DOCUMENT.read_text()
    before, _, rest = text.partition(BEGIN)
    now = before + table(names, [result for result, _ in results]) + rest.partition(END)[2]
    if write:
        DOCUMENT.write_text(now)
    elif now != text:
        print(f"{DOCUMENT.name} is not what the runs say: conform.py devices ... --write, and look at the difference")
        for old, new in zip(text.splitlines(), now.splitlines()):
            if old != new:
                print(f"  - {old}\n  + {new}")
        failed += 1
    return failed


# --- defects --------------------------------------------------------------------------------------------------------

# Cases that a defect breaks besides its own, because they rest on the same thing.
FOLLOW = {
    "CF-004": ["CF-096"], "CF-015": ["CF-013"], "CF-025": ["CF-016"], "CF-027": ["CF-060", "CF-095"], "CF-029": ["CF-031"],
    "CF-030": ["CF-020"], "CF-031": ["CF-005"], "CF-033": ["CF-046"], "CF-036": ["CF-022"], "CF-037": ["CF-022"], "CF-038": ["CF-046"],
    "CF-039": ["CF-022"], "CF-041": ["CF-046"], "CF-058": ["CF-026", "CF-086"], "CF-060": ["CF-027", "CF-095"], "CF-065": ["CF-004"], "CF-086": ["CF-058"],
    "CF-E01": ["CF-E05", "CF-E06"],
}
# Twins for defects that the usual twin, an FZM1, cannot have.
GATEWAY = f"esi:{ROOT}/examples/eoe/gateway.xml"
RACK = f"esi:{ROOT}/tests/esi/rack.xml" # modules whose idents a master writes
STATES = f"esi:{ROOT}/tests/esi/states.xml" # TxPDO toggle and state in the inputs
ADS = f"esi:{ROOT}/tests/esi/ads.xml" # CoE and AoE
DRIVES = f"esi:{ROOT}/tests/esi/drives.xml#" # CiA 402, of each shape
MOVE = ["--move", "1048576,1048576,10485760"] # a turn, a turn a second, in 100 ms
SCREW_MOVE = ["--move", "5000,5000,50000"] # the same on a screw of 5 mm, in micrometres
DRIVE_CASES = ["--only", "CF-D*"]
DEFECT_TWINS = {**{id_: [RACK] for id_ in ("CF-M01", "CF-M02", "CF-M02b")}, "CF-M03": [STATES],
                "CF-A01": [ADS], "CF-A02": [ADS],
                **{f"CF-D{number:02}": [f"{DRIVES}SERVO"] for number in range(1, 18)}, "CF-D14": [f"{DRIVES}CYCLIC"],
                **{f"CF-E{number}": [GATEWAY] for number in ("01", "02", "03", "04", "05", "06", "07", "08", "09", "10", "12")},
                "CF-032": ["fzm1,vr-bu-ect-map7"], "CF-073": ["vr-bu-ect-map7"]}
ALIAS = ["--alias", "5"] # without one, CF-046 waits for 2 s in each run, and is skipped
IN_OTHERS = ["CF-072b", *(f"CF-S0{number}" for number in range(1, 7))] # no product can have them; devices made for tests do
DEFECTS_LEAST = 130
SAMPLE = 8 # cases of other sections that a defect is tried with
SEED = os.environ.get("ECTWIN_SEED", "1")


def case_of(id_):
    """CF-087 of CF-087b, its second defect."""
    return id_.rstrip("bcd")


def defect(ectwin, conform, id_, only):
    """@param only options that choose cases. @return nothing, or what is wrong"""
    if id_ == "CF-084":
        with folder_with_a_file() as (twins, arguments):
            return find_defect(ectwin, conform, id_, ["--break", id_, *ALIAS, *twins], [*arguments, *only])
    devices_ = DEFECT_TWINS.get(id_, ["fzm1"])
    arguments = [] if devices_ in ([GATEWAY], [RACK], [STATES], [ADS]) or devices_[0].startswith(DRIVES) else esi_of(devices_[-1].split(",")[0])
    if id_.startswith("CF-D"):
        arguments, only = MOVE if id_ >= "CF-D05" else [], DRIVE_CASES
    if id_ == "CF-096b":
        arguments += ["--plug", f"{ectwin} unplug 1 >&2 && sleep 0.1 && {ectwin} plug 1 >&2"]
    return find_defect(ectwin, conform, id_, ["--break", id_, *ALIAS, *devices_], [*arguments, *only])


def find_defect(ectwin, conform, id_, twins, arguments):
    done = call(ectwin, conform, twins, [*arguments, "--format", "json"])
    alone = " ".join(words(ectwin, conform, twins, arguments))
    try:
        cases = json.loads(done.stdout)["cases"]
    except json.JSONDecodeError:
        return f"{id_}: no report; exit code {done.returncode}\n{done.stderr}  alone: {alone}"
    failed = [c["id"] for c in cases if c["verdict"] == "fail"]
    expected = sorted([case_of(id_), *FOLLOW.get(id_, [])])
    return "" if failed == expected else f"{id_}: expected to fail {expected}, got {failed}\n  alone: {alone}"


def section_and_sample(conform):
    """@return a function of a defect's id: options that choose the section of its case, the cases that it breaks besides, and a sample"""
    listed = subprocess.run([conform, "--list"], capture_output=True, text=True, check=True).stdout
    section = {line.split()[0]: line.split()[1] for line in listed.splitlines()}

    def chosen(id_):
        case = case_of(id_)
        needed = [other for other in section if section[other] == section[case] or other in FOLLOW.get(id_, [])]
        others = [other for other in section if other not in needed]
        return ["--only", ",".join(needed + random.Random(f"{SEED} {id_}").sample(others, SAMPLE))]
    return chosen


def defects(ectwin, conform, only):
    return all_defects(ectwin, conform, only, section_and_sample(conform))


def whole(ectwin, conform, only):
    return all_defects(ectwin, conform, only, lambda id_: [])


def all_defects(ectwin, conform, only, chosen):
    listed = subprocess.run([ectwin, "run", "--break", "help"], capture_output=True, text=True, check=True).stdout
    ids = [line.split()[0] for line in listed.splitlines() if line.startswith(only or "CF-")]
    ids = [id_ for id_ in ids if id_ not in IN_OTHERS]
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        wrong = [text for text in pool.map(lambda id_: defect(ectwin, conform, id_, chosen(id_)), ids) if text]
    if not only and len(ids) < DEFECTS_LEAST:
        wrong.append(f"expected at least {DEFECTS_LEAST} defects, got {len(ids)}")
    print(*wrong, f"{len(ids)} defects, each found by its case" if not wrong else "", sep="\n")
    return len(wrong)


# Defects that a device cannot have: `--break help` names the need. Other pairs of defect and device either fail or skip the case.
WITHOUT = {
    "CF-018": ["pmctendo-dd5"], "CF-019": ["vr-bu-ect-map1", "optoncdt2300"], "CF-048": ["vr-bu-ect-map1", "optoncdt2300"],
    "CF-049": ["vr-bu-ect-map1", "optoncdt2300"], "CF-068": ["pmctendo-dd5"], "CF-072b": ["*"],
    "CF-074": ["vr-bu-ect-map1", "optoncdt2300", "pmctendo-dd5"], "CF-078": ["optoncdt2300"], "CF-082": ["optoncdt2300"],
}
SEEDS = {"CF-094": range(1, 5), "CF-094b": range(1, 5)}


def one_case(ectwin, conform, id_, device, seed):
    """@return nothing, or what is wrong: each defect is found by its case, or cannot be in that device"""
    arguments = [*esi_of(device), "--seed", str(seed), "--only", case_of(id_), "--format", "json",
                 *(["--plug", f"{ectwin} unplug 1 >&2 && sleep 0.1 && {ectwin} plug 1 >&2"] if id_ == "CF-096b" else [])]
    case = json.loads(call(ectwin, conform, ["--break", id_, device], arguments).stdout)["cases"][0]
    absent = set(WITHOUT.get(id_, [])) & {device, "*"}
    if case["verdict"] == "skip" or case["verdict"] == ("pass" if absent else "fail"):
        return ""
    return f"{id_} in {device}, seed {seed}: expected {'pass' if absent else 'fail'}, got {case['verdict']}: {case['reason']}"


def everywhere(ectwin, conform, only):
    """Each defect in each device, by its case alone; those that random numbers could find, with several seeds"""
    devices_ = [line.split()[0] for line in subprocess.run([ectwin, "list"], capture_output=True, text=True, check=True).stdout.splitlines()]
    listed = subprocess.run([ectwin, "run", "--break", "help"], capture_output=True, text=True, check=True).stdout
    ids = [line.split()[0] for line in listed.splitlines() if line.startswith(only or "CF-")]
    todo = [(id_, device, seed) for id_ in ids for device in devices_ for seed in SEEDS.get(id_, [1])]
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        wrong = [text for text in pool.map(lambda one: one_case(ectwin, conform, *one), todo) if text]
    print(*wrong, f"{len(todo)} pairs of a defect and a device" if not wrong else "", sep="\n")
    return len(wrong)


# --- devices made for tests ---------------------------------------------------------------------------------------------


SOE_FOLLOW = {6: ["CF-S02"]} # an attribute alone is that of the read of all elements

# Device, options of its run, the case that it is made for, cases that fail.
OTHERS = (
    ("network", ["--only", "CF-07*"], "CF-072", []),
    ("--break CF-072b network", ["--only", "CF-07*"], "CF-072", ["CF-072"]),
    ("network", ["--only", "CF-02[34567],CF-058,CF-08[56]"], "CF-085", []),
    ("careless", ["--only", "CF-02[34567],CF-058,CF-08[56]"], "CF-085", ["CF-085"]),
    (GATEWAY, ["--only", "CF-085,CF-E*"], "CF-085", []),
    (GATEWAY, ["--only", "CF-E*"], "CF-E02", []),
    (f"--eoe echo {GATEWAY}", ["--only", "CF-E*"], "CF-E03", []),
    (ADS, ["--only", "CF-A*,CF-02[34567],CF-058,CF-07*,CF-086"], "CF-A01", []),
    (ADS, ["--only", "CF-A*"], "CF-A02", []),
    (RACK, ["--only", "CF-M*,CF-07*"], "CF-M01", []),
    (f"--module 2=0x120 {RACK}", ["--only", "CF-M*"], "CF-M02", []),
    (f"--set modules.strict=1 {RACK}", ["--only", "CF-M*"], "CF-M02", []),
    (STATES, ["--only", "CF-M*,CF-07*"], "CF-M03", []),
    ("soedev", [], "CF-S01", []),
    *((f"--break CF-S0{number} soedev", ["--only", "CF-S*,CF-02*"], f"CF-S0{number}", SOE_FOLLOW.get(number, []) + [f"CF-S0{number}"])
      for number in range(1, 7)),
    (f"{DRIVES}SERVO", [*DRIVE_CASES, *MOVE], "CF-D11", []),
    (f"{DRIVES}SMALL", [*DRIVE_CASES, *MOVE], "CF-D12", []),
    (f"{DRIVES}BARE", [*DRIVE_CASES, *MOVE], "CF-D13", []),
    (f"{DRIVES}SPEED", [*DRIVE_CASES, *MOVE], "CF-D09", []),
    (f"{DRIVES}DUAL", [*DRIVE_CASES, *MOVE], "CF-D13", []),
    (f"{DRIVES}WIDE", [*DRIVE_CASES, *MOVE], "CF-D13", []),
    (f"{DRIVES}SERVO", ["--only", "CF-D15,CF-D16", *MOVE], "CF-D16", []),
    (f"{DRIVES}CYCLIC", [*DRIVE_CASES, *MOVE], "CF-D14", []),
    (f"{DRIVES}CYCLIC", ["--only", "CF-D15,CF-D17", *MOVE], "CF-D17", []),
    (f"{DRIVES}SCREW", [*DRIVE_CASES, *SCREW_MOVE], "CF-D13", []),
    ("--set status_bits=402 pmctendo-dd5", [*DRIVE_CASES, *MOVE], "CF-D17", []),
    ("pmctendo-dd5", [*DRIVE_CASES, *MOVE], "CF-D09", ["CF-D10", "CF-D11", "CF-D12", "CF-D13", "CF-D14", "CF-D15", "CF-D17"]), # bits 10, 12, 13 of the manual
    (f"--set axis1.jam=1 {DRIVES}SERVO", ["--only", "CF-D01,CF-D05,CF-D13", *MOVE], "CF-D05", ["CF-D13"]),
    ("hesitant", ["--only", "CF-084", "--file", "data", "--destructive"], "CF-084", []),
)


# Slaves that lie in CoE: the run ends with 2 and the reason.
LIARS = {
    "liar-upload-4g": "slave 1 cannot be examined", "liar-no-uploads": "no reply within 2000 ms",
    "liar-no-replies": "no reply within 2000 ms", "liar-toggle": "1C12:00: a segment with the wrong toggle bit",
    "liar-other-index": "is the reply to the request", "liar-endless-list": "slave 1 cannot be examined",
    "liar-endless-mails": "slave 1 cannot be examined",
}


def liar(ectwin, conform, device):
    done = call(ectwin, conform, [device], ["--format", "json"])
    return "" if done.returncode == 2 and LIARS[device] in done.stderr and done.stdout == "" else \
        f"{device}: expected exit code 2 and '{LIARS[device]}', got {done.returncode}: {done.stderr}"


def others(ectwin, conform, _):
    """Ethernet over EtherCAT: a device that has it passes, one that puts together what does not belong together fails.
    Files: one that is BUSY until a request is repeated passes. Segments: one that serves an aborted transfer fails. Liars end the run with a reason"""
    def other(device, arguments, made_for, expected):
        done = call(ectwin, conform, device.split(), [*arguments, "--format", "json"])
        cases = json.loads(done.stdout)["cases"]
        its = next(c for c in cases if c["id"] == made_for)
        failed = [c["id"] for c in cases if c["verdict"] == "fail"]
        return "" if failed == expected and its["verdict"] != "skip" else \
            f"{device}: expected to fail {expected}, got {failed}; {made_for}: {its['verdict']}, {its['reason']}\n" \
            f"  alone: {ectwin} with {device} -- {conform} -i {{}} {' '.join(arguments)}"
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        texts = [*pool.map(lambda row: other(*row), OTHERS), *pool.map(lambda device: liar(ectwin, conform, device), LIARS)]
    wrong = [text for text in texts if text]
    print(*wrong, sep="\n")
    return len(wrong)


# --- command line -----------------------------------------------------------------------------------------------------


def expect(what, expected, got):
    if expected != got:
        raise AssertionError(f"{what}: expected {expected!r}, got {got!r}")


def contains(what, part, text):
    if part not in text:
        raise AssertionError(f"{what}: expected {part!r} in {text!r}")


def address_goes_back(ectwin, conform):
    """a slave that fails a case with an address that was set for the case has its previous one afterwards"""
    twice = f'{conform} -i {{}} --only CF-E03; exec {conform} -i {{}} --only CF-085 --format json'
    done = subprocess.run([ectwin, "with", "--break", "CF-E03", GATEWAY, "--", "sh", "-c", twice.replace("{}", "$ECTWIN_IFACE")],
                          capture_output=True, text=True, timeout=300, check=False)
    first, _, second = done.stdout.partition("{")
    contains("CF-E03", "1 fail", first)
    case = next(c for c in json.loads("{" + second)["cases"] if c["id"] == "CF-085")
    expect("CF-085", ("pass", "the slave has no address: the arrival of frames cannot be judged"), (case["verdict"], case["reason"]))


def exit_codes(ectwin, conform):
    """0 with all passed, 2 without a slave or an interface, 64 for wrong usage, each with a line that names the remedy"""
    done = call_over_network(ectwin, conform, ["fzm1"], ["--only", "CF-001"])
    expect("a good run", (0, '{"event":"ready","iface":"ecat0","slaves":1}\n'), (done.returncode, done.stderr))
    for arguments, code, text in ((["--slave", "3"], 2, "there is no slave 3: 1 replied on 'ecat0'"),
                                  (["--only", "CF-777"], 64, "no case is selected"),
                                  (["--move", "1,2"], 64, "--move takes three numbers, DISTANCE,SPEED,ACCELERATION"),
                                  (["--move", "0,1,1"], 64, "--move takes a number from 1"),
                                  (["--slave", "x"], 64, "--slave takes a number from 1"), (["--format", "pdf"], 64, "--format is"),
                                  (["-o", "/no/such/file", "--only", "CF-001"], 2, "cannot write '/no/such/file'"),
                                  (["--pcap", "/no/such/file"], 2, "cannot write '/no/such/file'")):
        done = call_over_network(ectwin, conform, ["fzm1"], arguments)
        expect(" ".join(arguments), code, done.returncode)
        contains(" ".join(arguments), text, done.stderr)
    done = subprocess.run([conform, "-i", "nosuch0"], capture_output=True, text=True, check=False)
    expect("no such interface", 2, done.returncode)
    contains("no such interface", "there is no network interface of that name", done.stderr)
    expect("no interface named", 64, subprocess.run([conform], capture_output=True, check=False).returncode)
    expect("two places", 64, subprocess.run([conform, "-i", "lo", "--in-process", "fzm1"], capture_output=True, check=False).returncode)


def long_run(conform, device, only, notes):
    """A run with --long: each case passes, with the note of it"""
    done = subprocess.run([conform, "--in-process", device, "--long", "--only", only, "--format", "json"], capture_output=True,
                          text=True, check=False, env=IN_PROCESS)
    cases = json.loads(done.stdout)["cases"]
    expect(device, (0, ["pass"] * len(notes)), (done.returncode, [c["verdict"] for c in cases]))
    for note, case in zip(notes, cases):
        expect(f"{case['id']}: {note}", True, re.fullmatch(note, case["reason"]) is not None)


def million(_, conform):
    """--in-process, --long: a million mails, frames and requests (CF-094)"""
    long_run(conform, "fzm1", "CF-094", ["10[0-9]{5} mails, frames and requests"])


def in_process(_, conform):
    """--in-process: twins without a network; with --long an hour without a master (CF-049)"""
    long_run(conform, "fzm1", "CF-001,CF-049", [".*", "3600 s without a master"])
    long_run(conform, "fzm1,vr-bu-ect-map7", "CF-010", [".*"])
    done = subprocess.run([conform, "--in-process", "nosuch"], capture_output=True, text=True, check=False)
    contains("an unknown device", "there is no device 'nosuch'", done.stderr)
    with tempfile.TemporaryDirectory() as folder:
        alone = shutil.copy(conform, folder)
        done = subprocess.run([alone, "--in-process", "fzm1"], capture_output=True, text=True, check=False)
    expect("without ectwin", 2, done.returncode)
    contains("without ectwin", "ectwin', which --in-process needs", done.stderr)


def equal_runs(_, conform):
    """--in-process: three runs of the whole catalogue have the same frames at the same times, whatever the load of the machine"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.pcapng"
        hashes = set()
        for _ in range(3):
            subprocess.run([conform, "--in-process", "fzm1,vr-bu-ect-map7", "--pcap", path], capture_output=True, check=False)
            hashes.add(hashlib.sha256(path.read_bytes()).hexdigest())
        expect("frames", True, len(list(frames_of(path.read_bytes()))) > 10000)
    expect("captures that differ", 1, len(hashes))


def listing(_, conform):
    """--list needs no slave; each id once, grouped by section; --only and --skip take patterns"""
    def ids(*arguments):
        return [id_ for id_, _ in rows(*arguments)]

    def rows(*arguments):
        done = subprocess.run([conform, "--list", *arguments], capture_output=True, text=True, check=True)
        return [line.split()[:2] for line in done.stdout.splitlines()]
    letters = [letter for _, letter in rows()]
    expect("sections, each in one piece", sorted(letters), letters)
    every = ids()
    expect("ids that occur twice", [], [i for i in every if every.count(i) > 1])
    expect("--only", ["CF-033"] + [i for i in every if i.startswith("CF-04")], ids("--only", "CF-033,CF-04*"))
    expect("--skip", [i for i in every if i != "CF-004"], ids("--skip", "CF-004"))
    expect("both", ["CF-001"], ids("--only", "CF-00[12]", "--skip", "CF-002"))


def formats(ectwin, conform):
    """JSON, JUnit and HTML are well-formed, name each case, and refer to nothing outside"""
    chosen = ["--only", "CF-00[1-4],CF-045"]
    result = json.loads(call(ectwin, conform, ["fzm1"], [*chosen, "--format", "json"]).stdout)
    expect("cases in JSON", ["CF-001", "CF-002", "CF-003", "CF-004", "CF-045"], [c["id"] for c in result["cases"]])
    expect("skips are counted", 1, result["summary"]["skip"])
    evidence = result["cases"][1]["evidence"]
    expect("evidence of both directions", {"step", "sent", "received"}, {e["kind"] for e in evidence})
    numbers = [e["frame"] for e in evidence if e["kind"] != "step"]
    expect("frames are numbered as they came", (sorted(numbers), result["cases"][1]["last_frame"]), (numbers, numbers[-1]))
    junit = xml.dom.minidom.parseString(call(ectwin, conform, ["fzm1"], [*chosen, "--format", "junit"]).stdout)
    expect("test cases in JUnit", 5, len(junit.getElementsByTagName("testcase")))
    expect("skipped in JUnit", 1, len(junit.getElementsByTagName("skipped")))
    html = call(ectwin, conform, ["fzm1"], [*chosen, "--format", "html"]).stdout
    for word in ("src=", "url(", "@import"):
        expect(f"{word} in HTML", False, word in html)
    for target in re.findall('href="([^"]*)', html):
        contains("target of a link in HTML", f'id="{target.removeprefix("#")}"', html)
    contains("HTML", 'id="CF-003"', html)


def report_fields(ectwin, conform):
    """HTML: verdict first, with a link to each failure; device, tool, command line, ESI hash; operator and firmware, or blanks"""
    esi = ROOT / "esi/ectwin-fzm1.xml"
    chosen = ["--esi", str(esi), "--only", "CF-01[67]", "--format", "html"]
    html = call(ectwin, conform, ["--break", "CF-016", "fzm1"], [*chosen, "--operator", "Zoë <QA>", "--firmware", "1.2"]).stdout
    version = subprocess.run([conform, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    places = [html.find(text) for text in (">FZM1: EtherCAT conformance</h1>", "<b>FAIL</b>", '<a href="#CF-016">',
                                           "<td><span>1.2</span>", hashlib.sha256(esi.read_bytes()).hexdigest(),
                                           "Zoë &lt;QA&gt;", version, "--only 'CF-01[67]'", 'id="CF-016"')]
    expect("fields, in this order", True, -1 not in places and places == sorted(places))
    html = call(ectwin, conform, ["fzm1"], chosen).stdout
    contains("without a failure", "<b>PASS</b>", html)
    expect("blank fields for operator and firmware", 2, html.count('class="blank">&nbsp;'))


def output_lost(_, conform):
    """--version names the version; --help and --list into a full disk end with 2 and a line"""
    done = subprocess.run([conform, "--version"], capture_output=True, text=True, check=True)
    expect("--version", True, re.fullmatch(r"ectwin-conform \d+\.\d+\.\d+\n", done.stdout) is not None)
    for option in ("--help", "--list", "--version"):
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([conform, option], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        expect(f"{option} >/dev/full", (2, "ectwin-conform: cannot write to standard output: No space left on device\n"),
               (done.returncode, done.stderr))


def end_of_frame(ectwin, conform):
    """CF-020: a chip that changes a SyncManager's status at the end of the frame passes all cases"""
    done = call(ectwin, conform, ["--break", "END-OF-FRAME", "fzm1"], ["--format", "json"])
    expect("cases that fail", [], [(c["id"], c["reason"]) for c in json.loads(done.stdout)["cases"] if c["verdict"] == "fail"])


def canary(ectwin, conform):
    """A mailbox that one case ends makes one failure; each later case is not judged since that one"""
    chosen = ["--only", "CF-07[1-4],CF-08[37]", "--format"]
    done = call(ectwin, conform, ["--break", "DEAD-MAILBOX", "fzm1"], [*chosen, "json"])
    result = json.loads(done.stdout)
    expect("exit code", 1, done.returncode)
    expect("verdicts", ["pass", "fail", "skip", "unjudged", "unjudged", "unjudged"], [c["verdict"] for c in result["cases"]])
    expect("summary", (1, 3), (result["summary"]["fail"], result["summary"]["unjudged"]))
    for case in result["cases"][3:]:
        contains(f"reason of {case['id']}", "not judged since CF-072: ", case["reason"])
    revived = call(ectwin, conform, ["--break", "DEAD-MAILBOX", "fzm1"], [*chosen, "text", "--power", "exit 1"])
    contains("a --power that fails changes nothing", "1 fail, 1 skip, 3 not judged", revived.stdout)


def source_address(ectwin, conform):
    """Frames leave with the interface's unicast address; the first ESC marks it as locally administered"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.pcapng"
        call_over_network(ectwin, conform, ["fzm1"], ["--only", "CF-00[12],CF-013,CF-095", "--pcap", str(path)])
        sources = {frame[6] & 3 for frame in frames_of(path.read_bytes())}
    expect("low bits of the first byte: sent and received", {0, 2}, sources)


def frames_of(data):
    """The EtherCAT frames of a pcapng file"""
    at = 0
    while at < len(data):
        kind, total, length = (int.from_bytes(data[at + n:at + n + 4], sys.byteorder) for n in (0, 4, 20))
        if kind == 6 and data[at + 40:at + 42] == b"\x88\xa4":
            yield data[at + 28:at + 28 + length]
        at += total


def capture(ectwin, conform):
    """--pcap: a pcapng in which each case's first frame carries its title"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.pcapng"
        result = json.loads(call(ectwin, conform, ["fzm1"], ["--only", "CF-00[12]", "--format", "json", "--pcap",
                                                             str(path)]).stdout)
        data = path.read_bytes()
    at, frame, titles = 0, 0, {}
    while at < len(data):
        kind, total = (int.from_bytes(data[at + n:at + n + 4], sys.byteorder) for n in (0, 4))
        if kind == 6:
            frame += 1
            for case in result["cases"]:
                if f"{case['id']} {case['title']}".encode() in data[at:at + total]:
                    titles[case["id"]] = frame
        at += total
    expect("the file ends with a block", len(data), at)
    expect("frames that carry the titles", {c["id"]: c["first_frame"] for c in result["cases"]}, titles)


def on_request(ectwin, conform):
    """--stress, --fuzz and --timing are not run unasked; JSON, text and HTML contain their histograms"""
    listed = subprocess.run([conform, "--list"], capture_output=True, text=True, check=True).stdout
    expect("unasked", False, any(word in listed for word in ("STRESS", "FUZZ", "TIMING")))
    asked = ["--stress=1", "--fuzz=1", "--timing", "--seed", "7", "--only", "STRESS,FUZZ,TIMING"]
    result = json.loads(call(ectwin, conform, ["fzm1"], [*asked, "--format", "json"]).stdout)
    for case in result["cases"]:
        expect(f"{case['id']}: {case['reason']}", "pass", case["verdict"])
    expect("cases", 3, len(result["cases"]))
    mails = next(t for t in result["timings"] if t["name"] == "a mailbox request and its reply")
    expect("values of a histogram", 200, sum(c["count"] for c in mails["classes"]))
    timing = ["--timing", "--only", "TIMING"]
    contains("HTML", "<svg", call(ectwin, conform, ["fzm1"], [*timing, "--format", "html"]).stdout)
    contains("text", "INIT to PREOP: 20 times", call(ectwin, conform, ["fzm1"], timing).stdout)


# Mistakes in the file: the text to change, the change, and the cases that find it.
MISTAKES = {
    "another product code": ("<Device ", 'ProductCode="#x00F20001"', 'ProductCode="#x00F20009"', "CF-057"),
    "a revision that the slave is too old for": ("<Device ", 'RevisionNo="#x00010000"', 'RevisionNo="#x00020000"', "CF-057"),
    "a protocol that is not there": ("<Fmmu>", "</Mailbox>", "<FoE/></Mailbox>", "CF-058"),
    "another size of the EEPROM": ("<Eeprom>", "<ByteSize>2048<", "<ByteSize>4096<", "CF-059"),
    "another PDI": ("<Eeprom>", "<ConfigData>08", "<ConfigData>80", "CF-059"),
    "a mailbox elsewhere": ("<Fmmu>", 'StartAddress="#x1000"', 'StartAddress="#x1F00"', "CF-060"),
    "another order of mapped entries": ("<RxPdo", "<SubIndex>1<", "<SubIndex>2<", "CF-061"),
    "a PDO of another name, which is an object's too": ("<RxPdo", "<Name>Command area", "<Name>Command", "CF-061,CF-077"),
    "another clock mode": ("<Dc>", "<AssignActivate>#x0300<", "<AssignActivate>#x0700<", "CF-062"),
    "an attribute that is obsolete": ("<Fmmu>", "<Sm ", '<Sm OneByteMode="1" ', "CF-063"),
    "another name of the device": ("<Device ", "<Name>FZM1<", "<Name>FZM2<", "CF-064"),
    "an object of another name": ("<Objects>", "<Name>Device type<", "<Name>Type of device<", "CF-077"),
}
COMPARED = "CF-05[4-9],CF-06*,CF-07[67]"


def wrong_file(ectwin, conform):
    """--esi: the file of the device passes all cases that compare with it, and each mistake in it fails just its cases"""
    def failed(path):
        done = call(ectwin, conform, ["fzm1"], ["--esi", str(path), "--only", COMPARED, "--format", "json"])
        return [c["id"] for c in json.loads(done.stdout)["cases"] if c["verdict"] == "fail"]
    whole = (ROOT / "esi/ectwin-fzm1.xml").read_text()
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "changed#1.xml"
        path.write_text(whole)
        expect("the file as it is", [], failed(path))
        for what, (after, text, change, ids) in MISTAKES.items():
            at = whole.find(text, whole.find(after))
            expect(f"{what}: {text} is in the file", True, at > 0)
            path.write_text(whole[:at] + change + whole[at + len(text):])
            expect(what, ids.split(","), failed(path))


def files_named(ectwin, conform):
    """--esi: what cannot be read ends with 2 and a line; without a file, cases that need one are skipped; reports name it"""
    fzm1, lot = str(ROOT / "esi/ectwin-fzm1.xml"), str(ROOT / "tests/esi/digital.xml")
    for arguments, code, text in ((["--esi", "/no/such.xml"], 2, "/no/such.xml: No such file"),
                                  (["--esi", f"{lot}#DI5"], 2, 'no device "DI5" in it'),
                                  (["--esi", lot], 2, "both fit: name one"),
                                  (["--esi", fzm1, "--schema", "/no/such.xsd"], 2, "/no/such.xsd: the schema"),
                                  (["--schema", "a.xsd"], 64, "name it with --esi")):
        done = call(ectwin, conform, ["fzm1"], [*arguments, "--only", "CF-057"])
        expect(" ".join(arguments), code, done.returncode)
        contains(" ".join(arguments), text, done.stderr)
    without = json.loads(call(ectwin, conform, ["fzm1"], ["--only", "CF-063,CF-077", "--format", "json"]).stdout)
    expect("without a file", [("skip", "no ESI file was given (--esi FILE)")] * 2,
           [(c["verdict"], c["reason"]) for c in without["cases"]])
    another = call(ectwin, conform, ["fzm1"], ["--esi", f"{lot}#DO16", "--only", "CF-057"])
    expect("another device's file", 1, another.returncode)
    contains("another device's file", f"ESI file: {lot}, DO16 revision 0x00010000", another.stdout)


def move(ectwin, conform):
    """--move: without it no axis is enabled; an axis beyond its distance is stopped, and the case fails"""
    for arguments, verdict, reason in (([], "skip", "needs --move"), (MOVE, "pass", ""),
                                       (["--move", "1000,1048576,10485760"], "fail", "expected at most 1000 units of --move")):
        done = call(ectwin, conform, [f"{DRIVES}SERVO"], [*arguments, "--only", "CF-D11", "--format", "json"])
        case = json.loads(done.stdout)["cases"][0]
        expect(" ".join(arguments), verdict, case["verdict"])
        contains(" ".join(arguments), reason, case["reason"])


def files(ectwin, conform):
    """--file: what was in the file is in it afterwards; without --destructive it is read only"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "data"
        path.write_bytes(b"as before" * 100)
        before = path.stat().st_mtime_ns
        for arguments, reason in (([], "refusals only; name a file to read with --file"),
                                  (["--file", "data"], "900 bytes read; written with --destructive only")):
            done = call(ectwin, conform, ["--files", folder, "fzm1"], [*arguments, "--only", "CF-084", "--format", "json"])
            expect("verdict", [("pass", reason)], [(c["verdict"], c["reason"]) for c in json.loads(done.stdout)["cases"]])
        expect("not written", before, path.stat().st_mtime_ns)
        done = call(ectwin, conform, ["--files", folder, "fzm1"], ["--file", "data", "--destructive", "--only", "CF-084"])
        expect("written", 0, done.returncode)
        expect("the file was written", True, path.stat().st_mtime_ns != before)
        expect("its content", b"as before" * 100, path.read_bytes())
        expect("remaining files", ["data"], os.listdir(folder))
        done = call(ectwin, conform, ["--files", folder, "fzm1"], ["--file", "date", "--only", "CF-084"])
        contains("a file that is not there", "'date' in PREOP: expected data or error 0x8008, got error 0x8001", done.stdout)


def power(ectwin, conform):
    """--power: the slave is switched off and on by that command and found again; one that does not do it is noticed"""
    chosen = ["--only", "CF-047,CF-096", "--format", "json"]
    cases = json.loads(call(ectwin, conform, ["fzm1"], [*chosen, "--power", f"{ectwin} set restart=1 >&2"]).stdout)["cases"]
    expect("with it", [("pass", ""), ("pass", "address lost; plug pulled; power off and on")],
           [(c["verdict"], c["reason"]) for c in cases])
    cases = json.loads(call(ectwin, conform, ["fzm1"], [*chosen, "--only", "CF-047", "--power", "exit 3"]).stdout)["cases"]
    expect("one that fails", [("fail", "--power 'exit 3': expected exit code 0, got 3")],
           [(c["verdict"], c["reason"]) for c in cases])


LONG = ["--stress=60"] # a busy machine sees the middle of a run late


def in_the_middle(ectwin, conform, arguments, what):
    """Runs the shell commands `what` when a run, $run, has come to CF-016, which its capture shows"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.pcapng"
        script = (f"{conform} -i $ECTWIN_IFACE {arguments} {' '.join(LONG)} --pcap {path} & run=$!; "
                  f"until grep -q 'CF-016 A' {path}; do sleep 0.05; done; {what}")
        return subprocess.run([ectwin, "with", "fzm1", "--", "sh", "-c", script], capture_output=True, text=True,
                              timeout=300, check=False)


def interrupted(ectwin, conform):
    """Ctrl-C: what ran is reported, exit code 130, the slave is back in INIT"""
    done = in_the_middle(ectwin, conform, "", "kill -INT $run; wait $run; echo exit $?; "
                         f"{conform} -i $ECTWIN_IFACE --only CF-001 | tail -1")
    contains("after Ctrl-C", "exit 130", done.stdout)
    contains("after Ctrl-C", "interrupted", done.stdout)
    contains("the run after", "1 pass, 0 warn, 0 fail, 0 skip", done.stdout)


def dead_slave(ectwin, conform):
    """A slave that fails in the middle of a run: each case left has its verdict, soon, and the run ends with 1"""
    done = in_the_middle(ectwin, conform, "--format json", "ip link set $ECTWIN_IFACE down; wait $run")
    expect("exit code", 1, done.returncode)
    cases = json.loads(done.stdout)["cases"]
    planned = len(subprocess.run([conform, *LONG, "--list"], capture_output=True, text=True, check=True).stdout.splitlines())
    expect("cases with a verdict", planned, len(cases))
    expect("the first case, alive", "pass", cases[0]["verdict"])
    last = [c for c in cases if c["verdict"] != "skip"][-1]
    contains("reason of the last case", "no reply", last["reason"])


def command(ectwin, conform, only):
    tests = [power, in_process, move, canary, dead_slave, on_request, wrong_file, address_goes_back, equal_runs, end_of_frame, files, exit_codes,
             files_named, interrupted, source_address, formats, report_fields, output_lost, listing, capture] # those that take long first
    chosen = [test for test in [*tests, million] if test.__name__ == only] if only else tests
    if not chosen:
        sys.exit(f"no test is named {only}: {' '.join(test.__name__ for test in [*tests, million])}")

    def wrong(test):
        try:
            test(ectwin, conform)
            return f"ok      {test.__doc__}", False
        except AssertionError as error:
            return f"FAILED  {test.__doc__}\n  {error}\n  alone: conform.py command {ectwin} {conform} {test.__name__}", True
    with concurrent.futures.ThreadPoolExecutor(RUNS + 2) as pool: # three of them wait for most of their time
        results = list(pool.map(wrong, chosen))
    print(*(text for text, _ in results), sep="\n")
    return sum(failed for _, failed in results)


if __name__ == "__main__":
    if len(sys.argv) < 4 or sys.argv[1] not in ("devices", "command", "others", "defects", "whole", "everywhere"):
        sys.exit(__doc__)
    paths = [os.path.abspath(p) for p in sys.argv[2:4]]
    if sys.argv[1] == "devices":
        sys.exit(devices(*paths, "--write" in sys.argv) != 0)
    run = {"command": command, "others": others, "defects": defects, "whole": whole, "everywhere": everywhere}[sys.argv[1]]
    sys.exit(run(*paths, sys.argv[4] if len(sys.argv) > 4 else None) != 0)
