"""One level of detail as arrays."""

import numpy as np


class Level:
    """The triangles of one LOD of an object.

    ``triangles`` is *n* × 3, indices of the object's vertices; ``submesh`` has the submesh of each.
    ``error`` and ``rms`` are its distances from LOD 0 (``rms`` may be None).
    """

    def __init__(self, obj, lod, triangles, submesh):
        self.object, self.lod, self.triangles, self.submesh = obj, lod, triangles, submesh
        step = int(np.searchsorted(obj.lods, lod))
        self.error = float(obj.errors[step])
        self.rms = None if obj.rms is None else float(obj.rms[step])

    def of_submesh(self, number):
        """The triangles of one submesh."""
        return self.triangles[self.submesh == number]

    def compact(self):
        """Positions, values of each attribute, and triangles over only the vertices in use."""
        used, triangles = np.unique(self.triangles, return_inverse=True)
        values = [value[used] for value in self.object.values]
        return self.object.positions[used], values, triangles.reshape(-1, 3).astype(np.uint32)

    def __repr__(self):
        return f"<LOD {self.lod} of {self.object.name!r}: {len(self.triangles)} triangles>"
