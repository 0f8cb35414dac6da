"""Compares the Python package with what this program wrote: see tests/cli/second_reader.rs.

usage: second_reader.py levels FOLDER | streams STATES FOLDER | facts FOLDER | damage FOLDER
"""

import json
import pathlib
import random
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli/packaging/python"))

import numpy as np

import lodc


def oriented(triangles, submesh):
    """Submesh and corners of each triangle, the smallest corner first, sorted."""
    t = np.asarray(triangles, np.int64).reshape(-1, 3)
    first, row = t.argmin(axis=1), np.arange(len(t))
    t = np.stack([t[row, (first + i) % 3] for i in range(3)], axis=1)
    t = np.column_stack([np.asarray(submesh, np.int64), t])
    return t[np.lexsort(t.T[::-1])]


class Words:
    """Numbers of a dump, one after the other."""

    def __init__(self, path):
        self.words, self.at = np.fromfile(path, "<u4"), 0

    def take(self, count):
        self.at += count
        return self.words[self.at - count : self.at]

    def one(self):
        return int(self.take(1)[0])

    def triangles(self):
        return self.take(4 * self.one()).reshape(-1, 4).astype(np.int64)

    def is_read(self):
        return self.at >= len(self.words)


def glb(path):
    """The primitives of a GLB: the values of each attribute, and triangles."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    root, blob = json.loads(data[20 : 20 + length]), data[28 + length :]
    types = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
    widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

    def accessor(number):
        a = root["accessors"][number]
        view = root["bufferViews"][a["bufferView"]]
        dtype, width = np.dtype(types[a["componentType"]]), widths[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", dtype.itemsize * width)
        rows = [blob[start + i * stride :][: dtype.itemsize * width] for i in range(a["count"])]
        return np.frombuffer(b"".join(rows), dtype).reshape(-1, width)

    for mesh in root.get("meshes", []):
        for primitive in mesh["primitives"]:
            indices = accessor(primitive["indices"]).reshape(-1, 3).astype(np.int64)
            yield accessor(primitive["attributes"]["POSITION"]), indices


def by_position(positions, triangles):
    """The oriented triangles of a mesh by the bytes of their corners, sorted."""
    bits = np.ascontiguousarray(positions, "<f4").view("<u4").astype(np.int64)
    rows = []
    for t in np.asarray(triangles, np.int64):
        corners = [tuple(bits[v]) for v in t]
        rows.append(min((corners[i:] + corners[:i]) for i in range(3)))
    return sorted(rows)


def levels(folder):
    files = count = extracted = 0
    for path in sorted(folder.glob("*.levels")):
        words, obj = Words(path), lodc.open(path.with_suffix(".lodc")).objects[0]
        structures = [None, *obj.structures]
        assert len(structures) == 4, f"{path.stem}: {structures}"
        while not words.is_read():
            lod, wanted = words.one(), words.triangles()
            for structure in structures:
                level = obj.level(lod, structure=structure)
                found = oriented(level.vertices[level.triangles], level.submesh)
                assert np.array_equal(found, wanted), f"{path.stem}: LOD {lod} of {structure}"
            assert len(wanted) == obj.counts[np.searchsorted(obj.lods, lod)], path.stem
            glb_path = folder / f"{path.stem}@{lod}.glb"
            if glb_path.exists():
                parts = [by_position(*part) for part in glb(glb_path)]
                part = obj.level(lod)
                mine = [
                    by_position(part.positions, part.of_submesh(s))
                    for s in range(len(obj.submeshes))
                ]
                assert parts == [rows for rows in mine if rows], f"{path.stem}: LOD {lod}, extract"
                extracted += 1
            count += 1
        files += 1
    print(f"{files} files, {count} levels in every structure, {extracted} of them by extract")


def streams(states, folder):
    count = steps = 0
    for path in sorted(states.glob("*.states")):
        files = lodc.open(folder / f"{path.stem}.lodc").objects

        def step(obj):
            nonlocal steps
            whole, steps = files[obj.number], steps + 1
            last = len(whole.positions) - 1
            found = oriented(last - obj.triangles.astype(np.int64), obj.triangle_submesh)
            wanted = oriented(*whole.live_triangles(last + 1 - len(obj.targets)))
            assert np.array_equal(found, wanted), f"{path.stem}: step {obj.steps}"
            targets = last - whole.targets[::-1][: len(obj.targets) - 1].astype(np.int64)
            come = obj.has_come[1:]
            assert (np.array(obj.targets[1:])[come] == targets[come]).all(), path.stem

        stream, words = lodc.stream(), Words(path)
        stream.each_step = step
        data, end = (folder / f"{path.stem}.lods").read_bytes(), 0
        while not words.is_read():
            start, end = end, words.one()
            stream.feed(data[start:end])
            assert stream.used == end and len(stream.objects) == words.one(), (
                f"{path}: {end} bytes"
            )
            for obj in stream.objects:
                compare(obj, words, f"{path}: {end} bytes, {obj.name}")
        assert stream.is_complete() and stream.used == len(data), path
        for obj, whole in zip(stream.objects, files):
            pairs = [(obj.positions, whole.positions)]
            pairs += [(obj.values(i), v) for i, v in enumerate(whole.values)]
            for mine, wanted in pairs:
                assert mine[::-1].tobytes() == wanted.tobytes(), f"{path}: {obj.name}"
            assert obj.attributes == whole.attributes and obj.submeshes == whole.submeshes, path
        count += 1
    print(f"{count} streams, {steps} steps")


def compare(obj, words, what):
    """Compares an object of a stream with the next state of a dump."""
    vertices, error, rms = words.one(), words.one(), words.one()
    assert len(obj.targets) == vertices, what
    assert struct.pack("<f", obj.error) == struct.pack("<I", error) or not obj.steps, what
    has_rms = struct.unpack("<f", struct.pack("<I", rms))[0]
    assert obj.rms == (has_rms if has_rms == has_rms else None), what
    triangles = np.column_stack([obj.triangle_submesh, obj.triangles]) if vertices else []
    wanted = words.triangles()
    found = oriented(obj.triangles, obj.triangle_submesh) if len(triangles) else wanted[:0]
    assert np.array_equal(found, wanted[np.lexsort(wanted.T[::-1])]), what


def facts(folder):
    for path in sorted(folder.glob("*.lodc")):
        file = lodc.open(path)
        digest = f"{file.source.content_hash:032x}"
        layout = " layout gpu" if file.layout == "gpu" else ""
        print(path.name, file.source.format, digest, "objects", f"{len(file.objects)}{layout}")
        for o in file.objects:
            step = int(np.argmax(o.counts <= len(o.triangles) // 2))
            half = o.lods[step]
            total = sum(int(v.view("u1").sum(dtype=np.int64)) for v in o.values if v.size)
            line = (
                f"{path.name} {o.name} vertices {len(o.positions)} triangles {len(o.triangles)} "
                f"submeshes {len(o.submeshes)} attributes {len(o.attributes)} sum {total} "
                f"records {len(o.targets)} steps {len(o.lods) - 1} half {half} {o.counts[step]} "
                f"models {','.join(o.structures)}"
            )
            if o.rms is not None:
                bits = [int(c[step : step + 1].view(np.uint32)[0]) for c in (o.errors, o.rms)]
                line += " error {:08x} rms {:08x}".format(*bits)
            print(line)


def damage(folder):
    """Every flipped byte of a file is found; of a stream, what comes before it stays."""
    found, generator = 0, random.Random(1)
    for path in [*sorted(folder.glob("*.lodc")), *sorted(folder.glob("*.lods"))]:
        whole = path.read_bytes()
        # A stream is decoded up to the change, in Python.
        changes = min(len(whole), 60 if path.suffix == ".lodc" else 15)
        for at in sorted(generator.sample(range(len(whole)), changes)):
            data = bytearray(whole)
            data[at] ^= 1 << generator.randrange(8)
            try:
                if path.suffix == ".lodc":
                    lodc.open(bytes(data))
                else:
                    lodc.stream(bytes(data) + bytes(1 << 17))
            except lodc.FormatError as e:
                assert e.place and e.what, path
                found += 1
            else:
                raise AssertionError(f"{path}: byte {at} changed unnoticed")
    for prefix in range(0, 160, 7):
        stream = lodc.stream((folder / "triangle.lods").read_bytes()[:prefix])
        assert not stream.is_complete()
    print(f"all {found} damaged files were refused")


commands = {"levels": levels, "streams": streams, "facts": facts, "damage": damage}
commands[sys.argv[1]](*map(pathlib.Path, sys.argv[2:]))
