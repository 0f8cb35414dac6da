"""Kinds of meshes: functions of a seeded generator and of about how many triangles are wanted."""

import numpy as np

from shapes import (
    BOX, QUAD, TAU, apart, copies, directions, globe, grid, join, lumpy, noise, prism, sheet, side,
    sphere, square, surface_net, tube, turns, upright, welded,
)  # fmt: skip

KINDS = {}


def kind(make):
    KINDS[make.__name__] = make
    return make


def at_least(count, least=1):
    return max(least, round(count))


# One surface


@kind
def closed_scan(rng, n):
    return lumpy(rng, n)


@kind
def noisy_scan(rng, n):
    positions, triangles = lumpy(rng, n, 0.15)
    return positions + rng.normal(size=positions.shape) * 0.3 / n**0.5, triangles


@kind
def photogrammetry(rng, n):
    positions, triangles = lumpy(rng, 0.85 * n, 0.15)
    middle = positions[triangles].mean(1)
    for _ in range(12):
        hole = middle[rng.integers(len(middle))]
        keep = np.linalg.norm(middle - hole, axis=1) > rng.uniform(0.02, 0.12)
        triangles, middle = triangles[keep], middle[keep]
    some = at_least(n / 200)
    places = rng.normal(size=(some, 3)) * 0.9
    return join(
        (positions, triangles), copies(sphere(20), places, 10 ** rng.uniform(-3, -1.3, some))
    )


@kind
def bust(rng, n):
    positions, triangles = lumpy(rng, n, 0.25, 6)
    narrow = 1 - 0.6 * np.exp(-((positions[:, 2:] + 0.3) ** 2) / 0.05)
    return positions * np.concatenate([narrow, narrow, 0 * narrow + 1.6], 1), triangles


@kind
def terrain(rng, n):
    return sheet(side(n), lambda p: 0.2 * noise(p * 2, rng, 7))


@kind
def terrain_skirt(rng, n):
    m = side(0.95 * n)
    positions, triangles = sheet(m, lambda p: 0.15 * noise(p * 2, rng, 6))
    around = np.arange(m * m).reshape(m, m)
    edge = np.concatenate([around[:-1, 0], around[-1, :-1], around[:0:-1, -1], around[0, :0:-1]])
    k, c = len(positions), np.arange(len(edge))
    d = (c + 1) % len(c)
    low = positions[edge] - [0, 0, 0.3]
    skirt = [np.stack([edge, k + c, k + d], 1), np.stack([edge, k + d, edge[d]], 1)]
    return np.concatenate([positions, low]), np.concatenate([triangles, *skirt])


@kind
def terraces(rng, n):
    def height(p):
        return np.floor(8 * noise(p * 2, rng, 3)) * 0.04

    return sheet(side(n), height)


@kind
def cliffs(rng, n):
    return sheet(side(n), lambda p: 0.4 * (noise(p * 2, rng, 3) > 0) + 0.01 * noise(p * 9, rng, 3))


@kind
def cloth(rng, n):
    m = side(n)
    flat = square(m)
    fold = 0.08 * np.sin(14 * flat[:, 0] + 3 * noise(flat * 2, rng, 2))
    return np.column_stack([0.6 * flat[:, 0] + fold, fold, flat[:, 1]]), grid(m, m)


@kind
def moebius(rng, n):
    parts, some = [], 5
    for _ in range(some):
        w = 5
        m = at_least(n / some / (2 * (w - 1)), 8)
        u = (np.arange(m) * TAU / m)[:, None]
        v = np.linspace(-0.3, 0.3, w)[None]
        wide = 1 + v * np.cos(u / 2)
        body = np.stack([wide * np.cos(u), wide * np.sin(u), v * np.sin(u / 2)], -1).reshape(-1, 3)
        a = (m - 1) * w + np.arange(w - 1)
        b = w - 1 - np.arange(w - 1)
        seam = [np.stack([a, b, b - 1], 1), np.stack([a, b - 1, a + 1], 1)]
        band = (body, np.concatenate([grid(m, w), *seam]))
        parts.append(copies(band, rng.uniform(-3, 3, (1, 3)), turns(rng, 1)))
    return join(*parts)


@kind
def klein_bottle(rng, n):
    m = side(n, 8)
    u, v = np.meshgrid(np.arange(m) * TAU / m, np.arange(m) * TAU / m, indexing="ij")
    r = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    points = np.stack([r * np.cos(u), r * np.sin(u), z], -1).reshape(-1, 3)
    return welded((points, grid(m, m, False, True)), 6)


def field(rng, n, value, reach=1.3):
    m = max(8, round((n / 8) ** 0.5 * 1.2))
    x = np.linspace(-reach, reach, m)
    points = np.stack(np.meshgrid(x, x, x, indexing="ij"), -1).reshape(-1, 3)
    return surface_net(value(points).reshape(m, m, m), 2 * reach / (m - 1))


@kind
def marching_cubes(rng, n):
    shape = lambda p: 1 - np.linalg.norm(p, axis=1) + 0.15 * noise(p, rng, 3)
    return field(rng, n, lambda p: np.floor(shape(p) * 30) / 30 + 0.01 * rng.normal(size=len(p)))


@kind
def gyroid(rng, n):
    waves = lambda p: sum(np.sin(4 * p[:, k]) * np.cos(4 * p[:, (k + 1) % 3]) for k in range(3))
    return field(rng, n / 6, lambda p: 0.4 - abs(waves(p)))


@kind
def voxels(rng, n):
    m = max(6, round((n / 9) ** 0.5))
    height = m * (0.4 + 0.3 * noise(square(m), rng, 3)).reshape(m, m)
    full = np.zeros((m + 2,) * 3, bool)
    full[1:-1, 1:-1, 1:-1] = np.arange(m)[None, None] < height[..., None]
    quads = []
    for axis in range(3):
        for up in (0, 1):
            open_side = full & ~np.roll(full, -1 if up else 1, axis)
            low = np.argwhere(open_side).astype(float)
            low[:, axis] += up
            e, f = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            ring = [low, low + e, low + e + f, low + f]
            quads.append(np.stack(ring if up else ring[::-1], 1))
    quads = np.concatenate(quads)
    k = 4 * np.arange(len(quads))[:, None]
    return quads.reshape(-1, 3), np.concatenate([k + [0, 1, 2], k + [0, 2, 3]])


@kind
def knot(rng, n):
    sides = 12
    m = at_least(n / (2 * sides), 16)
    t = np.arange(m) * TAU / m
    r = 2 + np.cos(3 * t)
    return tube(
        np.stack([r * np.cos(2 * t), r * np.sin(2 * t), np.sin(3 * t)], 1), 0.35, sides, True
    )


@kind
def crossing_tori(rng, n):
    parts = []
    for _ in range(4):
        m = at_least((n / 8) ** 0.5, 6)
        t = np.arange(m) * TAU / m
        ring = tube(np.stack([np.cos(t), np.sin(t), 0 * t], 1), rng.uniform(0.3, 1.2), m, True)
        parts.append(copies(ring, rng.uniform(-0.4, 0.4, (1, 3)), turns(rng, 1)))
    return join(*parts)


@kind
def spiral(rng, n):
    m = at_least(n / 8, 20)
    t = np.linspace(0, 10 * TAU, m)[:, None]
    r = np.linspace(0.2, 1, 5)[None]
    body = np.stack([r * np.cos(t), r * np.sin(t), 0.05 * t + 0 * r], -1)
    return body.reshape(-1, 3), grid(m, 5)


@kind
def ribbons(rng, n):
    parts = []
    for _ in range(6):
        m = at_least(n / 24, 8)
        t = np.linspace(0, 1, m)
        path = np.stack([noise(t[:, None] * 3, rng, 3) for _ in range(3)], 1) * 2
        wide = 0.05 * np.stack([np.cos(9 * t), np.sin(9 * t), 0 * t + 0.3], 1)
        parts.append((np.stack([path - wide, path, path + wide], 1).reshape(-1, 3), grid(m, 3)))
    return join(*parts)


@kind
def sea_shell(rng, n):
    m = side(n, 8)
    u = np.linspace(0, 6 * TAU, 2 * m)[:, None]
    v = (np.arange(m // 2) * TAU / (m // 2))[None]
    r = np.exp(0.12 * u - 4.5)
    body = [
        r * (1 + 0.6 * np.cos(v)) * np.cos(u),
        r * (1 + 0.6 * np.cos(v)) * np.sin(u),
        r * (np.sin(v) - 2),
    ]
    return np.stack(body, -1).reshape(-1, 3), grid(2 * m, m // 2, False, True)


@kind
def poles(rng, n):
    rings = 5 if n < 5000 else 8
    return globe(rings, at_least(n / (2 * (rings - 1)), 8))


@kind
def high_valence(rng, n):
    t = np.arange(n) * TAU / n
    ring = np.stack([np.cos(t), np.sin(t), 0.05 * np.sin(7 * t)], 1) * rng.uniform(0.97, 1, (n, 1))
    k = np.arange(n)
    return np.concatenate([ring, [[0, 0, 0.2]]]), np.stack([k, (k + 1) % n, 0 * k + n], 1)


@kind
def cones(rng, n):
    m = at_least(n / 20, 6)
    t = np.arange(m) * TAU / m
    k = np.arange(m)
    cone = (
        np.concatenate([np.stack([np.cos(t), np.sin(t), 0 * t], 1), [[0, 0, 3]]]),
        np.stack([k, (k + 1) % m, 0 * k + m], 1),
    )
    return copies(cone, rng.uniform(-8, 8, (20, 3)), turns(rng, 20, rng.uniform(0.2, 1, 20)))


@kind
def needles(rng, n):
    m = at_least(n / 10, 8)
    x, y = np.linspace(0, 1, m), np.linspace(0, 200, 6)
    flat = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    z = 0.05 * np.sin(40 * flat[:, 0]) + 1e-3 * rng.normal(size=len(flat))
    return np.column_stack([flat, z]), grid(m, 6)


@kind
def slivers(rng, n):
    m = side(n)
    positions, triangles = sheet(m, lambda p: 0.1 * noise(p * 2, rng, 4))
    # Vertices that almost meet their neighbours.
    shift = np.where(rng.random(len(positions)) < 0.4, 0.998, 0) * 2 / (m - 1)
    shift[np.abs(positions[:, 0]) > 0.97] = 0
    positions[:, 0] += shift
    return positions, triangles


@kind
def zipper(rng, n):
    m = at_least(n / 6, 6)
    a = np.linspace(0, 10, m)
    b = np.linspace(0, 10, 2 * m + 1)
    left = np.column_stack([a, 0 * a - 1, 0.2 * np.sin(a)])
    middle = np.column_stack([b, 0 * b, 0.2 * np.sin(b)])
    right = np.column_stack([b, 0 * b + 0.3, 0.2 * np.sin(b)])
    seam = np.column_stack([a, 0 * a, 0.2 * np.sin(a)])
    rows = lambda p, q: (np.stack([p, q], 1).reshape(-1, 3), grid(len(p), 2))
    return join(rows(left, seam), rows(middle, right))


@kind
def stars(rng, n):
    some = at_least(n / 100)
    parts = []
    for _ in range(some):
        m = 2 * rng.integers(5, 20)
        t = np.arange(m) * TAU / m
        r = np.where(np.arange(m) % 2, 1, rng.uniform(0.1, 0.6))
        star = prism(np.stack([r * np.cos(t), r * np.sin(t)], 1), 0.1)
        parts.append(copies(star, rng.uniform(-5, 5, (1, 3)), turns(rng, 1, 0.7)))
    return join(*parts)


@kind
def gears(rng, n):
    some = at_least(n / 1000)
    parts = []
    for _ in range(some):
        teeth = at_least(n / some / 32, 8)
        t = np.arange(teeth * 8) / (teeth * 8) * TAU
        bump = np.array([0, 0.02, 0.06, 0.1, 0.1, 0.06, 0.02, 0])[np.arange(teeth * 8) % 8]
        r = 1 + bump * 20 / teeth
        gear = prism(np.stack([r * np.cos(t), r * np.sin(t)], 1), rng.uniform(0.1, 0.4))
        parts.append(copies(gear, rng.uniform(-4, 4, (1, 3)), turns(rng, 1)))
    return join(*parts)


@kind
def bolts(rng, n):
    some = 4
    m = at_least(n / some / 8, 24)
    t = np.arange(m) * 8 / m
    profile = np.array([[1, 0], [1, 0.1], [0.8, 0.4], [0.8, 0.5], [1, 1]])
    a = TAU * t[:, None]
    thread = [
        profile[:, 0] * np.cos(a),
        profile[:, 0] * np.sin(a),
        (t[:, None] + profile[:, 1]) / 4,
    ]
    bolt = welded((np.stack(thread, -1).reshape(-1, 3), grid(m, 5)), 5)
    hexagon = np.stack([np.cos(np.arange(6) * TAU / 6), np.sin(np.arange(6) * TAU / 6)], 1) * 1.8
    head = prism(hexagon, -0.9)
    return copies(join(bolt, head), [[4 * k, 0, 0] for k in range(some)])


FONT = {
    "A": "01110100011000111111100011000110001",
    "B": "11110100011000111110100011000111110",
    "E": "11111100001000011110100001000011111",
    "O": "01110100011000110001100011000101110",
    "R": "11110100011000111110101001001010001",
    "S": "01111100001000001110000010000111110",
}


@kind
def letters(rng, n):
    dot = BOX[0] * [1, 1, 1.5], BOX[1]
    count, places = at_least(n / 12), []
    column = 0
    while len(places) < count:
        bits = FONT["ABEORS"[rng.integers(6)]]
        places += [
            (column % 300 + k % 5, -(column // 300) * 9 - k // 5, 0)
            for k, bit in enumerate(bits)
            if bit == "1"
        ]
        column += 6
    return welded(copies(dot, places[:count]))


@kind
def perforated(rng, n):
    m = 12
    t = np.arange(m) * TAU / m
    c, s = np.cos(t), np.sin(t)
    q = 0.5 / np.maximum(abs(c), abs(s))
    hole, edge = np.stack([0.3 * c, 0.3 * s], 1), np.stack([q * c, q * s], 1)
    parts = []
    for z in (0.05, -0.05):
        rim = np.insert(np.concatenate([hole, edge]), 2, z, 1)
        t = grid(2, m, False, True)
        parts.append((rim, t if z < 0 else t[:, ::-1]))
    wall = np.concatenate([np.insert(hole, 2, z, 1) for z in (0.05, -0.05)])
    parts.append((wall, grid(2, m, False, True)))
    k = at_least((n / (6 * m)) ** 0.5, 2)
    places = [(x, y, 0) for x in range(k) for y in range(k)]
    return welded(copies(join(*parts), places), 5)


@kind
def honeycomb(rng, n):
    t = np.arange(6) * TAU / 6 + TAU / 12
    ring = np.stack([np.cos(t), np.sin(t)], 1) / 3**0.5
    wall = np.concatenate([np.insert(ring, 2, z, 1) for z in (0, 0.5, 1)])
    k = at_least((n / 24) ** 0.5, 2)
    places = [(x + y % 2 / 2, y * 3**0.5 / 2, 0) for x in range(k) for y in range(k)]
    return welded(copies((wall, grid(3, 6, False, True)), places), 6)


@kind
def foam(rng, n):
    k = 4
    m = max(2, round((n / (3 * 2 * (k - 1) ** 2)) ** (1 / 3)) + 1)
    nodes = np.stack(np.meshgrid(*[np.arange(m)] * 3, indexing="ij"), -1) + rng.uniform(
        -0.25, 0.25, (m, m, m, 3)
    )
    t = np.linspace(0, 1, k)
    u, v = (w.reshape(-1, 1) for w in np.meshgrid(t, t, indexing="ij"))
    parts = []
    for axis in range(3):
        e, f = (np.eye(3, dtype=int)[k] for k in range(3) if k != axis)
        for at in np.ndindex(m, m, m):
            if max(at + e + f) >= m:
                continue
            a, b, c, d = (nodes[tuple(at + x)] for x in (0 * e, e, e + f, f))
            points = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
            parts.append((points, grid(k, k)))
    return welded(join(*parts), 6)


@kind
def fillets(rng, n):
    positions, triangles = sphere(n / 12)
    boxes = np.sign(positions) * 0.9 + positions * 0.1, triangles
    places = np.column_stack([rng.uniform(-19, 19, (12, 2)), np.full(12, 1.0)])
    plate = BOX[0] * [40, 40, 1], BOX[1]
    return join(plate, copies(boxes, places, rng.uniform(0.3, 1.5, 12)))


@kind
def coral(rng, n):
    parts, tips = [], [(np.zeros(3), np.array([0, 0, 1.0]), 0.2)]
    sides, k = 8, 8
    while 2 * sides * (k - 1) * len(parts) < n:
        at, way, radius = tips.pop(0)
        path = at + np.linspace(0, 4 * radius, k)[:, None] * way
        path = path + 0.15 * radius * rng.normal(size=path.shape)
        parts.append(tube(path, radius * np.linspace(1, 0.8, k), sides, capped=True))
        for _ in range(2):
            turned = way + 0.7 * rng.normal(size=3)
            tips.append((path[-1], turned / np.linalg.norm(turned), max(0.85 * radius, 0.01)))
    return join(*parts)


@kind
def flower(rng, n):
    m = side(n / 24, 4)
    flat = square(m, 0.5) + [0.5, 0]
    petal = np.column_stack(
        [flat[:, 0], flat[:, 1] * np.sin(np.pi * flat[:, 0]), 0.5 * flat[:, 0] ** 2]
    )
    turned = upright(np.arange(24) * TAU * 0.382, np.linspace(1, 0.2, 24))
    return copies((petal, grid(m, m)), np.outer(np.linspace(0, 0.5, 24), [0, 0, 1]), turned)


@kind
def floor_plan(rng, n):
    def height(p):
        return np.where(np.all(abs(p * 7 % 2 - 1) < 0.2, axis=1), 0.3, 0.0)

    return sheet(side(n), height)


@kind
def fine_box(rng, n):
    m = side(n / 6)
    flat = square(m)
    faces = []
    for axis in range(3):
        for up in (-1, 1):
            faces.append((np.roll(np.insert(flat, 2, up, 1), axis, 1), grid(m, m)[:, ::up]))
    return welded(join(*faces), 6)


@kind
def facets(rng, n):
    positions, triangles = apart(lumpy(rng, n, 0.2, 3))
    a, b, c = positions[0::3], positions[1::3], positions[2::3]
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return positions, triangles, ("nx ny nz", np.repeat(normal, 3, 0))


@kind
def charts(rng, n):
    positions, triangles = lumpy(rng, n)
    seeds = directions(rng, max(8, n // 80))
    chart = np.argmax(positions[triangles].mean(1) @ seeds.T, axis=1)
    key, number = np.unique(triangles * len(seeds) + chart[:, None], return_inverse=True)
    vertex, of = key // len(seeds), key % len(seeds)
    shift = rng.random((len(seeds), 2))
    uv = (positions[vertex][:, :2] + shift[of]) * 0.3
    return positions[vertex], number.reshape(-1, 3), ("s t", uv)


@kind
def spike(rng, n):
    positions, triangles = lumpy(rng, n)
    for k in rng.integers(len(positions), size=3):
        positions[k] *= rng.uniform(5, 60)
    return positions, triangles


@kind
def pond(rng, n):
    m = side(n * 0.8)
    positions, triangles = sheet(m, lambda p: 0.02 * noise(p * 3, rng, 4))
    middle = positions[triangles].mean(1)
    hole = np.hypot(middle[:, 0], middle[:, 1]) < 0.4 + 0.05 * np.sin(
        9 * np.arctan2(middle[:, 1], middle[:, 0])
    )
    k = side(n * 0.2)
    water = np.insert(square(k, 0.5), 2, -0.03, 1), grid(k, k)
    return join((positions, triangles[~hole]), water)


# Many parts


@kind
def soup(rng, n):
    corners = rng.random((n, 1, 3)) + rng.normal(size=(n, 3, 3)) * 0.01
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


@kind
def large_soup(rng, n):
    corners = rng.random((n, 1, 3)) + rng.normal(size=(n, 3, 3)) * 0.2
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


@kind
def uneven_soup(rng, n):
    size = 10 ** rng.uniform(-4, -0.5, (n, 1, 1))
    corners = rng.random((n, 1, 3)) + rng.normal(size=(n, 3, 3)) * size
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


@kind
def leaf_cards(rng, n):
    some = at_least(n / 2)
    places = directions(rng, some) * rng.uniform(0.5, 1, (some, 1)) ** (1 / 3)
    return copies(QUAD, places, turns(rng, some, rng.uniform(0.02, 0.06, some)))


@kind
def crossed_cards(rng, n):
    some = at_least(0.8 * n / 4)
    card = QUAD[0][:, [0, 2, 1]] + [0, 0, 0.5], QUAD[1]
    cross = join(card, (card[0][:, [1, 0, 2]], card[1]))
    flat = rng.uniform(-1, 1, (some, 2))
    places = np.insert(flat, 2, 0.1 * noise(flat, rng, 2), 1)
    ground = sheet(side(0.2 * n), lambda p: 0.02 * noise(p * 4, rng, 3))
    turned = upright(rng.uniform(0, TAU, some), rng.uniform(0.02, 0.05, some))
    return join(copies(cross, places, turned), ground)


@kind
def grass(rng, n):
    some, k = at_least(n / 6), 4
    t = np.linspace(0, 1, k)[None, :, None]
    root = np.insert(rng.uniform(-1, 1, (some, 2)), 2, 0, 1)[:, None]
    way = np.column_stack([rng.normal(size=(some, 2)) * 0.3, np.ones(some)])[:, None]
    bent = np.column_stack([rng.normal(size=(some, 2)) * 0.3, -0.2 * np.ones(some)])[:, None]
    path = root + 0.2 * (t * way + t * t * bent)
    wide = upright(rng.uniform(0, TAU, some)) @ [0.005, 0, 0]
    wide = wide[:, None] * (1 - 0.9 * t)
    blades = np.stack([path - wide, path + wide], 2).reshape(-1, 3)
    blade = grid(k, 2)
    return blades, (blade[None] + np.arange(some)[:, None, None] * 2 * k).reshape(-1, 3)


@kind
def hair(rng, n):
    k = 11
    some = at_least(n / (2 * (k - 1)))
    root = directions(rng, some)[:, None]
    t = np.linspace(0, 1, k)[None, :, None]
    way = root + 0.3 * rng.normal(size=(some, 1, 3))
    path = root + 0.8 * t * way - t * t * [0, 1, 0]
    wide = np.cross(way[:, 0], directions(rng, some))
    wide = 0.01 * (wide / np.linalg.norm(wide, axis=1, keepdims=True))[:, None] * (1 - 0.8 * t)
    strips = np.stack([path - wide, path + wide], 2).reshape(-1, 3)
    return strips, (grid(k, 2)[None] + np.arange(some)[:, None, None] * 2 * k).reshape(-1, 3)


@kind
def fur(rng, n):
    skin = sphere(n / 4)
    some = at_least(n / 4)
    up = directions(rng, some)
    t = np.arange(3) * TAU / 3
    spike = np.array([[0.004 * np.cos(a), 0.004 * np.sin(a), 0] for a in t] + [[0, 0, 0.15]])
    sides = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    a = np.cross(up, directions(rng, some))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    return join(skin, copies((spike, sides), up, np.stack([a, np.cross(up, a), up], 2)))


@kind
def feathers(rng, n):
    m = 8
    some = at_least(n / (4 * (m - 1)))
    t = np.linspace(0, 1, m)
    half = 0.12 * np.sin(np.pi * np.clip(t, 0.05, 0.98))
    rows = [np.stack([t, s * half, 0.1 * t * t + 0.02 * abs(s)], 1) for s in (-1, 0, 1)]
    feather = np.stack(rows, 1).reshape(-1, 3), grid(m, 3)
    return copies(feather, directions(rng, some), turns(rng, some, rng.uniform(0.2, 0.5, some)))


@kind
def seats(rng, n):
    seat = join(
        (BOX[0] * [0.4, 0.4, 0.04], BOX[1]),
        (BOX[0] * [0.4, 0.04, 0.5] + [0, 0.2, 0.25], BOX[1]),
    )
    some = at_least(n / 24)
    row = max(4, round((6 * some) ** 0.5))
    k = np.arange(some)
    r, a = 40 + k // row * 0.8, k % row * TAU / row
    places = np.stack([r * np.cos(a), 0.7 * r * np.sin(a), k // row * 0.4], 1)
    return copies(seat, places, upright(a - np.pi / 2))


@kind
def own_quads(rng, n):
    m = side(n)
    positions, triangles = sheet(m, lambda p: 0.2 * noise(p, rng, 4))
    q = len(triangles) // 2
    corners = np.stack([*triangles[:q].T, triangles[q:, 2]], 1)
    quads = positions[corners]
    middle = quads.mean(1, keepdims=True)
    k = 4 * np.arange(q)[:, None]
    return (middle + 0.97 * (quads - middle)).reshape(-1, 3), np.concatenate(
        [k + [0, 1, 2], k + [0, 2, 3]]
    )


@kind
def own_triangles(rng, n):
    positions, triangles = apart(lumpy(rng, n))
    return positions + 1e-4 * rng.normal(size=positions.shape), triangles


@kind
def chain_mail(rng, n):
    sides, k = 5, 12
    some = at_least((n / (2 * sides * k)) ** 0.5, 2)
    t = np.arange(k) * TAU / k
    ring = tube(np.stack([0.62 * np.cos(t), 0.62 * np.sin(t), 0 * t], 1), 0.1, sides, True)
    c, s = np.cos(0.6), np.sin(0.6)
    ways = [[[1, 0, 0], [0, c, -s], [0, s, c]], [[c, 0, s], [0, 1, 0], [-s, 0, c]]]
    places = [(x, y, 0) for x in range(some) for y in range(some)]
    return copies(ring, places, [ways[(x + y) % 2] for x, y, _ in places])


@kind
def woven(rng, n):
    k = max(2, round((n / (2 * 6 * 4 * 2)) ** 0.5))
    t = np.linspace(0, k, 4 * k + 1)
    parts = []
    for i in range(k):
        wave = 0.3 * np.cos(np.pi * t + np.pi * i)
        parts.append(tube(np.stack([t, 0 * t + i + 0.5, wave], 1), 0.24, 6))
        parts.append(tube(np.stack([0 * t + i + 0.5, t, -wave], 1), 0.24, 6))
    return join(*parts)


@kind
def wires(rng, n):
    positions, triangles = sphere(n / 12)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.sort(edges, 1), axis=0)
    return join(*[tube(positions[edge], 0.006, 4) for edge in edges])


@kind
def cables(rng, n):
    sides, some = 6, 12
    m = at_least(n / (2 * sides * some), 6)
    parts = []
    for k in range(some):
        t = np.linspace(0, 1, m)
        path = np.stack([10 * t, k * 0.5 + 0.3 * noise(t[:, None], rng, 3), 2 * t * (t - 1)], 1)
        parts.append(tube(path, 0.03, sides, capped=True))
    return join(*parts)


@kind
def springs(rng, n):
    sides, some = 8, 5
    m = at_least(n / (2 * sides * some), 30)
    t = np.linspace(0, 1, m)
    coil = np.stack([np.cos(8 * TAU * t), np.sin(8 * TAU * t), 4 * t], 1)
    return copies(
        tube(coil, 0.1, sides, capped=True), rng.uniform(-8, 8, (some, 3)), turns(rng, some)
    )


@kind
def pipes(rng, n):
    sides, some = 10, at_least(n / 1000, 2)
    parts = []
    for _ in range(some):
        at, path = rng.integers(0, 10, 3).astype(float), []
        for _ in range(at_least(n / some / (2 * sides * 6), 3)):
            way = np.eye(3)[rng.integers(3)] * rng.choice([-1, 1])
            path += [at + way * s for s in (0.15, 0.3, 0.9, 1.2, 1.5, 1.7)]
            at = at + 1.8 * way
        parts.append(tube(path, rng.uniform(0.05, 0.2), sides, capped=True))
    return join(*parts)


@kind
def struts(rng, n):
    k = max(2, round((n / 3 / 12) ** (1 / 3)))
    parts = []
    places = np.array([(x, y, z) for x in range(k) for y in range(k) for z in range(k)], float)
    for axis in range(3):
        size = np.where(np.arange(3) == axis, 0.9, 0.05)
        parts.append(copies((BOX[0] * size, BOX[1]), places + 0.5 * np.eye(3)[axis]))
    return join(*parts)


@kind
def fence(rng, n):
    some = at_least(n / 12)
    places = np.column_stack([0.12 * np.arange(some), np.zeros(some), np.full(some, 0.5)])
    rail = BOX[0] * [0.12 * some, 0.02, 0.05] + [0.06 * some, 0.02, 0.3], BOX[1]
    return join(copies((BOX[0] * [0.08, 0.02, 1], BOX[1]), places), rail)


@kind
def bricks(rng, n):
    some = at_least(n / 12)
    wide = max(2, round((2 * some) ** 0.5))
    k = np.arange(some)
    places = np.stack([k % wide + k // wide % 2 / 2, 0 * k, 0.35 * (k // wide)], 1)
    brick = BOX[0] * [0.96, 0.5, 0.31], BOX[1]
    return copies(brick, places + 0.01 * rng.normal(size=places.shape))


@kind
def books(rng, n):
    some = at_least(n / 36)
    parts, at = [], 0.0
    for k in range(some):
        w, h, d = rng.uniform(0.02, 0.08), rng.uniform(0.2, 0.3), rng.uniform(0.12, 0.2)
        cover = BOX[0] * [w, d, h], BOX[1]
        pages = BOX[0] * [w - 0.006, d - 0.01, h - 0.01] + [0, 0.006, 0], BOX[1]
        band = BOX[0] * [w + 0.001, d + 0.001, 0.01], BOX[1]
        at += w
        parts.append(copies(join(cover, pages, band), [[at % 3, 0, 0.4 * (at // 3)]]))
    return join(*parts)


@kind
def city(rng, n):
    some = at_least(n / 12)
    wide = max(2, round(some**0.5))
    k = np.arange(some)
    size = np.column_stack([rng.uniform(0.3, 0.8, (some, 2)), rng.gamma(2, 0.7, some) + 0.1])
    places = np.stack([k % wide, k // wide, size[:, 2] / 2], 1)
    return copies(BOX, places, size[:, :, None] * np.eye(3))


@kind
def stairs(rng, n):
    some = at_least(0.8 * n / 12)
    a = 0.15 * np.arange(some)
    places = np.stack([3 * np.cos(a), 3 * np.sin(a), 0.05 * np.arange(some)], 1)
    step = BOX[0] * [2, 0.4, 0.04], BOX[1]
    m = at_least(0.1 * n / 12, 3)
    t = np.linspace(0, a[-1], m)
    rails = [
        tube(np.stack([r * np.cos(t), r * np.sin(t), t / 3 + 0.5], 1), 0.02, 6) for r in (2, 4)
    ]
    return join(copies(step, places, upright(a)), *rails)


@kind
def shingles(rng, n):
    some = at_least(n / 12)
    wide = max(2, round(some**0.5))
    k = np.arange(some)
    places = np.stack(
        [k % wide + k // wide % 2 / 2, 0.7 * (k // wide), 0.02 * rng.normal(size=some)], 1
    )
    tilt = np.array([[1, 0, 0], [0, 0.98, -0.2], [0, 0.2, 0.98]])
    return copies((BOX[0] * [0.95, 1, 0.05], BOX[1]), places, np.broadcast_to(tilt, (some, 3, 3)))


@kind
def tree(rng, n):
    parts, tips, leaves = [], [(np.zeros(3), np.array([0, 0, 1.0]), 1.0)], []
    sides, k = 6, 5
    while 2 * sides * (k - 1) * len(parts) < 0.4 * n:
        at, way, long = tips.pop(0)
        path = at + np.linspace(0, long, k)[:, None] * way + 0.02 * long * rng.normal(size=(k, 3))
        parts.append(tube(path, 0.06 * long * np.linspace(1, 0.7, k), sides))
        for _ in range(3):
            turned = way + 0.6 * rng.normal(size=3)
            tips.append((path[-1], turned / np.linalg.norm(turned), 0.75 * long))
    some = at_least(0.6 * n / 2)
    ends = np.array([tip[0] for tip in tips])
    places = ends[rng.integers(len(ends), size=some)] + 0.1 * rng.normal(size=(some, 3))
    return join(*parts, copies(QUAD, places, turns(rng, some, rng.uniform(0.03, 0.08, some))))


@kind
def dust(rng, n):
    some = at_least(n / 2 / 20)
    places = directions(rng, some) * rng.uniform(1.2, 3, (some, 1))
    specks = copies(sphere(20), places, rng.uniform(0.002, 0.01, some))
    return join(lumpy(rng, n / 2, 0.2), specks)


@kind
def shards(rng, n):
    some = at_least(n / 4)
    corners = rng.normal(size=(some, 4, 3)) * (0.05 * rng.lognormal(size=(some, 1, 3)))
    corners += rng.uniform(-2, 2, (some, 1, 3))
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    return corners.reshape(-1, 3), (faces[None] + 4 * np.arange(some)[:, None, None]).reshape(-1, 3)


@kind
def confetti(rng, n):
    some = at_least(n / 2)
    return copies(
        QUAD,
        np.insert(rng.uniform(-1, 1, (some, 2)), 2, 0, 1),
        upright(rng.uniform(0, TAU, some), 0.02),
    )


@kind
def gravel(rng, n):
    per = 80
    some = at_least(n / per)
    stones = [lumpy(rng, per, 0.5, 2) for _ in range(some)]
    places = np.column_stack([rng.uniform(-3, 3, (some, 2)), rng.uniform(0, 0.5, some)])
    size = rng.lognormal(-2, 0.6, some)
    return join(*[(p * s + at, t) for (p, t), at, s in zip(stones, places, size)])


@kind
def dominoes(rng, n):
    some = at_least(n / 12)
    t = np.arange(some) * 0.05
    places = np.stack([t * np.cos(t**0.5), t * np.sin(t**0.5), 0 * t], 1)
    return copies((BOX[0] * [0.02, 0.1, 0.2], BOX[1]), places, upright(t**0.5))


@kind
def bow_ties(rng, n):
    octahedron = np.concatenate([np.eye(3), -np.eye(3)]) / 2
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    k = max(2, round((n / 8) ** (1 / 3)))
    places = [(x, y, z) for x in range(k) for y in range(k) for z in range(k)]
    positions, triangles = welded(copies((octahedron, np.array(faces)), places))
    return positions + 0.02 * rng.normal(size=positions.shape), triangles


@kind
def blobs(rng, n):
    some = at_least(n / 600, 3)
    parts = []
    for _ in range(some):
        positions, triangles = lumpy(rng, n / some, 0.2, 3)
        parts.append((positions * rng.uniform(0.2, 0.6) + 0.6 * rng.normal(size=3), triangles))
    return join(*parts)


@kind
def duplicates(rng, n):
    part = lumpy(rng, n / 4)
    return join(part, part, part, part)


@kind
def doubled_faces(rng, n):
    positions, triangles = lumpy(rng, n / 2)
    return positions, np.concatenate([triangles, triangles[:, ::-1]])


@kind
def nested_spheres(rng, n):
    some = 15 if n > 5000 else 5
    part = sphere(n / some)
    return copies(part, np.zeros((some, 3)), np.linspace(0.3, 1, some))


def shell(rng, n, gap):
    positions, triangles = sheet(side(n / 2), lambda p: 0.2 * noise(p, rng, 4))
    return join((positions, triangles), (positions - [0, 0, gap], triangles[:, ::-1]))


@kind
def thick_shell(rng, n):
    return shell(rng, n, 0.05)


@kind
def thin_shell(rng, n):
    return shell(rng, n, 2e-3)


@kind
def foil(rng, n):
    return shell(rng, n, 5e-5)


@kind
def hollow_scan(rng, n):
    positions, triangles = lumpy(rng, n / 2)
    return join((positions, triangles), (0.97 * positions, triangles[:, ::-1]))


@kind
def decals(rng, n):
    height = lambda p: 0.1 * np.sin(3 * p[:, 0]) * np.cos(2 * p[:, 1])
    parts = [sheet(side(n / 2), height)]
    k = 5
    for _ in range(at_least(n / 2 / 32)):
        flat = square(k, 0.05) + rng.uniform(-0.9, 0.9, 2)
        parts.append((np.column_stack([flat, height(flat) + 1e-4]), grid(k, k)))
    return join(*parts)


@kind
def t_junctions(rng, n):
    parts, left = [], n
    while left > 0:
        r, turned, at = rng.uniform(0.3, 1.5), turns(rng, 1)[0], rng.uniform(-10, 10, 3)
        for h in range(3):
            m = int(rng.integers(16, 60))
            t = np.linspace(0, TAU, m)
            rows = [np.stack([r * np.cos(t), r * np.sin(t), 0 * t + h + z], 1) for z in (0, 1)]
            parts.append((np.concatenate(rows) @ turned.T + at, grid(2, m)))
            left -= 2 * (m - 1)
    return apart(join(*parts))


# Sizes unlike each other


@kind
def ground(rng, n):
    plane = QUAD[0] * 1000 - [0, 0, 0.6], QUAD[1]
    positions, triangles = lumpy(rng, n)
    return join((positions / 2, triangles), plane)


@kind
def sky_box(rng, n):
    positions, triangles = lumpy(rng, n)
    return join((positions / 2, triangles), (BOX[0] * 2000, BOX[1][:, ::-1]))


@kind
def tiles(rng, n):
    some = at_least((n / 20) ** 0.5, 3)
    places = np.array(
        [(2 * x, 2 * y, -0.6 + 0.02 * rng.normal()) for x in range(some) for y in range(some)]
    )
    positions, triangles = lumpy(rng, 0.9 * n)
    return join(
        (positions / 2 + [some, some, 0], triangles),
        copies(QUAD, places, np.full(len(places), 1.99)),
    )


@kind
def panels(rng, n):
    some, rivets = at_least(n / 200, 6), at_least(n / 80)
    rivet = globe(5, 10)
    size = turns(rng, some, rng.uniform(1, 4, some))
    spread = [20, 20, 6]
    return join(
        copies(rivet, rng.uniform(-1, 1, (rivets, 3)) * spread, np.full(rivets, 0.005)),
        copies(QUAD, rng.uniform(-1, 1, (some, 3)) * spread, size),
    )


@kind
def islands(rng, n):
    parts = []
    for size in (1e-3, 1e-2, 0.1, 1, 10):
        positions, triangles = lumpy(rng, n / 5)
        parts.append((positions * size + rng.uniform(-500, 500, 3), triangles))
    return join(*parts)


@kind
def one_huge(rng, n):
    huge = (
        np.array([[-900.0, -400, -0.5], [700, -500, -0.4], [100, 800, -0.7]]),
        np.array([[0, 1, 2]]),
    )
    corners = rng.uniform(-1, 1, (n, 1, 3)) + rng.normal(size=(n, 3, 3)) * 0.02
    tiny = corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)
    return join(tiny, huge)


@kind
def masts(rng, n):
    some, sides = 30, 6
    m = at_least(0.3 * n / some / (2 * sides), 2)
    t = np.linspace(0, 1, m + 1)
    mast = tube(np.stack([0 * t, 0 * t, 20 * t], 1), 0.01, sides, capped=True)
    places = np.insert(rng.uniform(-10, 10, (some, 2)), 2, 0, 1)
    return join(
        copies(mast, places), sheet(side(0.7 * n), lambda p: 0.5 * noise(p / 5, rng, 4), 10)
    )


@kind
def screws(rng, n):
    some = at_least(n / 24)
    size = rng.uniform(0.2, 3, (some, 3))
    boxes = copies(BOX, rng.uniform(-5, 5, (some, 3)), size[:, :, None] * np.eye(3))
    few = at_least(n / 2 / 96)
    return join(boxes, copies(globe(7, 8), rng.uniform(-5, 5, (few, 3)), np.full(few, 5e-4)))


@kind
def wall_scan(rng, n):
    parts, m = [], side(n / 8)
    for k in range(8):
        positions, triangles = sheet(m, lambda p: 0.01 * rng.normal(size=len(p)), 2)
        turned = positions[:, [2, 0, 1]] if k % 2 else positions[:, [0, 2, 1]]
        parts.append((turned + np.array([rng.uniform(-6, 6), rng.uniform(-6, 6), 0]), triangles))
    return join(*parts)


@kind
def plank_and_dust(rng, n):
    plank = BOX[0] * [300, 0.2, 0.02], BOX[1]
    some = at_least(n / 20)
    places = rng.uniform(-1, 1, (some, 3)) * [150, 2, 2]
    return join(plank, copies(sphere(20), places, 10 ** rng.uniform(-3, -0.5, some)))


@kind
def lamp_in_hall(rng, n):
    hall = BOX[0] * [60, 40, 12], BOX[1][:, ::-1]
    columns = copies((BOX[0] * [0.6, 0.6, 12], BOX[1]), rng.uniform(-1, 1, (20, 3)) * [28, 18, 0])
    positions, triangles = lumpy(rng, n, 0.2)
    return join((0.2 * positions, triangles), hall, columns)


def make(name, triangles, seed):
    """Positions (f32), triangles and perhaps a named attribute of a kind."""
    index = sorted(KINDS).index(name)
    rng = np.random.default_rng([seed, index])
    positions, found, *more = KINDS[name](rng, triangles)
    return np.asarray(positions, np.float32), np.asarray(found, np.int32), *more


def write(path, positions, triangles, attribute=None):
    """Writes a mesh as binary PLY."""
    names, columns = ["x", "y", "z"], [positions]
    if attribute:
        names += attribute[0].split()
        columns.append(attribute[1])
    rows = np.concatenate(columns, 1).astype("<f4")
    faces = np.zeros(len(triangles), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, triangles
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    head += [f"property float {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    path.write_bytes("\n".join(head).encode() + rows.tobytes() + faces.tobytes())
