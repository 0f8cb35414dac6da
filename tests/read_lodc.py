"""Reads .lodc files with nothing but the standard library, from docs/FORMAT.md alone, and prints
what is in them.

usage: read_lodc.py FOLDER   (prints the same lines as facts.txt in that folder)
Checksums are left out: XXH3 is not in the standard library.
"""

import pathlib
import struct
import sys

SCENE = 0xFFFFFFFF
SEMANTICS_WITH_SET = (3, 4, 5, 6)
COMPONENT_BYTES = (1, 1, 2, 2, 4, 4)


class Reader:
    """Bincode with fixed-width little-endian integers."""

    def __init__(self, data, framed):
        self.data, self.at, self.framed = data, 0, framed

    def take(self, form):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values[0]

    def string(self):
        length = self.take("Q")
        assert self.at + length <= len(self.data)
        self.at += length
        return self.data[self.at - length : self.at].decode("utf-8")

    def many(self, what):
        return [what() for _ in range(self.take("Q"))]

    def record(self, what):
        """A value with its length in front; later versions may have more fields at its end."""
        if not self.framed:
            return what()
        length = self.take("Q")
        end = self.at + length
        assert end <= len(self.data)
        result = what()
        assert self.at <= end
        self.at = end
        return result

    def records(self, what):
        return self.many(lambda: self.record(what))

    def maybe(self, what):
        flag = self.take("B")
        assert flag in (0, 1)
        return what() if flag else None


def sections(data):
    magic, version, count, length, _checksum = struct.unpack_from("<8sIIQQ", data)
    assert magic == b"\x89LODC\r\n\x1a" and version in (1, 2, 3) and length == len(data)
    found, end = {"version": version}, 32 + 40 * count
    for i in range(count):
        tag, flags, obj, index, offset, size, _ = struct.unpack_from("<4sIIIQQQ", data, 32 + 40 * i)
        assert offset == (end + 15) // 16 * 16 and not any(data[end:offset])
        assert flags in (0, 1) or (version == 3 and flags & 0xFFFE == 0)
        end = offset + size
        assert end <= len(data)
        found[tag.decode(), obj, index] = data[offset:end]
    assert end == len(data)
    return found


def manifest(data, version):
    r = Reader(data, version >= 3)
    u32 = lambda: r.take("I")
    low = lambda: r.take("Q")

    def submesh():
        return {"name": r.string(), "material": r.maybe(r.string), "primitive": u32(),
                "triangles": u32(), "attributes": r.many(u32)}

    def attribute():
        semantic = u32()
        assert semantic <= 7
        which = u32() if semantic in SEMANTICS_WITH_SET else r.string() if semantic == 7 else None
        return {"semantic": semantic, "which": which, "morph": r.maybe(u32),
                "component": r.take("B"), "components": r.take("B"),
                "normalized": r.take("B"), "full": r.take("B")}

    def obj():
        return {"name": r.string(), "scale": r.take("d"), "mesh": u32(), "legal": u32(),
                "changes": u32(), "first_change": r.maybe(u32),
                "submeshes": r.records(submesh), "attributes": r.records(attribute),
                "models": r.records(lambda: (r.string(), r.many(r.string)))}

    result = {"format": ("obj", "gltf", "glb")[r.take("B")], "hash": low() | low() << 64}
    kind = u32()
    if kind == 0:
        result["libraries"] = r.many(r.string)
        result["materials"] = r.many(lambda: (r.string(), r.many(r.string)))
    else:
        assert kind == 1
    result["objects"] = r.records(obj)
    assert r.at == len(data) or version >= 3
    return result


def steps(found, number, triangles, records):
    bits = found["JOIN", number, 0]
    ends = [k + 1 for k in range(records) if not bits[k // 8] >> (k % 8) & 1]
    lost = found["STRI", number, 0]
    long = list(struct.unpack("<%dI" % ((len(lost) - len(ends)) // 4), lost[len(ends):]))
    after = []
    for byte in lost[: len(ends)]:
        triangles -= long.pop(0) if byte == 255 else byte
        after.append(triangles)
    assert not long and len(errors(found, "SERR", number)) == len(ends)
    return ends, after


def errors(found, tag, number):
    stored = found[tag, number, 0]
    if found["version"] == 1:
        return [e for (e,) in struct.iter_unpack("<f", stored)]
    bits, growth, shift, result = 0, 0, 0, []
    for byte in stored:
        growth |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            bits, growth, shift = bits + growth, 0, 0
            result.append(struct.unpack("<f", struct.pack("<I", bits))[0])
    assert shift == 0
    return result


def indices(found, tag, number, vertices):
    """Numbers of vertices, each in the bytes that the largest needs."""
    narrow = 1 + (vertices > 2**8) + (vertices > 2**16) + (vertices > 2**24)
    width = 4 if found["version"] == 1 else narrow
    stored = found[tag, number, 0]
    assert len(stored) % width == 0
    return [int.from_bytes(stored[i : i + width], "little") for i in range(0, len(stored), width)]


def object_line(found, number, o):
    vertices = len(found["POSI", number, 0]) // 12
    corners = indices(found, "TRIS", number, vertices)
    tris = list(zip(corners[::3], corners[1::3], corners[2::3]))
    assert 3 * len(tris) == len(corners)
    targets = indices(found, "TARG", number, vertices)
    assert len(targets) == max(vertices, 1) - 1
    assert all(k < t < vertices for k, t in enumerate(targets))
    assert all(v < vertices for t in tris for v in t)
    count = len(o["submeshes"])
    width = 1 if count <= 256 else 2 if count <= 65536 else 4
    if count > 1:
        raw = found["VSUB", number, 0]
        submesh = [int.from_bytes(raw[i : i + width], "little") for i in range(0, len(raw), width)]
    else:
        submesh = [0] * vertices
    assert len(submesh) == vertices and sum(s["triangles"] for s in o["submeshes"]) == len(tris)
    total = 0
    for i, a in enumerate(o["attributes"]):
        has = {s for s in range(count) if a["full"] or i in o["submeshes"][s]["attributes"]}
        stride = COMPONENT_BYTES[a["component"]] * a["components"]
        stored = found["ATTR", number, i]
        assert len(stored) == stride * sum(s in has or a["full"] == 1 for s in submesh)
        total += sum(stored)
    ends, after = steps(found, number, len(tris), len(targets))
    levels = [(0, len(tris)), *zip(ends, after)]
    half, left = next(((e, n) for e, n in levels if n <= len(tris) // 2), (0, 0))
    models = ",".join(name for name, _ in o["models"])
    measured = ""
    if ("SRMS", number, 0) in found:
        curves = [[0, *errors(found, tag, number)] for tag in ("SERR", "SRMS")]
        assert all(len(c) == len(ends) + 1 and c == sorted(c) for c in curves)
        error, rms = (struct.pack(">f", c[[0, *ends].index(half)]).hex() for c in curves)
        measured = f" error {error} rms {rms}"
    return (f"{o['name']} vertices {vertices} triangles {len(tris)} submeshes {count} "
            f"attributes {len(o['attributes'])} sum {total} records {len(targets)} "
            f"steps {len(ends)} half {half} {left} models {models}{measured}")


def main():
    for path in sorted(pathlib.Path(sys.argv[1]).glob("*.lodc")):
        found = sections(path.read_bytes())
        scene = manifest(found["MANI", SCENE, 0], found["version"])
        print(f"{path.name} {scene['format']} {scene['hash']:032x} objects {len(scene['objects'])}")
        for number, o in enumerate(scene["objects"]):
            print(path.name, object_line(found, number, o))


main()
