"""Levels of lodc beside those of other tools: `just league FOLDER`.

Every model of the folder becomes one GLB, with noise as its texture where it has coordinates and no
image. Each tool that is installed takes it to shares of its triangles; lodc takes it to as many as
each tool has left, so counts are equal. All are measured by a rasteriser and distances that are not
lodc's (draw.c, libigl). A cell is a model at a share; a ratio below 1 is better than the tool's, a
cell within 2 % is a tie. The best of all tools is that of each cell."""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).parent.parent / "kinds"))

import measure
import scene
import tools
from compiled import compiled

# The metric of each, and what `extract` is told.
WAYS = {
    "default": ("quadric", []),
    "`--no-refit`": ("quadric", ["--no-refit"]),
    "hybrid": ("hybrid", []),
    "hybrid `--no-refit`": ("hybrid", ["--no-refit"]),
}
KINDS = [".glb", ".gltf", ".obj", ".ply", ".stl", ".vrm"]
TIE, NEAR = 0.02, 0.02


class Lodc:
    """The program on one model, and the levels that it has made."""

    def __init__(self, program, source, folder, ruler):
        self.program, self.source, self.folder, self.ruler = program, source, folder, ruler
        self.made = {}

    def level(self, way, count):
        """The differences of a level with as many triangles."""
        if (way, count) not in self.made:
            metric, words = WAYS[way]
            stored, out = self.stored(metric), self.folder / "lodc.glb"
            words = ["extract", stored, "--triangles", count, "-q", "-o", out, *words]
            tools.run([self.program, *words])
            self.made[way, count] = self.ruler.measure(scene.read(out), True)
        return self.made[way, count]

    def stored(self, metric):
        """A file of all levels: `extract` writes of it what it would of the model, and the model is
        simplified once."""
        path = self.folder / f"{metric}.lodc"
        if not path.exists():
            words = ["build", self.source, "--metric", metric, "--models", "none", "-q", "-o", path]
            tools.run([self.program, *words])
        return path


def cells(arguments, model, folder):
    """Rows of a model: by share, tool and way the measured differences of both."""
    source = folder / "in.glb"
    words = ["extract", model, "--ratio", "1", "--textures", "embed", "-q", "-o", source]
    tools.run([arguments.lodc, *words])
    painted = scene.prepare(source)
    whole = scene.read(source)
    ruler = measure.Ruler(arguments.drawing, whole)
    lodc, count = Lodc(arguments.lodc, source, folder, ruler), len(whole.material_of)
    print(f"{model.name}: {count} triangles{', painted' if painted else ''}", flush=True)
    for ratio in arguments.ratios:
        wanted = int(ratio * count)
        for name, (level, keeps) in arguments.tools.items():
            is_shown = keeps == "all" or (keeps == "textured") == bool(whole.images)
            if keeps == "textured" and not whole.images:
                continue
            try:
                made = level(source, whole, ratio)
            except (tools.Failed, ValueError) as error:
                print(f"  {name} at {ratio:.0%}: {error}", flush=True)
                continue
            found = ruler.measure(made, is_shown and (keeps != "plain" or not whole.is_painted()))
            left = found["triangles"]
            if not 0.6 * wanted <= left <= 1.3 * wanted + 2:
                print(f"  {name} at {ratio:.0%}: {left} triangles for {wanted}", flush=True)
                continue
            equal = wanted if abs(left - wanted) <= NEAR * wanted else left
            for way in arguments.ways:
                yield {
                    "model": model.name, "ratio": ratio, "tool": name, "way": way,
                    "theirs": found, "ours": lodc.level(way, equal),
                }  # fmt: skip


def ratio_of(row, key):
    """How a level of lodc compares; none where the tool's was not measured."""
    if key not in row["theirs"]:
        return None
    floor = measure.FLOORS[key]
    return (row["ours"][key] + floor) / (row["theirs"][key] + floor)


def summary(ratios):
    """The geometric mean, and the cells that are won, tied and lost."""
    if not ratios:
        return "–"
    mean = math.exp(sum(math.log(r) for r in ratios) / len(ratios))
    lost = sum(r > 1 + TIE for r in ratios)
    won = sum(r < 1 - TIE for r in ratios)
    return f"{mean:.2f} {won}/{len(ratios) - won - lost}/{lost}"


def best_of_all(rows, key):
    """By model and share, the largest ratio over all tools, and whose it is."""
    best = {}
    for row in rows:
        ratio, cell = ratio_of(row, key), (row["model"], row["ratio"])
        if ratio is not None and (cell not in best or ratio > best[cell][0]):
            best[cell] = ratio, row["tool"]
    return best


def table(rows, ways, names):
    """The table as Markdown, and the cells that the first way loses."""
    lines = []
    for key in measure.FLOORS:
        lines += ["", f"| {key} against | {' | '.join(ways)} |", "| --- " * (len(ways) + 1) + "|"]
        of_way = {way: [r for r in rows if r["way"] == way] for way in ways}
        for name in names:
            row = []
            for way in ways:
                own = [ratio_of(r, key) for r in of_way[way] if r["tool"] == name]
                row.append(summary([ratio for ratio in own if ratio is not None]))
            lines.append(f"| {name} | {' | '.join(row)} |")
        best = [[r for r, _ in best_of_all(of_way[way], key).values()] for way in ways]
        means = " | ".join(summary(ratios) for ratios in best)
        lines.append(f"| **the best of all in each cell** | {means} |")
        lost = best_of_all(of_way[ways[0]], key).items()
        lost = sorted(((r, cell, tool) for cell, (r, tool) in lost if r > 1 + TIE), reverse=True)
        for ratio, (model, share), tool in lost:
            lines.append(f"* {key} lost: {model} at {share:.0%}, {ratio:.2f} ({tool})")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=pathlib.Path, help="models, or files of them by name")
    parser.add_argument("--lodc", default="target/release/lodc")
    parser.add_argument("--tools", default="target/other_tools", type=pathlib.Path)
    parser.add_argument("--ratios", default="0.5,0.25,0.1,0.05,0.02")
    parser.add_argument("--ways", default="default,`--no-refit`")
    parser.add_argument("--models", default="", help="names, by commas [default: all]")
    parser.add_argument("--rows", type=pathlib.Path, help="JSON lines to add to, and to begin with")
    arguments = parser.parse_args()
    arguments.ratios = [float(ratio) for ratio in arguments.ratios.split(",")]
    arguments.ways = arguments.ways.split(",")
    arguments.tools, absent = tools.installed(arguments.tools)
    for name in absent:
        print(f"{name} is not installed")
    source = pathlib.Path(__file__).with_name("draw.c")
    arguments.drawing = measure.Drawing(compiled(source))
    rows = []
    if arguments.rows and arguments.rows.exists():
        rows = [json.loads(line) for line in arguments.rows.read_text().splitlines()]
    done = {row["model"] for row in rows}
    models = sorted(p for p in arguments.folder.rglob("*") if p.suffix.lower() in KINDS)
    wanted = set(filter(None, arguments.models.split(",")))
    for model in models:
        if model.name in done or wanted and model.name not in wanted:
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                own = list(cells(arguments, model, pathlib.Path(folder)))
            except (tools.Failed, ValueError, subprocess.SubprocessError) as error:
                print(f"{model.name}: left out: {error}")
                continue
        rows += own
        if arguments.rows:
            with arguments.rows.open("a") as out:
                out.writelines(json.dumps(row) + "\n" for row in own)
    print(table(rows, arguments.ways, [*arguments.tools]))


if __name__ == "__main__":
    main()
