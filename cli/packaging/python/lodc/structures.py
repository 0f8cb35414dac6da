"""The structures that a file can hold beside the plain sequence; all show the same triangles."""

import heapq
from typing import NamedTuple

import numpy as np

from .arrays import read_indices, varints
from .errors import need

NEVER = np.iinfo(np.int64).max
GENERATORS = ("stripe", "cache")


class Array(NamedTuple):
    """An array of a structure; ``wide`` if its numbers are u32."""

    data: bytes
    wide: bool


class Interactive:
    """Interactive Meshes: no arrays of its own. The triangles of a submesh stand in reverse order
    of their death, so a level is the first ones of each."""

    def __init__(self, obj, arrays):
        need(not arrays, obj.place, "has arrays of interactive, which has none")
        self.object = obj

    def triangles(self, lod):
        """The triangles of a LOD and the submesh of each."""
        obj = self.object
        moved = obj.shown(lod)[obj.triangles]
        live = obj.is_live(moved)
        # The first dead triangle ends its submesh.
        starts = np.concatenate(([0], np.cumsum(obj.entry.triangle_counts)))
        counts = []
        for start, end in zip(starts, starts[1:]):
            dead = np.flatnonzero(~live[start:end])
            counts.append(dead[0] if len(dead) else end - start)
        need(sum(counts) == live.sum(), obj.place, "has a live triangle behind a dead one")
        parts = [moved[s : s + n] for s, n in zip(starts, counts)]
        submesh = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
        return np.concatenate(parts or [moved[:0]]).astype(np.uint32), submesh


class Strips:
    """Strips as a file has them.

    ``vertices`` has those of all, one after the other; ``starts`` says where each begins.
    """

    def __init__(self, obj, array):
        place, data = f"{obj.place}: strips", array.data
        at = 4 if array.wide else 1
        need(len(data) >= at, place, "end within the number of their generator")
        kind = int.from_bytes(bytes(data[:at]), "little")
        need(kind < len(GENERATORS), place, "are of an unknown generator")
        self.generator = GENERATORS[kind]
        submeshes = len(obj.submeshes)
        front = _front_words if array.wide else _front
        per_submesh, used = front(data[at:], submeshes, place)
        at += used
        total = int(per_submesh.sum())
        need(total <= len(data), place, "are more than their bytes can hold")
        lengths, used = front(data[at:], total, place)
        at += used
        need((lengths >= 3).all(), place, "have one of fewer than three vertices")
        self.vertices = read_indices(data[at:], len(obj.positions), array.wide, place)
        need(len(self.vertices) == lengths.sum(), place, "have another number of vertices")
        need((self.vertices < len(obj.positions)).all(), place, "have one that does not exist")
        self.starts = np.concatenate(([0], np.cumsum(lengths)))
        self.strip = np.repeat(np.arange(total), lengths)
        self.submesh = np.repeat(np.arange(submeshes, dtype=np.uint32), per_submesh)

    def draw(self, obj, vertices, strip):
        """The triangles that strips of these vertices draw, and the submesh of each."""
        if len(vertices) < 3:
            return np.zeros((0, 3), np.uint32), np.zeros(0, np.uint32)
        triples = np.stack([vertices[:-2], vertices[1:-1], vertices[2:]], axis=1)
        whole = strip[:-2] == strip[2:]
        first = np.searchsorted(strip, strip[:-2])
        odd = (np.arange(len(strip) - 2) - first) % 2 == 1
        triples[odd] = triples[odd][:, [1, 0, 2]]
        drawn = whole & obj.is_live(triples)
        return triples[drawn].astype(np.uint32), self.submesh[strip[:-2][drawn]]


def _front(data, count, place):
    """The first ``count`` numbers of seven bits a byte, and the bytes that they take."""
    most = min(len(data), 5 * count)
    part = bytes(data[:most])
    complete = np.flatnonzero(np.frombuffer(part, "u1") < 128)
    need(len(complete) >= count, place, "end within their numbers")
    end = int(complete[count - 1]) + 1 if count else 0
    return varints(part[:end], place)[0].astype(np.int64), end


def _front_words(data, count, place):
    """The first ``count`` u32, and the bytes that they take."""
    need(len(data) >= 4 * count, place, "end within their numbers")
    return np.frombuffer(data, "<u4", count=count).astype(np.int64), 4 * count


class Masking:
    """Masking Strips: strips of at most sixteen vertices, drawn without what is degenerate."""

    def __init__(self, obj, arrays):
        self.object, self.strips = obj, Strips(obj, arrays["strips"])
        longest = int(np.diff(self.strips.starts).max(initial=0))
        need(longest <= 16, obj.place, "has a masking strip of more than 16 vertices")

    def triangles(self, lod):
        """The triangles of a LOD and the submesh of each."""
        shown = self.object.shown(lod)[self.strips.vertices]
        return self.strips.draw(self.object, shown, self.strips.strip)


class Speed:
    """Speed Strips: strips that lose elements as they become needless."""

    def __init__(self, obj, arrays):
        self.object, self.strips = obj, Strips(obj, arrays["strips"])
        need(not arrays["removals"].wide, obj.place, "has wide removals, which are never written")
        self._removals = arrays["removals"].data
        self._gone = None

    def triangles(self, lod):
        """The triangles of a LOD and the submesh of each."""
        left = self.gone() >= lod
        shown = self.object.shown(lod)[self.strips.vertices]
        return self.strips.draw(self.object, shown[left], self.strips.strip[left])

    def gone(self):
        """For each element of the strips the record after which it is gone. Replays the removals
        of all strips once."""
        if self._gone is None:
            ends = self._last_records()
            self._gone = np.full(len(self.strips.vertices), NEVER, np.int64)
            numbers = iter(varints(self._removals, f"{self.object.place}: removals")[0].tolist())
            for strip in range(len(self.strips.starts) - 1):
                start, end = self.strips.starts[strip : strip + 2]
                try:
                    removals = [
                        (next(numbers), next(numbers), next(numbers)) for _ in range(next(numbers))
                    ]
                except (StopIteration, RuntimeError):
                    need(False, self.object.place, "has fewer removals than it says")
                self._replay(int(start), int(end), removals, int(ends[strip]))
            need(next(numbers, None) is None, self.object.place, "has more removals than strips")
        return self._gone

    def _last_records(self):
        """For each strip the record after which it draws nothing."""
        vertices, strip = self.strips.vertices, self.strips.strip
        ends = np.full(len(self.strips.starts) - 1, -1, np.int64)
        if len(vertices) < 3:
            return ends
        triples = np.stack([vertices[:-2], vertices[1:-1], vertices[2:]], axis=1)
        whole = strip[:-2] == strip[2:]
        triples, strip = triples[whole], strip[:-2][whole]
        # The first number of records after which a triangle is dead, by bisection.
        low, high = (
            np.zeros(len(triples), np.int64),
            np.full(len(triples), len(self.object.targets)),
        )
        while (low < high).any():
            middle = (low + high) // 2
            live = np.zeros(len(triples), bool)
            for lod in np.unique(middle[low < high]) if len(triples) < 64 else ():
                here = middle == lod
                live[here] = self.object.is_live(self.object.shown(int(lod))[triples[here]])
            if len(triples) >= 64:
                live = self._live_at(triples, middle)
            high = np.where(live, high, middle)
            low = np.where(live & (low < middle + 1), middle + 1, low)
            low = np.minimum(low, high)
        np.maximum.at(ends, strip, high - 1)
        return ends

    def _live_at(self, triples, lods):
        """For each triangle whether it is live at a LOD of its own."""
        targets = np.append(self.object.targets.astype(np.int64), 0)
        moved, limit = triples.astype(np.int64), lods[:, None]
        while True:
            goes = moved < limit
            if not goes.any():
                return self.object.is_live(moved)
            moved = np.where(goes, targets[np.minimum(moved, len(targets) - 1)], moved)

    def _replay(self, start, end, removals, death):
        """Finds the record of each removal of a strip: its events are the records, in order, that
        change an element that is left, up to its death."""
        targets, vertices = self.object.targets, self.strips.vertices
        elements = list(range(start, end))  # those left, in order
        front = 0  # elements that went at the front keep their places
        count = {}  # elements left by the vertex that they are
        members = {}
        for e in elements:
            members.setdefault(int(vertices[e]), []).append(e)
        heap = list(members)
        heapq.heapify(heap)
        gone, event, due = self._gone, 0, 0
        event_of_removal = []
        for difference, at, code in removals:
            due += difference
            event_of_removal.append((due, at, code))
        pending = 0
        while heap and pending < len(event_of_removal):
            vertex = heapq.heappop(heap)
            left = [e for e in members.pop(vertex, ()) if gone[e] == NEVER]
            if not left:
                continue
            need(vertex < death, self.object.place, "has a removal after the end of a strip")
            target = int(targets[vertex])
            if target not in members:
                members[target] = []
                heapq.heappush(heap, target)
            members[target] += left
            shift = 0
            while pending < len(event_of_removal) and event_of_removal[pending][0] == event:
                _, at, code = event_of_removal[pending]
                number, kind = code >> 2, code & 3
                first = at - front - shift
                need(
                    0 <= first and first + number <= len(elements) and number > 0,
                    self.object.place, "has a removal outside its strip",
                )  # fmt: skip
                for e in elements[first : first + number]:
                    gone[e] = vertex
                del elements[first : first + number]
                shift += number
                pending += 1
                if kind == 2:
                    need(first == 0, self.object.place, "has a removal at the front that is not")
                    front += number
                    shift -= number
            event += 1
        need(pending == len(event_of_removal), self.object.place, "has a removal without an event")
