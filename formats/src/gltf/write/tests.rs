//! Written documents equal those read, and are valid where nothing is left.

use crate::export::{ExportFormat, ExportObject, export};
use crate::gltf::read::tests::{Builder, exact_triangles, parsed, read_bytes, sound};
use crate::import::ImportOptions;
use crate::testing::{Scratch, corpus};
use crate::{Document, ObjDocument, ObjMaterial, ObjectInfo, OutputFile, Scene, SubmeshInfo};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic, Submesh};
use serde_json::{Value, json};
use std::path::Path;

fn written(
    document: &Document,
    objects: &[(&ObjectInfo, &Mesh)],
    format: ExportFormat,
) -> Vec<OutputFile> {
    let objects: Vec<ExportObject<'_>> =
        objects.iter().map(|&(info, mesh)| ExportObject { info, mesh }).collect();
    export(Path::new("out/a b.glb"), format, document, &objects).expect("it can be written")
}

fn glb(scene: &Scene) -> Vec<u8> {
    let objects: Vec<_> = scene.objects.iter().map(|o| (&o.info, &o.mesh)).collect();
    written(&scene.document, &objects, ExportFormat::Glb).remove(0).bytes
}

/// The mesh with only those triangles whose number passes.
fn thinned(mesh: &Mesh, keep: impl Fn(usize) -> bool) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    let old = std::mem::take(&mut parts.triangles);
    for s in &mut parts.submeshes {
        let kept: Vec<[u32; 3]> = s.triangles().filter(|&t| keep(t)).map(|t| old[t]).collect();
        *s = Submesh {
            first_triangle: parts.triangles.len() as u32,
            triangle_count: kept.len() as u32,
            attributes: s.attributes.clone(),
        };
        parts.triangles.extend(kept);
    }
    Mesh::try_from(parts).expect("fewer triangles are a mesh too")
}

/// The JSON of a GLB.
fn json_of(file: &[u8]) -> Value {
    let length = u32::from_le_bytes([file[12], file[13], file[14], file[15]]) as usize;
    serde_json::from_slice(&file[20..20 + length]).expect("a JSON chunk")
}

fn again(file: &[u8]) -> Scene {
    read_bytes(file, &ImportOptions::default()).expect("what was written can be read")
}

#[test]
fn every_model_comes_back_exactly_and_an_independent_reader_agrees() {
    let Some(folder) = corpus() else { return };
    let mut checked = 0;
    for part in ["gltf", "paper", "ugly/trimesh"] {
        for path in files_below(&folder.join(part)) {
            let Ok(scene) = crate::import::import(&path, &ImportOptions::default()) else {
                continue;
            };
            if !matches!(scene.document, Document::Gltf(_)) {
                continue;
            }
            let file = glb(&scene);
            if !scene.warnings.iter().any(|w| w.contains("through unchanged")) {
                let triangles = scene.objects.iter().map(|o| o.mesh.triangles().len()).sum();
                assert_eq!(independent_triangles(&file), Some(triangles), "{path:?}");
            }
            let back = again(&file);
            assert_eq!(back.objects.len(), scene.objects.len(), "{path:?}");
            for (a, b) in scene.objects.iter().zip(&back.objects) {
                assert!(
                    exact_triangles(&a.mesh) == exact_triangles(&b.mesh),
                    "{path:?} {}",
                    a.info.name
                );
                assert_eq!((&a.info.name, a.info.world_scale), (&b.info.name, b.info.world_scale));
            }
            // Writing what was read again changes nothing any more.
            assert!(glb(&back) == file, "{path:?}");
            checked += 1;
        }
    }
    assert!(checked > 80, "only {checked} models");
}

/// Number of triangles that the `gltf` package finds in a file, every corner of which has a
/// position.
fn independent_triangles(file: &[u8]) -> Option<usize> {
    let read = ::gltf::Gltf::from_slice_without_validation(file).ok()?;
    let blob = read.blob.as_deref();
    let mut triangles = 0;
    for primitive in read.document.meshes().flat_map(|m| m.primitives()) {
        let reader = primitive.reader(|_| blob);
        let indices: Vec<u32> = reader.read_indices()?.into_u32().collect();
        let positions = primitive.get(&::gltf::Semantic::Positions)?.count();
        if primitive.mode() != ::gltf::mesh::Mode::Triangles
            || indices.iter().any(|&i| i as usize >= positions)
        {
            return None;
        }
        triangles += indices.len() / 3;
    }
    Some(triangles)
}

fn files_below(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut out = Vec::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|e| e.path()) {
        if path.is_dir() {
            out.extend(files_below(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            out.push(path);
        }
    }
    out.sort();
    out
}

#[test]
fn indices_are_never_8_bits_and_grow_at_65535_vertices() {
    for (vertices, component) in [(3, 5123), (65_535, 5123), (65_536, 5125)] {
        let mut b = Builder::default();
        let p = b.zigzag(vertices);
        let root = b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "mode": 5 }] }]),
        );
        let remaining = json_of(&glb(&sound(&root)));
        let primitive = &remaining["meshes"][0]["primitives"][0];
        let indices =
            &remaining["accessors"][primitive["indices"].as_u64().expect("indices") as usize];
        assert_eq!(
            (&indices["componentType"], primitive.get("mode")),
            (&json!(component), None),
            "{vertices}"
        );
    }
}

#[test]
fn narrow_attributes_are_padded_and_positions_have_bounds_in_their_own_type() {
    let mut b = Builder::default();
    let p = b.data(5121, "VEC3", 3, &[0, 0, 7, 9, 0, 7, 0, 5, 7]);
    let color = b.data(5121, "VEC3", 3, &[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    b.accessors[color]["normalized"] = json!(true);
    let root = b.with_meshes(
        &json!([{ "primitives": [{ "attributes": { "COLOR_0": color, "POSITION": p } }] }]),
    );
    let file = glb(&sound(&root));
    let remaining = json_of(&file);
    for view in remaining["bufferViews"].as_array().expect("views") {
        assert_eq!(
            view["byteStride"].as_u64().unwrap_or(4) % 4
                + view["byteOffset"].as_u64().unwrap_or(0) % 4,
            0
        );
        assert!(view["target"] == json!(34962) || view.get("byteStride").is_none());
    }
    let position = remaining["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
        .as_u64()
        .expect("positions") as usize;
    assert_eq!(remaining["accessors"][position]["max"], json!([9, 5, 7]));
    assert_eq!(remaining["accessors"][position]["min"], json!([0, 0, 7]));
}

#[test]
fn primitives_and_meshes_without_triangles_leave_a_sound_scene() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let times = b.floats("SCALAR", 1, &[0.0, 1.0]);
    let primitive = json!({ "attributes": { "POSITION": p }, "targets": [{ "POSITION": p }] });
    let mut root = b.with_meshes(&json!([
        { "primitives": [primitive, primitive], "name": "two" },
        { "primitives": [primitive], "name": "one" },
        { "primitives": [primitive], "name": "last" },
    ]));
    root["nodes"] = json!([
        { "mesh": 1, "skin": 0, "weights": [1], "name": "n" }, { "mesh": 2 }, { "mesh": 0 },
    ]);
    root["skins"] = json!([{ "joints": [2] }]);
    let channel =
        |node: u32| json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
    let pointer = |pointer: &str| {
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        json!({ "sampler": 0, "target": { "path": "pointer", "extensions": extensions } })
    };
    let sampler = json!({ "input": times, "output": times });
    root["animations"] = json!([
        { "samplers": [sampler], "channels": [
            channel(0), channel(1), pointer("/meshes/2/weights"), pointer("/meshes/1/weights"),
        ] },
        { "samplers": [sampler], "channels": [channel(0)] },
    ]);
    let scene = sound(&root);
    // The first mesh loses its first primitive, the second mesh everything.
    let meshes: Vec<Mesh> =
        (0..3).map(|m| thinned(&scene.objects[m].mesh, |t| m != 1 && (m != 0 || t > 0))).collect();
    let objects: Vec<_> = scene.objects.iter().zip(&meshes).map(|(o, m)| (&o.info, m)).collect();
    let file = written(&scene.document, &objects, ExportFormat::Glb).remove(0).bytes;
    let remaining = json_of(&file);
    let names: Vec<_> =
        remaining["meshes"].as_array().expect("meshes").iter().map(|m| m["name"].clone()).collect();
    assert_eq!(names, [json!("two"), json!("last")]);
    assert_eq!(remaining["meshes"][0]["primitives"].as_array().map(Vec::len), Some(1));
    assert_eq!(remaining["nodes"], json!([{ "name": "n" }, { "mesh": 1 }, { "mesh": 0 }]));
    assert_eq!(remaining["animations"].as_array().map(Vec::len), Some(1));
    assert_eq!(
        remaining["animations"][0]["channels"],
        json!([channel(1), pointer("/meshes/1/weights")])
    );
    assert_eq!(again(&file).objects.len(), 2);
}

#[test]
fn a_gltf_names_its_bin_file_and_reads_back_from_disk() {
    let mut b = Builder::default();
    let p = b.zigzag(4);
    let scene =
        sound(&b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "mode": 5 }] }]),
        ));
    let scratch = Scratch::new("gltf-export");
    let objects = [ExportObject { info: &scene.objects[0].info, mesh: &scene.objects[0].mesh }];
    let path = scratch.path("a b ❤.gltf");
    let files =
        export(&path, ExportFormat::Gltf, &scene.document, &objects).expect("it can be written");
    assert_eq!(files.len(), 2);
    for file in &files {
        std::fs::write(&file.path, &file.bytes).expect("written");
    }
    let back = crate::import::import(&path, &ImportOptions::default()).expect("sound");
    assert!(exact_triangles(&back.objects[0].mesh) == exact_triangles(&scene.objects[0].mesh));
}

fn obj_like() -> (ObjDocument, ObjectInfo, Mesh) {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let stream = |semantic, components, bytes| Attribute {
        semantic,
        morph_target: None,
        component: Component::F32,
        components,
        normalized: false,
        bytes,
    };
    let parts = MeshParts {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        vertex_submesh: vec![0; 3],
        attributes: vec![
            stream(Semantic::TexCoord(0), 2, floats(&[0.0, 0.25, 1.0, 0.25, 0.0, 1.0])),
            stream(Semantic::Normal, 3, floats(&[0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])),
        ],
        triangles: vec![[0, 1, 2]],
        submeshes: vec![Submesh { first_triangle: 0, triangle_count: 1, attributes: vec![0, 1] }],
    };
    let lines = [
        "Kd 0.5 0.25 2",
        "d 0.5",
        "map_Kd -s 1 1 1 -blendu on tex\\my map.png",
        "nonsense",
        "Ke 0 0 0",
    ];
    let material = ObjMaterial { name: "m".to_owned(), lines: lines.map(str::to_owned).to_vec() };
    let submesh =
        SubmeshInfo { name: "g".to_owned(), material: Some("m".to_owned()), document_primitive: 0 };
    let info = ObjectInfo {
        name: "thing".to_owned(),
        submeshes: vec![submesh],
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    let document = ObjDocument { materials: vec![material], ..ObjDocument::default() };
    (document, info, Mesh::try_from(parts).expect("a triangle"))
}

#[test]
fn what_came_from_obj_gets_a_scene_materials_and_the_conventions_of_gltf() {
    let (document, info, mesh) = obj_like();
    let file =
        written(&Document::Obj(document), &[(&info, &mesh)], ExportFormat::Glb).remove(0).bytes;
    let remaining = json_of(&file);
    let pbr = &remaining["materials"][0]["pbrMetallicRoughness"];
    assert_eq!(pbr["baseColorFactor"], json!([0.214041, 0.050876, 1.0, 0.5]));
    assert_eq!(remaining["materials"][0]["alphaMode"], json!("BLEND"));
    assert_eq!(remaining["images"], json!([{ "uri": "tex/my%20map.png" }]));
    assert_eq!(
        (&remaining["asset"]["generator"], &remaining["scenes"]),
        (&json!("lodc"), &json!([{ "nodes": [0] }]))
    );
    let back = again(&file);
    let mesh = &back.objects[0].mesh;
    let values =
        |stream: usize| (0..3).map(|v| mesh.attributes()[stream].value(v, 1)).collect::<Vec<f32>>();
    assert_eq!(values(0), [0.75, 0.75, 0.0]);
    let z = (0..3).map(|v| mesh.attributes()[1].value(v, 2)).collect::<Vec<f32>>();
    assert_eq!(z, [1.0; 3]);
    assert_eq!(parsed(&back)["meshes"][0]["primitives"][0]["material"], json!(0));
}

#[test]
fn a_document_that_does_not_fit_its_objects_is_refused() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let scene =
        sound(&b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }])));
    let mut info = scene.objects[0].info.clone();
    info.document_mesh = 7;
    let objects = [ExportObject { info: &info, mesh: &scene.objects[0].mesh }];
    assert!(export(Path::new("x.glb"), ExportFormat::Glb, &scene.document, &objects).is_err());
    info.document_mesh = 0;
    info.submeshes.clear();
    let objects = [ExportObject { info: &info, mesh: &scene.objects[0].mesh }];
    assert!(export(Path::new("x.glb"), ExportFormat::Glb, &scene.document, &objects).is_err());
}
