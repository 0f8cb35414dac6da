"""Plots of how error rises while triangles go."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .file import LodFile
from .opening import File
from .opening import open as open_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot(file: LodFile | File, ax: "Axes | None" = None) -> "Axes":
    """Draws the error of every level over its triangles, a line for each object. Needs
    matplotlib."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("plot needs the package matplotlib: pip install matplotlib") from None
    opened = file if isinstance(file, LodFile) else open_file(file)
    axes: Any = plt.subplots()[1] if ax is None else ax
    for obj in opened.objects:
        shown = (obj.counts > 0) & np.isfinite(obj.errors) & (obj.errors > 0)
        axes.step(obj.counts[shown], obj.errors[shown], where="post", label=obj.name or "mesh")
    axes.set(xscale="log", yscale="log", xlabel="triangles", ylabel="error (mesh units)")
    if len(opened.objects) > 1:
        axes.legend()
    found: "Axes" = axes
    return found
