"""How far apart two meshes are: the work is done by distance.c."""

import ctypes
import hashlib
import math
import pathlib
from typing import NamedTuple

import numpy as np
from compiled import compiled

SOURCE = pathlib.Path(__file__).with_name("distance.c")
TOLERANCE, PIECES = 1.02, 2_000_000
WANTED, POINTS = 0.01, 4_000_000


class Measured(NamedTuple):
    """The two-sided Hausdorff distance is between ``low`` and ``high``; ``rms`` is the larger root
    mean square distance of both ways, within ``spread`` (one standard error, a share)."""

    low: float
    high: float
    rms: float
    spread: float


def library():
    """The compiled functions."""
    found = compiled(SOURCE)
    found.tree_new.restype = ctypes.c_void_p
    found.integral.restype = ctypes.c_double
    found.farthest.restype = ctypes.c_int64
    return found


LIBRARY = library()


def numbers(array):
    return array.ctypes.data_as(ctypes.c_void_p)


class Surface:
    """A mesh as a set of triangles: faces with the same three positions count once."""

    def __init__(self, positions, triangles):
        corners = np.asarray(positions, np.float32)[np.asarray(triangles, np.int64)] + np.float32(0)
        # The smallest corner first, as bits: a set of three positions has one key.
        rows = np.ascontiguousarray(corners).view([("x", "f4"), ("y", "f4"), ("z", "f4")])
        rows = np.sort(rows.reshape(-1, 3), axis=1)
        keys = np.ascontiguousarray(rows).view("V36").reshape(-1)
        self.keys, first = np.unique(keys, return_index=True)
        self.corners = np.ascontiguousarray(corners[first].reshape(-1, 9), np.float64)
        self.count = len(self.keys)
        a, b, c = self.corners.reshape(-1, 3, 3).transpose(1, 0, 2)
        self.areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        self.area = math.fsum(self.areas)
        self.key = hashlib.sha256(self.keys.tobytes()).digest()
        self._tree = None

    @property
    def tree(self):
        if self._tree is None:
            self._tree = ctypes.c_void_p(LIBRARY.tree_new(numbers(self.corners), self.count))
        return self._tree

    def __del__(self):
        if self._tree is not None:
            LIBRARY.tree_free(self._tree)

    def distances(self, points):
        """Distances of points from the surface."""
        points = np.ascontiguousarray(points, np.float64)
        found = np.empty(len(points))
        LIBRARY.distances(self.tree, numbers(points), len(points), numbers(found))
        return found


def one_way(a, b, seed, floor=0.0):
    """Farthest distance of surface a from b (low, high) where it is more than a floor, mean square
    distance and its error."""
    own = np.ascontiguousarray(a.corners[~np.isin(a.keys, b.keys, assume_unique=True)])
    low, high, error = ctypes.c_double(floor), ctypes.c_double(), ctypes.c_double()
    if not len(own):
        return floor, floor, 0.0, 0.0
    LIBRARY.farthest(
        b.tree, numbers(own), len(own), ctypes.c_double(TOLERANCE), ctypes.c_int64(PIECES),
        ctypes.byref(low), ctypes.byref(high),
    )  # fmt: skip
    whole = LIBRARY.integral(
        b.tree, numbers(own), len(own), ctypes.c_double(WANTED), ctypes.c_int64(POINTS),
        ctypes.c_uint64(seed), ctypes.byref(error),
    )  # fmt: skip
    area = a.area or 1.0
    return low.value, high.value, whole / area, error.value / area


def measure(a, b, seed=1):
    """How far two surfaces are apart, the larger of both ways."""
    if not a.count or not b.count:
        far = 0.0 if a.count == b.count else math.inf
        return Measured(far, far, far, 0.0)
    there = one_way(a, b, seed)
    ways = [there, one_way(b, a, seed, there[0])]
    square, error = max((way[2], way[3]) for way in ways)
    spread = error / square / 2 if square else 0.0
    return Measured(*(max(way[k] for way in ways) for k in (0, 1)), math.sqrt(square), spread)
