"""Points: the vertices before the first triangle, which come when a split needs them
(docs/STREAM.md, section 4)."""

from ..errors import need
from .batches import Groups
from .values import code_values


class Points:
    """The points of one object: those that have come, and those that are only announced.

    ``child`` is the last point that came with a missing one as its parent; ``group`` the first and
    the end of its wedge group, if known; ``last_wedge`` by the first point of a group the one of it
    that came last.
    """

    def __init__(self, count=0):
        self.missing, self.left = [True] * count, count
        self.child, self.group = [None] * count, [None] * count
        self.last_wedge, self.last = {}, None

    def is_missing(self, vertex):
        return vertex < len(self.missing) and self.missing[vertex]

    def is_free(self, vertex):
        return vertex < len(self.group) and self.group[vertex] is None

    def is_further_wedge(self, vertex):
        group = self.group[vertex] if vertex < len(self.group) else None
        return group is not None and group[0] < vertex

    def come(self, point, parent):
        self.missing[point] = False
        self.left -= 1
        self.last_wedge[self.group[point][0]] = self.last = point
        if self.is_missing(parent):
            self.child[parent] = point


def absolute(coder, contexts, channels):
    """The indices of a vertex without a reference."""
    folded = [coder.gamma(contexts.first_index) for _ in range(channels)]
    return [-1 - u // 2 if u & 1 else u // 2 for u in folded]


def announce(obj, coder, contexts):
    """The number of points and, in an exact order, the parent of the first vertex behind them."""
    vertices, channels = obj.header.vertices, obj.header.layout.channels
    count = coder.gamma(contexts.point_count) + 1
    need(count <= vertices, obj.place, "has more vertices than its header says")
    need(
        count * (channels + 8) <= (1 << 20) + 1024 * obj.used,
        obj.place,
        "expands more than any real stream",
    )
    obj.error_code = obj.rms_code = 0xFFF
    obj.points = Points(count)
    for _ in range(count):
        obj.mesh.add_vertex(0)
    obj.targets, obj.continues = [0] * count, [False] * count
    obj.indices = [[0] * channels for _ in range(count)]
    obj.groups = None if obj.header.exact else Groups(count)
    if obj.header.exact and count < vertices:
        obj.next_parent = coder.bounded(contexts.parent, count)


def bring(obj, coder, contexts, point, alone):
    """A point that is missing and, unless it comes alone, those of its group that are."""
    points = obj.points
    if points.is_free(point):
        _group(obj, coder, contexts, point)
    for v in [point] if alone else range(*points.group[point]):
        if points.missing[v]:
            _point(obj, coder, contexts, v)


def _point(obj, coder, contexts, point):
    mesh, points, header = obj.mesh, obj.points, obj.header
    wedge = points.last_wedge.get(points.group[point][0])
    parent = obj.targets[point] = _parent(obj, coder, contexts, point, wedge)
    reference = _reference(obj, point, parent, wedge)
    submeshes = len(header.streams)
    if submeshes > 1:
        same = reference is not None and coder.bit(contexts.point_submesh)
        mesh.submesh[point] = mesh.submesh[reference] if same else coder.uniform(submeshes)
    if reference is None:
        obj.indices[point] = absolute(coder, contexts, header.layout.channels)
    else:
        values, siblings = contexts.point_values, [] if wedge is None else [wedge]
        obj.indices[point] = code_values(
            coder, values, header.layout, obj.indices, reference, siblings, [], (reference,) * 2
        )
    points.come(point, parent)


def _group(obj, coder, contexts, point):
    """The wedge group of a point."""
    mesh, points = obj.mesh, obj.points
    first, end = point, point + 1
    while first and points.is_free(first - 1) and coder.bit(contexts.point_wedge[0]):
        first -= 1
    while points.is_free(end) and coder.bit(contexts.point_wedge[1]):
        end += 1
    if first:
        obj.continues[first - 1] = coder.bit(contexts.point_continues)
    for v in range(first, end):
        points.group[v] = first, end
        if v > first:
            obj.continues[v - 1] = True
            mesh.next_wedge[v], mesh.next_wedge[v - 1] = mesh.next_wedge[v - 1], v


def _parent(obj, coder, contexts, point, wedge):
    if point == 0:
        return 0
    if wedge is not None:
        distance = coder.gamma(contexts.point_next_parent)
        return (min(obj.targets[wedge], point - 1) + distance) % point
    start, end = obj.points.group[obj.points.last] if obj.points.last is not None else (0, 0)
    end = min(end, point)
    if start < end and coder.bit(contexts.point_in_last):
        return start + coder.uniform(end - start)
    return coder.gamma(contexts.point_parent) % point


def _reference(obj, point, parent, wedge):
    """The vertex from which a point is predicted; None for the first of all."""
    points = obj.points
    if wedge is not None and obj.targets[wedge] == parent:
        return wedge
    if points.child[point] is not None:
        return points.child[point]
    if not points.is_missing(parent):
        return parent
    return points.last if wedge is None else wedge
