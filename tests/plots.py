#!/usr/bin/env python3
"""Draws the plots of docs/BENCHMARKS.md from the rows in docs/benchmarks: `just plots`.

With `--check` nothing is written, and the exit status is 1 if a plot is not that of its rows."""
import csv
import math
import pathlib
import sys

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "docs" / "benchmarks"
COLOURS = ["#1b6ca8", "#c0392b", "#2e7d32", "#7d3c98", "#b9770e", "#555555"]
WIDTH, HEIGHT, LEFT, TOP, GAP = 300, 200, 60, 34, 110


def rows(name):
    with open(FOLDER / name, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


class Panel:
    """Lines over two axes; each axis has marks and is linear or logarithmic."""

    def __init__(self, title, across, up, log=(True, False)):
        self.title, self.log = title, log
        self.marks = across, up

    def place(self, axis, value):
        """Share of the axis, from its first mark to its last."""
        first, last = self.marks[axis][0], self.marks[axis][-1]
        if self.log[axis]:
            return math.log(value / first) / math.log(last / first)
        return (value - first) / (last - first)

    def draw(self, left, lines, unit):
        x = lambda value: left + WIDTH * self.place(0, value)
        y = lambda value: TOP + HEIGHT * (1 - self.place(1, value))
        out = [f'<text x="{left}" y="{TOP - 14}" font-weight="bold">{self.title}</text>',
               f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" '
               'stroke="#999"/>']
        for mark in self.marks[0]:
            out.append(f'<path d="M{x(mark):.1f} {TOP}v{HEIGHT}" stroke="#ddd"/><text '
                       f'x="{x(mark):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">'
                       f'{mark:,g}{unit}</text>')
        for mark in self.marks[1]:
            out.append(f'<path d="M{left} {y(mark):.1f}h{WIDTH}" stroke="#ddd"/><text '
                       f'x="{left - 6}" y="{y(mark) + 4:.1f}" text-anchor="end">{mark:g}</text>')
        labels = []
        for colour, (name, points) in zip(COLOURS, lines):
            path = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in points)
            out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" '
                       'stroke-width="1.8"/>')
            labels.append([y(points[-1][1]) + 4, name, colour])
        labels.sort()
        for before, label in zip(labels, labels[1:]):
            label[0] = max(label[0], before[0] + 13)
        for at, name, colour in labels:
            out.append(f'<text x="{left + WIDTH + 5}" y="{at:.1f}" fill="{colour}">{name}</text>')
        return out


def picture(panels, below):
    body = []
    for number, (panel, lines, unit) in enumerate(panels):
        body += panel.draw(LEFT + number * (WIDTH + GAP + LEFT), lines, unit)
    width, height = len(panels) * (LEFT + WIDTH + GAP), TOP + HEIGHT + 44
    body.append(f'<text x="{width / 2:.0f}" y="{height - 6}" text-anchor="middle">{below}</text>')
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            'font-family="sans-serif" font-size="12">\n'
            '<rect width="100%" height="100%" fill="white"/>\n')
    return head + "\n".join(body) + "\n</svg>\n"


LEVELS = [1, 5, 10, 25, 50]


def distance():
    """RMS of every half-edge tool over that of lodc, by level."""
    lines = []
    table = rows("quadric-rms.csv")
    for key, name in (("openmesh", "OpenMesh"), ("meshoptimizer", "meshoptimizer"),
                      ("cgal_end_point", "CGAL, end point")):
        points = []
        for level in LEVELS:
            at = [r for r in table if int(r["level_percent"]) == level
                  and r["model"] != "fandisk"]
            points.append((level, mean([float(r[key]) / float(r["lodc"]) for r in at])))
        lines.append((name, points))
    lines.append(("lodc", [(level, 1) for level in LEVELS]))
    panel = Panel("RMS distance / lodc's", LEVELS, [0.8, 1, 1.2, 1.4, 1.6, 1.8, 2])
    return panel, lines, " %"


def looks():
    """Image error of metrics and tools over that of the quadric metric, by level."""
    lines = []
    table = rows("image-error-means.csv")
    names = {"hybrid": "hybrid", "viewpoint": "viewpoint", "kl": "kl",
             "meshoptimizer": "meshoptimizer", "openmesh": "OpenMesh"}
    for key, name in names.items():
        points = [(int(r["level_percent"]), float(r["image_rmse_per_quadric"]))
                  for r in table if r["tool"] == key]
        lines.append((name, sorted(points)))
    panel = Panel("Image error / quadric's", LEVELS, [0.4, 0.8, 1.2, 1.6, 2])
    return panel, lines, " %"


def extraction():
    """Microseconds of an update over the records of one, by model."""
    table = sorted(rows("extraction-update.csv"), key=lambda r: float(r["records_per_update"]))
    names = {"interactive": "Interactive", "progressive_meshes": "Prog. Meshes",
             "lodstrips": "LodStrips", "masking": "Masking", "speed": "Speed"}
    lines = [(name, [(float(r["records_per_update"]), float(r[key])) for r in table])
             for key, name in names.items()]
    panel = Panel("µs per update of 0.1 % (processor)", [1, 10, 100, 1000],
                  [0.01, 0.1, 1, 10, 100, 1000], (True, True))
    return panel, lines, ""


def traffic():
    """Bytes sent to a device by one update, by model."""
    records = {r["model"]: float(r["records_per_update"]) for r in rows("extraction-update.csv")}
    table = sorted(rows("traffic.csv"), key=lambda r: records[r["model"]])
    names = {"whole_index_list": "whole index list", "speed": "Speed", "lodstrips": "LodStrips",
             "masking": "Masking", "progressive_meshes": "Prog. Meshes",
             "interactive": "Interactive"}
    lines = [(name, [(records[r["model"]], float(r[key])) for r in table])
             for key, name in names.items()]
    marks = [1, 10, 100, 1000, 1e4, 1e5, 1e6, 1e7]
    panel = Panel("bytes sent per update of 0.1 %", [1, 10, 100, 1000], marks, (True, True))
    return panel, lines, ""


def streams(key, title, marks):
    """Error of the prefixes of a stream, by their share of its bytes."""
    lines = {}
    for r in rows("stream-distortion.csv"):
        if r[key]:
            percent = float(r["bytes_percent"].rstrip(" %"))
            lines.setdefault(r["model"], []).append((percent, float(r[key])))
    return Panel(title, [1, 2, 5, 10, 25, 50], marks, (True, True)), list(lines.items()), " %"


def device():
    """Microseconds on an NVIDIA H200 over the vertices of a mesh."""
    vertices = {r["model"]: int(r["vertices"]) for r in rows("device-limit.csv")}
    names = {"Speed Strips, *direct*, per update of 0.1 %": "Speed, direct",
             "Masking Strips, per update of 0.1 %": "Masking",
             "the whole mesh in one jump": "whole mesh",
             "view-dependent, outline": "by view",
             "Interactive Meshes, per update of 0.1 %": "Interactive"}
    at = [r for r in rows("device-time.csv") if r["adapter"] == "NVIDIA H200"]
    lines = [(name, [(vertices[r["model"]], 1e3 * float(r["value"]))
                     for r in at if r["case"] == case]) for case, name in names.items()]
    lines.append(("limit", [(int(r["vertices"]), float(r["limit_us"]))
                            for r in rows("device-limit.csv")]))
    panel = Panel("µs on a device (H200)", [1e3, 1e4, 1e5, 1e6], [0.01, 0.1, 1, 10, 100, 1000],
                  (True, True))
    return panel, lines, ""


def device_draws():
    """Milliseconds of a draw on an NVIDIA H200 over the vertices of a mesh."""
    vertices = {r["model"]: int(r["vertices"]) for r in rows("device-limit.csv")}
    at = [r for r in rows("device-time.csv") if r["adapter"] == "NVIDIA H200"]
    names = ["triangles", "triangles in cache order", "long strips", "cache-aware strips"]
    short = {"triangles in cache order": "cache order", "cache-aware strips": "cache strips"}
    lines = [(short.get(name, name), [(vertices[r["model"]], float(r["value"])) for r in at
                                      if r["case"] == f"one draw of LOD 0, {name}"])
             for name in names]
    panel = Panel("ms of one draw of LOD 0 (H200)", [1e3, 1e4, 1e5, 1e6], [0.01, 0.1, 1, 10],
                  (True, True))
    return panel, lines, ""


PLOTS = {
    "device.svg": lambda: picture([device(), device_draws()], "vertices (four meshes)"),
    "quality.svg": lambda: picture([distance(), looks()], "share of the triangles"),
    "models.svg": lambda: picture([extraction(), traffic()], "records per update (ten meshes)"),
    "streams.svg": lambda: picture([
        streams("rms", "RMS distance, % of the diagonal", [0.001, 0.01, 0.1, 1, 10]),
        streams("image_rmse", "image error, grey levels of 255", [1, 10, 100, 1000])],
        "share of the stream's bytes"),
}


def main():
    stale = []
    for name, draw in PLOTS.items():
        path, svg = FOLDER / name, draw()
        if "--check" not in sys.argv[1:]:
            path.write_text(svg, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != svg:
            stale.append(name)
    if stale:
        sys.exit(f"not drawn from the rows as they are: {', '.join(stale)} (`just plots`)")


main()
