"""One object at one level of detail, as arrays."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .attribute import Attribute
from .scene import Submesh

Name = str | tuple[str, int]


class Whole:
    """The arrays of an object that its levels share. ``upright`` says that V goes up and normals
    have any length, as in an OBJ."""

    def __init__(
        self,
        positions: NDArray[np.float32],
        attributes: list[Attribute],
        values: list[NDArray[Any]],
        submeshes: list[Submesh],
        upright: bool,
    ) -> None:
        self.positions, self.attributes, self.values = positions, attributes, values
        self.submeshes, self.upright = submeshes, upright


class LevelObject(Mapping[Name, NDArray[Any]]):
    """One object at one level: arrays of its vertices by the names that glTF has.

    ``obj["TEXCOORD_0"]`` has a row for each vertex, as glTF means it: integers that stand for
    fractions as floats, V from the top down, zeros where a submesh has none.
    ``obj["POSITION", 2]`` are the differences of morph target 2. ``triangles`` is *n* × 3, indices
    of these rows; ``submesh`` has the submesh of each, ``vertices`` for each row the vertex of the
    whole object. ``error`` and ``rms`` are distances from the input in the mesh's units (``rms``
    may be None).
    """

    def __init__(
        self,
        name: str,
        lod: int | None,
        distance: tuple[float, float | None],
        whole: Whole,
        triangles: NDArray[np.uint32],
        submesh: NDArray[np.uint32],
    ) -> None:
        self.name, self.lod, (self.error, self.rms) = name, lod, distance
        self.submeshes, self.submesh = whole.submeshes, submesh
        used = np.zeros(len(whole.positions), bool)
        used[triangles] = True
        self.vertices: NDArray[np.int64] = np.flatnonzero(used)
        row = np.cumsum(used, dtype=np.uint32) - np.uint32(1)
        self.triangles: NDArray[np.uint32] = row[triangles].reshape(-1, 3)
        self._whole = whole
        self._numbers: dict[tuple[str, int | None], int] = {("POSITION", None): -1}
        for number, attribute in enumerate(whole.attributes):
            # Positions of integers are there as floats already.
            self._numbers.setdefault((attribute.gltf_name(), attribute.morph_target), number)

    @property
    def positions(self) -> NDArray[np.float32]:
        """``obj["POSITION"]``."""
        return self["POSITION"]

    def __getitem__(self, name: Name) -> NDArray[Any]:
        key: Any = (name, None) if isinstance(name, str) else name
        number = self._numbers.get(key)
        if number is None:
            known = ", ".join(repr(name) for name in self)
            raise KeyError(f"{self.name!r} has no {name!r}; it has {known}")
        if number < 0:
            return self._whole.positions[self.vertices]
        stored = self._whole.values[number][self.vertices]
        return self._whole.attributes[number].as_gltf(stored, self._whole.upright)

    def __iter__(self) -> Iterator[Name]:
        return (name if target is None else (name, target) for name, target in self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def of_submesh(self, number: int) -> NDArray[np.uint32]:
        """The triangles of one submesh."""
        found: NDArray[np.uint32] = self.triangles[self.submesh == number]
        return found

    def __repr__(self) -> str:
        lod = "" if self.lod is None else f"LOD {self.lod}, "
        return f"<{self.name!r}: {lod}{len(self.triangles)} triangles, error {self.error:.4g}>"
