#!/usr/bin/env python3
"""Draws lines of a terminal as an SVG picture.  usage: terminal.py [WIDTH] <TEXT >FILE.svg      lines that begin with "$ " are commands"""
import html
import sys

LINE, CHARACTER, MARGIN = 18, 7.8, 14


def main():
    width = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    lines = [line.rstrip()[:width] for line in sys.stdin.read().splitlines()]
    columns = max([len(line) for line in lines] + [40])
    size = (round(columns * CHARACTER + 2 * MARGIN), len(lines) * LINE + 2 * MARGIN)
    print(f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]}" viewBox="0 0 {size[0]} {size[1]}" '
          'font-family="DejaVu Sans Mono,monospace" font-size="13">')
    print('<rect width="100%" height="100%" rx="6" fill="#1d2327"/>')
    for row, line in enumerate(lines):
        colour = "#7bd88f" if line.startswith("$ ") else "#e4e4e4"
        print(f'<text x="{MARGIN}" y="{MARGIN + row * LINE + 13}" fill="{colour}" xml:space="preserve">{html.escape(line)}</text>')
    print("</svg>")


main()
