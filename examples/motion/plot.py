#!/usr/bin/env python3
"""Draws the output of ectwin-motion as an SVG picture.  usage: plot.py [CSV] >motion.svg

Three panels over one time: positions (turns), speed of the set position and of the shaft (turns a second), following
error (turns) and torque (per mille). Dashed lines separate the phases.
"""
import csv
import html
import sys

TURN = 1048576
WIDTH, LEFT, RIGHT, TOP, PANEL, GAP = 760, 70, 20, 26, 120, 26
COLOURS = {"set": "#999", "actual": "#06c"}


def read(lines):
    rows = list(csv.DictReader(lines))
    if len(rows) < 3 or "following_error" not in rows[0]:
        sys.exit("plot.py: the input is not output of ectwin-motion")
    return rows


def speeds(ms, counts):
    """Turns a second, over 5 cycles; 0 where a reference run has set the position."""
    result = []
    for i in range(len(counts)):
        a, b = max(0, i - 5), i
        way = (counts[b] - counts[a]) / TURN
        seconds = (ms[b] - ms[a]) / 1000
        result.append(0 if seconds <= 0 or abs(way) > 5 else way / seconds)
    return result


def panel(out, number, title, ms, curves):
    top = TOP + number * (PANEL + GAP)
    values = [v for _, curve in curves for v in curve]
    low, high = min(values + [0]), max(values + [0])
    if high == low:
        high = low + 1
    scale_x, scale_y = (WIDTH - LEFT - RIGHT) / (ms[-1] - ms[0]), PANEL / (high - low)

    def x(t):
        return LEFT + (t - ms[0]) * scale_x

    def y(v):
        return top + (high - v) * scale_y

    out.append(f'<text x="{LEFT}" y="{top - 6}">{html.escape(title)}</text>')
    for value in (low, 0, high):
        out.append(f'<line x1="{LEFT}" y1="{y(value):.1f}" x2="{WIDTH - RIGHT}" y2="{y(value):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end" fill="#555">{value:.3g}</text>')
    for colour, curve in curves:
        kept = [(x(ms[0]), y(curve[0]))]
        for t, v in zip(ms[1:], curve[1:]):
            if x(t) - kept[-1][0] >= 2 or abs(y(v) - kept[-1][1]) >= 2:
                kept.append((x(t), y(v)))
        kept.append((x(ms[-1]), y(curve[-1])))
        points = [f"{px:.1f},{py:.1f}" for px, py in kept]
        out.append(f'<polyline points="{" ".join(points)}" fill="none" stroke="{COLOURS[colour]}" stroke-width="1.5"/>')
    return x


def main():
    lines = open(sys.argv[1]) if len(sys.argv) > 1 else sys.stdin
    rows = read(lines)
    ms = [float(r["ms"]) for r in rows]
    number = {name: [int(r[name]) for r in rows] for name in ("set", "position", "following_error", "torque")}
    height = TOP + 3 * (PANEL + GAP) + 14
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="sans-serif" '
           'font-size="12">', f'<rect width="{WIDTH}" height="{height}" fill="white"/>']
    x = panel(out, 0, "position, turns (grey: set)", ms,
              [("set", [v / TURN for v in number["set"]]), ("actual", [v / TURN for v in number["position"]])])
    panel(out, 1, "speed, turns a second (grey: of the set position)", ms,
          [("set", speeds(ms, number["set"])), ("actual", speeds(ms, number["position"]))])
    panel(out, 2, "torque, per mille of the rated one", ms, [("actual", number["torque"])])
    last, bottom = None, TOP + 3 * (PANEL + GAP) - GAP
    for t, row in zip(ms, rows):
        if row["phase"] != last:
            out.append(f'<line x1="{x(t):.1f}" y1="{TOP}" x2="{x(t):.1f}" y2="{bottom}" stroke="#ccc" '
                       'stroke-dasharray="2,3"/>')
            if row["phase"] in ("homing", "moving", "settling"):
                out.append(f'<text x="{x(t) + 3:.1f}" y="{bottom + 14}" fill="#555">{row["phase"]}</text>')
        last = row["phase"]
    for t in range(0, int(ms[-1]) + 1, 500):
        out.append(f'<text x="{x(ms[0] + t):.1f}" y="{bottom + 30}" text-anchor="middle" fill="#555">{t}</text>')
    out.append(f'<text x="8" y="{bottom + 30}" fill="#555">ms</text>')
    print("\n".join(out + ["</svg>"]))


main()
