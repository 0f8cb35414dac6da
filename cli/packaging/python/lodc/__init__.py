"""Reads .lodc files and .lods streams of lodc: every level of detail as NumPy arrays.

>>> import lodc
>>> obj = lodc.open("bunny.lodc").objects[0]
>>> level = obj.level(ratio=0.1)
>>> level.triangles.shape, level.error
"""

import io
import os

from .attribute import Attribute, Source, Submesh
from .errors import FormatError
from .file import LodFile
from .level import Level
from .object import Object
from .stream import Stream
from .stream.object import StreamObject

__all__ = [
    "Attribute", "FormatError", "Level", "LodFile", "Object", "Source", "Stream", "StreamObject",
    "Submesh", "open", "open_stream",
]  # fmt: skip


def open(path):
    """Opens a .lodc file, by path or as bytes. Checks every sum."""
    return _named(path, LodFile)


def open_stream(path=None):
    """Opens a .lods stream: by path or as bytes (a prefix will do), or without either an empty one
    that is fed bytes as they come."""
    if path is None:
        return Stream()
    return _named(path, lambda data: Stream().feed(data))


def _named(path, read):
    if isinstance(path, (bytes, bytearray, memoryview)):
        return read(path)
    try:
        with io.open(path, "rb") as file:
            return read(file.read())
    except FormatError as e:
        e.file = os.fspath(path)
        raise
