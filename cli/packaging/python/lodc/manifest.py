"""The manifest of a .lodc file: its source, its document, its objects."""

from dataclasses import dataclass
from typing import Any

from .attribute import Attribute, Source, read_attribute, read_document, source_format
from .cursor import Cursor
from .errors import need
from .scene import Submesh

PLACE = "section MANI"


@dataclass
class Bounds:
    """Bounds of the vertices of an object at rest: a box, and a sphere around its middle."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    center: tuple[float, float, float]
    radius: float


@dataclass
class ObjectEntry:
    """An object as the manifest describes it."""

    name: str
    #: World units per mesh unit where the scene shows the object at its largest.
    world_scale: float
    #: Number of its mesh in the glTF document.
    document_mesh: int
    #: The LOD at which collapses that keep the surface sound end.
    last_legal_lod: int
    topology_changes: int
    first_topology_change: int | None
    submeshes: list[Submesh]
    triangle_counts: list[int]
    attributes: list[Attribute]
    #: For each attribute: every vertex has it, not only those of some submeshes.
    full: list[bool]
    #: The structures of the object (Speed Strips, ...), with the names of their arrays.
    models: list[tuple[str, list[str]]]
    bounds: Bounds


def read_manifest(data: Any) -> tuple[Source, dict[str, Any], list[ObjectEntry]]:
    """The source, what an OBJ's document says, and the objects."""
    cursor = Cursor(data, PLACE)
    kind, content_hash = cursor.u8(), cursor.u128()
    source = Source(source_format(kind, PLACE), content_hash)
    document = read_document(cursor)
    return source, document, cursor.many(lambda: cursor.record(lambda: _object(cursor)))


def _object(cursor):
    name, scale, mesh = cursor.string(), cursor.f64(), cursor.u32()
    legal, changes = cursor.u32(), cursor.u32()
    first = cursor.optional(cursor.u32)
    submeshes = cursor.many(lambda: cursor.record(lambda: _submesh(cursor)))
    attributes = cursor.many(lambda: cursor.record(lambda: read_attribute(cursor)))
    models = cursor.many(lambda: cursor.record(lambda: _model(cursor)))
    point = lambda: (cursor.f32(), cursor.f32(), cursor.f32())
    bounds = Bounds(point(), point(), point(), cursor.f32())
    need(0 < scale < float("inf"), PLACE, "has an object whose scale is not a number above 0")
    return ObjectEntry(
        name, scale, mesh, legal, changes, first,
        [s for s, _ in submeshes], [n for _, n in submeshes],
        [a for a, _ in attributes], [full for _, full in attributes],
        models, bounds,
    )  # fmt: skip


def _submesh(cursor):
    name, material = cursor.string(), cursor.optional(cursor.string)
    primitive, triangles = cursor.u32(), cursor.u32()
    streams = tuple(cursor.many(cursor.u32))
    return Submesh(name, material, primitive, streams), triangles


def _model(cursor):
    return cursor.string(), cursor.many(cursor.string)
