#!/usr/bin/env python3
"""Levels in motion: generates faces, props and rigs, and compares errors of levels with bars.

    motion.py LODC [--before LODC] [--seed N] [--only NAME,...] [--csv FILE] [--keep FOLDER]

Morphing: the error over the default weights and every target, beside the largest that the same
program states of any of these shapes as a static mesh. Rigs: the error over poses, and at rest,
beside those that another version (--before) states. Prints a line for each model and level; ends
with 1 if a bar is missed.
"""

import argparse
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

RATIOS = (0.5, 0.25, 0.1)
# At most these times the error of the worst static shape, by ratio; and the mean over models, at
# 50 and 25 %.
MORPH_BARS = {0.5: 1.5, 0.25: 1.5, 0.1: 2.5}
MORPH_MEAN = 1.2
# At most these times the error over poses of the version before: the worst, and the mean; the mean
# at rest.
RIG_BAR, RIG_MEAN, REST_MEAN = 1.25, 0.9, 1.1


class Model:
    """Positions, triangles, targets (a list of deltas each), joints and an animation of them."""

    def __init__(
        self, positions, triangles, targets=(), weights=None, normals=False, sparse=False, skin=None
    ):
        self.positions, self.triangles = positions, triangles
        self.targets, self.weights = [list(t) for t in targets], weights
        self.normals, self.sparse, self.skin = normals, sparse, skin

    def shape(self, target=None):
        """The positions with the default weights, and one target at 1."""
        weights = list(self.weights or [0.0] * len(self.targets))
        if target is not None:
            weights[target] = 1.0
        positions = [list(p) for p in self.positions]
        for weight, deltas in zip(weights, self.targets):
            if weight:
                for p, d in zip(positions, deltas):
                    for k in range(3):
                        p[k] += weight * d[k]
        return positions

    def static(self, target=None):
        return Model(self.shape(target), self.triangles, normals=self.normals)


def sub(a, b):
    return [a[k] - b[k] for k in range(3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalized(a):
    length = math.sqrt(sum(x * x for x in a)) or 1.0
    return [x / length for x in a]


def vertex_normals(positions, triangles):
    normals = [[0.0] * 3 for _ in positions]
    for t in triangles:
        n = cross(sub(positions[t[1]], positions[t[0]]), sub(positions[t[2]], positions[t[0]]))
        for v in t:
            for k in range(3):
                normals[v][k] += n[k]
    return [normalized(n) for n in normals]


class Glb:
    """Puts a glTF document and its one buffer together."""

    def __init__(self):
        self.bin, self.views, self.accessors = bytearray(), [], []

    def view(self, data):
        self.bin += b"\0" * (-len(self.bin) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data)})
        self.bin += data
        return len(self.views) - 1

    def floats(self, rows, kind, minmax=False):
        data = struct.pack(f"<{sum(map(len, rows))}f", *(x for row in rows for x in row))
        accessor = {
            "bufferView": self.view(data),
            "componentType": 5126,
            "count": len(rows),
            "type": kind,
        }
        if minmax:
            single = [[struct.unpack("<f", struct.pack("<f", x))[0] for x in row] for row in rows]
            accessor["min"] = [min(c) for c in zip(*single)]
            accessor["max"] = [max(c) for c in zip(*single)]
        return self.add(accessor)

    def sparse(self, rows):
        used = [i for i, row in enumerate(rows) if any(row)] or [0]
        indices = self.view(struct.pack(f"<{len(used)}I", *used))
        values = self.view(struct.pack(f"<{3 * len(used)}f", *(x for i in used for x in rows[i])))
        low, high = ([f(c) for c in zip(*rows)] for f in (min, max))
        return self.add(
            {
                "componentType": 5126,
                "count": len(rows),
                "type": "VEC3",
                "min": low,
                "max": high,
                "sparse": {
                    "count": len(used),
                    "indices": {"bufferView": indices, "componentType": 5125},
                    "values": {"bufferView": values},
                },
            }
        )

    def integers(self, rows, kind, component, letter):
        flat = [x for row in rows for x in row]
        data = struct.pack(f"<{len(flat)}{letter}", *flat)
        return self.add(
            {
                "bufferView": self.view(data),
                "componentType": component,
                "count": len(rows),
                "type": kind,
            }
        )

    def add(self, accessor):
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def bytes(self, document):
        self.bin += b"\0" * (-len(self.bin) % 4)
        document |= {
            "asset": {"version": "2.0"},
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.bin)}],
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.bin)
        return (
            struct.pack("<4sII", b"glTF", 2, length)
            + struct.pack("<I4s", len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(self.bin), b"BIN\0")
            + bytes(self.bin)
        )


def write(model, path):
    glb = Glb()
    primitive = {
        "attributes": {"POSITION": glb.floats(model.positions, "VEC3", True)},
        "indices": glb.integers([[i] for t in model.triangles for i in t], "SCALAR", 5125, "I"),
    }
    rest_normals = vertex_normals(model.positions, model.triangles) if model.normals else None
    if model.normals:
        primitive["attributes"]["NORMAL"] = glb.floats(rest_normals, "VEC3")
    targets = []
    for deltas in model.targets:
        target = {
            "POSITION": glb.sparse(deltas) if model.sparse else glb.floats(deltas, "VEC3", True)
        }
        if model.normals:
            moved = [[p[k] + d[k] for k in range(3)] for p, d in zip(model.positions, deltas)]
            moved = vertex_normals(moved, model.triangles)
            target["NORMAL"] = glb.floats([sub(m, n) for m, n in zip(moved, rest_normals)], "VEC3")
        targets.append(target)
    if targets:
        primitive["targets"] = targets
    mesh = {"primitives": [primitive]}
    if model.weights:
        mesh["weights"] = model.weights
    document = {"meshes": [mesh], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}
    if model.skin:
        add_skin(glb, model, primitive, document)
    path.write_bytes(glb.bytes(document))
    return path


def add_skin(glb, model, primitive, document):
    """A skin: joints [(parent, position)], weights of each vertex, rotations of joints."""
    joints, weights, keys = model.skin
    rows = [(sorted(w.items(), key=lambda x: -x[1]) + [(0, 0.0)] * 4)[:4] for w in weights]
    rows = [[(j, w / sum(x for _, x in row)) for j, w in row] for row in rows]
    primitive["attributes"]["JOINTS_0"] = glb.integers(
        [[j for j, _ in row] for row in rows], "VEC4", 5121, "B"
    )
    primitive["attributes"]["WEIGHTS_0"] = glb.floats([[w for _, w in row] for row in rows], "VEC4")
    nodes = document["nodes"]
    for parent, position in joints:
        local = sub(position, joints[parent][1]) if parent is not None else list(position)
        nodes.append({"translation": local})
    for j, (parent, _) in enumerate(joints):
        if parent is not None:
            nodes[1 + parent].setdefault("children", []).append(1 + j)
    inverse = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -p[0], -p[1], -p[2], 1] for _, p in joints]
    document["skins"] = [
        {
            "joints": list(range(1, 1 + len(joints))),
            "inverseBindMatrices": glb.floats(inverse, "MAT4"),
        }
    ]
    nodes[0]["skin"] = 0
    document["scenes"][0]["nodes"] = [0, 1]
    samplers, channels = [], []
    for joint, axis, angles in keys:
        times = glb.floats([[0.5 * i] for i in range(len(angles))], "SCALAR", True)
        turns = [[math.sin(a / 2) * x for x in axis] + [math.cos(a / 2)] for a in angles]
        samplers.append({"input": times, "output": glb.floats(turns, "VEC4")})
        channels.append(
            {"sampler": len(samplers) - 1, "target": {"node": 1 + joint, "path": "rotation"}}
        )
    if samplers:
        document["animations"] = [{"samplers": samplers, "channels": channels}]


def grid(columns, rows, at, closed=False):
    """A grid of quads over u, v from 0 to 1; closed: the last column is the first."""
    width = columns if closed else columns + 1
    positions = [at(i / columns, j / rows) for j in range(rows + 1) for i in range(width)]
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a, b = j * width + i, j * width + (i + 1) % width
            c, d = a + width, b + width
            triangles += [[a, b, d], [a, d, c]] if (i + j) % 2 else [[a, b, c], [b, d, c]]
    return positions, triangles


def bump(p, center, radius):
    d2 = sum((p[k] - center[k]) ** 2 for k in range(3)) / radius**2
    return math.exp(-d2) if d2 < 9 else 0.0


def head(rng, n=44):
    """A face: an ellipsoid with a nose, eye sockets, brows, lips and some unevenness."""
    noise = [
        (
            [rng.uniform(-1, 1), rng.uniform(-1.2, 1.2), rng.uniform(0.2, 1)],
            rng.uniform(0.1, 0.3),
            rng.uniform(-0.03, 0.03),
        )
        for _ in range(30)
    ]
    features = [
        ([0, 0, 1.0], 0.18, 0.22),
        ([0, 0.2, 1], 0.12, 0.1),
        ([-0.35, 0.3, 0.85], 0.17, -0.1),
        ([0.35, 0.3, 0.85], 0.17, -0.1),
        ([-0.35, 0.5, 0.8], 0.15, 0.07),
        ([0.35, 0.5, 0.8], 0.15, 0.07),
        ([0, -0.42, 0.95], 0.14, 0.06),
        ([0, -0.56, 0.9], 0.13, 0.07),
        ([0, -0.95, 0.75], 0.25, 0.08),
    ] + noise

    def at(u, v):
        theta, phi = (u - 0.5) * math.pi * 1.1, (v - 0.5) * math.pi * 0.9
        p = [math.sin(theta) * math.cos(phi), 1.25 * math.sin(phi), math.cos(theta) * math.cos(phi)]
        n = normalized([p[0], p[1] / 1.56, p[2]])
        height = sum(h * bump(p, c, r) for c, r, h in features)
        return [p[k] + height * n[k] for k in range(3)]

    return grid(n, n, at)


def expression(positions, center, radius, direction):
    return [[bump(p, center, radius) * x for x in direction] for p in positions]


def clipped(deltas, least=1e-4):
    return [d if max(map(abs, d)) > least else [0.0, 0.0, 0.0] for d in deltas]


def random_targets(rng, positions, count, radius, strength):
    targets = []
    for _ in range(count):
        center = positions[rng.randrange(len(positions))]
        out = normalized(center)
        direction = [
            s * rng.uniform(0.4, 1) * (0.7 * o + 0.3 * rng.uniform(-1, 1))
            for s, o in zip([rng.choice((-1, 1)) * strength] * 3, out)
        ]
        targets.append(clipped(expression(positions, center, rng.uniform(*radius), direction)))
    return targets


# Of common blend shape sets: where, how wide and which way; mirrored if off the middle.
EXPRESSIONS = [
    ([0.35, 0.5, 0.8], 0.16, [0, 0.12, 0.05]),
    ([0.15, 0.5, 0.9], 0.14, [-0.03, -0.08, 0.02]),
    ([0.5, 0.45, 0.7], 0.15, [0, 0.1, 0.03]),
    ([0.35, 0.35, 0.85], 0.12, [0, -0.13, 0.06]),
    ([0.35, 0.25, 0.85], 0.13, [0, 0.05, 0.03]),
    ([0.35, 0.3, 0.85], 0.15, [0, 0.04, -0.03]),
    ([0.5, -0.1, 0.75], 0.22, [0.02, 0.08, 0.08]),
    ([0.55, -0.3, 0.7], 0.25, [0.12, 0, 0.1]),
    ([0.12, 0.02, 1], 0.12, [0.01, 0.06, 0.03]),
    ([0.28, -0.45, 0.85], 0.14, [0.1, 0.08, -0.03]),
    ([0.28, -0.5, 0.85], 0.14, [0.03, -0.1, 0]),
    ([0.28, -0.48, 0.85], 0.13, [-0.09, 0, 0.05]),
    ([0.3, -0.5, 0.85], 0.16, [0.12, -0.02, -0.04]),
    ([0.12, -0.42, 0.95], 0.12, [0, 0.08, 0.03]),
    ([0.12, -0.58, 0.9], 0.12, [0, -0.1, 0.02]),
    ([0.2, -0.5, 0.9], 0.14, [0, 0.03, 0.07]),
    ([0.2, -0.5, 0.9], 0.15, [-0.02, 0, -0.08]),
    ([0, -0.9, 0.7], 0.45, [0, -0.25, -0.05]),
    ([0, -0.9, 0.7], 0.45, [0.15, 0, 0]),
    ([0, -0.9, 0.7], 0.45, [0, 0, 0.15]),
    ([0, -0.42, 0.95], 0.16, [0, 0.02, 0.1]),
    ([0, -0.57, 0.9], 0.16, [0, 0.02, 0.1]),
    ([0, -0.5, 0.95], 0.22, [0, 0, 0.14]),
    ([0, -0.5, 0.95], 0.2, [0.1, 0, 0]),
    ([0, -0.42, 0.95], 0.15, [0, -0.05, -0.06]),
    ([0, -0.57, 0.9], 0.15, [0, 0.06, -0.06]),
    ([0, 0.55, 0.9], 0.3, [0, 0.1, 0.03]),
    ([0, -0.5, 0.95], 0.25, [0, -0.06, 0.08]),
]


def named_targets(rng, positions):
    targets = []
    for center, radius, direction in EXPRESSIONS:
        for side in (1, -1) if center[0] else (1,):
            c = [side * center[0], center[1], center[2]]
            d = [side * direction[0] * rng.uniform(0.8, 1.2), direction[1], direction[2]]
            targets.append(clipped(expression(positions, c, radius, d)))
    return targets


def tube(rng, columns, rows, radius=0.25, length=4.0):
    wobble = [(rng.uniform(0.5, 4), rng.uniform(0, 6), rng.uniform(0.02, 0.05)) for _ in range(6)]

    def at(u, v):
        a, z = 2 * math.pi * u, length * (v - 0.5)
        r = radius * (
            1 + sum(h * math.sin(f * z * 3 + p + (i % 3) * a) for i, (f, p, h) in enumerate(wobble))
        )
        return [r * math.cos(a), z, r * math.sin(a)]

    return grid(columns, rows, at, closed=True)


def chain_skin(positions, joints, axis_ranges, rng, soft):
    """Joints along y, each vertex led by the two nearest; keys turn every joint to and fro."""
    ys = [y for _, (_, y, _) in joints]
    weights = []
    for p in positions:
        w = {j: math.exp(-(((p[1] - (y + soft)) / soft) ** 2)) for j, y in enumerate(ys)}
        best = sorted(w, key=w.get, reverse=True)[:3]
        weights.append({j: w[j] + 1e-9 for j in best})
    keys = [(j, axis, [0.0] + [rng.uniform(-a, a) for _ in range(6)]) for j, axis, a in axis_ranges]
    return joints, weights, keys


def limbs(rng, count, columns=14, rows=30):
    """A body with limbs around it, each a chain of three joints."""
    body, triangles = grid(
        24,
        16,
        lambda u, v: [
            0.5 * math.cos(2 * math.pi * u) * math.sin(math.pi * max(0.02, min(0.98, v))),
            0.35 * math.cos(math.pi * v),
            0.5 * math.sin(2 * math.pi * u) * math.sin(math.pi * max(0.02, min(0.98, v))),
        ],
        True,
    )
    positions, joints, weights, keys = list(body), [(None, [0, 0, 0])], [{0: 1.0} for _ in body], []
    for limb in range(count):
        angle = 2 * math.pi * limb / count + rng.uniform(-0.1, 0.1)
        out = [math.cos(angle), 0, math.sin(angle)]
        side = [-out[2], 0, out[0]]
        length, radius = rng.uniform(1.2, 2), rng.uniform(0.08, 0.14)

        def at(u, v):
            a, r = 2 * math.pi * u, radius * (1.2 - 0.7 * v) * (1 + 0.15 * math.sin(9 * v + limb))
            along, up, across = (
                0.4 + length * v,
                r * math.sin(a) + 0.25 * math.sin(3 * v),
                r * math.cos(a),
            )
            return [along * out[k] + across * side[k] + (up if k == 1 else 0) for k in range(3)]

        own, faces = grid(columns, rows, at, True)
        base, first = len(positions), len(joints)
        for i in range(3):
            parent = 0 if i == 0 else first + i - 1
            joints.append((parent, [(0.4 + length * i / 3) * out[k] for k in range(3)]))
            keys.append((first + i, side, [0.0] + [rng.uniform(-0.9, 0.9) for _ in range(5)]))
        for p in own:
            v = (p[0] * out[0] + p[2] * out[2] - 0.4) / length
            w = {first + i: math.exp(-(((v - (i + 0.5) / 3) / 0.2) ** 2)) + 1e-9 for i in range(3)}
            weights.append(w)
        positions += own
        triangles += [[base + i for i in t] for t in faces]
    return Model(positions, triangles, skin=(joints, weights, keys))


def tube_rig(rng, joint_count, reach, soft, columns=24, rows=80):
    positions, triangles = tube(rng, columns, rows)
    joints = [
        (None if i == 0 else i - 1, [0, -2 + 4 * i / joint_count, 0]) for i in range(joint_count)
    ]
    ranges = [(j, axis, reach) for j in range(1, joint_count) for axis in ([0, 0, 1],)]
    return Model(positions, triangles, skin=chain_skin(positions, joints, ranges, rng, soft))


def face(rng, targets, **options):
    positions, triangles = head(rng, options.pop("n", 44))
    return Model(positions, triangles, targets(positions), **options)


def mouth(rng):
    """Lips that touch at rest: vertices along a slit are there twice, and the lower ones open."""
    positions, triangles = head(rng, 40)
    width, row = 41, 13
    twins = {}
    for i in range(12, 29):
        v = row * width + i
        if 12 < i < 28:
            twins[v] = len(positions)
            positions.append(list(positions[v]))
    below = lambda t: all(v // width <= row for v in t)
    triangles = [[twins.get(v, v) for v in t] if below(t) else t for t in triangles]
    lower = set(twins.values())
    y = positions[row * width + 20][1]
    is_low = lambda i, p: i in lower or (i < width * row)
    jaw = [
        (
            [0, -0.3 * bump(p, [0, y, 0.9], 0.5), -0.05 * bump(p, [0, y, 0.9], 0.5)]
            if is_low(i, p)
            else [0.0] * 3
        )
        for i, p in enumerate(positions)
    ]
    smile = expression(positions, [0.3, y, 0.85], 0.2, [0.1, 0.06, 0])
    return Model(positions, triangles, [clipped(jaw), clipped(smile)])


def unfolded(rng):
    """A prop that its default weights unfold: at weight 0 most of it is one point."""
    positions, triangles = grid(
        20, 20, lambda u, v: [u - 0.5, v - 0.5, 0.15 * math.sin(5 * u) * math.cos(4 * v + 1)]
    )
    folded = [p if p[1] < -0.2 else [0.0, 0.2, 0.0] for p in positions]
    return Model(folded, triangles, [[sub(p, f) for p, f in zip(positions, folded)]], weights=[1.0])


def flag(rng):
    positions, triangles = grid(60, 36, lambda u, v: [2 * u, v, 0.02 * math.sin(20 * u)])
    waves = []
    for _ in range(8):
        f, g, phase, h = (
            rng.uniform(2, 7),
            rng.uniform(-3, 3),
            rng.uniform(0, 6),
            rng.uniform(0.08, 0.2),
        )
        waves.append(
            [[0, 0, h * p[0] / 2 * math.sin(f * p[0] + g * p[1] + phase)] for p in positions]
        )
    return Model(positions, triangles, waves)


def balloon(rng):
    positions, triangles = tube(rng, 36, 60, 0.8, 2.4)
    grow = [
        [0.6 * p[0] * bump(p, [0, 0, 0], 1.4), 0, 0.6 * p[2] * bump(p, [0, 0, 0], 1.4)]
        for p in positions
    ]
    twist = []
    for p in positions:
        a = 0.7 * p[1]
        twist.append(
            [
                p[0] * math.cos(a) - p[2] * math.sin(a) - p[0],
                0,
                p[0] * math.sin(a) + p[2] * math.cos(a) - p[2],
            ]
        )
    bend = [[0.25 * p[1] ** 2, 0, 0] for p in positions]
    return Model(positions, triangles, [grow, twist, bend])


def lid(rng):
    """A box of bevelled panels; targets push panels out."""
    positions, triangles = grid(
        48,
        32,
        lambda u, v: [
            3 * (u - 0.5),
            2 * (v - 0.5),
            0.1 * max(-1, min(1, 6 * math.sin(18 * u))) * max(-1, min(1, 6 * math.sin(12 * v))),
        ],
    )
    targets = [
        [[0, 0, 0.3 if abs(p[0] - c) < 0.45 and abs(p[1]) < 0.7 else 0.0] for p in positions]
        for c in (-1.0, 0.0, 1.0)
    ]
    return Model(positions, triangles, targets)


def skinned_face(rng):
    model = face(rng, lambda p: named_targets(rng, p)[:16])
    joints = [(None, [0, -1, 0]), (0, [0, -0.2, 0.2])]
    weights = [
        {0: 1.0, 1: max(0.0, min(1.0, (-0.35 - p[1]) * 4)) if p[2] > 0.3 else 0.0}
        for p in model.positions
    ]
    weights = [{0: 1 - w[1], 1: w[1] + 1e-9} for w in weights]
    model.skin = (joints, weights, [(1, [1, 0, 0], [0.0, 0.35, 0.1, 0.3])])
    return model


def body(rng):
    """A body with targets that change all of it."""
    positions, triangles = tube(rng, 40, 70, 0.6, 4)
    targets = []
    for _ in range(10):
        f, phase, h = rng.uniform(0.5, 2.5), rng.uniform(0, 6), rng.uniform(0.1, 0.3)
        targets.append(
            [
                [h * p[0] * math.sin(f * p[1] + phase), 0, h * p[2] * math.sin(f * p[1] + phase)]
                for p in positions
            ]
        )
    return Model(positions, triangles, targets)


MORPHING = {
    "brow": lambda r: face(r, lambda p: named_targets(r, p)[:4]),
    "face24": lambda r: face(r, lambda p: random_targets(r, p, 24, (0.1, 0.3), 0.15)),
    "face48": lambda r: face(r, lambda p: named_targets(r, p)),
    "face70": lambda r: face(r, lambda p: random_targets(r, p, 70, (0.08, 0.25), 0.12)),
    "mouth": mouth,
    "sparse": lambda r: face(r, lambda p: named_targets(r, p)[8:24], sparse=True),
    "normals": lambda r: face(r, lambda p: named_targets(r, p)[:12], normals=True),
    "unfolded": unfolded,
    "flag": flag,
    "balloon": balloon,
    "lid": lid,
    "body": body,
    "skinned": skinned_face,
}
RIGS = {
    "arm": lambda r: tube_rig(r, 5, 0.7, 0.6),
    "tail": lambda r: tube_rig(r, 12, 0.45, 0.3),
    "hinge": lambda r: tube_rig(r, 4, 1.2, 0.15),
    "spider": lambda r: limbs(r, 8),
    "dog": lambda r: limbs(r, 4, 18, 40),
}


def extract(program, path, ratio, poses):
    """The error that a level states, in mesh units."""
    command = [
        program,
        "extract",
        "--no-refit",
        str(path),
        "--ratio",
        str(ratio),
        "--poses",
        str(poses),
        "--json",
        "-q",
        "-o",
        str(path.with_suffix(".out.glb")),
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    level = json.loads(done.stdout)
    level = level["outputs"][0] if "outputs" in level else level
    return level["error"], level["triangles"]


def morphing(program, name, model, folder, rows):
    path = write(model, folder / f"{name}.glb")
    shapes = [None] + list(range(len(model.targets)))
    statics = (
        [write(model.static(s), folder / f"{name}.{s}.glb") for s in shapes]
        if not model.skin
        else None
    )
    factors = {}
    for ratio in RATIOS:
        error, triangles = extract(program, path, ratio, 64)
        worst = max(extract(program, p, ratio, 0)[0] for p in statics) if statics else None
        factor = error / worst if worst else float("nan")
        factors[ratio] = factor
        rows.append((name, ratio, triangles, error, worst, factor))
        shown = f"{worst:9.5f} {factor:6.2f}" if worst else ""
        print(f"{name:10} {100 * ratio:3.0f} % {triangles:6} {error:9.5f} {shown}", flush=True)
    return factors


def rig(program, before, name, model, folder, rows):
    path = write(model, folder / f"{name}.glb")
    factors = {}
    for ratio in RATIOS:
        error, triangles = extract(program, path, ratio, 8)
        rest = rest_error(program, path, ratio)
        line = f"{name:10} {100 * ratio:3.0f} % {triangles:6} {error:9.5f} rest {rest:9.5f}"
        if before:
            old, old_rest = extract(before, path, ratio, 8)[0], rest_error(before, path, ratio)
            factors[ratio] = (error / old, rest / old_rest)
            line += f"  before {old:9.5f} {error / old:5.2f}"
            line += f"  rest {old_rest:9.5f} {rest / old_rest:5.2f}"
            rows.append((name, ratio, triangles, error, old, error / old))
        print(line, flush=True)
    return factors


def rest_error(program, path, ratio):
    """What the level for all poses is off at rest: its distance by `compare`."""
    level = path.with_suffix(".out.glb")
    extract(program, path, ratio, 8)
    done = subprocess.run(
        [program, "compare", str(path), str(level), "--json", "-q"], capture_output=True, text=True
    )
    report = json.loads(done.stdout)
    return report["hausdorff"]["max"]


def mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else float("nan")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("program")
    parser.add_argument("--before")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--csv")
    parser.add_argument("--keep")
    args = parser.parse_args()
    only = set(filter(None, args.only.split(",")))
    missed, rows = [], []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(args.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        wanted = lambda names: {n: m for n, m in names.items() if not only or n in only}
        make = lambda name, model: model(random.Random(f"{name} {args.seed}"))
        found = {
            name: morphing(args.program, name, make(name, m), folder, rows)
            for name, m in wanted(MORPHING).items()
        }
        for ratio, bar in MORPH_BARS.items():
            factors = {n: f[ratio] for n, f in found.items() if f[ratio] == f[ratio]}
            if not factors:
                continue
            average = mean(factors.values())
            print(
                f"morphing at {100 * ratio:.0f} %: mean {average:.2f}, "
                f"worst {max(factors.values()):.2f}"
            )
            missed += [f"{n} at {ratio}: {f:.2f}" for n, f in factors.items() if f > bar]
            missed += (
                [f"mean at {ratio}: {average:.2f}"] if ratio > 0.2 and average > MORPH_MEAN else []
            )
        found = {
            n: rig(args.program, args.before, n, make(n, m), folder, rows)
            for n, m in wanted(RIGS).items()
        }
        pairs = [f for factors in found.values() for f in factors.values()]
        if pairs:
            average, rest = mean(p[0] for p in pairs), mean(p[1] for p in pairs)
            worst = max(p[0] for p in pairs)
            print(f"rigs: mean {average:.2f}, worst {worst:.2f}; at rest {rest:.2f}")
            missed += [f"rigs: mean {average:.2f}"] if average > RIG_MEAN else []
            missed += [f"rigs: worst {worst:.2f}"] if worst > RIG_BAR else []
            missed += [f"rigs at rest: mean {rest:.2f}"] if rest > REST_MEAN else []
    if args.csv:
        command = f"# `just motion --seed {args.seed}`; "
        command += "beside: the worst static shape, or the version before (rigs)"
        shown = lambda number, text: "" if number is None else text
        lines = [command, "model,ratio,triangles,error,beside,factor"] + [
            f"{n},{r},{t},{e:.6g},{shown(w, w and f'{w:.6g}')},{shown(w, f'{f:.3f}')}"
            for n, r, t, e, w, f in rows
        ]
        Path(args.csv).write_text("\n".join(lines) + "\n")
    for bar in missed:
        print("missed:", bar)
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
