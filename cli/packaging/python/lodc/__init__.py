"""Continuous level of detail: builds .lodc files, and takes levels out of them as NumPy arrays.

>>> import lodc
>>> file = lodc.build("chair.glb", metric="hybrid")
>>> level = file.level(ratio=0.1)
>>> level.triangles.shape, level["TEXCOORD_0"].shape, level.error
"""

from .attribute import Attribute, Source
from .building import build
from .errors import FormatError, LodcWarning, ProgramError
from .file import LodFile
from .level import Level
from .level_object import LevelObject
from .lods import Stream
from .lods.object import StreamObject
from .object import Object
from .opening import open, stream
from .plotting import plot
from .program import program
from .scene import Image, Instance, Scene, Submesh

__all__ = [
    "Attribute", "FormatError", "Image", "Instance", "Level", "LevelObject", "LodFile",
    "LodcWarning", "Object", "ProgramError", "Scene", "Source", "Stream", "StreamObject", "Submesh",
    "build", "open", "plot", "program", "stream",
]  # fmt: skip
