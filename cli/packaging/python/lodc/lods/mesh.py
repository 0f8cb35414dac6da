"""The partial mesh: corner lists, stars, links and splits (docs/STREAM.md, section 5)."""


class Star:
    """The triangles around a vertex as it sees them, and its link.

    ``faces`` are (triangle, a, b); ``fans`` (first, last, closed); ``link`` (vertex, index of the
    triangle at its outgoing link edge, of that at its incoming one; −1 for none). A star that
    ``is_named`` has only these triangles, all of which are transferred.
    """

    def __init__(self, mesh, vertex, named=None):
        self.faces, self.is_named = [], named is not None
        for t in named if self.is_named else mesh.corners[vertex]:
            x, y, z = mesh.triangles[t]
            self.faces.append(
                (t, y, z) if x == vertex else (t, z, x) if y == vertex else (t, x, y)
            )
        self.fans, self.link = [], []
        faces, first = self.faces, 0
        for i, (_, a, b) in enumerate(faces):
            self.link.append((a, i, i - 1 if i > first else -1))
            if i + 1 < len(faces) and faces[i + 1][1] == b:
                continue
            closed = b == faces[first][1]
            if closed:
                at = len(self.link) - 1 - (i - first)
                self.link[at] = (self.link[at][0], first, i)
            else:
                self.link.append((b, -1, i))
            self.fans.append((first, i, closed))
            first = i + 1

    def is_closed(self):
        """Whether the star is one closed fan."""
        return len(self.fans) == 1 and self.fans[0][2]


LONG = 256


class LinkedCorners:
    """A long list of corners, linked both ways: any of them leaves or gets a neighbour at once.

    None is before the first and after the last.
    """

    def __init__(self, corners):
        ring = [None, *corners]
        self.after = dict(zip(ring, [*ring[1:], None]))
        self.before = {after: before for before, after in self.after.items()}

    def __len__(self):
        return len(self.after) - 1

    def __iter__(self):
        t = self.after[None]
        while t is not None:
            yield t
            t = self.after[t]

    def insert(self, t, beside, is_after):
        """Puts one after or before another one."""
        before = beside if is_after else self.before[beside]
        self._link(before, t, self.after[before])

    def take_out(self, t):
        self._link(self.before.pop(t), self.after.pop(t))

    def _link(self, *corners):
        for a, b in zip(corners, corners[1:]):
            self.after[a], self.before[b] = b, a


class PartialMesh:
    """The mesh of one object so far."""

    def __init__(self):
        self.triangles, self.corners, self.submesh, self.next_wedge = [], [], [], []

    def add_vertex(self, submesh):
        self.next_wedge.append(len(self.corners))
        self.corners.append([])
        self.submesh.append(submesh)

    def split(self, parent, new, star, transfer, triangles):
        """Transfers triangles, adds the new ones, updates corner lists. Of each new triangle:
        side, corner next, corner previous, triangles of the star at its apex's link edges."""
        order = _rotated(star.faces, transfer)
        kept = [star.faces[i][0] for i in order if not transfer[i]]
        moved = [star.faces[i][0] for i in order if transfer[i]]
        for t in moved:
            self.triangles[t] = tuple(new if v == parent else v for v in self.triangles[t])
        first = len(self.triangles)
        numbers = range(first, first + len(triangles))
        self.triangles += [(new, after, before) for _, after, before, _, _ in triangles]
        side = lambda wanted: [t for t, x in zip(numbers, triangles) if x[0] == wanted]
        if star.is_named:
            corners = self._long(parent)
            for t in moved:
                corners.take_out(t)
            for t in reversed(side("left")):
                corners.insert(t, None, True)
            for t in side("right"):
                corners.insert(t, None, False)
        else:
            self.corners[parent] = side("left") + kept + side("right")
        self.corners[new] = moved + list(numbers)
        for t, (kind, after, before, outgoing, incoming) in zip(numbers, triangles):
            if kind == "detached":
                self._insert(after, t)
                self._insert(before, t)
                continue
            beside = outgoing if outgoing >= 0 else incoming
            beside = star.faces[beside][0] if beside >= 0 else None
            self._insert(after if kind == "left" else before, t, beside, outgoing >= 0)

    def _long(self, vertex):
        """The corners of a vertex, linked."""
        if isinstance(self.corners[vertex], list):
            self.corners[vertex] = LinkedCorners(self.corners[vertex])
        return self.corners[vertex]

    def _insert(self, vertex, t, beside=None, is_after=False):
        """Puts a corner after or before that of another triangle, or at the end."""
        corners = self.corners[vertex]
        if len(corners) > LONG or not isinstance(corners, list):
            self._long(vertex).insert(t, beside, is_after)
        elif beside is None:
            corners.append(t)
        else:
            corners.insert(corners.index(beside) + is_after, t)


def _rotated(faces, transfer):
    """The order of the star in which what is kept and what is transferred are one run each."""
    n = len(faces)
    if n < 2 or faces[-1][2] != faces[0][1] or all(transfer) or not any(transfer):
        return list(range(n))
    start = n
    while transfer[start - 1] == transfer[0]:
        start -= 1
    return [*range(start, n), *range(start)]
