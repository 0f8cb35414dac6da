//! What is quantised stands where it stood, to half a step.

use crate::export::{ExportFormat, ExportObject, ExportOptions, Precision, export_with};
use crate::gltf::read::tests::{Builder, parsed, read_bytes, sound};
use crate::import::ImportOptions;
use crate::{Limits, Scene, scene_graph};
use lodc_mesh::{Attribute, Component, Semantic};
use lodc_scene::{Arrangement, posed};
use serde_json::{Value, json};
use std::path::Path;

const SIDE: usize = 8;
const BITS: Precision = Precision {
    position: Some(12),
    normal: Some(10),
    uv: Some(11),
    color: Some(8),
    weight: Some(8),
};

/// Accessors of a curved sheet of `SIDE` by `SIDE` vertices: indices, and attributes.
fn sheet(b: &mut Builder) -> (usize, Value) {
    let grid_points = || (0..SIDE * SIDE).map(|i| [(i % SIDE) as f32, (i / SIDE) as f32]);
    let each = |f: &dyn Fn(f32, f32) -> Vec<f32>| -> Vec<f32> {
        grid_points().flat_map(|[x, y]| f(x, y)).collect()
    };
    let quads = (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| (y * SIDE + x) as u16));
    let s = SIDE as u16;
    let indices = quads.flat_map(|v| [v, v + 1, v + s, v + s, v + 1, v + s + 1]);
    let indices = b.indices(&indices.collect::<Vec<_>>());
    let positions = each(&|x, y| vec![x * 0.73 - 3.0, y * 1.1, (x * y * 0.37) % 1.3]);
    let normals = each(&|x, y| {
        let n = [x - 3.5, y - 3.5, 2.0 - x * 0.6];
        let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
        n.map(|c| c / length).to_vec()
    });
    let attributes = json!({
        "POSITION": b.floats("VEC3", 3, &positions),
        "NORMAL": b.floats("VEC3", 3, &normals),
        "TEXCOORD_0": b.floats("VEC2", 2, &each(&|x, y| vec![x * 0.31 - 0.7, 2.0 + y * 0.17])),
        "COLOR_0": b.floats("VEC3", 3, &each(&|x, y| vec![x / 7.0, y / 7.0, 0.3])),
    });
    (indices, attributes)
}

/// Two sheets, one below a node that turns and scales and moved by a morph target that an
/// animation weighs, the other one with a skin.
fn scene() -> Scene {
    let mut b = Builder::default();
    let (indices, plain) = sheet(&mut b);
    let count = SIDE * SIDE;
    let deltas: Vec<f32> = (0..3 * count).map(|i| (i % 11) as f32 * 0.21 - 1.0).collect();
    let target = json!({ "POSITION": b.floats("VEC3", 3, &deltas) });
    let mut skinned = sheet(&mut b).1;
    let joints: Vec<u8> = (0..count).flat_map(|i| [0, 1, 0, (i % 2) as u8]).collect();
    skinned["JOINTS_0"] = b.data(5121, "VEC4", count, &joints).into();
    let shares = |i: usize| [i as f32 / count as f32, 1.0 - i as f32 / count as f32, 0.0, 0.0];
    skinned["WEIGHTS_0"] =
        b.floats("VEC4", 4, &(0..count).flat_map(shares).collect::<Vec<_>>()).into();
    let matrix = |scale: f32, x: f32| {
        let s = scale;
        [s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, s, 0.0, x, 2.0, -1.0, 1.0]
    };
    let matrices = b.floats("MAT4", 16, &[matrix(1.0, 3.0), matrix(0.5, -2.0)].concat());
    b.accessors[matrices]["min"] = json!(vec![0.0; 16]);
    let times = b.floats("SCALAR", 1, &[0.0, 1.0]);
    let weights = b.floats("SCALAR", 1, &[0.0, 1.0]);
    let mut root = b.with_meshes(&json!([
        { "weights": [0.25], "primitives": [
            { "attributes": plain, "indices": indices, "targets": [target], "material": 0 }
        ] },
        { "primitives": [{ "attributes": skinned, "indices": indices, "material": 1 }] },
    ]));
    root["nodes"] = json!([
        { "mesh": 0, "name": "leaf", "translation": [5.0, 1.0, 0.5], "scale": [2.0, 1.5, 1.0],
          "rotation": [0.5, 0.5, 0.5, 0.5], "weights": [0.5], "children": [2] },
        { "mesh": 1, "skin": 0 },
        { "translation": [0.0, 1.0, 0.0], "children": [3] },
        { "scale": [1.5, 1.5, 1.5] },
    ]);
    root["skins"] = json!([{ "joints": [2, 3], "inverseBindMatrices": matrices }]);
    root["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        "samplers": [{ "input": times, "output": weights }],
    }]);
    root["textures"] = json!([{}]);
    let moved = json!({ "offset": [0.5, -1.0], "scale": [2.0, 3.0] });
    root["materials"] = json!([
        { "pbrMetallicRoughness": { "baseColorTexture": {
            "index": 0, "extensions": { "KHR_texture_transform": moved }
        } } },
        {},
    ]);
    root["extensionsUsed"] = json!(["KHR_texture_transform"]);
    sound(&root)
}

fn written(scene: &Scene, precision: Precision, compress: bool) -> Scene {
    let bytes = file(scene, precision, compress);
    read_bytes(&bytes, &ImportOptions::default()).expect("what was written can be read")
}

fn file(scene: &Scene, precision: Precision, compress: bool) -> Vec<u8> {
    let objects: Vec<_> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    let options = ExportOptions { precision, compress, ..ExportOptions::default() };
    let path = Path::new("out.glb");
    let files = export_with(path, ExportFormat::Glb, &scene.document, &objects, &options);
    files.expect("it can be written").remove(0).bytes
}

/// Positions of all vertices where the scene shows them, by object.
fn positions_in_scene(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    let infos: Vec<_> = scene.objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(&scene.document, &infos, &Limits::DEFAULT).expect("a sound document");
    let scenes = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let positions = |p: &lodc_scene::Placement| {
        posed(&scene.objects[p.object].mesh, p).positions.iter().map(|p| p.to_array()).collect()
    };
    scenes.placements().iter().map(positions).collect()
}

fn stream<'a>(scene: &'a Scene, object: usize, semantic: &Semantic) -> &'a Attribute {
    let mut streams = scene.objects[object].mesh.attributes().iter();
    streams.find(|a| a.semantic == *semantic && a.morph_target.is_none()).expect("the stream")
}

fn values(a: &Attribute, vertex: u32) -> Vec<f64> {
    (0..usize::from(a.components)).map(|c| a.value(vertex, c).into()).collect()
}

#[track_caller]
fn assert_close(a: &[f64], b: &[f64], limit: f64) {
    let distance = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(a.len() == b.len() && distance <= limit, "{a:?} and {b:?}: {distance} > {limit}");
}

#[test]
fn vertices_stand_where_they_stood() {
    let plain = written(&scene(), Precision::default(), false);
    let before = positions_in_scene(&plain);
    let all = || before.iter().flatten();
    let side = |k: usize| {
        let extreme = |f: fn(f64, f64) -> f64| all().map(|p| p[k]).reduce(f).expect("vertices");
        extreme(f64::max) - extreme(f64::min)
    };
    // Half a step in each direction, and half of that for the morph target of weight 0.5.
    let step = (0..3).map(side).fold(0.0, f64::max) / f64::from((1 << 12) - 2);
    for compress in [false, true] {
        // Weights of few bits move vertices, too.
        let quantised = written(&plain, Precision { weight: None, ..BITS }, compress);
        for (a, b) in before.iter().flatten().zip(positions_in_scene(&quantised).iter().flatten()) {
            assert_close(a, b, step * 0.87 * 1.5);
        }
        let document = parsed(&quantised);
        let matrices = document["skins"][0]["inverseBindMatrices"].as_u64().expect("one");
        let matrices = &document["accessors"][matrices as usize];
        assert_eq!((&matrices["type"], &matrices["min"]), (&json!("MAT4"), &Value::Null));
        for object in &quantised.objects {
            let raw = object.mesh.attributes().iter().find(|a| a.semantic == Semantic::Position);
            assert_eq!(raw.map(|a| a.component), Some(Component::U16));
        }
    }
}

#[test]
fn animated_weights_follow_their_mesh() {
    let quantised = parsed(&written(&scene(), BITS, false));
    let node = &quantised["animations"][0]["channels"][0]["target"]["node"];
    let child = &quantised["nodes"][node.as_u64().expect("a node") as usize];
    assert_eq!((&child["mesh"], &child["weights"]), (&json!(0), &json!([0.5])));
    assert_eq!(quantised["nodes"][0]["children"], json!([2, node]));
    assert!(quantised["nodes"][0].get("mesh").is_none());
    assert_eq!(quantised["nodes"][0]["name"], "leaf");
}

#[test]
fn textures_show_the_same_places() {
    let plain = written(&scene(), Precision::default(), false);
    let quantised = written(&plain, BITS, true);
    let set = Semantic::TexCoord(0);
    let (a, b) = (stream(&plain, 0, &set), stream(&quantised, 0, &set));
    assert_eq!((b.component, b.normalized), (Component::U16, false));
    let info = &parsed(&quantised)["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    let transform = &info["extensions"]["KHR_texture_transform"];
    let number = |key: &str, k: usize| transform[key][k].as_f64().expect("a number");
    let step = 7.0 * 0.31 / f64::from((1 << 11) - 1);
    for v in 0..(SIDE * SIDE) as u32 {
        let (uv, n) = (values(a, v), values(b, v));
        let before = [0.5 + 2.0 * uv[0], -1.0 + 3.0 * uv[1]];
        let after = [0, 1].map(|k| number("offset", k) + number("scale", k) * n[k]);
        assert_close(&before, &after, 0.51 * step * 13f64.sqrt());
    }
    // No texture reads the other sheet's, so nothing could scale integers back.
    let (a, b) = (stream(&plain, 1, &set), stream(&quantised, 1, &set));
    assert_eq!(b.component, Component::F32);
    for v in 0..(SIDE * SIDE) as u32 {
        assert_close(&values(a, v), &values(b, v), step * 1.01);
    }
}

#[test]
fn other_streams_keep_their_bits() {
    let plain = written(&scene(), Precision::default(), false);
    let quantised = written(&plain, BITS, true);
    for (semantic, component, limit) in [
        // Less than a third of a degree.
        (Semantic::Normal, Component::I16, 0.005),
        (Semantic::Color(0), Component::U8, 0.87 / 255.0),
        (Semantic::Weights(0), Component::U8, 2.0 / 255.0),
    ] {
        let (a, b) = (stream(&plain, 1, &semantic), stream(&quantised, 1, &semantic));
        assert_eq!((b.component, b.normalized), (component, true), "{semantic:?}");
        for v in 0..(SIDE * SIDE) as u32 {
            assert_close(&values(a, v), &values(b, v), limit);
            if semantic == Semantic::Weights(0) {
                assert_eq!(b.at(v).iter().map(|&w| u32::from(w)).sum::<u32>(), 255);
            }
        }
    }
}

#[test]
fn compression_changes_no_bit_of_what_is_quantised() {
    let [plain, compressed] = [false, true].map(|compress| written(&scene(), BITS, compress));
    for (a, b) in plain.objects.iter().zip(&compressed.objects) {
        assert_eq!(a.mesh.attributes().len(), b.mesh.attributes().len());
        for stream in a.mesh.attributes() {
            assert!(b.mesh.attributes().contains(stream), "{:?}", stream.semantic);
        }
    }
    // What is on a grid stays on it.
    let again = written(&compressed, BITS, true);
    assert_eq!(positions_in_scene(&again), positions_in_scene(&compressed));
}

#[test]
fn positions_without_a_place_for_their_transform_stay() {
    let mut b = Builder::default();
    let (indices, attributes) = sheet(&mut b);
    let moved = b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    let mesh = json!({ "primitives": [{ "attributes": attributes, "indices": indices }] });
    let with_point = json!({ "primitives": [
        { "attributes": attributes, "indices": indices },
        { "attributes": { "POSITION": attributes["POSITION"] }, "mode": 0 },
    ] });
    let mut root = b.with_meshes(&json!([mesh, mesh, with_point]));
    root["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": moved } } });
    root["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    // A skin without matrices has nothing that could hold the transform.
    root["nodes"][1]["skin"] = 0.into();
    root["skins"] = json!([{ "joints": [0] }]);
    let quantised = written(&sound(&root), BITS, false);
    assert_eq!(quantised.objects.len(), 3);
    for object in &quantised.objects {
        let raw = |a: &&Attribute| a.semantic == Semantic::Position;
        assert_eq!(object.mesh.attributes().iter().find(raw), None, "{}", object.info.name);
    }
}

#[test]
fn animations_and_skins_are_compressed_and_come_back_exactly() {
    let scene = scene();
    let [plain, packed] = [false, true].map(|c| written(&scene, Precision::default(), c));
    let moves =
        |s: &Scene| crate::animation(&s.document, 0, &Limits::DEFAULT).expect("it is there");
    assert_eq!(moves(&plain), moves(&packed));
    // The skin poses them: its matrices are the same.
    assert_eq!(positions_in_scene(&plain), positions_in_scene(&packed));
    let bytes = file(&scene, Precision::default(), true);
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("a JSON chunk");
    let sampler = &json["animations"][0]["samplers"][0];
    for accessor in
        [&sampler["input"], &sampler["output"], &json["skins"][0]["inverseBindMatrices"]]
    {
        let accessor = &json["accessors"][accessor.as_u64().expect("an accessor") as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
        assert!(view["extensions"]["EXT_meshopt_compression"].is_object(), "{accessor} {view}");
    }
    let plain = file(&scene, Precision::default(), false);
    assert!(bytes.len() < plain.len(), "{} {}", bytes.len(), plain.len());
}

#[test]
fn skinned_positions_stay_where_a_vertex_follows_no_joint() {
    let shows = |weightless: &[usize]| {
        let mut b = Builder::default();
        let (indices, plain) = sheet(&mut b);
        let count = SIDE * SIDE;
        let joints: Vec<u8> = (0..count).flat_map(|i| [(i % 2) as u8, 7, 0, 0]).collect();
        let skinned = |b: &mut Builder, without: &[usize]| {
            // Joint 7 does not exist: its weight moves nothing.
            let weights = (0..count).map(|v| match without.contains(&v) {
                true => [0.0, 1.0, 0.0, 0.0],
                false => [1.0, 0.0, 0.0, 0.0],
            });
            let weights = weights.collect::<Vec<_>>().concat();
            let mut attributes = plain.clone();
            attributes["JOINTS_0"] = b.data(5121, "VEC4", count, &joints).into();
            attributes["WEIGHTS_0"] = b.floats("VEC4", 4, &weights).into();
            json!({ "primitives": [{ "attributes": attributes, "indices": indices }] })
        };
        let meshes = [skinned(&mut b, weightless), skinned(&mut b, &[]), skinned(&mut b, &[])];
        let identity =
            [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.].map(|v: f32| v);
        let matrices = [0, 1].map(|_| b.floats("MAT4", 16, &[identity; 2].concat()));
        let mut root = b.with_meshes(&json!(meshes));
        root["nodes"] = json!([
            { "mesh": 0, "skin": 0, "translation": [3.0, 0.0, 0.0] },
            { "mesh": 1, "skin": 0 },
            { "mesh": 2, "skin": 1 },
            { "mesh": 2, "translation": [0.0, 9.0, 0.0] },
            { "mesh": 0, "translation": [0.0, 0.0, 9.0] },
            { "translation": [1.0, 0.0, 0.0] },
            {},
        ]);
        let skin = |matrices: usize| json!({ "joints": [5, 6], "inverseBindMatrices": matrices });
        root["skins"] = json!([skin(matrices[0]), skin(matrices[1])]);
        root["scenes"] = json!([{ "nodes": [0, 1, 2, 3, 4, 5, 6] }]);
        sound(&root)
    };
    let precision = Precision { position: Some(12), ..Precision::default() };
    // With one such vertex, the mesh and the one that has its matrices.
    for (weightless, stays) in [(&[][..], [false; 3]), (&[9], [true, true, false])] {
        let plain = shows(weightless);
        let quantised = written(&plain, precision, false);
        let is_on_a_grid = |o: &crate::SceneObject| {
            o.mesh.attributes().iter().any(|a| a.semantic == Semantic::Position)
        };
        let on_grids: Vec<bool> = quantised.objects.iter().map(is_on_a_grid).collect();
        assert_eq!(on_grids, stays.map(|stays| !stays));
        let [before, after] = [&plain, &quantised].map(positions_in_scene);
        for (a, b) in before.iter().flatten().zip(after.iter().flatten()) {
            assert_close(a, b, 0.01);
        }
        let objects: Vec<_> =
            plain.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
        let rounded = crate::export::rounded(&plain.document, &objects, precision);
        let rounded = rounded.expect("a sound document").expect("positions are rounded");
        assert_eq!(rounded.iter().map(|r| r.stays.is_some()).collect::<Vec<_>>(), stays);
    }
}
