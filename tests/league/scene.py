"""Triangles of a GLB as its nodes place them, each corner by itself, with base colours."""

import dataclasses
import io
import json
import pathlib
import struct

import numpy as np
from PIL import Image

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
READ = {"KHR_mesh_quantization", "KHR_texture_transform", "EXT_mesh_gpu_instancing"}
MODES = {"OPAQUE": 0, "MASK": 1, "BLEND": 2}
LARGEST_IMAGE = 1024
CREASE = np.cos(np.radians(60))


@dataclasses.dataclass
class Scene:
    """``positions``, ``normals`` (n, 3, 3), ``coordinates`` (n, 3, 2), ``colours`` (n, 3, 4),
    ``material_of`` (n), rows of ``materials`` as draw.c takes them, ``images`` (h, w, 4)."""

    positions: np.ndarray
    normals: np.ndarray
    coordinates: np.ndarray
    colours: np.ndarray
    material_of: np.ndarray
    materials: np.ndarray
    images: list

    def is_painted(self):
        """Whether a picture needs more than the shape."""
        return bool(self.images) or bool((self.colours != 1).any())


class Glb:
    """The parts of a file."""

    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.document = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]
        missing = set(self.document.get("extensionsRequired", [])) - READ
        if missing:
            raise ValueError(f"{path} requires {sorted(missing)}")

    def write(self, path):
        """Writes the file, with its one buffer as long as it has become."""
        self.binary += bytes(-len(self.binary) % 4)
        self.document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        parts = [(0x4E4F534A, text), (0x004E4942, self.binary)]
        body = b"".join(struct.pack("<II", len(part), kind) + part for kind, part in parts)
        head = struct.pack("<III", 0x46546C67, 2, 12 + len(body))
        pathlib.Path(path).write_bytes(head + body)

    def view(self, index):
        """The bytes of a buffer view."""
        view = self.document["bufferViews"][index]
        return self.binary[view.get("byteOffset", 0) :][: view["byteLength"]]

    def values(self, index):
        """The values of an accessor, one row an element, normalised ones as they count."""
        accessor = self.document["accessors"][index]
        kind, width = np.dtype("<" + COMPONENTS[accessor["componentType"]]), SIZES[accessor["type"]]
        if "bufferView" not in accessor:
            return np.zeros((accessor["count"], width), np.float32)
        data = self.view(accessor["bufferView"])
        view = self.document["bufferViews"][accessor["bufferView"]]
        stride = view.get("byteStride", width * kind.itemsize)
        shape, steps = (accessor["count"], width), (stride, kind.itemsize)
        offset = accessor.get("byteOffset", 0)
        found = np.ndarray(shape, kind, data, offset, steps).copy()
        if accessor.get("normalized"):
            found = np.maximum(found.astype(np.float32) / np.iinfo(kind).max, -1)
        return found


def own_matrix(node):
    """What a node does to what is below it."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(turn) * node.get("scale", [1, 1, 1])
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def placed(document):
    """Meshes of the scene by number, each with a matrix; those of skins as they were modelled."""
    nodes, found = document["nodes"], []
    below = [(root, np.eye(4)) for root in document["scenes"][document.get("scene", 0)]["nodes"]]
    while below:
        number, matrix = below.pop()
        node = nodes[number]
        matrix = matrix @ own_matrix(node)
        if "mesh" in node:
            found.append((node["mesh"], np.eye(4) if "skin" in node else matrix))
        below += [(child, matrix) for child in node.get("children", [])]
    return found


def material_row(material, images):
    """A material as draw.c takes it; ``images`` are numbers by texture."""
    base = material.get("pbrMetallicRoughness", {})
    colour = base.get("baseColorFactor", [1, 1, 1, 1])
    texture = images.get(base.get("baseColorTexture", {}).get("index"), -1)
    shown = [c ** (1 / 2.2) for c in colour[:3]]
    mode = MODES[material.get("alphaMode", "OPAQUE")]
    two_sided = float(material.get("doubleSided", False))
    return [*shown, colour[3], texture, two_sided, mode, material.get("alphaCutoff", 0.5)]


def base_images(glb):
    """The images of base colours, and their numbers by texture."""
    images, of_texture, of_source = [], {}, {}
    for material in glb.document.get("materials", []):
        texture = material.get("pbrMetallicRoughness", {}).get("baseColorTexture", {}).get("index")
        source = None if texture is None else glb.document["textures"][texture].get("source")
        if source is None or "bufferView" not in glb.document["images"][source]:
            continue
        if source not in of_source:
            view = glb.document["images"][source]["bufferView"]
            image = Image.open(io.BytesIO(glb.view(view))).convert("RGBA")
            image.thumbnail((LARGEST_IMAGE, LARGEST_IMAGE), Image.Resampling.BOX)
            of_source[source] = len(images)
            images.append(np.ascontiguousarray(image))
        of_texture[texture] = of_source[source]
    return images, of_texture


def read(path):
    """The triangles of a file."""
    glb = Glb(path)
    images, of_texture = base_images(glb)
    materials = [[1, 1, 1, 1, -1, 0, 0, 0.5]]
    materials += [material_row(m, of_texture) for m in glb.document.get("materials", [])]
    parts = []
    for mesh, matrix in placed(glb.document):
        for primitive in glb.document["meshes"][mesh]["primitives"]:
            part = primitive_parts(glb, primitive, matrix)
            if part is not None:
                parts.append(part)
    joined = [np.concatenate(column) for column in zip(*parts)]
    positions, normals, coordinates, colours, material_of = joined
    normals = np.where(np.isnan(normals), creased(positions), normals)
    arrays = [a.astype(np.float32) for a in (positions, normals, coordinates, colours)]
    rows = np.array(materials, np.float32)
    return Scene(*arrays, material_of.astype(np.int32), rows, images)


def primitive_parts(glb, primitive, matrix):
    """The corners of a primitive's triangles; without normals these are not numbers."""
    attributes = primitive["attributes"]
    points = glb.values(attributes["POSITION"]).astype(float)
    if primitive.get("mode", 4) != 4 or not len(points):
        return None
    corners = np.arange(len(points))
    if "indices" in primitive:
        corners = glb.values(primitive["indices"]).ravel().astype(np.int64)
    corners = corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if np.linalg.det(matrix[:3, :3]) < 0:
        corners = corners[:, [0, 2, 1]]
    number = primitive.get("material", -1)
    texture = {}
    if number >= 0:
        material = glb.document["materials"][number]
        texture = material.get("pbrMetallicRoughness", {}).get("baseColorTexture", {})
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    normals = np.full(points.shape, np.nan)
    if "NORMAL" in attributes:
        normals = glb.values(attributes["NORMAL"]) @ np.linalg.inv(matrix[:3, :3])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    coordinates = np.zeros((len(points), 2))
    name = f"TEXCOORD_{texture.get('texCoord', 0)}"
    if name in attributes:
        coordinates = glb.values(attributes[name]).astype(float)
        moved = texture.get("extensions", {}).get("KHR_texture_transform", {})
        coordinates = coordinates * moved.get("scale", [1, 1]) + moved.get("offset", [0, 0])
    colours = np.ones((len(points), 4))
    if "COLOR_0" in attributes:
        found = glb.values(attributes["COLOR_0"])
        colours[:, : found.shape[1]] = found
    by_corner = [values[corners] for values in (points, normals, coordinates, colours)]
    return [*by_corner, np.full(len(corners), number + 1)]


def creased(positions):
    """Normals by corner: those of the faces around a point within 60 degrees of the corner's own,
    by area."""
    cross = np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0])
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-30)
    flat = np.ascontiguousarray(positions.reshape(-1, 3).astype(np.float32)) + np.float32(0)
    _, point = np.unique(flat, axis=0, return_inverse=True)
    point = point.ravel()
    order = np.argsort(point, kind="stable")
    starts = np.searchsorted(point[order], np.arange(point.max() + 2))
    sums = np.zeros((len(flat), 3))
    # The k-th corner at each point in turn: as many rounds as the most faces around one.
    counts = np.diff(starts)
    for k in range(min(int(counts.max()), 64)):
        other = order[np.minimum(starts[point] + k, len(order) - 1)] // 3
        counted = (k < counts[point]) & ((unit[other] * np.repeat(unit, 3, 0)).sum(1) >= CREASE)
        sums += cross[other] * counted[:, None]
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 0, sums / np.maximum(length, 1e-30), np.repeat(unit, 3, 0)).reshape(
        positions.shape
    )


SHOWN = ["name", "alphaMode", "alphaCutoff", "doubleSided"]


def prepare(path):
    """Leaves of a file's materials what a picture shows: base colours, and images of these that are
    inside. Where none is, noise becomes the image of all that has texture coordinates; returns
    whether it does."""
    glb = Glb(path)
    document, images, textures = glb.document, [], []
    for material in document.get("materials", []):
        base = material.get("pbrMetallicRoughness", {})
        kept = {k: base[k] for k in ("baseColorFactor", "baseColorTexture") if k in base}
        if "baseColorTexture" in kept:
            own = document["textures"][kept["baseColorTexture"]["index"]]
            image = document["images"][own["source"]] if "source" in own else {}
            if "bufferView" in image:
                kept["baseColorTexture"] = {**kept["baseColorTexture"], "index": len(textures)}
                textures.append({**own, "source": len(images)})
                images.append(image)
            else:
                del kept["baseColorTexture"]
        shown = {k: material[k] for k in SHOWN if k in material}
        material.clear()
        material.update(shown, pbrMetallicRoughness=kept)
    primitives = [p for mesh in document.get("meshes", []) for p in mesh["primitives"]]
    primitives = [p for p in primitives if "TEXCOORD_0" in p["attributes"]]
    painted = not images and bool(primitives)
    if painted:
        out = io.BytesIO()
        noise().save(out, "png")
        glb.binary += bytes(-len(glb.binary) % 4)
        at = {"buffer": 0, "byteOffset": len(glb.binary), "byteLength": len(out.getvalue())}
        document.setdefault("bufferViews", []).append(at)
        glb.binary += out.getvalue()
        view = len(document["bufferViews"]) - 1
        images, textures = [{"bufferView": view, "mimeType": "image/png"}], [{"source": 0}]
        materials = document.setdefault("materials", [])
        for primitive in primitives:
            if "material" not in primitive:
                primitive["material"] = len(materials)
                materials.append({})
            base = materials[primitive["material"]].setdefault("pbrMetallicRoughness", {})
            base["baseColorTexture"] = {"index": 0}
    for name, values in (("images", images), ("textures", textures)):
        document.pop(name, None)
        if values:
            document[name] = values
    for name in ("extensionsUsed", "extensionsRequired"):
        own = [e for e in document.pop(name, []) if e in READ]
        if own:
            document[name] = own
    glb.write(path)
    return painted


def noise():
    """An image with detail of every size: grains of 4 to 128 cells, added up."""
    random, size = np.random.default_rng(7), 512
    total = np.zeros((size, size, 3))
    for cells in (4, 8, 16, 32, 64, 128):
        grain = Image.fromarray(random.integers(0, 256, (cells, cells, 3), np.uint8))
        total += np.asarray(grain.resize((size, size), Image.Resampling.BILINEAR), float) - 127.5
    return Image.fromarray(np.clip(127.5 + 0.6 * total, 0, 255).astype(np.uint8))
