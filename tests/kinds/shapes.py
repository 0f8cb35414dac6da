"""What kinds of meshes are made of. A part is a pair: positions (n x 3) and triangles (m x 3)."""

import numpy as np

TAU = 2 * np.pi
BOX = (
    np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) - 0.5,
    np.array(
        [
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
        ]  # fmt: skip
    ),
)
QUAD = (
    np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) / 2,
    np.array([[0, 1, 2], [0, 2, 3]]),
)


def join(*parts):
    """One part of several."""
    ends = np.cumsum([0] + [len(p) for p, _ in parts])
    return (
        np.concatenate([p for p, _ in parts]),
        np.concatenate([np.asarray(t) + e for (_, t), e in zip(parts, ends)]),
    )


def copies(part, places, turns=None):
    """The part at each place, turned and scaled by a matrix (or factor) each."""
    positions, triangles = part
    places = np.asarray(places, float)
    turns = np.ones(len(places)) if turns is None else np.asarray(turns, float)
    if turns.ndim < 3:
        turns = turns.reshape(len(places), -1)[:, :, None] * np.eye(3)
    moved = np.einsum("nij,vj->nvi", turns, positions) + places[:, None]
    numbers = np.arange(len(places))[:, None, None] * len(positions)
    return moved.reshape(-1, 3), (triangles[None] + numbers).reshape(-1, 3)


def directions(rng, count):
    """Unit vectors."""
    found = rng.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def turns(rng, count, scale=1.0):
    """Random rotations times a factor each."""
    a = directions(rng, count)
    b = np.cross(a, directions(rng, count))
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    found = np.stack([a, b, np.cross(a, b)], axis=2)
    return found * np.broadcast_to(scale, (count,))[:, None, None]


def upright(angles, scale=1.0):
    """Rotations around the third axis."""
    c, s, o = np.cos(angles), np.sin(angles), np.zeros(len(angles))
    rows = [[c, -s, o], [s, c, o], [o, o, o + 1]]
    return np.moveaxis(np.array(rows), 2, 0) * np.broadcast_to(scale, (len(c),))[:, None, None]


def noise(points, rng, octaves=5, frequency=2.0):
    """Sums of sines in random directions, about -1 to 1."""
    found, height = np.zeros(len(points)), 0.5
    for _ in range(octaves):
        for _ in range(4):
            wave = rng.normal(size=points.shape[1]) * frequency
            found += height / 2 * np.sin(points @ wave + rng.uniform(0, TAU))
        height, frequency = height / 2, 2 * frequency
    return found


def grid(n, m, around_n=False, around_m=False):
    """Triangles of n x m vertices, two for each quad."""
    i = np.arange(n if around_n else n - 1)[:, None]
    j = np.arange(m if around_m else m - 1)[None]
    a, b = i * m + j, (i + 1) % n * m + j
    d, c = i * m + (j + 1) % m, (i + 1) % n * m + (j + 1) % m
    quads = np.stack([a, b, c, d], -1).reshape(-1, 4)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def side(triangles, least=2):
    """Vertices along the side of a square grid with so many triangles."""
    return max(least, round((triangles / 2) ** 0.5) + 1)


def square(n, size=1.0):
    """Points of a flat grid of n x n around the origin, with two coordinates."""
    x = np.linspace(-size, size, n)
    return np.stack(np.meshgrid(x, x, indexing="ij"), -1).reshape(-1, 2)


def sheet(n, height, size=1.0):
    """A height field of n x n vertices; `height` of n x 2 points."""
    flat = square(n, size)
    return np.column_stack([flat, height(flat)]), grid(n, n)


def sphere(triangles):
    """A geodesic sphere of 20 f^2 triangles, for the f that comes nearest."""
    f = max(1, round((triangles / 20) ** 0.5))
    g = (1 + 5**0.5) / 2
    corners = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0]]
    corners = np.array([np.roll(c, k) for k in range(3) for c in corners], float)
    # The faces are the triples of mutually nearest corners.
    near = np.linalg.norm(corners[:, None] - corners[None], axis=2) < 2.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    ij = np.array([(i, j) for i in range(f + 1) for j in range(f + 1 - i)])
    number = {tuple(x): k for k, x in enumerate(ij)}
    small = [
        (number[i, j], number[i + 1, j], number[i, j + 1]) for i in range(f) for j in range(f - i)
    ]
    small += [
        (number[i + 1, j], number[i + 1, j + 1], number[i, j + 1])
        for i in range(f - 1)
        for j in range(f - 1 - i)
    ]
    parts = []
    for face in faces:
        a, b, c = corners[list(face)]
        if np.dot(np.cross(b - a, c - a), a) < 0:
            b, c = c, b
        parts.append((a + (b - a) * ij[:, :1] / f + (c - a) * ij[:, 1:] / f, np.array(small)))
    positions, found = welded(join(*parts))
    return positions / np.linalg.norm(positions, axis=1, keepdims=True), found


def welded(part, digits=9):
    """Equal positions (rounded) become one vertex; triangles without area go."""
    positions, triangles = part
    _, first, number = np.unique(
        np.round(positions, digits) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    t = number.reshape(-1)[triangles]
    sound = (t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 0] != t[:, 2])
    return positions[first], t[sound]


def apart(part):
    """Each triangle with vertices of its own."""
    positions, triangles = part
    return positions[triangles.reshape(-1)], np.arange(triangles.size).reshape(-1, 3)


def globe(rings, segments):
    """A sphere by longitude and latitude."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1, None]
    phi = np.arange(segments)[None] * TAU / segments
    body = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi]
    positions = np.stack(body, -1).reshape(-1, 3)
    k, c = len(positions), np.arange(segments)
    d, last = (c + 1) % segments, k - segments
    caps = [np.stack([0 * c + k, c, d], 1), np.stack([0 * c + k + 1, last + d, last + c], 1)]
    triangles = np.concatenate([grid(rings - 1, segments, False, True), *caps])
    return np.concatenate([positions, [[0, 0, 1], [0, 0, -1]]]), triangles


def tube(path, radius, sides, closed=False, capped=False):
    """A tube along a path, by a frame that turns as little as possible."""
    path = np.asarray(path, float)
    if closed:
        along = np.roll(path, -1, 0) - np.roll(path, 1, 0)
    else:
        along = np.gradient(path, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    up = np.eye(3)[np.argmin(abs(along[0]))]
    ups = np.empty_like(path)
    for i, t in enumerate(along):
        up = up - t * (up @ t)
        up /= np.linalg.norm(up)
        ups[i] = up
    angle = np.arange(sides) * TAU / sides
    across = np.cross(along, ups)
    ring = ups[:, None] * np.cos(angle)[:, None] + across[:, None] * np.sin(angle)[:, None]
    radius = np.broadcast_to(radius, (len(path),))
    positions = (path[:, None] + ring * radius[:, None, None]).reshape(-1, 3)
    triangles = grid(len(path), sides, closed, True)
    if capped:
        k, c = len(positions), np.arange(sides)
        d, last = (c + 1) % sides, k - sides
        positions = np.concatenate([positions, path[:1], path[-1:]])
        caps = [np.stack([0 * c + k, d, c], 1), np.stack([0 * c + k + 1, last + c, last + d], 1)]
        triangles = np.concatenate([triangles, *caps])
    return positions, triangles


def prism(outline, height):
    """A polygon (n x 2), star-shaped around its mean, with thickness."""
    n, middle = len(outline), outline.mean(0)
    low, high = np.insert(outline, 2, 0, 1), np.insert(outline, 2, height, 1)
    ends = [[*middle, 0], [*middle, height]]
    k = np.arange(n)
    d = (k + 1) % n
    return np.concatenate([low, high, ends]), np.concatenate(
        [
            np.stack([k, d, n + d], 1),
            np.stack([k, n + d, n + k], 1),
            np.stack([0 * k + 2 * n, d, k], 1),
            np.stack([0 * k + 2 * n + 1, n + k, n + d], 1),
        ]
    )


def surface_net(field, spacing):
    """The surface where a field on a cubic grid is 0: a vertex for each cell that it crosses."""
    inside = field > 0
    n = np.array(field.shape)
    cell = np.zeros(n - 1, np.int64)
    weight, total = np.zeros((*(n - 1), 3)), np.zeros(n - 1)
    corner = lambda a, d: a[tuple(slice(k, k + s - 1) for k, s in zip(d, n))]
    for axis in range(3):
        for rest in np.ndindex(2, 2):
            low = list(rest)
            low.insert(axis, 0)
            high = list(low)
            high[axis] = 1
            a, b = corner(field, low), corner(field, high)
            crossed = (a > 0) != (b > 0)
            with np.errstate(divide="ignore", invalid="ignore"):
                t = np.where(crossed, a / (a - b), 0)
            point = np.array(low, float) + t[..., None] * np.eye(3)[axis]
            weight += point * crossed[..., None]
            total += crossed
    used = total > 0
    cell[used] = np.arange(used.sum())
    at = np.argwhere(used)
    positions = (at + weight[used] / total[used][:, None]) * spacing
    triangles = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        a = inside
        b = np.roll(inside, -1, axis)
        where = np.argwhere(a != b)
        sound = (where[:, axis] < n[axis] - 1) & (where[:, u] > 0) & (where[:, v] > 0)
        sound &= (where[:, u] < n[u] - 1) & (where[:, v] < n[v] - 1)
        where = where[sound]
        step = lambda du, dv: tuple(
            (where - du * np.eye(3, dtype=int)[u] - dv * np.eye(3, dtype=int)[v]).T
        )
        quad = np.stack([cell[step(0, 0)], cell[step(1, 0)], cell[step(1, 1)], cell[step(0, 1)]], 1)
        flip = ~inside[tuple(where.T)]
        quad[flip] = quad[flip][:, ::-1]
        triangles += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return positions, np.concatenate(triangles)


def lumpy(rng, triangles, height=0.1, octaves=5):
    """A closed surface as scans have it."""
    positions, found = sphere(triangles)
    return positions * (1 + height * noise(positions, rng, octaves))[:, None], found
