"""The scene around objects: where nodes place them, materials, images."""

import base64
import os
import urllib.parse
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import FormatError, need

PLACE = "document"
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
INSTANCING = "EXT_mesh_gpu_instancing"


@dataclass(frozen=True)
class Submesh:
    """Names of a submesh, and the numbers of the attributes that its vertices have. ``material``
    is None if it has none, and empty if that has no name."""

    name: str
    material: str | None
    primitive: int
    attributes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Instance:
    """An object as a node shows it: ``object`` is its number, ``node`` that of the node (None
    without nodes), ``matrix`` 4 × 4 takes columns from the mesh's units to world units, ``skin`` is
    the number of the skin that moves it instead, if any."""

    object: int
    node: int | None
    name: str
    matrix: NDArray[Any]
    skin: int | None


@dataclass(frozen=True, eq=False)
class Image:
    """An image: ``data`` are the bytes of its file, None if that is not there."""

    name: str
    mime: str | None
    uri: str | None
    data: bytes | None

    def __repr__(self) -> str:
        size = "not there" if self.data is None else f"{len(self.data)} bytes"
        return f"<image {self.name or self.uri or ''!r}: {self.mime}, {size}>"


class Scene:
    """The default scene, at rest.

    ``instances`` are the objects as nodes place them, ``materials`` those of the document (of an
    OBJ their names and lines), ``gltf`` the document itself, None of an OBJ, PLY or STL.
    """

    def __init__(
        self,
        gltf: dict[str, Any] | None,
        buffer: bytes,
        obj: dict[str, Any] | None,
        meshes: list[int],
        folder: str | None,
    ) -> None:
        self.gltf, self._buffer, self._folder = gltf, buffer, folder
        self._libraries = obj or {}
        self._worlds: dict[int, NDArray[Any]] = {}
        self.instances: list[Instance] = []
        if gltf is None:
            lines = self._libraries.get("materials", [])
            self.materials: list[dict[str, Any]] = [
                {"name": name, "lines": text} for name, text in lines
            ]
            place = np.eye(4)
            place[:3, 3] = self._libraries.get("offset", 0.0)
            self.instances += [Instance(i, None, "", place, None) for i in range(len(meshes))]
        else:
            self.materials = list(gltf.get("materials", []))
            self._place(meshes)

    def _place(self, meshes: list[int]) -> None:
        gltf = self.gltf or {}
        nodes = gltf.get("nodes", [])
        children = {c for node in nodes for c in node.get("children", [])}
        scenes = gltf.get("scenes")
        if scenes is None:
            roots = [n for n in range(len(nodes)) if n not in children]
        else:
            number = gltf.get("scene", 0)
            roots = scenes[number].get("nodes", []) if number < len(scenes) else []
        unseen = [(n, np.eye(4)) for n in reversed(roots)]
        while unseen:
            number, parent = unseen.pop()
            if number in self._worlds or not 0 <= number < len(nodes):
                continue
            node = nodes[number]
            world = parent @ _local(node)
            self._worlds[number] = world
            unseen += [(c, world) for c in reversed(node.get("children", []))]
            for obj in [o for o, mesh in enumerate(meshes) if mesh == node.get("mesh")]:
                for place in self._repeats(node):
                    shown = world @ place
                    self.instances.append(
                        Instance(obj, number, node.get("name", ""), shown, node.get("skin"))
                    )

    def _repeats(self, node: dict[str, Any]) -> list[NDArray[Any]]:
        """Where a node shows its mesh, relative to itself."""
        extension = node.get("extensions", {}).get(INSTANCING)
        if extension is None:
            return [np.eye(4)]
        named = {"translation": "TRANSLATION", "rotation": "ROTATION", "scale": "SCALE"}
        accessors = extension.get("attributes", {})
        columns = {
            key: self.accessor(accessors[name]) for key, name in named.items() if name in accessors
        }
        count = min((len(column) for column in columns.values()), default=1)
        return [_local({k: column[i] for k, column in columns.items()}) for i in range(count)]

    def material(self, instance: Instance, submesh: Submesh) -> dict[str, Any] | None:
        """The material that a submesh has where an instance shows it."""
        if self.gltf is None or instance.node is None:
            named = [m for m in self.materials if m.get("name") == submesh.material]
            return named[-1] if named else None
        mesh = self.gltf["meshes"][self.gltf["nodes"][instance.node]["mesh"]]
        number = mesh["primitives"][submesh.primitive].get("material")
        return None if number is None else self.materials[number]

    def accessor(self, number: int) -> NDArray[Any]:
        """The elements of an accessor of the document, a row each; fractions as floats."""
        try:
            gltf = self.gltf or {}
            a = gltf["accessors"][number]
            dtype, width = np.dtype(COMPONENTS[a["componentType"]]), WIDTHS[a["type"]]
            if "bufferView" not in a:
                return np.zeros((a["count"], width), dtype)
            view = gltf["bufferViews"][a["bufferView"]]
            start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
            stride = view.get("byteStride", dtype.itemsize * width)
            rows: NDArray[Any] = np.ndarray(
                (a["count"], width), dtype, self._buffer, start, (stride, dtype.itemsize)
            )
        except (KeyError, IndexError, TypeError, ValueError) as e:
            raise FormatError(PLACE, f"has an accessor that cannot be read: {e}") from None
        return fractions(rows) if a.get("normalized") else rows

    @property
    def images(self) -> list[Image]:
        """The images: in the document, or beside the file (not elsewhere)."""
        return [self._image(image) for image in (self.gltf or {}).get("images", [])]

    def _image(self, image: dict[str, Any]) -> Image:
        name, mime, uri = image.get("name", ""), image.get("mimeType"), image.get("uri")
        if "bufferView" in image:
            views = (self.gltf or {}).get("bufferViews", [])
            need(0 <= image["bufferView"] < len(views), PLACE, "has an image that is not there")
            view = views[image["bufferView"]]
            start = view.get("byteOffset", 0)
            data = self._buffer[start : start + view.get("byteLength", 0)]
            return Image(name, mime, None, bytes(data))
        if uri is None:
            return Image(name, mime, None, None)
        if uri.startswith("data:"):
            head, _, text = uri[5:].partition(",")
            data = base64.b64decode(text) if head.endswith(";base64") else text.encode()
            return Image(name, mime or head.split(";")[0], None, data)
        return Image(name, mime, uri, self._beside(urllib.parse.unquote(uri)))

    def _beside(self, path: str) -> bytes | None:
        """The bytes of a file in the folder of images or below."""
        if self._folder is None or "\0" in path:
            return None
        folder = os.path.realpath(self._folder)
        whole = os.path.realpath(os.path.join(folder, path))
        if os.path.commonpath([folder, whole]) != folder or not os.path.isfile(whole):
            return None
        with open(whole, "rb") as file:
            return file.read()

    def world(self, node: int) -> NDArray[Any]:
        """The matrix from a node's space to the world, 4 × 4."""
        return self._worlds.get(node, np.eye(4))

    def joints(self, skin: int) -> NDArray[Any]:
        """The matrices of a skin's joints from the mesh's units to the world, *n* × 4 × 4."""
        stored = (self.gltf or {})["skins"][skin]
        joints = stored.get("joints", [])
        inverse = np.repeat(np.eye(4)[None], len(joints), axis=0)
        if "inverseBindMatrices" in stored:
            given = self.accessor(stored["inverseBindMatrices"])[: len(joints)]
            inverse[: len(given)] = given.reshape(-1, 4, 4).transpose(0, 2, 1)
        placed: NDArray[Any] = np.stack([self.world(j) for j in joints]) @ inverse
        return placed

    def __repr__(self) -> str:
        images = len((self.gltf or {}).get("images", []))
        counts = f"{len(self.instances)} instances, {len(self.materials)} materials"
        return f"<scene: {counts}, {images} images>"


def named_by(
    gltf: dict[str, Any] | None, mesh: int, submeshes: list[Submesh]
) -> list[Submesh]:
    """Submeshes with the names of the materials that a glTF's mesh has for them; those of other
    formats have them."""
    if gltf is None:
        return submeshes
    meshes, materials = gltf.get("meshes", []), gltf.get("materials", [])
    primitives = meshes[mesh].get("primitives", []) if mesh < len(meshes) else []

    def name(submesh: Submesh) -> str | None:
        if submesh.primitive >= len(primitives):
            return None
        number = primitives[submesh.primitive].get("material", -1)
        return materials[number].get("name", "") if 0 <= number < len(materials) else None

    return [replace(submesh, material=name(submesh)) for submesh in submeshes]


def fractions(numbers: NDArray[Any]) -> NDArray[np.float32]:
    """Integers that stand for fractions (glTF 2.0, 3.6.2.2)."""
    largest = np.float32(np.iinfo(numbers.dtype).max)
    return np.maximum(numbers.astype(np.float32) / largest, np.float32(-1))


def _local(node: dict[str, Any]) -> NDArray[Any]:
    """A node's matrix relative to its parent (glTF 2.0, 3.5.3)."""
    if len(node.get("matrix", ())) == 16:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = (float(c) for c in node.get("rotation", (0, 0, 0, 1)))
    square = x * x + y * y + z * z + w * w
    if square > 0:
        s = 2 / square
        matrix[:3, :3] = [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    matrix[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)), np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix
