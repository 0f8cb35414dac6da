"""Models that the table of bars is measured on: `models.py FOLDER`."""
import json
import os
import struct
import sys
import zlib

import numpy as np

SMALL = 200


def wavy(rings, sides, seed, depth=0.3, stretch=1.0):
    """A sphere with waves on it, closed but for its seam: positions, normals, texture coordinates
    and triangles."""
    random = np.random.default_rng(seed)
    u, v = np.meshgrid(np.linspace(0, 1, sides + 1), np.linspace(0, 1, rings + 1))
    u, v = u.ravel(), v.ravel()
    around, down = 2 * np.pi * np.where(u == 1, 0, u), np.pi * v
    unit = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], 1)
    height = np.zeros(len(unit))
    for octave in range(7):
        for _ in range(3):
            way = random.normal(size=3) * 1.5 * 2**octave
            height += 0.5**octave / 3 * np.sin(unit @ way + random.uniform(0, 6))
    # Vertices of the seam and the poles share their bits.
    points = np.round(unit * (1 + depth * height)[:, None] * [1, 1, stretch], 6)
    row, column = (axis.ravel() for axis in np.mgrid[0:rings, 0:sides])
    a = row * (sides + 1) + column
    b = a + sides + 1
    faces = np.concatenate([np.stack([a, b, a + 1], 1), np.stack([a + 1, b, b + 1], 1)])
    return clean(points, smooth(points, faces), np.stack([u, v], 1), faces)


def scan():
    """A closed surface of 100,000 triangles: positions and triangles alone."""
    points, _, _, faces = wavy(200, 250, 2, 0.35)
    points, place = np.unique(points, axis=0, return_inverse=True)
    return points, None, None, place.ravel()[faces]


def turned(sides, seed):
    """A hollow shaft with two steps and hard edges, without texture coordinates."""
    random = np.random.default_rng(seed)
    a, b, c = random.uniform(0.2, 1.0, 3)
    p, q, r = np.cumsum(random.uniform(0.1, 0.6, 3))
    profile = [(0.1, 0), (a, 0), (a, p), (b, p), (b, q), (c, q), (c, r), (0.1, r), (0.1, 0)]
    angle = 2 * np.pi * (np.arange(sides + 1) % sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    points, normals, faces = [], [], []
    for number, ((inner, low), (outer, high)) in enumerate(zip(profile, profile[1:])):
        points += [ring * inner + [0, 0, low], ring * outer + [0, 0, high]]
        out = np.array([high - low, inner - outer]) / np.hypot(high - low, inner - outer)
        normals.append(np.tile(ring * out[0] + [0, 0, out[1]], (2, 1)))
        first = 2 * number * (sides + 1) + np.arange(sides)
        second = first + sides + 1
        faces += [
            np.stack([first, first + 1, second], 1),
            np.stack([first + 1, second + 1, second], 1),
        ]
    return clean(
        np.round(np.concatenate(points), 6), np.concatenate(normals), None, np.concatenate(faces)
    )


def clean(points, normals, coordinates, faces):
    """Without triangles that have no area, and without vertices that none uses."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]
    used, faces = np.unique(faces, return_inverse=True)
    of_used = (
        None if values is None else values[used] for values in (points, normals, coordinates)
    )
    return *of_used, faces.reshape(-1, 3)


def smooth(points, faces):
    """Normals that are the same where positions are."""
    place = np.unique(points, axis=0, return_inverse=True)[1].ravel()
    a, b, c = (points[faces[:, k]] for k in range(3))
    sums = np.zeros((place.max() + 1, 3))
    for k in range(3):
        np.add.at(sums, place[faces[:, k]], np.cross(b - a, c - a))
    return (sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12))[place]


def picture(size, seed):
    """A PNG of coloured noise."""
    coarse = np.random.default_rng(seed).integers(0, 256, (size // 8, size // 8, 3), np.uint8)
    rows = np.kron(coarse, np.ones((8, 8, 1), np.uint8)).reshape(size, -1)
    lines = b"".join(b"\0" + row.tobytes() for row in rows)
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines)),
        (b"IEND", b""),
    )
    packed = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def write_glb(path, meshes, image=None):
    """One node for each mesh; `image` is the texture of all."""
    data, views, accessors = bytearray(), [], []

    def view(content):
        data.extend(b"\0" * (-len(data) % 4))
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
        data.extend(content)
        return len(views) - 1

    def accessor(values, kind, code):
        entry = {
            "bufferView": view(values.tobytes()),
            "componentType": code,
            "count": len(values),
            "type": kind,
        }
        if kind == "VEC3":
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        accessors.append(entry)
        return len(accessors) - 1

    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "materials": [{"name": "all"}],
        "meshes": [],
        "nodes": [],
    }
    for number, (points, normals, coordinates, faces) in enumerate(meshes):
        attributes = {"POSITION": accessor(points.astype("<f4"), "VEC3", 5126)}
        if normals is not None:
            attributes["NORMAL"] = accessor(normals.astype("<f4"), "VEC3", 5126)
        if coordinates is not None:
            attributes["TEXCOORD_0"] = accessor(coordinates.astype("<f4"), "VEC2", 5126)
        indices = accessor(faces.astype("<u4").ravel(), "SCALAR", 5125)
        document["meshes"].append(
            {"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}
        )
        document["nodes"].append(
            {"mesh": number, "translation": [2.5 * (number % 8), 2.5 * (number // 8), 0]}
        )
    document["scenes"] = [{"nodes": list(range(len(meshes)))}]
    if image:
        document["images"] = [{"mimeType": "image/png", "bufferView": view(image)}]
        document["textures"] = [{"source": 0}]
        document["materials"][0]["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}}
    data.extend(b"\0" * (-len(data) % 4))
    document |= {
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(data), b"BIN\0") + data)


def write_obj(path, points, normals, coordinates, faces):
    with open(path, "w", encoding="ascii") as out:
        for word, rows in (("v", points), ("vt", coordinates), ("vn", normals)):
            out.writelines(f"{word} {' '.join(f'{x:.6g}' for x in row)}\n" for row in rows.tolist())
        corners = (faces + 1).tolist()
        out.writelines("f " + " ".join(f"{v}/{v}/{v}" for v in face) + "\n" for face in corners)


def write_all(folder):
    """A textured asset, a scan, a scene of 65 objects, and small assets of 5,000 triangles."""
    os.makedirs(os.path.join(folder, "small"), exist_ok=True)
    at = lambda name: os.path.join(folder, name)
    write_glb(at("textured.glb"), [wavy(48, 52, 1)], picture(512, 1))
    write_glb(at("scan.glb"), [scan()])
    share = np.random.default_rng(3).lognormal(0, 1.2, 65)
    parts = (share / share.sum() * 140_000).astype(int)
    round_one = lambda n, seed: wavy(
        max(6, int((n / 2) ** 0.5)), max(6, int((n / 2) ** 0.5)), seed, 0.1
    )
    solids = [turned(max(8, n // 16), i) if i % 3 else round_one(n, i) for i, n in enumerate(parts)]
    write_glb(at("scene.glb"), solids)
    for number in range(SMALL):
        model = wavy(48, 52, 100 + number, 0.2 + number % 3 / 10, 1 + number % 4 / 2)
        name = at(f"small/{number:03}")
        if number % 2:
            write_glb(name + ".glb", [model])
        else:
            write_obj(name + ".obj", *model)


if __name__ == "__main__":
    write_all(sys.argv[1])
