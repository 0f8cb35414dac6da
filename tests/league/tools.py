"""Tools that make levels of a GLB, as far as they are installed. Each returns a scene."""

import pathlib
import subprocess
import tempfile

import numpy as np

import scene

GLTFPACK = {"si": [], "sv": ["-sv"], "sa": ["-sa"], "sp": ["-sp"], "sv-sp": ["-sv", "-sp"]}
MESHOPTIMIZER = {
    "glTF-Transform simplify": "transform",
    "meshoptimizer simplifyWithAttributes": "attributes",
    "meshoptimizer simplifyWithUpdate": "update",
    "meshoptimizer simplifyWithUpdate, permissive": "permissive",
}
HERE = pathlib.Path(__file__).parent


class Failed(Exception):
    """A tool made nothing of a model."""


def run(words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode:
        raise Failed((done.stderr or done.stdout).strip()[-200:])
    return done.stdout


def of_files(words):
    """A tool that writes a GLB: ``words`` returns its command line."""

    def level(path, whole, ratio):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out.glb"
            run(words(path, ratio, out))
            return scene.read(out)

    return level


def gltfpack(folder, flags):
    program = folder / "node_modules/gltfpack/cli.js"
    kept = ["-se", "1", "-noq", "-kn", "-km", "-kv"]
    return of_files(lambda path, ratio, out: [
        "node", program, "-i", path, "-o", out, "-si", ratio, *kept, *flags
    ])  # fmt: skip


def meshoptimizer(folder, way):
    return of_files(lambda path, ratio, out: [
        "node", HERE / "other_tools.mjs", folder, path, ratio, way, out
    ])  # fmt: skip


def of_shapes(simplify):
    """A tool that knows positions and triangles: each material of the scene by itself.
    ``simplify`` takes points, faces, texture coordinates by corner and a count; it returns points,
    faces and texture coordinates or None."""

    def level(path, whole, ratio):
        parts = []
        for material in np.unique(whole.material_of):
            own = whole.material_of == material
            corners = whole.positions[own].reshape(-1, 3)
            points, faces = np.unique(corners, axis=0, return_inverse=True)
            faces = faces.reshape(-1, 3).astype(np.int32)
            distinct = (np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)
            uv = whole.coordinates[own][distinct]
            found = points, faces[distinct], uv
            if distinct.sum() >= 4:
                found = simplify(*found, max(1, int(own.sum() * ratio)))
            points, faces, uv = found
            if len(faces):
                uv = np.zeros((len(faces), 3, 2)) if uv is None else uv
                parts.append((points[faces], uv, np.full(len(faces), material)))
        if not parts:
            raise Failed("nothing is left")
        positions, uv, material_of = (np.concatenate(column) for column in zip(*parts))
        return scene.Scene(
            positions.astype(np.float32),
            scene.creased(positions).astype(np.float32),
            uv.astype(np.float32),
            np.ones((*positions.shape[:2], 4), np.float32),
            material_of.astype(np.int32),
            whole.materials,
            whole.images,
        )

    return level


def pymeshlab(with_texture):
    import pymeshlab as library

    def simplify(points, faces, uv, count):
        meshes = library.MeshSet()
        if not with_texture:
            meshes.add_mesh(library.Mesh(vertex_matrix=points.astype(float), face_matrix=faces))
            meshes.meshing_decimation_quadric_edge_collapse(
                targetfacenum=count, preservenormal=True
            )
            made = meshes.current_mesh()
            return made.vertex_matrix(), made.face_matrix(), None
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.obj"
            with open(path, "w") as out:
                out.write("mtllib a.mtl\nusemtl a\n")
                out.writelines("v %r %r %r\n" % tuple(p) for p in points.tolist())
                out.writelines("vt %r %r\n" % tuple(c) for c in uv.reshape(-1, 2).tolist())
                for i, (a, b, c) in enumerate((faces + 1).tolist()):
                    out.write(f"f {a}/{3 * i + 1} {b}/{3 * i + 2} {c}/{3 * i + 3}\n")
            meshes.load_new_mesh(str(path))
        meshes.meshing_decimation_quadric_edge_collapse_with_texture(
            targetfacenum=count, preservenormal=True
        )
        made = meshes.current_mesh()
        kept = made.wedge_tex_coord_matrix().reshape(-1, 3, 2)
        return made.vertex_matrix(), made.face_matrix(), kept

    return of_shapes(simplify)


def fast_simplification():
    import fast_simplification as library

    def simplify(points, faces, uv, count):
        return *library.simplify(points.astype(np.float32), faces, target_count=count), None

    return of_shapes(simplify)


def open3d():
    from open3d import geometry, utility

    def simplify(points, faces, uv, count):
        mesh = geometry.TriangleMesh(
            utility.Vector3dVector(points.astype(float)), utility.Vector3iVector(faces)
        )
        mesh = mesh.simplify_quadric_decimation(target_number_of_triangles=count)
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles), None

    return of_shapes(simplify)


def installed(folder):
    """Tools by name, each with whether it keeps what a picture shows, and the names of those that
    are absent."""
    modules = folder / "node_modules"
    tools, absent = {}, []

    def offer(name, is_there, make, is_shown):
        try:
            if is_there:
                tools[name] = make(), is_shown
                return
        except ImportError:
            pass
        absent.append(name)

    for name, flags in GLTFPACK.items():
        there = (modules / "gltfpack").exists()
        title = f"gltfpack {' '.join(['-si', *flags])}"
        offer(title, there, lambda flags=flags: gltfpack(folder, flags), "all")
    for name, way in MESHOPTIMIZER.items():
        there = (modules / "@gltf-transform/functions").exists()
        offer(name, there, lambda way=way: meshoptimizer(folder, way), "all")
    offer("PyMeshLab with texture", True, lambda: pymeshlab(True), "textured")
    offer("PyMeshLab", True, lambda: pymeshlab(False), "plain")
    offer("fast-simplification", True, fast_simplification, "plain")
    offer("Open3D", True, open3d, "plain")
    return tools, absent
