"""The partial mesh: corner lists, stars, links and splits (docs/STREAM.md, section 5)."""


class Star:
    """The triangles around a vertex as it sees them, and its link.

    ``faces`` are (triangle, a, b); ``fans`` (first, last, closed); ``link`` (vertex, index of the
    triangle at its outgoing link edge, of that at its incoming one; −1 for none).
    """

    def __init__(self, mesh, vertex):
        self.faces = []
        for t in mesh.corners[vertex]:
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
        self.corners[parent] = side("left") + kept + side("right")
        self.corners[new] = moved + list(numbers)
        for t, (kind, after, before, outgoing, incoming) in zip(numbers, triangles):
            if kind == "detached":
                self.corners[after].append(t)
                self.corners[before].append(t)
                continue
            corners = self.corners[after if kind == "left" else before]
            if outgoing >= 0:
                corners.insert(corners.index(star.faces[outgoing][0]) + 1, t)
            elif incoming >= 0:
                corners.insert(corners.index(star.faces[incoming][0]), t)
            else:
                corners.append(t)


def _rotated(faces, transfer):
    """The order of the star in which what is kept and what is transferred are one run each."""
    n = len(faces)
    if n < 2 or faces[-1][2] != faces[0][1] or all(transfer) or not any(transfer):
        return list(range(n))
    start = n
    while transfer[start - 1] == transfer[0]:
        start -= 1
    return [*range(start, n), *range(start)]
