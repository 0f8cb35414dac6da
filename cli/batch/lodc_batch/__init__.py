"""Builds the assets of a list on the workers of a Dask cluster.

Every asset is one task. A task claims the memory that its asset may need (the resource `MEM`, in
bytes, of a worker) and runs `lodc build` with that limit. An asset that needs more ends with status
5, once. A task whose worker is lost runs again on another one. Inputs, outputs and `lodc` itself
are reached by the same paths on every machine.
"""

from .cluster import build
from .tasks import Task, read_list

__all__ = ["Task", "build", "read_list"]
