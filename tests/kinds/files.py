"""What the campaign reads and changes of lodc's files."""

import json
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "cli/packaging/python"))

import lodc
from distance import Surface
from lodc.container import Container
from lodc.xxh3 import xxh3_64

TYPES = {5123: "<u2", 5125: "<u4", 5121: "u1", 5126: "<f4"}


def chunks(path):
    """The JSON and the bytes of a GLB."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def levels(path):
    """The surface of each mesh of a GLB, each of one primitive."""
    root, blob = chunks(path)

    def accessor(number, width):
        a = root["accessors"][number]
        view, dtype = root["bufferViews"][a["bufferView"]], np.dtype(TYPES[a["componentType"]])
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", dtype.itemsize * width)
        shape = (a["count"], width)
        return np.ndarray(shape, dtype, blob, start, (stride, dtype.itemsize))

    for mesh in root["meshes"]:
        part = mesh["primitives"][0]
        corners = accessor(part["indices"], 1).reshape(-1, 3)
        yield Surface(accessor(part["attributes"]["POSITION"], 3), corners)


def with_numbers(path, out, error=1.0, rms=1.0):
    """Writes a GLB again whose levels state other numbers."""
    root, blob = chunks(path)
    stated = root["extras"]["lodc"]
    for level in stated.get("levels", [stated]):
        for name, factor in (("error", error), ("rms", rms)):
            if level[name] is not None:
                level[name] *= factor
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob))
    parts = [head, struct.pack("<I4s", len(text), b"JSON"), text]
    parts += [struct.pack("<I4s", len(blob), b"BIN\0"), blob]
    out.write_bytes(b"".join(parts))


class Sequence:
    """The levels of a .lodc file of one object, and what it states of each."""

    def __init__(self, path):
        self.object = lodc.open(path).objects[0]
        self.counts, self.lods = self.object.counts, self.object.lods
        self.errors, self.rms = self.object.errors, self.object.rms

    def step(self, triangles):
        """The finest level of at most so many triangles."""
        return min(int(np.searchsorted(-self.counts, -triangles)), len(self.counts) - 1)

    def surface(self, step):
        level = self.object.level(int(self.lods[step]))
        return Surface(level.positions, level.triangles)


def curve(numbers):
    """The bytes of a curve (docs/FORMAT.md, section 2)."""
    bits = np.asarray(numbers, "<f4").view("<u4").astype(np.int64)
    out = bytearray()
    for more in np.diff(bits, prepend=0).tolist():
        while more > 127:
            out.append(more & 127 | 128)
            more >>= 7
        out.append(more)
    return bytes(out)


def injected(path, out, error=1.0, rms=1.0):
    """Writes a file whose curves are scaled, with right checksums and without what says that this
    program made it. Returns the factor of the mean distances where it is least: they stay below
    the largest ones."""
    file, data = Sequence(path), memoryview(path.read_bytes())
    errors = file.errors[1:] * np.float32(error)
    means = np.minimum(file.rms[1:] * np.float32(rms), errors)
    count = struct.unpack_from("<I", data, 12)[0]
    entries, sections = [], []
    for at in range(40, 40 + 40 * count, 40):
        tag, flags, number, index, start, length, _ = struct.unpack_from("<4sIIIQQQ", data, at)
        if tag in (b"MADE", b"LEVL"):
            continue
        content = bytes(data[start : start + length])
        content = {b"SERR": curve(errors), b"SRMS": curve(means)}.get(tag, content)
        entries.append((tag, flags, number, index, content))
    end = 40 + 40 * len(entries)
    table = b""
    for tag, flags, number, index, content in entries:
        gap = -end % (256 if flags & 2 else 16)
        sections.append(b"\0" * gap + content)
        where = (end + gap, len(content), xxh3_64(content))
        table += struct.pack("<4sIIIQQQ", tag, flags, number, index, *where)
        end += gap + len(content)
    head = bytes(data[:12]) + struct.pack("<IQQ", len(entries), end, xxh3_64(table))
    out.write_bytes(head + struct.pack("<Q", xxh3_64(head)) + table + b"".join(sections))
    Container(memoryview(out.read_bytes()))
    finite = np.isfinite(file.rms[1:]) & (file.rms[1:] > 0)
    factors = means[finite] / file.rms[1:][finite]
    return float(factors.min()) if len(factors) else 1.0
