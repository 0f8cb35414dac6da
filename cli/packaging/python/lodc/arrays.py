"""Arrays of sections: indices, curves, variable-length numbers."""

import numpy as np

from .errors import need


def read_indices(data, vertices, wide, place):
    """Indices of the fewest bytes that hold the last vertex, or of four."""
    width = 4 if wide else index_bytes(vertices)
    data = np.frombuffer(data, "u1")
    need(len(data) % width == 0, place, "has indices that are no whole number")
    data = data.reshape(-1, width).astype(np.uint32)
    shifts = 8 * np.arange(width, dtype=np.uint32)
    return (data << shifts).sum(axis=1, dtype=np.uint32)


def index_bytes(vertices):
    """The bytes of an index."""
    return next(n for n in (1, 2, 3, 4) if max(vertices, 1) - 1 < 1 << 8 * n)


def varints(data, place):
    """All numbers of seven bits a byte, and where each ends."""
    data = np.frombuffer(data, "u1")
    ends = np.flatnonzero(data < 128)
    need(not len(data) or data[-1] < 128, place, "ends within a number")
    starts = np.concatenate(([0], ends[:-1] + 1)) if len(ends) else ends
    need(not len(ends) or (ends - starts).max() < 10, place, "has a number that is too long")
    need(not ((data[ends] == 0) & (ends > starts)).any(), place, "has a number with spare bytes")
    numbers = np.zeros(len(ends), np.uint64)
    for i in range(int((ends - starts).max()) + 1 if len(ends) else 0):
        has = starts + i <= ends
        part = (data[starts[has] + i] & 127).astype(np.uint64) << np.uint64(7 * i)
        numbers[has] |= part
    return numbers, ends + 1


def curve(data, steps, place):
    """A curve: one f32 for each step, each the bits of the one before and a difference."""
    differences, _ = varints(data, place)
    need(len(differences) == steps, place, "does not have one value for each step")
    need((differences < 1 << 32).all(), place, "has a step that is too large")
    bits = np.cumsum(differences, dtype=np.uint64)
    need(not len(bits) or bits[-1] <= 0x7F800000, place, "rises beyond infinity")
    return bits.astype(np.uint32).view(np.float32)


def lost_triangles(data, steps, place):
    """Triangles that die in each step."""
    need(len(data) >= steps, place, "does not have one number for each step")
    lost = np.frombuffer(data, "u1", count=steps).astype(np.int64)
    large = np.flatnonzero(lost == 255)
    need(len(data) == steps + 4 * len(large), place, "has another number of large numbers")
    if len(large):
        lost[large] = np.frombuffer(data, "<u4", offset=steps)
        need((lost[large] >= 255).all(), place, "has a small number among the large ones")
    return lost
