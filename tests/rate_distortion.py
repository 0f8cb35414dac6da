#!/usr/bin/env python3
"""Draws docs/rate-distortion.svg: `lodc bench --streams --no-times --json FILES | python3 tests/rate_distortion.py > OUT.svg`.

Two panels over the share of a stream's bytes: RMS distance in % of the diagonal, and image error in grey levels."""
import json
import math
import sys

COLOURS = ["#1b6ca8", "#c0392b", "#2e7d32", "#7d3c98", "#b9770e"]
WIDTH, HEIGHT, LEFT, TOP, GAP = 300, 200, 60, 30, 70


def lines():
    for file in json.load(sys.stdin)["files"]:
        for number, o in enumerate(file["objects"]):
            name = file["file"].rsplit("/", 1)[-1].rsplit(".", 1)[0]
            yield name if len(file["objects"]) == 1 else f"{name} {number + 1}", o["stream"]["prefixes"]


def panel(x0, title, key, rows, low, high):
    def at(percent, value):
        x = x0 + WIDTH * math.log(percent) / math.log(50)
        return x, TOP + HEIGHT * (1 - math.log(value / low) / math.log(high / low))

    out = [f'<text x="{x0}" y="{TOP - 12}">{title}</text>',
           f'<rect x="{x0}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>']
    for percent in (1, 2, 5, 10, 25, 50):
        x = at(percent, low)[0]
        out.append(f'<path d="M{x:.1f} {TOP}v{HEIGHT}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{percent} %</text>')
    for exponent in range(round(math.log10(low)), round(math.log10(high)) + 1):
        y = at(1, 10.0 ** exponent)[1]
        out.append(f'<path d="M{x0} {y:.1f}h{WIDTH}" stroke="#ddd"/>'
                   f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end">{10.0 ** exponent:g}</text>')
    for number, (name, prefixes) in enumerate(rows):
        colour = COLOURS[number % len(COLOURS)]
        points = [at(p["percent"], p[key]) for p in prefixes if p[key]]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.8"/>')
        out.append(f'<text x="{x0 + WIDTH - 8}" y="{TOP + 18 + 15 * number}" text-anchor="end" fill="{colour}">{name}</text>')
    return out


def main():
    rows = list(lines())
    panels = []
    for number, (title, key) in enumerate([("RMS distance, % of the diagonal", "rms"), ("image error, grey levels of 255", "image")]):
        values = [p[key] for _, prefixes in rows for p in prefixes if p[key]]
        low, high = 10.0 ** math.floor(math.log10(min(values))), 10.0 ** math.ceil(math.log10(max(values)))
        panels += panel(LEFT + number * (WIDTH + GAP), title, key, rows, low, high)
    width, height = LEFT + 2 * WIDTH + GAP + 20, TOP + HEIGHT + 45
    panels.append(f'<text x="{width / 2:.0f}" y="{height - 8}" text-anchor="middle">share of the stream</text>')
    print(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">')
    print('<rect width="100%" height="100%" fill="white"/>')
    print("\n".join(panels) + "\n</svg>")


main()
