#!/usr/bin/env python3
"""Draws a recording of test_clocks, the differences of all clocks to the reference over time, as an SVG.

usage: ectwin with --drift 100 --cable 10 fzm1,fzm1,... -- build/release/tests/integration/test_clocks {} N 20 > clocks.csv
       tools/dev/plot_clocks.py clocks.csv > docs/clocks.svg
"""
import csv
import math
import sys

WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 860, 420, 70, 50, 40
DECADES = 6  # 1 ns to 1 ms


def main():
    with open(sys.argv[1], encoding="ascii") as file:
        rows = [(int(r["ms"]), int(r["slave"]), abs(int(r["difference_ns"]))) for r in csv.DictReader(file)]
    last = max(ms for ms, _, _ in rows)
    clocks = {}
    for ms, slave, size in rows:
        clocks.setdefault(slave, []).append((ms, size))

    def x(ms):
        return LEFT + (WIDTH - LEFT - 20) * ms / last

    def y(size):
        return HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * math.log10(max(size, 1)) / DECADES

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="20" font-size="14">{len(clocks)} clocks and a reference, SOEM, a sample each '
           'millisecond: |0x092C|</text>']
    for decade in range(DECADES + 1):
        size = 10 ** decade
        name = f"{size} ns" if size < 1000 else f"{size // 1000} µs" if size < 10 ** 6 else f"{size // 10 ** 6} ms"
        colour = "#c00" if size == 1000 else "#ccc"
        out.append(f'<path d="M{LEFT} {y(size):.1f}H{WIDTH - 20}" stroke="{colour}"/>'
                   f'<text x="{LEFT - 8}" y="{y(size) + 4:.1f}" text-anchor="end">{name}</text>')
    for second in range(0, last // 1000 + 1, max(1, last // 8000)):
        out.append(f'<text x="{x(1000 * second):.1f}" y="{HEIGHT - BOTTOM + 20}" text-anchor="middle">{second} s</text>')
    for points in clocks.values():
        way = " ".join(f"{x(ms):.0f},{y(size):.0f}" for ms, size in points)
        out.append(f'<polyline points="{way}" fill="none" stroke="#26c" stroke-opacity="0.25"/>')
    worst = max(size for ms, _, size in rows if ms > last * 0.9)
    out.append(f'<text x="{WIDTH - 24}" y="{TOP + 16}" text-anchor="end">in the last tenth at most {worst} ns</text>')
    print("\n".join(out) + "\n</svg>")


if __name__ == "__main__":
    main()
