//! Whatever ends with a block can be written in every format.

use super::*;
use crate::export::{ExportFormat, ExportObject, export};
use crate::gltf::read::tests::read_bytes;
use crate::import::ImportOptions;
use lodc_fixtures as fixtures;
use serde_json::{Value, json};
use std::path::Path;

const FORMATS: [(&str, ExportFormat); 4] = [
    ("a.glb", ExportFormat::Glb),
    ("a.gltf", ExportFormat::Gltf),
    ("a.obj", ExportFormat::Obj),
    ("a.ply", ExportFormat::Ply),
];

/// A scene of the named shapes, each shown by a node; joints are the first node.
fn scene(names: &[&str]) -> LodFile {
    let mut objects = Vec::new();
    let (mut nodes, mut meshes): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
    let mut is_skinned = false;
    for (number, name) in names.iter().enumerate() {
        let mesh = fixtures::named(name).expect("a shape");
        let targets = mesh.attributes().iter().filter_map(|a| a.morph_target).max();
        let targets = vec![json!({}); targets.map_or(0, |last| last as usize + 1)];
        let primitive = || match targets.len() {
            0 => json!({}),
            _ => json!({ "targets": targets }),
        };
        let primitives: Vec<Value> = mesh.submeshes().iter().map(|_| primitive()).collect();
        meshes.push(json!({ "name": name, "primitives": primitives }));
        let mut node = json!({ "mesh": number });
        if name.starts_with("skinned") {
            node["skin"] = 0.into();
            is_skinned = true;
        }
        nodes.push(node);
        let mut object = object(name, fixtures::random_collapse(&mesh, 1));
        object.info.document_mesh = number as u32;
        objects.push(object);
    }
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let mut root = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": roots }],
        "nodes": nodes, "meshes": meshes,
    });
    if is_skinned {
        root["skins"] = json!([{ "joints": [0, 0, 0, 0] }]);
    }
    let mut file = gltf(objects);
    file.document = Document::Gltf(GltfDocument::new(root.to_string(), Vec::new()));
    file
}

/// Writes what every block of a stream ends with in every format.
fn check_every_prefix(file: &LodFile, case: &str) {
    for block_bytes in [Some(0), None] {
        let options = PackOptions { block_bytes, ..PackOptions::default() };
        let packed = pack(file, &options).expect("a sound file");
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        let mut start = 0;
        for end in ends(&packed.bytes) {
            unpacker.feed(&packed.bytes[start..end]).expect("a sound stream");
            start = end;
            check_prefix(&unpacker, &format!("{case}, {end} of {} bytes", packed.bytes.len()));
        }
        assert!(unpacker.is_complete(), "{case}");
    }
}

fn check_prefix(unpacker: &Unpacker, case: &str) {
    let Some(arrived) = unpacker.arrived().expect("a sound document") else { return };
    let meshes: Vec<_> =
        (0..unpacker.objects()).map(|i| unpacker.mesh(i).expect("a mesh").0).collect();
    let objects: Vec<_> = (arrived.infos.iter().zip(&meshes))
        .map(|(info, mesh)| ExportObject { info, mesh })
        .collect();
    let triangles: usize = meshes.iter().map(|m| m.triangles().len()).sum();
    for (name, format) in FORMATS {
        let files = export(Path::new(name), format, &arrived.document, &objects)
            .unwrap_or_else(|e| panic!("{case} as {name}: {e}"));
        if format == ExportFormat::Glb && triangles > 0 {
            let scene = read_bytes(&files[0].bytes, &ImportOptions::default());
            let scene = scene.unwrap_or_else(|e| panic!("{case}: it cannot be read again: {e}"));
            let again: usize = scene.objects.iter().map(|o| o.mesh.triangles().len()).sum();
            assert_eq!(again, triangles, "{case}");
            let streams = |m: &lodc_mesh::Mesh| {
                m.attributes().iter().filter_map(|a| a.morph_target).collect::<Vec<_>>()
            };
            let shown = meshes.iter().filter(|m| !m.triangles().is_empty()).map(streams);
            assert!(scene.objects.iter().map(|o| streams(&o.mesh)).eq(shown), "{case}: targets");
        }
    }
}

#[test]
fn every_prefix_is_written_in_every_format() {
    let scenes: [&[&str]; 5] = [
        &["machine_part"],
        &["skinned_tube_u8"],
        &["morphing_sphere"],
        &["machine_part", "morphing_sphere", "skinned_tube_u16", "coloured_cube"],
        &["skinned_tube_u8", "morphing_sphere", "morphing_sphere"],
    ];
    for names in scenes {
        check_every_prefix(&scene(names), &names.join(", "));
    }
    let plain = object("cube", fixtures::random_collapse(&fixtures::cube(), 1));
    check_every_prefix(&obj(vec![plain]), "an OBJ");
}
