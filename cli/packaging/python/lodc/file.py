"""A .lodc file: its manifest and its objects."""

import json
from dataclasses import dataclass

from .attribute import Source, Submesh, read_attribute, read_document, source_format
from .container import Container
from .cursor import Cursor
from .errors import need
from .object import Object

PLACE = "section MANI"


@dataclass
class ObjectEntry:
    """An object as the manifest describes it."""

    name: str
    world_scale: float
    document_mesh: int
    last_legal_lod: int
    topology_changes: int
    first_topology_change: int | None
    submeshes: list
    triangle_counts: list
    attributes: list
    full: list
    models: list


class LodFile:
    """An open .lodc file.

    ``objects`` are its meshes, ``source`` says what it was made from, ``gltf`` is the JSON of a
    glTF source and ``buffer`` its bytes; ``obj`` has the libraries and materials of an OBJ.
    ``layout`` is ``packed`` or ``gpu``.
    """

    def __init__(self, data):
        container = Container(memoryview(data))
        self.skipped = container.skipped
        self.layout = "gpu" if container.wide else "packed"
        cursor = Cursor(container.take(b"MANI"), PLACE)
        kind, content_hash = cursor.u8(), cursor.u128()
        self.source = Source(source_format(kind, PLACE), content_hash)
        self.obj = read_document(cursor)
        entries = cursor.many(lambda: cursor.record(lambda: _object(cursor)))
        self.gltf, self.buffer = None, b""
        if not self.obj:
            self.gltf = json.loads(bytes(container.take(b"DJSN")))
            self.buffer = bytes(container.take(b"DBLB"))
        self.objects = [Object(container, i, entry) for i, entry in enumerate(entries)]

    def __repr__(self):
        return f"<lodc file: {self.objects}>"


def _object(cursor):
    name, scale, mesh = cursor.string(), cursor.f64(), cursor.u32()
    legal, changes = cursor.u32(), cursor.u32()
    first = cursor.optional(cursor.u32)
    submeshes = cursor.many(lambda: cursor.record(lambda: _submesh(cursor)))
    attributes = cursor.many(lambda: cursor.record(lambda: read_attribute(cursor)))
    models = cursor.many(lambda: cursor.record(lambda: _model(cursor)))
    need(0 < scale < float("inf"), PLACE, "has an object whose scale is not a number above 0")
    return ObjectEntry(
        name, scale, mesh, legal, changes, first,
        [s for s, _ in submeshes], [n for _, n in submeshes],
        [a for a, _ in attributes], [full for _, full in attributes],
        models,
    )  # fmt: skip


def _submesh(cursor):
    name, material = cursor.string(), cursor.optional(cursor.string)
    primitive, triangles = cursor.u32(), cursor.u32()
    streams = tuple(cursor.many(cursor.u32))
    return Submesh(name, material, primitive, streams), triangles


def _model(cursor):
    return cursor.string(), cursor.many(cursor.string)
