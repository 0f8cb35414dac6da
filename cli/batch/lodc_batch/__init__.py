"""Builds the assets of a list on the workers of a Dask cluster.

Every asset is one task. A task claims the memory that `lodc build --estimate` says its asset needs
(the resource `MEM`, in bytes, of a worker) and runs `lodc build` with that limit; one that needs
more runs once more with all that a worker has. A task whose worker is lost runs again on another
one. Inputs and outputs are reached by the same paths on every machine, or by URLs; so is `lodc`.
"""

from .cluster import ClusterError, build
from .tasks import Task, read_list

__all__ = ["ClusterError", "Task", "build", "read_list"]
