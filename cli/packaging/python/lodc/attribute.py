"""Descriptions that files and streams share: attributes, submeshes, documents."""

from dataclasses import dataclass

import numpy as np

from .errors import FormatError

MEANINGS = ("position", "normal", "tangent", "texcoord", "color", "joints", "weights", "custom")
COMPONENTS = tuple(np.dtype(t) for t in ("i1", "u1", "<i2", "<u2", "<u4", "<f4"))


@dataclass(frozen=True)
class Attribute:
    """What a stream of vertex data means.

    ``set`` counts texture coordinates, colours, joints and weights; ``name`` is that of a custom
    one; ``morph_target`` is the target whose deltas it holds.
    """

    meaning: str
    set: int
    name: str
    morph_target: int | None
    dtype: np.dtype
    components: int
    normalized: bool

    def label(self):
        """A name for people, such as ``texcoord 0``."""
        base = self.name if self.meaning == "custom" else self.meaning
        if self.meaning in ("texcoord", "color", "joints", "weights"):
            base += f" {self.set}"
        return base if self.morph_target is None else f"{base} of morph target {self.morph_target}"


@dataclass(frozen=True)
class Submesh:
    """Names of a submesh, and the numbers of the attributes that its vertices have."""

    name: str
    material: str | None
    primitive: int
    attributes: tuple


@dataclass(frozen=True)
class Source:
    """The file that a scene was made from: ``obj``, ``gltf`` or ``glb``, and its content hash."""

    format: str
    content_hash: int


def source_format(number, place):
    """The name of a source format."""
    if number > 2:
        raise FormatError(place, f"names source format {number}, which is not known")
    return ("obj", "gltf", "glb")[number]


def component(number, components, place):
    """The type of a component."""
    if number >= len(COMPONENTS) or not 1 <= components <= 16:
        raise FormatError(place, "has an attribute of an unknown type")
    return COMPONENTS[number]


def read_attribute(cursor):
    """An attribute as a manifest has it, and whether its section has bytes for all vertices."""
    number = cursor.u32()
    if number >= len(MEANINGS):
        raise FormatError(cursor.place, "has an attribute of an unknown meaning")
    meaning = MEANINGS[number]
    count, name = (cursor.u32(), "") if 3 <= number <= 6 else (0, "")
    if meaning == "custom":
        name = cursor.string()
    morph_target = cursor.optional(cursor.u32)
    kind, components = cursor.u8(), cursor.u8()
    normalized, full = cursor.boolean(), cursor.boolean()
    dtype = component(kind, components, cursor.place)
    return Attribute(meaning, count, name, morph_target, dtype, components, normalized), full


def read_document(cursor):
    """A document without the JSON of a glTF: the libraries and materials of an OBJ."""
    kind = cursor.u32()
    if kind == 1:
        return {}
    if kind:
        raise FormatError(cursor.place, "has a document of an unknown kind")
    material = lambda: (cursor.string(), cursor.many(cursor.string))
    return {"libraries": cursor.many(cursor.string), "materials": cursor.many(material)}
