"""A .lodc file: every level of its objects."""

import json
import os
import tempfile
from typing import Any

import numpy as np

from .container import Container
from .level import Level, Origin, table
from .manifest import read_manifest
from .object import Object
from .scene import Scene, named_by
from .selector import Selector, TargetValue, selector

SHARES = (1.0, 0.5, 0.25, 0.1, 0.05, 0.01)


class LodFile:
    """An open .lodc file.

    ``objects`` are its meshes, ``scene`` has nodes, materials and images, ``source`` says what it
    was made from, ``layout`` is ``packed`` or ``gpu``, ``warnings`` are those of its build.
    ``gltf`` is the JSON of a glTF source and ``buffer`` its bytes; ``obj`` has the libraries and
    materials of an OBJ. ``folder`` is where images are looked for.
    """

    def __init__(self, data: bytes, folder: str | None = None, warnings: list[str] = []) -> None:
        container = Container(memoryview(data))
        self.data, self.folder, self.warnings = data, folder, list(warnings)
        self.skipped = container.skipped
        self.layout = "gpu" if container.wide else "packed"
        self.source, self.obj, entries = read_manifest(container.take(b"MANI"))
        self.gltf: dict[str, Any] | None = None
        self.buffer = b""
        if not self.obj:
            self.gltf = json.loads(bytes(container.take(b"DJSN")))
            self.buffer = bytes(container.take(b"DBLB"))
        upright = self.gltf is None
        for entry in entries:
            entry.submeshes[:] = named_by(self.gltf, entry.document_mesh, entry.submeshes)
        self.objects = [Object(container, i, e, upright) for i, e in enumerate(entries)]
        meshes = [entry.document_mesh for entry in entries]
        self.scene = Scene(self.gltf, self.buffer, self.obj, meshes, folder)

    @property
    def triangles(self) -> int:
        """Triangles of the input, over all objects."""
        return sum(len(o.triangles) for o in self.objects)

    def level(
        self,
        lod: TargetValue = None,
        *,
        ratio: TargetValue = None,
        triangles: TargetValue = None,
        error: TargetValue = None,
        rms: TargetValue = None,
    ) -> Level:
        """One level of the whole scene, by exactly one selector: ``ratio`` (0.1 or ``"10%"``),
        ``triangles`` (500 or ``"10k"``), ``error`` or ``rms`` (a distance, or ``"0.5%"`` of the
        diagonal), or ``lod`` (of every object).

        Over several objects triangles are shared out as the program does it: where the error
        is least.
        """
        wish = selector(lod=lod, ratio=ratio, triangles=triangles, error=error, rms=rms)
        origin = Origin("extract", self.data, self.folder)
        lods = self._lods(wish)
        if len(self.objects) == 1:
            words = ["--lod", str(lods[0])]
        elif wish.name == "lod":
            words = [*wish.words(), "--per-object"]
        else:
            words = wish.words()
        objects = [o.at(k) for o, k in zip(self.objects, lods)]
        return Level(objects, [o.world_scale for o in self.objects], self.scene, origin, words)

    def _lods(self, wish: Selector) -> list[int]:
        """The LOD of each object, as the program chooses them."""
        if len(self.objects) == 1:
            [only] = self.objects
            return [only.chosen(wish.scaled(only.world_scale))]
        if wish.name == "lod":
            return [o.chosen(wish) for o in self.objects]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "level.glb")
            words = [*wish.words(), "--json", "--textures", "keep", "--order", "file", "-o", path]
            said = json.loads(Origin("extract", self.data, self.folder).run(words))
        return [int(o["lod"]) for o in said["objects"]]

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the .lodc file."""
        with open(path, "wb") as file:
            file.write(self.data)

    def facts(self) -> list[tuple[float, int, float]]:
        """Shares of the triangles with the triangles and the error of the levels that ``level``
        gives for them."""
        found = []
        for share in SHARES:
            lods = self._lods(Selector("ratio", share))
            steps = [int(np.searchsorted(o.lods, k)) for o, k in zip(self.objects, lods)]
            pairs = list(zip(self.objects, steps))
            errors = (o.world_scale * float(o.errors[s]) for o, s in pairs)
            error = max(errors, default=0.0)
            found.append((share, sum(int(o.counts[s]) for o, s in pairs), error))
        return found

    def __repr__(self) -> str:
        what = [repr(o.name) for o in self.objects]
        names = what[0] if len(what) == 1 else f"{len(what)} objects"
        return f"<lodc file: {names}, {self.triangles} triangles>"

    def _repr_html_(self) -> str:
        objects = [(o.name, len(o.positions), len(o.triangles)) for o in self.objects]
        levels = [(f"{share:.0%}", n, f"{error:.4g}") for share, n, error in self.facts()]
        first = table(("object", "vertices", "triangles"), objects)
        return first + table(("share", "triangles", "error"), levels)
