"""A .lods stream, fed bytes as they come (docs/STREAM.md)."""

import json
from typing import Any

from ..attribute import Source, read_document, source_format
from ..cursor import Cursor
from ..errors import FormatError, need
from ..header import check_header
from ..level import Level, Origin
from ..level_object import LevelObject
from ..scene import Scene, Submesh, named_by
from ..xxh32 import xxh32
from .coder import Substream
from .contexts import Contexts
from .object import StreamObject, read_header, take_headers
from .text import TYPICAL_HEADERS, TextCodec

MAGIC = b"\x89LODS\r\n\x1a"
HEADER = 16
MAX_PAYLOAD = 16 << 20


class Stream:
    """A stream so far. :meth:`feed` it bytes; ``objects`` has the meshes of all whole blocks.

    ``source``, ``obj`` and ``gltf`` are as those of a file, and None until they have come;
    ``buffer`` is empty until all of it has come, and :meth:`bytes_of` gives what has.
    ``all_objects`` is how many objects there will be, ``used`` the bytes of whole blocks.
    """

    source: Source | None
    obj: dict[str, Any] | None
    gltf: dict[str, Any] | None
    all_objects: int | None
    objects: list[StreamObject]
    buffer: bytes
    used: int

    def __init__(self, folder: str | None = None) -> None:
        self.source = self.obj = self.gltf = self.all_objects = None
        self.objects, self.buffer, self.used, self.folder = [], b"", 0, folder
        self._order, self._came = [], b""
        self._headers = TextCodec(TYPICAL_HEADERS)
        self._fed = bytearray()
        self.each_step = None
        self._waiting, self._blocks, self._contexts = b"", 0, Contexts()
        self._complete, self._announced, self._text = False, 0, b""

    def is_complete(self) -> bool:
        """Whether the end has come."""
        return self._complete

    def bytes_of(self, start: int, length: int) -> bytes | None:
        """Bytes of the buffer, such as those of a buffer view; None if some have not come."""
        at = 0
        for first, end in self._order:
            if first <= start and start + length <= end:
                at += start - first
                return self._came[at : at + length] if at + length <= len(self._came) else None
            at += end - first
        return None

    @property
    def triangles(self) -> int:
        """Triangles so far, over all objects."""
        return sum(len(o.mesh.triangles) for o in self.objects)

    @property
    def scene(self) -> Scene:
        """The scene so far; as long as the document is missing, every object stands at the
        origin."""
        meshes = [o.document_mesh for o in self.objects]
        return Scene(self.gltf, self.buffer or self._in_place(), self.obj, meshes, self.folder)

    def _in_place(self) -> bytes:
        """The buffer up to the last byte that has come, with zeros for what has not."""
        at, placed = 0, bytearray()
        for start, end in self._order:
            part = self._came[at : at + end - start]
            placed.extend(bytes(max(start + len(part) - len(placed), 0)))
            placed[start : start + len(part)] = part
            at += len(part)
            if not part:
                break
        return bytes(placed)

    def level(self) -> Level:
        """The mesh so far."""
        upright = self.obj is not None and bool(self.obj)
        objects: list[LevelObject] = [o.level(upright) for o in self.objects]
        scales = [o.world_scale for o in self.objects]
        origin = Origin("unpack", bytes(self._fed[: self.used]), self.folder)
        return Level(objects, scales, self.scene, origin, [])

    def __repr__(self) -> str:
        state = "complete" if self._complete else "so far"
        return f"<lodc stream: {self.used} bytes, {self.triangles} triangles {state}>"

    def feed(self, data: bytes) -> "Stream":
        """Takes the next bytes and reads the blocks that they complete."""
        self._fed += data
        self._waiting += bytes(data)
        if not self.used:
            if len(self._waiting) < HEADER:
                magic = self._waiting[:8]
                need(magic == MAGIC[: len(magic)], "header", "not a .lods stream")
                return self
            check_header(self._waiting[:HEADER], MAGIC, ".lods stream", xxh32, 4)
            self._waiting, self.used = self._waiting[HEADER:], HEADER
        while self._waiting and self._block():
            pass
        return self

    def _block(self):
        """Reads one block; False if some of it is missing."""
        place, data = f"block {self._blocks}", self._waiting
        need(not self._complete, place, "follows the end of the stream")
        if not _has_fields(data):
            return False
        cursor = Cursor(data, place)
        length, tag, steps = cursor.varint(), cursor.varint(), cursor.varint()
        at = cursor.at
        if len(data) < at + 2:
            return False
        check = xxh32(data[:at], self._blocks)
        need(
            data[at : at + 2] == check.to_bytes(4, "little")[:2],
            place,
            "has fields that do not match their checksum",
        )
        need(length <= MAX_PAYLOAD or self._blocks == 0, place, "is longer than any block may be")
        end = at + 6 + length
        if len(data) < end:
            return False
        payload = data[at + 6 : end]
        found = xxh32(payload, check).to_bytes(4, "little")
        need(data[at + 2 : at + 6] == found, place, "does not match its checksum")
        self._read(place, tag, steps, payload)
        self._waiting, self._blocks, self.used = data[end:], self._blocks + 1, self.used + end
        return True

    def _read(self, place, tag, steps, payload):
        if self._blocks == 0:
            need(tag == steps == 0, place, "is not a head")
            self._head(payload, place)
        elif tag == 0 and steps > 0:
            self._turns(place, steps, payload)
        elif tag == 0 and payload:
            self._document(payload, place)
        elif tag == 0:
            whole = self._announced == self.all_objects and all(
                o.is_complete() for o in self.objects
            )
            need(
                whole and self._document_left == 0,
                place,
                "ends the stream before everything is complete",
            )
            self._complete = True
        else:
            self._steps(place, tag - 1, steps, payload)

    def _steps(self, place, number, steps, payload):
        cursor, whole = Cursor(payload, place), len(payload)
        is_first = number == self._announced and number < self.all_objects
        if is_first:
            self._announce(1, cursor, place)
        need(number < self._announced, place, "belongs to an object that does not exist")
        obj, payload = self.objects[number], payload[cursor.at :]
        obj.place = place
        if is_first and steps == 0:
            need(not payload and obj.header.steps == 0, place, "has no steps")
            return
        obj.used = self.used + whole
        obj.read(payload, steps, self._contexts, self.each_step)

    def _announce(self, count, cursor, place):
        """Reads the headers of the next objects."""
        if count == 0:
            return
        headers = take_headers(cursor, self._headers)
        for _ in range(count):
            number = self._announced
            need(number < self.all_objects, place, "has a header too many")
            if number == len(self.objects):
                self.objects.append(StreamObject(number, place))
            self.objects[number].place = place
            self.objects[number].start(read_header(headers))
            self._announced += 1
        need(headers.at == len(headers.data), place, "has headers with bytes left over")

    def _turns(self, place, steps, payload):
        """Reads a block in which objects take turns."""
        cursor, contexts = Cursor(payload, place), self._contexts
        self._announce(cursor.varint(), cursor, place)
        coder = Substream(payload[cursor.at :])
        while steps > 0:
            distance = coder.gamma(contexts.object)
            number = (contexts.expected_object + distance) % max(self.all_objects, 1)
            contexts.expected_object = (number + 1) % max(self.all_objects, 1)
            need(number < self._announced, place, "names an object that has no header yet")
            obj = self.objects[number]
            obj.place, obj.used = place, self.used + len(payload)
            while True:
                obj.step(coder, contexts, self.each_step)
                steps -= 1
                if steps == 0 or obj.steps == obj.header.steps:
                    break
                if obj.is_between_batches() and not coder.bit(contexts.goes_on):
                    break
        need(coder.is_finished(), place, "does not end with its steps")

    def _head(self, payload, place):
        c = Cursor(payload, place)
        self.format = source_format(c.u8(), place)
        self.all_objects, self._text_bytes, self._stored = c.varint(), c.varint(), c.varint()
        self._buffer_bytes = c.varint((1 << 64) - 1)
        self._document_left = self._stored + self._buffer_bytes
        need(c.at == len(payload), place, "has bytes left over")
        need(self._stored <= self._text_bytes, place, "announces a document that cannot be")

    def _document(self, payload, place):
        need(len(payload) <= self._document_left, place, "goes on after the document")
        self._document_left -= len(payload)
        missing = self._stored - len(self._text)
        self._text += payload[:missing]
        self._came += payload[missing:]
        if missing > 0 and len(self._text) == self._stored:
            self._read_text(place)
        if self._document_left == 0:
            self.buffer = self._in_place()

    def _read_text(self, place):
        text = self._text
        if self._stored < self._text_bytes:
            text = TextCodec().decode(text, self._text_bytes)
            need(text is not None, place, "has a text that cannot be decoded")
        c = Cursor(text, place)
        self._source(c)
        entries = c.many(lambda: _object_text(c))
        need(
            len(entries) == self.all_objects, place, "has another number of objects than the head"
        )
        need(self.source.format == self.format, place, "has another format than the head")
        runs = c.many(lambda: (c.u64(), c.u64()))
        self._order = _buffer_order(runs, self._buffer_bytes, place)
        self._json(text[c.at :], place)
        for number, (name, scale, mesh, names) in enumerate(entries):
            if number == len(self.objects):
                self.objects.append(StreamObject(number, place))
            submeshes = named_by(self.gltf, mesh, [Submesh(*s, ()) for s in names])
            self.objects[number].name_as(name, scale, mesh, submeshes)

    def _source(self, c):
        kind, content_hash = c.u8(), c.u128()
        self.source = Source(source_format(kind, c.place), content_hash)
        self.obj = read_document(c)

    def _json(self, text, place):
        if self.obj:
            need(not text, place, "has JSON for an OBJ")
            return
        try:
            self.gltf = json.loads(bytes(text))
        except ValueError as e:
            raise FormatError(place, f"has JSON that cannot be read: {e}") from None


def _buffer_order(runs, length, place):
    """Starts and ends of the runs of the buffer in the order in which they come: those that are
    named, then what is between them."""
    order, end = [(start, start + size) for start, size in runs], 0
    for first, last in sorted(order):
        need(end <= first and last <= length, place, "has runs of the buffer that cannot be")
        if end < first:
            order.append((end, first))
        end = last
    return order + ([(end, length)] if end < length else [])


def _has_fields(data):
    """Whether the three numbers of a block have come; one that is wrong counts."""
    ended = length = 0
    for byte in data[:15]:
        length += 1
        if byte < 128 or length == 6:
            ended, length = ended + 1, 0
            if ended == 3:
                return True
    return False


def _object_text(c):
    name, scale, mesh = c.string(), c.f64(), c.u32()
    c.u32(), c.u32(), c.optional(c.u32)
    need(0 < scale < float("inf"), c.place, "has an object whose scale is not a number above 0")
    submesh = lambda: (c.string(), c.optional(c.string), c.u32())
    return name, scale, mesh, c.many(submesh)
