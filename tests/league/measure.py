"""How a level differs from its input: in pictures, in outlines, in space."""

import ctypes

import igl
import numpy as np

VIEWS, SIZE, SAMPLES, POINTS = 12, 320, 2, 20_000
# What is added to both sides of a ratio: differences that nobody can measure.
FLOORS = {"image": 0.25, "rms": 0.002, "outline": 0.0005}


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


class Drawing:
    """draw.c."""

    def __init__(self, library):
        self.library, self.taken = library, None

    def pictures(self, shown, cameras):
        """Colours and covered shares of pixels, of each camera."""
        if self.taken is not shown.images:
            count = len(shown.images)
            ints = ctypes.c_int * max(count, 1)
            sizes = [ints(*[image.shape[k] for image in shown.images]) for k in (1, 0)]
            pixels = (ctypes.c_void_p * max(count, 1))(*[i.ctypes.data for i in shown.images])
            self.library.take_textures(count, *sizes, pixels)
            self.taken = shown.images
        arrays = [shown.positions, shown.normals, shown.coordinates, shown.colours]
        arrays = [np.ascontiguousarray(a) for a in [*arrays, shown.material_of, shown.materials]]
        found = []
        for camera in cameras:
            colours = np.zeros((SIZE, SIZE, 3), np.float32)
            covered = np.zeros((SIZE, SIZE), np.float32)
            self.library.draw(
                len(shown.material_of), *map(pointer, arrays), pointer(camera), SIZE, SAMPLES,
                pointer(colours), pointer(covered),
            )
            found.append((colours, covered))
        return found


def cameras(centre, radius):
    """Cameras on a spiral around a sphere."""
    step = np.arange(VIEWS) + 0.5
    height = 1 - 2 * step / VIEWS
    angle, ring = np.pi * (1 + 5**0.5) * step, np.sqrt(1 - height**2)
    found = []
    for eye in np.stack([ring * np.cos(angle), height, ring * np.sin(angle)], 1):
        above = np.array([0.0, 1, 0]) if abs(eye[1]) < 0.97 else np.array([1.0, 0, 0])
        right = np.cross(above, eye)
        right /= np.linalg.norm(right)
        row = np.concatenate([right, np.cross(eye, right), eye, centre, [radius]])
        found.append(row.astype(np.float32))
    return found


class Tree:
    """Triangles with area, to measure distances to."""

    def __init__(self, positions):
        corners = positions.astype(float)
        area = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        corners, self.area = corners[area > 0], area[area > 0]
        self.points = np.ascontiguousarray(corners.reshape(-1, 3))
        self.faces = np.arange(len(self.points)).reshape(-1, 3)
        self.tree = igl.AABB()
        self.tree.init(self.points, self.faces)

    def spread(self, seed):
        """Points spread evenly over the surface."""
        random, ends = np.random.default_rng(seed), np.cumsum(self.area)
        wanted = (np.arange(POINTS) + random.random(POINTS)) / POINTS * ends[-1]
        face = np.searchsorted(ends, wanted, side="right").clip(0, len(ends) - 1)
        a, b = np.sqrt(random.random(POINTS)), random.random(POINTS)
        shares = np.stack([1 - a, a * (1 - b), a * b], 1)
        return np.einsum("nk,nkd->nd", shares, self.points[self.faces[face]])

    def squared(self, points):
        """Squared distances of points."""
        found = self.tree.squared_distance(self.points, self.faces, np.ascontiguousarray(points))
        return np.maximum(np.asarray(found[0] if isinstance(found, tuple) else found), 0)


class Ruler:
    """Measures levels of an input."""

    def __init__(self, drawing, whole):
        self.drawing, self.whole, self.tree = drawing, whole, Tree(whole.positions)
        points = whole.positions.reshape(-1, 3).astype(float)
        low, high = points.min(0), points.max(0)
        self.diagonal = float(np.linalg.norm(high - low))
        centre = (low + high) / 2
        self.cameras = cameras(centre, float(np.linalg.norm(points - centre, axis=1).max()))
        self.samples = self.tree.spread(1)
        self.shown = drawing.pictures(whole, self.cameras)

    def measure(self, level, is_shown):
        """The differences of a level; without its picture where a tool keeps no attributes."""
        found = {"triangles": len(level.material_of)}
        squares = count = apart = either = 0
        now = self.drawing.pictures(level, self.cameras)
        for (a, covered), (b, also) in zip(self.shown, now):
            difference = (a - b)[(covered > 0) | (also > 0)]
            squares += float((difference**2).sum())
            count += difference.size
            apart += float(abs(covered - also).sum())
            either += float(np.maximum(covered, also).sum())
        if is_shown:
            found["image"] = (squares / max(count, 1)) ** 0.5
        found["outline"] = apart / max(either, 1)
        tree = Tree(level.positions)
        ways = [tree.squared(self.samples).mean(), self.tree.squared(tree.spread(2)).mean()]
        found["rms"] = 100 * (sum(ways) / 2) ** 0.5 / self.diagonal
        return found
