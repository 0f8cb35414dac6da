"""An object of a .lodc file: its vertices, its collapse sequence and its levels."""

import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arrays import curve, lost_triangles, read_indices
from .attribute import Attribute
from .container import Container
from .errors import need
from .level_object import LevelObject, Whole
from .manifest import ObjectEntry
from .scene import Submesh, fractions
from .selector import Selector, TargetValue, selector
from .structures import Array, Interactive, Masking, Speed


class Row(NamedTuple):
    """A level in the table of an object; ``rms`` is −1 if it was not measured."""

    lod: int
    triangles: int
    vertices: int
    error: float
    rms: float


class Object:
    """One mesh with all its levels.

    ``positions`` is an array of *v* × 3; ``attributes`` describes further streams and ``values``
    has the array of each, *v* × components. ``triangles`` is *f* × 3, submesh 0 first;
    ``triangle_submesh`` has the submesh of each. ``targets`` are the collapse targets, and
    ``lods``, ``errors``, ``rms`` and ``counts`` have LOD 0 and then the LOD after each step,
    ``table`` has some levels and ``bounds`` a box and a sphere around all of them.
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    targets: NDArray[np.uint32]
    lods: NDArray[np.int64]
    errors: NDArray[np.float32]
    rms: NDArray[np.float32] | None
    counts: NDArray[np.int64]

    def __init__(
        self, container: Container, number: int, entry: ObjectEntry, upright: bool
    ) -> None:
        self.number, self.entry, self.name = number, entry, entry.name
        self.world_scale: float = entry.world_scale
        self.submeshes: list[Submesh] = entry.submeshes
        self.attributes: list[Attribute] = entry.attributes
        self.place = f'object "{entry.name}"'
        take = lambda tag, index=0: container.take(tag, number, index)
        positions = take(b"POSI")
        need(len(positions) % 12 == 0, self.place, "has positions that are no whole number")
        self.positions = np.frombuffer(positions, "<f4").reshape(-1, 3)
        v = len(self.positions)
        wide = lambda tag, index=0: (tag, number, index) in container.wide
        self.triangles = read_indices(take(b"TRIS"), v, wide(b"TRIS"), self.place)
        need(len(self.triangles) % 3 == 0, self.place, "has corners that are no triangle")
        self.triangles = self.triangles.reshape(-1, 3)
        self.targets = read_indices(take(b"TARG"), v, wide(b"TARG"), self.place)
        self.vertex_submesh = self._vertex_submesh(take, v)
        self.triangle_submesh = np.repeat(
            np.arange(len(self.submeshes), dtype=np.uint32), entry.triangle_counts
        )
        self._read_steps(container, take, v)
        self.values: list[NDArray[Any]] = [
            self._values(take, wide, i, v) for i in range(len(self.attributes))
        ]
        self._whole = Whole(self.positions, self.attributes, self.values, self.submeshes, upright)
        self._check(v)
        self._check_overview(container)
        self._models(container)
        # Positions by number: equal coordinates (−0 is +0) that move alike have equal numbers.
        bits = (self.positions + np.float32(0)).view(np.uint32)
        bits = np.concatenate([bits, *self._motion()], axis=1)
        self.position_ids = np.unique(bits, axis=0, return_inverse=True)[1].reshape(-1)

    def _motion(self):
        """What moves each vertex, as arrays of u32 with a row for each: vertices at one position
        whose rows are equal stay together in all poses."""
        moves = [
            (a.morph_target is None) == (a.meaning in ("joints", "weights"))
            and a.meaning in ("position", "joints", "weights")
            for a in self.attributes
        ]
        if not any(moves):
            return []
        formats = [tuple(i for i in s.attributes if moves[i]) for s in self.submeshes]
        format_numbers = [formats.index(f) for f in formats]
        rows = [np.array(format_numbers, np.uint32)[self.vertex_submesh].reshape(-1, 1)]
        streams = {}
        for i in np.flatnonzero(moves):
            a = self.attributes[i]
            values = fractions(self.values[i]) if a.normalized else self.values[i]
            key = (a.meaning, a.morph_target or 0, a.set)
            columns = streams.setdefault(key, np.zeros((len(values), 16), np.float32))
            columns[:, : a.components] += values.astype(np.float32)
        for key in sorted(streams):
            if key[0] == "position":
                rows.append((streams[key][:, :3] + np.float32(0)).view(np.uint32))
        sets = sorted(k[2] for k in streams if k[0] == "joints" and ("weights", 0, k[2]) in streams)
        if sets:
            joints = np.concatenate([streams["joints", 0, s] for s in sets], axis=1)
            weights = np.concatenate([streams["weights", 0, s] for s in sets], axis=1)
            joints[weights == 0] = np.inf
            order = np.lexsort((weights, joints), axis=1)
            for columns in (joints, weights):
                ordered = np.take_along_axis(columns, order, axis=1)
                rows.append((ordered + np.float32(0)).view(np.uint32))
        return rows

    def _vertex_submesh(self, take, v):
        count = len(self.submeshes)
        if count < 2:
            return np.zeros(v, np.uint32)
        dtype = "u1" if count <= 256 else "<u2" if count <= 65536 else "<u4"
        data = np.frombuffer(take(b"VSUB"), dtype).astype(np.uint32)
        need(len(data) == v, self.place, "does not have one submesh for each vertex")
        return data

    def _read_steps(self, container, take, v):
        records = max(v, 1) - 1
        need(len(self.targets) == records, self.place, "does not have one record for each vertex")
        joins = np.frombuffer(take(b"JOIN"), "u1")
        need(len(joins) == -(-records // 8), self.place, "has joins of another number of records")
        joins = np.unpackbits(joins, bitorder="little")
        need(not joins[max(records - 1, 0) :].any(), self.place, "joins records that do not exist")
        ends = np.flatnonzero(joins[:records] == 0) + 1
        self.lods = np.concatenate(([0], ends)).astype(np.int64)
        steps = len(ends)
        errors = curve(take(b"SERR"), steps, f"{self.place}: SERR")
        self.errors = np.concatenate(([0], errors)).astype(np.float32)
        self.rms = None
        if (b"SRMS", self.number, 0) in container.sections:
            rms = curve(take(b"SRMS"), steps, f"{self.place}: SRMS")
            self.rms = np.concatenate(([0], rms)).astype(np.float32)
        self.poses = []
        if (b"POSE", self.number, 0) in container.sections:
            stored = take(b"POSE")
            need(len(stored) % 16 == 0, self.place, "has no whole number of poses")
            self.poses = list(struct.iter_unpack("<IId", stored))
        lost = lost_triangles(take(b"STRI"), steps, f"{self.place}: STRI")
        self.counts = len(self.triangles) - np.concatenate(([0], np.cumsum(lost)))
        need((self.counts >= 0).all(), self.place, "loses more triangles than it has")
        need(self.counts[-1] == 0, self.place, "has triangles left at its last LOD")

    def _values(self, take, wide, number, v):
        attribute, full = self.attributes[number], self.entry.full[number]
        place = f"{self.place}: {attribute.label()}"
        stored = take(b"ATTR", number)
        if wide(b"ATTR", number):
            stored = _without_padding(stored, attribute, place)
        data = np.frombuffer(stored, attribute.dtype)
        need(len(data) % attribute.components == 0, place, "is no whole number of vertices")
        data = data.reshape(-1, attribute.components)
        if not full:
            has = np.array([number in s.attributes for s in self.submeshes])[self.vertex_submesh]
            need(len(data) == has.sum(), place, "does not have one value for each vertex")
            whole = np.zeros((v, attribute.components), attribute.dtype)
            whole[has] = data
            data = whole
        need(len(data) == v, place, "does not have one value for each vertex")
        return data

    def _check(self, v):
        need(np.isfinite(self.positions).all(), self.place, "has a coordinate that is not finite")
        records = np.arange(len(self.targets))
        need((self.targets > records).all(), self.place, "has a target that is gone already")
        need((self.targets < max(v, 1)).all(), self.place, "has a target that is no vertex")
        need((self.triangles < v).all(), self.place, "has a corner that is no vertex")
        same = self.triangle_submesh
        need(len(same) == len(self.triangles), self.place, "has triangles without a submesh")
        need(
            (self.vertex_submesh < max(len(self.submeshes), 1)).all(),
            self.place,
            "has a vertex of no submesh",
        )
        corners = self.vertex_submesh[self.triangles]
        need((corners == same[:, None]).all(), self.place, "has a triangle over two submeshes")
        if self.rms is not None:
            need((self.rms <= self.errors).all(), self.place, "has a mean error above the largest")

    def _check_overview(self, container):
        """Compares bounds and the table of levels with vertices and curves."""
        self.bounds = bounds = self.entry.bounds
        p = self.positions.astype(np.float64)
        low, high = (p.min(0), p.max(0)) if len(p) else (np.zeros(3), np.zeros(3))
        center = ((low + high) / 2).astype(np.float32)
        x, y, z = (p - center).T
        exact = np.sqrt((x * x + y * y + z * z).max(initial=0))
        radius = np.float32(exact)
        radius = np.nextafter(radius, np.float32(np.inf)) if radius < exact else radius
        found = (tuple(low), tuple(high), tuple(center), radius)
        stated = (bounds.low, bounds.high, bounds.center, bounds.radius)
        need(found == stated, self.place, "has other bounds than its vertices")
        table = container.sections.get((b"LEVL", self.number, 0), b"")
        place = f"{self.place}: LEVL"
        need(len(table) % 20 == 0 and len(table) <= 64 * 20, place, "is no table of levels")
        self.table = [Row(*row) for row in struct.iter_unpack("<IIIff", table)]
        before = -1
        for row in self.table:
            step = int(np.searchsorted(self.lods, row.lod))
            is_level = step < len(self.lods) and self.lods[step] == row.lod
            need(is_level and row.lod > before and len(p) > 0, place, "has a level that is not")
            rms = -1 if self.rms is None else self.rms[step]
            own = (self.counts[step], len(p) - row.lod, self.errors[step], rms)
            need(own == row[1:], place, "has other numbers than the curves")
            before = row.lod

    def _models(self, container):
        """Finds the arrays of each structure: they are numbered over all of them."""
        self.structures: dict[str, Any] = {}
        index = 0
        known = {"interactive": Interactive, "speed": Speed, "masking": Masking}
        for name, arrays in self.entry.models:
            keys = [(b"MODA", self.number, index + i) for i in range(len(arrays))]
            sections = [Array(container.take(*key), key in container.wide) for key in keys]
            index += len(arrays)
            if name in known:
                need(name not in self.structures, self.place, f"has {name} twice")
                self.structures[name] = known[name](self, dict(zip(arrays, sections)))

    def shown(self, lod: int) -> NDArray[np.int64]:
        """For each vertex the vertex that it is shown as at a LOD."""
        shown = np.arange(len(self.positions))
        shown[:lod] = self.targets[:lod]
        # Follow twice as many targets each time, until nothing moves.
        while True:
            further = shown[shown]
            if (further == shown).all():
                return shown
            shown = further

    def floor(self, lod: int) -> int:
        """The last LOD, from 0 to ``lod``, that ends a step."""
        return int(self.lods[np.searchsorted(self.lods, lod, side="right") - 1])

    def select(
        self,
        lod: TargetValue = None,
        *,
        ratio: TargetValue = None,
        triangles: TargetValue = None,
        error: TargetValue = None,
        rms: TargetValue = None,
    ) -> int:
        """The LOD that a selector means; exactly one must be given.

        ``lod`` is rounded down to a step. ``ratio`` (0.1 or ``"10%"``) stands for that share of the
        triangles, ``triangles`` (500 or ``"10k"``) for the finest LOD with at most that many,
        ``error`` and ``rms`` for the coarsest LOD within a distance: in the mesh's units, or
        ``"0.5%"`` of its diagonal. But for ``lod``, a mesh with triangles never comes back empty.
        """
        return self.chosen(
            selector(lod=lod, ratio=ratio, triangles=triangles, error=error, rms=rms)
        )

    def chosen(self, wish: Selector) -> int:
        """As :meth:`select`."""
        if wish.name == "lod":
            return self.floor(int(min(wish.value, len(self.targets))))
        if wish.name in ("ratio", "triangles"):
            share = wish.value * len(self.triangles) if wish.name == "ratio" else wish.value
            step = int(np.searchsorted(-self.counts, -np.floor(share), side="left"))
        else:
            curve = self.errors if wish.name == "error" else self.rms
            if curve is None:
                raise ValueError(f"{self.place} has no mean errors: they were not measured")
            limit = wish.value * self.diagonal if wish.percent else wish.value
            step = int(np.searchsorted(curve, np.float64(limit), side="right")) - 1
        last = int((self.counts > 0).sum()) - 1
        most = max(last, 0) if len(self.triangles) else len(self.lods) - 1
        return int(self.lods[min(max(step, 0), most)])

    @property
    def diagonal(self) -> float:
        """The diagonal of the bounding box of LOD 0, in the mesh's units."""
        if not len(self.positions):
            return 0.0
        box = self.positions.max(axis=0).astype(np.float64) - self.positions.min(axis=0)
        return float(np.linalg.norm(box))

    def level(
        self,
        lod: TargetValue = None,
        *,
        ratio: TargetValue = None,
        triangles: TargetValue = None,
        error: TargetValue = None,
        rms: TargetValue = None,
        structure: str | None = None,
    ) -> LevelObject:
        """This object at one level, by a selector of :meth:`select`; ``structure`` names the model
        that shows it (``interactive``, ``speed``, ``masking``), else the plain sequence."""
        wish = selector(lod=lod, ratio=ratio, triangles=triangles, error=error, rms=rms)
        return self.at(self.chosen(wish), structure)

    def at(self, lod: int, structure: str | None = None) -> LevelObject:
        """This object at a LOD that ends a step."""
        if structure is None:
            triangles, submesh = self.live_triangles(lod)
        else:
            if structure not in self.structures:
                raise KeyError(f"{self.place} has no {structure}, only {list(self.structures)}")
            triangles, submesh = self.structures[structure].triangles(lod)
        step = int(np.searchsorted(self.lods, lod))
        rms = None if self.rms is None else float(self.rms[step])
        distance = float(self.errors[step]), rms
        return LevelObject(self.name, lod, distance, self._whole, triangles, submesh)

    def live_triangles(self, lod: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """The triangles of a LOD and the submesh of each."""
        moved = self.shown(lod)[self.triangles]
        live = self.is_live(moved)
        return moved[live].astype(np.uint32), self.triangle_submesh[live]

    def is_live(self, triangles: NDArray[Any]) -> NDArray[np.bool_]:
        """For each triangle whether its corners are three positions."""
        a, b, c = self.position_ids[triangles].T
        return (a != b) & (b != c) & (c != a)

    def __repr__(self) -> str:
        return f"<{self.name!r}: {len(self.positions)} vertices, {len(self.triangles)} triangles>"


def _without_padding(stored, attribute, place):
    """A stream of which each vertex takes a multiple of four bytes."""
    stride = attribute.components * np.dtype(attribute.dtype).itemsize
    padded = -(-stride // 4) * 4
    need(len(stored) % padded == 0, place, "is no whole number of vertices")
    rows = np.frombuffer(stored, "u1").reshape(-1, padded)
    need(not rows[:, stride:].any(), place, "has padding behind a vertex that is not zero")
    return rows[:, :stride].tobytes()
