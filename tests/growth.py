"""How the program's work grows with each count that a file can hold: `just growth`.

growth.py LODC [--sample N] [--seed N] [--counts a,b] [--stages a,b] [--csv FILE]
growth.py LODC --time [--seconds S] [--counts a,b] [--stages a,b] [--csv FILE]

For each count files are made whose other counts stay small. Valgrind counts the instructions that a
stage takes for n, 2n and 4n on one thread; those from 2n to 4n are at most 2.4 times those from n
to 2n. A sample is N cells of the table, chosen by the seed, and those that were once beyond.

With --time the count is doubled until a stage takes S seconds of processor time or the count
reaches its end. The table shows the last count, its seconds and the growth over the half of it,
which counts where a stage takes S / 4 seconds or more.

Growth beyond is named, and ends with 1.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import random
import re
import resource
import struct
import subprocess
import sys
import tempfile
import time

MOST = 2.4
# Fewer instructions more for a count twice as large are chance: hash seeds, waiting threads.
CHANCE = 1_000_000


class Glb:
    """A glTF with one triangle to begin with."""

    def __init__(self):
        self.blob, self.views, self.accessors = b"", [], []
        self.document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.document |= {"nodes": [], "meshes": []}

    def view(self, data):
        """Adds bytes; returns their view."""
        self.views.append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)})
        self.blob += data + b"\0" * (-len(data) % 4)
        return len(self.views) - 1

    def floats(self, values, kind="VEC3", **more):
        """Adds an accessor of floats."""
        size = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16, "VEC2": 2}[kind]
        view = self.view(struct.pack(f"<{len(values)}f", *values))
        accessor = {"bufferView": view, "componentType": 5126, "count": len(values) // size}
        accessor |= {"type": kind, **more}
        if kind == "VEC3" or kind == "SCALAR":
            columns = [values[i::size] for i in range(size)]
            accessor |= {"min": list(map(min, columns)), "max": list(map(max, columns))}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def triangle(self, **more):
        """A primitive of one triangle."""
        return {"attributes": {"POSITION": self.floats([0, 0, 0, 1, 0, 0, 0, 1, 0])}, **more}

    def mesh(self, primitives, **more):
        """Adds a mesh and the node that shows it."""
        self.document["meshes"].append({"primitives": primitives, **more})
        self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]))
        self.document["nodes"].append({"mesh": len(self.document["meshes"]) - 1})

    def bytes(self, **more):
        """The file."""
        blob = self.blob + b"\0" * (-len(self.blob) % 4)
        document = self.document | {"bufferViews": self.views, "accessors": self.accessors} | more
        document["buffers"] = [{"byteLength": len(blob)}]
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob))
        chunks = [(b"JSON", text), (b"BIN\0", blob)]
        return head + b"".join(struct.pack("<I4s", len(b), kind) + b for kind, b in chunks)


# One grey pixel.
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010800000000 3a7e9b55"
    "0000000a49444154789c63680000008200 8177cd72b60000000049454e44ae426082".replace(" ", "")
)


def looks(images, textures, materials, used):
    """Images, textures and materials, of which primitives show some."""
    glb = Glb()
    corner = glb.triangle()
    corner["attributes"]["TEXCOORD_0"] = glb.floats([0, 0, 1, 0, 0, 1], "VEC2")
    glb.mesh([corner | {"material": m} for m in range(used)])
    view = glb.view(PNG)
    texture = lambda i: {"baseColorTexture": {"index": i % textures}}
    shown = lambda i: {"pbrMetallicRoughness": texture(i), "name": f"m{i}"}
    return glb.bytes(
        images=[{"bufferView": view, "mimeType": "image/png"} for _ in range(images)],
        textures=[{"source": i % images} for i in range(textures)],
        materials=[shown(i) for i in range(materials)],
    )


def nodes(n):
    glb = Glb()
    glb.mesh([glb.triangle()])
    for i in range(n):
        glb.document["nodes"].append({"name": f"n{i}", "translation": [i, 0, 0]})
    glb.document["scenes"][0]["nodes"] += range(1, n + 1)
    return glb.bytes()


def instances(n):
    glb = Glb()
    glb.mesh([glb.triangle()])
    glb.document["nodes"] = [{"mesh": 0, "translation": [i, 0, 0]} for i in range(n)]
    glb.document["scenes"][0]["nodes"] = list(range(n))
    return glb.bytes()


def meshes(n):
    glb = Glb()
    primitive = glb.triangle()
    for i in range(n):
        glb.mesh([primitive], name=f"mesh{i}")
        # Beside each other: pictures of all in one place take long.
        glb.document["nodes"][-1]["translation"] = [2 * i, 0, 0]
    return glb.bytes()


def primitives(n):
    glb = Glb()
    primitive = glb.triangle()
    glb.mesh([primitive] * n)
    return glb.bytes()


def targets(n):
    glb = Glb()
    moved = glb.floats([0, 0, 1, 0, 0, 0, 0, 0, 0])
    glb.mesh([glb.triangle(targets=[{"POSITION": moved}] * n)], weights=[0] * n)
    return glb.bytes()


def joints(n):
    glb = Glb()
    primitive = glb.triangle()
    view = glb.view(struct.pack("<12H", *[i * (n - 1) // 11 for i in range(12)]))
    glb.accessors.append({"bufferView": view, "componentType": 5123, "count": 3, "type": "VEC4"})
    primitive["attributes"]["JOINTS_0"] = len(glb.accessors) - 1
    primitive["attributes"]["WEIGHTS_0"] = glb.floats([0.25] * 12, "VEC4")
    glb.mesh([primitive])
    glb.document["nodes"][0]["skin"] = 0
    glb.document["nodes"] += [{"translation": [0, i / n, 0]} for i in range(n)]
    glb.document["scenes"][0]["nodes"] += range(1, n + 1)
    unit = [float(i % 5 == 0) for i in range(16)]
    skin = {"joints": list(range(1, n + 1)), "inverseBindMatrices": glb.floats(unit * n, "MAT4")}
    return glb.bytes(skins=[skin])


def moving(animations, channels, keys):
    """Animations of as many nodes as each has channels."""
    glb = Glb()
    glb.mesh([glb.triangle()])
    glb.document["nodes"] += [{"mesh": 0} for _ in range(channels - 1)]
    glb.document["scenes"][0]["nodes"] = list(range(channels))
    times = glb.floats(list(range(keys)), "SCALAR")
    way = glb.floats([float(k % 7) for k in range(3 * keys)])
    sampler = {"input": times, "output": way}
    channel = lambda i: {"sampler": 0, "target": {"node": i, "path": "translation"}}
    one = {"samplers": [sampler], "channels": [channel(i) for i in range(channels)]}
    return glb.bytes(animations=[one] * animations)


def accessors(n):
    glb = Glb()
    glb.mesh([glb.triangle()])
    glb.accessors += [dict(glb.accessors[0]) for _ in range(n)]
    return glb.bytes()


def sparse(n):
    glb = Glb()
    side = 3 * n
    glb.mesh([{"attributes": {"POSITION": 0}}])
    indices = glb.view(struct.pack(f"<{side}I", *range(side)))
    numbers = places(n)
    values = glb.view(struct.pack(f"<{3 * side}f", *numbers))
    axes = [numbers[axis::3] for axis in range(3)]
    ends = {"min": [min(axis) for axis in axes], "max": [max(axis) for axis in axes]}
    indices = {"bufferView": indices, "componentType": 5125}
    given = {"count": side, "indices": indices, "values": {"bufferView": values}}
    kind = {"componentType": 5126, "count": side, "type": "VEC3"}
    glb.accessors.append({**kind, "sparse": given, **ends})
    return glb.bytes()


def band(i):
    """The corners of a triangle of a flat band."""
    places = [(k / 2, k % 2, 0) for k in range(i, i + 3)]
    return places if i % 2 == 0 else [places[1], places[0], places[2]]


def places(n):
    """The corners of a band, each triangle with its own."""
    return [c for i in range(n) for corner in band(i) for c in corner]


def lines(before):
    """An OBJ of a band, with a line before each triangle."""
    corners = lambda i: "".join(f"v {x} {y} {z}\n" for x, y, z in band(i))
    face = lambda i: f"{before(i)}f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n"
    return lambda n: "".join(corners(i) + face(i) for i in range(n)).encode()


def high_valence(n):
    """Triangles around one vertex, alike for every count."""
    turn = lambda i: math.tau * i / n
    place = lambda i: f"{math.cos(turn(i)):.5f} {math.sin(turn(i)):.5f} {i % 7 / 100}"
    rim = "".join(f"v {place(i)}\n" for i in range(n))
    faces = "".join(f"f 1 {i + 2} {(i + 1) % n + 2}\n" for i in range(n))
    return ("v 0 0 -1\n" + rim + faces).encode()


# The first count of surfaces whose distances are measured.
LARGE = 4_000

# Extension, what makes the file, first and last count for time, first count for work.
COUNTS = {
    "images": ("glb", lambda n: looks(n, 1, 1, 1), 2_000, 256_000, 500),
    "textures": ("glb", lambda n: looks(1, n, 1, 1), 2_000, 256_000, 500),
    "materials": ("glb", lambda n: looks(1, 1, n, 1), 2_000, 128_000, 500),
    "shown": ("glb", lambda n: looks(n, n, n, n), 500, 16_000, 125),
    "nodes": ("glb", nodes, 2_000, 128_000, 500),
    "instances": ("glb", instances, 2_000, 64_000, 500),
    "meshes": ("glb", meshes, 500, 16_000, 125),
    "primitives": ("glb", primitives, 500, 16_000, 500),
    "targets": ("glb", targets, 500, 32_000, 500),
    "joints": ("glb", joints, 1_000, 64_000, 500),
    "animations": ("glb", lambda n: moving(n, 1, 2), 1_000, 64_000, 500),
    "channels": ("glb", lambda n: moving(1, n, 2), 1_000, 32_000, 250),
    "keys": ("glb", lambda n: moving(1, 1, n), 10_000, 640_000, 10_000),
    "accessors": ("glb", accessors, 2_000, 128_000, 500),
    "sparse": ("glb", sparse, 2_000, 64_000, 500),
    "objects": ("obj", lines(lambda i: f"o o{i}\n"), 2_000, 64_000, 500),
    "groups": ("obj", lines(lambda i: f"g g{i}\n"), 2_000, 64_000, 500),
    "usemtls": ("obj", lines(lambda i: f"usemtl m{i}\n"), 500, 16_000, 500),
    # Budgets of distances grow up to 4,000 triangles: a step that looks like growth of the work.
    "high_valence": ("obj", high_valence, 1_000, 128_000, LARGE),
}

# Arguments, with IN for the mesh, A for its .lodc file and S for its stream.
STAGES = {
    "build": ["build", "IN", "-o", "a.lodc"],
    "extract": ["extract", "a.lodc", "--ratio", "0.5", "--no-refit", "-o", "x.glb"],
    "chain": ["chain", "a.lodc", "--levels", "50%,25%", "-o", "c.glb"],
    "view": ["view", "a.lodc", "-o", "v.html"],
    "verify": ["verify", "a.lodc"],
    "info": ["info", "a.lodc"],
    "pack": ["pack", "a.lodc", "-o", "a.lods"],
    "unpack": ["unpack", "a.lods", "-o", "u.glb"],
}


# A surface that grows with the count: what measures distances has samples and budgets that are the
# same for all small ones, so it is looked at from a larger count on, and left out of samples.
SURFACES = {"sparse", "objects", "groups", "usemtls", "high_valence"}
BY_SURFACE = {"build", "verify"}

# Cells that were once beyond the bar: always in a sample.
MENDED = {
    "targets": ["build"],
    "channels": ["chain"],
    "instances": ["chain"],
    "meshes": ["pack", "unpack"],
    "high_valence": ["extract"],
    "primitives": ["extract", "chain", "view", "unpack"],
    "usemtls": ["extract", "chain", "view", "unpack"],
}


def run(command, folder, **more):
    """Runs a command; returns the first line of what it says if it fails."""
    kept = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    done = subprocess.run(command, cwd=folder, **kept, **more)
    if done.returncode == 0:
        return ""
    wrong = done.stderr.decode(errors="replace").strip().splitlines()
    return (wrong or [f"status {done.returncode}"])[0]


def seconds(command, folder):
    """Processor time of a run; none if it failed or took a minute."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    try:
        wrong = run(command, folder, timeout=60)
    except subprocess.TimeoutExpired:
        wrong = "takes more than a minute"
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return (None if wrong else took), wrong


def instructions(command, folder):
    """Instructions of a run; none if it failed."""
    valgrind = "valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null"
    # The program would start again to set what is not set.
    environment = {**os.environ, "MIMALLOC_PURGE_DELAY": "10", "XDG_RUNTIME_DIR": "/tmp"}
    said = pathlib.Path(folder) / "counted.txt"
    wrong = run([*valgrind.split(), f"--log-file={said}", *command], folder, env=environment)
    counted = re.search(r"I +refs: +([\d,]+)", said.read_text())
    return (None if wrong or not counted else int(counted[1].replace(",", ""))), wrong


def command(lodc, stage, mesh):
    """The command line of a stage."""
    words = [mesh if word == "IN" else word for word in STAGES[stage]]
    return [lodc, *words, "-q", "--jobs", "1"]


class Table:
    """What was found, a line for each cell."""

    def __init__(self, unit):
        self.unit, self.rows, self.beyond = unit, [], []

    def add(self, name, stage, n, amount, growth, is_beyond, wrong):
        """Shows a cell."""
        self.rows.append(f"{name},{stage},{n},{amount},{growth:.2f},{wrong}")
        what = wrong + ("  BEYOND" if is_beyond else "")
        cell = f"{name:10} {stage:8} {n:8} {amount:>14} {self.unit}  x {growth:.2f} {what}"
        print(cell.rstrip(), flush=True)
        self.beyond += [f"{name} x {stage}"] if is_beyond else []

    def end(self, file):
        """Writes the table and leaves the program."""
        if file:
            head = f"count,stage,n,{self.unit},growth,stopped\n"
            file.write_text(head + "\n".join(self.rows) + "\n")
        print(f"beyond {MOST}: {', '.join(self.beyond) or 'none'}")
        sys.exit(bool(self.beyond))


def chosen(counts, stages, sample, seed):
    """The cells of a run: stages by count."""
    cells = [(name, stage) for name in counts for stage in stages]
    if sample is None:
        return {name: stages for name in counts}
    cells = [(name, stage) for name, stage in cells if not measures_a_surface(name, stage)]
    always = [(name, stage) for name, stage in cells if stage in MENDED.get(name, [])]
    others = [cell for cell in cells if cell not in always]
    cells = always + random.Random(seed).sample(others, min(sample, len(others)))
    of = lambda name: [stage for stage in stages if (name, stage) in cells]
    return {name: of(name) for name in counts if of(name)}


def measures_a_surface(name, stage):
    """Whether a cell's work depends on budgets of distances."""
    return name in SURFACES and stage in BY_SURFACE


def first(name, stage):
    """The first count of a cell."""
    return LARGE if measures_a_surface(name, stage) else COUNTS[name][4]


def work_of(lodc, name, stages, n):
    """The work of stages at three counts."""
    extension, make = COUNTS[name][:2]
    found = {stage: [] for stage in stages}
    # Later stages need the files of earlier ones.
    needed = {"build", *(["pack"] if "unpack" in stages else [])}
    for size in (n, 2 * n, 4 * n):
        with tempfile.TemporaryDirectory(prefix="lodc-growth-") as folder:
            mesh = f"in.{extension}"
            (pathlib.Path(folder) / mesh).write_bytes(make(size))
            for stage in STAGES:
                if stage in stages:
                    found[stage].append(instructions(command(lodc, stage, mesh), folder))
                elif stage in needed:
                    run(command(lodc, stage, mesh), folder)
    return found


def work(asked, stages):
    """The table of counted work."""
    counts = asked.counts.split(",")
    cells = chosen(counts, stages, asked.sample, asked.seed)
    if asked.sample is not None:
        print(f"seed {asked.seed}")
    table = Table("instructions")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = []
        for name, stages in cells.items():
            for n in sorted({first(name, stage) for stage in stages}):
                own = [stage for stage in stages if first(name, stage) == n]
                rows.append((name, 4 * n, pool.submit(work_of, asked.lodc, name, own, n)))
        for name, n, row in rows:
            for stage, found in row.result().items():
                wrong = next((wrong for took, wrong in found if took is None), None)
                if wrong is not None:
                    table.add(name, stage, n, 0, 0.0, True, wrong or "was not counted")
                    continue
                small, middle, large = [took for took, _ in found]
                growth = (large - middle) / max(middle - small, CHANCE)
                table.add(name, stage, n, large, growth, growth > MOST, "")
    return table


def times(asked, stages):
    """The table of times."""
    table = Table("s")
    for name in asked.counts.split(","):
        extension, make, n, last, _ = COUNTS[name]
        history, open_stages, stopped = {stage: [] for stage in stages}, set(stages), {}
        while n <= last and open_stages:
            with tempfile.TemporaryDirectory(prefix="lodc-growth-") as folder:
                mesh = f"in.{extension}"
                (pathlib.Path(folder) / mesh).write_bytes(make(n))
                for stage in STAGES:
                    # Later stages need the files of earlier ones.
                    if stage not in open_stages and stage not in ("build", "pack"):
                        continue
                    took, wrong = seconds(command(asked.lodc, stage, mesh), folder)
                    if stage not in open_stages:
                        continue
                    if took is None:
                        stopped[stage] = f"{n}: {wrong}"
                        open_stages.discard(stage)
                        continue
                    history[stage].append((n, took))
                    if took >= asked.seconds:
                        open_stages.discard(stage)
            n *= 2
        for stage in stages:
            count, took = history[stage][-1] if history[stage] else (0, 0.0)
            growth = took / max(history[stage][-2][1], 0.005) if len(history[stage]) > 1 else 0.0
            wrong = stopped.get(stage, "")
            late = growth > MOST and took >= asked.seconds / 4 or "minute" in wrong
            table.add(name, stage, count, f"{took:.3f}", growth, late, wrong)
    return table


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lodc", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--counts", default=",".join(COUNTS))
    parser.add_argument("--stages", default=",".join(STAGES))
    parser.add_argument("--time", action="store_true")
    parser.add_argument("--seconds", type=float, default=0.8)
    parser.add_argument("--sample", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=pathlib.Path)
    asked = parser.parse_args()
    measure = times if asked.time else work
    measure(asked, asked.stages.split(",")).end(asked.csv)


main()
