#!/usr/bin/env python3
"""Draws a timing chart of a recorded exchange.
usage: chart.py [--svg [--curve FACTOR]] [--zero SIGNAL[:N]] [--from MS] [--to MS] [--width N] [RECORDING]

A recording is the output of `ectwin watch --every`. Without --signals the changing signals of an FZM1's handshakes are drawn.
Signals other than 0 or 1 are drawn as values, or as curves (numbers times FACTOR). Times are in milliseconds, from the first change
or from that of --zero: exe:2 is the second rising edge of exe.
"""
import argparse
import html
import json
import math
import sys

ERRORS = 0x7FFFFFF5  # of an optoNCDT 2300: values from here on are errors, not distances
HANDSHAKES = "exe,flg,step,ready,busy,dsa,gate,output1"


def rise(changes, zero):
    """Time of the N-th rising edge of a signal: SIGNAL or SIGNAL:N."""
    name, _, count = zero.partition(":")
    if count and not count.isdigit() or count == "0":
        sys.exit(f"chart.py: --zero takes SIGNAL or SIGNAL:N, N from 1, not '{zero}'")
    rises = [t for t, value in changes[name][1:] if value == "1"]
    if len(rises) < int(count or 1):
        sys.exit(f"chart.py: {name} rises {len(rises)} times in this recording, not {count or 1}")
    return rises[int(count or 1) - 1]


def read(lines, wanted, slave, zero):
    """For each signal its changes, (time, value), beginning with the initial value; times in ms."""
    changes = {name: [] for name in wanted + ([zero.partition(":")[0]] if zero else [])}
    for number, line in enumerate(lines, 1):
        try:
            entry = json.loads(line)
            entry["time"], entry["value"]
        except (ValueError, TypeError, KeyError):
            if number == len(lines):
                break  # truncated at the end of the recording
            sys.exit(f"chart.py: line {number} is not one of 'ectwin watch'")
        if entry.get("slave", slave) == slave and entry.get("name") in changes:
            changes[entry["name"]].append((entry["time"] * 1000, str(entry["value"])))
    start = rise(changes, zero) if zero else None
    changes = {name: changes[name] for name in wanted if len(changes[name]) > 1}
    if not changes:
        sys.exit("chart.py: none of these signals changes in this recording: " + ", ".join(wanted))
    if start is None:
        start = min(c[1][0] for c in changes.values())
    return {name: [(round(t - start, 3), v) for t, v in c] for name, c in changes.items()}


def window(changes, first, last):
    times = [t for c in changes.values() for t, _ in c[1:]]
    end = max(times) if last is None else last
    begin = 0 if first is None else first
    margin = max((end - begin) * 0.04, 0.1)
    start, stop = (begin - margin if first is None else first), (end + margin if last is None else last)
    if start >= stop:
        sys.exit("chart.py: --to must be later than --from")
    return start, stop


def spans(change, start, end):
    """(from, to, value) of each level inside the window."""
    result = []
    for i, (t, value) in enumerate(change):
        begin = start if i == 0 else t
        stop = change[i + 1][0] if i + 1 < len(change) else end
        if stop > start and begin < end:
            result.append((max(begin, start), min(stop, end), value))
    return result


def is_level(change):
    return all(v in ("0", "1") for _, v in change)


def text(changes, start, end, width):
    scale = width / (end - start)
    pad = max(len(name) for name in changes) + 2
    rows = []
    for name, change in changes.items():
        line = [" "] * width
        for begin, stop, value in spans(change, start, end):
            first, last = int((begin - start) * scale), max(int((stop - start) * scale), int((begin - start) * scale) + 1)
            fill = ("▔" if value == "1" else "▁") * width if is_level(change) else value.center(last - first, "─")
            for x in range(first, min(last, width)):
                line[x] = fill[x - first]
        rows.append(name.upper().ljust(pad) + "".join(line))
    ticks = [" "] * (width + 8)
    at = -9
    for t in sorted({t for c in changes.values() for t, _ in c[1:]}):
        x = int((t - start) * scale)
        label = f"{t:g}"
        if x >= at + 1 and x < width:
            ticks[x:x + len(label)] = label
            at = x + len(label)
    rows.append("ms".ljust(pad) + "".join(ticks).rstrip())
    return "\n".join(row.rstrip() for row in rows) + "\n"


def curve(change, start, end, factor, x, high, low):
    """A curve from `high` to `low` (pixels), of the lowest to the highest number; an error (no distance) is a gap."""
    steps = [(a, b, int(v) * factor if int(v) < ERRORS else None) for a, b, v in spans(change, start, end)]
    numbers = [v for _, _, v in steps if v is not None]
    least, most = min(numbers, default=0), max(numbers, default=1)
    scale = (low - high) / ((most - least) or 1)
    lines, out = [[]], []
    for begin, stop, value in steps:
        if value is None:
            lines.append([])
            out.append(f'<rect x="{x(begin)}" y="{high}" width="{float(x(stop)) - float(x(begin)):.1f}" '
                       f'height="{low - high}" fill="#fde8e8"/>')
        else:
            y = f"{low - (value - least) * scale:.1f}"
            lines[-1] += [f"{x(begin)},{y}", f"{x(stop)},{y}"]
    out += [f'<polyline points="{" ".join(line)}" fill="none" stroke="#06c" stroke-width="1.5"/>' for line in lines if line]
    out += [f'<text x="82" y="{y}" text-anchor="end" fill="#555">{value:g}</text>'
            for y, value in ((high + 10, most), (low, least))]
    return out


def svg(changes, start, end, width, factor):
    left, top, gap = 90, 14, 16
    heights = [88 if factor and not is_level(change) else 18 for change in changes.values()]
    tops = [top + sum(heights[:n]) + gap * n for n in range(len(heights) + 1)]
    scale = (width - left - 20) / (end - start)
    bottom = tops[-1]

    def x(t):
        return f"{left + (t - start) * scale:.1f}"

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{bottom + 26}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{bottom + 26}" fill="white"/>']
    at = -99.0
    ticks = {t for c in changes.values() for t, _ in c[1:]}
    if factor:  # these change continuously
        step = 10 ** math.floor(math.log10((end - start) / 4))
        ticks = {n * step for n in range(math.ceil(start / step), math.floor(end / step) + 1)}
    for t in sorted(ticks):
        if start <= t <= end:
            out.append(f'<line x1="{x(t)}" y1="{top - 6}" x2="{x(t)}" y2="{bottom}" stroke="#ccc" stroke-dasharray="2,3"/>')
            if float(x(t)) - at > 34:
                out.append(f'<text x="{x(t)}" y="{bottom + 16}" text-anchor="middle" fill="#555">{t:g}</text>')
                at = float(x(t))
    out.append(f'<text x="8" y="{bottom + 16}" fill="#555">ms</text>')
    for n, (name, change) in enumerate(changes.items()):
        height = heights[n]
        high, low = tops[n], tops[n] + height
        out.append(f'<text x="8" y="{(high + low) / 2 if height > 18 else low - 3}">{html.escape(name.upper())}</text>')
        if is_level(change):
            points = []
            for begin, stop, value in spans(change, start, end):
                y = high if value == "1" else low
                points += [f"{x(begin)},{y}", f"{x(stop)},{y}"]
            out.append(f'<polyline points="{" ".join(points)}" fill="none" stroke="#06c" stroke-width="2"/>')
            continue
        if factor:
            out += curve(change, start, end, factor, x, high, low)
            continue
        for begin, stop, value in spans(change, start, end):
            out.append(f'<rect x="{x(begin)}" y="{high}" width="{(stop - begin) * scale:.1f}" height="{height}" '
                       'fill="#eef4ff" stroke="#06c"/>')
            if (stop - begin) * scale > 8 * len(value):
                out.append(f'<text x="{float(x(begin)) + (stop - begin) * scale / 2:.1f}" y="{low - 4}" '
                           f'text-anchor="middle">{html.escape(value)}</text>')
    return "\n".join(out + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", nargs="?", help="default: standard input")
    parser.add_argument("--svg", action="store_true", help="a picture instead of text")
    parser.add_argument("--curve", type=float, metavar="FACTOR", help="numbers as curves, times FACTOR: 1e-6 for nm as mm")
    parser.add_argument("--signals", default=HANDSHAKES, help="which, in this order, separated by commas")
    parser.add_argument("--slave", type=int, default=1, help="of the chain, from 1 (default 1)")
    parser.add_argument("--zero", metavar="SIGNAL[:N]", help="where times count from: SIGNAL rises for the N-th time")
    parser.add_argument("--from", dest="first", type=float, help="milliseconds")
    parser.add_argument("--to", dest="last", type=float, help="milliseconds")
    parser.add_argument("--width", type=int, help="characters (default 100) or pixels (default 760)")
    args = parser.parse_args()
    if args.width is not None and args.width < (200 if args.svg else 20):
        sys.exit("chart.py: --width takes at least 20 characters or 200 pixels")
    try:
        lines = (open(args.recording) if args.recording else sys.stdin).read().splitlines()
    except OSError as error:
        sys.exit(f"chart.py: {error}")
    changes = read(lines, args.signals.split(","), args.slave, args.zero)
    start, end = window(changes, args.first, args.last)
    if args.curve and not args.svg:
        sys.exit("chart.py: curves are drawn with --svg")
    if args.svg:
        sys.stdout.write(svg(changes, start, end, args.width or 760, args.curve))
    else:
        sys.stdout.write(text(changes, start, end, args.width or 100))


main()
