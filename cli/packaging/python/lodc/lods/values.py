"""Values of new vertices: prediction and residuals (docs/STREAM.md, section 6)."""

import math

from .numbers import Decimal, Grid, Integer, Octahedral, nearest, to_f32

PARENT, CUT, NEAR, RIDGE = 0.2, 0.16, 0.05, 0.02
MOST_SOURCES = 15


def wrap(index):
    """An i32."""
    return (index + (1 << 31) & 0xFFFFFFFF) - (1 << 31)


class Layout:
    """The streams of a vertex: of each its first channel, channels, prediction and systems."""

    def __init__(self, attributes, systems):
        self.streams, first = [], 0
        kinds = ["smooth"] + [
            "octahedral" if isinstance(of[0], Octahedral) else _prediction(a)
            for a, of in zip(attributes, systems[1:])
        ]
        for prediction, of in zip(kinds, systems):
            self.streams.append((first, len(of), prediction, of))
            first += len(of)
        self.channels = first
        self.is_linear = isinstance(systems[0][0], (Decimal, Grid))


def _prediction(attribute):
    if attribute.meaning in ("joints", "weights", "custom"):
        return "parent"
    if attribute.morph_target is not None:
        return "smooth"
    direction = attribute.meaning in ("normal", "tangent") and attribute.dtype.kind == "f"
    if direction and attribute.components >= 3:
        return "direction"
    return "fit" if attribute.meaning == "texcoord" else "smooth"


def code_values(coder, contexts, layout, indices, parent, siblings, link, cut):
    """Decodes the indices of a vertex. ``indices`` has those of all vertices before; ``siblings``
    are wedges that came before it, ``cut`` the apexes of the first left and right triangle."""
    vertex = _Vertex(coder, contexts, layout, indices, parent, siblings, link)
    out = list(indices[siblings[-1]][:3]) if siblings else vertex.position(cut)
    for s in range(1, len(layout.streams)):
        out += vertex.attribute(s, out)
    return out


def _index(system, even, at, parent):
    """The index nearest to a number: an index itself if even, else a value."""
    if even:
        return nearest(at)
    value = to_f32(at)
    return system.index(value) if math.isfinite(value) else parent


class _Vertex:
    """A vertex while its values are decoded."""

    def __init__(self, coder, contexts, layout, indices, parent, siblings, link):
        self.coder, self.contexts, self.layout, self.indices = coder, contexts, layout, indices
        self.parent, self.siblings, self.link = parent, siblings, link
        self.sibling, self.before = None, 4

    def residual(self, slot, channel, accuracy, guess, spread):
        """An index by its prediction, and the accuracy of that."""
        c, channel, half = self.contexts, min(channel, 3), 0
        if spread is None:
            expected = (c.mean_bits[slot][channel] + 8) // 16
        else:
            expected = spread.bit_length()
            half = spread >> expected - 2 & 1 if expected > 1 else 0
        context = c.residual[slot][channel][accuracy][half]
        residual, length = self.coder.residual(context, min(expected, 32))
        c.mean_bits[slot][channel] = (15 * c.mean_bits[slot][channel] + 16 * length + 8) // 16
        return wrap(guess + residual), 0 if length + 2 < expected else 1 if length < expected else 2

    def position(self, cut):
        layout, link, systems = self.layout, self.link, self.layout.streams[0][3]
        parent = self.indices[self.parent][:3]
        if not link:
            out, accuracy = [], 0
            for c in range(3):
                index, accuracy = self.residual(0, c, accuracy, parent[c], None)
                out.append(index)
            return out
        left, right = (self.indices[v][:3] for v in cut)
        means, at, guesses, spreads, sides = [], [], [], [], []
        for c, system in enumerate(systems):
            around = [self.indices[v][c] for v in link]
            least, most = min(around), max(around)
            p, l, r = parent[c], left[c], right[c]
            even = system.is_even(min(least, p, l, r), max(most, p, l, r))
            real = float if even else system.value
            total = float(sum(around)) if even else _total(map(real, around))
            mean = total / len(link)
            middle = (real(l) + real(r)) / 2.0
            x = mean + PARENT * (real(p) - mean) - CUT * (middle - mean)
            means.append(mean)
            at.append(x)
            guesses.append((_index(system, even, mean, p), _index(system, even, x, p)))
            sides.append(most - least)
            spreads.append(most - least if len(link) > 1 else None)
        plane = None
        if layout.is_linear and len(link) > 1:
            edge = [float(left[c]) - float(right[c]) for c in range(3)]
            plane = _Plane(edge, [means[c] - float(parent[c]) for c in range(3)], sides)
        bits = self.contexts.mode_bits
        mode = 2 if bits[2] <= min(bits[0], bits[1]) else 1 if bits[1] <= bits[0] else 0
        out, accuracy = [0] * 3, 0
        if mode == 2 and plane:
            for channel, axis in enumerate(plane.axes):
                guess = plane.guess(at, out) if channel == 2 else guesses[axis][1]
                out[axis], accuracy = self.residual(8, channel, accuracy, guess, plane.spread)
        else:
            for axis in range(3):
                guess = guesses[axis][min(mode, 1)]
                out[axis], accuracy = self.residual(0, axis, accuracy, guess, spreads[axis])
        if len(link) > 1:
            ways = [[g[0] for g in guesses], [g[1] for g in guesses], [g[1] for g in guesses]]
            if plane:
                ways[2][plane.axes[2]] = plane.guess(at, out)
            for way, guess in enumerate(ways):
                length = sum(abs(out[c] - guess[c]).bit_length() for c in range(3))
                bits[way] = (bits[way] * 63 + length * 64 + 32) // 64
        return out

    def attribute(self, s, position):
        c, (first, channels, _, _) = self.contexts, self.layout.streams[s]
        slot = s if s < 8 else 0
        siblings, parents, sources = self.sources(first, channels)
        available = (siblings > 0) + 2 * (parents < len(sources))
        context = c.source[slot][available][c.last_source[slot]][self.before]
        source = min(self.coder.symbol(context), 3)
        c.last_source[slot] = self.before = source
        begin, end = ((0, siblings), (siblings, parents), (parents, len(sources)), (0, 0))[source]
        if begin == end:
            return self.coded(s, slot, position)
        at = begin
        if end - begin > 1:
            which = self.coder.symbol(c.which[source // 2][min(end - begin - 1, 7)])
            at += min(which, end - begin - 1)
        vertex, value = sources[at]
        if source == 0:
            self.sibling = vertex
        return list(value)

    def sources(self, first, channels):
        """Vertices with different values: siblings, parent, link; where the first two end."""
        out = []

        def add(v, most):
            value = self.indices[v][first : first + channels]
            if len(out) < most and all(value != other for _, other in out):
                out.append((v, value))

        latest = list(self.siblings)[::-1][:MOST_SOURCES]
        for v in latest if self.sibling is None else [self.sibling, *latest]:
            add(v, MOST_SOURCES)
        siblings = len(out)
        add(self.parent, MOST_SOURCES + 1)
        parents = len(out)
        for v in self.link[:MOST_SOURCES]:
            add(v, 1 << 32)
        return siblings, parents, out

    def coded(self, s, slot, position):
        first, channels, prediction, systems = self.layout.streams[s]
        guesses = self.guesses(s, position)
        out, accuracy = [], 0
        for channel in range(channels):
            guess, spread = guesses[channel]
            if prediction == "direction" and channel == 2 and self.link:
                x, y = systems[0].value(out[0]), systems[1].value(out[1])
                square = 1.0 - x * x - y * y
                if square >= 0:
                    root = math.sqrt(square)
                    system = systems[2]
                    signed = -root if system.value(guess) < 0 else root
                    guess, spread = _index(system, False, signed, guess), None
            index, accuracy = self.residual(slot, channel, accuracy, guess, spread)
            out.append(index)
        return out

    def guesses(self, s, position):
        first, channels, prediction, systems = self.layout.streams[s]
        if prediction == "parent" or not self.link:
            return [(i, None) for i in self.indices[self.parent][first : first + channels]]
        if prediction == "fit":
            offsets = self.offsets(position)
            fit = lambda values: _affine(offsets, values)
            return [self.fitted(first + c, systems[c], fit) for c in range(channels)]
        mean = lambda values: _total(values) / len(values)
        out = [self.fitted(first + c, systems[c], mean) for c in range(channels)]
        if prediction == "octahedral":
            total = [0.0] * 3
            for w, v in zip(_weights(self.offsets(position)), self.link):
                direction = systems[0].direction(*self.indices[v][first : first + 2])
                total = [t + w * d for t, d in zip(total, direction)]
            for c, index in enumerate(systems[0].indices(*total)):
                out[c] = index, out[c][1]
        return out

    def offsets(self, position):
        """Where the vertices of the link are from here."""
        systems = self.layout.streams[0][3]
        real = lambda c, i: float(i) if self.layout.is_linear else systems[c].value(i)
        here = [real(c, position[c]) for c in range(3)]
        return [[real(c, self.indices[v][c]) - here[c] for c in range(3)] for v in self.link]

    def fitted(self, channel, system, fit):
        around = [self.indices[v][channel] for v in self.link]
        least, most = min(around), max(around)
        even = system.is_even(least, most)
        at = fit([float(i) if even else system.value(i) for i in around])
        index = _index(system, even, at, self.indices[self.parent][channel])
        return index, most - least if len(around) > 1 else None


class _Plane:
    """The plane of the ring and the cut."""

    def __init__(self, edge, out, sides):
        cross = lambda i, j: edge[i] * out[j] - edge[j] * out[i]
        normal = [cross(1, 2), cross(2, 0), cross(0, 1)]
        last = max(range(3), key=lambda i: abs(normal[i]))
        self.axes = [(last + 1) % 3, (last + 2) % 3, last]
        slope = lambda i: min(max(-normal[i] / normal[last], -1.0), 1.0) if normal[last] else 0.0
        self.slopes = [slope(i) for i in self.axes[:2]]
        x, y, z = map(float, sides)
        self.spread = min(int(math.sqrt(x * x + y * y + z * z) / 2.0), 0xFFFFFFFF)

    def guess(self, at, out):
        first, second, last = self.axes
        off = lambda i: float(out[i]) - at[i]
        return nearest(at[last] + self.slopes[0] * off(first) + self.slopes[1] * off(second))


def _total(numbers):
    """A sum from the first to the last: `sum` may compensate."""
    total = 0.0
    for number in numbers:
        total += number
    return total


def _weights(offsets):
    lengths = [math.sqrt(x * x + y * y + z * z) for x, y, z in offsets]
    mean = _total(lengths) / len(lengths)
    return [1.0 / (d + NEAR * mean) if mean > 0 else 1.0 for d in lengths]


def _affine(offsets, values):
    """The value here of a linear function fitted to those around."""
    weights = _weights(offsets)
    if len(offsets) >= 4:
        rows = [[0.0] * 5 for _ in range(4)]
        for w, (x, y, z), value in zip(weights, offsets, values):
            terms = (1.0, x, y, z, value)
            for i in range(4):
                for j in range(i, 5):
                    rows[i][j] += w * w * terms[i] * terms[j]
        ridge = RIDGE * (rows[1][1] + rows[2][2] + rows[3][3])
        for i in (1, 2, 3):
            rows[i][i] += ridge
        first = _first(rows)
        if first is not None:
            return first
    return _total(w * v for w, v in zip(weights, values)) / _total(weights)


def _first(rows):
    """The first unknown of four symmetric equations; None if they are singular."""
    for k in (3, 2, 1):
        pivot = rows[k]
        if not pivot[k] > 0:
            return None
        for i in range(k):
            factor = rows[i][k] / pivot[k]
            for j in range(i, k):
                rows[i][j] -= factor * rows[j][k]
            rows[i][4] -= factor * pivot[4]
    if rows[0][0] == 0:
        return None
    first = rows[0][4] / rows[0][0]
    return first if math.isfinite(first) else None
