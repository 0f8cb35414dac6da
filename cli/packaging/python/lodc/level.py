"""One level of detail of a file or stream."""

import html
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .level_object import LevelObject, Name
from .program import run
from .scene import Scene
from .trimeshes import to_trimesh

if TYPE_CHECKING:
    import trimesh


class Origin:
    """What levels of a file or stream come out of: the command that writes one (``extract`` or
    ``unpack``), the bytes that it reads, and the folder that images are looked for in."""

    def __init__(self, command: str, data: bytes, folder: str | None) -> None:
        self.command, self.data, self.folder = command, data, folder

    def run(self, words: list[str]) -> bytes:
        """Runs the command; what it writes on standard output."""
        suffix = ".lodc" if self.command == "extract" else ".lods"
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"file{suffix}")
            with open(path, "wb") as file:
                file.write(self.data)
            if self.command == "extract":
                # Levels have the vertices of the file.
                words = ["--no-refit", *words]
                if self.folder is not None:
                    words = ["--textures-from", self.folder, *words]
            return run([self.command, path, "-q", *words])[0]


class Level(Mapping[Name, NDArray[Any]]):
    """One level of a scene: ``objects`` are its meshes, in the order of the file.

    The level has the arrays of all objects one after the other, each object once and as it stands
    by itself (``to_trimesh`` places them): ``level["POSITION"]``, ``level.triangles``. ``owner``
    says whose a triangle is. Names are those that any object has; vertices of the others have
    zeros there. ``error`` and ``rms`` are the largest distances from the input, in world units.
    """

    def __init__(
        self, objects: list[LevelObject], scales: list[float], scene: Scene, origin: Origin,
        words: list[str],
    ) -> None:  # fmt: skip
        self.objects, self.scene = objects, scene
        self._origin, self._words = origin, words
        pairs = list(zip(scales, objects))
        self.error: float = max((scale * o.error for scale, o in pairs), default=0.0)
        means = [scale * o.rms for scale, o in pairs if o.rms is not None]
        self.rms: float | None = max(means, default=0.0) if len(means) == len(objects) else None

    @property
    def triangle_count(self) -> int:
        """Triangles of all objects."""
        return sum(len(o.triangles) for o in self.objects)

    @property
    def only(self) -> LevelObject:
        """The object, if there is one.

        Raises ValueError if there are several."""
        if len(self.objects) != 1:
            names = ", ".join(repr(o.name) for o in self.objects[:8])
            raise ValueError(f"{len(self.objects)} objects: take one of level.objects ({names})")
        return self.objects[0]

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """*n* × 3 rows of ``level["POSITION"]``."""
        if len(self.objects) == 1:
            return self.objects[0].triangles
        starts = np.cumsum([0, *(len(o.vertices) for o in self.objects)], dtype=np.uint32)
        each = [o.triangles + first for o, first in zip(self.objects, starts)]
        return np.concatenate([np.zeros((0, 3), np.uint32), *each])

    @property
    def owner(self) -> NDArray[np.uint32]:
        """The number of each triangle's object."""
        counts = [len(o.triangles) for o in self.objects]
        return np.repeat(np.arange(len(counts), dtype=np.uint32), counts)

    @property
    def positions(self) -> NDArray[np.float32]:
        """``level["POSITION"]``."""
        return self["POSITION"]

    @property
    def submesh(self) -> NDArray[np.uint32]:
        """The submesh of each triangle, in its object."""
        return np.concatenate([np.zeros(0, np.uint32), *(o.submesh for o in self.objects)])

    @property
    def lod(self) -> int | None:
        """The LOD; None of a stream, and of several objects, which each have their own."""
        return self.objects[0].lod if len(self.objects) == 1 else None

    def __getitem__(self, name: Name) -> NDArray[Any]:
        if len(self.objects) == 1:
            return self.objects[0][name]
        found = [o[name] if name in o else None for o in self.objects]
        shapes = {values.shape[1:] for values in found if values is not None}
        if not shapes:
            known = ", ".join(repr(name) for name in self)
            raise KeyError(f"no object has {name!r}; the objects have {known}")
        if len(shapes) > 1:
            widths = ", ".join(sorted(str(shape[0]) for shape in shapes))
            raise ValueError(f"{name!r} has {widths} numbers: take it of each of level.objects")
        [shape] = shapes
        kinds = [values.dtype for values in found if values is not None]
        zeros = np.result_type(*kinds)
        rows = [
            np.zeros((len(o.vertices), *shape), zeros) if values is None else values
            for o, values in zip(self.objects, found)
        ]
        return np.concatenate(rows)

    def __iter__(self) -> Iterator[Name]:
        return iter(dict.fromkeys(name for o in self.objects for name in o))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def to_trimesh(self) -> "trimesh.Trimesh":
        """One mesh of everything as the scene places it at rest, in world units. Texture
        coordinates and colours come along where every part has them; ``metadata["parts"]`` names
        the object and the material of each number in ``face_attributes["part"]``. Needs trimesh."""
        return to_trimesh(self.scene, self.objects)

    def to_glb(self) -> bytes:
        """The level as a GLB file: nodes, materials, skins and animations of the input, images
        inside, the same bytes as ``lodc extract --no-refit`` writes."""
        return self._origin.run([*self._words, "-o", "-"])

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the level as the extension says: .glb, .gltf, .obj, .ply."""
        self._origin.run([*self._words, "-o", os.fspath(path)])

    def __repr__(self) -> str:
        objects = f"{len(self.objects)} objects, " if len(self.objects) != 1 else ""
        return f"<level: {objects}{self.triangle_count} triangles, error {self.error:.4g}>"

    def _repr_html_(self) -> str:
        rows = [(o.name, o.lod, len(o.triangles), f"{o.error:.4g}") for o in self.objects]
        return table(("object", "LOD", "triangles", "error"), rows)


def table(head: tuple[str, ...], rows: Sequence[tuple[object, ...]]) -> str:
    """A table for notebooks; of many rows the first ones."""

    def cells(tag: str, row: tuple[object, ...]) -> str:
        return "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in row)

    shown = [f"<tr>{cells('td', row)}</tr>" for row in rows[:40]]
    if len(rows) > 40:
        shown.append(f"<tr><td colspan={len(head)}>{len(rows) - 40} more</td></tr>")
    return f"<table><tr>{cells('th', head)}</tr>{''.join(shown)}</table>"
