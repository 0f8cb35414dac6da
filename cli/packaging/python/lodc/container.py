"""The sections of a .lodc file."""

import struct

from .errors import FormatError, need
from .header import check_header
from .xxh3 import xxh3_64

MAGIC = b"\x89LODC\r\n\x1a"
HEADER = 40
SCENE = 0xFFFFFFFF
REQUIRED, WIDE, HINTS = 1, 2, 0xFFFF0000
MAY_BE_WIDE = {b"POSI", b"TRIS", b"TARG", b"ATTR", b"MODA"}
KNOWN = {
    b"MANI", b"DJSN", b"DBLB", b"POSI", b"VSUB", b"TRIS", b"TARG", b"JOIN", b"SERR", b"STRI",
    b"SRMS", b"LOCK", b"ATTR", b"MODA", b"POSE", b"MADE", b"LEVL",
}  # fmt: skip


class Container:
    """The sections by tag, object and index. ``skipped`` names those that this reader does not
    know and need not know, ``wide`` holds the keys of those that are as a device takes them."""

    def __init__(self, data: memoryview) -> None:
        need(len(data) >= HEADER, "header", "the file ends within its header")
        check_header(data[:HEADER], MAGIC, ".lodc file", xxh3_64, 8)
        count, length, check = struct.unpack_from("<IQQ", data, 12)
        end = HEADER + 40 * count
        need(length == len(data), "header", f"the file has {len(data)} bytes, not {length}")
        need(end <= length, "header", "the section table is longer than the file")
        found = xxh3_64(bytes(data[HEADER:end]))
        need(found == check, "section table", "does not match its checksum")
        self.sections, self.wide, self.skipped = {}, set(), []
        at = end
        for entry in range(HEADER, end, 40):
            at = self._section(data, entry, at)
        need(at == length, "section table", "the file goes on after its last section")

    def _section(self, data, entry, before):
        tag, flags, obj, index, offset, length, check = struct.unpack_from("<4sIIIQQQ", data, entry)
        name = tag.decode("ascii", "replace")
        place = f"section {name}" + ("" if obj == SCENE else f" of object {obj}")
        align = 256 if flags & WIDE else 16
        start = -(-before // align) * align
        need(offset == start and offset + length <= len(data), place, "is not where it should be")
        need(not any(data[before:start]), place, "follows bytes that are not 0")
        allowed = REQUIRED | HINTS | (WIDE if tag in MAY_BE_WIDE else 0)
        need(not flags & ~allowed & 0xFFFFFFFF, place, "has a flag that is not known")
        content = data[start : start + length]
        need(xxh3_64(content) == check, place, "does not match its checksum")
        if tag in KNOWN:
            need((tag, obj, index) not in self.sections, place, "occurs twice")
            self.sections[tag, obj, index] = content
            if flags & WIDE:
                self.wide.add((tag, obj, index))
        else:
            need(not flags & REQUIRED, place, "is required: a newer reader is needed")
            self.skipped.append(name)
        return start + length

    def take(self, tag: bytes, obj: int = SCENE, index: int = 0) -> memoryview:
        """A section that must be there."""
        content = self.sections.get((tag, obj, index))
        if content is None:
            where = "" if obj == SCENE else f" of object {obj}"
            raise FormatError(f"section {tag.decode()}{where}", "is not there")
        return content
