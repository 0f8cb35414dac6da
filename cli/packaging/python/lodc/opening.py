"""Opening files and streams."""

import builtins
import os
from collections.abc import Callable
from typing import TypeVar

from .errors import FormatError
from .file import LodFile
from .lods import Stream

File = str | os.PathLike[str] | bytes | bytearray | memoryview
"""A file by its path, or its bytes."""
T = TypeVar("T")


def open(file: File) -> LodFile:
    """Opens a .lodc file, by path or as bytes. Checks every sum."""
    return _named(file, LodFile)


def stream(file: File | None = None) -> Stream:
    """Opens a .lods stream: by path or as bytes (a prefix will do), or without either an empty one
    that is fed bytes as they come."""
    if file is None:
        return Stream()
    return _named(file, lambda data, folder=None: Stream(folder).feed(data))


def _named(file: File, read: Callable[..., T]) -> T:
    if isinstance(file, (bytes, bytearray, memoryview)):
        return read(bytes(file))
    if not isinstance(file, (str, os.PathLike)):
        raise TypeError(f"{file!r}: neither the path of a file nor its bytes")
    try:
        with builtins.open(file, "rb") as opened:
            return read(opened.read(), os.path.dirname(os.path.abspath(file)))
    except FormatError as e:
        e.file = os.fspath(file)
        raise
