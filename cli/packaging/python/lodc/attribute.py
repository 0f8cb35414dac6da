"""Descriptions that files and streams share: attributes, sources, documents."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import FormatError
from .scene import fractions

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
    dtype: "np.dtype[Any]"
    components: int
    normalized: bool

    def gltf_name(self) -> str:
        """The name that glTF has for it: ``NORMAL``, ``TEXCOORD_0``; that of a custom one."""
        if self.meaning == "custom":
            return self.name
        name = self.meaning.upper()
        has_sets = self.meaning in ("texcoord", "color", "joints", "weights")
        return f"{name}_{self.set}" if has_sets else name

    def as_gltf(self, values: NDArray[Any], upright: bool) -> NDArray[Any]:
        """Its values as glTF means them: fractions as floats; with ``upright``, as OBJ and PLY have
        them, V turned to go down, normals of unit length, colours from 0 to 1."""
        if self.normalized:
            return fractions(values)
        if not upright or values.dtype.kind != "f":
            return values
        if self.meaning == "texcoord":
            two = np.zeros((len(values), 2), np.float32)
            two[:, : values.shape[1]] = values[:, :2]
            two[:, 1] = np.float32(1) - two[:, 1]
            return two
        if self.meaning == "color":
            return np.clip(np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
        if self.meaning == "normal" and self.morph_target is None:
            length = np.linalg.norm(values.astype(np.float64), axis=1, keepdims=True)
            sound = np.isfinite(length) & (length > 0)
            unit = np.where(sound, values / np.where(sound, length, 1), [[0.0, 0.0, 1.0]])
            # What is a unit vector already stays bit for bit.
            return np.where(np.abs(length - 1) > 1e-5, unit, values).astype(np.float32)
        return values

    def label(self) -> str:
        """A name for people, such as ``texcoord 0``."""
        base = self.name if self.meaning == "custom" else self.meaning
        if self.meaning in ("texcoord", "color", "joints", "weights"):
            base += f" {self.set}"
        return base if self.morph_target is None else f"{base} of morph target {self.morph_target}"


@dataclass(frozen=True)
class Source:
    """The file that a scene was made from: ``obj``, ``gltf``, ``glb``, ``ply`` or ``stl``, and its
    content hash."""

    format: str
    content_hash: int


def source_format(number, place):
    """The name of a source format."""
    names = ("obj", "gltf", "glb", "ply", "stl")
    if number >= len(names):
        raise FormatError(place, f"names source format {number}, which is not known")
    return names[number]


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
    if kind not in (0, 2):
        raise FormatError(cursor.place, "has a document of an unknown kind")
    material = lambda: (cursor.string(), cursor.many(cursor.string))
    document = {"libraries": cursor.many(cursor.string), "materials": cursor.many(material)}
    document["loose"] = cursor.many(cursor.string) if kind == 2 else []
    document["offset"] = [cursor.f64() for _ in range(3)] if kind == 2 else [0.0] * 3
    return document
