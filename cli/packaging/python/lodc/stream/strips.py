"""Strip positions and strips as indices (docs/STREAM.md, section 7)."""

from ..errors import need


class StripOrder:
    """The drawing order of the triangles so far, cut into strips. None stands for no triangle."""

    def __init__(self):
        self.next, self.previous, self.strip, self.ends = {None: None}, {}, [], []

    def share(self, a, b):
        return a is not None and b is not None and self.strip[a] == self.strip[b]

    def insert(self, after, strip):
        t = len(self.strip)
        before = self.next[after]
        self.next[t], self.next[after], self.previous[t] = before, t, after
        self.strip.append(strip)
        if before is not None:
            self.previous[before] = t
        if strip == len(self.ends):
            self.ends.append([t, t])
        elif self.ends[strip][1] == after:
            self.ends[strip][1] = t
        elif self.ends[strip][0] == before:
            self.ends[strip][0] = t

    def code(self, coder, contexts, candidates, place):
        """Decodes the position of the next triangle and inserts it."""
        found = self._candidate(coder, contexts, candidates)
        self.insert(*(found or self._other(coder, contexts, candidates, place)))

    def _candidate(self, coder, contexts, candidates):
        a, b, _ = candidates
        excluded = None
        if self.share(a, b) and (self.next[a] == b or self.next[b] == a):
            excluded = a if self.next[a] == b else b
            if coder.bit(contexts.between):
                return excluded, self.strip[excluded]
        for i, t in enumerate(candidates):
            if t is None:
                continue
            another = any(c != t and self.share(t, c) for c in candidates)
            for side, after in enumerate((t, self.previous[t])):
                inside = self.share(after, self.next[after])
                if inside and after == excluded:
                    continue
                if coder.bit(contexts.beside[i][side][inside][another]):
                    return after, self.strip[t]
        return None

    def _other(self, coder, contexts, candidates, place):
        there = [(i, t) for i, t in enumerate(candidates) if t is not None]
        new = len(self.ends)
        if coder.bit(contexts.new_strip[len(there)]):
            for i, t in there:
                first, last = self.ends[self.strip[t]]
                for side, after in enumerate((last, self.previous[first])):
                    if coder.bit(contexts.beside_strip[i][side]):
                        return after, new
            strip = coder.uniform(new + 1)
            return (None if strip == 0 else self.ends[strip - 1][1]), new
        need(self.strip, place, "adds a triangle to a strip before there is one")
        number = coder.uniform(len(self.strip) + 1)
        after = number - 1 if number else None
        before = self.next[after]
        if self.share(after, before):
            return after, self.strip[after]
        beside = before if coder.bit(contexts.second) else after
        need(beside is not None, place, "adds a triangle to a strip that does not exist")
        return after, self.strip[beside]

    def strips(self):
        """The triangles of each strip, in drawing order, by the order in which strips are drawn."""
        drawn, t = [], self.next[None]
        while t is not None:
            if not drawn or not self.share(drawn[-1][-1], t):
                drawn.append([])
            drawn[-1].append(t)
            t = self.next[t]
        return drawn


def indices(triangles):
    """Strips of vertices that draw a list of triangles one after the other: mostly one strip.

    Chooses how the strip pivots so that the fewest pivots are repeated.
    """
    strips, i = [], 0
    while i < len(triangles):
        strip, used = _strip(triangles[i:])
        strips.append(strip)
        i += used
    return strips


def _shared(one, two):
    """The pairs (f, g): an edge of ``one`` from corner f that ``two`` has reversed, opposite its
    corner g."""
    return [
        (f, g)
        for f in range(3)
        for g in range(3)
        if one[f] == two[(g + 2) % 3] and one[(f + 1) % 3] == two[(g + 1) % 3]
    ]


def _pivot(triangle, g, f):
    """The vertex that the edge into a triangle, opposite corner g, and the edge out of it, from
    corner f, have in common; None if they are one edge."""
    turn = (f - g) % 3
    return triangle[(f + 1) % 3] if turn == 0 else triangle[f] if turn == 2 else None


def _strip(triangles):
    """The longest strip from the first triangle on, and how many triangles it draws."""
    # For each pair of triangles the ways to each edge that they share: f, g, repeated pivots so
    # far, the last pivot, the number of the way before.
    ways = []
    for one, two in zip(triangles, triangles[1:]):
        extended = []
        for f, g in _shared(one, two):
            if not ways:
                extended.append((f, g, 0, one[f], 0))
                continue
            best = None
            for number, (_, entered, repeats, last, _) in enumerate(ways[-1]):
                pivot = _pivot(one, entered, f)
                if pivot is not None and (best is None or repeats + (pivot == last) < best[2]):
                    best = (f, g, repeats + (pivot == last), pivot, number)
            if best:
                extended.append(best)
        if not extended:
            break
        ways.append(extended)
    if not ways:
        return list(triangles[0]), 1
    number = min(range(len(ways[-1])), key=lambda i: ways[-1][i][2])
    path = []
    for extended in reversed(ways):
        path.append(extended[number])
        number = extended[number][4]
    path.reverse()
    first, f = triangles[0], path[0][0]
    strip = [first[(f + 2) % 3], first[f], first[(f + 1) % 3]]
    for i, way in enumerate(path):
        if i + 1 < len(path) and path[i + 1][3] == way[3]:
            strip.append(way[3])
        strip.append(triangles[i + 1][way[1]])
    return strip, len(path) + 1
