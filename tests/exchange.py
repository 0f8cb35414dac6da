"""Outputs in the eyes of a reader that is not ours: trimesh. `exchange.py LODC CORPUS`

Ten files of each format, real ones where the corpus has them, others made here, become every
format at full detail. What trimesh finds in an output has to be what it finds in the input:
triangles, bounds, names of materials, which texture each has, colours of vertices. Triangles
without area are not counted: lodc drops them."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import trimesh

PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c489"
    "0000000d49444154789c63f8cfc0f01f00050001ffabce54d40000000049454e44ae426082"
)
FORMATS = ("glb", "gltf", "obj", "ply", "stl")


def grid(n, bump):
    """Positions, triangles and texture coordinates of a bumpy square."""
    y, x = numpy.mgrid[0 : n + 1, 0 : n + 1]
    z = (x * 7 + y * bump) % 5 / 4
    points = numpy.stack([x, y, z], -1).reshape(-1, 3).astype(float)
    a = (y[:-1, :-1] * (n + 1) + x[:-1, :-1]).ravel()
    faces = numpy.concatenate(
        [numpy.stack([a, a + 1, a + n + 2], -1), numpy.stack([a, a + n + 2, a + n + 1], -1)]
    )
    return points, faces, points[:, :2] / n


def made(folder, extension, number):
    """A file of a format: plain, coloured or with two textures, by its number."""
    points, faces, uv = grid(5 + number, number + 3)
    path = folder / f"made{number}.{extension}"
    kind = number % 3
    colours = (numpy.arange(len(points) * 3).reshape(-1, 3) * (number + 7)) % 256
    if extension == "obj":
        lines = [f"mtllib made{number}.mtl"] if kind == 2 else []
        for p, c in zip(points, colours):
            colour = " %.6f %.6f %.6f" % tuple(c / 255) if kind == 1 else ""
            lines.append("v %g %g %g%s" % (*p, colour))
        # Of texture coordinates without a material trimesh makes a material of its own.
        lines += ["vt %g %g" % tuple(t) for t in uv] if kind == 2 else []
        for i, face in enumerate(faces):
            if kind == 2 and i % (len(faces) // 2) == 0:
                lines.append("usemtl " + ("wood", "stone")[min(1, i // (len(faces) // 2))])
            lines.append(
                "f " + " ".join(f"{v + 1}/{v + 1}" if kind == 2 else f"{v + 1}" for v in face)
            )
        path.write_text("\n".join(lines) + "\n")
        if kind == 2:
            (folder / f"made{number}.mtl").write_text(
                "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nnewmtl stone\nKd 1 1 1\nmap_Kd stone.png\n"
            )
            (folder / "wood.png").write_bytes(PNG)
            (folder / "stone.png").write_bytes(PNG + b"\0")
        return path
    mesh = trimesh.Trimesh(points, faces, process=False)
    if kind == 1 and extension != "stl":
        mesh.visual.vertex_colors = numpy.concatenate(
            [colours, numpy.full((len(points), 1), 255)], -1
        )
    mesh.export(path)
    return path


def corpus_files(corpus, extension):
    """Small valid files of the corpus with triangles that trimesh reads, at most five."""
    if corpus is None:
        return []
    facts = json.loads((corpus / "manifest.json").read_text())
    fits = [
        corpus / name
        for name, f in sorted(facts.items())
        if name.endswith("." + extension)
        and "invalid" not in name
        and 12 <= (f.get("triangles") or 0) <= 20_000
        and f.get("modes", [4]) == [4]
        and not f.get("skins")
        and not f.get("extensions_required")
        and "faces" in str(f.get("trimesh", ""))
    ]
    return fits[:: max(1, len(fits) // 5)][:5]


def facts(path):
    """What trimesh sees in a file."""
    scene = trimesh.load_scene(path, process=False)
    corners, bindings, colours = [], set(), set()
    for name in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        corners.append(trimesh.transform_points(mesh.vertices, transform)[mesh.faces])
        visual = mesh.visual
        material = getattr(visual, "material", None)
        image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
        if material is not None:
            bindings.add((material.name or "", image.tobytes() if image is not None else None))
        if visual.kind == "vertex":
            colours.update(
                map(tuple, visual.vertex_colors[numpy.unique(mesh.faces)][:, :3].tolist())
            )
    corners = numpy.concatenate(corners) if corners else numpy.zeros((0, 3, 3))
    same = lambda i, j: (corners[:, i].astype("f4") == corners[:, j].astype("f4")).all(-1)
    corners = corners[~(same(0, 1) | same(1, 2) | same(2, 0))]
    return corners, bindings, colours


def near(a, b):
    """Whether two sets of colours are the same up to a step of 8 bits."""
    a, b = (numpy.array(sorted(s), float).reshape(-1, 3) for s in (a, b))
    if len(a) == 0 or len(b) == 0:
        return len(a) == len(b)
    distance = numpy.abs(a[:, None] - b[None]).max(-1)
    return distance.min(1).max() <= 1 and distance.min(0).max() <= 1


def linear(colours):
    """sRGB values as trimesh shows them of a glTF, whose numbers are linear light."""
    out = set()
    for colour in colours:
        v = numpy.array(colour) / 255
        light = numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
        out.add(tuple(numpy.round(light * 255).astype(int).tolist()))
    return out


def compare(source, output):
    """Differences between what trimesh sees in two files."""
    (a, bindings_a, colours_a), (b, bindings_b, colours_b) = facts(source), facts(output)
    if len(a) != len(b):
        yield f"{len(b)} triangles, not {len(a)}"
    elif len(a):
        ends = lambda c: numpy.stack([c.reshape(-1, 3).min(0), c.reshape(-1, 3).max(0)])
        size = numpy.ptp(ends(a), axis=0).max()
        if numpy.abs(ends(a) - ends(b)).max() > 1e-5 * max(size, 1e-30):
            yield f"bounds {ends(b).tolist()}, not {ends(a).tolist()}"
    kinds = [p.suffix[1:] for p in (source, output)]
    is_gltf = [k in ("glb", "gltf") for k in kinds]
    if "stl" in kinds:
        return
    if all(is_gltf) or "ply" not in kinds and source.name.startswith("made"):
        if bindings_a != bindings_b and {m for m, _ in bindings_a} != {""}:
            names = [sorted(n for n, _ in bindings) for bindings in (bindings_b, bindings_a)]
            yield "materials {}, not {}".format(*names)
    if source.name.startswith("made"):
        if is_gltf[1] and not is_gltf[0]:
            colours_a = linear(colours_a)
        if is_gltf[0] and not is_gltf[1]:
            colours_b = linear(colours_b)
        if not near(colours_a, colours_b):
            yield f"{len(colours_b)} colours, not {len(colours_a)}"


def main():
    lodc = os.path.abspath(sys.argv[1])
    corpus = None if len(sys.argv) < 3 or sys.argv[2] == "none" else Path(sys.argv[2])
    wrong, count = [], 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for extension in FORMATS:
            files = corpus_files(corpus, extension)
            for number in range(10 - len(files)):
                (folder / extension).mkdir(exist_ok=True)
                kind = "glb" if extension == "gltf" else extension
                path = made(folder / extension, kind, number)
                if extension == "gltf":
                    gltf = path.with_suffix(".gltf")
                    subprocess.run(
                        [lodc, "extract", path, "--lod", "0", "-o", gltf, "-q"], check=True
                    )
                    path = gltf
                files.append(path)
            for source in files:
                for target in FORMATS:
                    out = folder / "out"
                    out.mkdir(exist_ok=True)
                    output = out / f"{source.stem}.{target}"
                    run = subprocess.run(
                        [lodc, "extract", source, "--ratio", "1", "-o", output, "-q"],
                        capture_output=True,
                        text=True,
                    )
                    problems = (
                        [run.stderr.strip()] if run.returncode else list(compare(source, output))
                    )
                    wrong += [f"{source.name} as {target}: {p}" for p in problems]
                    count += 1
    print(f"{count} outputs read by trimesh {trimesh.__version__}, {len(wrong)} differ")
    print("\n".join(wrong))
    sys.exit(bool(wrong))


main()
