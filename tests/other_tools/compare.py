#!/usr/bin/env python3
"""Compares lodc with other simplifiers on one mesh: `just other-tools [MESH.obj]`.

Every tool gets the same positions and faces, is asked for the same numbers of triangles, and is
measured by the same ruler: points spread evenly over both surfaces, exact distances to the other
one, root mean square of both ways, in percent of the diagonal. Times are those of simplifying
alone, on one thread; that of lodc is for all levels at once, those of the others are for one."""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time

import igl
import numpy as np

LEVELS = (0.5, 0.25, 0.1, 0.05, 0.01)


# ------------------------------------------------------------------------------------------ meshes


def read_obj(path):
    """Positions and triangles; polygons become fans, everything else is passed over."""
    points, faces = [], []
    with open(path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                points.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(w.split("/")[0]) for w in words[1:]]
                corners = [c - 1 if c > 0 else len(points) + c for c in corners]
                faces += [[corners[0], b, c] for b, c in zip(corners[1:], corners[2:])]
    return np.array(points, np.float32), np.array(faces, np.int64)


def clean(points, faces):
    """Without degenerate and doubled faces and without points that no face uses."""
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    faces = faces[distinct & (faces[:, 2] != faces[:, 0])]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    faces = faces[np.sort(first)]
    used, renumbered = np.unique(faces, return_inverse=True)
    return points[used], renumbered.reshape(-1, 3)


def write_obj(path, points, faces):
    with open(path, "w", encoding="ascii") as out:
        out.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        out.writelines(f"f {a} {b} {c}\n" for a, b, c in (faces + 1).tolist())


# --------------------------------------------------------------------------------------- the ruler


def spread(points, faces, count, seed):
    """Points spread over a surface, evenly by area, one in each of `count` equal shares of it."""
    a, b, c = (points[faces[:, k]].astype(float) for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    random = np.random.default_rng(seed)
    share = (np.arange(count) + random.random(count)) / count
    face = np.searchsorted(np.cumsum(area) / area.sum(), share).clip(max=len(faces) - 1)
    u, v = random.random((2, count))
    over = u + v > 1
    u[over], v[over] = 1 - u[over], 1 - v[over]
    return a[face] + u[:, None] * (b - a)[face] + v[:, None] * (c - a)[face]


def rms(first, second, samples):
    """Root mean square distance of two surfaces: the mean of the squares of both ways."""
    squares = []
    for one, other in ((first, second), (second, first)):
        at = spread(*one, samples, 1)
        to = (other[0].astype(float), other[1].astype(np.int64))
        squares.append(float(np.mean(igl.point_mesh_squared_distance(at, *to)[0])))
    return math.sqrt(sum(squares) / 2)


# ------------------------------------------------------------------------------------------- tools


def meshoptimizer(points, faces, count):
    import meshoptimizer as tool

    indices = np.ascontiguousarray(faces.ravel(), np.uint32)
    out = np.zeros(len(indices), np.uint32)
    length = tool.simplify(out, indices, points, target_index_count=3 * count, target_error=1e30)
    return points, out[:length].reshape(-1, 3)


def openmesh(points, faces, count):
    import openmesh as tool

    mesh = tool.TriMesh(points=points.astype(float), face_vertex_indices=faces.astype(np.int32))
    decimater = tool.TriMeshDecimater(mesh)
    quadrics = tool.TriMeshModQuadricHandle()
    decimater.add(quadrics)
    decimater.module(quadrics).unset_max_err()
    decimater.initialize()
    decimater.decimate_to_faces(0, count)
    mesh.garbage_collection()
    return mesh.points(), mesh.face_vertex_indices()


def fast_simplification(points, faces, count):
    import fast_simplification as tool

    return tool.simplify(points.astype(float), faces.astype(np.int32), target_count=count)


def pyfqmr(points, faces, count):
    import pyfqmr

    tool = pyfqmr.Simplify()
    tool.setMesh(points.astype(float), faces.astype(np.int32))
    tool.simplify_mesh(target_count=count, verbose=False)
    return tool.getMesh()[:2]


# Name, function, and whether every vertex of the result is one of the input, as with lodc.
OTHER_TOOLS = (
    ("OpenMesh", openmesh, True),
    ("meshoptimizer", meshoptimizer, True),
    ("fast-simplification", fast_simplification, False),
    ("pyfqmr", pyfqmr, False),
)


class Lodc:
    """One file for all levels; each is taken out of it."""

    def __init__(self, program, metric, folder, mesh):
        self.program, self.folder = program, folder
        self.file = os.path.join(folder, "mesh.lodc")
        source = os.path.join(folder, "mesh.obj")
        write_obj(source, *mesh)
        report = self.run("build", source, "-o", self.file, "--models", "interactive",
                          "--metric", metric, "--jobs", "1", "--report", "json", "-q")
        stages = json.loads(report)["inputs"][0]["stages"]
        self.seconds = next(s["seconds"] for s in stages if s["name"] == "simplify")

    def run(self, *words):
        return subprocess.run([self.program, *words], check=True, stdout=subprocess.PIPE).stdout

    def level(self, count):
        out = os.path.join(self.folder, "level.obj")
        self.run("extract", self.file, "--triangles", str(count), "-o", out, "-q", "--no-refit")
        return read_obj(out)


# --------------------------------------------------------------------------------------- the table


def measure(mesh, lodc, levels, samples):
    """Rows of (tool, half-edge, level, triangles, RMS in percent, seconds)."""
    diagonal = float(np.linalg.norm(mesh[0].max(axis=0) - mesh[0].min(axis=0)))
    missing = set()
    for level in levels:
        count = int(level * len(mesh[1]))
        result = lodc.level(count)
        error = 100 * rms(mesh, result, samples) / diagonal
        yield "lodc", True, level, len(result[1]), error, lodc.seconds
        for name, simplify, same_points in OTHER_TOOLS:
            try:
                start = time.process_time()
                points, faces = simplify(*mesh, count)
                seconds = time.process_time() - start
            except ImportError as e:
                if name not in missing:
                    hint = "; --build-openmesh builds it" if name == "OpenMesh" else ""
                    print(f"{name} is left out: {e}{hint}", file=sys.stderr)
                missing.add(name)
                continue
            result = np.asarray(points, float), np.asarray(faces, np.int64)
            error = 100 * rms(mesh, result, samples) / diagonal
            yield name, same_points, level, len(faces), error, seconds


def show(rows):
    print(f"{'tool':20} {'vertices':9} {'level':>6} {'triangles':>10} {'RMS %':>9} {'s':>8}  "
          f"{'lodc / tool':>11}")
    ratios = {}
    own = 1.0
    for name, same_points, level, triangles, error, seconds in rows:
        own = error if name == "lodc" else own
        ratio = own / error if error > 0 else float("nan")
        ratios.setdefault((name, same_points), []).append(ratio)
        print(f"{name:20} {'input' if same_points else 'moved':9} {level:6.0%} {triangles:10,} "
              f"{error:9.5f} {seconds:8.3f}  {ratio:11.2f}", flush=True)
    print("\nRMS of lodc / RMS of the tool, geometric mean of the levels (below 1: lodc is closer)")
    for (name, same_points), values in ratios.items():
        if name != "lodc":
            mean = math.exp(sum(math.log(v) for v in values if v > 0) / len(values))
            kind = "keeps vertices, as lodc does" if same_points else "may move vertices"
            print(f"{name:20} {mean:5.2f}   {kind}")


def main():
    words = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    words.add_argument("mesh", help="an OBJ file; attributes are not compared")
    words.add_argument("--lodc", default="target/release/lodc", help="the program")
    words.add_argument("--metric", default="quadric", help="what drives lodc's collapses")
    words.add_argument("--samples", type=int, default=100_000, help="points on each surface")
    words.add_argument("--csv", help="also write the rows to this file")
    given = words.parse_args()
    mesh = clean(*read_obj(given.mesh))
    print(f"{given.mesh}: {len(mesh[1]):,} triangles, {len(mesh[0]):,} vertices\n")
    with tempfile.TemporaryDirectory() as folder:
        lodc = Lodc(given.lodc, given.metric, folder, mesh)
        rows = list(measure(mesh, lodc, LEVELS, given.samples))
    show(rows)
    if given.csv:
        with open(given.csv, "w", encoding="utf-8") as out:
            out.write(f"# just other-tools {given.mesh}\n")
            out.write("tool,half_edge,level,triangles,rms,seconds\n")
            out.writelines(",".join(str(c) for c in row) + "\n" for row in rows)


if __name__ == "__main__":
    main()
