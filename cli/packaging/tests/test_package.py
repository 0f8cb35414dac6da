"""The wheel, installed: the scripts of its README run, and what they say is so.

Run in a Python that has the wheel, trimesh, matplotlib and mypy; `tests/run --all` does.
"""

import contextlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import trimesh

import lodc

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
FIXTURES = ROOT / "fixtures"
README = (HERE.parent / "README.md").read_text(encoding="utf-8")
FRONT = (ROOT / "README.md").read_text(encoding="utf-8")


def scripts(text):
    """The Python of a page, block by block."""
    return [block.split("```")[0] for block in text.split("```python\n")[1:]]


class Fresh(unittest.TestCase):
    """A test in a folder of its own, with a mesh in it."""

    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.enterContext(contextlib.chdir(folder))
        pathlib.Path("part.glb").write_bytes((FIXTURES / "machine_part.glb").read_bytes())

    def run_script(self, script):
        """Runs a script as a user would; what it prints."""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


class Pages(Fresh):
    def test_the_scripts_of_the_page_run(self):
        whole, stream, structures = scripts(README)
        self.assertLessEqual(len(whole.splitlines()), 32)
        said = self.run_script(whole)
        self.assertIn("480 triangles in ['mesh0']", said)
        self.assertIn(" 10%     48 triangles", said)
        self.assertIn("(48, 3)", said)
        self.assertIn("ratio='many': neither a number nor text that is one", said)
        self.assertTrue(all(map(os.path.getsize, ["part.lodc", "part.10percent.obj", "part.png"])))
        lodc_program("pack", "part.lodc", "-o", "part.lods", "-q")
        self.assertIn("480 triangles, off by 0.0", self.run_script(stream))
        self.assertTrue(os.path.getsize("whole.glb"))
        self.run_script(structures)

    def test_the_front_page_runs(self):
        [script] = scripts(FRONT)
        self.assertLessEqual(len(script.splitlines()), 6)
        os.mkdir("fixtures")
        os.rename("part.glb", "fixtures/machine_part.glb")
        self.assertIn("48 triangles", self.run_script(script))

    def test_scripts_have_the_types_that_the_package_says(self):
        for number, script in enumerate(scripts(README)):
            pathlib.Path(f"script{number}.py").write_text(script)
        words = [
            "mypy",
            "--strict",
            "--follow-imports=silent",
            *sorted(map(str, pathlib.Path().glob("*.py"))),
        ]
        done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)


def lodc_program(*words):
    subprocess.run([lodc.program(), *words], check=True)


class Levels(Fresh):
    def test_levels_are_those_that_the_program_writes(self):
        wishes = [
            {"ratio": "25%"},
            {"ratio": 0.1},
            {"triangles": 100},
            {"error": "0.5%"},
            {"error": 0.3},
        ]
        file = lodc.build("part.glb")
        for wish in wishes:
            [(name, value)] = wish.items()
            file.write("part.lodc")
            words = [f"--{name}", str(value), "--no-refit", "-o", "level.glb", "-q"]
            lodc_program("extract", "part.lodc", *words)
            self.assertEqual(
                file.level(**wish).to_glb(), pathlib.Path("level.glb").read_bytes(), wish
            )

    def test_arrays_are_those_of_a_glb(self):
        for name in ["machine_part.glb", "terrain.obj", "coloured_cube.glb", "quantised_torus.glb"]:
            level = lodc.build(FIXTURES / name).level(ratio=0.5)
            widths = {name: level[name].shape[1] for name in sorted(level)}
            theirs = [row for part in glb_corners(level.to_glb(), widths) for row in part]
            own = np.column_stack([level[name] for name in widths])[level.triangles.reshape(-1)]
            self.assertEqual(sorted(theirs), sorted(rounded(own)), (name, widths))

    def test_several_objects_are_shared_out_and_placed_as_the_program_does_it(self):
        two_objects("two.gltf")
        file = lodc.build("two.gltf")
        self.assertEqual([i.name for i in file.scene.instances], ["a", "b", "c"])
        level = file.level(ratio=0.3)
        scene = trimesh.load(io.BytesIO(level.to_glb()), file_type="glb")
        self.assertEqual(level.triangle_count, sum(len(g.faces) for g in scene.geometry.values()))
        np.testing.assert_allclose(level.to_trimesh().bounds, scene.bounds, atol=1e-5)

    def test_a_level_of_several_objects_has_their_arrays_one_after_the_other(self):
        two_objects("two.gltf")
        level = lodc.build("two.gltf").level(ratio=0.5)
        self.assertGreater(len(level.objects), 1)
        self.assertEqual(level.triangles.shape, (level.triangle_count, 3))
        self.assertEqual(len(level["POSITION"]), sum(len(o["POSITION"]) for o in level.objects))
        for number, part in enumerate(level.objects):
            corners = level["POSITION"][level.triangles[level.owner == number]]
            np.testing.assert_array_equal(corners, part["POSITION"][part.triangles])
            self.assertEqual((level.submesh[level.owner == number] == part.submesh).all(), True)
        self.assertIsNone(level.lod)
        self.assertLess(len(repr(level)), 80)
        with self.assertRaisesRegex(KeyError, "COLOR_7"):
            level["COLOR_7"]

    def test_facts_are_those_of_levels(self):
        two_objects("two.gltf")
        for source in ["two.gltf", "part.glb"]:
            file = lodc.build(source)
            for share, triangles, error in file.facts():
                level = file.level(ratio=share)
                self.assertEqual((triangles, error), (level.triangle_count, level.error), source)

    def test_levels_of_ten_scenes_are_those_of_the_program(self):
        for number in range(10):
            grids("scene.gltf", [4 + (5 * i + 3 * number) % 13 for i in range(1 + number % 4)])
            file = lodc.build("scene.gltf", "scene.lodc", models="none")
            facts = file.facts()
            self.assertEqual([share for share, _, _ in facts], [1, 0.5, 0.25, 0.1, 0.05, 0.01])
            for share, triangles, error in facts:
                level = file.level(ratio=share)
                words = ["extract", "scene.lodc", "--ratio", str(share), "--no-refit"]
                done = subprocess.run(
                    [lodc.program(), *words, "-o", "level.glb", "--json", "-q"],
                    check=True,
                    capture_output=True,
                )
                said = json.loads(done.stdout)
                lods = [o["lod"] for o in said["objects"]]
                self.assertEqual([o.lod for o in level.objects], lods, (number, share))
                self.assertEqual(level.triangle_count, said["triangles"], (number, share))
                self.assertAlmostEqual(level.error, said["error"], delta=1e-6 * said["error"])
                self.assertEqual((triangles, error), (level.triangle_count, level.error))

    def test_submeshes_name_their_materials(self):
        root = json.loads((FIXTURES / "cube.gltf").read_text())
        root["materials"] = [{"name": "oak"}, {}]
        root["meshes"][0]["primitives"][0]["material"] = 0
        primitive = root["meshes"][0]["primitives"][0]
        root["meshes"][0]["primitives"] += [{**primitive, "material": 1}]
        without = {key: value for key, value in primitive.items() if key != "material"}
        root["meshes"][0]["primitives"] += [without]
        pathlib.Path("cube.bin").write_bytes((FIXTURES / "cube.bin").read_bytes())
        pathlib.Path("cube.gltf").write_text(json.dumps(root))
        [cube] = lodc.build("cube.gltf").objects
        self.assertEqual([s.material for s in cube.submeshes], ["oak", "", None])
        self.assertEqual([s.material for s in cube.at(0).submeshes], ["oak", "", None])

    def test_a_skin_places_its_vertices(self):
        file = lodc.build(FIXTURES / "skinned_tube_u8.glb")
        placed = file.level(ratio=1).to_trimesh()
        placed.export("placed.ply")
        words = [
            "compare",
            str(FIXTURES / "skinned_tube_u8.glb"),
            "placed.ply",
            "--views",
            "0",
            "--json",
        ]
        said = json.loads(
            subprocess.run([lodc.program(), *words], check=True, capture_output=True).stdout
        )
        self.assertLess(said["hausdorff"]["max"], 1e-5 * said["diagonal"])

    def test_images_are_found_in_the_file_and_beside_it_alone(self):
        folder = pathlib.Path("model")
        folder.mkdir()
        for name, uri in [("beside", "a b.png"), ("above", "../part.glb")]:
            two_objects(folder / f"{name}.gltf", images=[{"uri": uri.replace(" ", "%20")}])
        (folder / "a b.png").write_bytes(b"\x89PNG not really")
        [image] = lodc.build(folder / "beside.gltf").scene.images
        self.assertEqual((image.uri, image.data), ("a%20b.png", b"\x89PNG not really"))
        [image] = lodc.build(folder / "above.gltf").scene.images
        self.assertIsNone(image.data)


class Errors(Fresh):
    def test_what_is_wrong_is_said_in_words(self):
        file = lodc.build("part.glb")
        mistaken = [
            (lambda: file.level(), "exactly one of lod, ratio"),
            (lambda: file.level(ratio=0.5, lod=3), "given: lod and ratio"),
            (lambda: file.level(ratio=True), "neither a number"),
            (lambda: file.level(triangles=[1]), "neither a number"),
            (lambda: lodc.open(3), "neither the path"),
            (lambda: lodc.build(3), "not the path"),
            (lambda: lodc.build("part.glb", colour=[{1}]), "colour"),
            (lambda: lodc.build("part.glb", no_such_option=1), "'no_such_option': unknown option$"),
            (
                lambda: lodc.build("part.glb", lock_bordr=True),
                "'lock_bordr': unknown option; did you mean 'lock_border'",
            ),
        ]
        wrong = [
            (lambda: lodc.build("part.glb", importance="_FACE"), "no object has the attribute"),
            (lambda: file.level(ratio=1.5), "from 0 to 1"),
            (lambda: file.level(triangles=2.5), "whole number"),
            (lambda: file.level(error="near"), "neither a number"),
            (lambda: file.level(error=-1), "not a distance"),
            (lambda: file.level(error=float("nan")), "not a distance"),
            (lambda: file.level(lod="10%"), "whole number"),
            (lambda: lodc.open(b"junk" * 20), "not a .lodc file"),
            (lambda: lodc.stream(b"junk" * 20), "not a .lods stream"),
            (lambda: lodc.build("part.glb", metric="best"), "'best' .*possible values: quadric"),
            (lambda: lodc.build(FIXTURES / "x_nan.obj"), "line 4"),
        ]
        for kind, calls in [(TypeError, mistaken), (ValueError, wrong)]:
            for call, words in calls:
                with self.assertRaisesRegex(kind, words) as raised:
                    call()
                self.assertNotIn("Usage", str(raised.exception))
                self.assertEqual(len(str(raised.exception).splitlines()), 1)
        with self.assertRaises(FileNotFoundError):
            lodc.build("missing.glb")
        with self.assertRaisesRegex(KeyError, "POSITION"):
            file.level(lod=0)["TEXCOORD_9"]
        with self.assertRaisesRegex(lodc.ProgramError, "more than 10 triangles") as limit:
            lodc.build("part.glb", limit="triangles=10")
        self.assertEqual(limit.exception.status, 5)

    def test_warnings_are_warned_of(self):
        pathlib.Path("odd.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl none\nf 1 2 3\n")
        with self.assertWarnsRegex(lodc.LodcWarning, "^odd.obj: .*none"):
            file = lodc.build("odd.obj")
        self.assertEqual(len(file.warnings), 1)

    def test_a_file_is_shown_in_one_line(self):
        self.assertEqual(repr(lodc.build("part.glb")), "<lodc file: 'mesh0', 480 triangles>")
        two_objects("two.gltf")
        said = repr(lodc.build("two.gltf"))
        self.assertRegex(said, r"^<lodc file: \d objects, \d+ triangles>$")

    def test_a_notebook_shows_tables(self):
        file = lodc.build("part.glb")
        self.assertIn("<td>480</td>", file._repr_html_())
        self.assertIn("<td>48</td>", file.level(ratio=0.1)._repr_html_())


def rounded(rows):
    return map(tuple, (np.round(rows.astype(np.float64), 5) + 0.0).tolist())


def glb_corners(data, attributes):
    """The values of all corners of a GLB, primitive by primitive; 0 for what one lacks."""
    length = int.from_bytes(data[12:16], "little")
    root, blob = json.loads(data[20 : 20 + length]), data[28 + length :]
    types = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
    widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

    def accessor(number):
        a = root["accessors"][number]
        view = root["bufferViews"][a["bufferView"]]
        dtype, width = np.dtype(types[a["componentType"]]), widths[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", dtype.itemsize * width)
        rows = [blob[start + i * stride :][: dtype.itemsize * width] for i in range(a["count"])]
        values = np.frombuffer(b"".join(rows), dtype).reshape(-1, width)
        return values / np.iinfo(dtype).max if a.get("normalized") else values

    for primitive in (p for mesh in root["meshes"] for p in mesh["primitives"]):
        found = {name: accessor(number) for name, number in primitive["attributes"].items()}
        count = len(found["POSITION"])
        parts = [found.get(name, np.zeros((count, width))) for name, width in attributes.items()]
        columns = np.column_stack(parts)
        yield rounded(columns[accessor(primitive["indices"]).reshape(-1)])


def grids(path, sizes):
    """A scene of wavy sheets, scaled by their nodes."""
    data, views, accessors, meshes, nodes = b"", [], [], [], []
    for number, size in enumerate(sizes):
        row, column = np.mgrid[0 : size + 1, 0 : size + 1]
        height = np.sin(row * (0.7 + number)) * np.cos(column * 0.9)
        points = np.stack([row, column, height], axis=-1).reshape(-1, 3).astype("<f4")
        first = (row * (size + 1) + column)[:-1, :-1].reshape(-1)
        corners = [first, first + size + 1, first + size + 2, first, first + size + 2, first + 1]
        indices = np.stack(corners, axis=-1).reshape(-1).astype("<u4")
        for array, kind in ((points, "VEC3"), (indices, "SCALAR")):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
            accessor = {"bufferView": len(views) - 1, "count": len(array), "type": kind}
            accessor["componentType"] = 5126 if kind == "VEC3" else 5125
            if kind == "VEC3":
                accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
            accessors.append(accessor)
            data += array.tobytes()
        attributes = {"POSITION": len(accessors) - 2}
        primitive = {"attributes": attributes, "indices": len(accessors) - 1}
        meshes.append({"name": f"sheet{number}", "primitives": [primitive]})
        scale = [[1, 1, 1], [0.25, 0.25, 0.25], [3, 1, 2]][number % 3]
        nodes.append({"mesh": number, "scale": scale})
    pathlib.Path(path).with_suffix(".bin").write_bytes(data)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": pathlib.Path(path).stem + ".bin"}],
    }
    pathlib.Path(path).write_text(json.dumps(document))


def two_objects(path, images=()):
    """A terrain twice and another one, below nodes that turn, scale and mirror."""
    source = trimesh.creation.icosphere(3)
    boxes = trimesh.creation.icosphere(2)
    data, views, accessors, meshes = b"", [], [], []
    for mesh in (source, boxes):
        primitive = {"attributes": {}}
        for kind, array in (
            ("POSITION", mesh.vertices.astype("<f4")),
            ("indices", mesh.faces.astype("<u4")),
        ):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
            vector = kind == "POSITION"
            accessor = {
                "bufferView": len(views) - 1,
                "componentType": 5126 if vector else 5125,
                "count": len(array) if vector else array.size,
                "type": "VEC3" if vector else "SCALAR",
            }
            if vector:
                accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
                primitive["attributes"]["POSITION"] = len(accessors)
            else:
                primitive["indices"] = len(accessors)
            accessors.append(accessor)
            data += array.tobytes()
        meshes.append({"primitives": [primitive]})
    nodes = [
        {"name": "a", "mesh": 0, "translation": [5, 0, 0], "children": [1]},
        {"name": "b", "mesh": 1, "rotation": [0, 0.6, 0, 0.8], "scale": [1, 2, -3]},
        {"name": "c", "mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]},
    ]
    path = pathlib.Path(path)
    path.with_suffix(".bin").write_bytes(data)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 2]}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": len(data)}],
    }
    if images:
        document["images"] = list(images)
        document["textures"] = [{"source": 0}]
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        meshes[0]["primitives"][0]["material"] = 0
    path.write_text(json.dumps(document))


if __name__ == "__main__":
    unittest.main()
