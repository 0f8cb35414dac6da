"""Measures how the program's time grows with each count that a file can hold: `just growth`.

growth.py LODC [--counts a,b] [--stages a,b] [--seconds S] [--csv FILE]

For each count a file is made whose other counts stay small, and doubled until a stage takes S
seconds of processor time on one thread or the count reaches its end. The table shows the last
count, its seconds and the growth over the half of it. Growth above 2.4 where a stage takes S / 4
seconds or more is named, and ends with 1.
"""
import argparse
import json
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile

MOST = 2.4


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
    values = glb.view(struct.pack(f"<{3 * side}f", *places(n)))
    ends = {"min": [0, 0, 0], "max": [n, 1, 1]}
    indices = {"bufferView": indices, "componentType": 5125}
    given = {"count": side, "indices": indices, "values": {"bufferView": values}}
    kind = {"componentType": 5126, "count": side, "type": "VEC3"}
    glb.accessors.append({**kind, "sparse": given, **ends})
    return glb.bytes()


def places(n):
    """Corners of triangles beside each other."""
    return [c for i in range(n) for c in (i, 0, 0, i, 1, 0, i, 0, 1)]


def lines(before):
    """An OBJ of triangles beside each other, with a line before each."""
    corners = lambda i: f"v {i} 0 0\nv {i} 1 0\nv {i} 0 1\n"
    face = lambda i: f"{before(i)}f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n"
    return lambda n: "".join(corners(i) + face(i) for i in range(n)).encode()


def hub(n):
    """Triangles around one vertex."""
    rim = "".join(f"v {i * 7919 % 1009} {i * 104729 % 2003} {i}\n" for i in range(n))
    faces = "".join(f"f 1 {i + 2} {(i + 1) % n + 2}\n" for i in range(n))
    return ("v 0 0 -1\n" + rim + faces).encode()


# Name, extension, what makes the file, first and last count.
COUNTS = {
    "images": ("glb", lambda n: looks(n, 1, 1, 1), 2_000, 256_000),
    "textures": ("glb", lambda n: looks(1, n, 1, 1), 2_000, 256_000),
    "materials": ("glb", lambda n: looks(1, 1, n, 1), 2_000, 128_000),
    "shown": ("glb", lambda n: looks(n, n, n, n), 500, 16_000),
    "nodes": ("glb", nodes, 2_000, 128_000),
    "instances": ("glb", instances, 2_000, 64_000),
    "meshes": ("glb", meshes, 500, 16_000),
    "primitives": ("glb", primitives, 500, 16_000),
    "targets": ("glb", targets, 500, 32_000),
    "joints": ("glb", joints, 1_000, 64_000),
    "animations": ("glb", lambda n: moving(n, 1, 2), 1_000, 64_000),
    "channels": ("glb", lambda n: moving(1, n, 2), 1_000, 32_000),
    "keys": ("glb", lambda n: moving(1, 1, n), 10_000, 640_000),
    "accessors": ("glb", accessors, 2_000, 128_000),
    "sparse": ("glb", sparse, 2_000, 64_000),
    "objects": ("obj", lines(lambda i: f"o o{i}\n"), 2_000, 64_000),
    "groups": ("obj", lines(lambda i: f"g g{i}\n"), 2_000, 64_000),
    "usemtls": ("obj", lines(lambda i: f"usemtl m{i}\n"), 500, 16_000),
    "hub": ("obj", hub, 1_000, 128_000),
}

# Arguments, with IN for the mesh, A for its .lodc file and S for its stream.
STAGES = {
    "build": ["build", "IN", "-o", "a.lodc"],
    "extract": ["extract", "a.lodc", "--ratio", "0.5", "-o", "x.glb"],
    "chain": ["chain", "a.lodc", "--levels", "50%,25%", "-o", "c.glb"],
    "view": ["view", "a.lodc", "-o", "v.html"],
    "verify": ["verify", "a.lodc"],
    "info": ["info", "a.lodc"],
    "pack": ["pack", "a.lodc", "-o", "a.lods"],
    "unpack": ["unpack", "a.lods", "-o", "u.glb"],
}


def seconds(lodc, arguments, folder):
    """Processor time of a run; none if it failed or took a minute."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [lodc, *arguments, "-q", "--jobs", "1"]
    try:
        kept = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        run = subprocess.run(command, cwd=folder, timeout=60, **kept)
    except subprocess.TimeoutExpired:
        return None, "takes more than a minute"
    wrong = run.stderr.decode(errors="replace").strip().splitlines()
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return (took, "") if run.returncode == 0 else (None, (wrong or [f"status {run.returncode}"])[0])


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lodc", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--counts", default=",".join(COUNTS))
    parser.add_argument("--stages", default=",".join(STAGES))
    parser.add_argument("--seconds", type=float, default=0.8)
    parser.add_argument("--csv", type=pathlib.Path)
    asked = parser.parse_args()
    stages = asked.stages.split(",")
    rows, beyond = [], []
    for name in asked.counts.split(","):
        extension, make, n, last = COUNTS[name]
        history, open_stages, stopped = {stage: [] for stage in stages}, set(stages), {}
        while n <= last and open_stages:
            with tempfile.TemporaryDirectory(prefix="lodc-growth-") as folder:
                mesh = f"in.{extension}"
                (pathlib.Path(folder) / mesh).write_bytes(make(n))
                for stage, words in STAGES.items():
                    # Later stages need the files of earlier ones.
                    if stage not in open_stages and stage not in ("build", "pack"):
                        continue
                    words = [mesh if word == "IN" else word for word in words]
                    took, wrong = seconds(asked.lodc, words, folder)
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
            late = growth > MOST and took >= asked.seconds / 4
            rows.append(f"{name},{stage},{count},{took:.3f},{growth:.2f},{stopped.get(stage, '')}")
            what = stopped.get(stage, "") + ("  BEYOND" if late else "")
            print(f"{name:10} {stage:8} {count:8} {took:7.3f} s  x {growth:.2f} {what}", flush=True)
            beyond += [f"{name} x {stage}"] if late or "minute" in stopped.get(stage, "") else []
    if asked.csv:
        asked.csv.write_text("count,stage,n,seconds,growth,stopped\n" + "\n".join(rows) + "\n")
    print(f"beyond {MOST}: {', '.join(beyond) or 'none'}")
    sys.exit(bool(beyond))


main()
