"""Making files."""

import json
import os
import tempfile
from warnings import warn

from .errors import LodcWarning
from .file import LodFile
from .program import options as words_of
from .program import run


def build(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    metric: str | None = None,
    models: str = "none",
    **options: object,
) -> LodFile:
    """Makes a file with every level of a glTF, GLB, OBJ, PLY or STL file, and writes it to
    ``output`` if that is given.

    ``metric`` is ``quadric`` (the default), ``hybrid``, ``viewpoint`` or ``kl``; ``models`` names
    structures to store besides, separated by commas. Further ``options`` are those of ``lodc
    build``: ``lock_border=True``, ``weight={"uv": 0.5}``, ``lock=["material:face"]``,
    ``importance="COLOR_0"``.

    Warnings of the build are warned of (:class:`LodcWarning`), and stay in ``warnings``.

    Raises TypeError if there is no such option, ValueError if its value is wrong,
    :class:`FormatError` (a ValueError, too) if the mesh is, :class:`ProgramError` if a limit is
    reached or the output cannot be written.
    """
    if not isinstance(source, (str, os.PathLike)):
        raise TypeError(f"{source!r}: not the path of a mesh")
    path = os.path.abspath(source)
    os.stat(path)  # Raises what Python raises for a file that is not there.
    words = ["build", *words_of({"metric": metric, "models": models, **options})]
    with tempfile.TemporaryDirectory() as folder:
        made = os.path.join(folder, "file.lodc") if output is None else os.fspath(output)
        said = run([*words, "--report", "json", "-o", made, "--", os.fspath(source)])[0]
        with open(made, "rb") as file:
            data = file.read()
    warnings: list[str] = json.loads(said)["inputs"][0]["warnings"]
    for what in warnings:
        warn(f"{os.fspath(source)}: {what}", LodcWarning, stacklevel=2)
    return LodFile(data, os.path.dirname(path), warnings)
