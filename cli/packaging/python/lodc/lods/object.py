"""An object of a stream: its header and its steps (docs/STREAM.md, sections 4 and 8)."""

import struct

import numpy as np

from ..attribute import COMPONENTS, MEANINGS, Attribute, component
from ..cursor import Cursor
from ..errors import need
from ..level_object import LevelObject, Whole
from ..scene import Submesh
from .coder import Substream
from .mesh import LONG, PartialMesh, Star
from .numbers import Decimal, Float, Grid, Integer, Octahedral, Significant, directions, values
from .points import Points, announce, bring
from .values import Layout, code_values

MAX_TRIANGLES = 1 << 20


class Header:
    """What is known of an object before its first vertex."""

    def __init__(self, vertices, triangles, steps, exact, attributes, systems, streams):
        self.vertices, self.triangles, self.steps = vertices, triangles, steps
        self.exact, self.attributes, self.streams = exact, attributes, streams
        self.layout = Layout(attributes, systems)


def take_headers(cursor, codec):
    """The headers that a block begins with, decoded."""
    plain, coded = cursor.varint(1 << 24), cursor.varint(1 << 24)
    data = codec.decode(cursor.take(coded), plain)
    need(data is not None, cursor.place, "has headers that cannot be decoded")
    return Cursor(data, cursor.place)


def read_header(c):
    """The next one of the headers of a block."""
    vertices, triangles, steps, exact = (c.varint() for _ in range(4))
    need(exact < 2, c.place, "has an unknown order of steps")
    count = c.varint()
    systems, attributes = [_system(c, 3, True)], []
    for _ in range(count):
        attribute = _attribute(c)
        attributes.append(attribute)
        systems.append(_system(c, attribute.components, attribute.dtype.kind == "f", 3))
    streams, before, total = [], (), 0
    for _ in range(c.varint()):
        listed = c.varint()
        if listed:
            before = tuple(c.varint() for _ in range(listed - 1))
        total += len(before)
        need(total <= 1 << 22, c.place, "has too many streams of submeshes")
        streams.append(before)
    return Header(vertices, triangles, steps, bool(exact), attributes, systems, streams)


def _attribute(c):
    packed = c.varint((1 << 35) - 1)
    meaning, number = MEANINGS[packed % 8], packed // 8
    need(
        meaning not in ("position", "normal", "tangent") or not number,
        c.place,
        "has a set of what has none",
    )
    name = ""
    if meaning == "custom":
        name, number = bytes(c.take(number)).decode("utf-8"), 0
    target = c.varint()
    kind = c.u8()
    dtype = component(kind & 7, (kind >> 4) + 1, c.place)
    return Attribute(
        meaning,
        number,
        name,
        target - 1 if target else None,
        dtype,
        (kind >> 4) + 1,
        bool(kind & 8),
    )


def _system(c, channels, is_float, direction=None):
    """The systems of the channels of a stream. A direction of three components is two."""
    code = c.u8()
    if code == 3:
        bits, rest = c.u8(), channels - 3
        need(
            direction and is_float and rest >= 0 and 2 <= bits <= 24,
            c.place,
            "has a number system that does not fit its attribute",
        )
        return [Octahedral(bits)] * 2 + (_system(c, rest, True) if rest else [])
    need((code == 1) != is_float, c.place, "has a number system that does not fit its attribute")
    if code == 2:
        step = c.f32()
        need(step > 0, c.place, "has a grid without steps")
        return [Grid(c.f32(), step) for _ in range(channels)]
    if code == 0:
        system = Float()
    elif code == 1:
        system = Integer()
    elif 16 <= code <= 25:
        system = Decimal(code - 16)
    else:
        need(33 <= code <= 39, c.place, "has an unknown number system")
        system = Significant(code - 32)
    return [system] * channels


def _distance(code):
    """The distance of a code: its upper bits as a float."""
    return struct.unpack("<f", struct.pack("<I", code << 19 & 0xFFFFFFFF))[0]


class StreamObject:
    """One mesh as far as it has come.

    Vertices and triangles are numbered in stream order: vertex *a* is vertex *v* − 1 − *a* of the
    collapse order of a ``.lodc`` file. ``targets`` are the collapse targets, in that order.
    """

    def __init__(self, number, place):
        self.number, self.place, self.name = number, place, f"mesh{number}"
        self.world_scale, self.submeshes, self.document_mesh = 1.0, None, number
        self.header = None
        self.mesh, self.groups = PartialMesh(), None
        self.indices, self.targets, self.continues = [], [], []
        self.steps, self.error_code, self.rms_code = 0, 0, 0
        self.next_parent, self._parent, self._continued = 0, 0, False
        self.points, self.used = Points(), 0
        self._first_sibling = self._work = self._sides = 0

    def start(self, header):
        """Takes the header."""
        self.header = header
        names = self.submeshes
        if names is not None:
            need(
                len(names) == len(header.streams), self.place, "has other submeshes than its name"
            )
        self._list_submeshes()

    def name_as(self, name, scale, mesh, submeshes):
        """Takes what the text says of the object: its mesh in the document, and its submeshes."""
        if self.header is not None:
            need(
                len(submeshes) == len(self.header.streams),
                self.place,
                "has other submeshes in the text",
            )
        self.name, self.world_scale, self.document_mesh = name, scale, mesh
        self.submeshes = submeshes
        if self.header is not None:
            self._list_submeshes()

    def _list_submeshes(self):
        streams = self.header.streams
        named = self.submeshes or [Submesh("", None, i, ()) for i in range(len(streams))]
        self.submeshes = [
            Submesh(s.name, s.material, s.primitive, listed) for s, listed in zip(named, streams)
        ]

    @property
    def has_come(self):
        """Of each vertex so far whether its submesh and values are known. A point that no triangle
        has used yet may not have come: its values are index 0, its submesh is 0."""
        has_come = np.ones(len(self.mesh.corners), bool)
        has_come[: len(self.points.missing)] = np.logical_not(self.points.missing)
        return has_come

    @property
    def attributes(self):
        """Descriptions of the attributes."""
        return self.header.attributes if self.header else []

    @property
    def error(self):
        """The error of the mesh so far, in its units; at most 1/16 above the true one."""
        if not self.steps:
            return float("inf")
        error = _distance(self.error_code)
        return error if error == error else float("inf")

    @property
    def rms(self):
        """The root mean square distance of the mesh so far, as precise; None if there is none."""
        rms = _distance(self.rms_code)
        return rms if self.steps and rms == rms else None

    @property
    def triangles(self):
        """The triangles so far, *n* × 3."""
        return np.array(self.mesh.triangles, np.uint32).reshape(-1, 3)

    @property
    def triangle_submesh(self):
        """The submesh of each triangle."""
        return self.vertex_submesh[self.triangles[:, 0]]

    @property
    def vertex_submesh(self):
        """The submesh of each vertex so far."""
        return np.array(self.mesh.submesh, np.uint32)

    @property
    def positions(self):
        """Positions so far, *n* × 3."""
        return self._stream(0)

    def values(self, number):
        """The values of an attribute so far, *n* × components."""
        return self._stream(number + 1)

    def _stream(self, number):
        if self.header is None:
            return np.zeros((0, 3), np.float32)
        first, channels, _, systems = self.header.layout.streams[number]
        dtype = np.dtype("<f4") if number == 0 else self.header.attributes[number - 1].dtype
        all_indices = np.array(self.indices, np.int64).reshape(-1, self.header.layout.channels)
        columns, of = [], lambda c: all_indices[:, first + c]
        if isinstance(systems[0], Octahedral):
            columns = directions(systems[0], of(0), of(1))
        for c in range(2 if columns else 0, channels):
            columns.append(values(systems[c], of(c), dtype))
        return np.stack(columns, axis=1).astype(dtype)

    def level(self, upright: bool = False) -> LevelObject:
        """The mesh so far as a level; ``upright`` says that the source is no glTF."""
        values = [self.values(i) for i in range(len(self.attributes))]
        submeshes = self.submeshes or []
        whole = Whole(self.positions, self.attributes, values, submeshes, upright)
        distance = self.error, self.rms
        triangles = self.triangles
        submesh = self.triangle_submesh if len(triangles) else triangles[:, 0]
        return LevelObject(self.name, None, distance, whole, triangles, submesh)

    def is_complete(self):
        """Whether all that the header says has come."""
        h = self.header
        if h is None or self.points.left:
            return False
        counts = self.steps, len(self.mesh.corners), len(self.mesh.triangles)
        return counts == (h.steps, h.vertices, h.triangles)

    def read(self, payload, steps, contexts, each_step=None):
        """Decodes the steps of a block; calls ``each_step`` after each. ``used`` is set before: the
        bytes of the stream up to the end of the block."""
        need(0 < steps <= self.header.steps - self.steps, self.place, "has no steps, or too many")
        coder = Substream(payload)
        for _ in range(steps):
            self.step(coder, contexts, each_step)
        need(coder.is_finished(), self.place, "does not end with its steps")

    def step(self, coder, contexts, each_step=None):
        """Decodes a step."""
        need(self.steps < self.header.steps, self.place, "has too many steps")
        self._step(coder, contexts)
        need(not coder.is_exhausted(), self.place, "ends before its steps do")
        need(
            len(self.mesh.triangles) <= self.header.triangles,
            self.place,
            "has more triangles than its header says",
        )
        self.steps += 1
        if each_step:
            each_step(self)

    def is_between_batches(self):
        """Whether no batch has begun of which steps are still to come."""
        return self.header.exact or not (self.groups and self.groups.steps_left)

    def _step(self, coder, contexts):
        if not self.mesh.corners:
            announce(self, coder, contexts)
        if len(self.mesh.corners) == self.header.vertices and self.points.left:
            bring(self, coder, contexts, self.points.missing.index(True), alone=False)
        else:
            if self.groups and len(self.mesh.corners) < self.header.vertices:
                self._group(coder, contexts)
            self._vertices(coder, contexts)
            if self.groups and self.groups.steps_left:
                return
        if coder.bit(contexts.error_falls):
            self.error_code = self.error_code - coder.gamma(contexts.error_drop) & 0xFFFFFFFF
        if coder.bit(contexts.rms_falls):
            self.rms_code = self.rms_code - coder.gamma(contexts.rms_drop) & 0xFFFFFFFF

    def _group(self, coder, contexts):
        """The group that the next step splits off, and its parent."""
        groups, mesh = self.groups, self.mesh
        if groups.steps_left == 0:
            groups.begin(coder.gamma(contexts.batch) + 1)
        while True:
            self._work += 1
            group = groups.group
            need(
                group is not None, self.place, "has a batch of more steps than there are"
            )
            need(
                self._work <= (1 << 26) + (self.used << 16),
                self.place,
                "expands more than any real stream",
            )
            if not self.points.is_further_wedge(group):
                if coder.bit(groups.context(contexts, len(mesh.corners[group]))):
                    break
            groups.advance()
        groups.split()
        if self.points.is_missing(group):
            bring(self, coder, contexts, group, alone=not self.steps)
        self.next_parent = group
        if mesh.next_wedge[group] != group:
            self.next_parent = self._wedge_parent(coder, contexts, group)

    def _vertices(self, coder, contexts):
        while True:
            need(
                len(self.mesh.corners) < self.header.vertices,
                self.place,
                "has more vertices than its header says",
            )
            self._vertex(coder, contexts)
            self.continues.append(self._continued)
            if not self._continued:
                break

    def _vertex(self, coder, contexts):
        mesh, new, continued = self.mesh, len(self.mesh.corners), self._continued
        parent = self.next_parent
        if continued:
            parent = self._wedge_parent(coder, contexts, self._parent)
        if self.points.is_missing(parent):
            bring(self, coder, contexts, parent, alone=not self.steps)
        self._parent = parent
        submesh = mesh.submesh[parent]
        if len(self.header.streams) > 1 and not coder.bit(contexts.same_submesh):
            submesh = coder.uniform(len(self.header.streams))
        number = others = 0
        while number < 3 and number < new and self.continues[new - 1 - number]:
            number += 1
        wedge = mesh.next_wedge[parent]
        while others < 3 and wedge != parent:
            others, wedge = others + 1, mesh.next_wedge[wedge]
        self._sides = self._sides if continued else 0
        self._continued = coder.bit(contexts.continues[number if continued else 0][others])
        if self.header.exact and not self._continued and new + 1 < self.header.vertices:
            self.next_parent = (parent + coder.bounded(contexts.parent, new + 1)) % (new + 1)
        star = Star(mesh, parent, self._face_list(coder, contexts, parent))
        mesh.add_vertex(submesh)
        pattern, triangles = self._triangles(coder, contexts, star, parent, new, continued)
        for t in triangles:
            self._sides |= {"left": 1, "right": 2, "detached": 0}[t[0]]
        for corner in [v for t in triangles for v in t[1:3]]:
            if self.points.is_missing(corner):
                bring(self, coder, contexts, corner, alone=not self.steps)
        transfer = self._transfer(coder, contexts, star, pattern, triangles)
        first, target = len(mesh.triangles), self.targets[parent]
        mesh.split(parent, new, star, transfer, triangles)
        may_repeat = not any(transfer) and len(mesh.corners[target]) > LONG
        repeats = may_repeat and coder.bit(contexts.repeats_target)
        self.targets.append(target if repeats else parent)
        for t in mesh.triangles[first:]:
            need(len(set(t)) == 3, self.place, "adds a triangle without area")
            need(
                {mesh.submesh[v] for v in t} == {submesh},
                self.place,
                "adds a triangle over two submeshes",
            )
        if continued and coder.bit(contexts.same_position):
            wedge = new - 1
            mesh.next_wedge[new], mesh.next_wedge[wedge] = mesh.next_wedge[wedge], new
        else:
            self._first_sibling = new
        if self.groups:
            self.groups.add_vertex(self._first_sibling == new)
        link = [v for v, _, _ in Star(mesh, new).link]
        siblings = range(self._first_sibling, new)
        lefts = [t[1] for t in triangles if t[0] == "left"] or [parent]
        rights = [t[2] for t in triangles if t[0] == "right"] or [parent]
        cut, values = (lefts[0], rights[0]), contexts.values
        self.indices.append(
            code_values(
                coder, values, self.header.layout, self.indices, parent, siblings, link, cut
            )
        )

    def _face_list(self, coder, contexts, parent):
        """The triangles that are transferred if they are named, else None."""
        size, triangles = len(self.mesh.corners[parent]), self.mesh.triangles
        if size <= LONG or not coder.bit(contexts.is_named):
            return None
        count = coder.gamma(contexts.named)
        need(count <= size, self.place, "names more triangles than a star has")
        named = [coder.uniform(len(triangles)) for _ in range(count)]
        need(len(set(named)) == count, self.place, "names a triangle twice")
        is_there = all(parent in triangles[t] for t in named)
        need(is_there, self.place, "names a triangle of another star")
        return named

    def _wedge_parent(self, coder, contexts, before):
        count = len(self.mesh.corners)
        distance = coder.symbol(contexts.wedge_distance[not self._continued])
        if distance >= 8:
            return (before + coder.bounded(contexts.parent, count)) % count
        for _ in range(distance):
            before = self.mesh.next_wedge[before]
        return before

    def _triangles(self, coder, contexts, star, parent, new, continued):
        """The pattern and the new triangles: side, next, previous, and the triangles of the star at
        the apex's outgoing and incoming link edges (−1 for none)."""
        link, closed = star.link, star.is_closed()
        before = 1 + self._sides if continued else 0
        pattern = coder.symbol(contexts.pattern[min(len(star.faces), 3)][closed][before])
        first_left = None
        triangles = []

        def place(relative):
            origin = 0 if not relative else 2 if closed else 1
            if len(link) > 16:
                coded = coder.uniform(len(link))
            else:
                need(link, self.place, "names a corner of an empty link")
                coded = coder.symbol(contexts.place[origin][len(link)])
            need(coded < len(link), self.place, "names a corner beyond the link")
            return (coded + first_left) % len(link) if relative else coded

        def corner(may_be_elsewhere, relative):
            if may_be_elsewhere and not (link and coder.bit(contexts.in_link[min(len(link), 3)])):
                return coder.uniform(new + 1), -1, -1, None
            at = place(relative)
            return *link[at], at

        def add(side, may_be_elsewhere):
            nonlocal first_left
            relative = side == "right" and first_left is not None
            vertex, outgoing, incoming, at = corner(may_be_elsewhere, relative)
            if side == "left":
                if first_left is None:
                    first_left = at
                triangles.append((side, vertex, parent, outgoing, incoming))
            elif side == "right":
                triangles.append((side, parent, vertex, outgoing, incoming))
            else:
                before = corner(True, False)[0]
                triangles.append((side, vertex, before, -1, -1))

        if pattern < 4:
            for side in (("left", "right"), ("left",), ("right",), ())[pattern]:
                add(side, False)
            return pattern, triangles
        count = coder.symbol(contexts.count[continued])
        if count == 15:
            count += coder.gamma(contexts.more)
        need(count <= MAX_TRIANGLES, self.place, "adds too many triangles at once")
        before = 3
        for i in range(count):
            number = min(i, 2)
            if coder.bit(contexts.detached[number][before]):
                side, before = "detached", 2
            elif coder.bit(contexts.left[number][before]):
                side, before = "left", 0
            else:
                side, before = "right", 1
            add(side, True)
        return pattern, triangles

    def _transfer(self, coder, contexts, star, pattern, triangles):
        """For each triangle of the star whether it goes to the new vertex."""
        if pattern == 3 or star.is_named:
            return [True] * len(star.faces)
        expected = [0] * len(star.faces)  # bits: 1 kept, 2 transferred
        for side, _, _, outgoing, incoming in triangles:
            for at, says in ((outgoing, 1), (incoming, 2)):
                if at >= 0 and side != "detached":
                    expected[at] |= says if side == "left" else 3 - says
        for first, last, closed in star.fans:
            before = expected[last] if closed else 0
            for _ in range(2 if closed else 1):
                for i in range(first, last + 1):
                    expected[i] = before = expected[i] or before
            for i in range(last - 1, first - 1, -1):
                expected[i] = expected[i] or expected[i + 1]
        if pattern < 3:
            need(
                all(e in (1, 2) for e in expected), self.place, "does not say what is transferred"
            )
            return [e == 2 for e in expected]
        transfer, before = [], 0
        for e in expected:
            moves = coder.bit(contexts.transferred[e][before])
            transfer.append(moves)
            before = 2 if moves else 1
        return transfer
