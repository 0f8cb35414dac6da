"""Levels as meshes of the package trimesh."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray


from .level_object import LevelObject
from .scene import Instance, Scene, Submesh

if TYPE_CHECKING:
    import trimesh


def to_trimesh(scene: Scene, objects: list[LevelObject]) -> "trimesh.Trimesh":
    """All instances of a scene's objects as one mesh in the world."""
    try:
        import trimesh
    except ImportError:
        raise ImportError("to_trimesh needs the package trimesh: pip install trimesh") from None
    parts = _Parts()
    for instance in scene.instances:
        level = objects[instance.object]
        if len(level.triangles):
            parts.add(scene, instance, level)
    mesh: Any = trimesh.Trimesh(
        vertices=np.concatenate(parts.positions or [np.zeros((0, 3))]),
        faces=np.concatenate(parts.triangles or [np.zeros((0, 3), np.int64)]),
        process=False,
        metadata={"parts": parts.names},
    )
    mesh.face_attributes["part"] = np.concatenate(parts.parts or [np.zeros(0, np.int32)])
    uv, colours = parts.whole("TEXCOORD_0"), parts.whole("COLOR_0")
    if uv is not None:
        # Its V goes up.
        uv = np.column_stack([uv[:, 0], 1 - uv[:, 1]])
        visual: Any = trimesh.visual
        mesh.visual = visual.TextureVisuals(uv=uv)
    elif colours is not None:
        mesh.visual.vertex_colors = np.round(colours * 255).astype(np.uint8)
    made: "trimesh.Trimesh" = mesh
    return made


class _Parts:
    """Arrays of all parts, not yet joined."""

    def __init__(self) -> None:
        self.positions: list[NDArray[Any]] = []
        self.triangles: list[NDArray[np.int64]] = []
        self.parts: list[NDArray[np.int32]] = []
        self.names: list[dict[str, Any]] = []
        self.values: dict[str, list[NDArray[Any]]] = {"TEXCOORD_0": [], "COLOR_0": []}
        self.count = 0

    def add(self, scene: Scene, instance: Instance, level: LevelObject) -> None:
        positions, turned = placed(scene, instance, level)
        triangles = level.triangles.astype(np.int64) + self.count
        self.triangles.append(triangles[:, ::-1] if turned else triangles)
        self.parts.append(level.submesh.astype(np.int32) + np.int32(len(self.names)))
        self.names += [_named(scene, instance, level.name, s) for s in level.submeshes]
        self.positions.append(positions)
        self.count += len(positions)
        for name, values in self.values.items():
            if name in level:
                values.append(level[name])

    def whole(self, name: str) -> NDArray[Any] | None:
        """The values of all vertices, if all have them, of one width."""
        found = self.values[name]
        widths = {v.shape[1] for v in found}
        joined = np.concatenate(found) if len(widths) == 1 else np.zeros((0, 0))
        return joined if len(joined) == self.count and self.count else None


def _named(scene: Scene, instance: Instance, name: str, submesh: Submesh) -> dict[str, Any]:
    material = scene.material(instance, submesh) or {}
    return {"object": name, "node": instance.name, "material": material.get("name")}


def placed(scene: Scene, instance: Instance, level: LevelObject) -> tuple[NDArray[Any], bool]:
    """Positions of an instance in the world, at rest, and whether its triangles are turned over."""
    local = level["POSITION"].astype(np.float64)
    for target, weight in enumerate(_weights(scene, instance)):
        if weight and ("POSITION", target) in level:
            local = local + weight * level["POSITION", target]
    columns = np.column_stack([local, np.ones(len(local))])
    matrix = instance.matrix
    if instance.skin is not None and "JOINTS_0" in level and "WEIGHTS_0" in level:
        joints = scene.joints(instance.skin)
        sets = [n for n in range(8) if f"JOINTS_{n}" in level and f"WEIGHTS_{n}" in level]
        numbers = np.concatenate([level[f"JOINTS_{n}"] for n in sets], axis=1).astype(np.int64)
        weights = np.concatenate([level[f"WEIGHTS_{n}"] for n in sets], axis=1).astype(np.float64)
        weights[numbers >= len(joints)] = 0
        # Weights need not add up to 1; without any, the vertex stays with its node.
        total = weights.sum(axis=1, keepdims=True)
        weights = np.divide(weights, total, out=np.zeros_like(weights), where=total > 0)
        each = joints[np.minimum(numbers, len(joints) - 1)]
        blended = np.einsum("vj,vjrc->vrc", weights, each)
        blended[total[:, 0] <= 0] = matrix
        return np.einsum("vrc,vc->vr", blended, columns)[:, :3], False
    turned = bool(np.linalg.det(matrix[:3, :3]) < 0)
    return (columns @ matrix.T)[:, :3], turned


def _weights(scene: Scene, instance: Instance) -> list[float]:
    """The weights of morph targets at rest."""
    if scene.gltf is None or instance.node is None:
        return []
    node = scene.gltf["nodes"][instance.node]
    mesh = scene.gltf.get("meshes", [])[node["mesh"]]
    weights: list[float] = node.get("weights", mesh.get("weights", []))
    return weights
